"""All modes of a problem by its structure groups: each is solved for every choice of those before it that it depends on.

The modes are the tree of the groups' choices. A group is solved once for each set of values that it reads, so that the cost grows
with the sum of the groups and not with their product; groups that do not read each other's values are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod

import casadi as ca
import numpy as np

from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.continuation import by_continuation
from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.modes_result import Completeness, Group, Modes
from symkin.assembly.search import Search
from symkin.computed_once import lru_cache
from symkin.errors import InputError, TooManyModesError
from symkin.homotopy.start_store import start_of
from symkin.homotopy.structure import start_of_structure, structure_of
from symkin.homotopy.systems import system_of, unsuitable
from symkin.homotopy.values import algebraic_points
from symkin.numeric.levenberg import Progress
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.groups import structure_groups
from symkin.position.multistart import batched
from symkin.position.problem import Problem
from symkin.position.roots import MOST_MODES
from symkin.position.solution_list import SolutionList, checked_solutions

_RANKS: dict[Completeness, int] = {"proved": 0, "probability one": 1, "incomplete": 2, "sampled": 3}
"""Statements from the strongest to the weakest."""
_DIGITS = 6
"""Decimals to which values are rounded for the order of a group's solutions, so that rounding errors do not decide it."""


@dataclass
class _Solved:
    """A group's solutions for the values that it has been asked for: `points` (n, width) for each, and what is known of all."""

    problem: Problem
    completeness: Completeness
    complex_count: int | None = None
    unresolved: int | None = 0
    smallest: float = np.inf
    continuum: bool = False
    notes: tuple[str, ...] = ()
    engine: str | None = None
    sampled: bool = False
    count: int = 0


def modes_by_groups(
    problem: Problem, given: Given, search: Search, choose: Sequence[int] = (), progress: Progress | None = None
) -> Modes:
    """The modes for one set of given values; `choose` takes one solution of each of the first groups, by number."""
    rng = np.random.default_rng(search.seed)
    begin = np.zeros((1, int(problem.closure.variables.shape[0])))
    # of a structure nothing moves, its geometry is what is given
    begin[:, problem.known_places] = given.values if len(given.values) else problem.reference_known
    groups = structure_groups(problem)
    _check_choices(problem, choose)
    solved: dict[int, _Solved] = {}
    parts = []
    for part in independent_parts(groups):
        values = begin
        for number in part:
            chosen = choose[number] if number < len(choose) else None
            solved[number], values = _extended(groups[number], values, search, rng, chosen, progress)
            if len(values) > MOST_MODES:
                raise TooManyModesError(_too_many(problem, groups, number))
            if not len(values):
                break
        columns = np.concatenate([groups[number].unknown_places for number in part])
        parts.append((columns, values[:, columns]))
    count = prod(len(values) for _, values in parts)
    return _result(problem, given, search, [solved[k] for k in sorted(solved)], _combined(begin, parts, count), count)


def independent_parts(groups: Sequence[Problem]) -> list[list[int]]:
    """Numbers of the groups that read each other's values, directly or not: a left leg and a right one are two parts."""
    label = list(range(len(groups)))
    for k, group in enumerate(groups):
        read = {c.name for c in group.known_coordinates}
        for j in range(k):
            if read & {c.name for c in groups[j].system.unknowns}:
                old, new = label[j], label[k]
                label = [new if mine == old else mine for mine in label]
    return [[k for k, mine in enumerate(label) if mine == part] for part in dict.fromkeys(label)]


def _combined(begin: np.ndarray, parts: list[tuple[np.ndarray, np.ndarray]], count: int) -> np.ndarray:
    """Every combination of the parts' solutions, or, where these are too many, the first of each with every one of one part."""
    sizes = [len(values) for _, values in parts]
    if count <= MOST_MODES:
        chosen = np.array(list(product(*(range(n) for n in sizes))), dtype=int).reshape(count, len(parts))
    else:
        rows = [np.zeros(len(parts), dtype=int)]
        for k, n in enumerate(sizes):
            rows += [np.eye(1, len(parts), k, dtype=int)[0] * i for i in range(1, n)]
        chosen = np.array(rows)
    values = np.repeat(begin, len(chosen), axis=0)
    for k, (columns, own) in enumerate(parts):
        values[:, columns] = own[chosen[:, k]]
    return values


