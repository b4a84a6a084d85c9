"""Find readings that do not belong by mean-shift statistics, one by one, and fit without them; or
without all that the majority of the readings speaks against.

A reading y_i (both angles of an inclination, the components of a position) may be shifted by an
unknown d: the chi-square falls by T_i = e_i^T (1 - Q Q^T)_ii^+ e_i, which without a shift has the
chi-square distribution with as many degrees of freedom as that block has rank. The largest is taken
out and the rest judged again, while its probability is below 1 - (1 - level)^(1 / m) for m readings
(Sidak): of clean sets at most the share `level` has any reading flagged.

Each refit starts from the fit before it. One that does not converge, or fits the readings left
worse, is undone. What was taken out is judged once more by how the last fit predicts it: a reading
that agrees with it is put back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.data.observables import measure_of, written
from symkin.calibration.estimate.configurations import first_points, newton_configurations
from symkin.calibration.estimate.estimator import Estimate
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import build_readings, only_rounding
from symkin.calibration.estimate.robust import (
    SIGMA_OVER_MEDIAN,
    normalised_residuals,
    robust_estimate,
)
from symkin.calibration.estimate.state import State
from symkin.calibration.judge.statistics import (
    SIGNIFICANCE,
    LinearModel,
    Prediction,
    chi_square_tail,
    close_others,
    covariance,
    covariance_root,
    linear_model,
    predict_readings,
)

OUTLIER_LEVEL = 0.02
"""Share of clean data sets in which a reading may be flagged."""
MAX_OUTLIER_SHARE, _MAX_OUTLIERS = 0.2, 300
"""The largest share and the largest number of readings that are judged one by one; beyond, the fit
is wrong as a whole. So many postures with readings left out, or more, hint at a mistake in the
file; held-out ones beyond it say that the prediction is wrong.
"""
MIN_REDUNDANCY = 1e-3
"""A shift of which the fit absorbs all but this share (of its square) cannot be judged."""
_MIN_SHOWN_PROBABILITY = 1e-16
"""Probabilities below this are not given: no distribution of errors is known so far out."""
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


@dataclass(frozen=True)
class Outlier:
    """A flagged reading: number and label of its configuration, kind, estimated shift of its
    components (radians, length unit), the statistic in variances, with its degrees of freedom and
    probability, and the reason in one sentence.
    """

    configuration: int
    kind: str
    statistic: float
    degrees: int
    label: str = ""
    shift: tuple[float, ...] = ()
    probability: float = 0.0
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Screening:
    """Outliers in the order in which they were taken out, and readings (configuration, kind) that
    nothing else checks. `given_up` holds those found where there were so many that none is to be
    left out: the fit is wrong as a whole. `refused` says why nothing may be written, None where
    nothing speaks against it.
    """

    outliers: tuple[Outlier, ...] = ()
    unchecked: tuple[tuple[int, str], ...] = ()
    given_up: tuple[Outlier, ...] = ()
    refused: str | None = None


@dataclass(frozen=True, eq=False)
class Fit(Estimate):
    """An estimate over the configurations `used`, those `unsolved`, the sign of det F_z of each
    used one where the estimation began, and configurations without a reading, `silent`.
    """

    problem: CalibrationProblem
    used: np.ndarray
    unsolved: np.ndarray
    start_signs: np.ndarray
    notes: tuple[str, ...] = ()
    silent: Sequence[int] = ()
    loss: str = "squared"
    any_machine: bool = False


FitFunction = Callable[[Measurements, Fit | None], Fit]
"""Fits readings, from where another fit has ended, if given."""
_Kind = tuple[str, np.ndarray, np.ndarray]
"""Name of a kind of readings, configurations (m,) that have any, and rows (m, w) of these."""


# --- the search -----------------------------------------------------------------------------------


def screen_readings(
    problem: CalibrationProblem,
    model: LinearModel,
    *,
    level: float = OUTLIER_LEVEL,
    share: float = 0.0,
) -> Screening:
    """Find outliers by deletion, while their statistics are at least `share` of the largest and
    their shifts more than rounding. The search is given up where more than the share
    `MAX_OUTLIER_SHARE` of the readings, a third of the degrees of freedom or `_MAX_OUTLIERS`
    readings would go.
    """
    kinds = reading_kinds(problem)
    tests = [_test_readings(model, rows) for _, _, rows in kinds]
    unchecked = sorted(
        (int(i), kind)
        for (kind, configurations, _), (_, degrees, _) in zip(kinds, tests, strict=True)
        for i in configurations[degrees == 0]
    )
    count, most, least = _count(kinds), max_outliers(problem), 2 * model.degrees // 3
    found, falls = list[Outlier](), list[float]()
    while model.degrees > 0 and len(found) < count:
        outlier, rows = _least_likely(problem, model, kinds, tests)
        if outlier.probability >= 1.0 - (1.0 - level) ** (1.0 / (count - len(found))):
            break
        less = model.without(rows)
        falls.append(model.chi_square - less.chi_square)
        if falls[-1] < share * max(falls):
            break
        angular = measure_of(problem.mechanism, outlier.kind) == "angle"
        unit = 1.0 if angular else problem.mechanism.characteristic_length
        if only_rounding(np.array(outlier.shift), unit):
            break
        if len(found) >= most or model.degrees <= least:
            return Screening(unchecked=tuple(unchecked), given_up=tuple(found))
        found.append(outlier)
        model = less
        tests = [_test_readings(model, rows) for _, _, rows in kinds]
    return Screening(tuple(found), tuple(unchecked))


def max_outliers(problem: CalibrationProblem) -> int:
    """Return the number of readings that may be left out one by one."""
    return min(_MAX_OUTLIERS, int(MAX_OUTLIER_SHARE * _count(reading_kinds(problem))))


def reading_kinds(problem: CalibrationProblem) -> list[_Kind]:
    """List the kinds of readings (a distance by its name) with the configurations that have any
    component of it and their rows.
    """
    taken, keys, made = problem.readings.taken, problem.model.keys, list[_Kind]()
    for kind in dict.fromkeys(keys):
        inside = np.flatnonzero(np.array(keys) == kind)
        configurations = np.flatnonzero(taken[:, inside].any(axis=1))
        if len(configurations):
            rows = configurations[:, None] * taken.shape[1] + inside
            made.append((kind, configurations, rows))
    return made


def _count(kinds: Sequence[_Kind]) -> int:
    return sum(len(configurations) for _, configurations, _ in kinds)


def _test_readings(
    model: LinearModel, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Test the readings in rows (m, w): statistics and degrees of freedom (m,), whitened shifts (m,
    w).
    """
    values, vectors = np.linalg.eigh(model.freedom(rows))
    seen = values > MIN_REDUNDANCY
    part = (vectors.transpose(0, 2, 1) @ model.residuals[rows][:, :, None])[:, :, 0]
    scaled = np.where(seen, part, 0.0) / np.where(seen, values, 1.0)
    shift = (vectors @ scaled[:, :, None])[:, :, 0]
    return np.sum(part * scaled, axis=1), seen.sum(axis=1), shift


