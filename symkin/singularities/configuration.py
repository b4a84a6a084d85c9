"""Reach one configuration from joint values or a pose, singular ones included."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import ROUNDED_STEP
from symkin.position.determination import set_notes
from symkin.position.given import Given, read_given
from symkin.position.levenberg import Levenberg
from symkin.position.moved_starts import StartRank, nearly_closes
from symkin.position.options import Begun
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from symkin.position.solve import solve, solve_problem
from symkin.position.solve_result import SolveError, SolveResult
from symkin.position.starts import begun
from symkin.position.transfer import variables_elsewhere
from symkin.verb import verb

_NEARLY_SINGULAR = 1e4
"""Condition above which a configuration of values by name is iterated to the last digit."""
_FIRST_STEP = 1e-3
"""Of the size: a longer step leads elsewhere."""
_MOST_HALVINGS = 40
"""Steps from there to 1e-12; those at a double root end at 1e-8."""


@verb(Begun)
def configuration(mechanism: Mechanism, **options: Unpack[Begun]) -> Solution:
    """What `solve` reaches; where Newton's steps fail, as at a singular configuration,
    Levenberg-Marquardt from the same start, and that first where the start is singular and nearly
    closes the loops: it is meant as it is. Raises SolveError where no configuration is reached,
    InputError for values that do not fit.
    """
    read = read_given(mechanism, options["joints"], options["pose"], options["given"])
    problem = build_problem(mechanism, read.names)
    if problem.by_name:
        return _refined(_noted(solve(mechanism, **options, check=False)), read)
    begin, known = begun(mechanism, read, options["start"])[1], read.values
    damped = read.off_motion == 0.0 and problem.system.width > 0
    is_meant = (
        damped
        and nearly_closes(problem, begin, known)
        and StartRank.at(problem, begin, known).is_nearly_singular
    )
    found = solve_problem(problem, read, Levenberg(), begin).solution if is_meant else None
    if found is None:
        result = solve(mechanism, **options, check=False)
        if damped and result.solution is None:
            found = solve_problem(problem, read, Levenberg(), begin).solution
        if found is None:
            return _noted(result)
    return replace(found, notes=(*found.notes, *set_notes(problem, found.condition)))


def _noted(result: SolveResult) -> Solution:
    """The solution of a result with the result's notes."""
    if result.solution is None:
        raise SolveError(result.message, result)
    noted = (n for n in result.notes if n not in result.solution.notes)
    return replace(result.solution, notes=(*result.solution.notes, *noted))


def _refined(solution: Solution, given: Given) -> Solution:
    """A nearly singular solution of values by name, to as many digits as it has: steps of a solver
    end where rows vanish, which they do to the square of what is left.
    """
    if solution.condition < _NEARLY_SINGULAR:
        return solution
    problem = build_problem(solution.mechanism, given.names)
    values = variables_elsewhere(problem.closure, solution)
    known, z = (
        problem.select_values(values, c)
        for c in (problem.known_coordinates, problem.system.unknowns)
    )
    z = _halved(problem, z, known)
    found = make_solution(problem, problem.join_values(z, known), notes=solution.notes)
    return found if found.residual <= solution.residual else solution


def _halved(problem: Problem, z: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Newton's steps as long as they shrink: where two solutions meet each halves what is left,
    down to the root of rounding.
    """
    last = _FIRST_STEP * problem.closure.characteristic_length
    for _ in range(_MOST_HALVINGS):
        rows, jacobian = problem.system.linearise_one(z, known)
        step = np.linalg.lstsq(jacobian, -rows, rcond=ROUNDED_STEP)[0]
        size = float(np.linalg.norm(step))
        if not size < last:
            break
        z, last = problem.system.move(z[None], step[None])[0], 0.9 * size
    return z