def _check_choices(problem: Problem, choose: Sequence[int]) -> None:
    groups = structure_groups(problem)
    if len(choose) > len(groups):
        raise InputError(
            f"choose: {len(choose)} numbers for {len(groups)} blocks of {problem.mechanism.name}; one a block, in order"
        )
    for number in choose:
        if isinstance(number, bool) or not isinstance(number, int) or number < 0:
            raise InputError(f"choose: {number!r}; whole numbers from 0 on are needed, one a block")


def _too_many(problem: Problem, groups: Sequence[Problem], number: int) -> str:
    names = ", ".join(c.name for c in groups[number].system.unknowns)
    return (
        f"{problem.mechanism.name}: the solutions of its blocks combine to more than the {MOST_MODES} modes that are listed, at "
        f"block {number} ({names}) of {len(groups)}; take one solution of each of the first blocks by choose (--choose 0,1,...), or "
        "solve for one near a start"
    )


def _extended(
    group: Problem, values: np.ndarray, search: Search, rng: np.random.Generator, choice: int | None, progress: Progress | None
) -> tuple[_Solved, np.ndarray]:
    """Each of the partial configurations (n, variables) with every solution of a group beside it, or with the chosen one."""
    known, which = np.unique(values[:, group.known_places], axis=0, return_inverse=True)
    which = which.ravel()
    solved, points, owner = _solve(group, known, search, rng, progress)
    order = np.lexsort((*np.round(points.T[::-1], _DIGITS), owner))
    points, owner = points[order], owner[order]
    solved.count = int(np.bincount(owner, minlength=1).max())
    chosen = [np.flatnonzero(owner == mine) for mine in which.tolist()]
    if choice is not None:
        least = min((len(columns) for columns in chosen), default=0)
        if choice >= least:
            names = ", ".join(c.name for c in group.system.unknowns)
            allowed = f"0 to {least - 1}" if least else "none"
            raise InputError(f"choose: {choice} for the block {names}, which has {least} solutions here; allowed: {allowed}")
        chosen = [columns[choice : choice + 1] for columns in chosen]
    wider = values[np.repeat(np.arange(len(values)), [len(columns) for columns in chosen])]
    wider[:, group.unknown_places] = points[np.concatenate(chosen)]
    return solved, wider


def _solve(
    group: Problem, known: np.ndarray, search: Search, rng: np.random.Generator, progress: Progress | None
) -> tuple[_Solved, np.ndarray, np.ndarray]:
    """Solutions (m, width) of a group at known values (n, known), and the row of these that each belongs to."""
    if is_linear(group):
        return _linear(group, known)
    if search.method == "continuation":
        paths = group_paths(group)
        if paths is not None:
            found = paths.roots(known, certify=False)
            if found.plain.all() and len(found.points):
                count = int(found.complex_count.max(initial=0))
                solved = _Solved(group, "probability one", count, notes=paths.notes, engine=paths.engine)
                return solved, found.points, found.owner
    return _one_by_one(group, known, search, rng, progress)


def _one_by_one(
    group: Problem, known: np.ndarray, search: Search, rng: np.random.Generator, progress: Progress | None
) -> tuple[_Solved, np.ndarray, np.ndarray]:
    points, owner, solved = [np.zeros((0, group.system.width))], [np.zeros(0, dtype=int)], _Solved(group, "proved")
    for place, numbers in enumerate(known):
        given = Given("given", numbers, {})
        notes: tuple[str, ...] = ()
        if search.method == "continuation":
            blocks, notes, _ = by_continuation(group, given, search.starts, rng, progress)
            (roots,) = blocks
        else:
            roots = batched(group, group.blocks[0], given, search.starts, rng, progress)
        state: Completeness = "probability one"
        if roots.sampled:
            state = "sampled"
        elif roots.unresolved or roots.complex_sets or roots.continuum is not None:
            state = "incomplete"
        solved.completeness = max(solved.completeness, state, key=lambda s: _RANKS[s])
        solved.sampled |= roots.sampled
        solved.complex_count = None if roots.complex_count is None else max(solved.complex_count or 0, roots.complex_count)
        solved.unresolved = None if roots.sampled or solved.unresolved is None else solved.unresolved + roots.unresolved
        solved.continuum |= roots.continuum is not None
        solved.smallest = min(solved.smallest, roots.smallest_residual)
        solved.engine = roots.engine or solved.engine
        missing = () if roots.missing is None else (f"{', '.join(c.name for c in group.system.unknowns)}: {roots.missing}",)
        solved.notes = tuple(dict.fromkeys((*solved.notes, *notes, *missing)))
        points.append(roots.points)
        owner.append(np.full(len(roots.points), place))
    return solved, np.concatenate(points), np.concatenate(owner)


