"""Reach one configuration from joint values or a pose, singular ones included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.model.mechanism import Mechanism, require_limbs
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given, Joints, given_from
from symkin.position.moved_starts import StartRank, nearly_closes
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from symkin.position.solve import solve
from symkin.position.solve_result import SolveError
from symkin.position.starts import start_values
from symkin.spatial.pose import Pose


def configuration(
    mechanism: Mechanism,
    *,
    joints: Joints | None = None,
    pose: Sequence[float] | Pose | None = None,
    start: Joints | Pose | None = None,
) -> Solution:
    """What `solve` reaches; where Newton's steps fail, as at a singular configuration, Levenberg-Marquardt from the same start,
    and that first where the start is singular and nearly closes the loops: it is meant as it is.
    Raises SolveError where no configuration is reached, InputError for values that do not fit."""
    require_limbs(mechanism, "singularities", "the condition of a solution of solve or modes tells how near it is to one")
    given = given_from(mechanism, joints, pose)
    problem = build_problem(mechanism, given.kind)
    begin = start_values(problem, given, start)
    known = given.values
    if (
        given.off_motion == 0.0
        and nearly_closes(problem, begin, known)
        and StartRank.at(problem, begin, known).is_nearly_singular
    ):
        found = _by_least_squares(problem, given, begin)
        if found is not None:
            return found
    result = solve(mechanism, joints=joints, pose=pose, start=start, check=False)
    if result.solution is not None:
        noted = (n for n in result.notes if n not in result.solution.notes)
        return replace(result.solution, notes=(*result.solution.notes, *noted))
    found = _by_least_squares(problem, given, begin) if given.off_motion == 0.0 else None
    if found is None:
        raise SolveError(result.message, result)
    return found


def _by_least_squares(problem: Problem, given: Given, begin: np.ndarray) -> Solution | None:
    """The configuration that Levenberg-Marquardt reaches from a start."""
    system = problem.system
    if not system.width:
        return None
    batch = levenberg_marquardt(system, begin[None], given.values, tolerance=1e-13, max_iterations=400, patience=60)
    solution = make_solution(problem, problem.join_values(system.unit(batch.points[0]), given.values), notes=given.notes)
    return solution if solution.residual <= CLOSURE_TOLERANCE * problem.closure.characteristic_length else None
