"""How a problem is solved, whatever values are given: decided once, with its structure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.assembly.account import Part
from symkin.assembly.closed_roots import ClosedBlock
from symkin.assembly.families import Member, members_of
from symkin.assembly.group_solvers import group_solver, solved_at_once
from symkin.assembly.rod_lengths import rod_lengths
from symkin.assembly.search import Search
from symkin.computed_once import cached_property, lru_cache
from symkin.errors import InputError
from symkin.homotopy.systems import unsuitable
from symkin.homotopy.values import coordinate_scale
from symkin.numeric.rank import Rank
from symkin.position.determination import refuse_unless_determined, what_is_free
from symkin.position.groups import (
    independent_parts,
    is_linear,
    is_tied,
    joined_groups,
    structure_groups,
)
from symkin.position.multistart import batched_rows
from symkin.position.problem import Problem

_ROWS, _STARTS, _AWAY = 3, 64, 0.3
"""Known values at which regular solutions are looked for, random starts at each, and how far the
values are from the reference: in radians, and in sizes.
"""


@dataclass(frozen=True, eq=False)
class Plan:
    """The structure groups of a problem in the order of their solution. If it `joins`, those that
    formulas solve together are one: those of a limb, and rods whose ends are known.
    """

    problem: Problem
    joins: bool

    @cached_property
    def groups(self) -> tuple[Problem, ...]:
        groups = structure_groups(self.problem)
        return _joined(self.problem, groups) if self.joins else groups

    @cached_property
    def parts(self) -> list[list[int]]:
        """Numbers of groups that read each other's values, part by part."""
        return independent_parts(self.groups)

    @cached_property
    def is_one_group(self) -> bool:
        """Whether the problem is a group itself: all its rows are those of one."""
        return self.groups == (self.problem,)

    @cached_property
    def members(self) -> dict[Problem, Member]:
        """Groups that are solved as members of a family."""
        return members_of(self.groups)

    @cached_property
    def can_be_proved(self) -> bool:
        """Whether proofs can be tried: the rows of all groups are algebraic."""
        return all(is_linear(group) or unsuitable(group) is None for group in self.groups)

    @cached_property
    def dependent_parts(self) -> tuple[Part, ...]:
        """The parts that are several groups."""
        parts = [numbers for numbers in self.parts if len(numbers) > 1]
        own = [tuple(self.groups[k] for k in numbers) for numbers in parts]
        ties = [_may_refuse(some) and is_tied(joined_groups(self.problem, some)) for some in own]
        return tuple(zip(parts, ties, strict=True))

    @cached_property
    def free(self) -> str | None:
        """What to say where the rows leave unknowns free, so that no solution is isolated. Where
        others than those about the reference are, as of a kite that lies folded on itself, all are
        searched.
        """
        return None if self._elsewhere else what_is_free(self.problem)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What is said at all given values: of an assembly that leaves unknowns free where others,
        which are searched, do not.
        """
        free = what_is_free(self.problem) if self._elsewhere else None
        return (
            ()
            if free is None
            else (
                f"{free} about the reference: solutions of that motion, where there are any at "
                f"these values, are not isolated; those listed are of others",
            )
        )

    @cached_property
    def _elsewhere(self) -> bool:
        """Whether what is free about the reference is not free elsewhere."""
        return what_is_free(self.problem) is not None and _has_regular_solutions(self.problem)

    @cached_property
    def has_conditions(self) -> bool:
        """Whether rows without unknowns must hold of given values. Those of coordinates that are
        told by name are left to the groups.
        """
        problem = self.problem
        return not (problem.by_name or problem.conditions.errors.is_zero())

    @cached_property
    def is_searched(self) -> bool:
        """Whether solutions are searched at all given values, but those off a motion."""
        return not (self.free or self.problem.is_explicit or self.has_conditions)


def refuse_unless_isolated(problem: Problem) -> None:
    """Raise InputError where coordinates that are given by name leave some motion free or say the
    same thing twice: about the reference and, as far as random starts meet, elsewhere.
    """
    try:
        refuse_unless_determined(problem)
    except InputError:
        if problem.generic_rank < problem.system.freedom or not _has_regular_solutions(problem):
            raise


@lru_cache(maxsize=128)
def _has_regular_solutions(problem: Problem) -> bool:
    """Whether random starts meet a regular solution at random known values about the reference."""
    rng, system, coordinates = np.random.default_rng(0), problem.system, problem.known_coordinates
    away = rng.uniform(-_AWAY, _AWAY, (_ROWS, len(coordinate_scale(problem, coordinates))))
    given = system.exchanged(coordinates)
    known = given.move(
        problem.reference_known + coordinate_scale(problem, coordinates) * away,
        np.zeros((_ROWS, given.freedom)),
    )
    samples = batched_rows(problem, known, _STARTS, [rng] * _ROWS)
    return any(
        Rank.of(jacobian).value == system.freedom
        for sample, row in zip(samples, known, strict=True)
        for jacobian in system.linearise(sample.points, np.tile(row, (len(sample.points), 1)))[1]
    )


def plan_of(problem: Problem, search: Search) -> Plan:
    """The plan by which a search solves a problem."""
    formulas = search.method == "continuation" and search.formulas
    return _plan(problem, formulas and not problem.by_name)


@lru_cache(maxsize=128)
def _plan(problem: Problem, joins: bool) -> Plan:
    return Plan(problem, joins)


def _joined(problem: Problem, groups: tuple[Problem, ...]) -> tuple[Problem, ...]:
    found = list[Problem]()
    for numbers in independent_parts(groups):
        own = tuple(groups[k] for k in numbers)
        is_one = len(own) > 1 and _is_solved_as_one(joined_groups(problem, own), own)
        found += [joined_groups(problem, own)] if is_one else own
    given = {*problem.known_coordinates}
    rods = tuple(g for g in found if given >= {*g.known_coordinates} and rod_lengths(g.system))
    if len(rods) < 2:
        return tuple(found)
    return (joined_groups(problem, rods), *(group for group in found if group not in rods))


def _may_refuse(groups: tuple[Problem, ...]) -> bool:
    """Whether further rows of later groups may refuse solutions of earlier ones."""
    return any(g.system.rows.shape[0] > g.system.freedom for g in groups[1:])


def _is_solved_as_one(joined: Problem, own: tuple[Problem, ...]) -> bool:
    """Whether formulas solve groups together, or further rows of a later one refuse solutions of
    an earlier one, so that products of their counts are too large.
    """
    if solved_at_once(joined):
        return False
    solver = group_solver(joined)
    return isinstance(solver, ClosedBlock) or (_may_refuse(own) and solver is not None)
