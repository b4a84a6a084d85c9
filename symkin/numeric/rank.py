"""Rank, and what goes with it: null space, row space, rows that span the others.

Singular values decide: those up to a bound count as zero. The bound is absolute, or a share of the
largest one (`relative`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from symkin.numeric.linear_algebra import diagonal_parts, singular_values
from symkin.numeric.tolerances import RANK_TOLERANCE

_TINY = float(np.finfo(float).tiny)
_ROUNDED = 1e-6
"""Share by which lengths of rows may differ and count as equal."""
_CLEAR, _CLEAR_GAP = 1e-4, 1e6
"""Smallest singular value that counts, over the largest, at a point that is not nearly singular;
and over the next one that does not.
"""


@dataclass(frozen=True)
class Rank:
    """Rank of a matrix, the ratio of the singular values on both sides of the cut (infinite where
    it is clear), and the smallest one that counts as a share of the largest.
    """

    value: int
    gap: float
    least: float = 1.0

    @property
    def is_clear(self) -> bool:
        """Whether the cut is far from the singular values on both its sides."""
        return self.least >= _CLEAR and self.gap >= _CLEAR_GAP

    @staticmethod
    def of(matrix: np.ndarray, share: float = RANK_TOLERANCE) -> Rank:
        """Count the singular values above a share of the largest."""
        if min(matrix.shape) == 0 or not np.all(np.isfinite(matrix)):
            return Rank(0, float("inf"))
        s = singular_values(matrix)
        kept = count_above(s, share, relative=True)
        dropped = float(s[kept]) if kept < len(s) else 0.0
        least = float(s[kept - 1] / s[0]) if kept else 1.0
        return Rank(
            kept, float(s[kept - 1]) / dropped if kept and dropped > 0.0 else float("inf"), least
        )


def generic(ranks: Sequence[Rank]) -> int:
    """Which of the ranks at several points of a solution set is the generic one: the largest of
    those that are clear of the points' own errors, else the largest. A point that should be
    singular is found to the root of rounding only, and its rank is too large.
    """
    return max(range(len(ranks)), key=lambda k: (ranks[k].least >= _CLEAR, ranks[k].value))


def count_above(singular: np.ndarray, bound: float, *, relative: bool = False) -> int:
    """Count singular values, in falling order, above a bound or above a share of the largest."""
    largest = max(float(singular[0]), _TINY) if relative and len(singular) else 1.0
    return int(np.sum(singular > bound * largest))


def rank_of(matrix: np.ndarray, bound: float, *, relative: bool = False) -> int:
    """Count the singular values of a matrix above a bound or above a share of the largest."""
    if min(matrix.shape) == 0:
        return 0
    return count_above(singular_values(matrix), bound, relative=relative)


def null_space(
    matrix: np.ndarray, bound: float, *, relative: bool = False, least: int = 0
) -> np.ndarray:
    """Orthonormal rows n with matrix n = 0; at least so many, those of the smallest singular
    values.
    """
    if not len(matrix):
        return np.eye(matrix.shape[1])
    parts = diagonal_parts(matrix[None])
    if parts and not least:
        return _null_space_of_parts(matrix, parts, bound, relative=relative)
    _, singular, right = np.linalg.svd(matrix)
    return right[min(count_above(singular, bound, relative=relative), len(right) - least) :]


def row_space(matrix: np.ndarray, bound: float, *, relative: bool = False) -> np.ndarray:
    """Orthonormal rows of the same span."""
    _, singular, right = np.linalg.svd(matrix, full_matrices=False)
    return right[: count_above(singular, bound, relative=relative)]


def _null_space_of_parts(
    matrix: np.ndarray,
    parts: list[tuple[np.ndarray, np.ndarray]],
    bound: float,
    *,
    relative: bool,
) -> np.ndarray:
    if relative:
        bound *= max(float(singular_values(matrix)[0]), _TINY)
    found = [np.zeros((0, matrix.shape[1]))]
    for rows, columns in parts:
        for own, places in zip(rows, columns, strict=True):
            left = null_space(matrix[np.ix_(own, places)], bound)
            found.append(np.zeros((len(left), matrix.shape[1])))
            found[-1][:, places] = left
    return np.vstack(found)


# --- rows that span the others --------------------------------------------------------------------


def independent_rows(
    matrix: np.ndarray,
    least: float,
    *,
    groups: Iterable[int | Sequence[int]] | None = None,
    most: int | None = None,
) -> list[int]:
    """Choose rows that span the others, in the order in which they are taken: of each group in turn
    (a row by itself, or several; all rows are one group if none are given) that row which is
    farthest from those taken, as long as this is more than `least`; `most` at most.
    """
    left, chosen = matrix[None], list[int]()
    most = min(matrix.shape) if most is None else most
    for group in [range(len(matrix))] if groups is None else groups:
        among = np.atleast_1d(group)
        while len(among) and len(chosen) < most:
            lengths = np.linalg.norm(left[0, among], axis=1)
            best = _first_of_longest(lengths)
            if not lengths[best] > least:
                break
            chosen.append(int(among[best]))
            left = _without(left, among[best : best + 1])
            among = np.delete(among, best)
    return chosen


def most_independent(
    matrices: np.ndarray, most: int, least: float = RANK_TOLERANCE, *, together: bool = False
) -> np.ndarray:
    """Choose rows (m, rows), at most so many, of each of some matrices (m, rows, columns): one
    after another the row that is farthest from the span of those taken, while this is more than a
    share of the first one's length; `together` the same rows of all, by the matrix in which they
    are nearest to that span.
    """
    every, going = np.arange(len(matrices)), np.isfinite(matrices).all(axis=(1, 2))
    left, first = np.where(going[:, None, None], matrices, 0.0), np.zeros(len(matrices))
    taken = np.zeros(left.shape[:2], dtype=bool)
    for step in range(most):
        lengths = np.where(taken, -1.0, np.linalg.norm(left, axis=2))
        judged = np.broadcast_to(lengths.min(axis=0), lengths.shape) if together else lengths
        best = _first_of_longest(judged)
        longest = lengths[every, best]
        first = longest if step == 0 else first
        going &= longest > least * np.maximum(first, _TINY)
        if not going.any():
            break
        taken[every[going], best[going]] = True
        left = _without(left, best)
    return taken


def _first_of_longest(lengths: np.ndarray) -> np.ndarray:
    """The place of the largest along the last axis; of those that are equal but for rounding, the
    first.
    """
    longest = lengths.max(axis=-1, keepdims=True)
    return np.asarray(np.argmax(lengths >= (1.0 - _ROUNDED) * longest, axis=-1))


def _without(matrices: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Matrices (m, rows, columns) without their rows' parts along one row of each, twice: once
    leaves rounding of what was taken away.
    """
    along = matrices[np.arange(len(matrices)), rows]
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), _TINY)
    for _ in range(2):
        matrices = matrices - (matrices @ along.conj()[:, :, None]) * along[:, None]
    return matrices
