"""Describe joints at the reference configuration, and the coordinates that they carry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Literal

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.model.joint_forms import JOINT_FORMS, NUMBERS, JointForm, JointType, Kind
from symkin.model.motor import Motor
from symkin.text import not_among

BASE = "base"
"""The link that is fixed."""
PLATFORM = "platform"
"""The link on which limbs end where nothing else is said."""
POSE_CONDITIONS = ("x", "y", "z", "azimuth", "tilt", "torsion")
"""Coordinates of the platform's pose that are given one by one: position, and the rotation
Rz(azimuth) Ry(tilt) Rz(torsion - azimuth) from the base frame (Bonev, Zlatanov, Gosselin, ASME J.
Mech. Des. 124, 2002).
"""


@dataclass(frozen=True)
class Coordinate:
    """One joint or pose coordinate: a number, or a unit quaternion of four.

    `reference` is its value at the reference configuration; `limits` are in the same units
    (radians, length unit). A rod's coordinate has a `least` value, where its length is zero: 2
    least - value is the same configuration.
    """

    name: str
    kind: Kind
    role: Literal["actuated", "passive", "body", "pose", "condition", "geometry"]
    reference: tuple[float, ...] = (0.0,)
    limits: tuple[float, float] | None = None
    least: float | None = None

    @cached_property
    def width(self) -> int:
        """Count of numbers that hold it."""
        return NUMBERS[self.kind][0]

    @cached_property
    def freedom(self) -> int:
        """Count of independent ways in which it changes."""
        return NUMBERS[self.kind][1]

    @property
    def body(self) -> str | None:
        """The body whose pose it belongs to ("pose" for the platform), None for other
        coordinates.
        """
        return self.name.rpartition(".")[0] if self.role in ("body", "pose") else None

    @cached_property
    def is_angular(self) -> bool:
        """Whether it is a single angle, in radians."""
        return self.kind in ("angle", "turns")

    @cached_property
    def is_periodic(self) -> bool:
        """Whether whole turns leave it as it is."""
        return self.kind == "angle"

    @cached_property
    def is_advancing(self) -> bool:
        """Whether it is an angle whose whole turns count."""
        return self.kind == "turns"

    @cached_property
    def is_rotation(self) -> bool:
        """Whether it is a unit quaternion."""
        return self.kind == "quaternion"

    @cached_property
    def is_length(self) -> bool:
        """Whether it is a length."""
        return self.kind == "length"

    def unit(self, length: float) -> float:
        """What its numbers are measured in: a length in `length`, all others in 1."""
        return length if self.is_length else 1.0

    def lever(self, length: float) -> float:
        """How far a unit of it moves what is `length` away: 1 for a length."""
        return 1.0 if self.is_length else length


def units_of(coordinates: Sequence[Coordinate], length: float) -> list[float]:
    """The unit of each number of the coordinates (see `Coordinate.unit`)."""
    return [c.unit(length) for c in coordinates for _ in range(c.width)]


def places_of(coordinates: Sequence[Coordinate], counts: Sequence[int]) -> dict[str, range]:
    """The places of each coordinate's numbers, so many of each, one coordinate after the other."""
    ends = accumulate(counts)
    return {
        c.name: range(end - n, end) for c, n, end in zip(coordinates, counts, ends, strict=True)
    }


