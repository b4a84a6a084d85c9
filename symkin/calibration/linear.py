"""The linear model of all readings at an estimate: what chi-square is made of and outliers are found in.

The whitened residuals of all readings (joint noise included, see `residuals`) are e = (1 - Q Q^T) r with Q an orthonormal basis
of what the fit may absorb: the unknown inclination of each group and the parameters' columns. The part of the groups is block
diagonal and is kept as two columns, each group's own rows of them; the rest, orthogonal to it, is dense and as wide as there
are parameters. In the linear range |e|^2 has the chi-square distribution with as many degrees of freedom as there are readings
left, whichever form of the residuals was minimised.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from symkin.caching import cached_property
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.residuals import Readings, deviations, group_basis, group_sum, whitening
from symkin.calibration.state import State, evaluate_at, evaluate_readings, ideal_design, joint_covariance_at, slopes
from symkin.calibration.steps import spectrum
from symkin.numeric.rank import RANK_TOLERANCE

_BLOCK = 20_000
"""Rows that are multiplied at once where there are many."""


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Whitened residuals e (N,) after projection, N = n K; `own` (N, 2), the orthonormal columns of each row's group, whose
    number is `group` (N,), -1 for none; `shared` (N, k), the rest of the basis; which rows hold a reading (N,), and the
    transformation W (n, K, K) that whitened them. What is known of the parameters beside the readings stands in rows after those.
    `within_reach` is the square that the projection to the parameters' columns took away: at a minimum nothing, but for a form of
    residuals that weighs otherwise than joint noise and correlation ask."""

    residuals: np.ndarray
    own: np.ndarray
    group: np.ndarray
    shared: np.ndarray
    taken: np.ndarray
    whiten: np.ndarray
    within_reach: float = 0.0

    @cached_property
    def degrees(self) -> int:
        groups = int(np.max(self.group, initial=-1)) + 1
        return int(np.sum(self.taken)) - 2 * groups - int(self.shared.shape[1])

    @property
    def chi_square(self) -> float:
        return float(self.residuals @ self.residuals)

    @property
    def chi_square_as_is(self) -> float:
        """Of the parameters as they are, without the step that the projection stands for."""
        return self.chi_square + self.within_reach

    @property
    def absorbed(self) -> np.ndarray:
        """Share (N,) of a unit shift of each reading that the fit absorbs: the diagonal of Q Q^T."""
        return np.asarray(np.einsum("ij,ij->i", self.own, self.own) + np.einsum("ij,ij->i", self.shared, self.shared))

    def freedom(self, rows: np.ndarray) -> np.ndarray:
        """(1 - Q Q^T) restricted to some rows (..., w): what of a shift of these readings the fit cannot absorb, (..., w, w)."""
        own, shared, group = self.own[rows], self.shared[rows], self.group[rows]
        together = group[..., :, None] == group[..., None, :]
        absorbed = shared @ np.swapaxes(shared, -1, -2) + np.where(together, own @ np.swapaxes(own, -1, -2), 0.0)
        return np.asarray(self.taken[rows][..., None] * np.eye(rows.shape[-1]) - absorbed)

    def without(self, rows: np.ndarray) -> LinearModel:
        """The model in which the readings of these rows are free: their shift is one more unknown."""
        shift = -self.shared @ self.shared[rows].T
        shift -= np.where(self.group[:, None] == self.group[rows], self.own @ self.own[rows].T, 0.0)
        shift[rows, np.arange(len(rows))] += self.taken[rows]
        extra = _orthonormal(shift)
        residuals = self.residuals - extra @ (extra.T @ self.residuals)
        return replace(self, residuals=residuals, shared=np.hstack([self.shared, extra]))


def linear_model(problem: CalibrationProblem, state: State) -> LinearModel:
    """The linear model of all readings at a state with closed postures."""
    readings, free = problem.readings, admissible(problem, state)
    known, by_known = problem.prior_rows(state.p) or (np.zeros(0), np.zeros((0, len(free))))
    by_known = by_known @ free
    shape = readings.values.shape
    residuals, own, whiten = np.zeros((*shape, 1)), np.zeros((*shape, 2)), np.zeros((*shape, shape[1]))
    columns, squares = np.zeros((*shape, free.shape[1])), np.sum(by_known**2, axis=0)
    for rows, part in problem.parts:
        e = evaluate_at(part, state.p, state.z[rows])
        whiten[rows] = whitening(part.readings, joint_covariance_at(part, state.p, state.z[rows]))
        own[rows] = _group_columns(part.readings, whiten[rows])
        made, r = whiten[rows] @ (slopes(e) @ free), whiten[rows] @ deviations(part.readings, e.readings)[:, :, None]
        squares += np.sum(made**2, axis=(0, 1))
        for _ in range(2):  # the second time takes away what rounding left
            made, r = _less_groups(part.readings, own[rows], made), _less_groups(part.readings, own[rows], r)
        columns[rows], residuals[rows] = made, r
    kept, count = squares > 0, readings.values.size
    flat_columns = columns.reshape(count, -1)
    if len(known):
        flat_columns = np.vstack([flat_columns, by_known])
    if not kept.all():
        flat_columns = flat_columns[:, kept]
    flat_columns /= np.sqrt(squares[kept])
    shared = _basis_in_place(flat_columns) if problem.is_large else _basis(flat_columns)
    flat = np.concatenate([residuals.reshape(count), known])
    group = np.concatenate([np.repeat(readings.group, shape[1]), np.full(len(known), -1)])
    taken = np.concatenate([readings.taken.reshape(-1), np.ones(len(known), dtype=bool)])
    own_columns = np.vstack([own.reshape(count, 2), np.zeros((len(known), 2))])
    along = shared.T @ flat
    return LinearModel(flat - shared @ along, own_columns, group, shared, taken, whiten, float(along @ along))


