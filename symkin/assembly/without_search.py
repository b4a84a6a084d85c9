"""What is known of an input's modes without a search."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from symkin.assembly.as_written import Told
from symkin.assembly.group_roots import GroupRoots
from symkin.assembly.mode_proofs import proofs_of_group
from symkin.assembly.modes_result import Modes
from symkin.assembly.prover import PartProofs
from symkin.assembly.search import Search
from symkin.errors import InputError
from symkin.homotopy.systems import unsuitable
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.closed_configurations import assembly_of
from symkin.position.determination import what_is_free
from symkin.position.generic_rank import generic_rank
from symkin.position.given import Given
from symkin.position.groups import structure_groups
from symkin.position.pose_coordinates import poses_coordinates
from symkin.position.problem import Problem
from symkin.position.solution_list import SolutionList, checked_solutions


def free_unknowns(problem: Problem) -> str | None:
    """What to say where the rows leave unknowns free, so that no solution is isolated; coordinates
    by name are refused where they do not determine the others. Another assembly, where fewer are
    free, is searched.
    """
    free = what_is_free(problem)
    if free and problem.generic_rank == problem.system.freedom:
        found = generic_rank(assembly_of(problem.closure), 0)
        free = None if found.other_ranks or found.ranks_apart else free
    return free and (
        f"{free}, so that its solutions are no isolated modes; use solve with a start for one of "
        f"them"
    )


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


def meet_conditions(problem: Problem, known: np.ndarray) -> np.ndarray:
    """Which given values (n, known) meet the rows without unknowns."""
    return _errors_of_given(problem, known) == 0.0


def _errors_of_given(problem: Problem, known: np.ndarray) -> np.ndarray:
    """The errors (n,) of rows without unknowns at given values (n, known), 0 where these are
    rounding. Rows of a problem whose coordinates are told by name are left to its groups.
    """
    if problem.by_name or problem.conditions.errors.is_zero():
        return np.zeros(len(known))
    errors = problem.conditions.residuals(np.zeros((len(known), 0)), known)
    within = errors <= CLOSURE_TOLERANCE * problem.closure.characteristic_length
    return np.where(within, 0.0, errors)


def known_without_search(
    problem: Problem, givens: Sequence[Given], search: Search, told: Told | None = None
) -> list[Modes | None]:
    """What needs no search, of each input: unknowns that nothing determines, a pose off the motion,
    the direct problem of a serial arm, given values that contradict rows without unknowns. The
    modes of a machine are `told` in the coordinates of a description.
    """
    free = free_unknowns(problem)
    if free is not None and problem.mechanism.serial:
        raise InputError(free)
    if free is not None:
        search.refuse_unless_multistart(free)
        empty = [
            nothing(problem, given, search, note=f"positive-dimensional set: {free}")
            for given in givens
        ]
        return [replace(one, positive_dimensional=True) for one in empty]
    known = np.array([given.values for given in givens])
    if problem.is_explicit:
        return [*_forward(problem, givens, known, search, told)]
    errors = _errors_of_given(problem, known).tolist()
    off = (g.off_motion or e for g, e in zip(givens, errors, strict=True))
    return [
        nothing(problem, given, search, away) if away else None
        for given, away in zip(givens, off, strict=True)
    ]


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
