"""Decompose a problem into structure groups: parts that are solved one after another (Assur groups).

The rows' derivatives at random points show which rows hold which unknowns; at closed configurations such a derivative may vanish
because of the assembly (the bar of a parallelogram stays level). Of each branch's rows a set is kept that is independent at generic
closed configurations; Dulmage and Mendelsohn's decomposition of what is left, a matching of rows and unknowns and the strongly
connected components of the graph that it makes, is the block triangular form. In kinematics its blocks are Assur groups. All rows
of a block, redundant ones included, go with it.

Source: A. L. Dulmage, N. S. Mendelsohn, Coverings of bipartite graphs, Canadian J. Math. 10 (1958) 517-534.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, random_values
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate
from symkin.numeric.rank import Rank
from symkin.numeric.system import System
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations
from symkin.position.problem import Problem

_POINTS = 3
"""Random points at which derivatives are looked at: one that vanishes at all of them is zero."""
_ZERO = 1e-9
"""Derivative, over the largest of its row, that is zero to rounding."""


@lru_cache(maxsize=128)
def structure_groups(problem: Problem) -> tuple[Problem, ...]:
    """The parts of a problem in the order of their solution, each a problem of its own: unknown are its coordinates, known those
    of the given ones and of earlier parts that its rows hold."""
    rows, errors = (dependence_of(part, problem.closure) for part in (problem.system.rows, problem.system.errors))
    found: list[Problem] = []
    for places in _parts(problem, rows):
        unknowns = tuple(problem.system.unknowns[i] for i in sorted(places))
        earlier = tuple(c for part in found for c in part.system.unknowns)
        found.append(_part(problem, unknowns, earlier, (rows, errors)))
    return tuple(found)


def _part(
    problem: Problem,
    unknowns: tuple[Coordinate, ...],
    earlier: tuple[Coordinate, ...],
    dependence: tuple[np.ndarray, np.ndarray],
) -> Problem:
    closure = problem.closure
    stacked = {c.name: closure.variables[closure.slices[c.name]] for c in closure.coordinates}
    allowed = {c.name for c in (*unknowns, *earlier, *problem.known_coordinates)}
    places, checks = (_rows_of(held, closure, unknowns, allowed) for held in dependence)
    rows, errors = problem.system.rows[places, 0], problem.system.errors[checks, 0]
    rows, errors = (without_later(part, closure, allowed) for part in (rows, errors))
    held = ca.vertcat(rows, errors)
    known = tuple(
        c for c in (*problem.known_coordinates, *earlier) if ca.which_depends(held, stacked[c.name], 1, True).count(True)
    )
    system = System(
        unknowns,
        ca.vertcat(*(stacked[c.name] for c in unknowns)),
        ca.vertcat(ca.SX(0, 1), *(stacked[c.name] for c in known)),
        rows,
        errors,
        closure.characteristic_length,
        closure.mechanism.farthest,
    )
    return replace(problem, kind="given", system=system, known_coordinates=known, row_places=tuple(places))


@lru_cache(maxsize=256)
def is_linear(group: Problem) -> bool:
    """Whether a group's rows are linear in the unknowns, as those of couplings are: one solution, without a search."""
    system = group.system
    turning = any(c.kind == "quaternion" for c in system.unknowns)
    return not turning and not any(ca.which_depends(system.rows, system.unknown, 2, True))


def without_later(rows: ca.SX, closure: Closure, allowed: Collection[str]) -> ca.SX:
    """The same rows with the reference's values of coordinates that they hold with coefficients of rounding only."""
    later = [c for c in closure.coordinates if c.name not in allowed]
    if not later:
        return rows
    symbols = ca.vertcat(*(closure.variables[closure.slices[c.name]] for c in later))
    values = np.concatenate([closure.reference[closure.slices[c.name]] for c in later])
    return ca.substitute(rows, symbols, ca.SX(ca.DM(values)))


def dependence_of(rows: ca.SX, closure: Closure) -> np.ndarray:
    """Which rows hold which numbers of the closure's variables (rows, variables)."""
    rng = np.random.default_rng(0)
    values = [random_values(closure.coordinates, closure.characteristic_length, rng) for _ in range(_POINTS)]
    jacobian = ca.Function("j", [closure.variables], [ca.jacobian(rows, closure.variables)])
    # derivatives by angles are lengths: those by lengths become so too, so that a small machine has the rows of a large one
    unit = np.array(
        [closure.characteristic_length if c.kind == "length" else 1.0 for c in closure.coordinates for _ in range(c.width)]
    )
    sizes = np.max([np.abs(np.asarray(jacobian(v))) for v in values], axis=0) * unit
    return np.asarray(sizes > _ZERO * np.max(sizes, axis=1, keepdims=True, initial=1e-300))


