"""Find the Euler sequence that the angles of a file follow: each one is tried, and the fit decides.

About moving axes (capitals) the angles of the columns 1, 2, 3 turn in this order about the axes
named; about fixed axes (small letters) likewise. A sequence about moving axes is the reversed one
about fixed axes with the angles in reversed order, so that twenty-four remain for columns in a
given order; those that give the same rotations for all rows are one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symkin.calibration.data.files import DataFile, euler_quaternions
from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.estimate.configurations import first_points, newton_configurations
from symkin.calibration.estimate.estimator import estimate, parameters_at_poses
from symkin.calibration.estimate.first_guess import fit_measuring_frames
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.starting import with_starts
from symkin.calibration.estimate.state import design, spectrum
from symkin.calibration.judge.plausibility import MAX_NOISE_RATIO
from symkin.calibration.judge.statistics import SIGNIFICANCE, chi_square_tail
from symkin.errors import InputError
from symkin.files.euler_columns import SEQUENCES
from symkin.model.mechanism import Mechanism

_TRIAL_ROWS = 60
"""Configurations that the trial fits use, spread evenly over the file."""
_TRIAL_WIDENED = 10.0
"""How much wider the prior of a trial is: the sequence must be found of machines far off, too."""
_FITTED_SEQUENCES = 4
"""Sequences, the best by their residuals before the fit, that are fitted."""
_CLEAR_RATIO = 4.0
"""The runner-up's chi-square per degree of freedom must be this many times the best one's for the
choice to be clear.
"""
_UNCLOSED_MISFIT = 0.1
"""A configuration that does not close counts as one whose readings are off by this share of the
size (angles: radians), and no configuration counts as more: the sequence that explains most of the
configurations is wanted, and not the one that leaves out what it does not.
"""


@dataclass(frozen=True)
class SequenceTrial:
    """A trial fit: chi-square over all configurations, those that do not close counted as
    `_UNCLOSED_MISFIT` says, its degrees of freedom, and whether standard deviations are known.
    """

    chi_square: float
    degrees: int
    known: bool

    @property
    def score(self) -> float:
        """Chi-square per degree of freedom."""
        return self.chi_square / self.degrees

    def better_than(self, other: SequenceTrial) -> bool:
        """Tell whether the data separate the two: the other is worse by far more than noise can
        make of equal fits, and worse than noise.
        """
        ratio = other.score / max(self.score, 1.0 if self.known else 1e-300)
        if self.known:
            return (
                ratio > _CLEAR_RATIO
                and chi_square_tail(other.chi_square, other.degrees) < SIGNIFICANCE
            )
        # both are fits of the same readings, each with the noise that it leaves: how much less
        # likely these are by the other
        likelihood = -0.5 * min(self.degrees, other.degrees) * math.log(ratio)
        return ratio > _CLEAR_RATIO and likelihood < math.log(SIGNIFICANCE)


@dataclass(frozen=True)
class SequenceChoice:
    """The sequence that fits and those that read the same from these data; the trial fits of it and
    of the runner-up (None where no other could be fitted), over the same `configurations`.
    """

    sequence: str
    same: tuple[str, ...]
    best: SequenceTrial
    runner_up: str | None
    second: SequenceTrial | None
    configurations: int

    @property
    def chi_square(self) -> float:
        return self.best.chi_square

    @property
    def runner_up_chi_square(self) -> float | None:
        return None if self.second is None else self.second.chi_square

    @property
    def clear(self) -> bool:
        return self.second is None or self.best.better_than(self.second)

    @property
    def is_beyond(self) -> bool:
        """Whether even the best leaves residuals beyond any noise."""
        return self.best.known and self.best.score > MAX_NOISE_RATIO**2

    @property
    def none_fits(self) -> str:
        """The sentence where the fit in this sequence is not to be used."""
        return (
            f"no Euler sequence led to a fit that can be used; the nearest was "
            f"{describe_sequence(self.sequence)}, chi-square per degree of "
            f"freedom {self.best.score:.3g}"
        )

    def __str__(self) -> str:
        also = f" (the same on these data: {', '.join(self.same)})" if self.same else ""
        other = "no other sequence could be fitted"
        if self.second is not None:
            other = (
                f"the next best, {self.runner_up}, has {self.second.chi_square:.4g} with "
                f"{self.second.degrees}"
            )
        doubt = (
            ""
            if self.clear
            else (
                "; these data cannot tell the sequence: name it in the header, or take more "
                "postures and larger angles"
            )
        )
        return (
            f"the angles fit the Euler sequence {describe_sequence(self.sequence)}{also}: "
            f"chi-square {self.chi_square:.4g} with "
            f"{self.best.degrees} degrees of freedom over {self.configurations} postures, "
            f"{other}{doubt}"
        )


def describe_sequence(sequence: str) -> str:
    """Write 'ZYX about moving axes (xyz about fixed axes, angles in reversed order)'."""
    other = sequence[::-1].swapcase()
    here, there = ("moving", "fixed") if sequence.isupper() else ("fixed", "moving")
    return (
        f"{sequence} about {here} axes (= {other} about {there} axes with the angles in reversed "
        f"order)"
    )


def find_sequence(
    mechanism: Mechanism,
    data: DataFile,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> SequenceChoice:
    """Find the sequence of the file's open Euler angles; `options` are those of `calibrate`.

    Raises InputError where no sequence leads to a fit.
    """
    if data.open_euler is None:
        raise InputError(f"{data.path}: the file has no Euler angles of unknown sequence")
    rows = spread_rows(len(data.measurements), _TRIAL_ROWS)
    families = _equal_sequences(data.open_euler)
    trials = {family[0]: data.with_sequence(family[0]).subset(rows) for family in families}
    starts = {s: _trial_start(mechanism, trials[s], options) for s in trials}
    ranked = sorted((s for s in trials if starts[s].solved.any()), key=lambda s: starts[s].misfit)
    if not ranked:
        raise InputError(
            f"{data.path}: no Euler sequence leads to a fit; check units and the order of the "
            f"columns"
        )
    fitted: dict[str, SequenceTrial] = {}
    undetermined = False
    for sequence in ranked:
        if progress is not None:
            progress(len(fitted), _FITTED_SEQUENCES)
        trial = starts[sequence].fitted(mechanism, options)
        if trial is not None:
            fitted[sequence] = trial
        undetermined |= trial is None and bool(starts[sequence].solved.all())
        if len(fitted) == _FITTED_SEQUENCES:
            break
    if undetermined or not fitted:
        raise InputError(
            f"{data.path}: {len(data.measurements)} postures have no more readings than there are "
            f"parameters, so that every Euler "
            "sequence fits: name the sequence in the header (euler_ZYX_1[deg], ...), hold "
            "parameters, or add postures"
        )
    best, *others = sorted(fitted, key=lambda s: fitted[s].score)
    same = next(family for family in families if family[0] == best)[1:]
    second = others[0] if others else None
    return SequenceChoice(
        sequence=best,
        same=same,
        best=fitted[best],
        runner_up=second,
        second=None if second is None else fitted[second],
        configurations=len(rows),
    )


def diagnose_sequence(
    mechanism: Mechanism, data: DataFile, options: dict[str, Any]
) -> tuple[str, ...]:
    """A sentence where the Euler angles fit another sequence than the one that the header names, or
    none; `options` are those of `calibrate`.
    """
    if data.sequence is None or data.euler is None:
        return ()
    try:
        choice = find_sequence(mechanism, replace(data, sequence=None), **options)
    except InputError:
        return ()
    if not choice.clear or data.sequence in (choice.sequence, *choice.same) or choice.is_beyond:
        return ()
    return (
        f"the Euler angles look to be of another sequence than {data.sequence}, which the header "
        f"names: {describe_sequence(choice.sequence)} fits, with "
        f"chi-square {choice.chi_square:.4g} at {choice.best.degrees} degrees of freedom",
    )


def _equal_sequences(angles: np.ndarray) -> list[tuple[str, ...]]:
    """Gather sequences that read the same rotations from all rows."""
    found: list[tuple[np.ndarray, list[str]]] = []
    given = angles[np.all(np.isfinite(angles), axis=1)]
    for sequence in SEQUENCES:
        q = euler_quaternions(given, sequence)
        for known, names in found:
            if np.all(np.abs(np.sum(known * q, axis=1)) > 1 - 1e-12):
                names.append(sequence)
                break
        else:
            found.append((q, [sequence]))
    return [tuple(names) for _, names in found]


@dataclass(frozen=True, eq=False)
class _TrialStart:
    """Where a trial fit begins: the geometry p, the first estimate from whole poses or else
    nominal, configurations z there, which of them close, and how badly the readings fit (angles
    times the size; a configuration that does not close counts as one size).
    """

    measurements: Measurements
    p: np.ndarray
    z: np.ndarray
    solved: np.ndarray
    misfit: float

    def fitted(self, mechanism: Mechanism, options: dict[str, Any]) -> SequenceTrial | None:
        """A fit over the configurations that close, the others counted as misfit; None where all
        readings leave no degree of freedom.
        """
        problem = _problem(mechanism, self.measurements.subset(self.solved), options)
        state = estimate(problem, self.z[self.solved], p=self.p, max_iterations=20).state
        if not np.all(np.isfinite(state.linearised.vector)):
            return None
        rank, whole = spectrum(design(state)).rank, _problem(mechanism, self.measurements, options)
        if whole.readings.count <= rank:
            return None
        most = _largest_squares(whole)
        squares = np.minimum(np.sum(state.linearised.residuals**2, axis=1), most[self.solved])
        chi_square = float(np.sum(squares) + np.sum(most[~self.solved]))
        return SequenceTrial(chi_square, whole.readings.count - rank, whole.readings.known)


def _largest_squares(problem: CalibrationProblem) -> np.ndarray:
    """Return what each configuration counts at most (n,): its readings off by `_UNCLOSED_MISFIT` of
    the size, over their standard deviations.
    """
    units = np.where(problem.model.angular, 1.0, problem.model.closure.characteristic_length)
    return np.asarray(np.sum((_UNCLOSED_MISFIT * problem.readings.weight * units) ** 2, axis=1))


def _problem(
    mechanism: Mechanism, measurements: Measurements, options: dict[str, Any]
) -> CalibrationProblem:
    chosen = {k: options[k] for k in ("parameters", "fixed", "residual") if k in options}
    return replace(build_calibration(mechanism, measurements, **chosen), widened=_TRIAL_WIDENED)


def _trial_start(
    mechanism: Mechanism, measurements: Measurements, options: dict[str, Any]
) -> _TrialStart:
    measurements = with_starts(mechanism, measurements)
    problem = _problem(mechanism, measurements, options)
    model = problem.model
    first = parameters_at_poses(problem)
    p = model.nominal if first is None else first
    with np.errstate(all="ignore"):
        z, solved = newton_configurations(
            model, first_points(model, measurements, p), measurements.joints, p
        )
        p = fit_measuring_frames(problem, z, p, solved)
        gap = model.evaluate(
            z, measurements.joints, p, problem.quaternions
        ).readings - np.nan_to_num(problem.readings.values)
    gap = np.where(
        problem.readings.taken & solved[:, None] & np.isfinite(gap), gap * model.lengths, 0.0
    )
    return _TrialStart(
        measurements=measurements,
        p=p,
        z=z,
        solved=solved,
        misfit=float(np.linalg.norm(gap))
        + model.closure.characteristic_length * float(np.sum(~solved)),
    )
