"""Marks on links: what is drawn of a mechanism, however it was written. NumPy only, base frame,
length unit.

Every link's frame is the base frame at the reference configuration, as in `closure/link_poses.py`:
a link's pose is its displacement from there. So all marks are laid out once, at the reference, and
each link's pose moves its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from symkin.closure.branches import Branch, edges_of
from symkin.computed_once import lru_cache
from symkin.drawing.bodies import Body, body_of
from symkin.drawing.outline import grouped
from symkin.drawing.palette import LINK_COLOURS
from symkin.drawing.slides import joint_places, slide_routes
from symkin.model.bar import Bar
from symkin.model.graph_checks import links_of
from symkin.model.joined import Joined
from symkin.model.joint import BASE, PLATFORM, Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose

_SAME = 1e-6
"""Distance over the size below which two points are one, and sine below which two directions
are.
"""
_HAND, _MANY = 0.16, 12
"""Length over the size of the hand that shows how a link of one joint is turned, and how many links
a mechanism has whose hands are shorter.
"""
JOINT_NAMES: dict[JointType, str] = {
    "R": "revolute",
    "P": "prismatic",
    "C": "cylindrical",
    "H": "helical",
    "U": "universal",
    "S": "spherical",
    "weld": "weld",
}
ORIGIN, HAND, _HUB = "(frame)", "(hand)", "(hub)"
"""Owners of points that belong to no joint: origins of frames, hands, the middle of the rods' ends.
"""


@dataclass(frozen=True, eq=False)
class JointMark:
    """A joint between two `links` by name: its places (3,) on both, which a slide parts, and its
    axes (3,). One that floats has no place of its own.
    """

    joint: Joint
    links: tuple[str, str]
    start: np.ndarray
    end: np.ndarray
    axes: tuple[np.ndarray, ...]
    floats: bool

    @property
    def name(self) -> str:
        return self.joint.name

    @property
    def type(self) -> JointType:
        return self.joint.type

    @property
    def actuated(self) -> bool:
        return self.joint.actuated

    @property
    def centre(self) -> np.ndarray:
        """Where its symbol stands: a slide's halfway between its two links."""
        return 0.5 * (self.start + self.end) if self.type == "P" else self.end


@dataclass(frozen=True, eq=False)
class RodMark:
    """A rod between its two ends (3,) on two `links`, and the joints there; `label` is its name
    where it is written.
    """

    name: str
    label: str
    bar: Bar
    links: tuple[str, str]
    start: np.ndarray
    end: np.ndarray
    kinds: tuple[JointType, JointType]

    @property
    def actuated(self) -> bool:
        return self.bar.coordinate is not None

    @property
    def centre(self) -> np.ndarray:
        return np.asarray(0.5 * (self.start + self.end))


Mark = JointMark | RodMark


@dataclass(frozen=True, eq=False)
class LinkMark:
    """A link through `points` (k, 3), each of the joint or rod that is its owner; `edges` are pairs
    of their indices where they are joined in a certain way, None where an outline joins them.
    `label` is its name where it is written: links within limbs have none.
    """

    points: np.ndarray
    owners: tuple[str, ...]
    role: Literal["base", "platform", "link"]
    label: str
    colour: str
    edges: tuple[tuple[int, int], ...] | None = None

    def body(self, size: float) -> Body:
        """Its shape."""
        if self.edges is None:
            return body_of(self.points, size)
        return Body(self.points, list(self.edges), [])

    def of(self, owner: str) -> np.ndarray:
        """The points of an owner (n, 3)."""
        return self.points[[name == owner for name in self.owners]]


