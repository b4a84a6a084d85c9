"""Try readings as they might be meant: where each trial begins, what a fit from there leaves, and
which of two explains the readings; and so find the Euler sequence that the angles of a file follow.

About moving axes (capitals) the angles of the columns 1, 2, 3 turn in this order about the axes
named; about fixed axes (small letters) likewise. A sequence about moving axes is the reversed one
about fixed axes with the angles in reversed order, so that twenty-four remain for columns in a
given order; those that give the same rotations for all rows are one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symkin.calibration.data.files import DataFile, euler_quaternions
from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.estimate.configurations import first_points, newton_configurations
from symkin.calibration.estimate.estimator import estimate, parameters_at_poses
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.residuals import linearise
from symkin.calibration.estimate.starting import fit_measuring_frames, has_home, with_starts
from symkin.calibration.estimate.state import readings_at, spectrum
from symkin.calibration.judge.statistics import (
    SIGNIFICANCE,
    chi_square_tail,
    misfits,
    rms_of_better_part,
)
from symkin.errors import InputError
from symkin.files.euler_columns import SEQUENCES
from symkin.model.mechanism import Mechanism
from symkin.position.solution import finite

_WIDENED = 10.0
"""How much wider the prior of a trial is: what is meant must be found of machines far off, too."""
_CLEAR_RATIO = 9.0
"""A trial's chi-square per degree of freedom must be so many times another's for the choice to be
clear: readings that are off three times as far.
"""
_UNCLOSED_MISFIT = 0.1
"""A configuration that does not close counts in a fit as one whose readings are off by this share
of the size (angles: radians), and no configuration counts as more: what explains most of the
configurations is wanted, and not what leaves out those that it does not.
"""


@dataclass(frozen=True)
class Trial:
    """How well readings are explained: chi-square with its degrees of freedom, and whether standard
    deviations are known.
    """

    chi_square: float
    degrees: int
    known: bool

    @property
    def score(self) -> float:
        """Chi-square per degree of freedom."""
        return self.chi_square / self.degrees

    def better_than(self, other: Trial) -> bool:
        """Tell whether the data separate the two: the other is worse by far more than noise can
        make of equal ones, and worse than noise.
        """
        ratio = other.score / max(self.score, 1.0 if self.known else 1e-300)
        if not ratio > _CLEAR_RATIO:
            return False
        if self.known:
            return chi_square_tail(other.chi_square, other.degrees) < SIGNIFICANCE
        # each explains the same readings with the noise that it leaves: how much less likely these
        # are by the other
        likelihood = -0.5 * min(self.degrees, other.degrees) * math.log(ratio)
        return likelihood < math.log(SIGNIFICANCE)


NO_TRIAL = Trial(math.inf, 1, known=False)
"""Readings that cannot be tried."""


@dataclass(frozen=True, eq=False)
class Start:
    """Where a trial begins: parameters p, configurations z there, which of them close, and how far
    their readings are off (n, K), in radians and the length unit, NaN where nothing was read. Those
    of a configuration that does not close are off by a radian, or the size.
    """

    problem: CalibrationProblem
    p: np.ndarray
    z: np.ndarray
    solved: np.ndarray
    off: np.ndarray

    @property
    def misfit(self) -> float:
        """How far readings are off together (length unit), angles times the size: root mean square
        over the better four fifths of the configurations, so that single bad rows do not count.
        """
        return rms_of_better_part(np.nansum((self.off * self.problem.model.lengths) ** 2, axis=1))

    @property
    def misfits(self) -> dict[str, float]:
        """How far readings are off by kind (radians, length unit), see `misfits`."""
        return misfits(self.off, self.problem.model.keys)

    @property
    def trial(self) -> Trial:
        """What the start itself explains, whatever the noise."""
        count = self.problem.readings.count
        return Trial(count * self.misfit**2, count, known=False)

    def fitted(self) -> Trial | None:
        """What a fit over the configurations that close explains, the others counted as misfit;
        None where it leaves no degree of freedom.
        """
        problem, solved = self.problem, self.solved
        some = problem.of(np.flatnonzero(solved))
        state = estimate(some, self.z[solved], p=self.p, max_iterations=20).state
        degrees = problem.readings.count
        if not np.isfinite(state.linearised.vector).all():
            return None
        degrees -= len(problem.names) - spectrum(state)[1].shape[1]
        if degrees <= 0:
            return None
        units = problem.size / problem.model.lengths
        most = np.sum((_UNCLOSED_MISFIT * problem.readings.weight * units) ** 2, axis=1)
        squares = np.minimum(np.sum(state.linearised.residuals**2, axis=1), most[solved])
        chi_square = float(squares.sum() + most[~solved].sum())
        return Trial(chi_square, degrees, problem.readings.known)


def begin(
    mechanism: Mechanism, measurements: Measurements, *, at_poses: bool = False, **options: Any
) -> Start:
    """Begin a trial at the nominal geometry, or (`at_poses`) at that which whole measured poses
    give by themselves; measuring frames are where they fit best. `options` are those of
    `build_calibration`.
    """
    free = options.get("parameters"), options.get("fixed", ())
    ready = with_starts(mechanism, measurements, *free, completed=not has_home(mechanism))
    problem = replace(build_calibration(mechanism, ready, **options), widened=_WIDENED)
    model, readings = problem.model, problem.readings
    first = parameters_at_poses(problem) if at_poses else None
    p = model.nominal if first is None else first
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(model, first_points(model, ready, p), ready.joints, p)
        p = fit_measuring_frames(problem, np.nan_to_num(z), p, solved)
        h = np.nan_to_num(readings_at(problem, p, np.nan_to_num(z)))
        off = linearise("means", readings, h, np.zeros((*h.shape, 1))).residuals
        far = np.where(model.angular, 1.0, model.size)
        off = np.where(solved[:, None] & np.isfinite(off), off * readings.sigma, far)
        return Start(problem, p, z, solved, np.where(readings.taken, off, np.nan))


# --- Euler sequences ------------------------------------------------------------------------------


_TRIAL_ROWS = 60
"""Configurations that the trial fits use, spread evenly over the file."""
_FITTED_SEQUENCES = 4
"""Sequences, the best by their misfit before the fit, that are fitted."""


@dataclass(frozen=True)
class SequenceChoice:
    """The sequence that fits and those that read the same from these data; the trial fits of it and
    of the runner-up (None where no other could be fitted), over the same `configurations`.
    """

    sequence: str
    same: tuple[str, ...]
    best: Trial
    runner_up: str | None
    second: Trial | None
    configurations: int

    @property
    def clear(self) -> bool:
        return self.second is None or self.best.better_than(self.second)

    def text(self, *, fits: bool) -> str:
        """Say what was found, and whether a fit in this sequence `fits`, and is to be used."""
        if not fits:
            return (
                f"no Euler sequence led to a fit that can be used; the nearest was "
                f"{describe_sequence(self.sequence)}, chi-square per degree of "
                f"freedom {self.best.score:.3g}"
            )
        also = f" (the same on these data: {', '.join(self.same)})" if self.same else ""
        other, doubt = "no other sequence could be fitted", ""
        if self.second is not None:
            other = (
                f"the next best, {self.runner_up}, has {self.second.chi_square:.4g} with "
                f"{self.second.degrees}"
            )
        if not self.clear:
            doubt = (
                "; these data cannot tell the sequence: name it in the header, or take more "
                "postures and larger angles"
            )
        return (
            f"the angles fit the Euler sequence {describe_sequence(self.sequence)}{also}: "
            f"chi-square {self.best.chi_square:.4g} with {self.best.degrees} degrees of freedom "
            f"over {self.configurations} postures, {other}{doubt}"
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "sequence": self.sequence,
            "same": list(self.same),
            "chi_square": self.best.chi_square,
            "runner_up": self.runner_up,
            "runner_up_chi_square": finite(None if self.second is None else self.second.chi_square),
            "clear": self.clear,
        }


def describe_sequence(sequence: str) -> str:
    """Write 'ZYX about moving axes (xyz about fixed axes, angles in reversed order)'."""
    other = sequence[::-1].swapcase()
    here, there = ("moving", "fixed") if sequence.isupper() else ("fixed", "moving")
    return (
        f"{sequence} about {here} axes (= {other} about {there} axes with the angles in reversed "
        f"order)"
    )


def find_sequence(mechanism: Mechanism, data: DataFile, **options: Any) -> SequenceChoice:
    """Find the sequence of the file's open Euler angles; `options` are those of
    `build_calibration`.

    Raises InputError where no sequence leads to a fit.
    """
    if data.open_euler is None:
        raise InputError(f"{data.path}: the file has no Euler angles of unknown sequence")
    rows = spread_rows(len(data.measurements), _TRIAL_ROWS)
    families, some = equal_sequences(data.open_euler), data.subset(rows)
    starts = [
        (names, begin(mechanism, some.with_sequence(names[0]), at_poses=True, **options))
        for names in families
    ]
    starts = sorted((s for s in starts if s[1].solved.any()), key=lambda s: s[1].misfit)
    if not starts:
        raise InputError(
            "no Euler sequence leads to a fit; check units and the order of the columns"
        )
    fitted: list[tuple[tuple[str, ...], Trial]] = []
    undetermined = False
    for names, start in starts:
        trial = start.fitted()
        if trial is not None:
            fitted.append((names, trial))
        undetermined |= trial is None and bool(start.solved.all())
        if len(fitted) == _FITTED_SEQUENCES:
            break
    if undetermined or not fitted:
        raise InputError(
            f"{len(data.measurements)} postures have no more readings than there are "
            f"parameters, so that every Euler sequence fits: name the sequence in the header "
            f"(euler_ZYX_1[deg], ...), hold parameters, or add postures"
        )
    (best, trial), *others = sorted(fitted, key=lambda f: f[1].score)
    runner_up, second = (others[0][0][0], others[0][1]) if others else (None, None)
    return SequenceChoice(best[0], best[1:], trial, runner_up, second, len(rows))


def equal_sequences(angles: np.ndarray) -> list[tuple[str, ...]]:
    """Gather sequences that read the same rotations from all rows."""
    found: list[tuple[np.ndarray, list[str]]] = []
    given = angles[np.isfinite(angles).all(axis=1)]
    for sequence in SEQUENCES:
        q = euler_quaternions(given, sequence)
        same = (n for known, n in found if np.all(np.abs(np.sum(known * q, axis=1)) > 1 - 1e-12))
        if (names := next(same, None)) is None:
            found.append((q, names := []))
        names.append(sequence)
    return [tuple(names) for _, names in found]
