"""One solution near a start: the driver that owns convergence, verification and the status."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from symkin.errors import InputError, SolveError
from symkin.model.mechanism import Mechanism
from symkin.position.given import Given, given_from, joint_values, pose_coordinates, pose_from
from symkin.position.least_squares import LeastSquares
from symkin.position.levenberg import levenberg_marquardt
from symkin.position.newton import Newton
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Iterate, Solution, SolveResult, make_solution, pose_of
from symkin.position.system import System
from symkin.spatial.pose import Pose

Solver = Newton | LeastSquares
SOLVERS: dict[str, Solver] = {
    "newton": Newton(),
    "fast_newton": Newton(method="fast_newton"),
    "ipopt": LeastSquares(),
}
ACCEPTED = 1e-9
"""A configuration is a solution when no closure error exceeds this times the size."""


def solve(
    mechanism: Mechanism,
    *,
    joints: Sequence[float] | None = None,
    pose: Sequence[float] | Pose | None = None,
    start: Sequence[float] | Pose | None = None,
    solver: str | Solver = "newton",
    check: bool = True,
) -> SolveResult:
    """One solution of the direct (`joints`) or inverse (`pose`) problem, near `start`.

    Values are in the mechanism's units: actuated joints in file order; a pose is x, y, z, qw, qx, qy, qz. `start` is a
    pose for the direct problem and all actuated joints for the inverse one; default: the example's, else the
    reference. `solver` is "newton", "fast_newton", "ipopt" or a Newton or LeastSquares value.
    Raises SolveError when no solution is reached, unless `check` is False; InputError for values that do not fit.
    """
    given = given_from(mechanism, joints, pose)
    problem = build_problem(mechanism, given.kind)
    chosen = SOLVERS.get(solver) if isinstance(solver, str) else solver
    if chosen is None:
        raise InputError(f"solver = {solver!r} is unknown; allowed: {', '.join(SOLVERS)}")
    result = solve_problem(problem, given, chosen, start_values(problem, given, start))
    if check and result.solution is None:
        raise SolveError(result.message, result)
    return result


def solve_problem(problem: Problem, given: Given, solver: Solver, start: np.ndarray) -> SolveResult:
    """Iterate from a start (unknowns of the problem's system), verify on all rows, name the outcome."""
    begin = time.perf_counter()
    name = solver.name
    if given.off_motion > 0.0:
        path, status, left = [start], "infeasible", given.off_motion
    elif problem.is_explicit:
        path, status, left = [start], "ok", 0.0
        name = "forward"
    else:
        path = _iterates(problem, solver, start, given.values)
        status, left = _judge(problem, path, given.values)
    solution, left = _verified(problem, path[-1], given, status, left)
    status = "infeasible" if status == "ok" and solution is None else status
    return SolveResult(
        problem,
        given.echo,
        status,  # type: ignore[arg-type]
        solution,
        len(path) - 1,
        tuple(_history(problem, path, given.values)),
        None if solution is not None else left,
        name,
        time.perf_counter() - begin,
        given.notes,
    )


def start_values(problem: Problem, given: Given, start: Sequence[float] | Pose | None) -> np.ndarray:
    """Unknowns at the start. For a direct problem passive joints are fitted to the start's pose, each limb on the
    branch of the reference configuration."""
    mechanism, closure = problem.mechanism, problem.closure
    if start is None and mechanism.example is not None:
        start = _example_start(mechanism, given)
    values = closure.reference.copy()
    forward = problem.forward(given.values)
    if forward is not None:
        return np.concatenate([problem.take(values, closure.role("passive")), forward])
    if given.kind == "inverse":
        if start is not None:
            numbers = joint_values(mechanism, start, "start")  # type: ignore[arg-type]
            for c, number in zip(mechanism.actuated, numbers, strict=True):
                values[closure.slices[c.name]] = number
        return problem.take(values, problem.system.unknowns)
    if start is not None:
        coordinates, off = pose_coordinates(mechanism, pose_from(start, "start"))
        if off > 1e-6 * mechanism.size:
            raise InputError(f"start: the pose lies off the platform's {mechanism.motion} motion by {off:.3g} {mechanism.length_unit}")
        place = 0
        for c in closure.role("pose"):
            values[closure.slices[c.name]] = coordinates[place : place + c.width]
            place += c.width
        values = _fit_passive(mechanism, values, coordinates)
    return problem.take(values, problem.system.unknowns)


def _iterates(problem: Problem, solver: Solver, start: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
    if problem.system.width == 0:
        return [start]
    return solver.iterate(problem, start, known)


def _fit_passive(mechanism: Mechanism, values: np.ndarray, pose: np.ndarray) -> np.ndarray:
    inverse = build_problem(mechanism, "inverse")
    if not inverse.closure.role("passive"):
        return values
    begin = inverse.take(values, inverse.system.unknowns)
    batch = levenberg_marquardt(inverse.system, begin[None], pose)
    fitted = inverse.assemble(batch.points[0], pose)
    for c in inverse.closure.role("passive"):
        values[inverse.closure.slices[c.name]] = fitted[inverse.closure.slices[c.name]]
    return values


def _example_start(mechanism: Mechanism, given: Given) -> Sequence[float] | None:
    """The example's start, where it is of the kind that the problem takes."""
    example = mechanism.example
    start = example.start if example is not None else None
    example_kind = "inverse" if example is not None and example.pose is not None else "direct"
    return start if example_kind == given.kind else None


def _judge(problem: Problem, path: list[np.ndarray], known: np.ndarray) -> tuple[str, float]:
    """Status of a path's end and the closure error left there (length unit)."""
    system, end = problem.system, path[-1]
    if not all(np.all(np.isfinite(z)) for z in path):
        finite = [z for z in path if np.all(np.isfinite(z))]
        left = system.residual(finite[-1], known) if finite else float("inf")
        return ("singular" if _is_singular(problem, path[0], known) else "nonfinite"), left
    end = _unit(system, end)
    left = system.residual(system.polish(end, known), known)
    if left <= ACCEPTED * system.size:
        return "ok", left
    if _is_singular(problem, path[0], known):
        return "singular", left
    batch = levenberg_marquardt(system, np.stack([end, path[0]]), known, max_iterations=300, patience=60)
    best = min(system.residual(z, known) for z in batch.points if np.all(np.isfinite(z)))
    if not batch.converged.any():
        return "infeasible", min(best, left)
    return ("singular" if _is_singular(problem, end, known) else "max_iterations"), left


def _is_singular(problem: Problem, z: np.ndarray, known: np.ndarray) -> bool:
    _, jacobian = problem.system.linearise_one(_unit(problem.system, z), known)
    if not np.all(np.isfinite(jacobian)):
        return False
    singular = np.linalg.svd(jacobian, compute_uv=False)
    rank = problem.generic_rank
    return bool(rank > 0 and singular[rank - 1] < 1e-10 * max(singular[0], 1e-300))


def _unit(system: System, z: np.ndarray) -> np.ndarray:
    return system.move(z[None], np.zeros((1, system.freedom)))[0]


def _verified(problem: Problem, end: np.ndarray, given: Given, status: str, left: float) -> tuple[Solution | None, float]:
    if status != "ok":
        return None, left
    system = problem.system
    z = system.polish(_unit(system, end), given.values) if system.width else end
    solution = make_solution(problem, problem.assemble(z, given.values), notes=given.notes)
    return (solution, solution.residual) if solution.residual <= ACCEPTED * system.size else (None, solution.residual)


def _history(problem: Problem, path: list[np.ndarray], known: np.ndarray) -> list[Iterate]:
    steps = []
    for z in path:
        values = problem.assemble(z, known)
        if np.all(np.isfinite(values)):
            steps.append(Iterate(values, pose_of(problem.closure, values), problem.system.residual(_unit(problem.system, z), known)))
    return steps
