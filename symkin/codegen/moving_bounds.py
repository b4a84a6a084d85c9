"""Bound numbers, points and directions, and their first and second derivatives, along a part of a
line.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closed.screws import Screw
from symkin.codegen.steps.newton_kernel import rounded_up

_ON_AXIS = 1e-12
"""Distance (of the size) and sine of points and directions that lie on an axis: rounding."""
ZERO = ca.SX(0)


@dataclass(frozen=True)
class Scalar:
    """Bounds of a number along a part: of itself, its first and its second derivative."""

    size: ca.SX
    speed: ca.SX
    bend: ca.SX

    def times(self, other: Scalar) -> Scalar:
        return Scalar(
            self.size * other.size,
            self.speed * other.size + self.size * other.speed,
            self.bend * other.size + 2 * self.speed * other.speed + self.size * other.bend,
        )

    def plus(self, other: Scalar) -> Scalar:
        return Scalar(self.size + other.size, self.speed + other.speed, self.bend + other.bend)

    @property
    def half_square(self) -> Scalar:
        """Of half of the square of what is bounded."""
        return Scalar(
            0.5 * self.size**2, self.size * self.speed, self.speed**2 + self.size * self.bend
        )


@dataclass(frozen=True, eq=False)
class Moving:
    """A point (over the size) or direction along a part: it stays within `radius` of `centre`, and
    bounds of its first and second derivative.
    """

    centre: np.ndarray
    radius: ca.SX
    speed: ca.SX
    bend: ca.SX

    def away(self, point: np.ndarray) -> Scalar:
        """Its distance from a point that stays."""
        return Scalar(length_of(self.centre - point) + self.radius, self.speed, self.bend)

    def along(self, k: np.ndarray, point: np.ndarray) -> Scalar:
        """How far along a direction it is from a point that stays."""
        return Scalar(size_of(k @ (self.centre - point)) + self.radius, self.speed, self.bend)

    def across(self, screw: Screw, point: np.ndarray) -> Scalar:
        """Its part across an axis through a point."""
        gap, k = self.centre - point, np.array(screw.axis)
        return Scalar(length_of(gap - k * (k @ gap)) + self.radius, self.speed, self.bend)


def at_rest(vector: np.ndarray) -> Moving:
    """A vector that stays."""
    return Moving(vector, ca.SX(0), ca.SX(0), ca.SX(0))


def between(a: Moving, b: Moving) -> Moving:
    """The vector a - b."""
    return Moving(a.centre - b.centre, a.radius + b.radius, a.speed + b.speed, a.bend + b.bend)


def dot_of(a: Moving, b: Moving) -> Scalar:
    """The scalar product of two vectors, by their lengths."""
    return a.away(np.zeros(3)).times(b.away(np.zeros(3)))


def norm_of(vector: np.ndarray) -> float:
    """The length of a vector."""
    return float(np.linalg.norm(vector))


def length_of(vector: np.ndarray) -> float:
    """The length of a vector as a bound."""
    return size_of(norm_of(vector))


def size_of(number: float) -> float:
    """The absolute value of a number, rounded up to three digits; 0 of rounding."""
    return 0.0 if abs(number) <= _ON_AXIS else rounded_up(abs(float(number)))


def lesser(a: ca.SX, b: ca.SX) -> ca.SX:
    """The lesser of two bounds, the second one where that is told by a slide."""
    if not (a.is_constant() and b.is_constant()):
        return a if a.is_constant() else b
    return a if float(a) <= float(b) else b


ONE = Scalar(ca.SX(1), ca.SX(0), ca.SX(0))
