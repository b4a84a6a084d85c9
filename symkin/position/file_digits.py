"""Loops that close only to the digits of a file: where least squares from random steps off the
reference ends, and the rank there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import NOTHING, System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION

FILE_DIGITS = 1e-5
"""Of the size: loops that leave less at least-squares configurations are closed to the digits of a
file; and the share of the largest singular value below which others are zero to these digits. Files
are written with five digits and more.
"""
_CLEAR_DROP = 2e-2
"""Of the smallest singular value that counts: what the next one has at most where a rank to the
digits of a file is clear.
"""
BLUR = 30.0
"""Singular values that are zero but for a misfit, over it (a share of the size): what loops are
larger than their shortest links.
"""
_STARTS, _FEW_STARTS, _MANY_FREEDOMS = 8, 2, 40
"""Random steps of each of three lengths; of a mechanism of many freedoms, whose single steps take
long, fewer.
"""


@dataclass(frozen=True)
class ToDigits:
    """What holds to the digits of a file: the largest closure error (length unit) of least-squares
    configurations, and the rank there; `beside_alone`: nothing but the reference closes exactly,
    and it is singular.
    """

    misfit: float
    rank: int
    beside_alone: bool = False


@dataclass(frozen=True, eq=False)
class LeastSquaresEnds:
    """Where least squares from random steps off the reference end: variables (n, width), what each
    leaves the loops open by (length unit), and which of them are closed configurations.
    """

    points: np.ndarray
    misfits: np.ndarray
    closed: np.ndarray


def least_squares_from(system: System, reference: np.ndarray, seed: int) -> LeastSquaresEnds:
    """Least squares on all rows from random steps of three lengths off the reference."""
    size = system.characteristic_length
    rng = np.random.default_rng(seed)
    each = _FEW_STARTS if system.freedom > _MANY_FREEDOMS else _STARTS
    begin = np.tile(reference, (3 * each, 1))
    radii = np.repeat([0.03, 0.1, 0.3], each)[:, None] * size
    starts = system.move(begin, radii * rng.normal(size=(3 * each, system.freedom)))
    batch = levenberg_marquardt(system, starts, NOTHING, max_iterations=200)
    points = system.polish_many(batch.points).points
    misfits = system.residuals(points)
    closed = batch.converged & (misfits <= CLOSED_CONFIGURATION * size)
    return LeastSquaresEnds(points, misfits, closed)


def rank_to_digits(system: System, ends: LeastSquaresEnds, rank: int | None) -> ToDigits | None:
    """What holds at ends that close the loops only to the digits of a file, where more moves there
    than exactly (`rank`), or where nothing closes exactly, or nothing but a singular reference, at
    which more moves than beside it.
    """
    size, misfits = system.characteristic_length, ends.misfits
    near = np.flatnonzero((misfits > CLOSED_CONFIGURATION * size) & (misfits <= FILE_DIGITS * size))
    if not near.size:
        return None
    _, jacobians = system.linearise(ends.points[near])
    values = np.linalg.svd(jacobians, compute_uv=False)
    zero = np.maximum(FILE_DIGITS, BLUR * misfits[near] / size)[:, None] * values[:, :1]
    counts = np.sum(values > zero, axis=1)
    found, misfit = int(np.median(counts)), float(misfits[near].max())
    if rank is None or found < rank:
        return ToDigits(misfit, found)
    clear = [] if ends.closed.any() else _clear(values, counts)
    found = max(set(clear), key=clear.count, default=rank)
    return ToDigits(misfit, found, beside_alone=True) if found > rank else None


def _clear(values: np.ndarray, counts: np.ndarray) -> list[int]:
    """The ranks of those configurations at which the singular values that count are far from those
    that do not.
    """
    padded = np.hstack([values, np.zeros((len(values), 1))])
    rows = np.arange(len(values))
    dropped, kept = padded[rows, counts], padded[rows, np.maximum(counts - 1, 0)]
    return [int(count) for count in counts[dropped <= _CLEAR_DROP * kept]]
