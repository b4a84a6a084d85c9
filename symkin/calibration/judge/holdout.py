"""Hold out configurations from a fit, and test how well the fit predicts them.

Of a prediction at held-out configurations the whitened errors e have the covariance 1 + M M^T, M =
W (dh/dp) L with L L^T the covariance of the parameters, so that e^T (1 + M M^T)^-1 e = |e|^2 - e^T
M (1 + M^T M)^-1 M^T e has the chi-square distribution with as many degrees of freedom as readings
were held out, less two for the unknown inclination of each group.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import nearest_rows, solve_configurations
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import build_readings
from symkin.calibration.estimate.state import evaluate, evaluate_readings, joint_covariance
from symkin.calibration.judge.assessment import state_residuals
from symkin.calibration.judge.result import Calibration
from symkin.calibration.judge.statistics import (
    SIGNIFICANCE,
    chi_square_tail,
    f_tail,
    whitened_residuals,
)
from symkin.errors import InputError

_COUNT_PATTERN = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(%?)\s*")
_MAX_OUTLIER_SHARE = 0.2
"""Share of the held-out configurations that may be outliers, one by one; where more are off, the
prediction is.
"""
_OUTLIER_LEVEL = 0.02
"""Share of right predictions of which a configuration is called an outlier."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Predictions at configurations that were held out, by their labels: root mean square of the
    errors and what was expected of it, by kind (radians, length unit); chi-square without the
    `outliers`, its degrees of freedom and probability; configurations `unsolved`.
    """

    labels: tuple[str, ...]
    rms: dict[str, float]
    expected: dict[str, float]
    chi_square: float
    degrees: int
    p_value: float | None
    outliers: tuple[str, ...]
    unsolved: tuple[str, ...]
    seed: int

    @property
    def believable(self) -> bool:
        """Whether they are predicted as well as noise and the parameters' standard deviations let
        expect.
        """
        return not self.unsolved and (self.p_value is None or self.p_value > SIGNIFICANCE)

    @property
    def doubt(self) -> str:
        """Why the prediction is not believable."""
        if self.unsolved:
            return (
                f"the direct problem of {len(self.unsolved)} of {len(self.labels)} held-out "
                f"postures has no solution"
            )
        times = math.sqrt(self.chi_square / max(self.degrees, 1))
        return (
            f"the {len(self.labels)} held-out postures are missed by {times:.3g} times what noise "
            f"and parameters let expect, probability "
            f"{self.p_value:.1g}: the model lacks something that the fitted postures hide"
        )


def held_out_count(asked: str, configurations: int) -> int:
    """Read how many configurations `20` or `20%` are. Raises InputError where none or all of them
    would be held out.
    """
    match = _COUNT_PATTERN.fullmatch(asked)
    if match is None or (not match[2] and "." in match[1]):
        raise InputError(
            f"--hold-out {asked!r}: a number of postures, or a share such as 20%, is needed"
        )
    count = max(1, round(float(match[1]) / 100.0 * configurations)) if match[2] else int(match[1])
    if not 1 <= count < configurations:
        raise InputError(
            f"--hold-out {asked.strip()}: {count} of {configurations} postures would be held out; "
            f"allowed: 1 to {configurations - 1}"
        )
    return count


def draw_held_out(measurements: Measurements, count: int, seed: int) -> np.ndarray:
    """Draw the configurations (n,) to be held out: at random, and whole groups, until there are
    `count` of them or just more; none without a reading beside the joints. Raises InputError where
    nothing is left.
    """
    groups = (
        np.full(len(measurements), NO_GROUP) if measurements.groups is None else measurements.groups
    )
    left, held = measurements.is_read, np.zeros(len(measurements), dtype=bool)
    for k in np.random.default_rng([seed, len(measurements)]).permutation(len(measurements)):
        if left[k] and not held[k] and int(held.sum()) < count:
            held |= (groups == groups[k]) if groups[k] != NO_GROUP else np.arange(len(held)) == k
    if not np.any(left & ~held):
        raise InputError(
            "--hold-out: whole groups are held out, and none would be left; hold out less, or take "
            "more groups"
        )
    return held


def predict_held_out(fit: Calibration, measurements: Measurements, seed: int) -> HeldOut:
    """Predict held-out configurations by a fit; their direct problems begin at their neighbours'
    solutions.
    """
    model, p = build_model(fit.mechanism, measurements, fit.problem.names), fit.state.p
    near = nearest_rows(fit.problem.measurements.joints, measurements.joints, 1)[:, 0]
    configurations = solve_configurations(model, measurements, p, z=fit.state.z[near], seed=seed)
    unsolved = tuple(measurements.labels[int(k)] for k in np.flatnonzero(~configurations.solved))
    some, z = measurements.subset(configurations.solved), configurations.z[configurations.solved]
    if not len(z):
        return HeldOut(
            labels=tuple(measurements.labels),
            rms={},
            expected={},
            chi_square=0.0,
            degrees=0,
            p_value=None,
            outliers=(),
            unsolved=unsolved,
            seed=seed,
        )
    problem = replace(
        fit.problem, measurements=some, model=model, readings=build_readings(model, some)
    )
    off = _outliers(fit, problem, z)
    clean = problem
    if 0 < len(off) <= _MAX_OUTLIER_SHARE * len(z):
        kept = np.setdiff1d(np.arange(len(z)), off)
        clean = replace(
            problem,
            measurements=some.subset(kept),
            readings=build_readings(model, some.subset(kept)),
        )
    chi_square, degrees = _chi_square(fit, clean, z if clean is problem else z[kept])
    rms, expected = _error_sizes(fit, problem, z)
    named = tuple(some.labels[k] for k in off) if clean is not problem else ()
    return HeldOut(
        labels=tuple(measurements.labels),
        rms=rms,
        expected=expected,
        chi_square=chi_square,
        degrees=degrees,
        p_value=_probability(fit, chi_square, degrees),
        outliers=named,
        unsolved=unsolved,
        seed=seed,
    )


def _variance_factor(fit: Calibration) -> float:
    """Factor of the stated variances: 1 where standard deviations are known."""
    return 1.0 if fit.problem.readings.known else fit.chi_square / max(fit.degrees, 1)


def _probability(fit: Calibration, chi_square: float, degrees: int) -> float | None:
    if degrees <= 0 or fit.degrees <= 0:
        return None
    if fit.problem.readings.known:
        return chi_square_tail(chi_square, degrees)
    return f_tail(chi_square / degrees, degrees, fit.degrees)


def _covariance_root(fit: Calibration) -> np.ndarray:
    """L (P, k) with L L^T the covariance of the scaled free parameters."""
    names, scales = fit.problem.names, fit.problem.model.scales
    values, vectors = np.linalg.eigh(
        fit.covariance[: len(names), : len(names)] / np.outer(scales, scales)
    )
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _whitened(
    fit: Calibration, problem: CalibrationProblem, z: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors e (n, K) and M (n, K, k), in standard deviations."""
    state = evaluate(problem, fit.state.p, z, "means")
    residuals, columns = whitened_residuals(problem, state)
    scale = 1.0 / math.sqrt(max(_variance_factor(fit), 1e-300))
    return scale * residuals, scale * (columns @ _covariance_root(fit))