@dataclass(frozen=True)
class Joint:
    """A joint by a point on it and its axis, in the base frame at the reference configuration.

    R turns about `axis`, P slides along it, H turns and advances by `pitch` per turn (right-handed,
    coordinate = angle), C turns and slides, U turns about `axis` and then about `axis2` carried
    along, S turns about `point`. The displacement of a coordinate q is exp(S (q - zero)), S =
    (axis, point x axis + pitch axis / 2 pi) the joint's screw.

    `point`, `axis`, `axis2`: 3 numbers each, directions are normalised; `pitch`: length a turn (H);
    `zero`: the coordinate's value at the reference, `limits`: its range (low, high), `motor`: what
    is told of the motor there, all for R, P, H only; angles in radians, lengths in the length unit.
    Raises MechanismError for a type, a number or a combination that means nothing, with what is
    allowed.

    >>> import math, symkin
    >>> turn = [-math.pi, math.pi]
    >>> motor = symkin.Joint("q1", "R", [0, 0, 100], axis=[0, 0, 2], actuated=True, limits=turn)
    >>> motor.axis, motor.freedom
    ((0.0, 0.0, 1.0), 1)
    >>> symkin.Joint("u", "U", [0, 0, 0], [0, 0, 1], [0, 0, 1])
    Traceback (most recent call last):
    symkin.errors.MechanismError: joint 'u': axis2 = [0.0, 0.0, 1.0] is parallel to axis; ...

    Source: R. M. Murray, Z. Li, S. S. Sastry, A Mathematical Introduction to Robotic Manipulation,
    1994, section 3.2.
    """

    name: str
    type: JointType
    point: Sequence[float] = (0.0, 0.0, 0.0)
    axis: Sequence[float] | None = None
    axis2: Sequence[float] | None = None
    pitch: float = 0.0
    actuated: bool = False
    zero: float = 0.0
    limits: Sequence[float] | None = None
    motor: Motor | None = None

    def __post_init__(self) -> None:
        where = f"joint {self.name!r}"
        if self.type not in JOINT_FORMS:
            raise MechanismError(f"{where}: type = {not_among(self.type, JOINT_FORMS)}")
        if self.actuated and not self.form.axes:
            raise MechanismError(
                f"{where}: actuated = true is allowed for R, P, H, C and U joints only, not for "
                f"{self.type}"
                + (
                    "; write it as three R joints whose axes meet in a point, of which any are "
                    "actuated"
                    if self.type == "S"
                    else ""
                )
            )
        own = self.limits is not None or self.motor is not None
        if self.freedom != 1 and (self.zero != 0.0 or own):
            raise MechanismError(
                f"{where}: zero, limits and motor are allowed for joints of one coordinate (R, P, "
                f"H) only"
            )
        if self.type == "H" and self.pitch == 0.0:
            raise MechanismError(
                f"{where}: pitch is missing or 0; a helical joint needs its length per turn"
            )
        if self.type != "H" and self.pitch != 0.0:
            raise MechanismError(
                f"{where}: pitch is allowed for H joints only, not for {self.type}"
            )
        object.__setattr__(self, "point", vector3(self.point, f"{where}: point"))
        object.__setattr__(self, "axis", self._direction("axis", needed=self.form.axes > 0))
        object.__setattr__(self, "axis2", self._direction("axis2", needed=self.form.axes > 1))
        object.__setattr__(self, "zero", finite(self.zero, f"{where}: zero"))
        object.__setattr__(self, "pitch", finite(self.pitch, f"{where}: pitch"))
        object.__setattr__(self, "limits", interval(self.limits, f"{where}: limits"))
        if self.form.axes > 1 and _parallel(self.axis, self.axis2):
            raise MechanismError(
                f"{where}: axis2 = {list(self.axis2 or ())} is parallel to axis; a {self.type} "
                f"joint needs two directions"
            )

    def _direction(self, key: str, *, needed: bool) -> tuple[float, ...] | None:
        value = getattr(self, key)
        where = f"joint {self.name!r}: {key}"
        if value is None and needed:
            raise MechanismError(f"{where} is missing; a joint of type {self.type} needs it")
        if value is None:
            return None
        if not needed:
            raise MechanismError(f"{where} has no meaning for a joint of type {self.type}")
        return unit3(value, where)

    def turned(self) -> Joint:
        """The joint as it is seen from its second link, which its coordinate moves the other way
        about.
        """
        axis, axis2 = (None if a is None else tuple(-c for c in a) for a in (self.axis, self.axis2))
        return replace(self, axis=axis2, axis2=axis) if axis2 else replace(self, axis=axis)

    @property
    def form(self) -> JointForm:
        """What joints of its type have."""
        return JOINT_FORMS[self.type]

    @property
    def freedom(self) -> int:
        """Count of the joint's degrees of freedom."""
        return self.form.freedom

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates in the order in which the joint moves."""
        role: Literal["actuated", "passive"] = "actuated" if self.actuated else "passive"
        limits = None if self.limits is None else (self.limits[0], self.limits[1])
        return tuple(
            Coordinate(
                self.name + suffix,
                kind,
                role,
                (1.0, 0.0, 0.0, 0.0) if kind == "quaternion" else (self.zero,),
                limits,
            )
            for suffix, kind in self.form.coordinates
        )


# --- checks of numbers, shared by every part of a description -------------------------------------


LARGEST = 1e153
"""Numbers of a description are at most this, in any unit: sums of their squares stay within
doubles.
"""


def finite(value: float, where: str, largest: float = LARGEST) -> float:
    """Refuse what is not a finite number, or larger than `largest`; -0 becomes 0."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise MechanismError(f"{where} = {value!r} is not a number") from None
    if not math.isfinite(number):
        raise MechanismError(f"{where} = {value!r} is not finite")
    if abs(number) > largest:
        raise MechanismError(f"{where} = {value!r} is too large; at most {largest!r} is allowed")
    return number + 0.0


