"""Find the Euler sequence that the angles of a file follow: each one is tried, and the fit decides.

About moving axes (capitals) the angles of the columns 1, 2, 3 turn in this order about the axes
named; about fixed axes (small letters) likewise. A sequence about moving axes is the reversed one
about fixed axes with the angles in reversed order, so that twenty-four remain for columns in a
given order; those that give the same rotations for all rows are one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.calibration.data.files import DataFile, euler_quaternions
from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.judge.trials import Trial, begin
from symkin.errors import InputError
from symkin.files.euler_columns import SEQUENCES
from symkin.model.mechanism import Mechanism
from symkin.position.solution import finite

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
    given = angles[np.all(np.isfinite(angles), axis=1)]
    for sequence in SEQUENCES:
        q = euler_quaternions(given, sequence)
        same = (n for known, n in found if np.all(np.abs(np.sum(known * q, axis=1)) > 1 - 1e-12))
        names = next(same, None)
        if names is None:
            found.append((q, [sequence]))
        else:
            names.append(sequence)
    return [tuple(names) for _, names in found]