@lru_cache(maxsize=256)
def group_paths(group: Problem) -> BlockPaths | None:
    """What tracks the paths of a group; None where it has no start."""
    if unsuitable(group) is not None:
        return None
    (block,) = group.blocks
    system = system_of(group, block)
    structure = structure_of(group, system)
    if structure is not None:
        shared = start_of_structure(group, structure)
        if shared is not None:
            return BlockPaths(group, block, structure.system, shared, structure)
    start, _ = start_of(group, system, block)
    return None if start is None else BlockPaths(group, block, system, start)


# --- groups that are linear ----------------------------------------------------------------------------------------


@lru_cache(maxsize=256)
def is_linear(group: Problem) -> bool:
    """Whether the rows are linear in the unknowns, as those of couplings are: one solution, without a search."""
    system = group.system
    turning = any(c.kind == "quaternion" for c in system.unknowns)
    return not turning and not any(ca.which_depends(system.rows, system.unknown, 2, True))


def _linear(group: Problem, known: np.ndarray) -> tuple[_Solved, np.ndarray, np.ndarray]:
    system = group.system
    begin = np.zeros((len(known), system.width))
    points = system.polish_many(begin, known).points
    residual = system.residuals(points, known)
    closed = np.flatnonzero(residual <= CLOSURE_TOLERANCE * system.characteristic_length)
    smallest = float(residual.min(initial=np.inf))
    return _Solved(group, "proved", 1, smallest=smallest), points[closed], closed


# --- the result ----------------------------------------------------------------------------------------------------


def _result(problem: Problem, given: Given, search: Search, solved: list[_Solved], values: np.ndarray, count: int) -> Modes:
    groups = structure_groups(problem)
    found = checked_solutions(problem, values, given.notes)
    order = order_of_modes(problem, found.values, found.position, found.quaternion, np.zeros(len(values), dtype=int))
    # what is listed closes: on all rows together, not only on those of its groups
    closed = found.residual[order] <= CLOSURE_TOLERANCE * problem.closure.characteristic_length
    found = _certified(problem, given, found.chosen(order[closed]))
    whole = len(solved) == len(groups)
    counts = [part.complex_count for part in solved]
    completeness: Completeness = max((part.completeness for part in solved), key=lambda s: _RANKS[s], default="proved")
    if not closed.all():
        completeness, count = max(completeness, "incomplete", key=lambda s: _RANKS[s]), len(found)
    unresolved = [part.unresolved for part in solved]
    smallest = min((part.smallest for part in solved if np.isfinite(part.smallest)), default=None)
    continuum = any(part.continuum for part in solved)
    return Modes(
        problem=problem,
        given=given.echo,
        modes=found,
        completeness=completeness,
        method=search.method,
        seed=search.seed,
        elapsed_s=0.0,
        complex_count=prod(c for c in counts if c is not None) if whole and None not in counts else None,
        unresolved_paths=None if None in unresolved else sum(u for u in unresolved if u is not None),
        smallest_residual=None if len(found) or continuum else smallest,
        positive_dimensional=continuum,
        notes=tuple(dict.fromkeys((*given.notes, *(note for part in solved for note in part.notes)))),
        engine=", ".join(dict.fromkeys(part.engine for part in solved if part.engine is not None)) or None,
        groups=tuple(_group(part) for part in solved),
        count=count if whole else 0,
    )


def _group(part: _Solved) -> Group:
    unknowns = tuple(c.name for c in part.problem.system.unknowns)
    return Group(", ".join(unknowns), unknowns, part.complex_count, part.completeness, part.count)


def _certified(problem: Problem, given: Given, found: SolutionList) -> SolutionList:
    """The solutions with their certificates, on the rows of all groups together: each group's values are only known up to a box
    of their own."""
    from symkin.certificate.certificate import certify_batch
    from symkin.certificate.exact import knowns_of

    if not len(found) or unsuitable(problem) is not None:
        return found
    (block,) = problem.blocks
    system = system_of(problem, block)
    named = {c.name: found.values[:, problem.closure.slices[c.name]] for c in block.unknowns}
    z = algebraic_points(problem, system, named)
    size = problem.closure.characteristic_length
    values = given.values if len(given.values) else problem.reference_known
    batch = certify_batch(system, z, knowns_of(problem, values[None]), np.zeros(z.shape[1], dtype=np.intc), size)
    index, radius = batch.find(z, np.zeros(z.shape[1], dtype=int), None)
    return replace(found, certified=(index >= 0).astype(int), radius=radius, _made={})
