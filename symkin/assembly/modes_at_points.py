"""Modes at many points of one mechanism as arrays: what a sweep asks for.

Points that leave nothing in doubt are found together (see `plain_modes`), all others one by one, as `symkin.modes` does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.assembly.mode_table import ModeTable, from_modes, joined, nothing
from symkin.assembly.one_input import modes_of_input
from symkin.assembly.plain_modes import PlainModes, plain_modes
from symkin.assembly.search import Search
from symkin.errors import InputError, TooManyModesError
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import Progress
from symkin.position.given import Given, given_from
from symkin.position.problem import Kind, Problem, build_problem


@dataclass(frozen=True, eq=False)
class ModeFinder:
    """What is prepared once for all points of one problem of a mechanism; `search` holds starts and seed of random starts, for
    the points that need some."""

    problem: Problem
    search: Search
    certify: bool
    plain: PlainModes

    @property
    def engine(self) -> str:
        """What tracks the paths."""
        return self.plain.engine or "none"

    @property
    def starts_digest(self) -> str:
        """Hash of the roots from which paths begin."""
        return self.plain.starts_digest

    @property
    def bound(self) -> int | None:
        """Most isolated modes that a point can have, where paths tell."""
        if self.problem.is_explicit:
            return 1
        return self.plain.most_modes if self.plain.parts else None

    def enumerate(self, inputs: Sequence[Mapping[str, Any]]) -> ModeTable:
        """All modes at points given as arguments of `symkin.modes`."""
        return self.find([given_from(self.problem.mechanism, g.get("joints"), g.get("pose")) for g in inputs])

    def find(self, givens: Sequence[Given]) -> ModeTable:
        """All modes at given points."""
        values = np.array([given.values for given in givens]).reshape(len(givens), -1)
        return self.find_values(values, np.array([given.off_motion for given in givens]))

    def find_values(self, known: np.ndarray, off_motion: np.ndarray | None = None) -> ModeTable:
        """All modes at points known (n, numbers): values of the known coordinates in the length unit and radians, quaternions of
        unit length; `off_motion` (n,) is how far a pose lies off the platform's motion, where some does (length unit)."""
        off = np.zeros(len(known)) if off_motion is None else off_motion
        feasible = np.flatnonzero(off == 0.0)
        with np.errstate(all="ignore"):
            found = self.plain.find(known[feasible], certify=self.certify)
            places = feasible[found.places]
            if len(places) == len(known):
                return found.table
            others = np.setdiff1d(np.arange(len(known)), places).tolist()
            return joined(found.table, places, {i: self._one(known[i], float(off[i])) for i in others})

    def _one(self, known: np.ndarray, off_motion: float) -> ModeTable:
        """One point, alone."""
        if off_motion > 0.0:
            return nothing(self.problem.closure, "off the motion", 0)
        try:
            found, _ = modes_of_input(self.problem, Given(self.problem.kind, known, {}), self.search)
        except TooManyModesError:
            return nothing(self.problem.closure, "too many to list", -1)
        return from_modes(found)


def make_finder(
    mechanism: Mechanism, kind: Kind, *, starts: int, seed: int, certify: bool, progress: Progress | None = None
) -> ModeFinder:
    """The finder of one problem; a start that is not kept yet is computed. Raises InputError where the problem has no
    isolated solutions."""
    problem = build_problem(mechanism, kind)
    if mechanism.serial and problem.system.freedom > problem.generic_rank:
        raise InputError(
            f"{mechanism.name}: its {len(mechanism.actuated)} joints leave solutions of a pose free, so that none is isolated; "
            "sweep over its inputs"
        )
    return ModeFinder(problem, Search("continuation", starts, seed, "batched"), certify, plain_modes(problem, progress))
