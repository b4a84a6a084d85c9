"""Find the closed linkages of a robot: joints and rods that share loops or couplings, and which of
them stand for a serial limb.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from symkin.closure.branches import Branch, edges_of
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.model.bar import Bar
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.joined import back, tree_from
from symkin.model.joint import BASE, Coordinate, Joint, interval
from symkin.model.mechanism import Mechanism
from symkin.numeric.system import components
from symkin.position.loops import independent_cycles
from symkin.text import not_among

_MOST_WAYS = 200
"""Ways from a linkage's first link that are looked at."""


@dataclass(frozen=True, eq=False)
class Group:
    """Edges of a robot (numbers of `edges_of`) that share loops or couplings, hence one motion."""

    mechanism: Mechanism
    edges: tuple[int, ...]

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The single coordinates of its joints and rods, in file order."""
        held = {c.name for edge in self.own for c in _part(edge).coordinates}
        return tuple(c for c in self.mechanism.coordinates if c.name in held and not c.is_rotation)

    @cached_property
    def own(self) -> list[Branch]:
        return [_edges(self.mechanism)[k] for k in self.edges]

    @cached_property
    def _links(self) -> set[str]:
        return {link for edge in self.own for link in edge.ends}

    @cached_property
    def actuated(self) -> tuple[Coordinate, ...]:
        return tuple(c for c in self.coordinates if c.role == "actuated")

    @cached_property
    def alone(self) -> Mechanism:
        """The linkage as a machine of its own: joints between the base and its first link are
        welded, all others left out. Limbs between a base and a platform stay as they are.
        """
        mechanism = self.mechanism
        if mechanism.limbs:
            return mechanism
        kept = {_part(edge).name for edge in self.own}
        before = {_part(_edges(mechanism)[k]).name for k in _way(mechanism, self._root)}
        names = {c.name for edge in self.own for c in _part(edge).coordinates}
        return replace(
            mechanism,
            link_joints=[
                entry if entry.joint.name in kept else _welded(entry)
                for entry in mechanism.link_joints
                if entry.joint.name in kept | before
            ],
            link_rods=[rod for rod in mechanism.link_rods if rod.name in kept | before],
            couplings=[c for c in mechanism.couplings if names >= {c.joint, *c.names}],
            link_points=(),
            link_meshes=(),
            platform_link=None,
            platform_position=(0.0, 0.0, 0.0),
            platform_quaternion=(1.0, 0.0, 0.0, 0.0),
            motion="spatial",
            example=None,
        )

    @property
    def _root(self) -> str:
        """Its link that is nearest to the base."""
        return min(sorted(self._links), key=lambda link: len(_way(self.mechanism, link)))

    def serial_ways(self, count: int) -> list[tuple[str, ...]]:
        """Ways of `count` single coordinates from the first link on, not all of motors: first those
        that end at a link that carries more of the robot, then those that pass the fewest motors,
        then in file order.
        """
        order = [c.name for c in self.coordinates]
        motors, carriers = {c.name for c in self.actuated}, self.carriers
        found: list[tuple[int, int, list[int], tuple[str, ...]]] = []
        for names, end in self._ways(count):
            passed = len(motors & set(names))
            if passed < len(names):
                places = sorted(order.index(name) for name in names)
                found.append((end not in carriers, passed, places, names))
            if len(found) == _MOST_WAYS:
                break
        return list(dict.fromkeys(names for *_, names in sorted(found)))

    @cached_property
    def carriers(self) -> list[str]:
        """Its links that carry more of the robot."""
        others = [e for k, e in enumerate(_edges(self.mechanism)) if k not in self.edges]
        beyond = {link for edge in others for link in edge.ends}
        return sorted(self._links & beyond - {self._root})

    def way_to(self, link: str, most: int) -> tuple[str, ...] | None:
        """The fewest single coordinates, up to so many, that lead from the first link to one."""
        for count in range(most + 1):
            for names, end in self._ways(count):
                if end == link:
                    return names
        return None

    def _ways(
        self, count: int, visited: tuple[str, ...] = (), names: tuple[str, ...] = ()
    ) -> Iterator[tuple[tuple[str, ...], str]]:
        """Names of `count` coordinates on ways that go on from the last link visited, and the link
        to which they lead.
        """
        visited = visited or (self._root,)
        if len(names) == count:
            yield names, visited[-1]
            return
        for edge in self.own:
            (first, last), part = edge.ends, _part(edge)
            other = last if first == visited[-1] else first
            if visited[-1] not in edge.ends or other in visited or isinstance(part, Bar):
                continue
            own = part.coordinates
            if all(not c.is_rotation for c in own) and len(names) + len(own) <= count:
                more = (*names, *(c.name for c in own))
                yield from self._ways(count, (*visited, other), more)


def groups_of(mechanism: Mechanism) -> list[Group]:
    """The groups of edges that share loops or couplings, in file order."""
    edges = _edges(mechanism)
    owner = {c.name: k for k, edge in enumerate(edges) for c in _part(edge).coordinates}
    tied = [set(cycle) for cycle in independent_cycles(mechanism)]
    tied += [{owner[n] for n in (c.joint, *c.names)} for c in mechanism.couplings]
    held = set().union(*tied)
    groups = (group for group in components(tied, len(edges)) if group <= held)
    return [Group(mechanism, tuple(sorted(group))) for group in groups]


def group_with(mechanism: Mechanism, names: Sequence[str]) -> Group:
    """The edges whose motion coordinates of these names share: of all groups that hold one."""
    groups = [g for g in groups_of(mechanism) if {c.name for c in g.coordinates} & set(names)]
    return Group(mechanism, tuple(sorted(k for group in groups for k in group.edges)))


def with_ranges(mechanism: Mechanism, ranges: Mapping[str, Sequence[float]]) -> Mechanism:
    """The mechanism with other limits, (low, high) by name in its units, of joints of one
    coordinate between links.
    """
    if not ranges:
        return mechanism
    single = {e.joint.name for e in mechanism.link_joints if e.joint.freedom == 1}
    for name in ranges:
        if name not in single:
            raise InputError(f"ranges: {not_among(name, sorted(single))}")
    return replace(
        mechanism, link_joints=[_limited(e, mechanism, ranges) for e in mechanism.link_joints]
    )


def with_twins(mechanism: Mechanism, names: Sequence[str]) -> tuple[Mechanism, dict[str, str]]:
    """The mechanism with a joint geared one to one to each coordinate of these names, and the
    twins' names by these: a map may then have the coordinate on one side and its twin on the other.
    """
    twins, taken = dict[str, str](), {c.name for c in mechanism.coordinates}
    joints, gears = list(mechanism.link_joints), list(mechanism.couplings)
    for c in mechanism.coordinates:
        if c.name not in names:
            continue
        twin = f"{c.name}_as_joint"
        while twin in taken:
            twin += "_"
        taken.add(twin)
        twins[c.name] = twin
        made = Joint(
            twin,
            "R" if c.is_angular else "P",
            next(iter(mechanism.places.values())).tolist(),
            (0.0, 0.0, 1.0),
            zero=c.reference[0],
            limits=c.limits,
        )
        joints.append(LinkJoint(made, (BASE, twin)))
        gears.append(Coupling(twin, {c.name: 1.0}))
    return replace(mechanism, link_joints=joints, couplings=gears), twins


def _limited(
    entry: LinkJoint, mechanism: Mechanism, ranges: Mapping[str, Sequence[float]]
) -> LinkJoint:
    joint = entry.joint
    if joint.name not in ranges:
        return entry
    turn = mechanism.value_in(joint.coordinates[0], 1.0)
    bounds = [turn * value for value in interval(ranges[joint.name], f"ranges: {joint.name}") or ()]
    return replace(entry, joint=replace(joint, limits=bounds))


@lru_cache(maxsize=64)
def _edges(mechanism: Mechanism) -> tuple[Branch, ...]:
    return tuple(edges_of(mechanism))


def _part(edge: Branch) -> Joint | Bar:
    return edge.elements[0].part


def _welded(entry: LinkJoint) -> LinkJoint:
    joint = entry.joint
    return replace(entry, joint=Joint(joint.name, "weld", joint.point))


@lru_cache(maxsize=64)
def _tree(mechanism: Mechanism) -> dict[str, tuple[int, str]]:
    """The edge and the link before each link, on a shortest way from the base."""
    return tree_from((edge.ends for edge in _edges(mechanism)), BASE)


def _way(mechanism: Mechanism, link: str) -> list[int]:
    """Edges from a link back to the base."""
    return [k for k, _ in back(_tree(mechanism), link)]