def whitened(problem: CalibrationProblem, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (n, K) of all readings and their slopes by the scaled parameters (n, K, P), whitened, less the groups' inclinations."""
    readings, e = problem.readings, evaluate_readings(problem, state)
    whiten = whitening(readings, joint_covariance_at(problem, state.p, state.z))
    both = np.concatenate([deviations(readings, e.readings)[:, :, None], slopes(e)], axis=2)
    both = _less_groups(readings, _group_columns(readings, whiten), whiten @ both)
    return both[:, :, 0], both[:, :, 1:]


def admissible(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Basis (not of unit length) of the directions in which p is determined and an overconstrained closure stays consistent."""
    found = spectrum(ideal_design(problem, state))
    if state.leftover is None:
        return found.told
    null = found.null_space
    return _annihilated(np.vstack([null.T, state.leftover[1].reshape(-1, null.shape[0])]))


def _group_columns(readings: Readings, whiten: np.ndarray) -> np.ndarray:
    """W G (n, K, 2) made orthonormal group by group: W G L^-T with L L^T = sum over the group of (W G)^T W G."""
    if not readings.groups:
        return np.zeros((*readings.values.shape, 2))
    basis = group_basis(readings, whiten)
    root = np.linalg.cholesky(group_sum(readings, basis.transpose(0, 2, 1) @ basis))
    return np.where((readings.group >= 0)[:, None, None], basis @ np.linalg.inv(root).transpose(0, 2, 1)[readings.group], 0.0)


def _less_groups(readings: Readings, own: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Columns (n, K, k) less their projection to the groups' columns."""
    if not readings.groups:
        return values
    return np.asarray(values - own @ group_sum(readings, own.transpose(0, 2, 1) @ values)[readings.group])


def _annihilated(rows: np.ndarray) -> np.ndarray:
    """Orthonormal columns that the rows map to zero."""
    _, singular, right = np.linalg.svd(rows, full_matrices=True)
    return np.asarray(right[int(np.sum(singular > 1e-9)) :].T)


def _orthonormal(columns: np.ndarray) -> np.ndarray:
    norms = np.linalg.norm(columns, axis=0)
    return _basis(columns[:, norms > 0] / norms[norms > 0])


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of columns of unit length or less; directions below RANK_TOLERANCE are rounding."""
    if columns.shape[1] == 0:
        return columns
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, singular > RANK_TOLERANCE * max(1.0, float(singular[0]))])


def _basis_in_place(columns: np.ndarray) -> np.ndarray:
    """The same of many rows (N, k), which are overwritten block by block: with the triangle R of the columns, R = U S V^T, the basis
    is columns V / S; what rounding leaves of that is taken away by its own triangle."""
    _, singular, right = np.linalg.svd(_triangle(columns), full_matrices=False)
    kept = singular > RANK_TOLERANCE * max(1.0, float(singular[0]))
    _multiply(columns, right[kept].T / singular[kept])
    basis = columns[:, : int(kept.sum())]
    _multiply(basis, np.linalg.inv(_triangle(basis)))
    return basis


def _blocks(columns: np.ndarray) -> Iterator[np.ndarray]:
    yield from (columns[k : k + _BLOCK] for k in range(0, len(columns), _BLOCK))


def _triangle(columns: np.ndarray) -> np.ndarray:
    """R (k, k) of columns (N, k) = Q R."""
    found = np.zeros((0, columns.shape[1]))
    for block in _blocks(columns):
        found = np.asarray(np.linalg.qr(np.vstack([found, block]), mode="r"))
    return found


def _multiply(columns: np.ndarray, factor: np.ndarray) -> None:
    """columns @ factor, in the first columns."""
    for block in _blocks(columns):
        block[:, : factor.shape[1]] = block @ factor
