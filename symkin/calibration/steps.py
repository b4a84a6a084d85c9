"""Steps of the least-squares iteration, and what of the parameters the readings and the closure leave to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.numeric.rank import RANK_TOLERANCE

if TYPE_CHECKING:
    from symkin.calibration.state import State

_USUAL = 30.0
"""Columns up to so many times as long as the median one are as they are where rank is judged; longer ones are made so long."""


def damped_step(state: State, null_space: np.ndarray, damping: float, curved: np.ndarray | None = None) -> np.ndarray:
    """Minimise |r + J d|^2 + damping |D d|^2, D the columns' lengths, with no motion in the null space and the leftover
    rows met. With `curved`, second derivatives of the residuals along a step, its acceleration: |curved + J d|^2 instead."""
    matrix, right = state.fit.matrix, -(state.fit.vector if curved is None else curved)
    basis, particular = admitted(state, null_space)
    particular = particular if curved is None else np.zeros(matrix.shape[1])
    if basis is not None:
        matrix, right = matrix @ basis, right - matrix @ particular
    width = matrix.shape[1]
    triangle = np.asarray(np.linalg.qr(np.column_stack([matrix, right]), mode="r"))
    r, b = triangle[:width, :width], triangle[:width, width]
    if not np.all(np.isfinite(triangle)):
        return np.full(state.fit.matrix.shape[1], np.inf)
    if damping > 0.0:
        norms = np.linalg.norm(r, axis=0)
        lengths = np.maximum(norms, 1e-6 * np.max(norms, initial=0.0))
        above = np.vstack([r, np.sqrt(damping) * np.diag(lengths)])
        solution = np.linalg.lstsq(above, np.concatenate([b, np.zeros(width)]), rcond=None)[0]
    elif r.shape[0] < width or np.min(np.abs(np.diag(r)), initial=np.inf) == 0.0:
        solution = np.linalg.lstsq(r, b, rcond=None)[0]
    else:
        solution = np.linalg.solve(r, b)
    return np.asarray(solution if basis is None else particular + basis @ solution)


def admitted(state: State, null_space: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Basis of the steps that are allowed and one step that meets the leftover rows: all steps where it is None."""
    count = state.fit.matrix.shape[1]
    zero = np.zeros(count)
    if state.leftover is None and null_space.shape[1] == 0:
        return None, zero
    rows, right = null_space.T, np.zeros(null_space.shape[1])
    if state.leftover is not None:
        rows = np.vstack([rows, state.leftover[1].reshape(-1, count)])
        right = np.concatenate([right, -state.leftover[0].reshape(-1)])
    left, singular, across = np.linalg.svd(rows, full_matrices=True)
    kept = int(np.sum(singular > max(RANK_TOLERANCE * float(singular[0]), 1e-9))) if len(singular) else 0
    particular = across[:kept].T @ ((left[:, :kept].T @ right) / singular[:kept])
    return across[kept:].T, particular


def design(state: State) -> np.ndarray:
    """dr/dp of the readings, with the rows that an overconstrained closure leaves to p above them."""
    if state.leftover is None:
        return state.fit.matrix
    rows = state.leftover[1].reshape(-1, state.fit.matrix.shape[1])
    return np.vstack([constraint_rows(rows, state), state.fit.matrix])


def constraint_rows(rows: np.ndarray, state: State) -> np.ndarray:
    """Orthonormal rows of the space that the leftover rows span, times the largest column of the readings."""
    _, singular, right = np.linalg.svd(rows, full_matrices=False)
    kept = (
        right[singular > RANK_TOLERANCE * max(float(singular[0]), 1e-300)] if len(singular) and singular[0] > 1e-9 else right[:0]
    )
    return np.asarray(np.max(np.linalg.norm(state.fit.matrix, axis=0), initial=0.0) * kept)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Singular values (P,) of a matrix with P columns, and its rank, null space (P, k) and told directions (P, P - k), judged with
    very long columns made shorter: what is small beside an angle at a lever of kilometres is not rounding. `gap` is the
    ratio of the singular values so judged on both sides of the rank, infinite where nothing is dropped."""

    values: np.ndarray
    null_space: np.ndarray
    told: np.ndarray
    gap: float

    @property
    def rank(self) -> int:
        return int(self.told.shape[1])


def spectrum(matrix: np.ndarray, tolerance: float = RANK_TOLERANCE) -> Spectrum:
    """Rank and null space of a matrix. The null space has orthonormal columns; those of `told` are orthogonal to it and map to
    orthogonal ones."""
    if matrix.shape[0] > matrix.shape[1]:
        matrix = np.asarray(np.linalg.qr(matrix, mode="r"))
    width = matrix.shape[1]
    lengths = _at_least_usual(np.linalg.norm(matrix, axis=0))
    (values, right), (even, across) = (_singular(m) for m in (matrix, matrix / lengths))
    rank = _rank(even, tolerance)
    dropped = float(even[rank]) if rank < width else 0.0
    directions = across.T / lengths[:, None]
    null_space = right[rank:].T if _rank(values, tolerance) == rank else np.linalg.qr(directions[:, rank:])[0]
    told = directions[:, :rank] - null_space @ (null_space.T @ directions[:, :rank])
    return Spectrum(values, null_space, told, float(even[rank - 1]) / dropped if rank and dropped > 0.0 else float("inf"))


def _singular(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Singular values (P,) and right singular vectors as rows (P, P)."""
    _, values, right = np.linalg.svd(matrix, full_matrices=True)
    return np.concatenate([values, np.zeros(matrix.shape[1] - len(values))]), right


def _rank(values: np.ndarray, tolerance: float) -> int:
    return int(np.sum(values > tolerance * np.max(values, initial=1e-300)))


def _at_least_usual(norms: np.ndarray) -> np.ndarray:
    """Lengths of columns, those that are not much longer than the median as that; 1 where all are zero."""
    usual = _USUAL * float(np.median(norms[norms > 0.0])) if np.any(norms > 0.0) else 1.0
    return np.asarray(np.maximum(norms, usual))


def null_directions(matrix: np.ndarray, tolerance: float = RANK_TOLERANCE) -> np.ndarray:
    """Orthonormal columns (P, k) along which no residual changes, to first order."""
    return spectrum(matrix, tolerance).null_space