def _least_likely(
    problem: CalibrationProblem,
    model: LinearModel,
    kinds: Sequence[_Kind],
    tests: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]],
) -> tuple[Outlier, np.ndarray]:
    """Describe the least likely reading, with its rows: one of those with the largest statistic of
    their degrees of freedom; the larger statistic where several have probability 0. Noise that is
    not stated is that of the others of its kind, without the reading that is judged.
    """
    best, noise = (1.0, 0.0, 0, 0, 0), _unstated_noise(problem, model, kinds)
    for k, (statistics, degrees, _) in enumerate(tests):
        for d in map(int, np.unique(degrees[degrees > 0])):
            m = int(np.where(degrees == d, statistics, -1.0).argmax())
            statistic, left = statistics[m], None
            if (own := noise.get(kinds[k][0])) is not None:
                chi_square, left = own[0] - statistic, own[1] - d
                statistic *= max(left, 1.0) / max(chi_square, 1e-300)
            best = min(best, (chi_square_tail(statistic, d, left), -statistic, d, k, m))
    probability, statistic, degree, k, m = best
    kind, configurations, every = kinds[k]
    i, given = int(configurations[m]), model.taken[every[m]]
    rows = every[m][given]
    columns = rows - i * len(problem.model.columns)
    whiten = model.whiten[i][np.ix_(columns, columns)]
    shift = np.linalg.solve(whiten, tests[k][2][m][given])
    made = Outlier(i, kind, -statistic, degree, probability=probability)
    return _described(problem, i, made, columns, shift), rows


