"""Decompose a problem into structure groups: parts that are solved one after another (Assur
groups).

The rows' derivatives at random points show which rows hold which unknowns; at closed configurations
such a derivative may vanish because of the assembly (the bar of a parallelogram stays level). Of
each branch's rows a set is kept that is independent at generic closed configurations; Dulmage and
Mendelsohn's decomposition of what is left, a matching of rows and unknowns and the strongly
connected components of the graph that it makes, is the block triangular form. In kinematics its
blocks are Assur groups. All rows of a block, redundant ones included, go with it.

Source: A. L. Dulmage, N. S. Mendelsohn, Coverings of bipartite graphs, Canadian J. Math. 10 (1958)
517-534.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import pairwise

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, random_points
from symkin.computed_once import lru_cache
from symkin.elimination.implied_rows import PointRow, implied_rows
from symkin.elimination.product_rows import ProductRow
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.linear_algebra import diagonal_parts, singular_values
from symkin.numeric.rank import Rank, independent_rows
from symkin.numeric.system import components
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations
from symkin.position.problem import Problem

_POINTS = 3
"""Random points at which derivatives are looked at: one that vanishes at all of them is zero."""
_ZERO = 1e-9
"""Derivative, over the largest of its row, that is zero to rounding."""


@lru_cache(maxsize=128)
def structure_groups(problem: Problem) -> tuple[Problem, ...]:
    """The parts of a problem in the order of their solution, each a problem of its own: unknown are
    its coordinates, known those of the given ones and of earlier parts that its rows hold.
    """
    return _decomposed(problem)


@lru_cache(maxsize=128)
def independent_parts(groups: tuple[Problem, ...]) -> list[list[int]]:
    """Numbers of the groups that read each other's values, directly or not: a left leg and a right
    one are two parts.
    """
    label = list(range(len(groups)))
    for k, group in enumerate(groups):
        read = {c.name for c in group.known_coordinates}
        for j in range(k):
            if read & {c.name for c in groups[j].system.unknowns}:
                old, new = label[j], label[k]
                label = [new if mine == old else mine for mine in label]
    return [[k for k, mine in enumerate(label) if mine == part] for part in dict.fromkeys(label)]


@lru_cache(maxsize=128)
def joined_groups(problem: Problem, groups: tuple[Problem, ...]) -> Problem:
    """Groups of a problem that read no others' values as one."""
    names = {c.name for group in groups for c in group.system.unknowns}
    unknowns = tuple(c for c in problem.system.unknowns if c.name in names)
    places, checks = (
        [k for k, held in enumerate(part) if held & names] for part in _dependences(problem)
    )
    system, own = problem.system, problem.row_places
    if len(places) == system.rows.shape[0]:
        # what of the closure errors no unknown enters is held against known values
        return problem
    return replace(
        problem,
        system=replace(
            system,
            unknowns=unknowns,
            unknown=problem.closure.symbols(unknowns),
            rows=system.rows[places, 0],
            errors=system.errors[checks, 0],
        ),
        row_places=tuple(own[k] for k in places),
    )


@lru_cache(maxsize=256)
def implied_parts(group: Problem) -> tuple[Problem, ...]:
    """The parts of a group in the order of their solution, where rows that its branches imply take
    it apart: a platform's pose, say, then the passive joints of each limb. None of them where they
    do not.
    """
    if group.implied or group.closure.partition.geometry or is_tied(group):
        return ()
    candidates = with_implied(group, implied_rows_of(group))
    if not candidates.implied:
        return ()
    count, chosen = len(group.row_places), _independent_rows(candidates)
    kept = [row for k, row in enumerate(candidates.implied, start=count) if k in chosen]
    parts = _decomposed(with_implied(group, kept)) if kept else ()
    return parts if len(parts) > 1 else ()


