"""Which Euler sequence do the angles of a file follow? Every one is tried; the fit decides.

About moving axes (capitals) the angles of the columns 1, 2, 3 turn in this order about the axes named; about fixed axes (small
letters) likewise. A sequence about moving axes is the reversed one about fixed axes with the angles in reversed order, so that
twenty-four remain for columns in a given order; those that give the same rotations for all rows are one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.calibration.columns import SEQUENCES
from symkin.calibration.direct import newton_postures, start_points
from symkin.calibration.estimator import estimate
from symkin.calibration.files import DataFile, euler_quaternions
from symkin.calibration.from_poses import parameters_from_poses
from symkin.calibration.measurements import Measurements
from symkin.calibration.problem import CalibrationProblem, build_calibration
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism

_ROWS = 60
"""Postures that the trial fits use, spread evenly over the file."""
_FITTED = 4
"""Sequences, the best by their residuals before the fit, that are fitted."""
_CLEAR = 4.0
"""The runner-up's chi-square must be this many times the best one's for the choice to be clear."""


@dataclass(frozen=True)
class SequenceChoice:
    """The sequence that fits and those that read the same from these data; chi-square of the trial fits of it and of the
    runner-up (None where no other could be fitted), over the same `postures`."""

    sequence: str
    same: tuple[str, ...]
    chi_square: float
    runner_up: str | None
    runner_up_chi_square: float | None
    postures: int

    @property
    def clear(self) -> bool:
        return self.runner_up_chi_square is None or self.runner_up_chi_square > _CLEAR * self.chi_square

    def __str__(self) -> str:
        also = f" (the same on these data: {', '.join(self.same)})" if self.same else ""
        other = "no other sequence could be fitted"
        if self.runner_up is not None:
            other = f"the next best, {self.runner_up}, has {self.runner_up_chi_square:.4g}"
        doubt = "" if self.clear else "; the choice is not clear: name the sequence in the header, or take larger angles"
        return (
            f"the angles fit the Euler sequence {described(self.sequence)}{also}: chi-square {self.chi_square:.4g} over "
            f"{self.postures} postures, {other}{doubt}"
        )


def described(sequence: str) -> str:
    """'ZYX about moving axes (xyz about fixed axes, angles in reversed order)'."""
    other = sequence[::-1].swapcase()
    here, there = ("moving", "fixed") if sequence.isupper() else ("fixed", "moving")
    return f"{sequence} about {here} axes (= {other} about {there} axes with the angles in reversed order)"


def find_sequence(
    mechanism: Mechanism, data: DataFile, progress: Callable[[int, int], None] | None = None, **options: Any
) -> SequenceChoice:
    """The sequence of the file's open Euler angles; `options` are those of `calibrate`.

    Raises InputError where no sequence leads to a fit."""
    if data.open_euler is None:
        raise InputError(f"{data.path}: the file has no Euler angles of unknown sequence")
    rows = np.unique(np.linspace(0, len(data.measurements) - 1, _ROWS).astype(int))
    families = _families(data.open_euler)
    trials = {family[0]: data.with_sequence(family[0]).subset(rows) for family in families}
    starts = {s: _start(mechanism, trials[s], options) for s in trials}
    ranked = sorted((s for s in trials if starts[s].solved.any()), key=lambda s: starts[s].misfit)
    fitted: dict[str, float] = {}
    for done, sequence in enumerate(ranked[:_FITTED]):
        if progress is not None:
            progress(done, _FITTED)
        fitted[sequence] = starts[sequence].fitted(mechanism, options)
    if not fitted:
        raise InputError(f"{data.path}: no Euler sequence leads to a fit; check units and the order of the columns")
    best, *others = sorted(fitted, key=lambda s: fitted[s])
    same = next(family for family in families if family[0] == best)[1:]
    second = others[0] if others else None
    return SequenceChoice(best, same, fitted[best], second, None if second is None else fitted[second], len(rows))


def _families(angles: np.ndarray) -> list[tuple[str, ...]]:
    """Sequences that read the same rotations from all rows, together."""
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
class _Start:
    """Where a trial fit begins: the geometry p, the first estimate from whole poses or else nominal, postures z there, which of
    them close, and how badly the readings fit (angles times the size; a posture that does not close counts as one size)."""

    measurements: Measurements
    p: np.ndarray
    z: np.ndarray
    solved: np.ndarray
    misfit: float

    def fitted(self, mechanism: Mechanism, options: dict[str, Any]) -> float:
        """Chi-square of a fit over the postures that close, as much larger as postures are missing."""
        problem = _problem(mechanism, self.measurements.subset(self.solved), options)
        vector = estimate(problem, self.z[self.solved], p=self.p, max_iterations=20).state.fit.vector
        return float(vector @ vector) * len(self.solved) / int(self.solved.sum())


def _problem(mechanism: Mechanism, measurements: Measurements, options: dict[str, Any]) -> CalibrationProblem:
    chosen = {k: options[k] for k in ("parameters", "fixed", "residual") if k in options}
    return build_calibration(mechanism, measurements, **chosen)


def _start(mechanism: Mechanism, measurements: Measurements, options: dict[str, Any]) -> _Start:
    problem = _problem(mechanism, measurements, options)
    model = problem.model
    first = parameters_from_poses(model, measurements)
    p = model.nominal if first is None else first
    with np.errstate(all="ignore"):
        z, solved = newton_postures(model, start_points(model, measurements), measurements.joints, p)
        gap = model.evaluate(z, measurements.joints, p, problem.quaternions).readings - np.nan_to_num(problem.readings.values)
    weight = np.array([1.0 if kind in ("position", "distance") else model.closure.size for kind, _ in model.columns])
    gap = np.where(problem.readings.taken & solved[:, None] & np.isfinite(gap), gap * weight, 0.0)
    return _Start(measurements, p, z, solved, float(np.linalg.norm(gap)) + model.closure.size * float(np.sum(~solved)))
