"""Hold out configurations from a fit, and test how well the fit predicts them.

The errors e of the prediction (see `prediction`) have covariance S + J C J^T, so that e^T (S + J C
J^T)^-1 e has the chi-square distribution with as many degrees of freedom as readings were held out,
less two for the unknown inclination of each group.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.judge.outliers import MAX_OUTLIER_SHARE, OUTLIER_LEVEL
from symkin.calibration.judge.prediction import (
    close_others,
    covariance_root,
    predict_readings,
)
from symkin.calibration.judge.result import Calibration
from symkin.calibration.judge.statistics import SIGNIFICANCE, chi_square_tail
from symkin.errors import InputError

_COUNT_PATTERN = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(%?)\s*")


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Predictions at configurations that were held out, by their labels: root mean square of the
    errors and what was expected of it, by kind (radians, length unit); chi-square without the
    `outliers`, its degrees of freedom and probability; configurations `unsolved`.
    """

    labels: tuple[str, ...]
    unsolved: tuple[str, ...]
    seed: int
    rms: dict[str, float] = field(default_factory=dict)
    expected: dict[str, float] = field(default_factory=dict)
    chi_square: float = 0.0
    degrees: int = 0
    p_value: float | None = None
    outliers: tuple[str, ...] = ()

    @property
    def believable(self) -> bool:
        """Whether they are predicted as well as noise and the parameters' standard deviations let
        expect.
        """
        return not self.unsolved and (self.p_value is None or self.p_value > SIGNIFICANCE)

    @property
    def doubt(self) -> str:
        """Why the prediction is not believable."""
        if self.unsolved:
            return (
                f"the direct problem of {len(self.unsolved)} of {len(self.labels)} held-out "
                f"postures has no solution"
            )
        times = math.sqrt(self.chi_square / max(self.degrees, 1))
        return (
            f"the {len(self.labels)} held-out postures are missed by {times:.3g} times what noise "
            f"and parameters let expect, probability "
            f"{self.p_value:.1g}: the model lacks something that the fitted postures hide"
        )


def held_out_count(asked: str, configurations: int) -> int:
    """Read how many configurations `20` or `20%` are. Raises InputError where none or all of them
    would be held out.
    """
    match = _COUNT_PATTERN.fullmatch(asked)
    if match is None or (not match[2] and "." in match[1]):
        raise InputError(
            f"--hold-out {asked!r}: a number of postures, or a share such as 20%, is needed"
        )
    count = max(1, round(float(match[1]) / 100.0 * configurations)) if match[2] else int(match[1])
    if not 1 <= count < configurations:
        raise InputError(
            f"--hold-out {asked.strip()}: {count} of {configurations} postures would be held out; "
            f"allowed: 1 to {configurations - 1}"
        )
    return count


def draw_held_out(measurements: Measurements, count: int, seed: int) -> np.ndarray:
    """Draw the configurations (n,) to be held out: at random, and whole groups, until there are
    `count` of them or just more; none without a reading beside the joints. Raises InputError where
    nothing is left.
    """
    groups = (
        np.full(len(measurements), NO_GROUP) if measurements.groups is None else measurements.groups
    )
    left, held = measurements.is_read, np.zeros(len(measurements), dtype=bool)
    for k in np.random.default_rng([seed, len(measurements)]).permutation(len(measurements)):
        if left[k] and not held[k] and int(held.sum()) < count:
            held |= (groups == groups[k]) if groups[k] != NO_GROUP else np.arange(len(held)) == k
    if not np.any(left & ~held):
        raise InputError(
            "--hold-out: whole groups are held out, and none would be left; hold out less, or take "
            "more groups"
        )
    return held


def predict_held_out(fit: Calibration, measurements: Measurements, seed: int) -> HeldOut:
    """Predict held-out configurations by a fit; their direct problems begin at their neighbours'
    solutions.
    """
    labels = measurements.labels
    problem, z, solved = close_others(fit.problem, fit.state, measurements, seed)
    unsolved = tuple(labels[int(k)] for k in np.flatnonzero(~solved))
    if not len(z):
        return HeldOut(tuple(labels), unsolved, seed)
    root = covariance_root(fit.covariance, fit.problem)
    known = fit.problem.readings.known
    factor = 1.0 if known else max(fit.chi_square / max(fit.degrees, 1), 1e-300)
    made = clean = predict_readings(problem, fit.state.p, z, root, factor)
    taken, group, kept = problem.readings.taken, problem.readings.group, np.ones(len(z), dtype=bool)
    level = 1.0 - (1.0 - OUTLIER_LEVEL) ** (1.0 / len(z))
    chances = [
        _probability(fit, made.chi_square(np.array([k])), int(count))
        for k, count in enumerate(np.sum(taken, axis=1))
    ]
    off = np.array([chance is not None and chance < level for chance in chances])
    if 0 < np.sum(off) <= MAX_OUTLIER_SHARE * len(z):
        kept = ~off
        clean = predict_readings(problem, fit.state.p, z, root, factor, kept)
    degrees = int(np.sum(taken[kept])) - 2 * len(set(group[kept].tolist()) - {-1})
    chi_square = clean.chi_square(kept)
    squares, expected = made.errors**2, np.diagonal(made.covariance, axis1=1, axis2=2)
    kinds = np.array([kind for kind, _ in problem.model.columns])
    inside = {kind: taken & (kinds == kind) for kind in dict.fromkeys(kinds.tolist())}
    rms, expectation = (
        {kind: float(np.sqrt(np.mean(v[some]))) for kind, some in inside.items() if some.any()}
        for v in (squares, expected)
    )
    return HeldOut(
        tuple(labels),
        unsolved,
        seed,
        rms,
        expectation,
        chi_square,
        degrees,
        _probability(fit, chi_square, degrees),
        tuple(problem.measurements.labels[int(k)] for k in np.flatnonzero(~kept)),
    )


def _probability(fit: Calibration, chi_square: float, degrees: int) -> float | None:
    if degrees <= 0 or fit.degrees <= 0:
        return None
    return chi_square_tail(chi_square, degrees, None if fit.problem.readings.known else fit.degrees)