@lru_cache(maxsize=256)
def is_tied(group: Problem) -> bool:
    """Whether a group's known values must satisfy conditions: its rows say more of them than they
    leave unknown.
    """
    system = group.system
    if system.rows.shape[0] <= system.freedom:
        return False
    values = np.array(closed_configurations(group.closure, 0))
    places = np.concatenate([group.unknown_places, group.known_places])
    free = system.freed(group.known_coordinates)
    jacobians = free.linearise(values[:, places])[1]
    whole = max(jacobians, key=lambda jacobian: Rank.of(jacobian).value)
    return Rank.of(whole).value > Rank.of(whole[:, : system.freedom]).value


def _decomposed(problem: Problem) -> tuple[Problem, ...]:
    found: list[Problem] = []
    earlier: list[Coordinate] = []
    for places in _parts(problem, dependence_of(problem.system.rows, problem.closure)):
        unknowns = tuple(problem.system.unknowns[i] for i in sorted(places))
        found.append(_part(problem, unknowns, earlier, _dependences(problem)))
        earlier += unknowns
    # rows of the one part that a problem is need no second look
    return (problem,) if [*map(_extent, found)] == [_extent(problem)] else tuple(found)


def _extent(part: Problem) -> tuple[object, ...]:
    """What a part holds of its problem."""
    system = part.system
    return system.unknowns, part.known_coordinates, part.row_places, system.errors.shape


@lru_cache(maxsize=128)
def _dependences(problem: Problem) -> tuple[list[set[str]], list[set[str]]]:
    """Names of the coordinates that each row and each closure error holds."""
    system, closure = problem.system, problem.closure
    rows, errors = (
        _held(dependence_of(part, closure), closure) for part in (system.rows, system.errors)
    )
    return rows, errors


def implied_rows_of(group: Problem, kept: Collection[str] = ()) -> list[PointRow | ProductRow]:
    """What each branch of a group says without the joints that no other branch holds, but for those
    that are `kept`, of one floating body at most, which is unknown.
    """
    closure, places = group.closure, group.row_places
    held = _held(dependence_of(group.system.rows, closure), closure)
    owners: dict[str, set[str]] = {}
    for place, names in zip(places, held, strict=True):
        for name in names:
            owners.setdefault(name, set()).add(closure.row_sources[place].limb)
    known = {c.name for c in group.known_coordinates}
    own = known | {c.name for c in group.system.unknowns}
    fixed = {c.name for c in closure.coordinates if c.body is not None and c.name in known}
    staying = known.union(kept)
    joints = [c.name for c in closure.coordinates if c.body is None and c.name not in staying]
    found = []
    for branch in dict.fromkeys(closure.row_sources[place].limb for place in places):
        gone = [name for name in joints if owners.get(name, {branch}) == {branch}]
        unknowns = (c.name for c in group.system.unknowns)
        left = {name for name in unknowns if branch in owners.get(name, ())} - set(gone)
        for row in implied_rows(closure, branch, gone) if left else []:
            names = coordinates_in(row.row, closure)
            if names <= own and not names & fixed:
                found.append(row)
    return found


def with_implied(problem: Problem, implied: Sequence[PointRow | ProductRow]) -> Problem:
    """The same problem with implied rows behind its own."""
    size, system = problem.closure.characteristic_length, problem.system
    more = [row.row / (2 * size) if row.is_sphere else row.row for row in implied]
    rows, errors = (ca.vertcat(part, *more) for part in (system.rows, system.errors))
    return replace(
        problem,
        system=replace(system, rows=rows, errors=errors),
        implied=tuple(implied),
    )


def _part(
    problem: Problem,
    unknowns: tuple[Coordinate, ...],
    earlier: Sequence[Coordinate],
    dependence: tuple[list[set[str]], list[set[str]]],
) -> Problem:
    closure = problem.closure
    found = {c.name: c for c in (*unknowns, *problem.known_coordinates, *earlier)}
    places, checks = (_rows_of(held, unknowns, found) for held in dependence)
    rows, errors = problem.system.rows[places, 0], problem.system.errors[checks, 0]
    rows, errors = (without_later(part, closure, found) for part in (rows, errors))
    held = coordinates_in(ca.vertcat(rows, errors), closure)
    known = tuple(c for name, c in found.items() if name in held and c not in unknowns)
    system = replace(
        problem.system,
        unknowns=unknowns,
        unknown=closure.symbols(unknowns),
        known=closure.symbols(known),
        rows=rows,
        errors=errors,
    )
    own = problem.row_places
    return replace(
        problem,
        system=system,
        known_coordinates=known,
        row_places=tuple(own[k] for k in places if k < len(own)),
        implied=tuple(problem.implied[k - len(own)] for k in places if k >= len(own)),
    )


