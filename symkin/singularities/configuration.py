"""Reach one configuration from joint values or a pose, singular ones included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.tolerances import CLOSURE_TOLERANCE, ROUNDED_STEP
from symkin.position.given import Given, Joints, Values, problem_of, read_given
from symkin.position.moved_starts import StartRank, nearly_closes
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from symkin.position.solve import solve
from symkin.position.solve_result import SolveError, SolveResult
from symkin.position.starts import start_values
from symkin.position.transfer import variables_elsewhere
from symkin.spatial.pose import Pose

_NEARLY_SINGULAR = 1e4
"""Condition above which a configuration of values by name is iterated to the last digit."""
_FIRST_STEP = 1e-3
"""Of the size: a longer step leads elsewhere."""
_MOST_HALVINGS = 40
"""Steps from there to 1e-12; those at a double root end at 1e-8."""


def configuration(
    mechanism: Mechanism,
    *,
    joints: Joints | None = None,
    pose: Sequence[float] | Pose | None = None,
    given: Values | None = None,
    start: Joints | Values | Pose | None = None,
) -> Solution:
    """What `solve` reaches; where Newton's steps fail, as at a singular configuration,
    Levenberg-Marquardt from the same start, and that first where the start is singular and nearly
    closes the loops: it is meant as it is. Raises SolveError where no configuration is reached,
    InputError for values that do not fit.
    """
    read = read_given(mechanism, joints, pose, given)
    problem = problem_of(mechanism, read)
    begin = None if problem.by_name else start_values(problem, read, start)  # type: ignore[arg-type]
    meant = None if begin is None else _meant(problem, read, begin)
    if meant is not None:
        return meant
    result = solve(mechanism, joints=joints, pose=pose, given=given, start=start, check=False)
    if begin is None:
        return _refined(_noted(result), read)
    if result.solution is not None:
        return _noted(result)
    found = _by_least_squares(problem, read, begin) if read.off_motion == 0.0 else None
    if found is None:
        raise SolveError(result.message, result)
    return found


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
    problem = build_problem(solution.mechanism, "given", given.names)
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


def _meant(problem: Problem, given: Given, begin: np.ndarray) -> Solution | None:
    """The configuration beside a nearly singular start that nearly closes the loops."""
    known = given.values
    if (
        given.off_motion == 0.0
        and nearly_closes(problem, begin, known)
        and StartRank.at(problem, begin, known).is_nearly_singular
    ):
        return _by_least_squares(problem, given, begin)
    return None


def _by_least_squares(problem: Problem, given: Given, begin: np.ndarray) -> Solution | None:
    """The configuration that Levenberg-Marquardt reaches from a start."""
    system = problem.system
    if not system.width:
        return None
    batch = levenberg_marquardt(
        system, begin[None], given.values, tolerance=1e-13, max_iterations=400, patience=60
    )
    solution = make_solution(
        problem, problem.join_values(system.unit(batch.points[0]), given.values), notes=given.notes
    )
    return (
        solution
        if solution.residual <= CLOSURE_TOLERANCE * problem.closure.characteristic_length
        else None
    )
