"""Calibrate a mechanism in one call: build the problem, fit it, remove outliers, and build the result."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.configurations import (
    ROUGH_CLOSURE_TOLERANCE,
    SolvedConfigurations,
    determinant_signs,
    newton_configurations,
    solve_configurations,
    start_points,
)
from symkin.calibration.estimate.descent import is_rounding
from symkin.calibration.estimate.first_guess import fit_measuring_frames, parameters_from_poses
from symkin.calibration.estimate.lifted import estimate_by_ipopt
from symkin.calibration.estimate.problem import CalibrationProblem, NothingReadError, build_calibration
from symkin.calibration.estimate.robust import LOSSES, loss_note, robust_estimate
from symkin.calibration.estimate.solver import Estimate, descend_from, estimate, move_by_least_change
from symkin.calibration.estimate.starting import start_configurations, with_starts
from symkin.calibration.estimate.state import evaluate
from symkin.calibration.judge.assessment import Fit, build_result
from symkin.calibration.judge.outlier_removal import ScreenedFit, StartValues, fit_without_outliers
from symkin.calibration.judge.outliers import OUTLIER_LEVEL, Screening
from symkin.calibration.judge.result import Calibration, Parameter, Residual
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import Mechanism
from symkin.quiet import without_float_warnings

__all__ = ["METHODS", "OUTLIER_RULES", "Calibration", "Parameter", "Residual", "calibrate"]

METHODS = ("nested", "lifted", "ipopt")
_OTHER_METHOD = {"nested": "lifted", "lifted": "nested"}
"""The form that is tried where one does not converge: they cross curved valleys in different ways."""
_EXTENSION_FACTOR, _NEARLY_CONVERGED_RATIO, _NEARLY_CONVERGED_SHARE = 5, 3.0, 1e-3
"""An iteration that has not ended gets so many times its limit more where the residuals, root mean square, are below so many standard
deviations, or below this share of the size where these are not known."""
OUTLIER_RULES = ("remove", "report", "ignore")


@without_float_warnings
def calibrate(
    mechanism: Mechanism,
    measurements: Measurements,
    *,
    parameters: Sequence[str] | None = None,
    fixed: Sequence[str] = (),
    residual: str = "means",
    tolerance: tuple[float, float] | None = None,
    method: str = "nested",
    loss: str = "squared",
    outliers: str = "remove",
    level: float | None = None,
    max_iterations: int = 60,
    seed: int = 0,
) -> Calibration:
    """Identify a mechanism's geometry from measurements.

    `parameters` are names (default: all that the closure uses; see `model.parameter_names` for factors of readings and
    measuring frames), `fixed` those among them that keep their nominal values, which is one way to choose frames (see
    `gauge.joint_frames`); whatever else no reading tells is held by the least change from nominal. `tolerance` is the standard deviation
    to which lengths (length unit) and angles (radians) are made: the estimate is then the maximum a posteriori. `residual`: "means",
    "differences" or "maximum likelihood" (see `residuals`); `method`: "nested", "lifted" or "ipopt"; `loss`: "squared", "huber"
    or "cauchy" (see `robust`); `outliers`: "remove",
    "report" or "ignore", at the family-wise `level` (default 0.02); `seed` is for random starts of direct problems.

    Raises InputError for names, options and readings that do not fit, and where no posture's direct problem is solved.
    """
    if outliers == "ignore":
        refuse_ignored({"level": level}, "outliers = 'ignore' tests no reading")
    level = OUTLIER_LEVEL if level is None else level
    _check_choices(method, loss, outliers, level)
    begin = time.perf_counter()
    measurements.check(mechanism)
    _check_residual_form(residual, measurements)
    free = set(parameters or ()) - set(fixed)
    measurements = with_starts(mechanism, measurements, posed=not free & set(MEASURING_FRAMES))
    options: dict[str, object] = {"parameters": parameters, "fixed": fixed, "residual": residual, "tolerance": tolerance}

    def fit(readings: Measurements, near: StartValues | None = None) -> Fit:
        return _fit_measurements(mechanism, readings, options, method, max_iterations, seed, loss=loss, near=near)

    found = fit(measurements)
    screened = ScreenedFit(found, Screening((), ()))
    if outliers != "ignore":
        screened = fit_without_outliers(fit, measurements, found, level)
        found = screened.found if outliers == "remove" else found
    made = build_result(
        mechanism, measurements, found, screened.screening, method, time.perf_counter() - begin, outliers == "remove"
    )
    return replace(made, refused=made.refused or screened.refused)


# --- fitting -------------------------------------------------------------------------------------------------------


def _fit_measurements(
    mechanism: Mechanism, measurements: Measurements, options: dict[str, object], method: str, limit: int, seed: int, *, loss: str,
    near: StartValues | None = None,
) -> Fit:  # fmt: skip
    """Fit over the postures that can be solved; those that could not at nominal are tried again at the estimate. Postures without
    a reading beside the joints take no part."""
    heard = measurements.read
    if heard.any() and not heard.all():
        some = None if near is None else near.subset(heard)
        found = _fit_measurements(mechanism, measurements.subset(heard), options, method, limit, seed, loss=loss, near=some)
        numbers = np.flatnonzero(heard)
        return replace(found, used=numbers[found.used], unsolved=numbers[found.unsolved], silent=np.flatnonzero(~heard))
    problem = build_calibration(mechanism, measurements, **options)  # type: ignore[arg-type]
    start = _start_parameters(problem) if near is None else near.p
    p = problem.model.nominal if start is None else start
    postures = start_configurations(problem, p, seed=seed) if near is None else _solve_from(problem, p, near, seed)
    if not postures.solved.any():
        raise InputError(
            f"{mechanism.name}: the direct problem of no posture has a solution at the start geometry; check units, signs "
            "and the order of joints, or give starts"
        )
    p = fit_measuring_frames(problem, postures.z, p, postures.solved)
    _check_determined(problem, postures, p)
    part, notes = _solved_part(problem, postures, options), []
    result = _estimate_by(part, postures.z[postures.solved], method, limit, p)
    if not postures.solved.all():
        p = result.state.p
        solve = start_configurations if result.status == "ok" else _solve_roughly
        again = solve(problem, p, seed=seed + 1)
        if again.solved.sum() > postures.solved.sum():
            postures, part = again, _solved_part(problem, again, options)
            result = _estimate_by(part, again.z[again.solved], method, limit, p)
    if result.status != "ok" and method in _OTHER_METHOD:
        other = _estimate_by(part, postures.z[postures.solved], _OTHER_METHOD[method], limit, p)
        if other.status == "ok":
            notes.append(f"the {method} form did not converge ({result.status}); the {_OTHER_METHOD[method]} form was used")
            result = other
    if result.status == "max_iterations" and _is_nearly_converged(part, result):
        longer = _estimate_by(part, result.state.z, method, _EXTENSION_FACTOR * limit, result.state.p)
        result = replace(longer, iterations=result.iterations + longer.iterations)
    if result.status == "ok":
        result = _lower_cost(result, descend_from(part, postures.z[postures.solved], p, result))
    if result.null_space.shape[1]:
        result = move_by_least_change(part, result, "nested")
    if loss != "squared" and result.status == "ok":
        result = robust_estimate(part, result.state.p, result.state.z, loss).result
        notes.append(loss_note(loss))
    begin = determinant_signs(part.model.rows(postures.z[postures.solved], part.measurements.joints, p)[1])
    return Fit(part, result, np.flatnonzero(postures.solved), np.flatnonzero(~postures.solved), begin, tuple(notes), loss=loss)


def _start_parameters(problem: CalibrationProblem) -> np.ndarray | None:
    """Parameters that whole measured poses give by themselves; None without such poses, and where the file's own geometry gives the
    readings to rounding, which nothing may then move."""
    model, m = problem.model, problem.measurements
    start = parameters_from_poses(model, m)
    if start is None:
        return None
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(model, start_points(model, m), m.joints, model.nominal)
        stays = bool(solved.all()) and is_rounding(problem, evaluate(problem, model.nominal, z, "means"))
    return None if stays else start


def _solve_from(problem: CalibrationProblem, p: np.ndarray, near: StartValues, seed: int) -> SolvedConfigurations:
    """The direct problems from where an earlier fit has left them; postures that it had not begin where they would without it."""
    begun = start_points(problem.model, problem.measurements)
    begun = np.where(np.isnan(near.z), begun, near.z)
    return solve_configurations(problem.model, problem.measurements, p, z=begun, seed=seed, tolerance=ROUGH_CLOSURE_TOLERANCE)


def _solve_roughly(problem: CalibrationProblem, p: np.ndarray, *, seed: int) -> SolvedConfigurations:
    """The direct problems near their starts, whatever mode they end in."""
    return solve_configurations(problem.model, problem.measurements, p, seed=seed, tolerance=ROUGH_CLOSURE_TOLERANCE)


def _is_nearly_converged(problem: CalibrationProblem, result: Estimate) -> bool:
    """Whether the residuals are small although the iteration has not ended: a flat valley, along which it pays to go on."""
    scatter = float(np.sqrt(result.state.cost / problem.readings.count))
    return scatter < (_NEARLY_CONVERGED_RATIO if problem.readings.known else _NEARLY_CONVERGED_SHARE * problem.model.closure.size)


def _lower_cost(one: Estimate, other: Estimate | None) -> Estimate:
    """The estimate with the lower cost."""
    return one if other is None or other.status != "ok" or other.state.cost >= one.state.cost else other


def _estimate_by(problem: CalibrationProblem, z: np.ndarray, method: str, limit: int, p: np.ndarray | None = None) -> Estimate:
    if method == "ipopt":
        return estimate_by_ipopt(problem, z, max_iterations=limit, p=p)
    return estimate(problem, z, method=method, max_iterations=limit, p=p)


def _solved_part(problem: CalibrationProblem, postures: SolvedConfigurations, options: dict[str, object]) -> CalibrationProblem:
    if postures.solved.all():
        return problem
    some = problem.measurements.subset(postures.solved)
    try:
        return build_calibration(problem.mechanism, some, **options)  # type: ignore[arg-type]
    except NothingReadError:
        raise InputError(
            f"{problem.mechanism.name}: the direct problem of only {len(some)} of {len(problem.measurements)} postures has a solution "
            "at the start geometry, and these hold no reading that could be compared (no group of two postures is left, where groups "
            "are what was read); check that the data is of this mechanism, units, signs and the order of joints, or give starts"
        ) from None


def _check_determined(problem: CalibrationProblem, postures: SolvedConfigurations, p: np.ndarray) -> None:
    """Joint readings must fix the pose: each posture's closure has full column rank in its unknown coordinates."""
    rows_z = problem.model.rows(postures.z, problem.measurements.joints, p)[1][postures.solved]
    if rows_z.shape[2] == 0:
        return
    singular = np.linalg.svd(rows_z, compute_uv=False)
    short = rows_z.shape[1] < rows_z.shape[2] or bool(np.all(singular[:, -1] < 1e-10 * singular[:, 0]))
    if short:
        raise InputError(
            f"{problem.mechanism.name}: the actuated joints do not determine the pose; calibration needs a direct problem with "
            "isolated solutions: actuate more joints, or declare the platform's motion"
        )