@lru_cache(maxsize=256)
def is_linear(group: Problem) -> bool:
    """Whether a group's rows are linear in the unknowns, as those of couplings are: one solution,
    without a search.
    """
    system = group.system
    turning = any(c.is_rotation for c in system.unknowns)
    return not turning and not any(ca.which_depends(system.rows, system.unknown, 2, True))


def without_later(rows: ca.SX, closure: Closure, allowed: Collection[str]) -> ca.SX:
    """The same rows with the reference's values of coordinates that they hold with coefficients of
    rounding only.
    """
    held = coordinates_in(rows, closure)
    later = [c for c in closure.coordinates if c.name in held and c.name not in allowed]
    if not later:
        return rows
    values = np.concatenate([closure.reference[closure.slices[c.name]] for c in later])
    return ca.substitute(rows, closure.symbols(later), ca.SX(ca.DM(values)))


def coordinates_in(rows: ca.SX, closure: Closure) -> set[str]:
    """Names of the coordinates that rows hold."""
    owners = _owners(closure)
    held = (owners.get(symbol.element_hash()) for symbol in ca.symvar(rows))
    return {name for name in held if name is not None}


@lru_cache(maxsize=128)
def _owners(closure: Closure) -> dict[int, str]:
    """The coordinate of each symbol of a closure's variables."""
    names = [c.name for c in closure.coordinates for _ in range(c.width)]
    symbols = ca.vertsplit(closure.variables)
    return {s.element_hash(): name for s, name in zip(symbols, names, strict=True)}


def dependence_of(rows: ca.SX, closure: Closure) -> np.ndarray:
    """Which rows hold which numbers of the closure's variables (rows, variables); lengths are
    compared in sizes, as angles are.
    """
    values = random_points(closure.coordinates, closure.characteristic_length, _POINTS)
    jacobian = ca.Function("j", [closure.variables], [ca.jacobian(rows, closure.variables)])
    units = np.array(units_of(closure.coordinates, closure.characteristic_length))
    sizes = np.max([np.abs(np.asarray(jacobian(v))) for v in values], axis=0) * units
    return sizes > _ZERO * np.max(sizes, axis=1, keepdims=True, initial=1e-300)


def _held(dependence: np.ndarray, closure: Closure) -> list[set[str]]:
    """Names of the coordinates that each row holds, of the numbers (rows, variables) that it
    holds.
    """
    owner = np.repeat(np.arange(len(closure.coordinates)), [c.width for c in closure.coordinates])
    return [
        {closure.coordinates[k].name for k in set(owner[np.flatnonzero(line)].tolist())}
        for line in dependence
    ]


def _rows_of(
    dependence: Sequence[set[str]], unknowns: tuple[Coordinate, ...], allowed: Collection[str]
) -> list[int]:
    """Places of the rows that hold some of the unknowns and nothing that is found later."""
    own = {c.name for c in unknowns}
    return [
        k
        for k, held in enumerate(dependence)
        if held & own and all(name in allowed for name in held)
    ]


