"""Estimate by the majority of the readings: robust losses by iterated weights, and the scale of the
good readings.

With residuals t over their standard deviation a loss gives the weight w(t) with which a reading
counts in the next least-squares fit: 1 (squared), min(1, k / |t|) (Huber), 1 / (1 + (t / k)^2)
(Cauchy). t is taken over the scale of the better half of the readings where that is larger than the
noise stated, so that the good ones count while the fit is still far away.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.calibration.estimate.estimator import Estimate, estimate
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State, evaluate, joint_covariance
from symkin.numeric.linear_algebra import largest_of

_TUNING = {"huber": 1.345, "cauchy": 2.385}
"""Standard deviations from which a reading counts less, for EFFICIENCY with normal errors."""
EFFICIENCY = 0.95
"""Variance of least squares over that of either robust loss, without outliers."""
_MAX_FITS, _MIN_WEIGHT_CHANGE = 40, 1e-3
"""Most fits of a robust estimate, which ends when no weight changes by more than this."""
_STEPS_PER_FIT = 15
"""Most steps of each of these fits: the next goes on from there."""
_MAX_SCALE, _MIN_FITS, _SCALE_DECREASE = 30.0, 4, 0.8
"""It ends, too, after so many fits where the scale is so many times the noise stated and no longer
falls by this factor: no half of the readings agrees.
"""
SIGMA_OVER_MEDIAN = 1.4826
"""Standard deviation of a normal distribution over the median of its absolute values."""


def loss_weights(loss: str, t: np.ndarray) -> np.ndarray:
    """Return the weights (n, K) of readings whose residuals are t of their scale."""
    if loss == "huber":
        return np.minimum(1.0, _TUNING[loss] / np.maximum(np.abs(t), 1e-300))
    return (1.0 / (1.0 + (t / _TUNING[loss]) ** 2)) if loss == "cauchy" else np.ones_like(t)


def loss_note(loss: str) -> str:
    """Say what a robust loss does to the statistics."""
    return (
        f"loss {loss}: readings count less from {_TUNING[loss]:g} standard deviations on; "
        f"chi-square and its probability are those of all "
        "readings kept, each with its full weight, so that bad ones that are kept raise it; "
        "standard deviations of parameters and poses "
        f"are as if {100 * EFFICIENCY:.0f} % of the information were used, which holds for normal "
        f"errors"
    )


def robust_estimate(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, loss: str
) -> tuple[Estimate, float]:
    """Estimate with a robust loss from p and configurations z; and the ratio of the standard
    deviation of the good readings to the stated one.
    """
    known, state = problem.readings.known, evaluate(problem.by_means, p, z)
    here, steps, weight, scale = problem, 0, np.ones_like(problem.readings.sigma), np.inf
    for count in range(_MAX_FITS):
        t = normalised_residuals(problem, here, state)
        # of the better half, not below the stated noise
        median = np.median(np.abs(t[problem.readings.taken]))
        before, scale = scale, max(SIGMA_OVER_MEDIAN * median, 1.0 if known else 1e-12)
        if known and count > _MIN_FITS and scale > max(_MAX_SCALE, _SCALE_DECREASE * before):
            break
        fresh = loss_weights(loss, t / scale)
        if largest_of(fresh - weight) < _MIN_WEIGHT_CHANGE and steps:
            break
        weight = fresh
        here = with_weights(problem, weight)
        result = estimate(here, state.z, p=state.p, max_iterations=_STEPS_PER_FIT)
        state, steps = result.state, steps + result.iterations
    status = result.status if result.status != "max_iterations" else "stalled"
    ended = evaluate(problem.by_means, state.p, state.z)
    return Estimate(ended, status, steps, result.widened), scale


def with_weights(problem: CalibrationProblem, weight: np.ndarray) -> CalibrationProblem:
    """Let readings count as much as their weights say."""
    readings = problem.readings
    return replace(
        problem,
        readings=replace(readings, sigma=readings.sigma / np.sqrt(np.maximum(weight, 1e-12))),
    )


def normalised_residuals(
    problem: CalibrationProblem, here: CalibrationProblem, state: State
) -> np.ndarray:
    """Return residuals (n, K) over the standard deviations of a problem, joint noise included;
    groups' means are those of the weights that another problem, `here`, gives.
    """
    taken = problem.readings.taken
    raw = evaluate(here.by_means, state.p, state.z).linearised.residuals * np.where(
        taken, here.readings.sigma, 0.0
    )
    noise = np.einsum("nkk->nk", joint_covariance(problem, state.p, state.z))
    return np.where(
        taken, raw / np.sqrt(np.where(taken, problem.readings.sigma, 1.0) ** 2 + noise), 0.0
    )
