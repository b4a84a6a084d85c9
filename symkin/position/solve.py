"""One solution near a start: the driver that owns convergence, verification and the status."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Unpack

import numpy as np

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.numeric.levenberg import patiently
from symkin.numeric.root_checks import POLISHING, is_root
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.closed import ClosedForm
from symkin.position.determination import (
    DIGITS,
    determination,
    determination_at,
    is_least,
    misfit_note,
    refuse_contradictions,
    set_notes,
)
from symkin.position.given import Given, read_given
from symkin.position.least_squares import LeastSquares
from symkin.position.levenberg import Levenberg
from symkin.position.mobility import open_loops_note
from symkin.position.moved_starts import (
    StartRank,
    is_singular,
    moved_note,
    moved_starts,
    nearly_closes,
)
from symkin.position.newton import Newton
from symkin.position.options import SolveOptions
from symkin.position.out_of_reach import reach_note
from symkin.position.pose_coordinates import motion_note
from symkin.position.problem import Problem, build_problem
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from symkin.position.solve_result import SolveError, SolveResult, iterates_of
from symkin.position.starts import Start, begun, random_starts, start_notes
from symkin.text import not_among
from symkin.verb import verb
from symkin.verb_options import refuse_ignored

Solver = Newton | LeastSquares | ClosedForm | Levenberg
SOLVERS: dict[str, Solver] = {
    "newton": Newton(),
    "fast_newton": Newton(method="fast_newton"),
    "ipopt": LeastSquares(),
    "closed": ClosedForm(),
}
RESTARTS = 20
_NEARLY_CLOSED = 1e-6
"""Closure error, of the size, of ends that are polished to solutions."""


@verb(SolveOptions)
def solve(mechanism: Mechanism, **options: Unpack[SolveOptions]) -> SolveResult:
    """Find one solution of F(q, x, X, p) = 0 near `start`, for given `joints` q, a `pose` X, or
    values `given` by name.

    Values are in the mechanism's units: actuated joints in file order or by name; a pose is x, y,
    z, qw, qx, qy, qz. `start` is a pose for the direct problem and all actuated joints for the
    inverse one; default: the example's, else the reference. A start where the closure's Jacobian
    loses rank is moved, and `notes` says where to. `solver` is "newton", "fast_newton" (CasADi's
    rootfinders), "ipopt" (least squares with joint limits as bounds), "closed" (the formulas of an
    arm that has some, of its solutions the nearest to the start), or a value of
    `symkin.position.newton.Newton` or `symkin.position.least_squares.LeastSquares`. The answer is
    checked on all rows.

    `given` maps names of coordinates to values: joints, passive ones too, and x, y, z, azimuth,
    tilt and torsion of the platform, or its whole "pose". With it, and for a graph of links,
    `start` maps names to values as well, and "newton" means Levenberg-Marquardt on all rows; where
    fewer are given than the mobility, the configuration is one near the start. Which of several
    solutions values far from the start lead to depends on where loops are cut, and so on the order
    of a graph's joints.

    Raises SolveError when no solution is reached, unless `check` is False; InputError for values
    that do not fit, and for a `start` where nothing is iterated.

    >>> import symkin
    >>> platform = symkin.load("zhao2000")
    >>> joints = {"theta1": 81.6, "theta2": 202.8, "theta3": 330.6, "op": 105.2}
    >>> found = symkin.solve(platform, joints=joints)
    >>> back = symkin.solve(platform, pose=found.solution.pose)
    >>> found.status, [round(v, 6) for v in back.solution.actuated_values]
    ('ok', [81.6, -157.2, -29.4, 105.2])
    """
    require_mechanism(mechanism)
    asked = options["joints"], options["pose"], options["given"]
    start, solver = options["start"], options["solver"]
    chosen = SOLVERS.get(solver) if isinstance(solver, str) else solver
    if chosen is None or not hasattr(chosen, "name"):
        raise InputError(f"solver = {not_among(solver, SOLVERS)}")
    known = read_given(mechanism, *asked)
    result = _solved(mechanism, known, start, chosen, damped=solver == "newton")
    if result.status == "infeasible":
        note = reach_note(result.problem, known)
        result = result if note is None else replace(result, notes=(*result.notes, note))
    if result.solution is not None:
        found = result.solution
        note = motion_note(mechanism, found.position[None], found.quaternion[None])
        result = result if note is None else replace(result, notes=(*result.notes, note))
    if options["check"] and result.solution is None:
        raise SolveError("; ".join([result.message, *result.notes]), result)
    return result


def _solved(
    mechanism: Mechanism, given: Given, start: Start, chosen: Solver, *, damped: bool
) -> SolveResult:
    """The solution near a start; of values by name by damped steps, if no other solver is asked
    for.
    """
    begin = time.perf_counter()
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        problem = build_problem(mechanism, given.names)
        if not problem.by_name and (problem.is_explicit or not problem.system.width):
            refuse_ignored({"start": start}, _nothing_iterated(problem))
        problem, z = begun(mechanism, given, start)
        if problem.by_name:
            chosen = Levenberg() if damped else chosen
        if start is None:
            result = _from_default(problem, given, chosen, z)
        else:
            result = solve_beside(problem, given, chosen, z, "start")
        if problem.by_name:
            refuse_contradictions(problem, result.solution)
    notes = [*result.notes, *_more_notes(result, start)]
    return replace(result, notes=tuple(dict.fromkeys(notes)), elapsed_s=time.perf_counter() - begin)


def _more_notes(result: SolveResult, start: Start) -> list[str]:
    """What is said of a solution that loops of few digits or too few values leave open, and of one
    far from its start; of loops that never close.
    """
    problem, found = result.problem, result.solution
    if found is None:
        note = open_loops_note(problem.mechanism) if problem.by_name else None
        return [] if note is None else [note]
    size, notes = problem.closure.characteristic_length, list[str]()
    if found.residual > CLOSURE_TOLERANCE * size:
        notes.append(misfit_note(problem, found.residual))
    left = determination(problem).free if problem.by_name else 0
    if left:
        there = determination_at(problem, found)
        left = left if there.decided else min(left, there.free)
    if left:
        notes.append(_free_note(problem, left, start is None))
    notes += set_notes(problem, found.condition)
    return notes if start is None else [*notes, *start_notes(found, problem, start)]


def _free_note(problem: Problem, left: int, by_default: bool) -> str:
    count, mobility = len(problem.known_coordinates), len(problem.known_coordinates) + left
    where = "the reference" if by_default else "the start"
    return (
        f"{count} of the {mobility} coordinates that decide a configuration are given: this is one "
        f"near {where}, to which shortest "
        "steps of least squares have led"
    )


def _nothing_iterated(problem: Problem) -> str:
    """Why `solve` needs no start."""
    if problem.is_explicit:
        return (
            "the direct problem of a serial arm is a function of its joints, and nothing is "
            "iterated"
        )
    return (
        f"the {problem.name} problem of {problem.mechanism.name} has no unknowns, and nothing is "
        f"iterated"
    )


def solve_problem(problem: Problem, given: Given, solver: Solver, start: np.ndarray) -> SolveResult:
    """Iterate from a start (unknowns of the problem's system), verify on all rows, name the
    outcome.
    """
    return _outcome(problem, given, solver, _iterates(problem, given, solver, start))


def _outcome(problem: Problem, given: Given, solver: Solver, path: list[np.ndarray]) -> SolveResult:
    """What the iterates from a start have come to."""
    begin, name = time.perf_counter(), solver.name
    if given.off_motion > 0.0:
        status, left = "infeasible", given.off_motion
    elif problem.is_explicit:
        status, left, name = "ok", 0.0, "forward"
    else:
        status, left = _judge(problem, solver, path, given.values)
    solution, left = _verified(problem, path[-1], given, status, left)
    status = "infeasible" if status == "ok" and solution is None else status
    return SolveResult(
        problem=problem,
        given=given.echo,
        status=status,  # type: ignore[arg-type]
        solution=solution,
        iterations=len(path) - 1,
        history=iterates_of(problem, path, given.values),
        smallest_residual=None if solution is not None else left,
        method=name,
        elapsed_s=time.perf_counter() - begin,
        notes=given.notes,
    )


def solve_beside(
    problem: Problem, given: Given, solver: Solver, start: np.ndarray, which: str
) -> SolveResult:
    """Iterate from a start; where it is singular, or nearly so and leads nowhere, from starts moved
    off it, and say so.

    At a singular start Newton's step is rounding over rounding, and least squares do not slope
    along what is lost: what it leads to is left to chance, unless the start nearly closes. Damped
    steps begin anywhere, and go on from moved starts wherever they lead nowhere.
    """
    if given.off_motion > 0.0 or problem.is_explicit or problem.system.width == 0:
        return solve_problem(problem, given, solver, start)
    damped = isinstance(solver, Levenberg)
    first: SolveResult | None = None
    if damped:
        first = solve_problem(problem, given, solver, start)
        if first.solution is not None:
            return first
    rank = StartRank.at(problem, start, given.values)
    if not damped and (not rank.is_singular or nearly_closes(problem, start, given.values)):
        first = solve_problem(problem, given, solver, start)
        if first.solution is not None or not rank.is_nearly_singular:
            return first
    starts = moved_starts(problem, start, given.values)
    found = _from_some(problem, given, solver, starts)
    if found is not None:
        began, again = found
        note = (
            f"the {which} led to no configuration; another one (seed 0) did, which may be far from "
            f"it"
            if damped
            else moved_note(problem, given, rank, began, which)
        )
        return replace(again, notes=(*again.notes, note))
    verdict = min(
        (
            solve_problem(problem, given, solver, start) if first is None else first,
            solve_problem(problem, given, solver, starts[0]),
        ),
        key=lambda r: (r.solution is None, r.status != "infeasible", r.smallest_residual or 0.0),
    )
    if verdict.solution is not None or damped:
        return verdict
    note = (
        f"the {which} is {rank}, and {len(starts)} starts beside it led to no solution: give "
        f"another start, or list all with modes"
    )
    return replace(verdict, notes=(*verdict.notes, note))


def _from_some(
    problem: Problem, given: Given, solver: Solver, starts: np.ndarray
) -> tuple[np.ndarray, SolveResult] | None:
    """The start that has led to a solution, and the result: the first, then, where
    Levenberg-Marquardt finds the problem to have one, the others and the ends of
    Levenberg-Marquardt.
    """
    tries = starts[:1]
    found = _first_that_closes(problem, given, solver, tries)
    if found is None:
        ends = patiently(problem.system, starts, given.values).points
        ends = ends[np.isfinite(ends).all(axis=1)]
        ends = ends[problem.system.residuals(ends, given.values) <= _near(problem)]
        tries = ends if isinstance(solver, Levenberg) else np.vstack([starts[1:], ends])
        found = _first_that_closes(problem, given, solver, tries) if len(ends) else None
    return None if found is None else (tries[found[0]], found[1])


def _near(problem: Problem) -> float:
    """Closure error (length unit) up to which an end may be a solution: others than those that the
    digits of a file leave open may be held off by limits.
    """
    share = DIGITS if problem.by_name else _NEARLY_CLOSED
    return share * problem.closure.characteristic_length


def _first_that_closes(
    problem: Problem, given: Given, solver: Solver, starts: np.ndarray
) -> tuple[int, SolveResult] | None:
    """The first of some starts that leads to a solution: its index, and the result."""
    system, near = problem.system, _near(problem)
    for k, start in enumerate(starts):
        path = _iterates(problem, given, solver, start)
        end = path[-1]
        closes = np.all(np.isfinite(end)) and (
            system.residual(system.wrap(system.unit(end)), given.values) <= near
        )
        result = _outcome(problem, given, solver, path) if closes else None
        if result is not None and result.solution is not None:
            return k, result
    return None


def _from_default(problem: Problem, given: Given, solver: Solver, begin: np.ndarray) -> SolveResult:
    """Where the default start leads nowhere, random starts are tried, and the result says so."""
    result = solve_beside(problem, given, solver, begin, "default start")
    if result.solution is not None or given.off_motion > 0.0 or problem.system.width == 0:
        return result
    starts = random_starts(
        problem, problem.system, given.values, RESTARTS, np.random.default_rng(0)
    )[1:]
    found = _from_some(problem, given, solver, starts)
    if found is None:
        return result
    note = f"the default start led to no solution ({result.status}); a random one (seed 0) did"
    return replace(found[1], notes=(*found[1].notes, note))


def _iterates(
    problem: Problem, given: Given, solver: Solver, start: np.ndarray
) -> list[np.ndarray]:
    if given.off_motion > 0.0 or problem.is_explicit or problem.system.width == 0:
        return [start]
    return solver.iterate(problem, start, given.values)


def _judge(
    problem: Problem, solver: Solver, path: list[np.ndarray], known: np.ndarray
) -> tuple[str, float]:
    """Status of a path's end and the closure error left there (length unit)."""
    system, end = problem.system, path[-1]
    if not all(np.all(np.isfinite(z)) for z in path):
        finite = [z for z in path if np.all(np.isfinite(z))]
        left = system.residual(finite[-1], known) if finite else float("inf")
        return ("singular" if is_singular(problem, path[0], known) else "nonfinite"), left
    end = system.wrap(system.unit(end))
    left = system.residual(system.polish(end, known), known)
    # values by name may be those of a file that closes redundant rows only to its digits
    if problem.by_name or left <= CLOSURE_TOLERANCE * system.characteristic_length:
        polished = system.polish(end, known, POLISHING)
        if _is_answer(problem, polished, known):
            return "ok", left
    if isinstance(solver, Levenberg) or system.width == 0:
        return "infeasible", left
    if is_singular(problem, path[0], known):
        return "singular", left
    batch = patiently(system, np.stack([end, path[0]]), known)
    best = min(system.residual(z, known) for z in batch.points if np.all(np.isfinite(z)))
    reached = [system.polish(z, known, POLISHING) for z in batch.points[batch.converged]]
    if not any(is_root(system, z, known) for z in reached):
        return "infeasible", min(best, left)
    return ("singular" if is_singular(problem, end, known) else "max_iterations"), left


def _is_answer(problem: Problem, z: np.ndarray, known: np.ndarray) -> bool:
    """Whether unknowns close all rows to rounding, or redundant ones to the digits of a file as
    well as any do.
    """
    system = problem.system
    return is_root(system, z, known) or is_least(problem, known, z, system.residual(z, known))


def _verified(
    problem: Problem, end: np.ndarray, given: Given, status: str, left: float
) -> tuple[Solution | None, float]:
    if status != "ok":
        return None, left
    system = problem.system
    z = (
        system.polish(system.wrap(system.unit(end)), given.values, POLISHING)
        if system.width
        else end
    )
    solution = make_solution(problem, problem.join_values(z, given.values), notes=given.notes)
    return (solution if _is_answer(problem, z, given.values) else None), solution.residual
