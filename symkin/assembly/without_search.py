"""What is known of an input's modes without a search."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.as_written import Told
from symkin.assembly.group_roots import GroupRoots
from symkin.assembly.group_solvers import proofs_of_group
from symkin.assembly.modes_result import Modes
from symkin.assembly.plan import Plan
from symkin.assembly.prover import PartProofs
from symkin.assembly.search import Search
from symkin.errors import InputError
from symkin.homotopy.systems import unsuitable
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.groups import structure_groups
from symkin.position.pose_coordinates import poses_coordinates
from symkin.position.problem import Problem
from symkin.position.solution_list import SolutionList, checked_solutions


def _certified(problem: Problem, one: SolutionList, values: np.ndarray) -> SolutionList:
    """Poses that a formula gives, certified in balls as any other solutions: at values (n,
    variables) of the problem.
    """
    if unsuitable(problem) is not None:
        return one
    count = len(values)
    proofs = PartProofs.of_nothing(count)
    for part in structure_groups(problem):
        points = values[:, part.unknown_places]
        roots = GroupRoots.of_all(points, np.arange(count), np.ones(count))
        known = values[:, part.known_places]
        proofs = proofs.beside(proofs_of_group(part, roots, known, np.zeros(known.shape))[0])
    return one.chosen(slice(None), **proofs.told())


def errors_of_given(plan: Plan, known: np.ndarray) -> np.ndarray:
    """The errors (n,) of rows without unknowns at given values (n, known), 0 where these are
    rounding.
    """
    problem = plan.problem
    if not plan.has_conditions:
        return np.zeros(len(known))
    errors = problem.conditions.residuals(np.zeros((len(known), 0)), known)
    within = errors <= CLOSURE_TOLERANCE * problem.closure.characteristic_length
    return np.where(within, 0.0, errors)


def known_without_search(
    plan: Plan, givens: Sequence[Given], search: Search, told: Told | None = None
) -> dict[int, Modes]:
    """The modes of inputs that need no search, by their numbers: unknowns that nothing determines,
    a pose off the motion, the direct problem of a serial arm, given values that contradict rows
    without unknowns. The modes of a machine are `told` in the coordinates of a description.
    """
    problem = plan.problem
    if plan.free is not None:
        free = (
            f"{plan.free}, so that its solutions are no isolated modes; use solve with a start for "
            f"one of them"
        )
        if problem.mechanism.serial:
            raise InputError(free)
        search.refuse_unless_multistart(free)
        note = f"positive-dimensional set: {free}"
        empty = (nothing(problem, given, search, note=note) for given in givens)
        return dict(enumerate(replace(one, positive_dimensional=True) for one in empty))
    known = np.array([given.values for given in givens])
    if problem.is_explicit:
        return dict(enumerate(_forward(problem, givens, known, search, told)))
    errors = errors_of_given(plan, known).tolist()
    return {
        k: nothing(problem, given, search, given.off_motion or error)
        for k, (given, error) in enumerate(zip(givens, errors, strict=True))
        if given.off_motion or error
    }


def _forward(
    problem: Problem,
    givens: Sequence[Given],
    known: np.ndarray,
    search: Search,
    told: Told | None,
) -> Iterator[Modes]:
    """The one mode of a serial arm's joints (n, known), of each input."""
    search.refuse_unless_multistart(
        "the direct problem of a serial arm is a function of its joints, and nothing is searched"
    )
    poses = problem.forward(known)
    assert poses is not None  # noqa: S101 - the problem is explicit
    coordinates, _ = poses_coordinates(problem.mechanism, poses[:, :3].T, poses[:, 3:].T)
    values = problem.join_values(coordinates, known)
    if told is None:
        listed = checked_solutions(problem, values)
    else:
        listed = told.listed(problem.closure, values, np.arange(len(known)))
    listed, elapsed = _certified(problem, listed, values), search.elapsed_s
    note = "forward kinematics of a serial arm is a function of its joints: one pose"
    for k, (given, closed) in enumerate(zip(givens, listed.closed.tolist(), strict=True)):
        if not closed:
            yield nothing(problem, given, search, float(listed.residual[k]))
            continue
        yield Modes(
            problem=problem if told is None else told.problem,
            given=given.echo,
            modes=listed.chosen(slice(k, k + 1), notes=given.notes),
            completeness="proved",
            method="forward",
            seed=None,
            elapsed_s=elapsed,
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
        elapsed_s=search.elapsed_s,
        smallest_residual=smallest,
        notes=(*given.notes, note) if note else given.notes,
    )
