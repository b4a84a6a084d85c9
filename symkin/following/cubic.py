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

_HALVINGS = 30
"""Halvings to the place of a value: to 1e-9 of the length."""


@dataclass(frozen=True, eq=False)
class Cubic:
    """Cubics over 0 <= t <= length (...,) by their control points (..., 4, n): each lies in their
    hull, its derivative in the hull of their scaled differences.
    """

    control: np.ndarray
    length: np.ndarray

    @staticmethod
    def hermite(
        a: np.ndarray,
        slope_a: np.ndarray,
        b: np.ndarray,
        slope_b: np.ndarray,
        length: np.ndarray | float,
    ) -> Cubic:
        """The cubics through a and b (..., n) with these slopes there."""
        third = np.asarray(length)[..., None] / 3
        points = [a, a + third * slope_a, b - third * slope_b, b]
        return Cubic(np.stack(points, axis=-2), np.asarray(length, dtype=float))

    def among(self, chosen: np.ndarray | slice | int) -> Cubic:
        """Some of several cubics."""
        return Cubic(self.control[chosen], self.length[chosen])

    def longer(self, share: float) -> Cubic:
        """The same cubics, begun and ended this share of their length beyond their ends."""
        ends = (-share, 1.0 + share)
        # the control points of a part are the values of the polar form at its ends
        blossom = [_polar(*(ends[int(i < k)] for i in range(3))) for k in range(4)]
        return Cubic(np.array(blossom) @ self.control, self.length * (1.0 + 2.0 * share))

    def at(self, share: float) -> np.ndarray:
        """The point at `share` of the length."""
        return _polar(share, share, share) @ self.control

    def share_at(self, value: float) -> float:
        """The share at which the last component, which grows along one cubic, has a value."""
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.at(middle)[-1] < value else (low, middle)
        return 0.5 * (low + high)

    @property
    def middle_velocity(self) -> np.ndarray:
        """The derivative in the middle."""
        difference = np.array([-0.75, -0.75, 0.75, 0.75]) @ self.control
        return difference / self.length[..., None]

    @property
    def acceleration(self) -> tuple[np.ndarray, np.ndarray]:
        """Centre and half width (..., n) of a box that holds the second derivative."""
        scale = 6.0 / self.length[..., None] ** 2
        return _box(scale[..., None] * np.diff(self.control, 2, axis=-2), 8.0 * scale, self)

    @property
    def rounding(self) -> np.ndarray:
        """How far points (...,) that double precision gives are off at most."""
        return np.asarray(_ROUNDING * np.max(np.abs(self.control), axis=(-2, -1)))

    @property
    def hull(self) -> tuple[np.ndarray, np.ndarray]:
        """Centre and half width (..., n) of a box that holds the curve."""
        return _box(self.control, np.ones((*self.length.shape, 1)), self)

    @property
    def velocity(self) -> tuple[np.ndarray, np.ndarray]:
        """Centre and half width (..., n) of a box that holds the derivative."""
        scale = 3.0 / self.length[..., None]
        return _box(scale[..., None] * np.diff(self.control, axis=-2), 4.0 * scale, self)


def _polar(r: float, s: float, t: float) -> np.ndarray:
    """Weights (4,) of the control points in the cubic's polar form, at three shares."""
    return np.array(
        [
            (1 - r) * (1 - s) * (1 - t),
            r * (1 - s) * (1 - t) + s * (1 - r) * (1 - t) + t * (1 - r) * (1 - s),
            r * s * (1 - t) + r * t * (1 - s) + s * t * (1 - r),
            r * s * t,
        ]
    )


def _box(points: np.ndarray, scale: np.ndarray, curve: Cubic) -> tuple[np.ndarray, np.ndarray]:
    """A box of points (..., k, n), and of what rounding leaves out times a scale (..., 1)."""
    low, high = points.min(axis=-2), points.max(axis=-2)
    return 0.5 * (low + high), 0.5 * (high - low) * UP + scale * curve.rounding[..., None]
