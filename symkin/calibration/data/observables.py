"""Name what can be read of a mechanism beside its actuated joints and its platform's pose.

follower                     a passive joint coordinate, by an encoder
point.toe                    a named point, in the base frame
distance.toe.hip             the distance of two named points
coupler.position|orientation|inclination
                             the pose of a link other than the platform's: its displacement from the
                             reference configuration
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import casadi as ca

from symkin.closure.closure import Closure, build_closure
from symkin.closure.link_frames import link_frames
from symkin.closure.partition import Partition
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.model.graph import LinkPoint
from symkin.model.graph_checks import links_of
from symkin.model.joint import BASE, Coordinate
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import dot
from symkin.spatial.pose import Pose
from symkin.text import meant, shown

ObservableKind = Literal[
    "joint", "point", "distance", "position", "orientation", "inclination", "group"
]
Measure = Literal["length", "angle"]
ParameterKind = Literal["length", "angle", "number"]
POSE_COLUMNS: dict[ObservableKind, tuple[str, ...]] = {
    "group": ("group",),
    "inclination": ("alpha", "beta"),
    "position": ("x", "y", "z"),
    "orientation": ("qw", "qx", "qy", "qz"),
}
"""Columns of what is read of a link's pose, without the link's name."""


@dataclass(frozen=True)
class Observable:
    """What may be read: its `name`, its kind, and what it is `of` (a coordinate, points, a link;
    nothing where it is of the platform); its columns in a file and the components of its residuals;
    the `ends` of a distance between the platform and the base.
    """

    name: str
    kind: ObservableKind
    of: tuple[str, ...]
    columns: tuple[str, ...]
    components: tuple[str, ...]
    angular: bool = False
    ends: tuple[tuple[float, ...], ...] = ()

    @property
    def by_name(self) -> bool:
        """Whether its readings are held by their name, and not as a table of the platform."""
        return bool(self.of or self.ends)

    @property
    def key(self) -> str:
        """The name of its readings."""
        return self.columns[0] if self.ends else self.name

    @property
    def sigmas(self) -> tuple[str, ...]:
        """Columns of its standard deviations, without `sigma_`."""
        return (self.name,) if self.kind in ("orientation", "group") else self.columns

    @property
    def measure(self) -> Measure:
        """What its residuals and standard deviations are."""
        return "angle" if self.angular else "length"


def _of_link(kind: ObservableKind, *link: str) -> Observable:
    """What is read of the pose of a link, or of the platform."""
    name, *columns = (".".join((*link, word)) for word in (kind, *POSE_COLUMNS[kind]))
    components = {"group": POSE_COLUMNS["inclination"], "orientation": ("x", "y", "z")}
    return Observable(
        name,
        kind,
        link,
        tuple(columns),
        components.get(kind, POSE_COLUMNS[kind]),
        angular=kind != "position",
    )


PLATFORM: dict[str, Observable] = {kind: _of_link(kind) for kind in POSE_COLUMNS}
"""What is read of the platform, in the order of its columns; distances follow, then all else."""


def of_joint(c: Coordinate) -> Observable:
    """What an encoder reads of a coordinate."""
    measure: Measure = "angle" if c.is_angular else "length"
    return Observable(c.name, "joint", (c.name,), (c.name,), (measure,), angular=c.is_angular)


def distance_to_base(name: str, ends: Sequence[Sequence[float]]) -> Observable:
    """The distance between a point of the platform frame and one of the base frame, by the name of
    its column.
    """
    held = tuple(map(tuple, ends))
    return Observable("distance", "distance", (), (name,), (name,), ends=held)


@lru_cache(maxsize=64)
def observables(mechanism: Mechanism) -> dict[str, Observable]:
    """All that can be read of a mechanism by name beside actuated joints and platform, distances in
    both orders of their points.
    """
    passive = (c for c in mechanism.coordinates if c.role == "passive" and not c.is_rotation)
    found = [of_joint(c) for c in passive]
    points = [point.name for point in mechanism.link_points]
    for point in points:
        columns = tuple(f"point.{point}.{k}" for k in "xyz")
        found.append(Observable(f"point.{point}", "point", (point,), columns, tuple("xyz")))
    for pair in permutations(points, 2):
        name = f"distance.{pair[0]}.{pair[1]}"
        found.append(Observable(name, "distance", pair, (name,), ("length",)))
    found += [
        _of_link(kind, link)
        for link in links_of(mechanism)
        if link not in (BASE, mechanism.platform_link)
        for kind in ("position", "orientation", "inclination")
    ]
    return {o.name: o for o in found}


def observables_named(mechanism: Mechanism, names: Sequence[str]) -> tuple[Observable, ...]:
    """The observables of some names. Raises InputError for a name that nothing has, with the
    nearest ones.
    """
    known = observables(mechanism)
    for name in names:
        if name not in known:
            raise InputError(f"readings: {unknown_observable(mechanism, name)}")
        if names.count(name) > 1:
            raise InputError(f"readings: {name!r} stands twice")
    return tuple(known[name] for name in names)


def unknown_observable(mechanism: Mechanism, name: str, besides: Sequence[str] = ()) -> str:
    """A sentence on a name of nothing that can be read, with the nearest ones, or why it cannot be;
    `besides` are names of what else is read.
    """
    if any(c.name == name and c.is_rotation for c in mechanism.coordinates):
        return (
            f"{shown(name)} is a spherical joint, which no encoder reads; read the orientation of "
            f"its link"
        )
    known = [*besides, *(o.name for o in observables(mechanism).values())]
    allowed = [n for n in known if not n.startswith("distance.")]
    between = ["distance.A.B of two points"] if len(allowed) < len(known) else []
    listed = (
        f"; allowed: {', '.join([*allowed, *between])}"
        if known
        else ": it has no passive joints, named points or other links"
    )
    return f"nothing of {mechanism.name} is read as {shown(name)}{meant(name, known)}{listed}"


def measure_of(mechanism: Mechanism, kind: str) -> Measure:
    """Say whether readings of a kind, of the platform or by the name of an observable, are lengths
    or angles.
    """
    found = PLATFORM.get(kind) or observables(mechanism).get(kind)
    return "length" if found is None else found.measure


def unit_of(mechanism: Mechanism, kind: ParameterKind) -> str:
    """The unit in which lengths and angles are written; none for numbers."""
    m = mechanism
    return {"length": m.length_unit, "angle": m.angle_unit, "number": ""}[kind]


def value_out(mechanism: Mechanism, kind: ParameterKind, value: float) -> float:
    """A length, angle or number in the mechanism's unit."""
    return mechanism.angle_out(value) if kind == "angle" else value


