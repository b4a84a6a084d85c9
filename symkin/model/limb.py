"""Limbs: chains of joints from base to platform, rods between spherical ends, and chains that end in rods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from symkin.errors import MechanismError
from symkin.model.joint import Coordinate, Joint, finite, interval, vector3

RodType = Literal["SPS", "UPS", "SPU"]
ROD_TYPES: tuple[RodType, ...] = ("SPS", "UPS", "SPU")
_SAME_POINT = 1e-9
"""Distance of two points that are one, over their largest coordinate."""


@dataclass(frozen=True)
class RodLimb:
    """An actuated rod between two joint centres: |t + R platform - base| = offset + value.

    `base` is in the base frame, `platform` in the platform frame; the coordinate, named as the limb, is the length
    beyond `offset`, and `limits` are a range of that value. SPS, UPS and SPU have the same closure.
    """

    name: str
    base: Sequence[float]
    platform: Sequence[float]
    offset: float = 0.0
    limits: Sequence[float] | None = None
    type: RodType = "SPS"

    def __post_init__(self) -> None:
        where = f"limb {self.name!r}"
        if self.type not in ROD_TYPES:
            raise MechanismError(f"{where}: type = {self.type!r} is unknown; allowed: {', '.join(ROD_TYPES)}")
        object.__setattr__(self, "base", vector3(self.base, f"{where}: base"))
        object.__setattr__(self, "platform", vector3(self.platform, f"{where}: platform"))
        object.__setattr__(self, "offset", finite(self.offset, f"{where}: offset"))
        object.__setattr__(self, "limits", interval(self.limits, f"{where}: limits"))

    def coordinate(self, reference: float) -> Coordinate:
        limits = None if self.limits is None else (self.limits[0], self.limits[1])
        return Coordinate(self.name, "length", "actuated", (reference,), limits, least=-self.offset)


@dataclass(frozen=True)
class Rod:
    """A rigid rod with spherical ends from a point of a limb's last link (`start`, base frame at the reference) to
    `platform` (platform frame); as long as it is at the reference, or `length`."""

    start: Sequence[float]
    platform: Sequence[float]
    length: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector3(self.start, "rod: from"))
        object.__setattr__(self, "platform", vector3(self.platform, "rod: platform"))
        if self.length is not None:
            length = finite(self.length, "rod: length")
            if length <= 0.0:
                raise MechanismError(f"rod: length = {length!r} must be positive")
            object.__setattr__(self, "length", length)


@dataclass(frozen=True)
class Limb:
    """Joints in order from base to platform; or, with `rods`, from base to the last link that carries the rods."""

    name: str
    joints: Sequence[Joint]
    rods: Sequence[Rod] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", tuple(self.joints))
        object.__setattr__(self, "rods", tuple(self.rods))
        if not self.joints:
            raise MechanismError(f"limb {self.name!r} has no joint; a limb needs at least one, or the keys of a rod limb")
        self._check_balls()

    def _check_balls(self) -> None:
        """Refuse two spherical joints at one centre that nothing between them can part: their distance would be zero always."""
        balls = [i for i, joint in enumerate(self.joints) if joint.type == "S"]
        if len(balls) < 2:
            return
        first, last = self.joints[balls[0]], self.joints[balls[-1]]
        between = self.joints[balls[0] + 1 : balls[-1]]
        if all(_turns_about(joint, first.point) for joint in (*between, last)):
            raise MechanismError(
                f"limb {self.name!r}: the spherical joints {first.name!r} and {last.name!r} lie at one point and nothing between "
                "them moves them apart, a rod of no length; leave one of them out"
            )

    @property
    def type(self) -> str:
        return "".join(joint.type for joint in self.joints) + ("" if not self.rods else f"+{len(self.rods)}SS")


def _turns_about(joint: Joint, centre: Sequence[float]) -> bool:
    """Whether a joint leaves a point at rest that lies on its axes."""
    if joint.type == "R":
        away = np.cross(np.subtract(joint.point, centre), np.array(joint.axis))
        return float(np.linalg.norm(away)) <= _same_point(joint.point, centre)
    return joint.type in "US" and coincide(joint.point, centre)


def coincide(a: Sequence[float], b: Sequence[float]) -> bool:
    """Whether two points are one to rounding."""
    return float(np.linalg.norm(np.subtract(a, b))) <= _same_point(a, b)


def _same_point(a: Sequence[float], b: Sequence[float]) -> float:
    """Distance within which two points are one."""
    return _SAME_POINT * (float(np.max(np.abs([a, b]))) or 1.0)
