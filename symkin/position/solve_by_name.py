"""One configuration near a start, for values of any coordinates that are given by name.

Levenberg-Marquardt on all rows, then Gauss-Newton: where fewer coordinates are given than the
mobility, its steps are the shortest ones, so that the configuration is near the start; where loops
of redundant constraints are written with few digits, no configuration closes them exactly, and the
one of least squares is the answer.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.levenberg import patiently
from symkin.numeric.root_checks import POLISHING, is_root
from symkin.position.closed import ClosedForm
from symkin.position.determination import (
    determination,
    is_least,
    misfit_note,
    refuse_contradictions,
)
from symkin.position.given import Given
from symkin.position.given_by_name import given_by_name
from symkin.position.least_squares import LeastSquares
from symkin.position.mobility import open_loops_note
from symkin.position.moved_starts import moved_starts
from symkin.position.newton import Newton
from symkin.position.problem import Problem, build_problem
from symkin.position.solution_list import make_solution
from symkin.position.solve_result import SolveResult, iterates_of
from symkin.position.start_notes import start_notes
from symkin.position.starts import random_starts
from symkin.spatial.pose import Pose

_RESTARTS = 20

Start = Mapping[str, Any] | Sequence[float] | Pose | None


@dataclass(frozen=True, eq=False)
class _Attempt:
    """Where an iteration began and ended, and how far the loops are open there (length unit)."""

    begin: np.ndarray
    end: np.ndarray
    residual: float
    steps: int


def solve_by_name(
    mechanism: Mechanism,
    given: Given,
    start: Start,
    solver: Newton | LeastSquares | ClosedForm | None,
) -> SolveResult:
    """The configuration near a start that has the given values; `solver` in place of
    Levenberg-Marquardt.
    """
    clock = time.perf_counter()
    begin = _start_by_name(mechanism, given, start)
    problem = build_problem(
        mechanism, "given", given.names, tuple(n for n in begin.names if n not in given.names)
    )
    refuse_contradictions(problem)
    z = _unknowns_at(problem, given, begin)
    notes = list(given.notes)
    attempt = (
        _iterated(problem, given, z, solver)
        if given.off_motion == 0.0
        else _Attempt(z, z, given.off_motion, 0)
    )
    if (
        given.off_motion == 0.0
        and not _closes(problem, given, attempt)
        and not _is_least(problem, given, attempt)
    ):
        attempt, more = _from_elsewhere(problem, given, attempt, by_default=start is None)
        notes += more
    left = determination(problem).free
    solution, misfit = (
        None,
        _is_least(problem, given, attempt) if given.off_motion == 0.0 else False,
    )
    if _closes(problem, given, attempt) or misfit:
        if misfit:
            notes.append(misfit_note(problem, attempt.residual))
        if left:
            notes.append(_free_note(problem, left, start is None))
        solution = make_solution(
            problem, problem.join_values(attempt.end, given.values), notes=given.notes
        )
        notes += start_notes(solution, "given", start)
    note = open_loops_note(mechanism) if solution is None else None
    notes += [] if note is None else [note]
    return SolveResult(
        problem=problem,
        given=given.echo,
        status="ok"
        if solution is not None
        else "infeasible"
        if math.isfinite(attempt.residual)
        else "nonfinite",
        solution=solution,
        iterations=attempt.steps,
        history=iterates_of(problem, [attempt.begin, attempt.end], given.values),
        smallest_residual=None if solution is not None else attempt.residual,
        method="levenberg" if solver is None else solver.name,
        elapsed_s=time.perf_counter() - clock,
        notes=tuple(dict.fromkeys(notes)),
    )


# --- where it begins ------------------------------------------------------------------------------


def _start_by_name(mechanism: Mechanism, given: Given, start: Start) -> Given:
    """The start as values of coordinates by name: those of the user, else the example's, else
    none.
    """
    if start is None:
        example = mechanism.example
        if example is None or example.start is None:
            return Given("given", np.zeros(0), {})
        start = example.start
    if isinstance(start, Mapping):
        return _read_start(mechanism, start)
    actuated = [c.name for c in mechanism.actuated]
    direct = set(given.names) == set(actuated)
    if isinstance(start, Pose) or (len(start) == 7 and (direct or len(actuated) != 7)):
        return _read_start(mechanism, {"pose": start})
    if len(start) != len(actuated):
        raise InputError(
            f"start: {len(start)} values given; values by name are needed (NAME=VALUE,...), a pose "
            f"of 7 numbers, or the "
            f"{len(actuated)} actuated joints of {mechanism.name}"
        )
    return _read_start(mechanism, dict(zip(actuated, start, strict=True)))


def _read_start(mechanism: Mechanism, start: Mapping[str, Any]) -> Given:
    try:
        return given_by_name(mechanism, start)
    except InputError as error:
        raise InputError(f"start: {str(error).removeprefix('given: ')}") from None


def _unknowns_at(problem: Problem, given: Given, start: Given) -> np.ndarray:
    """Unknowns at the start: the closed configuration near the reference that has the start's
    values, or one that nearly has.
    """
    closure = problem.closure
    values = closure.reference.copy()
    if start.names:
        other = build_problem(
            problem.mechanism,
            "given",
            start.names,
            tuple(n for n in given.names if n not in start.names),
        )
        # the same coordinates, some of them in another place
        values = _values_in(problem, other, _fitted(other, start))
    values[problem.known_places] = given.values
    return problem.select_values(values, problem.system.unknowns)


def _fitted(problem: Problem, start: Given) -> np.ndarray:
    begin = problem.select_values(problem.closure.reference, problem.system.unknowns)
    if problem.system.width:
        batch = patiently(problem.system, begin[None], start.values)
        begin = batch.points[0] if np.all(np.isfinite(batch.points)) else begin
    return problem.join_values(begin, start.values)


def _values_in(problem: Problem, other: Problem, values: np.ndarray) -> np.ndarray:
    """The variables of one problem from those of another that holds the same coordinates."""
    found = problem.closure.reference.copy()
    for c in problem.closure.coordinates:
        if c.name in other.closure.slices:
            found[problem.closure.slices[c.name]] = values[other.closure.slices[c.name]]
    return found


# --- iterations -----------------------------------------------------------------------------------


def _iterated(
    problem: Problem, given: Given, z: np.ndarray, solver: Newton | LeastSquares | ClosedForm | None
) -> _Attempt:
    system = problem.system
    if system.width == 0:
        return _Attempt(z, z, system.residual(z, given.values), 0)
    if solver is not None:
        path = solver.iterate(problem, z, given.values)
        return _polished(problem, given, z, path[-1], len(path) - 1)
    batch = patiently(system, z[None], given.values)
    return _polished(problem, given, z, batch.points[0], batch.iterations)


def _polished(
    problem: Problem, given: Given, begin: np.ndarray, end: np.ndarray, steps: int
) -> _Attempt:
    system = problem.system
    if not np.all(np.isfinite(end)):
        return _Attempt(begin, begin, math.inf, steps)
    end = system.polish(system.wrap(system.unit(end)), given.values, POLISHING)
    return _Attempt(begin, end, system.residual(end, given.values), steps)


def _from_elsewhere(
    problem: Problem, given: Given, first: _Attempt, *, by_default: bool
) -> tuple[_Attempt, list[str]]:
    """The first of starts beside the given one, or of random ones for the default start, that leads
    to a configuration.
    """
    system = problem.system
    starts = [*moved_starts(problem, first.begin, given.values)]
    if by_default:
        starts += list(
            random_starts(problem, system, given, _RESTARTS, np.random.default_rng(0))[1:]
        )
    batch = patiently(system, np.array(starts), given.values)
    tries = [
        _polished(problem, given, z, end, batch.iterations)
        for z, end in zip(starts, batch.points, strict=True)
    ]
    for attempt in tries:
        if _closes(problem, given, attempt) or _is_least(problem, given, attempt):
            which = "default start" if by_default else "start"
            return attempt, [
                f"the {which} led to no configuration; another one (seed 0) did, which may be far "
                f"from it"
            ]
    return min([first, *tries], key=lambda a: a.residual), []


def _closes(problem: Problem, given: Given, attempt: _Attempt) -> bool:
    return (
        given.off_motion == 0.0
        and math.isfinite(attempt.residual)
        and is_root(problem.system, attempt.end, given.values)
    )


def _is_least(problem: Problem, given: Given, attempt: _Attempt) -> bool:
    return is_least(problem, given.values, attempt.end, attempt.residual)


# --- what is said ---------------------------------------------------------------------------------


def _free_note(problem: Problem, left: int, by_default: bool) -> str:
    count, mobility = len(problem.known_coordinates), len(problem.known_coordinates) + left
    where = "the reference" if by_default else "the start"
    return (
        f"{count} of the {mobility} coordinates that decide a configuration are given: this is one "
        f"near {where}, to which shortest "
        "steps of least squares have led"
    )
