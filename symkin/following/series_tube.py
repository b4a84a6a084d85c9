"""Prove a step near a singularity by power series, where the plain tubes of `step_certificate` are
too short.

With a small singular value r of dG/dz at the middle of a step, the plain tube's box has one width
in all unknowns that move, and bounds of second order: its length is about r. Here the box is a
parallelepiped L [-b, b], L the right singular vectors of dG/dz, thin in all directions but those
that the small singular values belong to, and along the curve p

    N G(p(t)) = sum N G_k t^k,    N [dG/dy (p(t) + L b)] L = sum N J_k L t^k,    k = 0 ... K,

with power series over balls, the last coefficients over the whole tube. Krawczyk's operator in the
coordinates of the parallelepiped, -N G + (1 - N [dG/dy L; e L]) b, N about the inverse of [dG/dy;
e] L, then proves the same as for a plain tube (Krawczyk 1969; parallelepipeds against wrapping as
in Lohner 1987; series with remainders as in Makino and Berz 2003).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_series, ctx

from symkin.computed_once import cached_property
from symkin.following.ball_matrices import identity, inverse_with, matrix
from symkin.following.cubic import Cubic
from symkin.following.step_certificate import HELD_WIDTH, LARGEST_FILL, Interval, Tube
from symkin.numeric.balls import UP, precision, upper

_BITS = 96
"""Precision of the balls: coefficients of order 8 lose digits by cancellation."""
_ORDER = 8
"""K: the order of the remainders."""
_TRIALS = 6
"""Boxes tried for one tube."""


def series_tube(interval: Interval, curve: Cubic, *ends: np.ndarray | None) -> Tube | None:
    """A tube over the path parameter about a curve, or None where none is proved; `ends` are half
    widths of boxes that it must hold. Rows as many as unknowns only, and without roots and arc
    tangents.
    """
    if any(half is None for half in ends) or not (
        interval.system.is_square and interval.system.has_series
    ):
        return None
    n, middle = len(curve.control[0]), curve.at(0.5)
    direction = np.append(np.zeros(n - 1), 1.0)
    jacobian = interval.evaluate(middle)[1]
    inverse = inverse_with(jacobian, direction)
    if inverse is None:
        return None
    frame = np.eye(n)
    frame[:-1, :-1] = np.linalg.svd(jacobian[:, :-1])[2].T
    least = np.zeros(n)
    for end in ends:
        if end is not None:
            least = np.maximum(least, 2.0 * np.abs(frame.T) @ end)
    least[-1] = HELD_WIDTH
    with precision(_BITS), _series_of(_ORDER + 1):
        proof = _Proof(interval, curve, frame, frame.T @ inverse)
        half = np.maximum(1.5 * proof.drift, least)
        for _ in range(_TRIALS):
            image = proof.image(half)
            if not np.isfinite(image).all() or float(np.max(half)) > 1.0:
                return None
            if (image <= LARGEST_FILL * half).all():
                return Tube(half, float(np.max(image / half)), frame)
            half = np.maximum(np.maximum(1.5 * image, 0.5 * half), least)
            half[-1] = HELD_WIDTH
    return None


@contextmanager
def _series_of(length: int) -> Iterator[None]:
    before = ctx.cap
    ctx.cap = length
    try:
        yield
    finally:
        ctx.cap = before


class _Proof:
    """The operator over one curve, as bounds in the coordinates of the parallelepiped. The curve's
    parameter runs from -1/2 to 1/2.
    """

    def __init__(
        self, interval: Interval, curve: Cubic, frame: np.ndarray, inverse: np.ndarray
    ) -> None:
        self.interval, self.n = interval, len(frame)
        self.frame = matrix(frame)
        self.spread = np.abs(frame)
        self.inverse = matrix(inverse)
        a, b, c, d = ([arb(float(v)) for v in row] for row in curve.control)
        self.about_middle = [
            [
                (p + 3 * q + 3 * r + s) / 8,
                (s + r - q - p) * 3 / 4,
                (p - q - r + s) * 3 / 2,
                s - 3 * r + 3 * q - p,
            ]
            for p, q, r, s in zip(a, b, c, d, strict=True)
        ]
        place = arb(0, 0.5)
        self.anywhere = [
            [
                w[0] + place * (w[1] + place * (w[2] + place * w[3])),
                w[1] + place * (2 * w[2] + place * 3 * w[3]),
                w[2] + 3 * place * w[3],
                w[3],
            ]
            for w in self.about_middle
        ]

    @cached_property
    def drift(self) -> np.ndarray:
        """Upper bounds (n,) of |N G(p(t))|."""
        return self._bound([self._times(column) for column in self._columns(0, np.zeros(self.n))])

    def image(self, half: np.ndarray) -> np.ndarray:
        """Upper bounds (n,) of |K| over a parallelepiped of these half widths."""
        ball = arb_mat(self.n, 1, [arb(0, v) for v in half.tolist()])
        moved = []
        for k, slope in enumerate(self._columns(1, half)):
            rows = arb_mat(
                self.n,
                self.n,
                [*slope, *([int(k == 0 and j == self.n - 1) for j in range(self.n)])],
            )
            through = self.inverse * (rows * self.frame)
            moved.append((identity(self.n) - through if k == 0 else through) * ball)
        return np.asarray((self.drift + self._bound(moved)) * UP)

    def _columns(self, part: int, half: np.ndarray) -> list[list[Any]]:
        """Coefficients 0 to K of all entries of G (part 0) or dG/dy (part 1), the last one over the
        whole tube.
        """
        wide = [arb(0, float(v) * UP) for v in self.spread @ half]
        thin, whole = (
            self.interval.series(
                part, [arb_series([w[0] + r, *w[1:]]) for w, r in zip(jets, wide, strict=True)]
            )
            for jets in (self.about_middle, self.anywhere)
        )
        columns = [[_coefficient(entry, k) for entry in thin] for k in range(_ORDER)]
        return [*columns, [_coefficient(entry, _ORDER) for entry in whole]]

    def _times(self, column: list[Any]) -> arb_mat:
        lifted: arb_mat = self.inverse * arb_mat(self.n, 1, [*column, arb(0)])
        return lifted

    def _bound(self, columns: list[arb_mat]) -> np.ndarray:
        """sum |column k| / 2^k, rounded upwards."""
        parts = [
            np.array([upper(v) for v in column.entries()]) * 0.5**k
            for k, column in enumerate(columns)
        ]
        return np.asarray(sum(parts[1:], parts[0]) * (1.0 + 2.0**-44))


def _coefficient(entry: Any, k: int) -> Any:
    """Coefficient k of what the evaluation gives for an entry: a series, or a constant."""
    if isinstance(entry, arb_series):
        return entry[k]
    return entry if k == 0 else 0
