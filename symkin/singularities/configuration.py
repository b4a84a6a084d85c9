"""One configuration from joint values or a pose, singular ones too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symkin.errors import SolveError
from symkin.model.mechanism import Mechanism
from symkin.position.given import given_from
from symkin.position.levenberg import levenberg_marquardt
from symkin.position.problem import build_problem
from symkin.position.solution import ACCEPTED, Solution, make_solution
from symkin.position.solve import solve
from symkin.position.starts import start_values
from symkin.spatial.pose import Pose


def configuration(
    mechanism: Mechanism,
    *,
    joints: Sequence[float] | None = None,
    pose: Sequence[float] | Pose | None = None,
    start: Sequence[float] | Pose | None = None,
) -> Solution:
    """What `solve` reaches; where Newton's steps fail, as at a singular configuration, Levenberg-Marquardt from the same start.
    Raises SolveError where no configuration is reached, InputError for values that do not fit."""
    result = solve(mechanism, joints=joints, pose=pose, start=start, check=False)
    if result.solution is not None:
        noted = (n for n in result.notes if n not in result.solution.notes)
        return replace(result.solution, notes=(*result.solution.notes, *noted))
    given = given_from(mechanism, joints, pose)
    problem = build_problem(mechanism, given.kind)
    begin = start_values(problem, given, start)
    if given.off_motion == 0.0 and problem.system.width:
        batch = levenberg_marquardt(problem.system, begin[None], given.values, tolerance=1e-13, max_iterations=400, patience=60)
        solution = make_solution(problem, problem.assemble(problem.system.unit(batch.points[0]), given.values))
        if solution.residual <= ACCEPTED * problem.closure.size:
            return solution
    raise SolveError(result.message, result)