def _unstated_noise(
    problem: CalibrationProblem, model: LinearModel, kinds: Sequence[_Kind]
) -> dict[str, tuple[float, float]]:
    """Return chi-square and its degrees of freedom of each kind whose noise is not stated."""
    if problem.readings.known:
        return {}
    channels, left = problem.measurements.channels(problem.mechanism), model.taken - model.absorbed
    unstated = {o.key for o, reading in channels if reading.sigma is None}
    return {
        kind: (float(np.sum(model.residuals[rows] ** 2)), float(left[rows].sum()))
        for kind, _, rows in kinds
        if kind in unstated
    }


def _described(
    problem: CalibrationProblem, row: int, o: Outlier, columns: np.ndarray, shift: np.ndarray
) -> Outlier:
    """Say in a sentence by how much the readings of some columns of a row are off."""
    label, mechanism = problem.measurements.labels[row], problem.mechanism
    measure = measure_of(mechanism, o.kind)
    text = ", ".join(
        f"{problem.model.columns[k][1]} {written(mechanism, measure, v)}"
        for k, v in zip(columns, shift, strict=True)
    )
    chance = f"below {_MIN_SHOWN_PROBABILITY:.0e}"
    if o.probability >= _MIN_SHOWN_PROBABILITY:
        chance = f"{o.probability:.1g}"
    reason = (
        f"posture {label}, {o.kind}: off by {text} of what the other readings say; "
        f"statistic {o.statistic:.4g} with {o.degrees} degrees of freedom, probability {chance}"
    )
    return replace(o, label=label, shift=tuple(map(float, shift)), reason=reason)


# --- fits without them ----------------------------------------------------------------------------


def fit_without_outliers(
    fit: FitFunction, measurements: Measurements, found: Fit, level: float
) -> tuple[Fit, Screening]:
    """Fit without outliers. Where there are so many that none can be told one by one, or where they
    spoil the first fit, the majority of the readings decides; where that decides nothing either and
    errors are gross, the fit is refused.
    """
    search, plain = _Search(fit, measurements, level), (found, Screening())
    if found.status == "ok":
        plain = search.one_by_one(found)
        if not plain[1].given_up:
            return plain
    return search.by_majority(found, plain)


