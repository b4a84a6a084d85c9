"""What is known of an input's modes without a search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.as_written import Told
from symkin.assembly.group_roots import GroupRoots
from symkin.assembly.mode_proofs import proofs_of_group
from symkin.assembly.modes_result import Modes
from symkin.assembly.prover import PartProofs
from symkin.assembly.search import Search
from symkin.errors import InputError
from symkin.homotopy.systems import unsuitable
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.groups import structure_groups
from symkin.position.problem import Problem
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.position.starts import begun


def free_unknowns(problem: Problem) -> str | None:
    """What to say where the rows leave unknowns free, so that no solution is isolated; coordinates
    by name are refused where they do not determine the others.
    """
    free = 0 if problem.by_name else problem.system.freedom - problem.generic_rank
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
    owner = np.zeros(1, dtype=int)
    proofs = PartProofs.of_nothing(1)
    for part in structure_groups(problem):
        roots = GroupRoots.of_all(values[:, part.unknown_places], owner, np.ones(1))
        known = values[:, part.known_places]
        proofs = proofs.beside(proofs_of_group(part, roots, known, np.zeros(known.shape))[0])
    return one.chosen(slice(None), **proofs.told())


def meet_conditions(problem: Problem, known: np.ndarray) -> np.ndarray:
    """Which given values (n, known) meet the rows without unknowns."""
    return _errors_of_given(problem, known) == 0.0


def _errors_of_given(problem: Problem, known: np.ndarray) -> np.ndarray:
    """The errors (n,) of rows without unknowns at given values (n, known), 0 where these are
    rounding. Rows of a problem whose coordinates are told by name are left to its groups.
    """
    if problem.by_name or problem.conditions.errors.is_zero():
        return np.zeros(len(known))
    errors = problem.conditions.residuals(np.zeros((len(known), 0)), known)
    within = errors <= CLOSURE_TOLERANCE * problem.closure.characteristic_length
    return np.where(within, 0.0, errors)


def known_without_search(
    problem: Problem, givens: Sequence[Given], search: Search, told: Told | None = None
) -> list[Modes | None]:
    """What needs no search, of each input: unknowns that nothing determines, a pose off the motion,
    the direct problem of a serial arm, given values that contradict rows without unknowns. The
    modes of a machine are `told` in the coordinates of a description.
    """
    free = free_unknowns(problem)
    if free is not None and problem.mechanism.serial:
        raise InputError(free)
    if free is not None:
        search.refuse_unless_multistart(free)
        empty = [
            nothing(problem, given, search, note=f"positive-dimensional set: {free}")
            for given in givens
        ]
        return [replace(one, positive_dimensional=True) for one in empty]
    off, explicit = [given.off_motion for given in givens], problem.is_explicit
    if not explicit:
        errors = _errors_of_given(problem, np.array([given.values for given in givens]))
        off = [away or error for away, error in zip(off, errors.tolist(), strict=True)]
    return [
        nothing(problem, given, search, away)
        if away
        else _forward(problem, given, search, told, i)
        if explicit
        else None
        for i, (given, away) in enumerate(zip(givens, off, strict=True))
    ]


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
        return nothing(problem, given, search, float(one.residual[0]))
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


def nothing(
    problem: Problem, given: Given, search: Search, smallest: float | None = None, note: str = ""
) -> Modes:
    """No modes, and why."""
    return Modes(
        problem=problem,
        given=given.echo,
        modes=checked_solutions(problem, np.zeros((0, problem.closure.reference.size))),
        completeness="sampled",
        method=search.method,
        seed=search.seed,
        elapsed_s=0.0,
        smallest_residual=smallest,
        notes=(*given.notes, note) if note else given.notes,
    )
