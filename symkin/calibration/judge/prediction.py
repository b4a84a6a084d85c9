"""Predict readings and poses by a fit, and compare the predictions with what was read.

Readings m at configurations that took no part in a fit differ from its model h by errors of
covariance S + J C J^T: S of their noise (that of joints included), J (n, K, P) their slopes by the
scaled parameters with the configurations following, C (P, P) the covariance of these. The unknown
inclination of a group is the weighted mean of the members that tell it; where another is compared
with it, the mean's own noise counts, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import deviations, group_sum
from symkin.calibration.estimate.state import evaluate_at, joint_covariance_at


def covariance_root(covariance: np.ndarray, problem: CalibrationProblem) -> np.ndarray:
    """Return L (P, k) with L L^T the covariance of the scaled free parameters, which come first."""
    scales = problem.model.scales
    free = covariance[: len(scales), : len(scales)] / np.outer(scales, scales)
    values, vectors = np.linalg.eigh(free)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


@dataclass(frozen=True, eq=False)
class Prediction:
    """The model less the readings at n configurations (n, K), 0 where nothing was read, with the
    noise S (n, K, K) of each, 1 there, and how what the fit does not know spreads them, J L (n, K,
    k).
    """

    errors: np.ndarray
    noise: np.ndarray
    spread: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """S + J C J^T of each configuration (n, K, K)."""
        return np.asarray(self.noise + self.spread @ self.spread.transpose(0, 2, 1))

    def chi_square(self, rows: np.ndarray) -> float:
        """Return e^T (S + J C J^T)^-1 e over some configurations together: with e and M = J L
        whitened by S, |e|^2 - e^T M (1 + M^T M)^-1 M^T e.
        """
        root = np.linalg.cholesky(self.noise[rows])
        both = np.linalg.solve(root, np.dstack([self.errors, self.spread])[rows])
        both = both.reshape(-1, both.shape[2])
        e, m = both[:, 0], both[:, 1:]
        within = np.eye(m.shape[1]) + m.T @ m
        return float(e @ e - (m.T @ e) @ np.linalg.solve(within, m.T @ e))


def predict_readings(
    problem: CalibrationProblem,
    p: np.ndarray,
    z: np.ndarray,
    root: np.ndarray,
    factor: float = 1.0,
    telling: np.ndarray | None = None,
) -> Prediction:
    """Predict the readings of a problem at parameters p and configurations z; `root` is that of the
    parameters' covariance, `factor` scales the variances stated, and `telling` (n,) are the members
    that tell the inclination of their group, all in a group without any.
    """
    readings = problem.readings
    e, taken, width = evaluate_at(problem, p, z), readings.taken, readings.values.shape[1]
    variance = factor * np.where(taken, readings.sigma, 0.0) ** 2 + ~taken
    both = taken[:, :, None] & taken[:, None, :]
    noise = np.where(both, factor * joint_covariance_at(problem, p, z), 0.0)
    noise = noise + variance[:, :, None] * np.eye(width)
    gap = deviations(readings, e.readings)
    values = np.where(taken[:, :, None], np.dstack([gap, e.slopes @ root]), 0.0)
    if readings.groups:
        inside, turn = readings.group >= 0, np.eye(width)[:, readings.columns]
        told = inside if telling is None else inside & telling
        told = told | (inside & ~group_sum(readings, told)[readings.group])
        weights = np.where(told[:, None, None], np.linalg.solve(noise, turn), 0.0)
        weights = weights.transpose(0, 2, 1)
        information = group_sum(readings, weights @ turn)
        means = np.linalg.solve(information, group_sum(readings, weights @ values))
        values -= np.where(inside[:, None, None], turn @ means[readings.group], 0.0)
        own = turn @ np.linalg.inv(np.linalg.cholesky(information)).transpose(0, 2, 1)
        own = np.where((inside & ~told)[:, None, None], own[readings.group], 0.0)
        values = np.dstack([values, own])
    return Prediction(errors=values[:, :, 0], noise=noise, spread=values[:, :, 1:])
