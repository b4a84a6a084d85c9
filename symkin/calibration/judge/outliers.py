"""Find readings that do not belong by mean-shift statistics, one by one, with deletion.

A reading y_i (both angles of an inclination, the components of a position) may be shifted by an
unknown d: the chi-square falls by T_i = e_i^T (1 - Q Q^T)_ii^+ e_i, which without a shift has the
chi-square distribution with as many degrees of freedom as that block has rank. The largest is taken
out and the rest judged again, while its probability is below 1 - (1 - level)^(1 / m) for m readings
(Sidak): of clean sets at most the share `level` has any reading flagged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.observables import is_angular
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import only_rounding
from symkin.calibration.judge.statistics import LinearModel, chi_square_tail, f_tail

OUTLIER_LEVEL = 0.02
"""Share of clean data sets in which a reading may be flagged."""
MAX_OUTLIER_SHARE, _MAX_OUTLIERS = 0.2, 300
"""The largest share and the largest number of readings that are judged one by one; beyond, the fit
is wrong as a whole. Postures with readings left out beyond that share hint at a mistake in the
file.
"""
_MIN_REDUNDANCY = 1e-3
"""A shift of which the fit absorbs all but this share (of its square) cannot be judged."""

_MIN_SHOWN_PROBABILITY = 1e-16
"""Probabilities below this are not given: no distribution of errors is known so far out."""


@dataclass(frozen=True)
class Outlier:
    """A flagged reading: number and label of its configuration, kind, estimated shift of its
    components (radians, length unit), the statistic with its degrees of freedom and probability,
    and the reason in one sentence.
    """

    configuration: int
    label: str
    kind: str
    shift: tuple[float, ...]
    statistic: float
    degrees: int
    probability: float
    reason: str


@dataclass(frozen=True, eq=False)
class Screening:
    """Outliers in the order in which they were taken out, and readings (configuration, kind) that
    nothing else checks. `given_up` holds those found where there were so many that none is to be
    left out: the fit is wrong as a whole.
    """

    outliers: tuple[Outlier, ...]
    unchecked: tuple[tuple[int, str], ...]
    given_up: tuple[Outlier, ...] = ()


@dataclass(frozen=True, eq=False)
class _ReadingTests:
    """Readings of one kind: configurations (m,), rows of the linear model (m, w), statistics and
    degrees of freedom (m,), whitened shifts (m, w).
    """

    kind: str
    configurations: np.ndarray
    rows: np.ndarray
    statistic: np.ndarray
    degrees: np.ndarray
    shift: np.ndarray


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
    first = [_test_readings(model, *kind) for kind in kinds]
    unchecked = tuple(
        sorted((int(i), j.kind) for j in first for i in j.configurations[j.degrees == 0])
    )
    count, least = sum(len(j.configurations) for j in first), 2 * model.degrees // 3
    most, found = max_outliers(problem), list[Outlier]()
    while model.degrees > 0 and len(found) < count:
        probability, judged, m = _least_likely(
            model, [_test_readings(model, *kind) for kind in kinds], problem.readings.known
        )
        if judged is None or probability >= 1.0 - (1.0 - level) ** (1.0 / (count - len(found))):
            break
        if judged.statistic[m] < share * max((o.statistic for o in found), default=0.0):
            break
        outlier = _outlier(problem, model, judged, m, probability)
        if only_rounding(
            np.array(outlier.shift),
            1.0
            if is_angular(problem.mechanism, outlier.kind)
            else problem.mechanism.characteristic_length,
        ):
            break
        if len(found) >= most or model.degrees <= least:
            return Screening((), unchecked, tuple(found))
        found.append(outlier)
        model = model.without(_taken_rows(model, judged.rows[m]))
    return Screening(tuple(found), unchecked)


def max_outliers(problem: CalibrationProblem) -> int:
    """Return the number of readings that may be left out one by one."""
    return min(
        _MAX_OUTLIERS,
        int(
            MAX_OUTLIER_SHARE
            * sum(len(configurations) for _, configurations, _ in reading_kinds(problem))
        ),
    )


def reading_kinds(problem: CalibrationProblem) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """List the kinds of readings (a distance by its name) with the configurations (m,) that have
    any component of it and rows (m, w).
    """
    columns, taken = problem.model.columns, problem.readings.taken
    members: dict[str, list[int]] = {}
    for k, (kind, component) in enumerate(columns):
        members.setdefault(component if kind == "distance" else kind, []).append(k)
    made = []
    for kind, inside in members.items():
        configurations = np.flatnonzero(taken[:, inside].any(axis=1))
        if len(configurations):
            made.append(
                (kind, configurations, configurations[:, None] * len(columns) + np.array(inside))
            )
    return made


def _taken_rows(model: LinearModel, rows: np.ndarray) -> np.ndarray:
    return np.asarray(rows[model.taken[rows]])


def _test_readings(
    model: LinearModel, kind: str, configurations: np.ndarray, rows: np.ndarray
) -> _ReadingTests:
    values, vectors = np.linalg.eigh(model.freedom(rows))
    seen = values > _MIN_REDUNDANCY
    part = np.where(
        seen, (vectors.transpose(0, 2, 1) @ model.residuals[rows][:, :, None])[:, :, 0], 0.0
    )
    scaled = part / np.where(seen, values, 1.0)
    shift = (vectors @ scaled[:, :, None])[:, :, 0]
    return _ReadingTests(
        kind=kind,
        configurations=configurations,
        rows=rows,
        statistic=np.sum(part * scaled, axis=1),
        degrees=np.sum(seen, axis=1),
        shift=shift,
    )


def _least_likely(
    model: LinearModel, kinds: list[_ReadingTests], known: bool
) -> tuple[float, _ReadingTests | None, int]:
    """Find the least likely reading, with probability, kind and place: one of those with the
    largest statistic of their degrees of freedom; the larger statistic where several have
    probability 0.
    """
    best: tuple[float, float, _ReadingTests | None, int] = (1.0, 0.0, None, 0)
    for judged in kinds:
        for d in (int(d) for d in np.unique(judged.degrees) if d):
            m = int(np.argmax(np.where(judged.degrees == d, judged.statistic, -1.0)))
            statistic = float(judged.statistic[m])
            probability = _probability(model, statistic, d, known=known)
            if (probability, -statistic) < (best[0], -best[1]):
                best = probability, statistic, judged, m
    return best[0], best[2], best[3]


def _probability(model: LinearModel, statistic: float, degrees: int, *, known: bool) -> float:
    """Return the probability of a statistic; unknown noise is studentised without the reading that
    is judged.
    """
    if known:
        return chi_square_tail(statistic, degrees)
    left = model.degrees - degrees
    if left <= 0:
        return 1.0
    return f_tail(statistic / degrees / _scatter(model, statistic, degrees), degrees, left)


def _scatter(model: LinearModel, statistic: float, degrees: int) -> float:
    """Return the variance of the readings that are left when one with such a statistic is taken
    out.
    """
    return max((model.chi_square - statistic) / max(model.degrees - degrees, 1), 1e-300)


def _outlier(
    problem: CalibrationProblem,
    model: LinearModel,
    judged: _ReadingTests,
    m: int,
    probability: float,
) -> Outlier:
    configuration, kind, rows = int(judged.configurations[m]), judged.kind, judged.rows[m]
    given = model.taken[rows]
    columns = rows[given] - configuration * len(problem.model.columns)
    degrees = int(judged.degrees[m])
    unit = 1.0 if problem.readings.known else _scatter(model, float(judged.statistic[m]), degrees)
    shift = np.linalg.solve(
        model.whiten[configuration][np.ix_(columns, columns)], judged.shift[m][given]
    )
    return describe_outlier(
        problem,
        configuration,
        kind,
        columns,
        shift,
        float(judged.statistic[m]) / unit,
        degrees,
        probability,
    )


def describe_outlier(
    problem: CalibrationProblem,
    configuration: int,
    kind: str,
    columns: np.ndarray,
    shift: np.ndarray,
    statistic: float,
    degrees: int,
    probability: float,
) -> Outlier:
    """Describe an outlier in a sentence; `columns` are those of the readings, the statistic counts
    in variances.
    """
    label = problem.measurements.labels[configuration]
    names = [problem.model.columns[k][1] for k in columns]
    angular = is_angular(problem.mechanism, kind)
    unit = "deg" if angular else problem.mechanism.length_unit
    shown = np.degrees(shift) if angular else shift
    text = ", ".join(f"{name} {v:+.3g} {unit}" for name, v in zip(names, shown, strict=True))
    reason = (
        f"posture {label}, {kind}: off by {text} of what the other readings say; "
        f"statistic {statistic:.4g} with {degrees} degrees of freedom, probability "
        f"{_probability_text(probability)}"
    )
    return Outlier(
        configuration=configuration,
        label=label,
        kind=kind,
        shift=tuple(float(v) for v in shift),
        statistic=statistic,
        degrees=degrees,
        probability=probability,
        reason=reason,
    )


def _probability_text(probability: float) -> str:
    """A probability with one digit, or that it is too small to be meant."""
    return (
        f"{probability:.1g}"
        if probability >= _MIN_SHOWN_PROBABILITY
        else f"below {_MIN_SHOWN_PROBABILITY:.0e}"
    )
