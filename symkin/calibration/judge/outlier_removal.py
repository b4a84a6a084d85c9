"""Fit without readings that do not belong: one after the other, or all that the majority of the
readings speaks against.

Each refit starts from the fit before it. One that does not converge, or fits the readings left
worse, is undone. What was taken out is judged once more by the last fit: a reading that agrees with
it is put back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configurations import (
    SOLVED_TOLERANCE,
    first_points,
    newton_configurations,
)
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.residuals import deviations
from symkin.calibration.estimate.robust import normalised_residuals, robust_estimate
from symkin.calibration.estimate.state import evaluate, joint_covariance, readings_at
from symkin.calibration.judge.assessment import Fit
from symkin.calibration.judge.outliers import (
    Outlier,
    Screening,
    describe_outlier,
    max_outliers,
    reading_kinds,
    screen_readings,
)
from symkin.calibration.judge.statistics import (
    SIGNIFICANCE,
    chi_square_tail,
    covariance,
    linear_model,
)

_GROSS_SHARE = 0.1
"""Outliers whose statistic is this share of the largest, or more, are taken out together."""
_MAX_REJECTED_SHARE = 0.45
"""Largest share of the readings that may be taken out by the word of the others."""
_GROSS_RATIO, _MAX_GROSS_SHARE = 6.0, 0.01
"""Readings off by so many times the scale of the better half, more than this share of all, are no
normal noise stated too small.
"""
_GOOD_SCALE = 2.0
"""Scale of the better half, over the noise stated, from which another start is tried."""
_WORSE_RATIO = 2.0
"""A refit whose chi-square per reading is so many times that of the fit before it has lost its
minimum.
"""

ReadingKey = tuple[int, str]


@dataclass(frozen=True, eq=False)
class StartValues:
    """Where a fit starts: parameters p, and unknown coordinates (n, width) of all configurations,
    NaN where none are known.
    """

    p: np.ndarray
    z: np.ndarray

    def subset(self, rows: np.ndarray) -> StartValues:
        return StartValues(self.p, self.z[rows])

    @staticmethod
    def of(found: Fit, count: int) -> StartValues:
        z = np.full((count, found.result.state.z.shape[1]), np.nan)
        z[found.used] = found.result.state.z
        return StartValues(found.result.state.p, z)


FitFunction = Callable[[Measurements, StartValues | None], Fit]


@dataclass(frozen=True, eq=False)
class ScreenedFit:
    """A fit, what was found in it, and why nothing of it may be written, None where nothing speaks
    against it.
    """

    found: Fit
    screening: Screening
    refused: str | None = None


def fit_without_outliers(
    fit: FitFunction, measurements: Measurements, found: Fit, level: float
) -> ScreenedFit:
    """Fit without outliers. Where there are so many that none can be told one by one, or where they
    spoil the first fit, the majority of the readings decides; where that decides nothing either and
    errors are gross, the fit is refused.
    """
    plain = ScreenedFit(found, Screening((), ()))
    if found.result.status == "ok":
        plain = _one_by_one(fit, measurements, found, level)
        if not plain.screening.given_up:
            return plain
    return _by_majority(fit, measurements, found, level, plain)


# --- one by one -----------------------------------------------------------------------------------


def _one_by_one(
    fit: FitFunction,
    measurements: Measurements,
    first: Fit,
    level: float,
    before: Sequence[Outlier] = (),
) -> ScreenedFit:
    """Take outliers out one by one. A gross error bends the fit beyond its linear range, so that
    good readings look bad: in each round only those go whose statistic is `_GROSS_SHARE` of the
    largest or more, and the rest is judged at a new fit.
    """
    found, taken_out, allowed = first, list(before), None
    unchecked: tuple[ReadingKey, ...] = ()
    while True:
        screening = _renumbered(
            screen_readings(
                found.problem,
                linear_model(found.problem, found.result.state),
                level=level,
                share=_GROSS_SHARE,
            ),
            found.used,
        )
        if allowed is None:
            allowed, unchecked = max_outliers(found.problem) + len(before), screening.unchecked
        if not screening.outliers and not screening.given_up:
            break
        more = [*taken_out, *screening.outliers, *screening.given_up]
        if screening.given_up or len(more) > allowed:
            return ScreenedFit(first, Screening((), unchecked, tuple(more)))
        again = fit(_without(measurements, more), StartValues.of(found, len(measurements)))
        if _is_worse(again, found):
            break
        found, taken_out = again, more
    return _put_back(
        fit, measurements, ScreenedFit(found, Screening(tuple(taken_out), unchecked)), level
    )


def _is_worse(again: Fit, found: Fit) -> bool:
    """Tell whether a fit to fewer readings failed, or fits them worse."""
    if again.result.status != "ok":
        return True
    return _per_reading(again) > _WORSE_RATIO * max(
        _per_reading(found), 1.0 if found.problem.readings.known else 0.0
    )


def _per_reading(found: Fit) -> float:
    return found.result.state.cost / max(found.problem.readings.count, 1)


# --- by majority ----------------------------------------------------------------------------------


def _by_majority(
    fit: FitFunction, measurements: Measurements, found: Fit, level: float, plain: ScreenedFit
) -> ScreenedFit:
    """Fit without all that a robust fit leaves far off; keep the plain fit where the errors are not
    gross, refuse it where they are and the rest does not fit either.
    """
    # gross errors bend a fit far: its prior is none of the good readings'
    problem = replace(found.problem, widened=1.0)
    trials = [robust_estimate(problem, found.result.state.p, found.result.state.z, "cauchy")]
    if not trials[0].scale < _GOOD_SCALE:
        model, rows = found.problem.model, found.problem.measurements
        begin, closed = newton_configurations(
            model, first_points(model, rows, model.nominal), rows.joints, model.nominal
        )
        trials += [robust_estimate(problem, model.nominal, begin, "cauchy")] if closed.all() else []
    trials = [t for t in trials if np.isfinite(t.scale)]
    best = min(trials, key=lambda t: t.scale, default=None)
    if best is None:
        return plain
    robust = replace(found, result=best.result)
    bad, share = _far_off(robust, best.scale, level)
    if share <= _MAX_GROSS_SHARE:
        return plain
    why = (
        f"{len(bad)} readings, {100 * share:.0f} % of all, are off by more than {_GROSS_RATIO:g} "
        f"times the scatter of the better half, and without "
        "them the others do not fit either: gross errors, or readings of another machine"
    )
    if not bad or share > _MAX_REJECTED_SHARE:
        return replace(plain, refused=why)
    near = StartValues.of(robust, len(measurements))
    again = fit(_without(measurements, bad), near)
    if again.result.status != "ok" or not _is_explained(again):
        return replace(plain, refused=why)
    final = _one_by_one(fit, measurements, again, level, bad)
    return replace(plain, refused=why) if final.screening.given_up else final


def _far_off(found: Fit, scale: float, level: float) -> tuple[list[Outlier], float]:
    """Find readings that a robust fit leaves off by more than chance allows, and the share of all
    that are grossly so.
    """
    problem, state = found.problem, found.result.state
    t = normalised_residuals(problem, problem, state) / scale
    bad, gross, count = list[Outlier](), 0, 0
    kinds = reading_kinds(problem)
    total = sum(len(configurations) for _, configurations, _ in kinds)
    for kind, configurations, rows in kinds:
        columns = rows[0] - configurations[0] * t.shape[1]
        for i in configurations:
            inside = columns[problem.readings.taken[i, columns]]
            statistic, count = float(t[i, inside] @ t[i, inside]), count + 1
            gross += statistic > _GROSS_RATIO**2 * len(inside)
            if chi_square_tail(statistic, len(inside)) < level / total:
                bad.append(
                    Outlier(
                        configuration=int(found.used[i]),
                        label="",
                        kind=kind,
                        shift=(),
                        statistic=statistic,
                        degrees=len(inside),
                        probability=0.0,
                        reason="",
                    )
                )
    return bad, gross / max(count, 1)


def _is_explained(found: Fit) -> bool:
    """Tell whether what a fit leaves is as the noise lets expect, or is normal noise of unknown
    size.
    """
    model = linear_model(found.problem, found.result.state)
    if found.problem.readings.known:
        return (
            chi_square_tail(model.chi_square, model.degrees) > SIGNIFICANCE
            or model.chi_square < 2.0 * model.degrees
        )
    t = normalised_residuals(found.problem, found.problem, found.result.state)[
        found.problem.readings.taken
    ]
    return (
        float(np.mean(np.abs(t) > _GROSS_RATIO * 1.4826 * np.median(np.abs(t)))) <= _MAX_GROSS_SHARE
    )


# --- what was taken out ---------------------------------------------------------------------------


def _put_back(
    fit: FitFunction, measurements: Measurements, made: ScreenedFit, level: float
) -> ScreenedFit:
    """Test the outliers by the last fit; put those that agree with it back, and fit again."""
    if not made.screening.outliers:
        return made
    outliers = _retest(measurements, made.found, made.screening.outliers)
    total = sum(
        len(configurations) for _, configurations, _ in reading_kinds(made.found.problem)
    ) + len(outliers)
    kept = [o for o in outliers if o.probability < level / total]
    if len(kept) < len(outliers):
        again = fit(_without(measurements, kept), StartValues.of(made.found, len(measurements)))
        if not _is_worse(again, made.found):
            return replace(
                made,
                found=again,
                screening=replace(
                    made.screening, outliers=tuple(_retest(measurements, again, kept))
                ),
            )
    return replace(made, screening=replace(made.screening, outliers=tuple(outliers)))


def _retest(measurements: Measurements, found: Fit, outliers: Sequence[Outlier]) -> list[Outlier]:
    """Compare readings that were taken out with what the fit predicts; they stay as they were
    judged where their configuration does not close.
    """
    if not outliers:
        return []
    problem = _problem_of_all(found, measurements)
    state, noise = found.result.state, np.zeros(0)
    begin = first_points(problem.model, measurements, found.result.state.p)
    begin[found.used] = state.z
    with np.errstate(all="ignore"):
        z, closed = newton_configurations(
            problem.model, begin, measurements.joints, state.p, tolerance=1e2 * SOLVED_TOLERANCE
        )
        there = evaluate(problem, state.p, z, "means")
        noise = joint_covariance(problem, there)
        _add_parameter_covariance(noise, problem, found, z, outliers)
    gap = deviations(problem.readings, readings_at(problem, state.p, z))
    _take_means(problem, gap, np.arange(len(z)), outliers)
    spread = 1.0 if problem.readings.known else _per_reading(found)
    return [
        _retest_outlier(problem, gap, noise, o, spread) if closed[o.configuration] else o
        for o in outliers
    ]


def _problem_of_all(found: Fit, measurements: Measurements) -> CalibrationProblem:
    names = (*found.problem.names, *found.problem.fixed)
    return build_calibration(
        found.problem.mechanism,
        measurements,
        parameters=names,
        fixed=found.problem.fixed,
        residual=found.problem.form,
    )


def _add_parameter_covariance(
    noise: np.ndarray,
    problem: CalibrationProblem,
    found: Fit,
    z: np.ndarray,
    outliers: Sequence[Outlier],
) -> None:
    """Add to that of noise (n, K, K) the covariance that the estimate's own gives the predictions
    of readings that were taken out: J C J^T, which one that took part in the fit would lessen. It
    stays as it is where none was taken out.
    """
    readings, model = problem.readings, problem.model
    out = np.array([o.configuration for o in outliers])
    rows = np.flatnonzero(
        np.isin(np.arange(len(z)), out)
        | ((readings.group >= 0) & np.isin(readings.group, readings.group[out]))
    )
    e = model.evaluate(
        z[rows], problem.measurements.joints[rows], found.result.state.p, problem.quaternions[rows]
    )
    slopes = e.slopes
    _take_means(problem, slopes, rows, outliers)
    free = covariance(found.problem, found.result.state) / np.outer(model.scales, model.scales)
    noise[rows] += slopes @ free @ slopes.transpose(0, 2, 1)


def _take_means(
    problem: CalibrationProblem, values: np.ndarray, rows: np.ndarray, outliers: Sequence[Outlier]
) -> None:
    """Take from the values (n, K, ...) of configurations `rows`, whole groups, the mean of those of
    their group that are not taken out, for grouped readings; their median where all are.
    """
    readings = problem.readings
    group = readings.group[rows]
    out = np.isin(rows, [o.configuration for o in outliers if o.kind == "group"])
    for g in np.unique(group[group >= 0]):
        members = np.flatnonzero(group == g)
        if np.any(~out[members]):
            means = values[np.ix_(members[~out[members]], readings.columns)].mean(axis=0)
        else:  # what most of them agree on, which a bad one among few does not move
            means = np.median(values[np.ix_(members, readings.columns)], axis=0)
        values[np.ix_(members, readings.columns)] -= means


def _retest_outlier(
    problem: CalibrationProblem, gap: np.ndarray, noise: np.ndarray, o: Outlier, spread: float
) -> Outlier:
    """Give an outlier the shift and the statistic that a fit gives it."""
    named = [
        k
        for k, (kind, component) in enumerate(problem.model.columns)
        if o.kind in (kind, component if kind == "distance" else kind)
    ]
    columns = np.array([k for k in named if problem.readings.taken[o.configuration, k]], dtype=int)
    if len(columns) == 0:
        return o
    block = noise[o.configuration][np.ix_(columns, columns)] + np.diag(
        problem.readings.sigma[o.configuration, columns] ** 2
    )
    shift = -gap[o.configuration, columns]
    statistic = float(shift @ np.linalg.solve(spread * block, shift))
    return describe_outlier(
        problem,
        o.configuration,
        o.kind,
        columns,
        shift,
        statistic,
        len(columns),
        chi_square_tail(statistic, len(columns)),
    )


def _without(measurements: Measurements, outliers: Sequence[Outlier]) -> Measurements:
    for o in outliers:
        measurements = measurements.without(o.configuration, o.kind)
    return measurements


def _renumbered(screening: Screening, used: np.ndarray) -> Screening:
    """The screening with the numbers that configurations have in the file."""
    return Screening(
        tuple(replace(o, configuration=int(used[o.configuration])) for o in screening.outliers),
        tuple((int(used[k]), kind) for k, kind in screening.unchecked),
        tuple(replace(o, configuration=int(used[o.configuration])) for o in screening.given_up),
    )
