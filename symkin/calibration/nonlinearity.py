"""Does the linear model hold within the standard deviations?

A step of one standard deviation along a combination of parameters that the readings tell least moves the residuals by
(dr/dp) step + d. Least squares takes d for a change of the parameters, (dr/dp)^+ d. Where that is not small against a
parameter's standard deviation, the latter is no measure of its error (curvature by the parameters, Bates and Watts 1980).
"""

from __future__ import annotations

import numpy as np

from symkin.calibration.linear import admissible
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.state import State, evaluate, joint_covariance, settled

CURVED = 0.5
"""Share of its standard deviation from which a parameter's is called doubtful."""
_WEAKEST = 3
"""Directions that are tried: with those that are told better curvature falls by the square of their deviation."""


def curvature(problem: CalibrationProblem, state: State, spread: float = 1.0) -> np.ndarray:
    """For each free parameter (P,), the largest change that curvature makes of it along the weakest directions, as a share of
    its standard deviation; inf where postures have no solution there, 0 where a closure leaves rows to the parameters.
    `spread` scales the stated variances."""
    found = np.zeros(len(problem.names))
    if state.leftover is not None:
        return found
    noise = joint_covariance(problem, state) if problem.form == "maximum likelihood" else None
    here = evaluate(problem, state.p, state.z, problem.form, noise)
    free = admissible(problem, here)
    _, singular, right = np.linalg.svd(here.fit.matrix @ free, full_matrices=False)
    inverse = np.sqrt(spread) * free @ right.T / singular
    sigma = np.linalg.norm(inverse, axis=1)
    for step in inverse.T[-_WEAKEST:]:
        for sign in (1.0, -1.0):
            pull = _pull(problem, here, sign * step, noise)
            if pull is None:
                return np.where(sigma > 0, np.inf, 0.0)
            change = inverse @ (right @ (free.T @ pull) / singular) / np.sqrt(spread)
            found = np.maximum(found, np.divide(np.abs(change), sigma, out=np.zeros_like(sigma), where=sigma > 0))
    return found


def _pull(problem: CalibrationProblem, here: State, step: np.ndarray, noise: np.ndarray | None) -> np.ndarray | None:
    """(dr/dp)^T d (P,) of the departure d, part by part; None where postures do not close."""
    total = np.zeros(len(step))
    for rows, part in problem.parts:
        some = None if noise is None else noise[rows]
        near = evaluate(part, here.p, here.z[rows], problem.form, some) if problem.is_large else here
        departure = _departure(part, near, step, some)
        if departure is None:
            return None
        total += near.fit.matrix.T @ departure
    return total


def _departure(problem: CalibrationProblem, here: State, step: np.ndarray, noise: np.ndarray | None) -> np.ndarray | None:
    """d = r(p + step) - r(p) - (dr/dp) step, postures closed again; None where they do not close."""
    z = problem.model.system.move(here.z, here.follow(step))
    with np.errstate(all="ignore"):
        there = settled(problem, here.p + problem.model.scales * step, z, problem.form, noise)
        departure = there.fit.vector - here.fit.vector - here.fit.matrix @ step
    closed = np.max(np.abs(there.pending), initial=0.0) < 1e-9 * problem.model.closure.size
    return np.asarray(departure) if closed and np.all(np.isfinite(departure)) else None