@dataclass(frozen=True)
class _Search:
    """How readings are fitted, which, and the share of clean data sets with an outlier."""

    fit: FitFunction
    measurements: Measurements
    level: float

    def without(self, outliers: Sequence[Outlier], near: Fit) -> Fit:
        """Fit the readings that are left, from where another fit has ended."""
        left = self.measurements
        for o in outliers:
            left = left.without(o.configuration, o.kind)
        return self.fit(left, near)

    def one_by_one(self, first: Fit, before: Sequence[Outlier] = ()) -> tuple[Fit, Screening]:
        """Take outliers out one by one. A gross error bends the fit beyond its linear range, so
        that good readings look bad: in each round only those go whose statistic is `_GROSS_SHARE`
        of the largest or more, and the rest is judged at a new fit.
        """
        found, taken_out = first, list(before)
        allowed, unchecked = max_outliers(first.problem) + len(before), None
        while True:
            model = linear_model(found.problem, found.state)
            made = screen_readings(found.problem, model, level=self.level, share=_GROSS_SHARE)
            if unchecked is None:
                unchecked = tuple((int(found.used[k]), kind) for k, kind in made.unchecked)
            fresh = [
                replace(o, configuration=int(found.used[o.configuration]))
                for o in (*made.outliers, *made.given_up)
            ]
            more = [*taken_out, *fresh]
            if made.given_up or len(more) > allowed:
                return first, Screening(unchecked=unchecked, given_up=tuple(more))
            if not fresh:
                break
            again = self.without(more, found)
            if _is_worse(again, found):
                break
            found, taken_out = again, more
        # what was taken out and agrees with the last fit is put back
        outliers = _retest(self.measurements, found, taken_out)
        total = _count(reading_kinds(found.problem)) + len(outliers)
        kept = [o for o in outliers if o.probability < self.level / total]
        if len(kept) < len(outliers):
            again = self.without(kept, found)
            if not _is_worse(again, found):
                found, outliers = again, _retest(self.measurements, again, kept)
        return found, Screening(tuple(outliers), unchecked)

    def by_majority(self, found: Fit, plain: tuple[Fit, Screening]) -> tuple[Fit, Screening]:
        """Fit without all that a robust fit leaves far off; keep the plain fit where the errors are
        not gross, refuse it where they are and the rest does not fit either.
        """
        # gross errors bend a fit far: its prior is none of the good readings'
        problem = replace(found.problem, widened=1.0)
        trials = [robust_estimate(problem, found.state.p, found.state.z, "cauchy")]
        if not trials[0][1] < _GOOD_SCALE:
            model, rows = found.problem.model, found.problem.measurements
            begin, closed = newton_configurations(
                model, first_points(model, rows, model.nominal), rows.joints, model.nominal
            )
            if closed.all():
                trials.append(robust_estimate(problem, model.nominal, begin, "cauchy"))
        result, scale = min(trials, key=lambda t: np.nan_to_num(t[1], nan=np.inf))
        if not np.isfinite(scale):
            return plain
        robust = replace(found, **vars(result))
        bad, share = _far_off(robust, scale, self.level)
        if share <= _MAX_GROSS_SHARE:
            return plain
        why = (
            f"{len(bad)} readings are off by more than chance allows, {100 * share:.0f} % of all "
            f"by more than {_GROSS_RATIO:g} times the scatter of the better half, and without them "
            "the others do not fit either: gross errors, rounded readings, or those of another "
            "machine"
        )
        refused = plain[0], replace(plain[1], refused=why)
        if not bad or share > _MAX_REJECTED_SHARE:
            return refused
        again = self.without(bad, robust)
        if again.status != "ok" or not _is_explained(again):
            return refused
        final = self.one_by_one(again, bad)
        return refused if final[1].given_up else final


def _is_worse(again: Fit, found: Fit) -> bool:
    """Tell whether a fit to fewer readings failed, or fits them worse."""
    least = 1.0 if found.problem.readings.known else 0.0
    bound = _WORSE_RATIO * max(_per_reading(found), least)
    return again.status != "ok" or _per_reading(again) > bound


def _per_reading(found: Fit) -> float:
    return found.state.cost / max(found.problem.readings.count, 1)


def _far_off(found: Fit, scale: float, level: float) -> tuple[list[Outlier], float]:
    """Find readings that a robust fit leaves off by more than chance allows, and the share of all
    that are grossly so.
    """
    problem, kinds = found.problem, reading_kinds(found.problem)
    squares = (normalised_residuals(problem, problem, found.state) / scale) ** 2
    bad, gross, total = list[Outlier](), 0, max(_count(kinds), 1)
    for kind, configurations, rows in kinds:
        statistics = squares.reshape(-1)[rows].sum(axis=1)
        degrees = problem.readings.taken.reshape(-1)[rows].sum(axis=1)
        gross += np.sum(statistics > _GROSS_RATIO**2 * degrees)
        bad += [
            Outlier(int(found.used[i]), kind, float(statistic), int(d))
            for i, statistic, d in zip(configurations, statistics, degrees, strict=True)
            if chi_square_tail(statistic, int(d)) < level / total
        ]
    return bad, gross / total


