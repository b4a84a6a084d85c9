"""Hold the readings in which mistakes are sought, as they stand in a file or put right."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.files import DataFile
from symkin.calibration.data.measurements import Measurements, spread_rows
from symkin.calibration.data.observables import written
from symkin.calibration.judge.trials import NO_TRIAL, Start, Trial, begin
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism

EXAMINED_CONFIGURATIONS = 40
"""Configurations that are looked at, spread evenly over the file: enough to see a mistake of all
rows.
"""
MIN_WHOLE_POSES = 4
"""Whole poses from which columns are assigned to joints, and frames are sought."""


@dataclass(frozen=True, eq=False)
class Case:
    """What the rules look at: readings of a mechanism, parameters that are unknown frames, and
    Euler angles (n, 3) as they stand with the sequence in which they are read, and whether this was
    sought, so that any other may be meant; and whether a fit took the poses where they stand, so
    that no frame is left out.
    """

    mechanism: Mechanism
    measurements: Measurements
    frames: tuple[str, ...] = ()
    euler: np.ndarray | None = None
    sequence: str = ""
    sought: bool = False
    placed: bool = False

    @staticmethod
    def of(
        mechanism: Mechanism, data: DataFile, sequence: str = "", frames: Sequence[str] = ()
    ) -> Case:
        """Make the case of a file; `sequence` is that of Euler angles whose header names none."""
        named, sought = data.sequence or sequence, data.open_euler is not None
        readings = data.with_sequence(sequence)
        return Case(mechanism, readings, tuple(frames), data.euler, named, sought)

    def start(self) -> Start | None:
        """Begin a trial of the readings at the nominal geometry, None where that cannot be."""
        try:
            return begin(self.mechanism, self.measurements, parameters=self.frames or None)
        except SymkinError:
            return None

    def trial(self) -> Trial:
        start = self.start()
        return NO_TRIAL if start is None else start.trial

    def reading(self, measurements: Measurements) -> Case:
        """Take other readings in place of these."""
        return replace(self, measurements=measurements)

    @property
    def left_by_chance(self) -> float:
        """What is left, as a trial's score, where joints are those of other rows, which explain
        nothing; few rows, or groups alone, whose rows are alike, say nothing of it.
        """
        m = self.measurements
        grouped = all(o.kind == "group" for o, _ in m.channels(self.mechanism))
        if grouped or len(m) < MIN_WHOLE_POSES:
            return math.inf
        joints = np.random.default_rng(0).permutation(m.joints)
        return self.reading(replace(m, joints=joints)).trial().score

    def subset(self, rows: np.ndarray) -> Case:
        euler = None if self.euler is None else self.euler[rows]
        return replace(self, measurements=self.measurements.subset(rows), euler=euler)

    @property
    def examined(self) -> Case:
        """Some rows, spread over the file, whole groups where there are any."""
        m = self.measurements
        rows = spread_rows(len(m), EXAMINED_CONFIGURATIONS)
        if m.groups is not None and len(m) > EXAMINED_CONFIGURATIONS:
            rows = np.flatnonzero(np.isin(m.groups, np.unique(m.groups[rows])))
        return self.subset(rows[: 4 * EXAMINED_CONFIGURATIONS])

    @property
    def consecutive(self) -> Case:
        """The first rows, so that each stands beside its neighbours."""
        return self.subset(np.arange(min(len(self.measurements), EXAMINED_CONFIGURATIONS)))

    def is_possible(self, measurements: Measurements) -> bool:
        """Tell whether no reading is below the least of its joint (rods of negative length)."""
        least = [-math.inf if c.least is None else c.least for c in self.mechanism.actuated]
        return bool(np.all(measurements.joints > np.array(least)))

    def angle(self, value: float) -> str:
        return written(self.mechanism, "angle", value, ".3g")


Finding = tuple[str, Case | None]
"""A sentence on a mistake, and the case put right by which it is judged; None where the readings
alone show it.
"""
Mistakes = dict[str, dict[str, Callable[[Case], Iterable[Finding]]]]
"""By stage, the mistakes that are looked for, each with its possible forms in a case."""
