"""Build the result of a calibration from its fit: standard deviations, residuals, chi-square, and notes that its reader must know."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import is_writable, nominal_parameters
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import only_rounding
from symkin.calibration.estimate.robust import EFFICIENCY
from symkin.calibration.estimate.solver import Estimate
from symkin.calibration.estimate.state import State, evaluate
from symkin.calibration.judge.identifiability import identifiability_at
from symkin.calibration.judge.named_directions import all_values, nearly_parallel
from symkin.calibration.judge.outliers import Screening
from symkin.calibration.judge.plausibility import LARGE_CHANGE, beyond_tolerances, large_changes
from symkin.calibration.judge.read_back import read_back
from symkin.calibration.judge.result import Calibration, Parameter, Residual
from symkin.calibration.judge.statistics import (
    DOUBTFUL_CURVATURE,
    SIGNIFICANCE,
    LinearModel,
    chi_square_tail,
    covariance,
    curvature,
    linear_model,
)
from symkin.text import first_of

_MAX_NAMED_TOLERANCES = 5
"""Parameters beyond their tolerances that are named at most."""
_MAX_CONDITION = 1e6
"""Condition of the identification Jacobian above which digits of the parameters are lost."""


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


def fit_notes(fit: Calibration, *, removed: bool) -> Iterator[str]:
    """Yield doubts and facts about a fit that its reader must know, each a sentence with its figure."""
    yield from _configuration_notes(fit)
    yield from _residual_notes(fit)
    yield from _rank_notes(fit)
    for o in fit.outliers:
        yield ("left out: " if removed else "outlier: ") + o.reason
    if fit.given_up:
        yield (
            f"so many readings do not belong, {len(fit.given_up)} and more, that none was left out: the readings or the model are "
            f"wrong as a whole; the first was {fit.given_up[0].reason}"
        )
    if fit.unchecked:
        yield f"nothing else checks {first_of([f'{kind} of posture {fit.measurements.labels[k]}' for k, kind in fit.unchecked])}"


def _configuration_notes(fit: Calibration) -> Iterator[str]:
    labels = fit.measurements.labels
    if fit.unsolved:
        yield (
            f"not used: the direct problem of posture {first_of([labels[k] for k in fit.unsolved])} was not solved, neither at "
            "the nominal nor at the identified geometry; check the joint readings or give starts"
        )
    judged = {o.configuration for o in (*fit.outliers, *fit.given_up)}
    silent = [labels[k] for k in fit.silent if k not in judged]
    if silent:
        yield f"not used: posture {first_of(silent)} holds no reading beside the joints (a group of two postures or more, or a sensor's)"
    if fit.changed_mode:
        yield f"posture {first_of([labels[k] for k in fit.changed_mode])} crossed a singularity and changed its assembly mode"
    groups = fit.measurements.groups
    if groups is not None:
        numbers, counts = np.unique(groups[groups >= 0], return_counts=True)
        if np.any(counts == 1):
            yield f"group {first_of([str(g) for g in numbers[counts == 1]])} has one posture and says nothing"


def _residual_notes(fit: Calibration) -> Iterator[str]:
    if fit.status != "ok":
        yield f"the iteration ended with {fit.status} after {fit.iterations} steps; the values are not a minimum"
    if fit.degrees <= 0:
        yield "there are no degrees of freedom left: the residuals are zero for any noise and nothing is checked; add postures"
    elif fit.p_value is None:
        yield "standard deviations are missing: those of the parameters are scaled by the residuals, and chi-square tests nothing"
    elif fit.p_value < SIGNIFICANCE:
        ratio = fit.chi_square / fit.degrees
        yield (
            f"not believable with the stated noise: chi-square per degree of freedom is {ratio:.3g}, probability {fit.p_value:.1g}; "
            "the noise is larger than stated or the model lacks something"
        )
    elif 1.0 - fit.p_value < SIGNIFICANCE:
        yield (
            f"chi-square per degree of freedom is only {fit.chi_square / fit.degrees:.3g}: the stated noise is too large, and the "
            "standard deviations with it"
        )
    if is_exact(fit):
        yield "the residuals are rounding only: is this a plan, or a simulation without noise?"
    yield from (
        f"{name} moved by {times:.3g} times its tolerance" for name, times in beyond_tolerances(fit)[:_MAX_NAMED_TOLERANCES]
    )
    far = [p.name for p in large_changes(fit)]
    if far:
        yield f"{first_of(far)} moved by more than {100 * LARGE_CHANGE:.0f} % of the size (angles: {LARGE_CHANGE} rad); check units and nominal values"


def is_exact(fit: Calibration) -> bool:
    """Tell whether the fit has degrees of freedom and yet leaves no residual above rounding: no instrument reads so."""
    size = fit.mechanism.size
    return fit.status == "ok" and fit.degrees > 0 and all(only_rounding(r.kind, r.value, size) for r in fit.residuals)


def _rank_notes(fit: Calibration) -> Iterator[str]:
    found = fit.identifiability
    if not found.is_clear:
        yield f"the rank {found.rank} is not clear: singular values fall by a factor of only {found.gap:.3g} there{_parallel_axes_note(fit)}"
    if found.condition > _MAX_CONDITION:
        yield f"the identification Jacobian has condition {found.condition:.2g}; {_parallel_axes_note(fit)[2:] or 'choose postures that differ more'}"
    if found.unobservable:
        yield f"not observable, held by the least change from nominal: {'; '.join(found.unobservable)}"
    yield from found.advice


def _parallel_axes_note(fit: Calibration) -> str:
    """Say what nearly parallel axes have to do with a rank that is not clear."""
    pairs = nearly_parallel(fit.mechanism, all_values(fit.problem.model, fit.state.p))
    free = {n for n in fit.problem.names if n.endswith(".d")}
    if not pairs or len(free) < 2:
        return ""
    return f"; {', '.join(pairs)} are parallel axes or nearly so, and their offsets d are told by how little they are not: hold one of each pair"
