"""Calibrate a mechanism in one call: build the problem, fit it, remove outliers, and build the
result.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    SolvedConfigurations,
    determinant_signs,
    first_points,
    is_determined,
    refuse_undetermined,
    solve_configurations,
    start_points,
)
from symkin.calibration.estimate.estimator import Estimate, estimate, parameters_at_poses
from symkin.calibration.estimate.joint_lines import (
    dh_names,
    has_nearly_parallel_axes,
    lines_problem,
    table_of_lines,
)
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.robust import loss_note, robust_estimate
from symkin.calibration.estimate.starting import (
    fit_measuring_frames,
    start_configurations,
    went_astray,
    with_starts,
)
from symkin.calibration.judge.assessment import build_result
from symkin.calibration.judge.deviations import estimate_deviations
from symkin.calibration.judge.outliers import (
    OUTLIER_LEVEL,
    Fit,
    FitFunction,
    Screening,
    fit_without_outliers,
)
from symkin.calibration.judge.result import Calibration
from symkin.calibration.judge.statistics import SIGNIFICANCE, chi_square_tail
from symkin.calibration.options import CalibrateOptions
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.numeric.linear_algebra import largest_of
from symkin.verb import verb
from symkin.verb_options import check_seed, refuse_ignored

_MAX_SCREENINGS = 3
"""Searches for outliers again, by the deviations of the readings that the one before kept."""
_MAX_ROUNDS = 6
"""Fits by which standard deviations that are not stated are estimated."""


@verb(CalibrateOptions)
def calibrate(
    mechanism: Mechanism, measurements: Measurements, **options: Unpack[CalibrateOptions]
) -> Calibration:
    """Identify a mechanism's geometry from measurements.

    The parameters p minimise sum |W (h(z_i, p) - m_i)|^2 over the configurations i, with readings
    m_i, their model h and weights W from the standard deviations (see `estimate.residuals`), where
    each configuration meets its closure F(z_i; q_i, p) = 0 at the joint readings q_i. What no
    reading determines is held by the least change from nominal.

    `parameters` names what is identified, factors of readings and measuring frames too (see
    `parameter_names`), by default all that matter; those in `fixed` keep their nominal values,
    which is one way to choose frames (see `joint_frames`). `residual` is "means", "differences" or
    "maximum likelihood" (see `residuals`); `tolerance` gives the standard deviations to which
    lengths (length unit) and angles (radians) are manufactured, and the estimate is then the
    maximum a posteriori. `method` is "nested" (other names are of before), of at most
    `max_iterations` steps; `loss` "squared", "huber" or "cauchy" (see `robust`); `outliers`
    "remove", "report" or "ignore", where a share `level` (default 0.02) of clean data sets may have
    a reading called one. `seed` is that of random starts of direct problems; with `any_machine` a
    geometry far from the file's is believed, too.

    Raises InputError for names, options and readings that do not fit, and where no configuration's
    direct problem is solved. Source: Hollerbach, Khalil, Gautier, Model Identification, Springer
    Handbook of Robotics, 2016.

    >>> import numpy as np, symkin
    >>> arm = symkin.load("gluon_6l3")
    >>> joints = np.random.default_rng(1).uniform(-90.0, 90.0, (12, 6))
    >>> tips = [symkin.solve(arm, joints=q).solution.position + [0.0, 0.0, 0.5] for q in joints]
    >>> readings = symkin.Measurements(
    ...     np.radians(joints), position=np.array(tips), position_sigma=0.01
    ... )
    >>> found = symkin.calibrate(arm, readings, parameters=["dh.1.d"])
    >>> found.status, round(found.values["dh.1.d"], 3)
    ('ok', 105.53)
    """
    require_mechanism(mechanism)
    check_seed(options["seed"])
    if options["outliers"] == "ignore":
        refuse_ignored({"level": options["level"]}, "outliers = 'ignore' tests no reading")
    level = OUTLIER_LEVEL if options["level"] is None else options["level"]
    if not 0.0 < level < 1.0:
        raise InputError(f"level = {level!r}: a probability between 0 and 1 is needed")
    try:
        return _calibrate(mechanism, measurements, options, level)
    except np.linalg.LinAlgError:
        closure = build_closure(mechanism)
        unknown = sum(c.freedom for c in closure.role("passive", "body", "pose"))
        why = (
            ": loops that are redundant close at no geometry near the file's for these readings"
            if closure.rows.numel() > unknown
            else ""
        )
        raise InputError(
            f"{mechanism.name}: the fit broke down, its equations are no finite numbers{why}; "
            "identify fewer parameters, or check units and signs"
        ) from None


def _calibrate(
    mechanism: Mechanism, measurements: Measurements, options: CalibrateOptions, level: float
) -> Calibration:
    begin, method = time.perf_counter(), options["method"]
    measurements.check(mechanism)
    # forms of residuals that these readings make no use of would be that of means
    form = options["residual"]
    asked = {f"residual = {form!r}": form}
    if form == "differences" and not np.any(measurements.group_of != NO_GROUP):
        refuse_ignored(
            asked, "differences are between neighbours in a group, and there are no groups"
        )
    if form == "maximum likelihood" and measurements.joint_sigma is None:
        reason = "it weighs the noise of the joint readings, which is not known"
        refuse_ignored(asked, reason, "give it (sigma_ columns of the joints, --sigma-joints)")
    measurements = with_starts(mechanism, measurements, options["parameters"], options["fixed"])
    found, screening = _screened(mechanism, options, measurements, level)
    if method != "nested":
        note = f"method {method!r} is one with 'nested' now; the name goes with the next release"
        found = replace(found, notes=(*found.notes, note))
    result = build_result(measurements, found, screening, removed=options["outliers"] == "remove")
    return replace(result, method=method, elapsed_s=time.perf_counter() - begin)


# --- fitting --------------------------------------------------------------------------------------


def _screened(
    mechanism: Mechanism, options: CalibrateOptions, measurements: Measurements, level: float
) -> tuple[Fit, Screening]:
    """Fit, without outliers if asked: what instruments that state no deviation scatter by is
    estimated from all readings first, then from those that belong.
    """
    fit: FitFunction = partial(_fit_measurements, mechanism, options, {})
    found, rule = fit(measurements, None), options["outliers"]

    def weighed(by: Fit) -> tuple[FitFunction, Fit] | None:
        """Fit all by the deviations that a fit leaves; None where those it was weighed by stand."""
        if by.status != "ok" or not (estimated := estimate_deviations(by)):
            return None
        again = partial(_fit_measurements, mechanism, options, estimated)
        made = again(measurements, by)
        return (again, made) if made.status == "ok" else None

    for _ in range(_MAX_ROUNDS):
        if (better := weighed(found)) is None:
            break
        fit, found = better
    if rule == "ignore":
        return found, Screening()
    clean, screening = fit_without_outliers(fit, measurements, found, level)
    for _ in range(_MAX_SCREENINGS):
        if not screening.outliers or (better := weighed(clean)) is None:
            break
        fit, found = better
        clean, screening = fit_without_outliers(fit, measurements, found, level)
    return clean if rule == "remove" else found, screening


def _fit_measurements(
    mechanism: Mechanism,
    options: CalibrateOptions,
    estimated: Mapping[str, float],
    measurements: Measurements,
    near: Fit | None,
) -> Fit:
    """Fit the configurations that hold a reading beside the joints, from where another fit has
    ended, if given.
    """
    read = measurements.is_read
    numbers = np.flatnonzero(read | ~read.any())
    chosen: dict[str, Any] = {
        key: options[key] for key in ("parameters", "fixed", "residual", "tolerance")
    }
    problem = build_calibration(
        mechanism, measurements.subset(numbers), **chosen, estimated=estimated
    )
    p, z = None, np.full((len(measurements), problem.model.system.width), np.nan)
    if near is not None:
        p, z[near.used] = near.state.p, near.state.z
    found = _Fitting(options, problem).run(p, z[numbers])
    return replace(
        found,
        used=numbers[found.used],
        unsolved=numbers[found.unsolved],
        silent=np.flatnonzero(~read).tolist(),
    )


class _Fitting:
    """Fit one problem: over the configurations that can be solved; those that could not at nominal
    are tried again at the estimate.
    """

    def __init__(self, options: CalibrateOptions, problem: CalibrationProblem) -> None:
        self.options, self.problem = options, problem
        self.estimate = partial(estimate, max_iterations=options["max_iterations"])

    def run(self, near: np.ndarray | None, z: np.ndarray) -> Fit:
        """Fit from the parameters `near`, if given, and the configurations z that are numbers."""
        problem, model, begun = self.problem, self.problem.model, None
        joints, p = problem.joints, model.nominal
        if near is not None:
            # those that the earlier fit had not begin where they would without it
            p, begun = near, first_points(model, problem.measurements, near)
            begun = np.where(np.isnan(z), begun, z)
        elif (start := parameters_at_poses(problem)) is not None:
            # the rows close at poses, too, where a geometry has shrunk to what does not move
            points = start_points(model, problem.measurements)
            p = start if is_determined(model, points, joints, start) else p
        solved = self._solve(p, begun)
        if not solved.solved.any():
            raise InputError(
                f"{problem.mechanism.name}: the direct problem of no posture has a solution "
                f"at the start geometry; check units, signs and the order of joints, or give starts"
            )
        if near is None:
            p, some = fit_measuring_frames(problem, solved.z, p, solved.solved), solved.solved
            refuse_undetermined(model, solved.z[some], joints[some], p)
            # their mode may end before this geometry: they join at the estimate
            solved = solved._replace(solved=some & ~went_astray(problem, p, solved))
        part, result = self._fitted(solved, p)
        if not solved.solved.all():
            # near their starts, whatever mode they end in, where it did not converge
            p, judged = result.state.p, result.status == "ok"
            again = self._solve(p, more=1, judged=judged)
            if again.solved.sum() > solved.solved.sum():
                solved, (part, result) = again, self._fitted(again, p)
        result, loss = self._by_lines(part, result), self.options["loss"]
        robust = loss != "squared" and result.status == "ok"
        if robust:
            result = robust_estimate(part, result.state.p, result.state.z, loss)[0]
        rows_z = model.values("rows", solved.z[solved.solved], part.joints, p)[1]
        return Fit(
            **vars(result),
            problem=replace(part, widened=result.widened),
            used=np.flatnonzero(solved.solved),
            unsolved=np.flatnonzero(~solved.solved),
            start_signs=determinant_signs(rows_z),
            notes=(loss_note(loss),) if robust else (),
            loss=loss,
            any_machine=self.options["any_machine"],
        )

    def _by_lines(self, part: CalibrationProblem, result: Estimate) -> Estimate:
        """Fit an arm with nearly parallel axes by its lines, and go on from there, where its table
        alone does not explain the readings; the better of both. The table comes first: its prior
        holds offsets along such axes near the file's, those of lines may be long and cancel.
        """
        arm, m = part.mechanism, part.measurements
        whole = set(dh_names(arm)) <= set(part.names)
        if part.is_stated or not whole or not has_nearly_parallel_axes(arm):
            return result
        cost, freedom = result.state.cost, part.readings.count - len(part.names)
        explained = part.readings.known and chi_square_tail(cost, freedom) > SIGNIFICANCE
        if result.status == "ok" and explained:
            return result
        lines = lines_problem(part)
        nominal = lines.model.nominal
        found = self.estimate(lines, solve_configurations(lines.model, m, nominal).z)
        p = table_of_lines(part, lines, found.state.p)
        wide = replace(part, widened=max(1.0, largest_of(part.over_prior(p))))
        other = self.estimate(wide, solve_configurations(part.model, m, p).z, p=p)
        better = other.status == "ok" and (other.state.cost < cost or result.status != "ok")
        return replace(other, iterations=found.iterations + other.iterations) if better else result

    def _solve(
        self, p: np.ndarray, z: np.ndarray | None = None, *, more: int = 0, judged: bool = True
    ) -> SolvedConfigurations:
        """Solve the direct problems from z if given, else in the modes that their readings fit; in
        any if these are not `judged`.
        """
        seed, problem = self.options["seed"] + more, self.problem
        if judged and z is None:
            return start_configurations(problem, p, seed=seed)
        tolerance = ROUGHLY_SOLVED_TOLERANCE
        return solve_configurations(
            problem.model, problem.measurements, p, z=z, seed=seed, tolerance=tolerance
        )

    def _fitted(
        self, solved: SolvedConfigurations, p: np.ndarray
    ) -> tuple[CalibrationProblem, Estimate]:
        """Fit the configurations that are solved: their problem, and the estimate from p."""
        problem, every = self.problem, solved.solved.all()
        part = problem if every else problem.of(solved.solved)
        if not every and part.readings.count <= 0:
            raise InputError(
                f"{problem.mechanism.name}: the direct problem of only {len(part.joints)} of "
                f"{len(problem.measurements)} postures has a solution "
                "at the start geometry, and these hold no reading that could be compared (no group "
                "of two postures is left, where groups "
                "are what was read); check that the data is of this mechanism, units, signs and "
                "the order of joints, or give starts"
            )
        return part, self.estimate(part, solved.z[solved.solved], p=p)
