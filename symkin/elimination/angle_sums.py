"""Find which angles that follow each other may stand as sums in rows: those of parallel axes.

Of two angles a, b the rows of parallel axes hold cosines and sines of m a + n b with m and n of one
sign, cos a and cos(a + b) among them, or, where the axes point opposite ways or the loop passes one
joint backwards, of two signs alone; those of other axes hold products such as cos a cos b, half of
which is cos(a - b). The Fourier coefficients of the rows over both angles tell it, far sooner than
their terms in the sums do.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import accumulate, pairwise, product
from operator import mul

import casadi as ca
import numpy as np

from symkin.numeric.system import System

_MOST_SUMMED = 4
"""Angles of a block of which sums are looked for: each more doubles the terms that are compared."""
_POINTS = 9
"""Points of a turn, which tell multiples of an angle up to the fourth."""
_ROUNDING = 1e-9
"""Share of a row's largest Fourier coefficient below which one is zero."""


Sums = dict[int, tuple[int, float]]
"""Of each angle that stands in a sum the angle before it, and by which sign it is added to the sum
up to there.
"""


def angle_sums(system: System, rows: ca.SX, known: np.ndarray) -> Iterator[Sums]:
    """Ways in which angles may be summed: not at all, and runs of two and more of which no two
    neighbours contradict it, at these known values.
    """
    yield {}
    angles = [k for k, c in enumerate(system.unknowns) if c.is_angular]
    if len(angles) > _MOST_SUMMED:
        return
    function = ca.Function("rows", [system.unknown, system.known], [ca.densify(rows)])
    alike = {pair: _signs(function, system, known, pair) for pair in pairwise(angles)}
    for i in range(len(angles)):
        for j in range(i + 2, len(angles) + 1):
            pairs = list(pairwise(angles[i:j]))
            for signs in product(*(alike[pair] for pair in pairs)):
                whole = accumulate(signs, mul)
                yield {
                    after: (before, sign)
                    for (before, after), sign in zip(pairs, whole, strict=True)
                }


def _signs(
    function: ca.Function, system: System, known: np.ndarray, pair: tuple[int, int]
) -> tuple[float, ...]:
    """The signs, of one angle over the other, by which alone some row depends on multiples of both
    together.
    """
    scale = [np.pi if c.is_angular else system.characteristic_length for c in system.unknowns]
    start = np.random.default_rng(0).uniform(-1.0, 1.0, system.width) * scale
    turns = 2.0 * np.pi * np.arange(_POINTS) / _POINTS
    points = np.repeat(start[:, None], _POINTS**2, axis=1)
    points[list(pair)] = [grid.ravel() for grid in np.meshgrid(turns, turns, indexing="ij")]
    values = np.asarray(function(points, np.repeat(known[:, None], _POINTS**2, axis=1)))
    found = np.abs(np.fft.fft2(values.reshape(-1, _POINTS, _POINTS)))
    if not np.all(np.isfinite(found)):
        return (1.0,)
    multiples = np.fft.fftfreq(_POINTS)
    sign = np.sign(np.outer(multiples, multiples))
    least = _ROUNDING * np.max(found, axis=(1, 2))
    alike, unlike = (np.max(found * (sign == s), axis=(1, 2)) > least for s in (1.0, -1.0))
    alone = {1.0: alike & ~unlike, -1.0: unlike & ~alike}
    return tuple(s for s, rows_of_it in alone.items() if np.any(rows_of_it))