def _is_explained(found: Fit) -> bool:
    """Tell whether what a fit leaves is as the noise lets expect, or is normal noise of unknown
    size.
    """
    problem, state = found.problem, found.state
    if problem.readings.known:
        model = linear_model(problem, state)
        likely = chi_square_tail(model.chi_square, model.degrees) > SIGNIFICANCE
        return likely or model.chi_square < 2.0 * model.degrees
    t = np.abs(normalised_residuals(problem, problem, state)[problem.readings.taken])
    return float(np.mean(t > _GROSS_RATIO * SIGMA_OVER_MEDIAN * np.median(t))) <= _MAX_GROSS_SHARE


# --- what was taken out ---------------------------------------------------------------------------


def _retest(measurements: Measurements, found: Fit, outliers: Sequence[Outlier]) -> list[Outlier]:
    """Compare readings that were taken out with what the fit predicts, inclinations with those of
    the others in their group; they stay as they were judged where their configuration does not
    close.
    """
    if not outliers:
        return []
    out = np.array([o.configuration for o in outliers])
    group = measurements.group_of
    beside = (group != NO_GROUP) & np.isin(group, group[out])
    rows = np.flatnonzero(beside | np.isin(np.arange(len(group)), out))
    state = found.state
    fitted, left = _with_own_noise(found.problem, state)
    problem, z, solved = close_others(fitted, state, measurements.subset(rows))
    rows = rows[solved]
    if not len(rows):
        return list(outliers)
    apart = {o.configuration: o.statistic for o in outliers if o.kind == "group"}
    for members in (np.flatnonzero(group == group[i]).tolist() for i in list(apart)):
        if all(k in apart for k in members):  # the others are compared with the likeliest
            del apart[min(members, key=lambda k: apart[k])]
    root = covariance_root(covariance(fitted, state), fitted)
    made = predict_readings(problem, state.p, z, root, telling=~np.isin(rows, list(apart)))
    return [_repredicted(problem, made, rows, o, left.get(o.kind)) for o in outliers]


def _with_own_noise(
    problem: CalibrationProblem, state: State
) -> tuple[CalibrationProblem, dict[str, float]]:
    """Weigh readings of each kind that states no noise by what a fit leaves of them; and by how
    many degrees of freedom that is known.
    """
    if problem.readings.known:
        return problem, {}
    readings, kinds = problem.readings, reading_kinds(problem)
    noise = _unstated_noise(problem, linear_model(problem, state), kinds)
    estimated, left = dict(problem.estimated), dict[str, float]()
    for kind, _, rows in kinds:
        if kind in noise and noise[kind][1] > 0.0:
            chi_square, left[kind] = noise[kind]
            usual = float(readings.sigma.reshape(-1)[rows[0]].min())
            estimated[kind] = usual * max(chi_square / left[kind], 1e-300) ** 0.5
    return replace(
        problem,
        estimated=estimated,
        readings=build_readings(problem.model, problem.measurements, estimated),
    ), left


def _repredicted(
    problem: CalibrationProblem, made: Prediction, rows: np.ndarray, o: Outlier, left: float | None
) -> Outlier:
    """Give an outlier the shift and the statistic that a prediction of some rows gives it."""
    i = int(np.searchsorted(rows, o.configuration))
    if o.configuration not in rows:
        return o
    named = np.array(problem.model.keys) == o.kind
    columns = np.flatnonzero(named & problem.readings.taken[i])
    shift, block = -made.errors[i, columns], made.covariance[i][np.ix_(columns, columns)]
    statistic, d = float(shift @ np.linalg.solve(block, shift)), len(columns)
    chance = chi_square_tail(statistic, d, left)
    fresh = replace(o, statistic=statistic, degrees=d, probability=chance)
    return _described(problem, i, fresh, columns, shift) if d else o
