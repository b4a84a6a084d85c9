"""Describe a mechanism: its layout, never its state. Frozen, hashable, printable."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import InputError, MechanismError
from symkin.model.description import Description, Example
from symkin.model.dh import DHTable, reference_frames
from symkin.model.graph_checks import check_graph, links_of
from symkin.model.joint import PLATFORM, POSE_CONDITIONS, Joint, finite, vector3
from symkin.model.keys import ANGLE_UNITS, LENGTH_UNITS
from symkin.model.keys import MOTIONS as MOTIONS
from symkin.model.keys import Motion as Motion
from symkin.model.limb import Limb, coincide
from symkin.model.names import check_mechanism_name, check_name, check_text
from symkin.model.placement import placed_points
from symkin.spatial.pose import NORM_OFF
from symkin.text import meant, not_among

_MUCH_LARGER = 3.0
"""Points along nearly parallel axes are moved where the described ones spread more than this many
times as far.
"""
_ROUNDING = 1e-9
"""Placed points that are nearer to each other than this share of the described ones are one point
to rounding.
"""
_ONE_POINT = 1e-13
"""Points that are nearer to each other than this share of their coordinates are one point: some
rounding errors of a point that was turned or computed.
"""
MOST_PARTS = 1000
"""Limbs, joints and rods of a mechanism at most: accounts of more would take hours."""


@dataclass(frozen=True)
class Mechanism(Description):
    """Limbs between a base and a platform, a serial arm, or a graph of links.

    A serial arm (`serial`) is one limb, all of its joints actuated, its platform the tool. A graph
    has joints (`link_joints`), rods (`link_rods`) and limbs between any two links, and `couplings`
    of joints. Limbs stand at the reference configuration, where the platform frame is at
    `platform_position` (3, length unit) and `platform_quaternion` (w, x, y, z) of the base frame.
    `motion` ("spatial", "schoenflies", "planar", "translation", "spherical") restricts the
    platform's pose to a group of the base frame's axes from there. `platform_link` names the link
    that carries the platform frame, None where a graph has no such link; `link_points` are named
    points of links, `link_meshes` files that show them, which a robot's file names and a mechanism
    file does not. Angles in joints are radians; `angle_unit` is what users read and write at the
    border. The closure of the limbs is F(q, x, X, p) = 0: actuated joints q, passive joints x, pose
    X, geometry p. Raises MechanismError for a description that cannot be right, with what is
    allowed.

    >>> import symkin
    >>> feet = [(-300, -100), (300, 100)]
    >>> legs = [symkin.RodLimb(f"leg{k}", [x, 0, 0], [u, 0, 0]) for k, (x, u) in enumerate(feet)]
    >>> bench = symkin.Mechanism("bench", legs, platform_position=[0, 0, 400])
    >>> [c.name for c in bench.actuated], round(bench.characteristic_length, 3)
    (['leg0', 'leg1'], 600.0)
    """

    def __post_init__(self) -> None:
        for key in ("limbs", "link_joints", "link_rods", "couplings", "link_points", "link_meshes"):
            object.__setattr__(self, key, tuple(getattr(self, key)))
        object.__setattr__(
            self,
            "platform_position",
            vector3(self.platform_position, f"{self.frame_name}.position"),
        )
        object.__setattr__(
            self,
            "platform_quaternion",
            unit_quaternion(self.platform_quaternion, f"{self.frame_name}.quaternion"),
        )
        if self.platform_link in (None, PLATFORM):
            # the link of that name carries the platform frame where no other does
            object.__setattr__(
                self, "platform_link", PLATFORM if PLATFORM in links_of(self) else None
            )
        _check_size(self)
        _check_names(self)
        for key in ("title", "source"):
            object.__setattr__(self, key, check_text(getattr(self, key), key))
        _check_choice("motion", self.motion, MOTIONS)
        _check_choice("length_unit", self.length_unit, LENGTH_UNITS)
        _check_choice("angle_unit", self.angle_unit, ANGLE_UNITS)
        if not (self.limbs or self.link_joints or self.link_rods):
            raise MechanismError("the mechanism has no limb; give [[limb]], [dh] or [[joint]]")
        _check_rods(self)
        check_graph(self)
        if self.serial:
            _check_serial(self)
        if self.example is not None:
            _check_example(self, self.example)

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(tuple(getattr(self, f.name) for f in fields(self) if f.compare))

    def __getstate__(self) -> dict[str, object]:
        """What is pickled: another process has other hashes of texts."""
        return {name: value for name, value in vars(self).items() if name != "_hash"}

    @cached_property
    def places(self) -> dict[str, np.ndarray]:
        """A point of each joint at the reference: the one described; or, where that makes the
        mechanism much larger than it is, one of its axis that is near the limb's other points (see
        `placement`).
        """
        described = {joint.name: np.array(joint.point) for joint in self.all_joints}
        origin, placed = np.array(self.platform_position), dict(described)
        for limb in self.limbs:
            starts = [bar.start.point for bar in limb.bars(self.reference_pose)]
            placed |= placed_points(limb.joints, np.mean(starts, axis=0) if starts else origin)
        spread, much = self._spread(placed), self._spread(described)
        # points placed by least squares may coincide to rounding where the described ones do not:
        # then the described ones stay
        return placed if _ROUNDING * much < spread and _MUCH_LARGER * spread < much else described

    @cached_property
    def characteristic_length(self) -> float:
        """The largest distance between the joints' `places`, centres and rod ends at the reference,
        by which angles become lengths; where all of them coincide, that to the platform origin, or
        1.
        """
        return self._spread(self.places) or 1.0

    @cached_property
    def farthest(self) -> float:
        """The largest coordinate of a point of the description at the reference: numbers as large
        as this are added and cancel.
        """
        joints = (joint.point for joint in self.all_joints)
        points = [*joints, *self.rod_ends, self.platform_position]
        return float(np.max(np.abs(np.array(points))))

    def _spread(self, places: Mapping[str, np.ndarray]) -> float:
        """The largest distance between points of joints and rod ends."""
        points = [*places.values(), *self.rod_ends]
        spread = _diameter(points)
        return spread or _diameter([*points, np.array(self.platform_position)])

    def to_toml(self) -> str:
        """The mechanism file (format 1) that describes this mechanism."""
        return self._written

    @cached_property
    def _written(self) -> str:
        # tomlkit takes a while to import, and few runs write
        from symkin.model.writer import mechanism_to_toml

        return mechanism_to_toml(self)

    @property
    def digest(self) -> str:
        """SHA-256 of the mechanism file: the same for two mechanisms only where nothing differs."""
        return hashlib.sha256(self.to_toml().encode()).hexdigest()

    def __str__(self) -> str:
        if self.is_graph:
            return (
                f"{self.name}: {len(links_of(self))} links, {len(list(self.all_joints))} joints, "
                f"{len(self.link_rods)} rods; lengths in "
                f"{self.length_unit}, angles in {self.angle_unit}"
            )
        kind = "serial arm" if self.serial else f"parallel mechanism, platform {self.motion}"
        limbs = ", ".join(f"{limb.name}: {limb.type}" for limb in self.limbs)
        return (
            f"{self.name}: {kind} ({limbs}); lengths in {self.length_unit}, angles in "
            f"{self.angle_unit}"
        )


def serial_arm_from_dh(name: str, table: DHTable, **options: object) -> Mechanism:
    """Make a serial arm from a DH table: its joints at zero joint values, with the table as its
    parameters.

    `options` are those of `Mechanism`: title, source, length_unit, angle_unit, example. Raises
    MechanismError for a table or options that cannot be. Source: Denavit and Hartenberg, Journal of
    Applied Mechanics 22, 1955.

    >>> import symkin
    >>> rows = [symkin.DHRow("q1", a=120.0), symkin.DHRow("q2", a=80.0)]
    >>> table = symkin.DHTable("standard", rows)
    >>> arm = symkin.serial_arm_from_dh("two_links", table, angle_unit="deg")
    >>> symkin.solve(arm, joints=[0.0, 90.0]).solution.position.round(6).tolist()
    [120.0, 80.0, 0.0]
    """
    frames, tool = reference_frames(
        table.convention, [(r.theta, r.d, r.a, r.alpha) for r in table.rows]
    )
    joints = [
        Joint(
            row.name,
            row.type,
            point=tuple(point),
            axis=tuple(axis),
            actuated=True,
            limits=row.limits,
        )
        for row, (point, axis) in zip(table.rows, frames, strict=True)
    ]
    return Mechanism(
        name,
        [Limb(name, joints)],
        platform_position=tuple(tool.position),
        platform_quaternion=tuple(tool.quaternion),
        serial=True,
        dh=table,
        **options,  # type: ignore[arg-type]
    )


def unit_quaternion(value: Sequence[float], where: str) -> tuple[float, ...]:
    """Normalise a quaternion; refused when its norm is off by more than 1e-2."""
    q = tuple(finite(component, where) for component in value)
    if len(q) != 4:
        raise MechanismError(
            f"{where} = {list(q)} has {len(q)} numbers; four are needed (w, x, y, z)"
        )
    length = math.hypot(*q)
    # beyond a slip of digits, numbers in another order or of another kind have been given
    if abs(length - 1.0) > NORM_OFF:
        raise MechanismError(
            f"{where} = {list(q)} has norm {length:.6g}; a unit quaternion is needed (1 to within "
            f"0.01)"
        )
    return q if abs(length - 1.0) <= 4e-16 else tuple(component / length for component in q)


def _diameter(points: list[np.ndarray]) -> float:
    """Largest distance of two points: of those that are so far apart to rounding the largest, pair
    by pair; 0 where all are one point to rounding.
    """
    if len(points) < 2:
        return 0.0
    places = np.array(points)
    rows = [
        np.sqrt(np.sum((places[k + 1 :] - places[k]) ** 2, axis=1)) for k in range(len(places) - 1)
    ]
    least = (1.0 - _ROUNDING) * max(float(row.max()) for row in rows)
    pairs = (
        (k, k + 1 + int(i)) for k, row in enumerate(rows) for i in np.flatnonzero(row >= least)
    )
    largest = max(float(np.linalg.norm(points[i] - points[j])) for i, j in pairs)
    return largest if largest > _ONE_POINT * float(np.max(np.abs(places))) else 0.0


def _check_size(mechanism: Mechanism) -> None:
    """Refuse more parts than any computation here ends with."""
    parts = {
        "limbs": len(mechanism.limbs),
        "joints": len(list(mechanism.all_joints)),
        "rods": len(mechanism.link_rods),
    }
    if sum(parts.values()) > MOST_PARTS:
        told = ", ".join(f"{count} {what}" for what, count in parts.items() if count)
        raise MechanismError(
            f"the mechanism has {told}; allowed: {MOST_PARTS} limbs, joints and rods together"
        )


def _check_choice(key: str, value: str, allowed: Sequence[str]) -> None:
    if value not in allowed:
        raise MechanismError(f"{key} = {not_among(value, allowed)}")


def _check_names(mechanism: Mechanism) -> None:
    check_mechanism_name(mechanism.name)
    limb_names = [limb.name for limb in mechanism.limbs]
    drives = [bar.name for bar in mechanism.bars if bar.coordinate is not None]
    coordinate_names = drives + [joint.name for joint in mechanism.all_joints]
    coordinate_names += [rod.name for rod in mechanism.link_rods if not rod.actuated]
    for what, names in (("limb", limb_names), ("joint", coordinate_names)):
        for name in names:
            check_name(name, f"{what}: name")
    made = [c.name for joint in mechanism.all_joints for c in joint.coordinates]
    made += drives
    for name in made:
        if name.startswith("pose."):
            raise MechanismError(
                f"joint {name!r}: names that begin with 'pose.' are the platform's own"
            )
    for name in made:
        if made.count(name) > 1 and coordinate_names.count(name) < 2:
            raise MechanismError(
                f"the coordinate {name!r} belongs to two joints; C and U joints make names such as "
                f"'u.1'"
            )
    for what, names in (("limbs", limb_names), ("joints or rods", coordinate_names)):
        for name in names:
            if names.count(name) > 1:
                raise MechanismError(
                    f"two {what} are named {name!r}; names must be unique in the file"
                )


def _check_rods(mechanism: Mechanism) -> None:
    for limb in mechanism.limbs:
        for k, bar in enumerate(limb.bars(mechanism.reference_pose), start=1):
            start, end = (place.tolist() for place in bar.places)
            if bar.length is None and bar.coordinate is None and coincide(start, end):
                raise MechanismError(
                    f"limb {limb.name!r}: the ends of rod {k} lie at one point at the reference; a "
                    f"rod has a length"
                )


def _check_example(mechanism: Mechanism, example: Example) -> None:
    """The example must be input that `solve` takes."""
    starts_with_pose = example.joints is not None
    if example.joints is not None:
        _check_joints("example.joints", mechanism, example.joints)
    if example.pose is not None:
        unit_quaternion(example.pose[3:], "example.pose: the quaternion")
    if example.given is not None:
        allowed = (
            *(c.name for c in mechanism.coordinates if not c.is_rotation),
            *POSE_CONDITIONS,
        )
        for name, _ in example.given:
            if name not in allowed:
                raise MechanismError(
                    f"example.given.{name}: no coordinate has this name{meant(name, allowed)}; "
                    f"allowed: {', '.join(allowed)}"
                )
    if example.start is None:
        return
    if not starts_with_pose:
        _check_joints("example.start", mechanism, example.start)
        return
    if len(example.start) != 7:
        raise MechanismError(
            f"example.start: {len(example.start)} values given, 7 are needed: x, y, z, qw, qx, qy, "
            f"qz"
        )
    unit_quaternion(example.start[3:], "example.start: the quaternion")


def _check_joints(where: str, mechanism: Mechanism, values: Sequence[float]) -> None:
    if len(values) != len(mechanism.actuated):
        raise MechanismError(
            f"{where}: {len(values)} values given, the mechanism has {len(mechanism.actuated)} "
            f"actuated joints"
        )
    for c, value in zip(mechanism.actuated, values, strict=True):
        if c.least is not None and value < c.least:
            raise MechanismError(
                f"{where}: {c.name} = {value:g} makes a rod of negative length; allowed: "
                f"{c.least + 0.0:g} and above"
            )


def _check_serial(mechanism: Mechanism) -> None:
    for _, joint in mechanism.joints:
        if joint.type in ("C", "U", "S"):
            raise MechanismError(
                f"joint {joint.name!r}: type {joint.type} in a serial arm; types R, P and H are "
                f"allowed"
            )
        if not joint.actuated:
            raise MechanismError(
                f"joint {joint.name!r}: all joints of a serial arm are actuated; types R, P and H "
                f"are allowed"
            )
    if mechanism.motion != "spatial":
        raise MechanismError("motion is a key of a platform; a serial arm has none")


def require_mechanism(value: object) -> None:
    """Raises InputError where something else stands in place of a mechanism: its name, or a
    solution.
    """
    if not isinstance(value, Mechanism):
        named = f"; symkin.load({value!r}) gives it" if isinstance(value, str) else ""
        raise InputError(
            f"mechanism is of type {type(value).__name__}; a Mechanism is needed{named}"
        )
