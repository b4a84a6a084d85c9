"""Build the result of a calibration from its fit: standard deviations, residuals, chi-square, and notes that its reader must know."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import is_writable, nominal_parameters
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.robust import EFFICIENCY
from symkin.calibration.estimate.solver import Estimate
from symkin.calibration.estimate.state import State, evaluate
from symkin.calibration.judge.fit_notes import fit_notes, is_exact
from symkin.calibration.judge.identifiability import identifiability_at
from symkin.calibration.judge.outliers import Screening
from symkin.calibration.judge.read_back import read_back
from symkin.calibration.judge.result import Calibration, Parameter, Residual
from symkin.calibration.judge.statistics import (
    DOUBTFUL_CURVATURE,
    LinearModel,
    chi_square_tail,
    covariance,
    curvature,
    linear_model,
)
from symkin.text import first_of


@dataclass(frozen=True, eq=False)
class Fit:
    """An estimate over the configurations `used`, those `unsolved`, the sign of det F_z of each used one where the estimation
    began, and configurations without a reading, `silent`."""

    problem: CalibrationProblem
    result: Estimate
    used: np.ndarray
    unsolved: np.ndarray
    start_signs: np.ndarray
    notes: tuple[str, ...] = ()
    silent: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    loss: str = "squared"


def build_result(measurements: Measurements, found: Fit, screening: Screening, *, removed: bool) -> Calibration:
    """Build the result of a fit at the geometry that the corrected file holds; `removed` says whether the outliers were left
    out."""
    mechanism = found.problem.mechanism
    problem, written = found.problem, read_back(found.problem, found.result.state)
    state = written.state
    model = linear_model(problem, state)
    known = problem.readings.known
    chi_square = model.chi_square_as_is
    spread = 1.0 if known else chi_square / max(model.degrees, 1)
    free = spread * covariance(problem, state) / (1.0 if found.loss == "squared" else EFFICIENCY)
    identified = identifiability_at(problem, state)
    crossed = found.used[state.determinant_signs * found.start_signs < 0]
    calibration = Calibration(
        mechanism=mechanism, measurements=measurements, problem=problem, state=state,
        parameters=_parameters(problem, state, free, known or model.degrees > 0), covariance=_full_covariance(problem, free),
        residuals=_residuals(problem, state, model, spread, found.used), chi_square=chi_square, degrees=model.degrees,
        p_value=chi_square_tail(_tested_chi_square(problem, model), model.degrees) if known and model.degrees > 0 else None,
        identifiability=identified, outliers=screening.outliers, unchecked=screening.unchecked,
        used=tuple(found.used.tolist()), unsolved=tuple(found.unsolved.tolist()), changed_mode=tuple(crossed.tolist()),
        poses=problem.model.poses(state.z, state.p), status=found.result.status, iterations=found.result.iterations,
        given_up=screening.given_up, silent=tuple(found.silent.tolist()), refused=written.reason,
    )  # fmt: skip
    left_out = [n for n in problem.names if not is_writable(mechanism, n)]
    notes = [*found.notes, *fit_notes(calibration, removed=removed)]
    curved = [
        n for n, share in zip(problem.names, curvature(problem, state, spread), strict=True) if not share < DOUBTFUL_CURVATURE
    ]
    if curved and not is_exact(calibration):
        notes.append(
            f"standard deviations of {first_of(curved)} are doubtful: the readings are not linear in the parameters within them; "
            "choose postures that tell these parameters better, or hold some"
        )
    if left_out:
        notes.append(f"a mechanism file has no place for {', '.join(left_out)}: apply them to the readings")
    return replace(calibration, notes=tuple(notes))


def _tested_chi_square(problem: CalibrationProblem, model: LinearModel) -> float:
    """Return the statistic that has the chi-square distribution: where the form that was minimised leaves joint noise or
    correlation out of account, what the parameters could still take away of it is no misfit."""
    efficient = problem.form == "maximum likelihood" or (problem.form == "means" and problem.measurements.joint_sigma is None)
    return model.chi_square_as_is if efficient else model.chi_square


def _parameters(problem: CalibrationProblem, state: State, free: np.ndarray, has_sigma: bool) -> tuple[Parameter, ...]:
    model = problem.model
    sigmas = np.sqrt(np.maximum(np.diag(free), 0.0))
    found = [
        Parameter(name=name, kind=kind, nominal=float(nominal), value=float(value), sigma=float(sigma) if has_sigma else None)
        for name, kind, nominal, value, sigma in zip(model.names, model.kinds, model.nominal, state.p, sigmas, strict=True)
    ]
    table = nominal_parameters(problem.mechanism)
    return (
        *found,
        *(
            Parameter(name=n, kind=table[n][1], nominal=table[n][0], value=table[n][0], sigma=0.0, held=True)
            for n in problem.fixed
        ),
    )


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
        rows.append(
            Residual(
                configuration=int(used[i]),
                kind=kind,
                component=component,
                value=float(raw[i, k]),
                sigma=float(readings.sigma[i, k]),
                normalised=normal,
            )
        )
    return tuple(rows)


def state_residuals(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Return the readings of the model less those taken (n, K), radians and length unit; a group's from its weighted mean."""
    means = evaluate(problem, state.p, state.z, "means").linearised.residuals
    return np.asarray(means * np.where(problem.readings.taken, problem.readings.sigma, 0.0))
