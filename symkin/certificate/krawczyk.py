"""Existence and uniqueness of a root in a box, by Krawczyk's operator in ball arithmetic.

For F(x) = 0 with as many rows as unknowns, a centre c, any matrix Y, and the box X of half width r
about c,

    K(X) = c - Y F(c) + (1 - Y F'(X)) (X - c).

If K(X) lies in the interior of X, X holds exactly one root, and F' is regular on X (Krawczyk 1969;
Moore 1977; Rump 1999). Over the complex numbers boxes are products of squares, and the statement is
the real one for real and imaginary parts. A ray x is made a point by the affine patch conj(z).(x -
c) = 0, z its approximate direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from flint import acb_mat, arb_mat, ctx

from symkin.certificate.ball_system import BallSystem
from symkin.computed_once import cached_property, lru_cache
from symkin.numeric.balls import COMPLEX, Number, Ring, precision, upper

_INFLATION = 2.5
"""Half width of the first box, over the size of the last Newton step."""
_WIDEST = 1e-3
"""Boxes wider than this prove nothing that is of use."""
_INSIDE = 0.99
"""The image lies in the box shrunk by this factor, hence in its interior."""
_REFINEMENTS = 10
"""Newton steps at most; from a good start each doubles the digits."""
_NEARLY_THERE = 1e-6
"""Steps below this that do not halve any more are rounding: the precision gives no more digits."""
_BITS = 64
"""Precision at which a box about a point in double precision is handled."""
_NEARLY_ZERO = 1e-10
"""Components of a unit ray below this are tried as exact zeros."""


@dataclass(frozen=True)
class Chart:
    """A square part of F near a root: `rows`, the unknowns `columns` (the others are exactly zero),
    and the patch, a row over all unknowns, if there is a ray.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    patch: tuple[complex, ...] | None
    width: int

    @property
    def is_whole(self) -> bool:
        return len(self.columns) == self.width

    def matrix(self, ring: Ring, entries: Sequence[Number]) -> Any:
        """The square part, with the patch, of dF/dz given row by row."""
        chosen = (
            entries
            if self.is_whole
            else [entries[i * self.width + j] for i in self.rows for j in self.columns]
        )
        n = len(self.columns)
        return ring.matrix(n, n, [*chosen, *self.patch_row(ring)])

    def patch_row(self, ring: Ring) -> list[Number]:
        if self.patch is None:
            return []
        chosen = [self.patch[j] for j in self.columns]
        return [
            ring.number(p.real) if ring.is_real else ring.number(p.real, p.imag) for p in chosen
        ]


def _exact(ring: Ring, value: complex) -> Number:
    return ring.number(value.real) if ring.is_real else ring.number(value.real, value.imag)


@dataclass(frozen=True, eq=False)
class Box:
    """|Re|, |Im| of (z_j - centre_j) at most `radius` (z_j = centre_j = 0 where the chart says so):
    one root, regular. For a real ring the box and the root are real. `point` is the centre in
    double precision, up to `rounding`.
    """

    chart: Chart
    ring: Ring
    bits: int
    centre: tuple[Number, ...]
    radius: float
    point: np.ndarray
    rounding: float

    @cached_property
    def balls(self) -> list[Number]:
        """The box as one ball (a square in the complex plane) for each unknown."""
        with precision(self.bits):
            return _boxed(self.chart, self.ring, self.centre, self.radius)

    def conjugate(self) -> Box:
        """The box of the conjugate points: where F has real coefficients, what holds of one holds
        of the other.
        """
        chart = self.chart
        patch = None if chart.patch is None else tuple(p.conjugate() for p in chart.patch)
        centre = self.centre if self.ring.is_real else tuple(c.conjugate() for c in self.centre)
        return replace(
            self, chart=replace(chart, patch=patch), centre=centre, point=np.conj(self.point)
        )


def box_about(ring: Ring, centre: np.ndarray, radius: float) -> Box:
    """A box of all unknowns that is proved elsewhere, about a point (width,) in double
    precision.
    """
    width = len(centre)
    chart = Chart((), tuple(range(width)), None, width)
    return Box(
        chart, ring, _BITS, tuple(_exact(ring, v) for v in centre.tolist()), radius, centre, 0.0
    )


def enclose(
    balls: BallSystem,
    chart: Chart,
    ring: Ring,
    point: np.ndarray,
    bits: int,
    inverse: np.ndarray | None = None,
) -> Box | None:
    """A box with exactly one root near a point (width,), or None. `inverse` is about that of the
    chart's matrix; without it the point is refined by Newton at the given precision.
    """
    with precision(bits):
        centre = [_exact(ring, v) for v in point.tolist()]
        for j in set(range(chart.width)).difference(chart.columns):
            centre[j] = ring.number(0)
        if inverse is None:
            centre, matrix = _refine(balls, chart, ring, centre)
        else:
            matrix = _from_numpy(ring, inverse)
        box = None if matrix is None else _krawczyk(balls, chart, ring, centre, matrix)
        return box if box is None or chart.is_whole or _is_alone(balls, box) else None


def _krawczyk(
    balls: BallSystem, chart: Chart, ring: Ring, centre: Sequence[Number], inverse: Any
) -> Box | None:
    n = len(chart.columns)
    step = inverse * ring.column(_chosen_rows(balls, chart, ring, centre))
    radius = _INFLATION * max(upper(s) for s in step.entries()) + 2.0**-ctx.prec
    for _ in range(3):
        if not radius < _WIDEST:
            return None
        box = _boxed(chart, ring, centre, radius)
        error = _identity(ring, n) - inverse * chart.matrix(ring, balls.jacobian(ring, box))
        image = error * ring.column([ring.around_zero(radius)] * n) - step
        if ring.column([ring.around_zero(_INSIDE * radius)] * n).contains(image):
            return Box(chart, ring, ctx.prec, tuple(centre), radius, *_in_doubles(ring, centre))
        radius *= 10.0
    return None


