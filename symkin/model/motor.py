"""Describe what a file tells of the motor at a joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

from symkin.errors import MechanismError

_LARGEST = 1e6
"""Efforts and speeds from here on are what files write for none."""


@dataclass(frozen=True)
class Motor:
    """What drives a joint, at its coordinate and in SI units whatever units the file has.

    `effort` is the range (low, high) in N m or N, `speed` the largest rate in rad/s or m/s,
    `armature` the inertia in kg m^2 or kg. None: nothing is told of it. Raises MechanismError.

    >>> import symkin
    >>> motor = symkin.Motor(effort=[-25, 25], armature=0.002)
    >>> symkin.Joint("hip", "R", [0, 0, 0], [0, 0, 1], actuated=True, motor=motor).motor.effort
    (-25.0, 25.0)
    """

    effort: Sequence[float] | None = None
    speed: float | None = None
    armature: float | None = None

    def __post_init__(self) -> None:
        if self.effort is not None:
            low, high = (float(end) for end in self.effort)
            if not -math.inf < low < high < math.inf:
                raise MechanismError(
                    f"motor: effort = [{low:g}, {high:g}]; the lower end comes first, and they "
                    f"differ"
                )
            object.__setattr__(self, "effort", (low, high))
        for key in ("speed", "armature"):
            value = getattr(self, key)
            if value is not None and not 0.0 < value < math.inf:
                raise MechanismError(f"motor: {key} = {value:g}; a number above 0 is needed")

    def to_dict(self) -> dict[str, object]:
        """What is told, by its keys in a mechanism file."""
        told = {field.name: getattr(self, field.name) for field in fields(self)}
        return {k: list(v) if k == "effort" else v for k, v in told.items() if v is not None}


def motor_of(
    effort: Sequence[float] | None = None, speed: float | None = None, armature: float | None = None
) -> Motor | None:
    """The motor that a file's numbers tell; None where all of them stand for nothing: efforts and
    speeds of 0, below it or too large for any motor, inertias of 0.
    """
    if effort is not None and not (
        -_LARGEST < effort[0] < effort[1] < _LARGEST and math.isfinite(effort[0] + effort[1])
    ):
        effort = None
    speed = speed if speed is not None and 0.0 < speed < _LARGEST else None
    armature = armature if armature is not None and 0.0 < armature < _LARGEST else None
    found = Motor(effort, speed, armature)
    return found if found.to_dict() else None