@dataclass(frozen=True, eq=False)
class Layout:
    """All marks at one configuration: links by name, joints, rods, named points with their links,
    coupled joints by name, joints between links that close loops, the first joints of limbs by the
    limbs' names, and the pose of the frame, None where there is none.
    """

    mechanism: Mechanism
    links: dict[str, LinkMark]
    joints: tuple[JointMark, ...]
    rods: tuple[RodMark, ...]
    points: dict[str, tuple[str, np.ndarray]]
    couplings: tuple[tuple[str, str], ...]
    closing: frozenset[str]
    limbs: Mapping[str, str]
    pose: Pose | None

    @property
    def size(self) -> float:
        return self.mechanism.characteristic_length

    @property
    def marks(self) -> dict[str, Mark]:
        """Joints and rods by name."""
        return {mark.name: mark for mark in self.joints} | {rod.name: rod for rod in self.rods}

    @property
    def all_points(self) -> np.ndarray:
        """Every point drawn, (k, 3)."""
        found = [point for mark in self.links.values() for point in mark.points]
        found += [joint.centre for joint in self.joints]
        return np.array(found or [np.zeros(3)])

    def at(self, poses: Mapping[str, Pose]) -> Layout:
        """The marks of the reference, moved by displacements of the links."""
        joints = tuple(_moved_joint(mark, poses) for mark in self.joints)
        rods = tuple(
            replace(
                rod,
                start=poses[rod.links[0]].apply(rod.start),
                end=poses[rod.links[1]].apply(rod.end),
            )
            for rod in self.rods
        )
        floating = {mark.name: mark.centre for mark in joints if mark.floats}
        links = {
            link: replace(mark, points=_moved_points(mark, poses[link], floating))
            for link, mark in self.links.items()
        }
        points = {name: (link, poses[link].apply(p)) for name, (link, p) in self.points.items()}
        platform = self.mechanism.platform_link
        pose = None if platform is None else poses[platform] @ self.mechanism.reference_pose
        return replace(self, links=links, joints=joints, rods=rods, points=points, pose=pose)

    def spread(self, step: float) -> Layout:
        """Joints that share a point stand `step` and more from it along their own axes, and links
        go through them there.
        """
        away = _offsets(self, step)
        if not away:
            return self
        joints = tuple(
            replace(mark, start=mark.start + away[mark.name], end=mark.end + away[mark.name])
            if mark.name in away
            else mark
            for mark in self.joints
        )
        links = {
            link: replace(
                mark,
                points=np.array(
                    [
                        p + away.get(owner, 0.0)
                        for owner, p in zip(mark.owners, mark.points, strict=True)
                    ]
                ),
            )
            for link, mark in self.links.items()
        }
        return replace(self, joints=joints, links=links)


@lru_cache(maxsize=16)
def layout_of(mechanism: Mechanism) -> Layout:
    """The marks at the reference configuration."""
    return _Gathered(mechanism).layout()


def _moved_joint(mark: JointMark, poses: Mapping[str, Pose]) -> JointMark:
    before, after = (poses[link] for link in mark.links)
    start, end = before.apply(mark.start), after.apply(mark.end)
    if mark.floats:
        held = [place for link, place in zip(mark.links, (start, end), strict=True) if link != BASE]
        start = end = np.asarray(np.mean(held, axis=0))
    turned = [pose.turn(axis) for pose, axis in zip((before, after), mark.axes, strict=False)]
    return replace(mark, start=start, end=end, axes=tuple(turned))


def _moved_points(mark: LinkMark, pose: Pose, floating: Mapping[str, np.ndarray]) -> np.ndarray:
    moved = [
        floating.get(owner, pose.apply(p))
        for owner, p in zip(mark.owners, mark.points, strict=True)
    ]
    return np.array(moved).reshape(-1, 3)


# --- joints that share a point --------------------------------------------------------------------


def _offsets(layout: Layout, step: float) -> dict[str, np.ndarray]:
    """How far joints stand from the point that they share with ones before them."""
    near, found = _SAME * layout.size, dict[str, np.ndarray]()
    marks = (
        (mark, mark.centre)
        for mark in layout.joints
        if mark.type != "P" or np.linalg.norm(mark.end - mark.start) <= near
    )
    for group, _ in grouped(marks, near):
        taken: list[np.ndarray] = []
        for mark in group[1:]:
            axis = _outward(layout, mark, near)
            along = 1 + sum(1 for other in taken if np.linalg.norm(other - axis) < _SAME)
            taken.append(axis)
            found[mark.name] = along * step * axis
    return found


