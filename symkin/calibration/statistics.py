"""What the residuals say: chi-square, covariance of parameters and poses, and the linear model that outliers are found in.

At an estimate the whitened residuals of all readings (joint noise included, see `residuals`) are e = (1 - Q Q^T) r with Q
an orthonormal basis of what the fit may absorb: the parameters' columns and the unknown inclination of each group. In the
linear range |e|^2 has the chi-square distribution with as many degrees of freedom as there are readings left, whichever
form of the residuals was minimised.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.calibration.estimator import (
    State,
    evaluate,
    ideal_design,
    joint_covariance,
    null_directions,
    slopes,
)
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.residuals import deviations, group_basis, neighbours, whitening
from symkin.position.rank import RANK_TOLERANCE


def chi_square_tail(value: float, degrees: int) -> float:
    """Probability that chi-square with `degrees` of freedom exceeds `value`: Q(degrees / 2, value / 2)."""
    from flint import arb

    if degrees <= 0 or value <= 0.0:
        return 1.0
    return float(arb(0.5 * value).gamma_upper(arb(degrees) / 2, 1))


def f_tail(value: float, first: int, second: int) -> float:
    """Probability that F(first, second) exceeds `value`: I_x(second / 2, first / 2), x = second / (second + first value)."""
    from flint import arb

    if first <= 0 or second <= 0 or value <= 0.0:
        return 1.0
    x = second / (second + first * value)
    return float(arb(x).beta_lower(arb(second) / 2, arb(first) / 2, 1))


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Whitened residuals e (N,) after projection, an orthonormal basis Q (N, k) of what the fit absorbs, which rows hold
    a reading (N,), and the transformation W (n, K, K) that whitened them."""

    residuals: np.ndarray
    basis: np.ndarray
    taken: np.ndarray
    whiten: np.ndarray

    @property
    def degrees(self) -> int:
        return int(np.sum(self.taken)) - int(self.basis.shape[1])

    @property
    def chi_square(self) -> float:
        return float(self.residuals @ self.residuals)

    def freedom(self, rows: np.ndarray) -> np.ndarray:
        """(1 - Q Q^T) restricted to some rows: what of a shift of these readings the fit cannot absorb."""
        part = self.basis[rows]
        return np.asarray(np.diag(self.taken[rows].astype(float)) - part @ part.T)

    def without(self, rows: np.ndarray) -> LinearModel:
        """The model in which the readings of these rows are free: their shift is one more unknown."""
        shift = np.zeros((len(self.residuals), len(rows)))
        shift[rows, np.arange(len(rows))] = self.taken[rows]
        shift -= self.basis @ self.basis[rows].T
        extra = _orthonormal(shift)
        residuals = self.residuals - extra @ (extra.T @ self.residuals)
        return LinearModel(residuals, np.hstack([self.basis, extra]), self.taken, self.whiten)


def linear_model(problem: CalibrationProblem, state: State) -> LinearModel:
    """The linear model of all readings at a state with closed postures."""
    readings = problem.readings
    e = problem.model.evaluate(state.z, problem.measurements.joints, state.p, problem.quaternions)
    whiten = whitening(readings, joint_covariance(problem, state))
    residuals = (whiten @ deviations(readings, e.readings)[:, :, None])[:, :, 0].reshape(-1)
    columns = [(whiten @ slopes(e)).reshape(len(residuals), -1) @ _admissible(problem, state)]
    if readings.groups:
        basis = group_basis(readings, whiten)
        spread = np.zeros((*basis.shape[:2], readings.groups, 2))
        inside = np.flatnonzero(readings.group >= 0)
        spread[inside, :, readings.group[inside]] = basis[inside]
        columns.insert(0, spread.reshape(len(residuals), -1))
    absorbed = _orthonormal(np.hstack(columns))
    return LinearModel(residuals - absorbed @ (absorbed.T @ residuals), absorbed, readings.taken.reshape(-1), whiten)


def _annihilated(rows: np.ndarray) -> np.ndarray:
    """Orthonormal columns that the rows map to zero."""
    _, singular, right = np.linalg.svd(rows, full_matrices=True)
    return np.asarray(right[int(np.sum(singular > 1e-9)) :].T)


def _orthonormal(columns: np.ndarray) -> np.ndarray:
    norms = np.linalg.norm(columns, axis=0)
    columns = columns[:, norms > 0] / norms[norms > 0]
    if columns.shape[1] == 0:
        return columns
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, singular > RANK_TOLERANCE * singular[0]])


# --- covariance ----------------------------------------------------------------------------------------------------


def covariance(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Covariance (P, P) of the free parameters (not scaled) for the form of residuals that was minimised:
    A S A^T with dp = A d(readings), S the covariance of readings with joint noise; along unobservable directions 0."""
    readings = problem.readings
    noise = joint_covariance(problem, state)
    mixed = evaluate(problem, state.p, state.z, problem.form, noise if problem.form == "maximum likelihood" else None)
    free = _admissible(problem, mixed)
    inverse = np.linalg.pinv(mixed.fit.matrix @ free, rcond=RANK_TOLERANCE)
    scaled = problem.model.scales[:, None] * (free @ inverse)
    if problem.form == "maximum likelihood":
        return np.asarray(scaled @ scaled.T)
    gain = _gain(problem, scaled.reshape(len(scaled), len(readings.values), -1))
    spread = np.where(readings.taken, readings.sigma, 0.0) ** 2
    s = noise + spread[:, :, None] * np.eye(spread.shape[1])
    flat = gain.transpose(1, 0, 2)
    return np.asarray(np.sum(flat @ s @ flat.transpose(0, 2, 1), axis=0))


def _admissible(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Basis of the directions in which p is determined and an overconstrained closure stays consistent."""
    null = null_directions(ideal_design(problem, state))
    rows = null.T
    if state.leftover is not None:
        rows = np.vstack([rows, state.leftover[1].reshape(-1, null.shape[0])])
    return np.eye(null.shape[0]) if len(rows) == 0 else _annihilated(rows)


def _gain(problem: CalibrationProblem, inverse: np.ndarray) -> np.ndarray:
    """dp per reading (P, n, K) from dp per residual: the transpose of how readings make residuals."""
    readings = problem.readings
    gain = inverse * np.where(readings.taken, 1.0 / readings.sigma, 0.0)
    if problem.form != "differences":
        return np.asarray(gain)
    before, after = neighbours(readings)
    for column in np.flatnonzero(readings.grouped):
        s = 1.0 / np.hypot(readings.sigma[before, column], readings.sigma[after, column])
        gain[:, :, column] = 0.0
        gain[:, after, column] += s * inverse[:, after, column]
        gain[:, before, column] -= s * inverse[:, after, column]
    return np.asarray(gain)
