"""Predict readings and poses by a fit, and compare the predictions with what was read.

Readings m at configurations that took no part in a fit differ from its model h by errors of
covariance S + J C J^T: S of their noise (that of joints included), J (n, K, P) their slopes by the
scaled parameters with the configurations following, C (P, P) the covariance of these. The unknown
inclination of a group is the weighted mean of the members that tell it; where another is compared
with it, the mean's own noise counts, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import nearest_rows, solve_configurations
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import (
    build_readings,
    deviations,
    group_sum,
    noise_of,
    take_means,
)
from symkin.calibration.estimate.state import State, evaluate_at, joint_covariance


def close_others(
    problem: CalibrationProblem, state: State, measurements: Measurements, seed: int = 0
) -> tuple[CalibrationProblem, np.ndarray, np.ndarray]:
    """Close other configurations at the parameters of a fit, from their neighbours' solutions: the
    problem of those that are solved, their unknown coordinates, and which they are (n,).
    """
    model = build_model(problem.mechanism, measurements, problem.names)
    near = state.z[nearest_rows(problem.joints, measurements.joints, 1)[:, 0]]
    found = solve_configurations(model, measurements, state.p, z=near, seed=seed)
    some = measurements.subset(found.solved)
    readings = build_readings(model, some)
    there = replace(problem, measurements=some, model=model, readings=readings)
    return there, found.z[found.solved], found.solved


def covariance_root(covariance: np.ndarray, problem: CalibrationProblem) -> np.ndarray:
    """Return L (P, k) with L L^T the covariance of the scaled free parameters, which come first."""
    scales = problem.model.scales
    free = covariance[: len(scales), : len(scales)] / np.outer(scales, scales)
    values, vectors = np.linalg.eigh(free)
    return vectors * np.sqrt(np.maximum(values, 0.0))


@dataclass(frozen=True, eq=False)
class Prediction:
    """The model less the readings at n configurations (n, K), 0 where nothing was read, with the
    noise S (n, K, K) of each, 1 there, how what the fit does not know spreads them, J L (n, K, k),
    and how the noise of the mean inclination of its group does, G (n, K, 2); which members tell
    that mean (n,).
    """

    errors: np.ndarray
    noise: np.ndarray
    spread: np.ndarray
    of_mean: np.ndarray
    telling: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """S + J C J^T of each configuration (n, K, K), with G G^T where it tells no mean."""
        own = np.where(self.telling[:, None, None], 0.0, self.of_mean)
        both = np.concatenate([self.spread, own], axis=2)
        return self.noise + both @ both.transpose(0, 2, 1)

    def chi_square(self, rows: np.ndarray) -> float:
        """Return e^T (S + J C J^T)^-1 e over some configurations together: with e and M = J L
        whitened by S, |e|^2 - e^T M (1 + M^T M)^-1 M^T e.
        """
        root = np.linalg.cholesky(self.noise[rows])
        both = np.linalg.solve(root, np.dstack([self.errors[rows], self.spread[rows]]))
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
    noise = noise_of(readings, joint_covariance(problem, p, z), factor)
    gap = deviations(readings, e.readings)
    values = np.where(taken[:, :, None], np.dstack([gap, e.slopes @ root]), 0.0)
    inside = readings.group >= 0
    told, of_mean = inside if telling is None else inside & telling, np.zeros((*gap.shape, 2))
    if readings.groups:
        told = told | (inside & ~group_sum(readings, told)[readings.group])
        turn = np.eye(width)[:, readings.columns]
        precise = np.where(told[:, None, None], np.linalg.solve(noise, turn), 0.0)
        information = take_means(readings, values, precise)
        own = np.linalg.inv(np.linalg.cholesky(information)).transpose(0, 2, 1)
        of_mean[readings.inside, readings.pair] = own[readings.group[readings.inside]]
    return Prediction(values[:, :, 0], noise, values[:, :, 1:], of_mean, told | ~inside)
