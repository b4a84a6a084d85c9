"""The linear model of all readings at an estimate: what chi-square is made of and outliers are found in.

The whitened residuals of all readings (joint noise included, see `residuals`) are e = (1 - Q Q^T) r with Q an orthonormal basis
of what the fit may absorb: the unknown inclination of each group and the parameters' columns. The part of the groups is block
diagonal and is kept as two columns, each group's own rows of them; the rest, orthogonal to it, is dense and as wide as there
are parameters. In the linear range |e|^2 has the chi-square distribution with as many degrees of freedom as there are readings
left, whichever form of the residuals was minimised.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.caching import cached_property
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.residuals import Readings, deviations, group_basis, group_sum, whitening
from symkin.calibration.state import State, evaluate_readings, ideal_design, joint_covariance, slopes
from symkin.calibration.steps import spectrum
from symkin.position.rank import RANK_TOLERANCE


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
        return np.asarray(np.sum(self.own**2, axis=1) + np.sum(self.shared**2, axis=1))

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
    readings = problem.readings
    e = evaluate_readings(problem, state)
    whiten = whitening(readings, joint_covariance(problem, state))
    residuals = whiten @ deviations(readings, e.readings)[:, :, None]
    own = _group_columns(readings, whiten)
    free = admissible(problem, state)
    known, by_known = problem.prior_rows(state.p) or (np.zeros(0), np.zeros((0, len(free))))
    columns, by_known = whiten @ (slopes(e) @ free), by_known @ free
    norms = np.hypot(np.linalg.norm(columns, axis=(0, 1)), np.linalg.norm(by_known, axis=0))
    columns, by_known = (part[..., norms > 0] / norms[norms > 0] for part in (columns, by_known))
    for _ in range(2):  # the second time takes away what rounding left
        columns = _less_groups(readings, own, columns)
        residuals = _less_groups(readings, own, residuals)
    count = readings.values.size
    shared = _basis(np.vstack([columns.reshape(count, -1), by_known]))
    flat = np.concatenate([residuals.reshape(count), known])
    group = np.concatenate([np.repeat(readings.group, readings.values.shape[1]), np.full(len(known), -1)])
    taken = np.concatenate([readings.taken.reshape(-1), np.ones(len(known), dtype=bool)])
    own = np.vstack([own.reshape(count, 2), np.zeros((len(known), 2))])
    along = shared.T @ flat
    return LinearModel(flat - shared @ along, own, group, shared, taken, whiten, float(along @ along))


def whitened(problem: CalibrationProblem, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (n, K) of all readings and their slopes by the scaled parameters (n, K, P), whitened, less the groups' inclinations."""
    readings, e = problem.readings, evaluate_readings(problem, state)
    whiten = whitening(readings, joint_covariance(problem, state))
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
