"""Tail probabilities of chi-square and F, and the covariance of parameters."""

from __future__ import annotations

import numpy as np

from symkin.calibration.linear import admissible
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.residuals import neighbours
from symkin.calibration.state import State, evaluate, joint_covariance
from symkin.numeric.rank import RANK_TOLERANCE

_DOUBLE = 53
"""Bits of tail probabilities."""
UNLIKELY = 1e-3
"""Tail probability on either side of chi-square beyond which the stated noise does not explain the residuals."""


def chi_square_tail(value: float, degrees: int) -> float:
    """Probability that chi-square with `degrees` of freedom exceeds `value`: Q(degrees / 2, value / 2)."""
    from flint import arb

    from symkin.certificate.balls import precision

    if degrees <= 0 or value <= 0.0:
        return 1.0
    with precision(_DOUBLE):
        return float(arb(0.5 * value).gamma_upper(arb(degrees) / 2, 1))


def f_tail(value: float, first: int, second: int) -> float:
    """Probability that F(first, second) exceeds `value`: I_x(second / 2, first / 2), x = second / (second + first value)."""
    from flint import arb

    from symkin.certificate.balls import precision

    if first <= 0 or second <= 0 or value <= 0.0:
        return 1.0
    x = second / (second + first * value)
    with precision(_DOUBLE):
        return float(arb(x).beta_lower(arb(second) / 2, arb(first) / 2, 1))


# --- covariance ----------------------------------------------------------------------------------------------------


def covariance(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Covariance (P, P) of the free parameters (not scaled) for the form of residuals that was minimised:
    A S A^T with dp = A d(readings), S the covariance of readings with joint noise; along unobservable directions 0."""
    noise = joint_covariance(problem, state)
    mixed = evaluate(problem, state.p, state.z, problem.form, noise if problem.form == "maximum likelihood" else None)
    free = admissible(problem, mixed)
    inverse = np.linalg.pinv(mixed.fit.matrix @ free, rcond=RANK_TOLERANCE)
    scaled = problem.model.scales[:, None] * (free @ inverse)
    if problem.form == "maximum likelihood":
        return np.asarray(scaled @ scaled.T)
    known = problem.prior_rows(state.p)
    if not problem.is_large:
        own, prior = np.split(scaled, [problem.readings.values.size], axis=1)
        return np.asarray(_propagated(problem, own, noise) + prior @ prior.T)
    back = scaled @ inverse.T @ free.T  # (J^T J)^+ with J^T in place of J^+
    prior = back @ (np.zeros((0, len(scaled))) if known is None else known[1]).T
    total = prior @ prior.T
    for rows, part in problem.parts:
        slopes = evaluate(part, state.p, state.z[rows], problem.form).fit.matrix
        total += _propagated(part, back @ slopes.T, noise[rows])
    return np.asarray(total)


def _propagated(problem: CalibrationProblem, scaled: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """A S A^T, from dp per residual (P, N) and the covariance (n, K, K) that joint noise gives the readings."""
    readings = problem.readings
    gain = _gain(problem, scaled.reshape(len(scaled), len(readings.values), -1))
    spread = np.where(readings.taken, readings.sigma, 0.0) ** 2
    s = noise + spread[:, :, None] * np.eye(spread.shape[1])
    flat = gain.transpose(1, 0, 2)
    return np.asarray(np.sum(flat @ s @ flat.transpose(0, 2, 1), axis=0))


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
