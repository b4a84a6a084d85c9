"""Calibration as one call."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.calibration.descent import is_rounding
from symkin.calibration.direct import ROUGH, Postures, newton_postures, signs, solve_postures, start_points
from symkin.calibration.estimator import Estimate, descended, estimate
from symkin.calibration.frames import frames_at
from symkin.calibration.from_poses import parameters_from_poses
from symkin.calibration.gauge import least_change
from symkin.calibration.lifted import estimate_by_ipopt
from symkin.calibration.measurements import NO_GROUP, Measurements
from symkin.calibration.outcome import Fitted, report
from symkin.calibration.outliers import LEVEL, Screening
from symkin.calibration.parameters import FRAMES
from symkin.calibration.problem import CalibrationProblem, NothingReadError, build_calibration
from symkin.calibration.removal import Cleaned, Near, cleaned
from symkin.calibration.result import Calibration, Parameter, Residual
from symkin.calibration.robust import LOSSES, loss_note, robust_estimate
from symkin.calibration.starting import start_postures, started
from symkin.calibration.state import evaluate
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import Mechanism
from symkin.quiet import without_float_warnings

__all__ = ["METHODS", "OUTLIER_RULES", "Calibration", "Parameter", "Residual", "calibrate"]

METHODS = ("nested", "lifted", "ipopt")
_OTHER = {"nested": "lifted", "lifted": "nested"}
"""The form that is tried where one does not converge: they cross curved valleys in different ways."""
_LONGER, _NEAR, _SMALL = 5, 3.0, 1e-3
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
    level = LEVEL if level is None else level
    _check_choices(method, loss, outliers, level)
    begin = time.perf_counter()
    measurements.check(mechanism)
    _check_form(residual, measurements)
    free = set(parameters or ()) - set(fixed)
    measurements = started(mechanism, measurements, posed=not free & set(FRAMES))
    options: dict[str, object] = {"parameters": parameters, "fixed": fixed, "residual": residual, "tolerance": tolerance}

    def fit(readings: Measurements, near: Near | None = None) -> Fitted:
        return _fit(mechanism, readings, options, method, max_iterations, seed, loss=loss, near=near)

    found = fit(measurements)
    screened = Cleaned(found, Screening((), ()))
    if outliers != "ignore":
        screened = cleaned(fit, measurements, found, level)
        found = screened.found if outliers == "remove" else found
    made = report(mechanism, measurements, found, screened.screening, method, time.perf_counter() - begin, outliers == "remove")
    return replace(made, refused=made.refused or screened.refused)


# --- fitting -------------------------------------------------------------------------------------------------------


def _fit(
    mechanism: Mechanism, measurements: Measurements, options: dict[str, object], method: str, limit: int, seed: int, *, loss: str,
    near: Near | None = None,
) -> Fitted:  # fmt: skip
    """Fit over the postures that can be solved; those that could not at nominal are tried again at the estimate. Postures without
    a reading beside the joints take no part."""
    heard = measurements.read
    if heard.any() and not heard.all():
        some = None if near is None else near.subset(heard)
        found = _fit(mechanism, measurements.subset(heard), options, method, limit, seed, loss=loss, near=some)
        numbers = np.flatnonzero(heard)
        return replace(found, used=numbers[found.used], unsolved=numbers[found.unsolved], silent=np.flatnonzero(~heard))
    problem = build_calibration(mechanism, measurements, **options)  # type: ignore[arg-type]
    start = _start_parameters(problem) if near is None else near.p
    p = problem.model.nominal if start is None else start
    postures = start_postures(problem, p, seed=seed) if near is None else _solved_near(problem, p, near, seed)
    if not postures.solved.any():
        raise InputError(
            f"{mechanism.name}: the direct problem of no posture has a solution at the start geometry; check units, signs "
            "and the order of joints, or give starts"
        )
    p = frames_at(problem, postures.z, p, postures.solved)
    _check_determined(problem, postures, p)
    part, notes = _partial(problem, postures, options), []
    result = _estimate(part, postures.z[postures.solved], method, limit, p)
    if not postures.solved.all():
        p = result.state.p
        solve = start_postures if result.status == "ok" else _solve_roughly
        again = solve(problem, p, seed=seed + 1)
        if again.solved.sum() > postures.solved.sum():
            postures, part = again, _partial(problem, again, options)
            result = _estimate(part, again.z[again.solved], method, limit, p)
    if result.status != "ok" and method in _OTHER:
        other = _estimate(part, postures.z[postures.solved], _OTHER[method], limit, p)
        if other.status == "ok":
            notes.append(f"the {method} form did not converge ({result.status}); the {_OTHER[method]} form was used")
            result = other
    if result.status == "max_iterations" and _is_near(part, result):
        longer = _estimate(part, result.state.z, method, _LONGER * limit, result.state.p)
        result = replace(longer, iterations=result.iterations + longer.iterations)
    if result.status == "ok":
        result = _lower(result, descended(part, postures.z[postures.solved], p, result))
    if result.null_space.shape[1]:
        result = least_change(part, result, "nested")
    if loss != "squared" and result.status == "ok":
        result = robust_estimate(part, result.state.p, result.state.z, loss).result
        notes.append(loss_note(loss))
    begin = signs(part.model.rows(postures.z[postures.solved], part.measurements.joints, p)[1])
    return Fitted(part, result, np.flatnonzero(postures.solved), np.flatnonzero(~postures.solved), begin, tuple(notes), loss=loss)


def _start_parameters(problem: CalibrationProblem) -> np.ndarray | None:
    """Parameters that whole measured poses give by themselves; None without such poses, and where the file's own geometry gives the
    readings to rounding, which nothing may then move."""
    model, m = problem.model, problem.measurements
    start = parameters_from_poses(model, m)
    if start is None:
        return None
    with np.errstate(all="ignore"):
        z, solved = newton_postures(model, start_points(model, m), m.joints, model.nominal)
        stays = bool(solved.all()) and is_rounding(problem, evaluate(problem, model.nominal, z, "means"))
    return None if stays else start


def _solved_near(problem: CalibrationProblem, p: np.ndarray, near: Near, seed: int) -> Postures:
    """The direct problems from where an earlier fit has left them; postures that it had not begin where they would without it."""
    begun = start_points(problem.model, problem.measurements)
    begun = np.where(np.isnan(near.z), begun, near.z)
    return solve_postures(problem.model, problem.measurements, p, z=begun, seed=seed, tolerance=ROUGH)


def _solve_roughly(problem: CalibrationProblem, p: np.ndarray, *, seed: int) -> Postures:
    """The direct problems near their starts, whatever mode they end in."""
    return solve_postures(problem.model, problem.measurements, p, seed=seed, tolerance=ROUGH)


def _is_near(problem: CalibrationProblem, result: Estimate) -> bool:
    """Whether the residuals are small although the iteration has not ended: a flat valley, along which it pays to go on."""
    scatter = float(np.sqrt(result.state.cost / problem.readings.count))
    return scatter < (_NEAR if problem.readings.known else _SMALL * problem.model.closure.size)


def _lower(one: Estimate, other: Estimate | None) -> Estimate:
    """The estimate with the lower cost."""
    return one if other is None or other.status != "ok" or other.state.cost >= one.state.cost else other


def _estimate(problem: CalibrationProblem, z: np.ndarray, method: str, limit: int, p: np.ndarray | None = None) -> Estimate:
    if method == "ipopt":
        return estimate_by_ipopt(problem, z, max_iterations=limit, p=p)
    return estimate(problem, z, method=method, max_iterations=limit, p=p)


def _partial(problem: CalibrationProblem, postures: Postures, options: dict[str, object]) -> CalibrationProblem:
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


def _check_determined(problem: CalibrationProblem, postures: Postures, p: np.ndarray) -> None:
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


def _check_form(residual: str, measurements: Measurements) -> None:
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
