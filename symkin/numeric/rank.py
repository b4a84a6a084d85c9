"""Numerical rank, judged by singular values, with the gap that supports the judgement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.numeric.linear_algebra import singular_values
from symkin.numeric.tolerances import RANK_TOLERANCE

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
        kept = int(np.sum(s > share * max(float(s[0]), float(np.finfo(float).tiny))))
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
