"""Calibration as one call."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symkin.calibration.direct import ROUGH, Postures, signs, solve_postures
from symkin.calibration.estimator import Estimate, descended, estimate
from symkin.calibration.frames import frames_at
from symkin.calibration.from_poses import parameters_from_poses
from symkin.calibration.gauge import least_change
from symkin.calibration.lifted import estimate_by_ipopt
from symkin.calibration.linear import linear_model
from symkin.calibration.measurements import Measurements
from symkin.calibration.outcome import Fitted, report
from symkin.calibration.outliers import LEVEL, Outlier, Screening, most_outliers, screen
from symkin.calibration.parameters import FRAMES
from symkin.calibration.problem import CalibrationProblem, NothingReadError, build_calibration
from symkin.calibration.result import Calibration, Parameter, Residual
from symkin.calibration.starting import start_postures, started
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.quiet import without_float_warnings

__all__ = ["METHODS", "OUTLIER_RULES", "Calibration", "Parameter", "Residual", "calibrate"]

METHODS = ("nested", "lifted", "ipopt")
_OTHER = {"nested": "lifted", "lifted": "nested"}
"""The form that is tried where one does not converge: they cross curved valleys in different ways."""
_LONGER, _NEAR, _SMALL = 5, 3.0, 1e-3
"""An iteration that has not ended gets so many times its limit more where the residuals, root mean square, are below so many standard
deviations, or below this share of the size where these are not known."""
_DOUBTFUL = 2.0
"""Chi-square per reading above which another way to the minimum is tried where some parameters are only told on the way."""
OUTLIER_RULES = ("remove", "report", "ignore")
_GROSS = 0.1
"""Outliers whose statistic is this share of the largest, or more, are taken out together."""


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
    outliers: str = "remove",
    level: float = LEVEL,
    max_iterations: int = 60,
    seed: int = 0,
) -> Calibration:
    """Identify a mechanism's geometry from measurements.

    `parameters` are names (default: all that the closure uses; see `model.parameter_names` for factors of readings and
    measuring frames), `fixed` those among them that keep their nominal values, which is one way to choose frames (see
    `gauge.joint_frames`); whatever else no reading tells is held by the least change from nominal. `tolerance` is the standard deviation
    to which lengths (length unit) and angles (radians) are made: the estimate is then the maximum a posteriori. `residual`: "means",
    "differences" or "maximum likelihood" (see `residuals`); `method`: "nested", "lifted" or "ipopt"; `outliers`: "remove",
    "report" or "ignore", at the family-wise `level`; `seed` is for random starts of direct problems.

    Raises InputError for names, options and readings that do not fit, and where no posture's direct problem is solved.
    """
    _check_choices(method, outliers, level)
    begin = time.perf_counter()
    measurements.check(mechanism)
    free = set(parameters or ()) - set(fixed)
    measurements = started(mechanism, measurements, posed=not free & set(FRAMES))
    options: dict[str, object] = {"parameters": parameters, "fixed": fixed, "residual": residual, "tolerance": tolerance}
    found = _fit(mechanism, measurements, options, method, max_iterations, seed)
    screening = Screening((), ())
    if outliers != "ignore" and found.result.status == "ok":
        fit = partial(_fit, mechanism, options=options, method=method, limit=max_iterations, seed=seed)
        screening, cleaned = _screened(fit, measurements, found, level)
        found = cleaned if outliers == "remove" else found
    return report(mechanism, measurements, found, screening, method, time.perf_counter() - begin, outliers == "remove")


def _screened(
    fit: Callable[[Measurements], Fitted], measurements: Measurements, found: Fitted, level: float
) -> tuple[Screening, Fitted]:
    """Outliers, and the fit without them. A gross error bends the fit beyond its linear range and makes others of the good:
    in each round only those go that are within _GROSS of the largest statistic, and the rest is judged at a new fit."""
    first, taken_out, allowed = found, list[Outlier](), None
    unchecked: tuple[tuple[int, str], ...] = ()
    while found.result.status == "ok":
        model = linear_model(found.problem, found.result.state)
        screening = _renumbered(screen(found.problem, model, level=level, share=_GROSS), found.used)
        if allowed is None:
            allowed, unchecked = most_outliers(found.problem), screening.unchecked
        if not screening.outliers and not screening.given_up:
            return Screening(tuple(taken_out), unchecked), found
        taken_out += (*screening.outliers, *screening.given_up)
        if screening.given_up or len(taken_out) > allowed:
            return Screening((), unchecked, tuple(taken_out)), first
        found = fit(_without(measurements, taken_out))
    return Screening((), unchecked, tuple(taken_out)), first


# --- fitting -------------------------------------------------------------------------------------------------------


def _fit(
    mechanism: Mechanism, measurements: Measurements, options: dict[str, object], method: str, limit: int, seed: int
) -> Fitted:
    """Fit over the postures that can be solved; those that could not at nominal are tried again at the estimate. Postures without
    a reading beside the joints take no part."""
    heard = measurements.read
    if heard.any() and not heard.all():
        found = _fit(mechanism, measurements.subset(heard), options, method, limit, seed)
        numbers = np.flatnonzero(heard)
        return replace(found, used=numbers[found.used], unsolved=numbers[found.unsolved], silent=np.flatnonzero(~heard))
    problem = build_calibration(mechanism, measurements, **options)  # type: ignore[arg-type]
    start = parameters_from_poses(problem.model, measurements)
    p = problem.model.nominal if start is None else start
    postures = start_postures(problem, p, seed=seed)
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
    if result.status == "ok" and _is_doubtful(part, result):
        result = _lower(result, descended(part, postures.z[postures.solved], p))
    if result.null_space.shape[1]:
        result = least_change(part, result, "nested")
    begin = signs(part.model.rows(postures.z[postures.solved], part.measurements.joints, p)[1])
    return Fitted(part, result, np.flatnonzero(postures.solved), np.flatnonzero(~postures.solved), begin, tuple(notes))


def _solve_roughly(problem: CalibrationProblem, p: np.ndarray, *, seed: int) -> Postures:
    """The direct problems near their starts, whatever mode they end in."""
    return solve_postures(problem.model, problem.measurements, p, seed=seed, tolerance=ROUGH)


def _is_near(problem: CalibrationProblem, result: Estimate) -> bool:
    """Whether the residuals are small although the iteration has not ended: a flat valley, along which it pays to go on."""
    scatter = float(np.sqrt(result.state.cost / problem.readings.count))
    return scatter < (_NEAR if problem.readings.known else _SMALL * problem.model.closure.size)


def _is_doubtful(problem: CalibrationProblem, result: Estimate) -> bool:
    """Whether noise does not explain what is left."""
    return not problem.readings.known or result.state.cost > _DOUBTFUL * problem.readings.count


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


def _without(measurements: Measurements, outliers: Sequence[Outlier]) -> Measurements:
    for o in outliers:
        measurements = measurements.without(o.posture, o.kind)
    return measurements


def _renumbered(screening: Screening, used: np.ndarray) -> Screening:
    return Screening(
        tuple(replace(o, posture=int(used[o.posture])) for o in screening.outliers),
        tuple((int(used[k]), kind) for k, kind in screening.unchecked),
        tuple(replace(o, posture=int(used[o.posture])) for o in screening.given_up),
    )


def _check_choices(method: str, outliers: str, level: float) -> None:
    if method not in METHODS:
        raise InputError(f"method = {method!r} is unknown; allowed: {', '.join(METHODS)}")
    if outliers not in OUTLIER_RULES:
        raise InputError(f"outliers = {outliers!r} is unknown; allowed: {', '.join(OUTLIER_RULES)}")
    if not 0.0 < level < 1.0:
        raise InputError(f"level = {level!r}: a probability between 0 and 1 is needed")