def written(mechanism: Mechanism, kind: ParameterKind, value: float, digits: str = "+.3g") -> str:
    """Write a length, angle or number with its unit."""
    return f"{value_out(mechanism, kind, value):{digits}} {unit_of(mechanism, kind)}".strip()


def observing_closure(mechanism: Mechanism, names: Sequence[str]) -> Closure:
    """The closure that holds the joints that are read, and the platform of limbs."""
    joints = frozenset(o.of[0] for o in observables_named(mechanism, names) if o.kind == "joint")
    return build_closure(mechanism, Partition(joints, pose=bool(joints) and not mechanism.is_graph))


def judged_link(mechanism: Mechanism) -> str:
    """The link by whose poses a geometry is judged: the platform's; of a mechanism without one that
    of the first named point, else one that no joint or rod holds to the base, else the last.
    """
    if mechanism.platform_link is not None:
        return mechanism.platform_link
    pointed = [point.link for point in mechanism.link_points if point.link != BASE]
    pairs = [
        tuple(e.links) for e in (*mechanism.link_joints, *mechanism.link_rods, *mechanism.limbs)
    ]
    held = {link for pair in pairs if BASE in pair for link in pair}
    placed = link_frames(build_closure(mechanism)).placed  # not those that may turn idly
    inner = [link for link in links_of(mechanism) if link not in held and link in placed]
    return [*pointed, *inner, *(link for link in reversed(links_of(mechanism)) if link in placed)][
        0
    ]


# --- expressions ----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Observed:
    """What is read, as expressions of the variables of a `closure` and the `geometry` (symbol and
    nominal value by key path): `values` by name (a joint's coordinate, a distance; else a point
    (3), or a link's pose (7)), `pose` (7) that of the judged link, or of its platform frame.
    """

    closure: Closure
    values: dict[str, ca.SX]
    pose: ca.SX
    geometry: dict[str, tuple[ca.SX, float]]


@lru_cache(maxsize=64)
def observed(mechanism: Mechanism, names: tuple[str, ...]) -> Observed:
    """The expressions of some observables over the closure that holds their joints. Raises
    InputError for links that may turn idly, and for joints that may.
    """
    closure = observing_closure(mechanism, names)
    wanted, pose = observables_named(mechanism, names), None
    if mechanism.platform_link is not None:
        pose = ca.vertcat(closure.pose.position, closure.pose.quaternion)
        if not wanted:
            return Observed(closure, {}, pose, {})
    links = link_frames(closure)
    poses = {link: links.frames[link] for link in links.placed}
    places, geometry, values = dict[str, ca.SX](), dict(links.geometry), dict[str, ca.SX]()
    for point in mechanism.link_points:
        symbols = [ca.SX.sym(f"{point_path(point)}.{k}") for k in "xyz"]
        geometry |= {str(s): (s, float(v)) for s, v in zip(symbols, point.point, strict=True)}
        frame = poses[point.link]
        places[point.name] = Pose(frame[:3], frame[3:]).apply(ca.vertcat(*symbols))
    for o in wanted:
        match o.kind:
            case "joint":
                if o.name not in closure.slices:
                    raise InputError(
                        f"readings: {o.name!r} turns idly between spherical joints: nothing is "
                        f"told by reading it"
                    )
                values[o.name] = closure.variables[closure.slices[o.name]]
            case "point":
                values[o.name] = places[o.of[0]]
            case "distance":
                gap = places[o.of[0]] - places[o.of[1]]
                values[o.name] = ca.sqrt(dot(gap, gap))
            case _:
                if o.of[0] not in poses:
                    raise InputError(
                        f"readings: link {o.of[0]!r} turns idly between its spherical joints; read "
                        f"one of its points"
                    )
                values[o.name] = poses[o.of[0]]
    pose = poses[judged_link(mechanism)] if pose is None else pose
    return Observed(closure, values, pose, geometry)


def point_path(point: LinkPoint) -> str:
    """The key path of a named point."""
    return f"{point.link}.points.{point.name}"
