"""Readings that do not belong: mean-shift statistics, one by one, with deletion.

A reading y_i (both angles of an inclination, the components of a position) may be shifted by an unknown d: the chi-square
falls by T_i = e_i^T (1 - Q Q^T)_ii^+ e_i, which without a shift has the chi-square distribution with as many degrees of
freedom as that block has rank. The largest is taken out and the rest judged again, while its probability is below
1 - (1 - level)^(1 / m) for m readings (Sidak): of clean sets at most the share `level` has any reading flagged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.statistics import LinearModel, chi_square_tail, f_tail

LEVEL = 0.02
"""Share of clean data sets in which a reading may be flagged."""
_HIDDEN = 1e-3
"""A shift of which the fit absorbs all but this share (of its square) cannot be judged."""


@dataclass(frozen=True)
class Outlier:
    """A flagged reading: number and label of its posture, kind, estimated shift of its components (radians, length
    unit), the statistic with its degrees of freedom and probability, and the reason in one sentence."""

    posture: int
    label: str
    kind: str
    shift: tuple[float, ...]
    statistic: float
    degrees: int
    probability: float
    reason: str


@dataclass(frozen=True, eq=False)
class Screening:
    """Outliers in the order in which they were taken out, and readings (posture, kind) that nothing else checks."""

    outliers: tuple[Outlier, ...]
    unchecked: tuple[tuple[int, str], ...]


def screen(problem: CalibrationProblem, model: LinearModel, *, level: float = LEVEL) -> Screening:
    """Find outliers by deletion; at most a third of the degrees of freedom is spent."""
    blocks = _blocks(problem)
    unchecked = tuple(key for key, rows in blocks.items() if _judge(model, rows, known=True)[1] == 0)
    found: list[Outlier] = []
    least = 2 * model.degrees // 3
    while model.degrees > least and len(found) < len(blocks):
        judged = {key: _judge(model, rows, known=problem.readings.known) for key, rows in blocks.items()}
        key = min(judged, key=lambda k: (judged[k][2], -judged[k][0]))
        if judged[key][2] >= 1.0 - (1.0 - level) ** (1.0 / len(judged)):
            break
        found.append(_outlier(problem, model, key, blocks[key], judged[key]))
        model = model.without(blocks.pop(key))
    return Screening(tuple(found), unchecked)


def _blocks(problem: CalibrationProblem) -> dict[tuple[int, str], np.ndarray]:
    """Rows of the linear model by posture and kind (a distance by its name)."""
    columns = problem.model.columns
    width = len(columns)
    kinds: dict[str, list[int]] = {}
    for k, (kind, component) in enumerate(columns):
        kinds.setdefault(component if kind == "distance" else kind, []).append(k)
    taken = problem.readings.taken
    return {
        (i, kind): np.array([i * width + k for k in members if taken[i, k]])
        for i in range(len(taken))
        for kind, members in kinds.items()
        if taken[i, members].any()
    }


def _judge(model: LinearModel, rows: np.ndarray, *, known: bool) -> tuple[float, int, float, np.ndarray]:
    """Statistic, degrees of freedom, probability, and the whitened shift; unknown noise is studentised without them."""
    values, vectors = np.linalg.eigh(model.freedom(rows))
    seen = values > _HIDDEN
    part = vectors[:, seen].T @ model.residuals[rows]
    statistic, degrees = float(np.sum(part**2 / values[seen])), int(np.sum(seen))
    shift = vectors[:, seen] @ (part / values[seen])
    if known:
        return statistic, degrees, chi_square_tail(statistic, degrees), shift
    left = model.degrees - degrees
    if left <= 0 or degrees == 0:
        return statistic, degrees, 1.0, shift
    rest = max((model.chi_square - statistic) / left, 1e-300)
    return statistic, degrees, f_tail(statistic / degrees / rest, degrees, left), shift


def _outlier(
    problem: CalibrationProblem,
    model: LinearModel,
    key: tuple[int, str],
    rows: np.ndarray,
    judged: tuple[float, int, float, np.ndarray],
) -> Outlier:
    posture, kind = key
    statistic, degrees, probability, whitened = judged
    width = len(problem.model.columns)
    columns = rows - posture * width
    shift = np.linalg.solve(model.whiten[posture][np.ix_(columns, columns)], whitened)
    label = problem.measurements.labels[posture]
    names = [problem.model.columns[k][1] for k in columns]
    angular = kind in ("group", "inclination", "orientation")
    unit = "deg" if angular else problem.mechanism.length_unit
    shown = np.degrees(shift) if angular else shift
    text = ", ".join(f"{name} {v:+.3g} {unit}" for name, v in zip(names, shown, strict=True))
    reason = (
        f"posture {label}, {kind}: off by {text} of what the other readings say; "
        f"statistic {statistic:.1f} with {degrees} degrees of freedom, probability {probability:.1g}"
    )
    return Outlier(posture, label, kind, tuple(float(v) for v in shift), statistic, degrees, probability, reason)
