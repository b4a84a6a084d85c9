"""Loops that close only to the digits of a file: where least squares from random steps off the
reference ends, and the rank there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.linear_algebra import parts_of_pattern
from symkin.numeric.nearest_root import closed_to_digits
from symkin.numeric.rank import Rank
from symkin.numeric.system import NOTHING, System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, FILE_DIGITS

_CLEAR_DROP = 2e-2
"""Of the smallest singular value that counts: what the next one has at most where a rank to the
digits of a file is clear.
"""
_OFTEN = 4
"""Of the configurations of clear rank one of so many has the generic one, at least: others lie
near singular places, and single ones in another assembly.
"""
_CLEAR_LEAST = 3e-3
"""Of the largest: what the smallest singular value that counts has at least where it is clear. At
a double point loops stay closed to digits for steps of the root of FILE_DIGITS, along which
singular values grow as much, though no motion is there.
"""
BLUR = 30.0
"""Singular values that are zero but for a misfit, over it (a share of the size): what loops are
larger than their shortest links.
"""
_WALKS, _WALK = 10, 0.1
"""Steps along what is free to digits, and their length (of the size): a few do not lead away from a
singular place, which most directions lead back to.
"""
_STARTS, _FEW_STARTS, _MANY_FREEDOMS = 8, 2, 40
"""Random steps of each of three lengths; of a mechanism of many freedoms, whose single steps take
long, fewer.
"""


@dataclass(frozen=True)
class ToDigits:
    """What holds to the digits of a file: the largest closure error (length unit) of least-squares
    configurations, and the rank there; `at_reference` is the rank at the reference where nothing
    else closes exactly at a clear rank, and it is singular.
    """

    misfit: float
    rank: int
    at_reference: int | None = None


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
    return _ends(system, system.move(begin, radii * rng.normal(size=(3 * each, system.freedom))))


def _ends(system: System, starts: np.ndarray) -> LeastSquaresEnds:
    batch = levenberg_marquardt(system, starts, NOTHING, max_iterations=200)
    points = system.polish_many(batch.points).points
    misfits = system.residuals(points)
    closed = batch.converged & (misfits <= CLOSED_CONFIGURATION * system.characteristic_length)
    return LeastSquaresEnds(points, misfits, closed)


def _walked_on(system: System, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Configurations from steps along what is free to digits at others, and their misfits, the
    least ones nearby where these do not close exactly. Singular places are left so: at generic ones
    less is free, and steps along that end at generic ones again. Those from which no step leads are
    left out: at a double point loops stay closed to digits nearby.
    """
    size, rng = system.characteristic_length, np.random.default_rng(0)
    went = np.zeros(len(points), dtype=bool)
    for _ in range(_WALKS):
        _, values, right = np.linalg.svd(system.linearise(points)[1])
        held = np.zeros(right.shape[:2], dtype=bool)
        held[:, : values.shape[1]] = values > FILE_DIGITS * values[:, :1]
        steps = rng.normal(size=held.shape) * ~held
        starts = system.move(points, _WALK * size * np.einsum("nk,nkj->nj", steps, right))
        ends = closed_to_digits(system, starts)
        near = system.residuals(ends) <= FILE_DIGITS * size
        points = np.where(near[:, None], ends, points)
        went |= near
    points = points[went]
    least = _ends(system, points)
    points = np.where(least.closed[:, None], points, least.points)
    return points, system.residuals(points)


def rank_to_digits(system: System, ends: LeastSquaresEnds, rank: int | None) -> ToDigits | None:
    """What holds at configurations that close the loops only to the digits of a file, where more
    moves there than exactly (`rank`), or where nothing closes exactly, or nothing but a singular
    reference, at which more moves than beside it.

    Loops that share no joint are judged each by itself: few ends are clear in all of them at once.
    """
    size = system.characteristic_length
    begun = ends.points[ends.misfits <= FILE_DIGITS * size]
    if not len(begun):
        return None
    points, misfits = _walked_on(system, begun)
    near = (misfits > CLOSED_CONFIGURATION * size) & (misfits <= FILE_DIGITS * size)
    if not near.any():
        return None
    points, misfits = points[near], misfits[near]
    zero = np.maximum(FILE_DIGITS, BLUR * misfits / size)
    ranks = [_generic(part, zero) for part in _parts(system.linearise(points)[1])]
    found, misfit = sum(count for count, _ in ranks), float(misfits.max())
    if rank is None or found < rank:
        return ToDigits(misfit, found)
    exact = system.linearise(ends.points[ends.closed])[1]
    alone = all(clear for _, clear in ranks) and not any(Rank.of(j).is_clear for j in exact)
    return ToDigits(misfit, found, rank) if found > rank and alone else None


def _parts(jacobians: np.ndarray) -> list[np.ndarray]:
    """The Jacobians (n, rows, columns) of loops that share no joint with others."""
    parts = parts_of_pattern((jacobians != 0.0).any(axis=0), least=0)
    return [
        jacobians[:, held[:, None], own]
        for rows, columns in parts
        for held, own in zip(rows, columns, strict=True)
        if held.size
    ] or [jacobians]


def _generic(jacobians: np.ndarray, zero: np.ndarray) -> tuple[int, bool]:
    """The largest rank of a quarter of the configurations at which the singular values that count
    are far from those that do not, shares of the largest up to `zero`: it is lost at singular
    places. Where no rank is clear and as frequent, the median and False.
    """
    values = np.linalg.svd(jacobians, compute_uv=False)
    values = np.hstack([values / values[:, :1], np.zeros((len(values), 1))])
    counts = np.sum(values > zero[:, None], axis=1)
    rows = np.arange(len(values))
    dropped, kept = values[rows, counts], values[rows, np.maximum(counts - 1, 0)]
    clear = [*counts[(dropped <= _CLEAR_DROP * kept) & (kept >= _CLEAR_LEAST)]]
    often = [c for c in clear if _OFTEN * clear.count(c) >= len(clear)]
    return (int(max(often)), True) if often else (int(np.median(counts)), False)
