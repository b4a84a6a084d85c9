"""The machine that a description means, with what a closure must know of it that no file tells."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.model.keys import ABOUT_Z
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply

_EXACT = 1e-14
"""Numbers of a quaternion that are zero to rounding."""


@dataclass(frozen=True)
class Machine(Mechanism):
    """The machine of a mechanism, not equal to it. Of one that is `laid` the closure describes each
    limb along axes, at a stand of its own (`closure/laid.py`). Of one that was turned coordinates
    of the pose are `told_in` the frames of its description: quaternions of base and platform. Of
    one that a file leaves open the joints that close loops have `gaps`, by which what their second
    links carry is displaced from where they are closed (position and quaternion); all others carry
    links, in this order. Its `size` stands in place of the characteristic length.
    """

    laid: bool = False
    told_in: tuple[tuple[float, ...], ...] = ()
    gaps: tuple[tuple[str, tuple[float, ...]], ...] | None = None
    size: float = 0.0

    __hash__ = Mechanism.__hash__

    def __post_init__(self) -> None:
        # the joints of a robot's file may be welds alone, which are no mechanism
        if self.gaps is None:
            super().__post_init__()

    @cached_property
    def characteristic_length(self) -> float:
        """That of the description, where no other one is told."""
        return self.size or super().characteristic_length

    @staticmethod
    def of(mechanism: Mechanism, **changes: Any) -> Machine:
        """The machine of a mechanism, or of another machine, with some of its fields changed."""
        own = {f.name: getattr(mechanism, f.name) for f in fields(mechanism)}
        return Machine(**(own | changes))


def is_laid(mechanism: Mechanism) -> bool:
    """Whether the closure describes the limbs along axes."""
    return isinstance(mechanism, Machine) and mechanism.laid


def gaps_of(mechanism: Mechanism) -> dict[str, Pose] | None:
    """What joints that close loops of a file leave open; None where no file leaves loops open."""
    if not isinstance(mechanism, Machine) or mechanism.gaps is None:
        return None
    return {name: Pose(np.array(gap[:3]), np.array(gap[3:])) for name, gap in mechanism.gaps}


def as_described(mechanism: Mechanism, pose: Pose) -> Pose:
    """A pose, its quaternion of any length, in the frames of the description: turned back by that
    of its base, seen from its platform.
    """
    if not isinstance(mechanism, Machine) or not mechanism.told_in:
        return pose
    base, platform = (Pose(np.zeros(3), np.array(turn)) for turn in mechanism.told_in)
    return base.inverse() @ (pose @ platform)


def turn_about_z(mechanism: Mechanism) -> float:
    """The platform's coordinate about z at the reference: 0, but of a laid machine, which tells it
    from an orientation without a turn about z.
    """
    w, z = mechanism.platform_quaternion[0], mechanism.platform_quaternion[3]
    is_told = is_laid(mechanism) and mechanism.motion in ABOUT_Z
    return 2.0 * math.atan2(z, w) if is_told else 0.0


def untwisted(mechanism: Mechanism) -> np.ndarray:
    """The quaternion of the platform from which its turn about z is told."""
    half, own = 0.5 * turn_about_z(mechanism), np.array(mechanism.platform_quaternion)
    if not half:
        return own
    found = multiply(np.array([math.cos(half), 0.0, 0.0, -math.sin(half)]), own)
    return np.where(np.abs(found) <= _EXACT, 0.0, found)