def vector3(value: Sequence[float], where: str) -> tuple[float, float, float]:
    """Refuse what is not three finite numbers."""
    try:
        components = tuple(value)
    except TypeError:
        raise MechanismError(
            f"{where} = {value!r} is no vector; three numbers are needed"
        ) from None
    if len(components) != 3:
        raise MechanismError(
            f"{where} = {list(components)} has {len(components)} numbers; three are needed"
        )
    x, y, z = (finite(component, where) for component in components)
    return (x, y, z)


def unit3(value: Sequence[float], where: str) -> tuple[float, float, float]:
    """Normalise a direction; one of length 1 to rounding keeps its digits."""
    x, y, z = vector3(value, where)
    length = math.hypot(x, y, z)
    if length < 1e-12:
        raise MechanismError(f"{where} = {[x, y, z]} is the zero vector; a direction is needed")
    # a unit vector to rounding keeps its digits, so that files read back as they were written
    if abs(length - 1.0) <= 4e-16:
        return (x, y, z)
    return (x / length, y / length, z / length)


def interval(value: Sequence[float] | None, where: str) -> tuple[float, float] | None:
    """Refuse what is not two finite numbers, low < high."""
    if value is None:
        return None
    try:
        bounds = tuple(finite(bound, where, math.inf) for bound in value)
    except TypeError:
        raise MechanismError(
            f"{where} = {value!r} is no range; two numbers [low, high] with low < high are needed"
        ) from None
    if len(bounds) != 2 or not bounds[0] < bounds[1]:
        raise MechanismError(
            f"{where} = {list(bounds)} is no range; two numbers [low, high] with low < high are "
            f"needed"
        )
    return (bounds[0], bounds[1])


def link_pair(links: Sequence[str], where: str) -> tuple[str, str]:
    """Two links, not the same."""
    pair = tuple(links)
    if len(pair) != 2 or not all(isinstance(link, str) for link in pair):
        raise MechanismError(
            f"{where}: links = {list(pair)} names {len(pair)} links; a joint is between two"
        )
    if pair[0] == pair[1]:
        raise MechanismError(
            f"{where}: links = {list(pair)} joins {pair[0]!r} to itself; two links are needed"
        )
    return pair


def _parallel(a: Sequence[float] | None, b: Sequence[float] | None) -> bool:
    if a is None or b is None:
        return False
    return (
        math.hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        < 1e-9
    )
