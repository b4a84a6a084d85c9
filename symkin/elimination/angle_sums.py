"""Find which angles that follow each other may stand as sums in rows: those of parallel axes.

Of two angles a, b the rows of parallel axes hold cosines and sines of m a + n b with m and n of one
sign, cos a and cos(a + b) among them; those of other axes hold products such as cos a cos b, half
of which is cos(a - b). The Fourier coefficients of the rows over both angles tell it, far sooner
than their terms in the sums do.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import casadi as ca
import numpy as np

from symkin.numeric.system import System

_MOST_SUMMED = 4
"""Angles of a block of which sums are looked for: each more doubles the terms that are compared."""
_POINTS = 9
"""Points of a turn, which tell multiples of an angle up to the fourth."""
_ROUNDING = 1e-9
"""Share of a row's largest Fourier coefficient below which one is zero."""


def angle_sums(system: System, rows: ca.SX, known: np.ndarray) -> Iterator[dict[int, int]]:
    """Ways in which angles may be summed, before each the one that its sum goes on from: none, and
    runs of two and more of which no two neighbours contradict it, at these known values.
    """
    yield {}
    angles = [k for k, c in enumerate(system.unknowns) if c.is_angular]
    if len(angles) > _MOST_SUMMED:
        return
    function = ca.Function("rows", [system.unknown, system.known], [ca.densify(rows)])
    summed = {pair for pair in pairwise(angles) if _may_be_summed(function, system, known, pair)}
    for i in range(len(angles)):
        for j in range(i + 2, len(angles) + 1):
            pairs = list(pairwise(angles[i:j]))
            if summed.issuperset(pairs):
                yield {after: before for before, after in pairs}


def _may_be_summed(
    function: ca.Function, system: System, known: np.ndarray, pair: tuple[int, int]
) -> bool:
    """Whether some row depends on both angles together by multiples of one sign alone."""
    scale = [np.pi if c.is_angular else system.characteristic_length for c in system.unknowns]
    start = np.random.default_rng(0).uniform(-1.0, 1.0, system.width) * scale
    turns = 2.0 * np.pi * np.arange(_POINTS) / _POINTS
    points = np.repeat(start[:, None], _POINTS**2, axis=1)
    points[list(pair)] = [grid.ravel() for grid in np.meshgrid(turns, turns, indexing="ij")]
    values = np.asarray(function(points, np.repeat(known[:, None], _POINTS**2, axis=1)))
    found = np.abs(np.fft.fft2(values.reshape(-1, _POINTS, _POINTS)))
    if not np.all(np.isfinite(found)):
        return True
    multiples = np.fft.fftfreq(_POINTS)
    sign = np.sign(np.outer(multiples, multiples))
    least = _ROUNDING * np.max(found, axis=(1, 2))
    alike, unlike = (np.max(found * (sign == s), axis=(1, 2)) > least for s in (1.0, -1.0))
    return bool(np.any(alike & ~unlike))