def _outward(layout: Layout, mark: JointMark, near: float) -> np.ndarray:
    """Along a joint's axis, towards what else its second link holds."""
    axis = mark.axes[0] if mark.axes else np.array([0.0, 0.0, 1.0])
    points = layout.links[mark.links[1]].points
    beyond = [point - mark.centre for point in points if np.linalg.norm(point - mark.centre) > near]
    return -axis if beyond and np.mean(beyond, axis=0) @ axis < -near else axis


# --- the reference --------------------------------------------------------------------------------


class _Gathered:
    """Gathers the marks of a mechanism, edge by edge."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.size = mechanism, mechanism.characteristic_length
        self.edges = list(edges_of(mechanism))
        joined = Joined[str]()
        self.last = [edge for edge in self.edges if not joined.join(*edge.ends)]
        """Edges between links that those before them in the file join already."""
        self.places = joint_places(mechanism, loops=bool(self.last))
        self.routes = {
            name: route
            for limb in mechanism.limbs
            for name, route in slide_routes(mechanism, limb, self.places).items()
        }
        self.points: dict[str, list[tuple[str, np.ndarray]]] = {}
        self.joints: list[JointMark] = []
        self.rods: list[RodMark] = []
        self.colours: dict[str, str] = {}
        """Of links that are neither base nor platform: one for all links of a limb."""

    def layout(self) -> Layout:
        mechanism, platform = self.mechanism, self.mechanism.platform_link
        if sum(BASE in edge.ends for edge in self.edges) == 1:
            self._attach(BASE, ORIGIN, np.zeros(3))
        floating = [edge for edge in self.edges if self._floats(edge)]
        for edge in self.edges:
            if isinstance(edge.elements[0].part, Bar):
                self._rod(edge, edge.elements[0].part)
            elif edge not in floating:
                self._joint(edge, *self._places(edge.elements[0].name))
        named = {p.name: (p.link, np.array(p.point)) for p in mechanism.link_points}
        for name, (link, point) in named.items():
            if link != BASE:
                self._attach(link, name, point)
        for edge in floating:
            self._joint(edge, *[self._beside(edge)] * 2, floats=True)
        if platform is not None:
            self._origin(platform, np.asarray(mechanism.reference_pose.position))
        self._hands()
        links, limbs = (*links_of(mechanism), *self.points), mechanism.limbs
        order = {joint.elements[0].name: k for k, joint in enumerate(self.edges)}
        return Layout(
            mechanism,
            {link: self._link(link) for link in dict.fromkeys(links) if link in self.points},
            tuple(sorted(self.joints, key=lambda mark: order[mark.name])),
            tuple(self.rods),
            named,
            self._couplings(),
            frozenset(e.name for e in self.last if e.name == e.elements[0].name in self.places),
            {} if mechanism.serial else {li.name: li.joints[0].name for li in limbs if li.joints},
            None if platform is None else mechanism.reference_pose,
        )

    def _attach(self, link: str, owner: str, point: np.ndarray) -> None:
        self.points.setdefault(link, []).append((owner, point))

    # --- joints and rods --------------------------------------------------------------------------

    def _floats(self, edge: Branch) -> bool:
        """A P joint or a weld whose point, which holds nothing, the file may have left out."""
        part = edge.elements[0].part
        return (
            isinstance(part, Joint)
            and not part.form.has_point
            and not any(part.point)
            and part.name not in self.routes
        )

    def _places(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        return self.routes.get(name, (self.places[name], self.places[name]))

    def _beside(self, edge: Branch) -> np.ndarray:
        """A slide or weld without a place of its own stands halfway between the other joints of the
        links that move.
        """
        middles = [
            np.mean([point for _, point in self.points[link]], axis=0)
            for link in edge.ends
            if link != BASE and self.points.get(link)
        ]
        return (
            np.asarray(np.mean(middles, axis=0)) if middles else self.places[edge.elements[0].name]
        )

    def _joint(
        self, edge: Branch, start: np.ndarray, end: np.ndarray, *, floats: bool = False
    ) -> None:
        joint = edge.elements[0].part
        assert isinstance(joint, Joint)  # noqa: S101 - the caller has asked
        axes = tuple(np.array(axis) for axis in (joint.axis, joint.axis2) if axis is not None)
        for link, place in zip(edge.ends, (start, end), strict=True):
            self._attach(link, joint.name, place)
        self.joints.append(JointMark(joint, edge.ends, start, end, axes, floats))

    def _rod(self, edge: Branch, bar: Bar) -> None:
        start, end = bar.places
        kinds = next((limb.type for limb in self.mechanism.limbs if limb.name == bar.name), "SS")
        own = bar.name == edge.name
        name = bar.name if own else f"{edge.name} {bar.name}"
        for link, point in zip(edge.ends, (start, end), strict=True):
            self._attach(link, name, point)
        label = name if own else ""
        self.rods.append(RodMark(name, label, bar, edge.ends, start, end, (kinds[0], kinds[-1])))  # type: ignore[arg-type]

    def _couplings(self) -> tuple[tuple[str, str], ...]:
        names = {mark.name for mark in self.joints} | {rod.name for rod in self.rods}
        found = []
        for coupling in self.mechanism.couplings:
            first, *others = (
                # `u.1` is a coordinate of `u`
                name if name in names else name.rsplit(".", 1)[0]
                for name in (coupling.joint, *coupling.names)
            )
            found += [(first, other) for other in others]
        return tuple(found)

    # --- links ------------------------------------------------------------------------------------

    def _origin(self, link: str, origin: np.ndarray) -> None:
        held = [point for _, point in self.points.get(link, [])]
        if all(np.linalg.norm(origin - point) > _SAME * self.size for point in held):
            self._attach(link, ORIGIN, origin)

    def _link(self, link: str) -> LinkMark:
        """A link of a limb goes from its joint to the middle of its rods' ends, and from there to
        each; others are outlines.
        """
        owners, points = zip(*self.points[link], strict=True)
        named, names = link in links_of(self.mechanism), {rod.name for rod in self.rods}
        kind = link if named else link.rsplit(".", 1)[0]
        turn = LINK_COLOURS[len(self.colours) % len(LINK_COLOURS)]
        if link == BASE:
            mark = LinkMark(np.array(points), owners, "base", link, "base edge")
        elif link == self.mechanism.platform_link:
            mark = LinkMark(np.array(points), owners, "platform", link, "platform")
        else:
            colour = self.colours.setdefault(kind, turn)
            mark = LinkMark(np.array(points), owners, "link", link if named else "", colour)
        rods = [k for k, owner in enumerate(owners) if owner in names]
        if named or len(rods) < 2:
            return mark
        hub = np.mean(mark.points[rods], axis=0)
        edges = ((0, len(points)), *((len(points), k) for k in rods))
        return replace(mark, points=np.array([*points, hub]), owners=(*owners, _HUB), edges=edges)

    def _hands(self) -> None:
        """A link with one point gets a second one, which turns with it; of a platform that the file
        does not name, the frame does that.
        """
        taken = list[np.ndarray]()
        hand = _HAND * self.size * min(1.0, np.sqrt(_MANY / len(self.points)))
        for edge in self.edges:
            axis = np.array(getattr(edge.elements[0].part, "axis", None) or (0.0, 0.0, 1.0))
            first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
            across = _unit(0.5 * _unit(first) + _unit(np.cross(axis, first)))
            for link in edge.ends:
                if link in (BASE, PLATFORM) or len(self.points[link]) != 1:
                    continue
                ((_, place),) = self.points[link]
                # hands at one place point in different directions
                turn = sum(np.linalg.norm(place - other) < _SAME * self.size for other in taken)
                taken.append(place)
                way = np.cos(turn) * across + np.sin(turn) * np.cross(_unit(axis), across)
                self._attach(link, HAND, place + hand * way)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)
