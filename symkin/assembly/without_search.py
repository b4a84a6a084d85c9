"""What is known of an input's modes without a search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.as_written import Told
from symkin.assembly.group_roots import GroupRoots
from symkin.assembly.mode_proofs import PartProofs, proofs_of_group
from symkin.assembly.modes_result import Modes
from symkin.assembly.search import Search
from symkin.errors import InputError
from symkin.homotopy.systems import unsuitable
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.groups import independent_problems
from symkin.position.problem import Problem
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.position.starts import begun


def free_unknowns(problem: Problem) -> str | None:
    """What to say where the rows leave unknowns free, so that no solution is isolated."""
    free = problem.system.freedom - problem.generic_rank
    if free <= 0:
        return None
    return (
        f"{problem.mechanism.name}: the {problem.name} problem leaves {free} of "
        f"{problem.system.freedom} unknowns free, so that "
        "its solutions are no isolated modes; use solve with a start for one of them"
    )


def _certified(problem: Problem, one: SolutionList, values: np.ndarray) -> SolutionList:
    """The pose that a formula gives, certified in balls as any other solution: at values (1,
    variables) of the problem.
    """
    if unsuitable(problem) is not None:
        return one
    known, owner = values[:, problem.known_places], np.zeros(1, dtype=int)
    proofs = PartProofs.of_nothing(1)
    for part in independent_problems(problem):
        roots = GroupRoots.of_all(values[:, part.unknown_places], owner, np.ones(1))
        proofs = proofs.beside(proofs_of_group(part, roots, known, np.zeros(known.shape))[0])
    return one.chosen(slice(None), **proofs.told())


def meet_conditions(problem: Problem, known: np.ndarray) -> np.ndarray:
    """Which given values (n, known) meet the rows without unknowns."""
    bound = CLOSURE_TOLERANCE * problem.closure.characteristic_length
    return _errors_of_given(problem, known) <= bound


def _errors_of_given(problem: Problem, known: np.ndarray) -> np.ndarray:
    """The errors (n,) of rows without unknowns at given values (n, known). Rows of a problem whose
    coordinates are told by name are left to its groups.
    """
    if problem.by_name or problem.conditions.errors.is_zero():
        return np.zeros(len(known))
    return problem.conditions.residuals(np.zeros((len(known), 0)), known)


def known_without_search(
    problem: Problem, given: Given, search: Search, told: Told | None = None, number: int = 0
) -> Modes | None:
    """What needs no search: unknowns that nothing determines, a pose off the motion, the direct
    problem of a serial arm, given values that contradict rows without unknowns. The modes of a
    machine are `told` in the coordinates of a description, whose input has this `number`.
    """
    free = None if problem.by_name else free_unknowns(problem)
    if free is not None and problem.mechanism.serial:
        raise InputError(free)
    if free is not None:
        search.refuse_unless_multistart(free)
        empty = _nothing(problem, given, search, note=f"positive-dimensional set: {free}")
        return replace(empty, positive_dimensional=True)
    if given.off_motion > 0.0:
        return _nothing(problem, given, search, given.off_motion)
    if problem.by_name:
        return None
    if problem.is_explicit:
        return _forward(problem, given, search, told, number)
    known = given.values[None]
    if meet_conditions(problem, known)[0]:
        return None
    return _nothing(problem, given, search, float(_errors_of_given(problem, known)[0]))


def _forward(
    problem: Problem, given: Given, search: Search, told: Told | None, number: int
) -> Modes:
    """The one mode of a serial arm's joints."""
    search.refuse_unless_multistart(
        "the direct problem of a serial arm is a function of its joints, and nothing is searched"
    )
    values = problem.join_values(begun(problem.mechanism, given, None)[1], given.values)[None]
    if told is None:
        one = checked_solutions(problem, values, given.notes)
    else:
        one = told.listed(problem.closure, values, np.array([number]))
    if not one.closed[0]:
        return _nothing(problem, given, search, float(one.residual[0]))
    note = "forward kinematics of a serial arm is a function of its joints: one pose"
    return Modes(
        problem=problem if told is None else told.problem,
        given=given.echo,
        modes=_certified(problem, one, values),
        completeness="proved",
        method="forward",
        seed=None,
        elapsed_s=0.0,
        complex_count=1,
        unresolved_paths=0,
        notes=(*given.notes, note),
    )


def _nothing(
    problem: Problem, given: Given, search: Search, smallest: float | None = None, note: str = ""
) -> Modes:
    """No modes, and why."""
    return Modes(
        problem=problem,
        given=given.echo,
        modes=SolutionList.of_none(problem.closure),
        completeness="sampled",
        method=search.method,
        seed=search.seed,
        elapsed_s=0.0,
        smallest_residual=smallest,
        notes=(*given.notes, note) if note else given.notes,
    )