def _rows_of(dependence: np.ndarray, closure: Closure, unknowns: tuple[Coordinate, ...], allowed: set[str]) -> list[int]:
    """Places of the rows that hold some of the unknowns and nothing that is found later."""
    own = {c.name for c in unknowns}
    kept: list[int] = []
    for k, line in enumerate(dependence):
        held = {c.name for c in closure.coordinates if line[closure.slices[c.name]].any()}
        if held & own and held <= allowed:
            kept.append(k)
    return kept


def _parts(problem: Problem, dependence: np.ndarray) -> list[set[int]]:
    """Places of unknowns, part by part in the order of solution; one part where the rows leave unknowns free."""
    system, slices = problem.system, problem.closure.slices
    if not system.unknowns:
        return []
    columns = np.repeat(np.arange(len(system.unknowns)), [c.freedom for c in system.unknowns])
    independent = _independent_rows(problem, _closed_jacobian(problem))
    if len(independent) != system.freedom:
        return [set(range(len(system.unknowns)))]
    holds = np.array([dependence[independent, slices[system.unknowns[k].name]].any(axis=1) for k in columns]).T
    match = _matching(holds)
    if match is None:
        return [set(range(len(system.unknowns)))]
    after = [{int(columns[j]) for j in np.flatnonzero(holds[match[column]])} for column in range(system.freedom)]
    needs: list[set[int]] = [set() for _ in system.unknowns]
    for column, others in enumerate(after):
        needs[int(columns[column])] |= others
    for body in _bodies(system.unknowns):
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
    jacobians = problem.system.linearise(values[:, problem.unknown_places], values[:, problem.known_places])[1]
    return np.asarray(max(jacobians, key=lambda jacobian: Rank.of(jacobian).value))


def _independent_rows(problem: Problem, jacobian: np.ndarray) -> np.ndarray:
    """Rows that span all of them, taken branch by branch, those of few unknowns first."""
    sources = [f"{row.limb}" for row in problem.closure.row_sources]
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(sources):
        groups.setdefault(name, []).append(k)
    width = {name: int(np.any(jacobian[rows] != 0.0, axis=0).sum()) for name, rows in groups.items()}
    basis, kept = np.zeros((0, jacobian.shape[1])), list[int]()
    largest = float(np.linalg.norm(jacobian, 2)) or 1.0
    for name in sorted(groups, key=lambda n: width[n]):
        left = {k: jacobian[k] - basis.T @ (basis @ jacobian[k]) for k in groups[name]}
        while left:
            best = max(left, key=lambda k: float(np.linalg.norm(left[k])))
            length = float(np.linalg.norm(left[best]))
            if length <= RANK_TOLERANCE * largest:
                break
            unit = left.pop(best) / length
            unit -= basis.T @ (basis @ unit)
            unit /= np.linalg.norm(unit)
            basis, kept = np.vstack([basis, unit]), [*kept, best]
            left = {k: row - unit * (unit @ row) for k, row in left.items()}
    return np.array(sorted(kept), dtype=int)


def _matching(holds: np.ndarray) -> list[int] | None:
    """A row for each column (augmenting paths), None where there is none."""
    row_of: list[int] = [-1] * holds.shape[1]

    def augment(row: int, seen: set[int]) -> bool:
        for column in np.flatnonzero(holds[row]).tolist():
            if column in seen:
                continue
            seen.add(column)
            if row_of[column] < 0 or augment(row_of[column], seen):
                row_of[column] = row
                return True
        return False

    return row_of if all(augment(row, set()) for row in range(holds.shape[0])) else None


def _components(needs: list[set[int]]) -> list[set[int]]:
    """Strongly connected components (Tarjan 1972), each after those that it needs."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    found: list[set[int]] = []

    def visit(v: int) -> None:
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in sorted(needs[v]):
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            part: set[int] = set()
            while v not in part:
                part.add(stack.pop())
            found.append(part)

    for v in range(len(needs)):
        if v not in index:
            visit(v)
    return found
