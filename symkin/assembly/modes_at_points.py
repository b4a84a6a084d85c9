"""Modes at many points of one problem as arrays: what a sweep asks for.

Points are solved together, group by group (see `by_groups`), of the machine that the description
means; those that need another look one by one, as `symkin.modes` does.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from math import prod
from typing import NamedTuple

import numpy as np

from symkin.assembly.account import FEW
from symkin.assembly.as_written import (
    COMPLETE,
    Told,
    machine_of,
    may_contradict,
)
from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.by_groups import modes_by_groups, modes_of_inputs
from symkin.assembly.closed_roots import ClosedBlock
from symkin.assembly.group_roots import STATEMENTS, engines_together
from symkin.assembly.group_solvers import most_roots, solvers_of
from symkin.assembly.mode_table import COMPLETENESS, ModeTable, stored_counts
from symkin.assembly.modes_result import Modes
from symkin.assembly.plan import Plan, plan_of, refuse_unless_isolated
from symkin.assembly.search import Search
from symkin.assembly.without_search import errors_of_given, nothing
from symkin.computed_once import cached_property
from symkin.errors import InputError, TooManyModesError
from symkin.machine.lower import Lowered
from symkin.position.determination import determination
from symkin.position.given import Given, in_order
from symkin.position.problem import Problem, build_problem
from symkin.position.roots import NOT_KNOWN

ROOTS_AT_ONCE = 40_000
"""Complex roots that are held at once."""


class Plain(NamedTuple):
    """Modes of the points at the `places` (n,), rising."""

    table: ModeTable
    places: np.ndarray


@dataclass(frozen=True, eq=False)
class ModeFinder:
    """What is prepared once for all points of one problem of a mechanism; `search` holds starts and
    seed of random starts, for the points that need some. `own` is what is solved: the problem
    itself, or where `low` is told that of the machine which the description means, whose known
    values are the problem's at `columns`.
    """

    problem: Problem
    search: Search
    certify: bool
    own: GroupFinder
    low: Lowered | None = None
    columns: tuple[int, ...] = ()

    @property
    def engine(self) -> str:
        """What tracks the paths."""
        return self.own.engine or "none"

    @property
    def starts_digest(self) -> str:
        """Hash of the roots from which paths begin."""
        return self.own.starts_digest

    @property
    def bound(self) -> int | None:
        """Most isolated modes that a point can have, where paths tell."""
        if self.problem.is_explicit:
            return 1
        return self.own.most_modes if self.own.is_tracked else None

    def find_values(self, known: np.ndarray, off_motion: np.ndarray | None = None) -> ModeTable:
        """All modes at points known (n, numbers): values of the known coordinates in the length
        unit and radians, quaternions of unit length; `off_motion` (n,) is how far a pose lies off
        the platform's motion, where some does (length unit).
        """
        off = np.zeros(len(known)) if off_motion is None else off_motion
        feasible = np.flatnonzero(off == 0.0)
        with np.errstate(all="ignore"):
            found, places = self._together(known[feasible])
            places = feasible[places]
            if len(places) == len(known):
                return found
            others = np.setdiff1d(np.arange(len(known)), places)
            alone = [self._one(known[i], float(off[i])) for i in others.tolist()]
            return ModeTable.joined([found, *alone]).at(np.argsort(np.append(places, others)))

    def _together(self, known: np.ndarray) -> Plain:
        """Modes at those of the points known (n, values) that need not be looked at one by one; of
        the machine's where its list is complete and closes on all rows of the description.
        """
        if self.low is None:
            return self.own.find(known, self.certify)
        told = Told(self.low, self.problem, known)
        there, places = self.own.find(known[:, list(self.columns)], self.certify, told)
        whole = np.isin(there.completeness, [COMPLETENESS.index(c) for c in COMPLETE])
        kept = np.flatnonzero(whole & (there.count >= 0))
        return Plain(there.at(kept), places[kept])

    def _one(self, known: np.ndarray, off_motion: float) -> ModeTable:
        """One point, alone."""
        if off_motion > 0.0:
            return ModeTable.of(self._empty, "off the motion")
        given = Given(tuple(c.name for c in self.problem.known_coordinates), known, {})
        try:
            return ModeTable.of(modes_of_inputs(self.problem, [given], self.search)[0])
        except TooManyModesError:
            return ModeTable.of(self._empty, "too many to list", -1)

    @cached_property
    def _empty(self) -> Modes:
        """No modes."""
        return nothing(self.problem, Given((), np.zeros(0), {}), self.search)


@dataclass(frozen=True, eq=False)
class GroupFinder:
    """What is prepared once for all points of a problem that is solved by its structure groups."""

    problem: Problem
    search: Search

    @cached_property
    def _solvers(self) -> list[BlockPaths | ClosedBlock]:
        return [solver for group in self._groups for solver in solvers_of(group)]

    @cached_property
    def _groups(self) -> tuple[Problem, ...]:
        """The groups of the problem; none where nothing is searched."""
        return () if self.problem.is_explicit else self._plan.groups

    @property
    def _plan(self) -> Plan:
        return plan_of(self.problem, self.search)

    @property
    def engine(self) -> str | None:
        """What tracks the paths or has the formulas."""
        return engines_together(solver.engine for solver in self._solvers)

    @cached_property
    def starts_digest(self) -> str:
        """Hash of the roots from which paths begin, and of the formulas."""
        digest = hashlib.sha256()
        for solver in self._solvers:
            digest.update(solver.digest)
        return digest.hexdigest()

    @cached_property
    def _bounds(self) -> list[int | None]:
        return [most_roots(group) for group in self._groups]

    @property
    def is_tracked(self) -> bool:
        """Whether every group has paths, or is linear."""
        return bool(self._groups) and None not in self._bounds

    @property
    def most_modes(self) -> int:
        """Most isolated modes that a point can have, groups without paths left aside."""
        return prod(bound for bound in self._bounds if bound is not None)

    def find(self, known: np.ndarray, certify: bool, told: Told | None = None) -> Plain:
        """Modes at those of the points known (n, values) that need not be looked at one by one:
        all, but for points that contradict rows without unknowns, and those without a solution
        where the description's digits may be why. Those of a machine are `told` in the coordinates
        of a description.
        """
        meets = errors_of_given(self._plan, known) == 0.0
        chosen = np.flatnonzero(bool(self._groups) & meets)
        each = max(1, ROOTS_AT_ONCE // max(self.most_modes, 1))
        parts = [chosen[i : i + each] for i in range(0, max(len(chosen), 1), each)]
        table = ModeTable.joined(
            [
                self._table(known[part], certify, None if told is None else told.of(part))
                for part in parts
            ]
        )
        if not determination(self.problem).misfit:
            return Plain(table, chosen)
        places = np.flatnonzero(table.count != 0)
        return Plain(table.at(places), chosen[places])

    def _table(self, known: np.ndarray, certify: bool, told: Told | None) -> ModeTable:
        found = modes_by_groups(self.problem, known, self.search, certify=certify, told=told)
        listed = np.bincount(found.owner, minlength=len(known))
        account = found.account
        many = (account.too_many != FEW) | np.array(listed < found.total, dtype=bool)
        complex_counts = np.where(account.whole & ~many, np.prod(found.factors, axis=1), NOT_KNOWN)
        return ModeTable(
            found.asked,
            found.listed.chosen(~many[found.owner]) if many.any() else found.listed,
            count=np.where(many, -1, listed),
            completeness=np.where(
                many,
                COMPLETENESS.index("too many to list"),
                COMPLETENESS.index(STATEMENTS[0]) + found.statement,
            ),
            unresolved=stored_counts(account.unresolved.sum(axis=1)),
            continuum=np.asarray(account.continuum.any(axis=1)),
            complex_count=stored_counts(complex_counts),
        )


def make_finder(problem: Problem, *, starts: int, seed: int, certify: bool) -> ModeFinder:
    """The finder of one problem; a start that is not kept yet is computed. Raises InputError where
    the problem has no isolated solutions.
    """
    search = Search("continuation", starts, seed, "batched")
    if problem.by_name:
        refuse_unless_isolated(problem)
    return _of_machine(problem, search, certify) or ModeFinder(
        problem, search, certify, _own(problem, search)
    )


def _of_machine(problem: Problem, search: Search, certify: bool) -> ModeFinder | None:
    """The finder that solves the machine which a description means, for values of joints; None
    where that is the description.
    """
    names = tuple(c.name for c in problem.known_coordinates)
    if any(c.width > 1 for c in problem.known_coordinates) or problem.of_pose:
        return None
    # values that tell which of them the machine takes
    given = Given(names, np.arange(len(names)), {})
    low = machine_of(problem.mechanism, names)
    if low is None or may_contradict(low, given):
        return None
    there = in_order(low.machine, given)
    of_machine = build_problem(low.machine, there.names)
    if of_machine.is_explicit:
        return None
    columns = tuple(map(int, there.values))
    return ModeFinder(problem, search, certify, _own(of_machine, search), low, columns)


def _own(problem: Problem, search: Search) -> GroupFinder:
    """The finder of a description itself."""
    if (free := plan_of(problem, search).free) is not None:
        other = "; sweep over its inputs" if problem.mechanism.serial else ""
        raise InputError(f"{free}, so that its solutions are no isolated modes{other}")
    return GroupFinder(problem, search)