def _in_doubles(ring: Ring, centre: Sequence[Number]) -> tuple[np.ndarray, float]:
    """The centre in double precision, and a bound of what that leaves out."""
    if ring.is_real:
        point = np.array([float(c) for c in centre], dtype=complex)
    else:
        point = np.array([complex(float(c.real), float(c.imag)) for c in centre])
    rest = [c - _exact(ring, v) for c, v in zip(centre, point.tolist(), strict=True)]
    return point, 0.0 if all(r == 0 for r in rest) else max(upper(r) for r in rest)


def _refine(
    balls: BallSystem, chart: Chart, ring: Ring, centre: list[Number]
) -> tuple[list[Number], Any]:
    """Newton's method on midpoints at the present precision; the centre and the last inverse, None
    if it does not settle.
    """
    inverse, last = None, _NEARLY_THERE
    for _ in range(_REFINEMENTS):
        inverse = chart.matrix(ring, balls.jacobian(ring, centre)).mid().inv(nonstop=True).mid()
        step = (inverse * ring.column(_chosen_rows(balls, chart, ring, centre))).entries()
        size = max(upper(s) for s in step)
        if not size < 1.0:
            return centre, None
        for j, s in zip(chart.columns, step, strict=True):
            centre[j] = (centre[j] - s).mid()
        if size < 2.0 ** (-0.6 * ctx.prec) or 0.5 * last < size < _NEARLY_THERE:
            break
        last = size
    return centre, inverse


def _chosen_rows(
    balls: BallSystem, chart: Chart, ring: Ring, centre: Sequence[Number]
) -> list[Number]:
    """F at the centre; the patch goes through the centre."""
    f = balls.rows(ring, centre)
    return [
        *(f if chart.is_whole else [f[i] for i in chart.rows]),
        *([] if chart.patch is None else [ring.number(0)]),
    ]


def _boxed(chart: Chart, ring: Ring, centre: Sequence[Number], radius: float) -> list[Number]:
    side = ring.around_zero(radius)
    if chart.is_whole:
        return [c + side for c in centre]
    return [c + side if j in chart.columns else c for j, c in enumerate(centre)]


@lru_cache(maxsize=64)
def _identity(ring: Ring, n: int) -> Any:
    return ring.matrix(n, n, [int(i == j) for i in range(n) for j in range(n)])


def _from_numpy(ring: Ring, a: np.ndarray) -> Any:
    rows, columns = a.shape
    real = arb_mat(rows, columns, a.real.ravel().tolist())
    if ring.is_real:
        return real
    return acb_mat(real) + acb_mat(arb_mat(rows, columns, a.imag.ravel().tolist())) * ring.number(
        0, 1
    )


# --- more rows than unknowns ----------------------------------------------------------------------


def chart_of(balls: BallSystem, point: np.ndarray) -> Chart | None:
    """A square part of the rows whose roots near the point are roots of all of them.

    It is all rows where they are as many as the unknowns. Else a part of the ray must be zero, so
    that rows vanish identically and leave as many as unknowns: a planar mechanism in space. The
    evaluation over a box about the point must give exact zeros. None where nothing of the kind is
    found.
    """
    ray, width = balls.system.projective, balls.width
    patch = None
    if ray:
        among = set(ray)
        patch = tuple(v.conjugate() if j in among else 0j for j, v in enumerate(point.tolist()))
    if balls.count == balls.freedom:
        return Chart(balls.all_rows, balls.all_columns, patch, width)
    zeros = [j for j in ray if abs(point[j]) < _NEARLY_ZERO]
    for lost in (0, 1, 2):
        for kept in combinations(zeros, len(zeros) - lost) if lost < len(zeros) else ():
            columns = tuple(j for j in range(width) if j not in kept)
            rows = _rows_left(balls, point, columns)
            if len(rows) == len(columns) - bool(ray):
                return Chart(rows, columns, patch, width)
    return None


def _rows_left(balls: BallSystem, point: np.ndarray, columns: tuple[int, ...]) -> tuple[int, ...]:
    with precision(64):
        side = COMPLEX.around_zero(_WIDEST)
        box = [
            COMPLEX.number(complex(v)) + side if j in columns else COMPLEX.number(0)
            for j, v in enumerate(point)
        ]
        # balls: true only of an exact zero
        vanishes = [bool(f == 0) for f in balls.rows(COMPLEX, box)]
        return tuple(i for i, zero in enumerate(vanishes) if not zero)


def _is_alone(balls: BallSystem, box: Box) -> bool:
    """Whether all rows together have no second root in the box widened to all unknowns: some L
    makes the norm of 1 - L F'(X) less than one, so that F is one to one there.
    """
    chart, ring, width = box.chart, box.ring, box.chart.width
    side = ring.around_zero(box.radius)
    whole = Chart((), tuple(range(width)), chart.patch, width)
    entries = [*balls.jacobian(ring, [c + side for c in box.centre]), *whole.patch_row(ring)]
    rows = len(entries) // width
    middle = np.array([complex(v) for v in entries]).reshape(rows, width)
    left = _from_numpy(ring, np.linalg.pinv(middle.real if ring.is_real else middle))
    error = _identity(ring, width) - left * ring.matrix(rows, width, entries)
    return bool(
        ring.column([ring.around_zero(_INSIDE * box.radius)] * width).contains(
            error * ring.column([side] * width)
        )
    )
