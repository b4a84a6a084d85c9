"""From a fit to its result: values with standard deviations, residuals, chi-square and notes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from symkin.calibration.believable import believe, is_exact, listed
from symkin.calibration.corrected import is_writable
from symkin.calibration.estimator import Estimate
from symkin.calibration.identifiability import judge
from symkin.calibration.linear import LinearModel, linear_model
from symkin.calibration.measurements import Measurements
from symkin.calibration.nonlinearity import CURVED, curvature
from symkin.calibration.outliers import Screening
from symkin.calibration.parameters import nominal_parameters
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.result import Calibration, Parameter, Residual
from symkin.calibration.robust import EFFICIENCY
from symkin.calibration.state import State, evaluate
from symkin.calibration.statistics import chi_square_tail, covariance
from symkin.calibration.written import read_back
from symkin.model.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Fitted:
    """An estimate over the postures `used`, those `unsolved`, the sign of det F_z of each used one where the estimation
    began, and postures without a reading, `silent`."""

    problem: CalibrationProblem
    result: Estimate
    used: np.ndarray
    unsolved: np.ndarray
    begin: np.ndarray
    notes: tuple[str, ...] = ()
    silent: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    loss: str = "squared"


def report(
    mechanism: Mechanism,
    measurements: Measurements,
    found: Fitted,
    screening: Screening,
    method: str,
    elapsed: float,
    removed: bool,
) -> Calibration:
    problem, written = found.problem, read_back(found.problem, found.result.state)
    state = written.state
    model = linear_model(problem, state)
    known = problem.readings.known
    chi_square = model.chi_square_as_is
    spread = 1.0 if known else chi_square / max(model.degrees, 1)
    free = spread * covariance(problem, state) / (1.0 if found.loss == "squared" else EFFICIENCY)
    identified = judge(problem, state)
    crossed = found.used[state.signs * found.begin < 0]
    calibration = Calibration(
        mechanism, measurements, problem, state, _parameters(problem, state, free, known or model.degrees > 0),
        _full_covariance(problem, free), _residuals(problem, state, model, spread, found.used), chi_square, model.degrees,
        chi_square_tail(_tested(problem, model), model.degrees) if known and model.degrees > 0 else None, identified,
        screening.outliers, screening.unchecked, tuple(found.used.tolist()), tuple(found.unsolved.tolist()),
        tuple(crossed.tolist()), problem.model.poses(state.z, state.p), method, found.result.status,
        found.result.iterations, elapsed, given_up=screening.given_up,
        silent=tuple(found.silent.tolist()), refused=written.reason,
    )  # fmt: skip
    left_out = [n for n in problem.names if not is_writable(mechanism, n)]
    notes = [*found.notes, *believe(calibration, removed=removed)]
    curved = [n for n, share in zip(problem.names, curvature(problem, state, spread), strict=True) if not share < CURVED]
    if curved and not is_exact(calibration):
        notes.append(
            f"standard deviations of {listed(curved)} are doubtful: the readings are not linear in the parameters within them; "
            "choose postures that tell these parameters better, or hold some"
        )
    if left_out:
        notes.append(f"a mechanism file has no place for {', '.join(left_out)}: apply them to the readings")
    return replace(calibration, notes=tuple(notes))


def _tested(problem: CalibrationProblem, model: LinearModel) -> float:
    """The statistic that has the chi-square distribution: where the form that was minimised leaves joint noise or correlation out of
    account, what the parameters could still take away of it is no misfit."""
    efficient = problem.form == "maximum likelihood" or (problem.form == "means" and problem.measurements.joint_sigma is None)
    return model.chi_square_as_is if efficient else model.chi_square


def _parameters(problem: CalibrationProblem, state: State, free: np.ndarray, has_sigma: bool) -> tuple[Parameter, ...]:
    model = problem.model
    sigmas = np.sqrt(np.maximum(np.diag(free), 0.0))
    found = [
        Parameter(name, kind, float(nominal), float(value), float(sigma) if has_sigma else None)
        for name, kind, nominal, value, sigma in zip(model.names, model.kinds, model.nominal, state.p, sigmas, strict=True)
    ]
    table = nominal_parameters(problem.mechanism)
    return (*found, *(Parameter(n, table[n][1], table[n][0], table[n][0], 0.0, held=True) for n in problem.fixed))


def _full_covariance(problem: CalibrationProblem, free: np.ndarray) -> np.ndarray:
    """Of the free parameters and then the held ones."""
    width = len(problem.names) + len(problem.fixed)
    whole = np.zeros((width, width))
    whole[: len(free), : len(free)] = free
    return whole


def _residuals(
    problem: CalibrationProblem, state: State, model: LinearModel, spread: float, used: np.ndarray
) -> tuple[Residual, ...]:
    readings = problem.readings
    raw = state_residuals(problem, state)
    left = np.sqrt(np.maximum(1.0 - model.absorbed[: raw.size], 0.0)).reshape(raw.shape)
    whitened = model.residuals[: raw.size].reshape(raw.shape)
    rows = []
    for i, k in np.argwhere(readings.taken):
        kind, component = problem.model.columns[k]
        normal = float(whitened[i, k] / left[i, k] / np.sqrt(spread)) if left[i, k] > 1e-6 and spread > 0 else None
        rows.append(Residual(int(used[i]), kind, component, float(raw[i, k]), float(readings.sigma[i, k]), normal))
    return tuple(rows)


def state_residuals(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Readings of the model less those taken (n, K), radians and length unit; a group's from its weighted mean."""
    means = evaluate(problem, state.p, state.z, "means").fit.residuals
    return np.asarray(means * np.where(problem.readings.taken, problem.readings.sigma, 0.0))
