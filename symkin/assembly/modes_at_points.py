"""Modes at many points of one problem as arrays: what a sweep asks for.

Points are solved together, group by group (see `by_groups`), of the machine that the description
means; those that need another look one by one, as `symkin.modes` does.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, NamedTuple

import numpy as np

from symkin.assembly.account import FEW
from symkin.assembly.as_written import (
    COMPLETE,
    Told,
    given_of_machine,
    machine_of,
    may_contradict,
)
from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.by_groups import modes_by_groups
from symkin.assembly.closed_roots import ClosedBlock
from symkin.assembly.group_roots import STATEMENTS
from symkin.assembly.group_solvers import most_roots, solved_groups, solvers_of
from symkin.assembly.mode_table import (
    COMPLETENESS,
    ModeTable,
    at_places,
    concatenated,
    from_modes,
    joined,
    nothing,
    stored_counts,
    table_of,
)
from symkin.assembly.modes_by_name import modes_by_name
from symkin.assembly.search import Search
from symkin.assembly.without_search import (
    free_unknowns,
    known_without_search,
    meet_conditions,
)
from symkin.computed_once import cached_property
from symkin.errors import InputError, TooManyModesError
from symkin.position.determination import determination, refuse_unless_determined
from symkin.position.given import Given
from symkin.position.given_by_name import any_given, problem_of
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN

ROOTS_AT_ONCE = 40_000
"""Complex roots that are held at once."""


@dataclass(frozen=True, eq=False)
class ModeFinder:
    """What is prepared once for all points of one problem of a mechanism; `search` holds starts and
    seed of random starts, for the points that need some.
    """

    problem: Problem
    search: Search
    certify: bool
    plain: GroupFinder

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
        return self.plain.most_modes if self.plain.is_tracked else None

    def enumerate(self, inputs: Sequence[Mapping[str, Any]]) -> ModeTable:
        """All modes at points given as arguments of `symkin.modes`."""
        return self.find([any_given(self.problem.mechanism, **g) for g in inputs])

    def find(self, givens: Sequence[Given]) -> ModeTable:
        """All modes at given points."""
        values = np.array([given.values for given in givens]).reshape(len(givens), -1)
        return self.find_values(values, np.array([given.off_motion for given in givens]))

    def find_values(self, known: np.ndarray, off_motion: np.ndarray | None = None) -> ModeTable:
        """All modes at points known (n, numbers): values of the known coordinates in the length
        unit and radians, quaternions of unit length; `off_motion` (n,) is how far a pose lies off
        the platform's motion, where some does (length unit).
        """
        off = np.zeros(len(known)) if off_motion is None else off_motion
        feasible = np.flatnonzero(off == 0.0)
        with np.errstate(all="ignore"):
            found = self.plain.find(known[feasible], certify=self.certify)
            places = feasible[found.places]
            if len(places) == len(known):
                return found.table
            others = np.setdiff1d(np.arange(len(known)), places).tolist()
            return joined(
                found.table, places, {i: self._one(known[i], float(off[i])) for i in others}
            )

    def _one(self, known: np.ndarray, off_motion: float) -> ModeTable:
        """One point, alone."""
        if off_motion > 0.0:
            return nothing(self.problem, "off the motion", 0)
        given = Given(self.problem.kind, known, {})
        try:
            found = known_without_search(self.problem, given, self.search)
            return from_modes(found or modes_by_name(self.problem, [given], self.search)[0])
        except TooManyModesError:
            return nothing(self.problem, "too many to list", -1)


@dataclass(frozen=True, eq=False)
class GroupFinder:
    """What is prepared once for all points of a problem that is solved by its structure groups;
    that of the machine of a description, where `told` holds this, whose known values are the
    description's at `places`.
    """

    problem: Problem
    search: Search
    told: Told | None = None
    places: tuple[int, ...] = ()

    @cached_property
    def _solvers(self) -> list[BlockPaths | ClosedBlock]:
        return [solver for group in self._groups for solver in solvers_of(group)]

    @cached_property
    def _groups(self) -> tuple[Problem, ...]:
        """The groups of the problem; none where nothing is searched."""
        problem = self.problem
        if problem.kind != "given" and (problem.is_explicit or free_unknowns(problem)):
            return ()
        return solved_groups(problem, self.search)

    @property
    def engine(self) -> str | None:
        """What tracks the paths or has the formulas."""
        return ", ".join(dict.fromkeys(solver.engine for solver in self._solvers)) or None

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

    def find(self, known: np.ndarray, *, certify: bool) -> Plain:
        """Modes at those of the points known (n, values) that need not be looked at one by one:
        all, but for points that contradict rows without unknowns, and those without a solution
        where the description's digits may be why; of a machine those whose list is complete and
        closes on all rows of the description.
        """
        own = known if self.told is None else known[:, list(self.places)]
        chosen = np.flatnonzero(bool(self._groups) & meet_conditions(self.problem, own))
        own, known = own[chosen], known[chosen]
        each = max(1, ROOTS_AT_ONCE // max(self.most_modes, 1))
        parts = [slice(i, i + each) for i in range(0, max(len(known), 1), each)]
        table = concatenated([self._table(own[part], known[part], certify) for part in parts])
        kept = np.ones(len(known), dtype=bool)
        if determination(self.problem).misfit:
            kept = table.count != 0
        if self.told is not None:
            kept &= np.isin(table.completeness, [COMPLETENESS.index(c) for c in COMPLETE])
            kept &= table.count >= 0
        places = np.flatnonzero(kept)
        if len(places) < len(kept):
            table = at_places(table, places)
        return Plain(table, chosen[places])

    def _table(self, own: np.ndarray, known: np.ndarray, certify: bool) -> ModeTable:
        told = None if self.told is None else replace(self.told, known=known)
        found = modes_by_groups(self.problem, own, self.search, certify=certify, told=told)
        listed = np.bincount(found.owner, minlength=len(own))
        total, account = np.array(found.total, dtype=object), found.account
        many = (account.too_many != FEW) | np.array(listed < total, dtype=bool)
        complex_counts = np.where(
            account.whole & ~many, np.prod(account.complex_count, axis=1), NOT_KNOWN
        )
        said = np.array([COMPLETENESS.index(statement) for statement in STATEMENTS])[
            found.statement
        ]
        return table_of(
            found.asked,
            found.listed.chosen(~many[found.owner]),
            count=np.where(many, -1, listed),
            completeness=np.where(many, COMPLETENESS.index("too many to list"), said),
            unresolved=stored_counts(account.unresolved.sum(axis=1)),
            continuum=np.asarray(account.continuum.any(axis=1)),
            complex_count=stored_counts(complex_counts),
        )


class Plain(NamedTuple):
    """Modes of the points at the `places` (n,), rising."""

    table: ModeTable
    places: np.ndarray


def make_finder(problem: Problem, *, starts: int, seed: int, certify: bool) -> ModeFinder:
    """The finder of one problem; a start that is not kept yet is computed. Raises InputError where
    the problem has no isolated solutions.
    """
    search = Search("continuation", starts, seed, "batched")
    if problem.kind == "given":
        refuse_unless_determined(problem)
    return ModeFinder(
        problem,
        search,
        certify,
        _of_machine(problem, search) or _own(problem, search),
    )


def _of_machine(problem: Problem, search: Search) -> GroupFinder | None:
    """The finder of the machine that a description means, for values of joints; None where that is
    the description.
    """
    names = tuple(c.name for c in problem.known_coordinates)
    if any(c.width > 1 for c in problem.known_coordinates) or problem.kind == "inverse":
        return None
    # values that tell which of them the machine takes
    given = Given(problem.kind, np.arange(len(names)), {}, names if problem.kind == "given" else ())
    low = machine_of(problem.mechanism, given)
    if low is None or may_contradict(low, given):
        return None
    there = given_of_machine(low, given)
    of_machine = problem_of(low.machine, there)
    if of_machine.is_explicit:
        return None
    told = Told(low, problem, np.zeros((0, len(names))))
    return replace(_own(of_machine, search), told=told, places=tuple(map(int, there.values)))


def _own(problem: Problem, search: Search) -> GroupFinder:
    """The finder of a description itself."""
    mechanism = problem.mechanism
    if (
        problem.kind != "given"
        and mechanism.serial
        and problem.system.freedom > problem.generic_rank
    ):
        raise InputError(
            f"{mechanism.name}: its {len(mechanism.actuated)} joints leave solutions of a pose "
            f"free, so that none is isolated; "
            "sweep over its inputs"
        )
    return GroupFinder(problem, search)
