"""Cubic curves with boxes that hold them and their derivatives in spite of rounding; a step is
proved about one.

With control points P_0 ... P_3 and s = t / length, in Bernstein's polynomials B (Farin, Curves and
Surfaces for CAGD, 2002):

    p = sum B_k^3(s) P_k,
    p' = (3 / length) sum B_k^2(s) (P_k+1 - P_k),
    p'' = (6 / length^2) sum B_k^1(s) (P_k+2 - 2 P_k+1 + P_k).

The polynomials are not negative and sum to 1, so that each lies in the box of its coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.balls import UP

_ROUNDING = 2.0**-48
"""Allowance for a cubic evaluated in double precision, relative to its control points."""


@dataclass(frozen=True, eq=False)
class Cubic:
    """A cubic over 0 <= t <= length by its control points (4, n): it lies in their hull, its
    derivative in the hull of their scaled differences.
    """

    control: np.ndarray
    length: float

    @staticmethod
    def hermite(
        a: np.ndarray, slope_a: np.ndarray, b: np.ndarray, slope_b: np.ndarray, length: float
    ) -> Cubic:
        third = length / 3
        return Cubic(np.array([a, a + third * slope_a, b - third * slope_b, b]), length)

    def at(self, share: float) -> np.ndarray:
        """The point at `share` of the length."""
        s, r = share, 1 - share
        return np.asarray(np.array([r**3, 3 * r * r * s, 3 * r * s * s, s**3]) @ self.control)

    @property
    def middle_velocity(self) -> np.ndarray:
        """The derivative in the middle."""
        return np.asarray(np.array([-0.75, -0.75, 0.75, 0.75]) @ self.control / self.length)

    @property
    def acceleration(self) -> tuple[np.ndarray, np.ndarray]:
        """Centre and half width (n,) of a box that holds the second derivative."""
        return _box(
            6.0 / self.length**2 * np.diff(self.control, 2, axis=0),
            48.0 / self.length**2 * self.rounding,
        )

    @property
    def rounding(self) -> float:
        return _ROUNDING * float(np.max(np.abs(self.control)))

    @property
    def hull(self) -> tuple[np.ndarray, np.ndarray]:
        """Centre and half width (n,) of a box that holds the curve."""
        return _box(self.control, self.rounding)

    @property
    def velocity(self) -> tuple[np.ndarray, np.ndarray]:
        """Centre and half width (n,) of a box that holds the derivative."""
        return _box(
            3.0 / self.length * np.diff(self.control, axis=0), 12.0 / self.length * self.rounding
        )


def _box(points: np.ndarray, rounding: float) -> tuple[np.ndarray, np.ndarray]:
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), 0.5 * (high - low) * UP + rounding
