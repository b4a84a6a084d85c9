"""Numerical rank, judged by singular values, with the gap that supports the judgement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.tolerances import RANK_TOLERANCE


@dataclass(frozen=True)
class Rank:
    """Rank of a matrix and the ratio of the singular values on both sides of the cut (infinite where it is clear)."""

    value: int
    gap: float

    @staticmethod
    def of(matrix: np.ndarray) -> Rank:
        if min(matrix.shape) == 0 or not np.all(np.isfinite(matrix)):
            return Rank(0, float("inf"))
        s = np.linalg.svd(matrix, compute_uv=False)
        kept = int(np.sum(s > RANK_TOLERANCE * max(float(s[0]), float(np.finfo(float).tiny))))
        dropped = float(s[kept]) if kept < len(s) else 0.0
        return Rank(kept, float(s[kept - 1]) / dropped if kept and dropped > 0.0 else float("inf"))
