"""What is known of an input's modes without a search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.modes_result import Modes
from symkin.assembly.prover import prover_of
from symkin.assembly.search import Search
from symkin.errors import InputError
from symkin.homotopy.systems import system_of, unsuitable
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from symkin.position.starts import start_values


def free_unknowns(problem: Problem) -> str | None:
    """What to say where the rows leave unknowns free, so that no solution is isolated."""
    free = problem.system.freedom - problem.generic_rank
    if free <= 0:
        return None
    return (
        f"{problem.mechanism.name}: the {problem.kind} problem leaves {free} of "
        f"{problem.system.freedom} unknowns free, so that "
        "its solutions are no isolated modes; use solve with a start for one of them"
    )


def _proved(problem: Problem, solution: Solution) -> Solution:
    """The pose that a formula gives, certified in balls as any other solution."""
    if unsuitable(problem) is not None:
        return solution
    values, owner = solution.variables[None], np.zeros(1, dtype=int)
    radii = list[float]()
    for block in problem.blocks:
        prover = prover_of(problem, system_of(problem, block), block)
        knowns = prover.knowns(values[:, problem.known_places])
        found = prover.proofs(values[:, problem.places(block.unknowns)], owner, knowns)
        if not found.certified[0]:
            return replace(solution, certified=False, radius=None)
        radii.append(float(found.radius[0]))
    return replace(solution, certified=True, radius=max(radii, default=0.0))


def known_without_search(problem: Problem, given: Given, search: Search) -> Modes | None:
    """What needs no search: unknowns that nothing determines, a pose off the motion, the direct
    problem of a serial arm, given values that contradict rows without unknowns.
    """
    if problem.by_name:
        return None
    free = free_unknowns(problem)
    if free is not None and problem.mechanism.serial:
        raise InputError(free)
    if free is not None:
        search.refuse_unless_multistart(free)
        empty = _nothing(problem, given, search, note=f"positive-dimensional set: {free}")
        return replace(empty, positive_dimensional=True)
    if given.off_motion > 0.0:
        return _nothing(problem, given, search, given.off_motion)
    if problem.is_explicit:
        search.refuse_unless_multistart(
            "the direct problem of a serial arm is a function of its joints, and nothing is "
            "searched"
        )
        values = problem.join_values(start_values(problem, given, None), given.values)
        note = "forward kinematics of a serial arm is a function of its joints: one pose"
        solution = make_solution(problem, values)
        if not solution.residual <= CLOSURE_TOLERANCE * problem.closure.characteristic_length:
            return _nothing(problem, given, search, solution.residual)
        return Modes(
            problem=problem,
            given=given.echo,
            modes=(_proved(problem, solution),),
            completeness="proved",
            method="forward",
            seed=None,
            elapsed_s=0.0,
            complex_count=1,
            unresolved_paths=0,
            notes=(*given.notes, note),
        )
    conditions = problem.conditions
    off = conditions.residual(np.zeros(0), given.values) if conditions.errors.shape[0] else 0.0
    if off > CLOSURE_TOLERANCE * problem.closure.characteristic_length:
        return _nothing(problem, given, search, off)
    if not problem.blocks:
        search.refuse_unless_multistart(
            f"the {problem.kind} problem of {problem.mechanism.name} has no unknowns, and nothing "
            f"is searched"
        )
        solution = make_solution(
            problem, problem.join_values(np.zeros(0), given.values), notes=given.notes
        )
        return Modes(
            problem=problem,
            given=given.echo,
            modes=(solution,),
            completeness="proved",
            method=search.method,
            seed=search.seed,
            elapsed_s=0.0,
            complex_count=1,
            unresolved_paths=0,
            notes=given.notes,
        )
    return None


def _nothing(
    problem: Problem, given: Given, search: Search, smallest: float | None = None, note: str = ""
) -> Modes:
    """No modes, and why."""
    return Modes(
        problem=problem,
        given=given.echo,
        modes=(),
        completeness="sampled",
        method=search.method,
        seed=search.seed,
        elapsed_s=0.0,
        smallest_residual=smallest,
        notes=(*given.notes, note) if note else given.notes,
    )