def _check_residual_form(residual: str, measurements: Measurements) -> None:
    """Refuse a form of residuals that these readings make no use of, so that it would be that of means."""
    groups = np.array([NO_GROUP]) if measurements.groups is None else measurements.groups
    asked = {f"residual = {residual!r}": residual}
    if residual == "differences" and not np.any(groups != NO_GROUP):
        refuse_ignored(asked, "differences are between neighbours in a group, and there are no groups")
    if residual == "maximum likelihood" and measurements.joint_sigma is None:
        reason = "it weighs the noise of the joint readings, which is not known"
        refuse_ignored(asked, reason, "give it (sigma_ columns of the joints, --sigma-joints)")


def _check_choices(method: str, loss: str, outliers: str, level: float) -> None:
    if method not in METHODS:
        raise InputError(f"method = {method!r} is unknown; allowed: {', '.join(METHODS)}")
    if loss not in LOSSES:
        raise InputError(f"loss = {loss!r} is unknown; allowed: {', '.join(LOSSES)}")
    if outliers not in OUTLIER_RULES:
        raise InputError(f"outliers = {outliers!r} is unknown; allowed: {', '.join(OUTLIER_RULES)}")
    if not 0.0 < level < 1.0:
        raise InputError(f"level = {level!r}: a probability between 0 and 1 is needed")
