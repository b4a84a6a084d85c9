"""Reach one configuration from joint values or a pose, singular ones included."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Unpack

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import ROUNDED_STEP
from symkin.position.given import given_from
from symkin.position.given_by_name import Values, plain_case, pose_names
from symkin.position.levenberg import Levenberg
from symkin.position.moved_starts import StartRank, nearly_closes
from symkin.position.options import Begun
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from symkin.position.solve import solve, solve_problem
from symkin.position.solve_result import SolveError, SolveResult
from symkin.position.starts import start_values
from symkin.position.transfer import variables_elsewhere
from symkin.verb_options import takes

_NEARLY_SINGULAR = 1e4
"""Condition above which a configuration of values by name is iterated to the last digit."""
_FIRST_STEP = 1e-3
"""Of the size: a longer step leads elsewhere."""
_MOST_HALVINGS = 40
"""Steps from there to 1e-12; those at a double root end at 1e-8."""


@takes(Begun)
def configuration(mechanism: Mechanism, **options: Unpack[Begun]) -> Solution:
    """What `solve` reaches; where Newton's steps fail, as at a singular configuration,
    Levenberg-Marquardt from the same start, and that first where the start is singular and nearly
    closes the loops: it is meant as it is. Raises SolveError where no configuration is reached,
    InputError for values that do not fit.
    """
    plain = plain_case(mechanism, options["joints"], options["pose"], options["given"])
    if plain is None:
        return _refined(_noted(solve(mechanism, **options, check=False)), options["given"])
    return _of_limbs(mechanism, *plain, options["start"])


def _noted(result: SolveResult) -> Solution:
    """The solution of a result with the result's notes."""
    if result.solution is None:
        raise SolveError(result.message, result)
    noted = (n for n in result.notes if n not in result.solution.notes)
    return replace(result.solution, notes=(*result.solution.notes, *noted))


def _refined(solution: Solution, given: Values | None) -> Solution:
    """A nearly singular solution of values by name, to as many digits as it has: steps of a solver
    end where rows vanish, which they do to the square of what is left.
    """
    if solution.condition < _NEARLY_SINGULAR:
        return solution
    mechanism = solution.mechanism
    names = (
        [c.name for c in mechanism.actuated]
        if given is None
        else [name for name in given if name != "pose"]
    )
    problem = build_problem(
        mechanism, "given", (*names, *(pose_names(mechanism) if given and "pose" in given else ()))
    )
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


def _of_limbs(mechanism: Mechanism, joints: Any, pose: Any, start: Any) -> Solution:
    """The configuration of all actuated joints or the pose of limbs, by damped steps where the
    start is meant as it is, or where Newton's fail.
    """
    given = given_from(mechanism, joints, pose)
    problem = build_problem(mechanism, given.kind)
    begin, known = start_values(problem, given, start), given.values
    damped = given.off_motion == 0.0 and problem.system.width > 0
    is_meant = (
        damped
        and nearly_closes(problem, begin, known)
        and StartRank.at(problem, begin, known).is_nearly_singular
    )
    found = solve_problem(problem, given, Levenberg(), begin).solution if is_meant else None
    if found is not None:
        return found
    result = solve(mechanism, joints=joints, pose=pose, start=start, check=False)
    if damped and result.solution is None:
        found = solve_problem(problem, given, Levenberg(), begin).solution
    return _noted(result) if found is None else found
