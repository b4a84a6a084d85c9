"""Prove that a branch of G(y; c) = 0 runs through a tube, by Krawczyk's operator in ball arithmetic
(Krawczyk 1969; see `certificate.krawczyk`).

About a curve p(t), 0 <= t <= h, with the linear row e.(y - p(t)) = 0 added, and for a box B about
zero,

    K = -M G(p(t)) + (1 - M [dG/dy (p(t) + B); e]) B,    M about the inverse of [dG/dy; e],

is enclosed for all t at once, by Taylor's formula about the middle of the curve with remainders
over the tube. If K lies in the interior of B, then for each t there is exactly one root in p(t) + B
on that hyperplane, and the branch is regular there. With e the direction of the path parameter u
this is one solution for every u of the step, and dG/dz is regular: no singularity.

Where rows are redundant M is a pseudo-inverse; then at most one solution is proved, and its
existence rests on the residual. The path's coefficients are balls of a radius of about 2e-15 (of
the size, or rad), in which the samples as given lie.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, arb_mat

from symkin.computed_once import cached_property
from symkin.following.ball_matrices import (
    balls,
    bounds,
    fixed_point,
    identity,
    inverse_with,
    matrix,
    sum_rounding,
)
from symkin.following.cubic import Cubic
from symkin.following.path_system import PathSystem, coefficient_scales
from symkin.numeric.balls import REAL, UP, precision, upper

BITS = 64
"""Precision of the balls: eleven bits more than the doubles about which they lie."""
COEFFICIENT_RADIUS = 2.0**-49
"""Radius of the coefficients' balls, relative to their values, or to the size and 1: what
interpolation in double precision leaves out at the samples.
"""
LARGEST_FILL = 0.99
"""The image must lie in the box shrunk by this factor."""
_TRIALS = 3
"""Boxes tried for one tube."""
_LEAST_FIRST_WIDTH = 0.002
"""A first box is at least so thick as this times the largest extent of its curve."""
_FIRST_WIDTH = 0.1
"""Half width of a first box over the extent of its curve."""
_LEAST_NEXT_WIDTH = 0.05
"""A second box is not thinner than this times the first: boxes take the shape of their images."""
HELD_WIDTH = 1e-15
"""Half width of a box along the path parameter where the linear row holds it."""


@dataclass(frozen=True, eq=False)
class Tube:
    """A proof for one step: half widths (n,) of the box about the curve, and the largest share of
    it that the image fills. `frame` (n, n): the box is spanned by its orthonormal columns, None: by
    the axes.
    """

    half: np.ndarray
    tightness: float
    frame: np.ndarray | None = None

    def holds(self, half: np.ndarray | None) -> bool:
        """Whether a box of these half widths about a point of the curve lies in the tube there, the
        path parameter apart.
        """
        if half is None:
            return False
        # the frame's inverse is its transpose but for rounding
        across = (
            half
            if self.frame is None
            else (np.abs(self.frame.T) @ half + 1e-13 * float(np.max(half))) * UP
        )
        return bool((across[:-1] <= self.half[:-1]).all())


@dataclass(frozen=True, eq=False)
class Interval:
    """The rows with the coefficients of one interval of the path bound."""

    system: PathSystem
    c: np.ndarray

    @cached_property
    def _prepared(self) -> list[Any]:
        with precision(BITS):
            spread = COEFFICIENT_RADIUS * np.maximum(
                np.abs(self.c), coefficient_scales(self.system.problem)
            )
            return self.system.balls.prepare(REAL, balls(self.c, spread))

    def evaluate(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """G and dG/dy in doubles."""
        return self.system.evaluate(y, self.c)

    def series(self, part: int, y: list[Any]) -> list[Any]:
        """G (part 0) or dG/dy (part 1) along power series over balls."""
        return self.system.balls.evaluate(part, y, self._prepared)

    @cached_property
    def _prepared_second(self) -> list[Any]:
        function, constants = self.system.second
        with precision(BITS):
            spread = COEFFICIENT_RADIUS * np.maximum(
                np.abs(self.c), coefficient_scales(self.system.problem)
            )
            return function.prepare(REAL, [*balls(self.c, spread), *constants])

    def tube(self, curve: Cubic, direction: np.ndarray, *ends: np.ndarray | None) -> Tube | None:
        """A tube about the curve, or None where no box of those tried holds its image. `direction`
        is e; `ends` are half widths of boxes about points of the curve, the path parameter apart,
        which the tube must hold.
        """
        if any(half is None for half in ends):
            return None
        inverse = inverse_with(self.evaluate(curve.at(0.5))[1], direction)
        if inverse is None:
            return None
        _, extent = curve.hull
        with precision(BITS):
            m = matrix(inverse)
            start = self._value(m, curve.at(0.5), curve.rounding)
            least = _least_box([half for half in ends if half is not None], len(extent))
            half = np.maximum(_first_box(extent, direction), least)
            for _ in range(_TRIALS):
                image = self._image_along(m, start, curve, half, direction)
                if not np.isfinite(image).all():
                    return None
                if (image <= LARGEST_FILL * half).all():
                    return Tube(half, float(np.max(image / half)))
                half = np.maximum(np.maximum(1.3 * image, _LEAST_NEXT_WIDTH * half), least)
                if float(np.max(half)) > 30.0 * float(np.max(extent) + 1e-12):
                    return None
        return None

    def point(
        self, y: np.ndarray, direction: np.ndarray, jacobian: np.ndarray
    ) -> np.ndarray | None:
        """Half widths (n,) of a box about y that holds exactly one root on the hyperplane e.(x -
        y) = 0, or None.
        """
        inverse = inverse_with(jacobian, direction)
        if inverse is None:
            return None
        with precision(BITS):
            m = matrix(inverse)
            start = self._value(m, y, 0.0)
            step = np.array([upper(v) for v in start.entries()])
            half = 2.5 * step + 0.01 * float(np.max(step)) + 1e-17
            for _ in range(_TRIALS):
                image = self._image(m, start, y, half, direction)
                if not np.isfinite(image).all() or float(np.max(half)) > 1e-2:
                    return None
                if (image <= LARGEST_FILL * half).all():
                    return half
                half = half * 8.0
        return None

    def tangent(
        self, y: np.ndarray, half: np.ndarray, direction: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Centre and half width (n,) of a box that holds the branch's tangent, e.dy/ds = 1, at
        every root in y + box; None where none is proved. With M about the inverse of [dG/dy; e], m
        its last column, dy/ds = m + (1 - M [dG/dy; e]) dy/ds.
        """
        inverse = inverse_with(self.evaluate(y)[1], direction)
        if inverse is None:
            return None
        with precision(BITS):
            m = matrix(inverse)
            slope = self.system.balls.evaluate(1, balls(y, half), self._prepared)
            error = identity(len(y)) - m * arb_mat(m.ncols(), len(y), [*slope, *direction.tolist()])
            away = fixed_point(
                error, (bounds(error) @ np.abs(inverse[:, -1])) * sum_rounding(len(y))
            )
        return None if away is None else (inverse[:, -1], away)

    def folds_once(self, curve: Cubic, direction: np.ndarray, tube: Tube) -> bool:
        """Whether d2u/ds2 < 0 is proved for the branch in a tube over s = e.y, so that u has at
        most one extreme there. With T a box that holds all tangents, d2y/ds2 = -M [d2G/dy2 T T;
        0] + (1 - M [dG/dy; e]) d2y/ds2.
        """
        inverse = inverse_with(self.evaluate(curve.at(0.5))[1], direction)
        if inverse is None:
            return False
        n = len(direction)
        with precision(BITS):
            m = matrix(inverse)
            there, bend = self._slopes(curve, tube.half)
            slope = there + bend * arb(0, 0.5 * curve.length * UP)
            error = identity(n) - m * arb_mat(m.ncols(), n, [*slope.entries(), *direction.tolist()])
            away = fixed_point(error, (bounds(error) @ np.abs(inverse[:, -1])) * sum_rounding(n))
            if away is None:
                return False
            tangents = balls(inverse[:, -1], away)
            curved = _lifted(m, self._bend(curve, tube.half, tangents) * REAL.column(tangents))
            size = np.array([upper(v) for v in curved.entries()])
            away = fixed_point(error, (bounds(error) @ size) * sum_rounding(n))
            return away is not None and bool(-curved[n - 1, 0] + arb(0, float(away[-1])) < 0)

    def _value(self, m: arb_mat, y: np.ndarray, rounding: float) -> arb_mat:
        """M G at a point; the linear row vanishes there."""
        g = self.system.balls.evaluate(0, balls(y, np.full(len(y), rounding)), self._prepared)
        return m * arb_mat(m.ncols(), 1, [*g, arb(0)])

    def _image(
        self, m: arb_mat, start: arb_mat, y: np.ndarray, half: np.ndarray, direction: np.ndarray
    ) -> np.ndarray:
        """Upper bounds (n,) of |K| at a point."""
        n = len(half)
        slope = self.system.balls.evaluate(1, balls(y, half), self._prepared)
        through = m * arb_mat(m.ncols(), n, [*slope, *direction.tolist()])
        total = (identity(n) - through) * REAL.column(balls(np.zeros(n), half)) - start
        return np.array([upper(v) for v in total.entries()])

    def _image_along(
        self, m: arb_mat, start: arb_mat, curve: Cubic, half: np.ndarray, direction: np.ndarray
    ) -> np.ndarray:
        """Upper bounds (n,) of |K| over a curve: G(p(t)) to second order and dG/dy to first about
        the middle, with remainders over the whole tube.
        """
        n, rows = len(half), m.ncols() - 1
        velocity = REAL.column(balls(*curve.velocity))
        ball = REAL.column(balls(np.zeros(n), half))
        there, bend = self._slopes(curve, half)
        through = m * arb_mat(rows + 1, n, [*there.entries(), *direction.tolist()])
        late, square = arb(0, 0.5 * curve.length * UP), arb(0, 0.125 * curve.length**2 * UP)
        total = (identity(n) - through) * ball - start + _lifted(m, bend * ball) * late
        at_middle = REAL.column(
            balls(curve.middle_velocity, np.full(n, 12.0 / curve.length * curve.rounding))
        )
        total = total + _lifted(m, there * at_middle) * late
        rest = bend * velocity + (there + bend * late) * REAL.column(balls(*curve.acceleration))
        total = total + _lifted(m, rest) * square
        return np.array([upper(v) for v in total.entries()])

    def _slopes(self, curve: Cubic, half: np.ndarray) -> tuple[arb_mat, arb_mat]:
        """dG/dy about the middle of a tube, and its derivative along the curve over the whole
        tube.
        """
        slope = self.system.balls.evaluate(
            1, balls(curve.at(0.5), half + curve.rounding), self._prepared
        )
        return arb_mat(self.system.count, len(half), slope), self._bend(
            curve, half, balls(*curve.velocity)
        )

    def _bend(self, curve: Cubic, half: np.ndarray, along: list[arb]) -> arb_mat:
        """The derivative of dG/dy along a box of vectors over the whole tube."""
        centre, extent = curve.hull
        arguments = [*balls(centre, extent + half), *along]
        return arb_mat(
            self.system.count,
            len(half),
            self.system.second[0].evaluate(0, arguments, self._prepared_second),
        )


def _lifted(m: arb_mat, column: arb_mat) -> arb_mat:
    """M times a column of the rows, zero in the linear row."""
    lifted: arb_mat = m * REAL.column([*column.entries(), arb(0)])
    return lifted


def _first_box(extent: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """A part of the extent of the curve in each unknown, and a little of the largest; next to
    nothing along the path parameter where that is e.
    """
    half = (
        _FIRST_WIDTH * extent + _LEAST_FIRST_WIDTH * float(np.max(extent[:-1], initial=0.0)) + 1e-13
    )
    if direction[-1] == 1.0:
        half[-1] = HELD_WIDTH
    return half


def _least_box(ends: list[np.ndarray], n: int) -> np.ndarray:
    """Twice the boxes that a tube must hold, free along the path parameter."""
    least = np.zeros(n)
    for half in ends:
        least = np.maximum(least, 2.0 * half)
    least[-1] = 0.0
    return least
