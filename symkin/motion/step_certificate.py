"""Proof that a branch of G(y; c) = 0 runs through a tube, by Krawczyk's operator in ball arithmetic (see `proof.krawczyk`).

About a curve p(t), 0 <= t <= h, with the linear row e.(y - p(t)) = 0 added, and for a box B about zero,

    K = -M G(p(t)) + (1 - M [dG/dy (p(t) + B); e]) B,    M about the inverse of [dG/dy; e],

is enclosed for all t at once, by Taylor's formula about the middle of the curve with remainders over the tube. If K lies in the interior
of B, then for each t there is exactly one root in p(t) + B on that hyperplane, and the branch is regular there. With e the
direction of the path parameter u this is one solution for every u of the step, and dG/dz is regular: no singularity.

Where rows are redundant M is a pseudo-inverse; then at most one solution is proved, and its existence rests on the residual.
The path's coefficients are balls of a radius of about 2e-15 (of the size, or rad), in which the samples as given lie.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, arb_mat

from symkin.motion.path_system import PathSystem, coefficient_scales
from symkin.proof.balls import REAL, UP, precision, upper

_BITS = 64
_SPREAD = 2.0**-49
"""Radius of the coefficients' balls, relative to their values, or to the size and 1: what interpolation in double precision leaves out at the samples."""
_ROUNDING = 2.0**-48
"""Allowance for a cubic evaluated in double precision, relative to its control points."""
_INSIDE = 0.99
"""The image must lie in the box shrunk by this factor."""
_TRIALS = 3
"""Boxes tried for one tube."""
_THINNEST = 0.002
"""A first box is at least so thick as this times the largest extent of its curve."""
_SLIM = 0.1
"""Half width of a first box over the extent of its curve."""
_THINNER = 0.05
"""A second box is not thinner than this times the first: boxes take the shape of their images."""
_STILL = 1e-15
"""Half width of a box along the path parameter where the linear row holds it."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A cubic over 0 <= t <= length by its control points (4, n): it lies in their hull, its derivative in the hull of their
    scaled differences."""

    control: np.ndarray
    length: float

    @staticmethod
    def hermite(a: np.ndarray, slope_a: np.ndarray, b: np.ndarray, slope_b: np.ndarray, length: float) -> Curve:
        third = length / 3
        return Curve(np.array([a, a + third * slope_a, b - third * slope_b, b]), length)

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
        return _box(6.0 / self.length**2 * np.diff(self.control, 2, axis=0), 48.0 / self.length**2 * self.rounding)

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
        return _box(3.0 / self.length * np.diff(self.control, axis=0), 12.0 / self.length * self.rounding)


def _box(points: np.ndarray, rounding: float) -> tuple[np.ndarray, np.ndarray]:
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), 0.5 * (high - low) * UP + rounding


@dataclass(frozen=True, eq=False)
class Tube:
    """A proof for one step: half widths (n,) of the box about the curve, and the largest share of it that the image fills."""

    half: np.ndarray
    tightness: float

    def holds(self, half: np.ndarray | None) -> bool:
        """Whether a box of these half widths about a point of the curve lies in the tube there, the path parameter apart."""
        return half is not None and bool((half[:-1] <= self.half[:-1]).all())


