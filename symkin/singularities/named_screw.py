"""Name a twist or a wrench: its axis, its pitch, and what one would call it (Ball 1900)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.position.solution import Solution
from symkin.result import json_fields


@dataclass(frozen=True, eq=False)
class NamedScrew:
    """A screw (s; s0) about the base origin: a twist (angular velocity; velocity at the origin) or
    a wrench (force; moment).

    The direction part has unit length, or the moment part where there is no direction part
    (translation, couple). `size` is the length that makes both parts comparable in naming.
    """

    kind: Literal["twist", "wrench"]
    vector: np.ndarray
    length_unit: str
    characteristic_length: float

    @staticmethod
    def of(
        kind: Literal["twist", "wrench"], vector: np.ndarray, length_unit: str, size: float
    ) -> NamedScrew:
        """The same screw with unit length, its first component of weight positive."""
        s, s0 = vector[:3], vector[3:]
        pure = float(np.linalg.norm(s)) <= SINGULAR_VALUE * float(np.linalg.norm(s0)) / size
        leading = s0 if pure else s
        unit = vector / np.linalg.norm(leading)
        sign = next(
            (math.copysign(1.0, v) for v in (unit[3:] if pure else unit[:3]) if abs(v) > 1e-6), 1.0
        )
        parts = np.concatenate([np.zeros(3), unit[3:]]) if pure else unit
        return NamedScrew(kind, sign * parts + 0.0, length_unit, size)

    @property
    def is_pure_moment(self) -> bool:
        """A translation or a couple."""
        return not self.vector[:3].any()

    @property
    def direction(self) -> np.ndarray:
        return self.vector[3:] if self.is_pure_moment else self.vector[:3]

    @property
    def pitch(self) -> float | None:
        """Length per radian along the axis; None for translations and couples."""
        return None if self.is_pure_moment else float(self.vector[:3] @ self.vector[3:])

    @property
    def point(self) -> np.ndarray | None:
        """The point of the axis nearest to the base origin; None for translations and couples."""
        return None if self.is_pure_moment else np.cross(self.vector[:3], self.vector[3:])

    @property
    def name(self) -> str:
        """rotation, translation, screw; force, couple, wrench."""
        if self.is_pure_moment:
            return "translation" if self.kind == "twist" else "couple"
        if abs(self.pitch or 0.0) <= SINGULAR_VALUE * self.characteristic_length:
            return "rotation" if self.kind == "twist" else "force"
        return "screw" if self.kind == "twist" else "wrench"

    def to_dict(self) -> dict[str, Any]:
        """`vector` is (direction; moment about the base origin), `pitch` length per radian."""
        return json_fields(self, "name", "vector", "direction", "point", "pitch")

    def __str__(self) -> str:
        along = f"along {_triple(self.direction, 1.0)}"
        if self.point is None or self.pitch is None:
            return f"{self.name} {along}"
        line = f"through {_triple(self.point, self.characteristic_length)} {along}"
        match self.name:
            case "rotation":
                return f"rotation about the axis {line}"
            case "force":
                return f"force along the line {line}"
            case _:
                turn = 2 * math.pi * self.pitch
                return (
                    f"{self.name} of pitch {turn:.6g} {self.length_unit} per turn about the axis "
                    f"{line}"
                )


def named_twist(solution: Solution, motion: np.ndarray) -> NamedScrew:
    """From (velocity of the platform origin; size times angular velocity)."""
    turn = motion[3:] / solution.mechanism.characteristic_length
    return _named("twist", solution, turn, motion[:3])


def named_wrench(solution: Solution, covector: np.ndarray) -> NamedScrew:
    """From the wrench's work on (velocity of the platform origin; size times angular velocity)."""
    moment = solution.mechanism.characteristic_length * covector[3:]
    return _named("wrench", solution, covector[:3], moment)


def _named(
    kind: Literal["twist", "wrench"], solution: Solution, along: np.ndarray, about: np.ndarray
) -> NamedScrew:
    """A screw by its direction part and its moment about the platform's origin."""
    m, vector = solution.mechanism, [*along, *(about + np.cross(solution.position, along))]
    return NamedScrew.of(kind, np.array(vector), m.length_unit, m.characteristic_length)


def joint_rates(
    mechanism: Mechanism, joints: Sequence[Coordinate], rates: np.ndarray
) -> dict[str, float]:
    """Rates by joint name in the mechanism's units, the largest 1, from lengths and angles times
    the size.
    """
    size = mechanism.characteristic_length
    values = rates * np.array([mechanism.value_out(c, 1.0 / c.lever(size)) for c in joints])
    largest = np.flatnonzero(np.abs(values) > (1 - SINGULAR_VALUE) * np.abs(values).max())[0]
    values = values / values[largest]
    return {
        c.name: float(v) for c, v in zip(joints, values, strict=True) if abs(v) > SINGULAR_VALUE
    }


def _triple(vector: np.ndarray, scale: float) -> str:
    """Components to six digits, those below 1e-6 of the scale as zero."""
    return "(" + ", ".join(f"{0.0 if abs(v) < 1e-6 * scale else v:.6g}" for v in vector) + ")"