def _statistic(errors: np.ndarray, m: np.ndarray) -> float:
    """e^T (1 + M M^T)^-1 e."""
    across = m.T @ errors
    return float(errors @ errors - across @ np.linalg.solve(np.eye(m.shape[1]) + m.T @ m, across))


def _chi_square(fit: Calibration, problem: CalibrationProblem, z: np.ndarray) -> tuple[float, int]:
    errors, m = _whitened(fit, problem, z)
    return _statistic(errors.reshape(-1), m.reshape(errors.size, -1)), problem.readings.count


def _outliers(fit: Calibration, problem: CalibrationProblem, z: np.ndarray) -> np.ndarray:
    """Find configurations (by number) that are off by themselves, beyond what the share
    `_OUTLIER_LEVEL` of right predictions has anywhere.
    """
    errors, m = _whitened(fit, problem, z)
    taken = np.sum(problem.readings.taken, axis=1)
    level = 1.0 - (1.0 - _OUTLIER_LEVEL) ** (1.0 / len(z))
    chances = [_probability(fit, _statistic(errors[k], m[k]), int(taken[k])) for k in range(len(z))]
    return np.array(
        [k for k, chance in enumerate(chances) if chance is not None and chance < level], dtype=int
    )


def _error_sizes(
    fit: Calibration, problem: CalibrationProblem, z: np.ndarray
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the root mean square of the errors of each kind, and of what noise and parameters let
    expect.
    """
    state, readings = evaluate(problem, fit.state.p, z, "means"), problem.readings
    errors, by_p = (
        state_residuals(problem, state),
        evaluate_readings(problem, state).slopes @ _covariance_root(fit),
    )
    noise = np.where(readings.taken, readings.sigma, 0.0) ** 2 + np.diagonal(
        joint_covariance(problem, state), axis1=1, axis2=2
    )
    variance = _variance_factor(fit) * noise + np.sum(by_p**2, axis=2)
    found: tuple[dict[str, float], dict[str, float]] = ({}, {})
    for kind in dict.fromkeys(kind for kind, _ in problem.model.columns):
        columns = [k for k, (other, _) in enumerate(problem.model.columns) if other == kind]
        taken = readings.taken[:, columns]
        if taken.any():
            found[0][kind] = float(np.sqrt(np.mean(errors[:, columns][taken] ** 2)))
            found[1][kind] = float(np.sqrt(np.mean(variance[:, columns][taken])))
    return found