@dataclass(frozen=True, eq=False)
class Interval:
    """The rows with the coefficients of one interval of the path bound."""

    system: PathSystem
    c: np.ndarray

    @cached_property
    def _prepared(self) -> list[Any]:
        with precision(_BITS):
            spread = _SPREAD * np.maximum(np.abs(self.c), coefficient_scales(self.system.problem))
            return self.system.balls.prepare(REAL, _balls(self.c, spread))

    def evaluate(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """G and dG/dy in doubles."""
        return self.system.evaluate(y, self.c)

    @cached_property
    def _prepared_second(self) -> list[Any]:
        function, constants = self.system.second
        with precision(_BITS):
            spread = _SPREAD * np.maximum(np.abs(self.c), coefficient_scales(self.system.problem))
            return function.prepare(REAL, [*_balls(self.c, spread), *constants])

    def tube(self, curve: Curve, direction: np.ndarray, *ends: np.ndarray | None) -> Tube | None:
        """A tube about the curve, or None where no box of those tried holds its image. `direction` is e; `ends` are half widths
        of boxes about points of the curve, the path parameter apart, which the tube must hold."""
        if any(half is None for half in ends):
            return None
        inverse = inverse_with(self.evaluate(curve.at(0.5))[1], direction)
        if inverse is None:
            return None
        _, extent = curve.hull
        with precision(_BITS):
            m = _matrix(inverse)
            start = self._value(m, curve.at(0.5), curve.rounding)
            least = _least_box([half for half in ends if half is not None], len(extent))
            half = np.maximum(_first_box(extent, direction), least)
            for _ in range(_TRIALS):
                image = self._image_along(m, start, curve, half, direction)
                if not np.isfinite(image).all():
                    return None
                if (image <= _INSIDE * half).all():
                    return Tube(half, float(np.max(image / half)))
                half = np.maximum(np.maximum(1.3 * image, _THINNER * half), least)
                if float(np.max(half)) > 30.0 * float(np.max(extent) + 1e-12):
                    return None
        return None

    def point(self, y: np.ndarray, direction: np.ndarray, jacobian: np.ndarray) -> np.ndarray | None:
        """Half widths (n,) of a box about y that holds exactly one root on the hyperplane e.(x - y) = 0, or None."""
        inverse = inverse_with(jacobian, direction)
        if inverse is None:
            return None
        with precision(_BITS):
            m = _matrix(inverse)
            start = self._value(m, y, 0.0)
            step = np.array([upper(v) for v in start.entries()])
            half = 2.5 * step + 0.01 * float(np.max(step)) + 1e-17
            for _ in range(_TRIALS):
                image = self._image(m, start, y, half, direction)
                if not np.isfinite(image).all() or float(np.max(half)) > 1e-2:
                    return None
                if (image <= _INSIDE * half).all():
                    return half
                half = half * 8.0
        return None

    def _value(self, m: arb_mat, y: np.ndarray, rounding: float) -> arb_mat:
        """M G at a point; the linear row vanishes there."""
        g = self.system.balls.evaluate(0, _balls(y, np.full(len(y), rounding)), self._prepared)
        return m * arb_mat(m.ncols(), 1, [*g, arb(0)])

    def _image(self, m: arb_mat, start: arb_mat, y: np.ndarray, half: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Upper bounds (n,) of |K| at a point."""
        n = len(half)
        slope = self.system.balls.evaluate(1, _balls(y, half), self._prepared)
        through = m * arb_mat(m.ncols(), n, [*slope, *direction.tolist()])
        total = (_identity(n) - through) * REAL.column(_balls(np.zeros(n), half)) - start
        return np.array([upper(v) for v in total.entries()])

    def _image_along(self, m: arb_mat, start: arb_mat, curve: Curve, half: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Upper bounds (n,) of |K| over a curve: G(p(t)) to second order and dG/dy to first about the middle, with remainders
        over the whole tube."""
        n, rows = len(half), m.ncols() - 1
        centre, extent = curve.hull
        middle, velocity = curve.at(0.5), REAL.column(_balls(*curve.velocity))
        ball = REAL.column(_balls(np.zeros(n), half))
        slope = self.system.balls.evaluate(1, _balls(middle, half + curve.rounding), self._prepared)
        arguments = [*_balls(centre, extent + half), *velocity.entries()]
        bend = arb_mat(rows, n, self.system.second[0].evaluate(0, arguments, self._prepared_second))
        there = arb_mat(rows, n, slope)
        through = m * arb_mat(rows + 1, n, [*slope, *direction.tolist()])
        late, square = arb(0, 0.5 * curve.length * UP), arb(0, 0.125 * curve.length**2 * UP)
        total = (_identity(n) - through) * ball - start + _lifted(m, bend * ball) * late
        at_middle = REAL.column(_balls(curve.middle_velocity, np.full(n, 12.0 / curve.length * curve.rounding)))
        total = total + _lifted(m, there * at_middle) * late
        rest = bend * velocity + (there + bend * late) * REAL.column(_balls(*curve.acceleration))
        total = total + _lifted(m, rest) * square
        return np.array([upper(v) for v in total.entries()])


def _lifted(m: arb_mat, column: arb_mat) -> arb_mat:
    """M times a column of the rows, zero in the linear row."""
    lifted: arb_mat = m * REAL.column([*column.entries(), arb(0)])
    return lifted


def inverse_with(jacobian: np.ndarray, direction: np.ndarray) -> np.ndarray | None:
    """About the (pseudo-)inverse of [dG/dy; e], (n, m + 1); None where it is singular or not finite. Where e is the path
    parameter's direction its last row is e exactly."""
    if not np.isfinite(jacobian).all():
        return None
    try:
        if direction[-1] == 1.0:
            inverse = _inverse(jacobian[:, :-1])
            top = np.hstack([inverse, -inverse @ jacobian[:, -1:]])
            inverse = np.vstack([top, np.append(np.zeros(jacobian.shape[0]), 1.0)])
        else:
            inverse = _inverse(np.vstack([jacobian, direction]))
    except np.linalg.LinAlgError:
        return None
    return inverse if np.isfinite(inverse).all() else None


def _inverse(matrix: np.ndarray) -> np.ndarray:
    square = matrix.shape[0] == matrix.shape[1]
    return np.asarray(np.linalg.inv(matrix) if square else np.linalg.pinv(matrix, rcond=1e-13))


def _first_box(extent: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """A part of the extent of the curve in each unknown, and a little of the largest; next to nothing along the path parameter
    where that is e."""
    half = _SLIM * extent + _THINNEST * float(np.max(extent[:-1], initial=0.0)) + 1e-13
    if direction[-1] == 1.0:
        half[-1] = _STILL
    return half


def _least_box(ends: list[np.ndarray], n: int) -> np.ndarray:
    """Twice the boxes that a tube must hold, free along the path parameter."""
    least = np.zeros(n)
    for half in ends:
        least = np.maximum(least, 2.0 * half)
    least[-1] = 0.0
    return least


def _balls(centre: np.ndarray, half: np.ndarray) -> list[arb]:
    return [arb(c, r) for c, r in zip(centre.tolist(), half.tolist(), strict=True)]


def _matrix(a: np.ndarray) -> arb_mat:
    return arb_mat(a.shape[0], a.shape[1], a.ravel().tolist())


def _identity(n: int) -> arb_mat:
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