def _parts(problem: Problem, dependence: np.ndarray) -> list[set[int]]:
    """Places of unknowns, part by part in the order of solution. Where the rows leave unknowns
    free, those that rows tie to each other are one part.
    """
    system, slices = problem.system, problem.closure.slices
    if not system.unknowns:
        return []
    every = np.array([dependence[:, slices[c.name]].any(axis=1) for c in system.unknowns]).T
    tied = [set(np.flatnonzero(row).tolist()) for row in every]
    bodies = _bodies(system.unknowns)
    if not any(c.is_rotation for c in system.unknowns):
        # numbers of a platform that rows nowhere tie: its height, say
        alone = components(tied, len(system.unknowns))
        bodies = [body & part for body in bodies for part in alone if body & part]
    apart = components([*tied, *bodies], len(system.unknowns))
    if all(len(part) == 1 or part in bodies for part in apart):
        return apart
    columns = np.repeat(np.arange(len(system.unknowns)), [c.freedom for c in system.unknowns])
    independent = _independent_rows(problem)
    holds = every[independent][:, columns]
    match = _matching(holds) if len(independent) == system.freedom else None
    if match is None:
        return apart
    after = [
        {int(columns[j]) for j in np.flatnonzero(holds[match[column]])}
        for column in range(system.freedom)
    ]
    needs: list[set[int]] = [set() for _ in system.unknowns]
    for column, others in enumerate(after):
        needs[int(columns[column])] |= others
    for body in bodies:
        # the coordinates of a pose are found together
        for place in body:
            needs[place] |= body
    return _components(needs)


def _bodies(unknowns: tuple[Coordinate, ...]) -> list[set[int]]:
    """Places of the pose coordinates of each floating body."""
    found: dict[str, set[int]] = {}
    for place, c in enumerate(unknowns):
        if c.body is not None:
            found.setdefault(c.body, set()).add(place)
    return list(found.values())


def _closed_jacobian(problem: Problem) -> np.ndarray:
    """dF/dd (rows, freedoms) at a generic closed configuration, that of highest rank."""
    values = np.array(closed_configurations(problem.closure, 0))
    jacobians = problem.system.linearise(
        values[:, problem.unknown_places], values[:, problem.known_places]
    )[1]
    return max(jacobians, key=lambda jacobian: Rank.of(jacobian).value)


def _independent_rows(problem: Problem) -> np.ndarray:
    """Rows that span all of them, taken branch by branch, those of few unknowns first; each implied
    row is a branch of its own.
    """
    jacobian = _closed_jacobian(problem)
    sources = [problem.closure.row_sources[place].limb for place in problem.row_places]
    sources += [f"implied {k}" for k in range(len(problem.implied))]
    largest = float(singular_values(jacobian)[0]) or 1.0 if jacobian.size else 1.0
    kept = list[int]()
    for rows, columns in diagonal_parts(jacobian[None]) or [_whole(jacobian)]:
        for own, places in zip(rows, columns, strict=True):
            part = jacobian[np.ix_(own, places)] / largest
            kept += own[_spanning(part, [sources[k] for k in own])].tolist()
    return np.array(sorted(kept), dtype=int)


def _whole(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = matrix.shape
    return np.arange(rows)[None], np.arange(columns)[None]


def _spanning(jacobian: np.ndarray, sources: Sequence[str]) -> list[int]:
    """Rows, of a matrix whose largest singular value is 1 at most, that span all of them."""
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(sources):
        groups.setdefault(name, []).append(k)
    width = {
        name: int(np.any(jacobian[rows] != 0.0, axis=0).sum()) for name, rows in groups.items()
    }
    ordered = [groups[name] for name in sorted(groups, key=lambda n: width[n])]
    return independent_rows(jacobian, RANK_TOLERANCE, groups=ordered)


def _matching(holds: np.ndarray) -> list[int] | None:
    """A row for each column of a square pattern, None where there is none: the diagonal of its
    block triangular form.
    """
    pattern = ca.Sparsity.triplet(*holds.shape, *(places.tolist() for places in np.nonzero(holds)))
    _, rows, columns, _, _, coarse, _ = pattern.btf()
    # the coarse blocks before and after the well determined one are empty where every row has a
    # column
    if coarse[-1] - coarse[0] != len(holds) or coarse[1] > 0:
        return None
    return [row for _, row in sorted(zip(columns, rows, strict=True))]


def _components(needs: list[set[int]]) -> list[set[int]]:
    """Strongly connected components, each after those that it needs."""
    pairs = [
        (other, place) for place, others in enumerate(needs) for other in sorted(others | {place})
    ]
    # of a pattern's components casadi lists each before those that its rows hold
    places, ends = ca.Sparsity.triplet(
        len(needs), len(needs), *map(list, zip(*pairs, strict=True))
    ).scc()[1:]
    return [set(places[i:j]) for i, j in pairwise(ends)]
