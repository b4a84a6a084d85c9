"""Differentiate the readings that would be taken at closed configurations, over their standard
deviations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP
from symkin.calibration.design.simulation import Noise, simulate_readings
from symkin.calibration.estimate.configurations import ClosedConfigurations
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.residuals import noise_of, whitening
from symkin.calibration.estimate.state import evaluate_at, joint_covariance_at
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.transfer import many_elsewhere


@dataclass(frozen=True, eq=False)
class ReadingSlopes:
    """Readings over their standard deviations, joint noise included: A (n, K, P) by scaled
    parameters, and B (n, K, 2) by the unknown inclination of the configuration's group, zero where
    it has none.
    """

    parameters: np.ndarray
    group: np.ndarray


def readings_problem(
    mechanism: Mechanism,
    made: ClosedConfigurations,
    groups: np.ndarray,
    readings: Sequence[str],
    noise: Noise,
    names: Sequence[str],
) -> tuple[CalibrationProblem, np.ndarray]:
    """State the problem of readings that would be taken at closed configurations, with the unknown
    coordinates there. Raises InputError where a reading is without a standard deviation.
    """
    quiet = np.random.default_rng(0)
    taken = simulate_readings(mechanism, made, groups, readings, noise, quiet)
    for o, r in taken.channels(mechanism):
        if r.sigma is None:
            raise InputError(
                f"the standard deviation of {o.name if o.of else f'{o.name} readings'} is zero or "
                f"not given; a plan needs it"
            )
    # readings at the configurations themselves
    read = None if taken.orientation is None else made.poses[:, 3:]
    taken = replace(taken, joints=made.joints, orientation=read)
    problem = build_calibration(mechanism, taken, parameters=names)
    values = many_elsewhere(problem.model.closure, build_closure(mechanism), made.values)
    return problem, np.ascontiguousarray(values[:, made.joints.shape[1] :])


def reading_slopes(
    mechanism: Mechanism,
    made: ClosedConfigurations,
    readings: Sequence[str],
    noise: Noise,
    names: Sequence[str],
    *,
    grouped: bool,
) -> ReadingSlopes:
    """Differentiate the readings that would be taken at closed configurations."""
    groups = np.zeros(len(made), dtype=int) if grouped else np.full(len(made), NO_GROUP)
    problem, z = readings_problem(mechanism, made, groups, readings, noise, names)
    p = problem.model.nominal
    found = evaluate_at(problem, p, z).slopes, joint_covariance_at(problem, p, z)
    # two inclinations have no slopes where the platform's z axis lies level: such a configuration
    # is offered as one that tells nothing
    told = np.all([np.all(np.isfinite(v), axis=(1, 2)) for v in found], axis=0)
    slopes, of_joints = (np.where(told[:, None, None], v, 0.0) for v in found)
    whiten = whitening(problem.readings, noise_of(problem.readings, of_joints))
    basis = whiten[:, :, problem.readings.grouped if grouped else []]
    return ReadingSlopes(whiten @ slopes, basis)
