"""Modes of mechanisms whose loops of redundant constraints close only to the digits of a file:
minima of the closure error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice, product

import numpy as np

from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.modes_result import Modes
from symkin.assembly.search import Search
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System, split_blocks
from symkin.position.determination import DIGITS, determination, is_least, misfit_note
from symkin.position.given import Given
from symkin.position.multistart import row_chunks
from symkin.position.problem import Problem
from symkin.position.roots import features, features_of, merge
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.position.starts import random_starts

_MOST_STARTS = 400
"""Random starts at most; a loop of redundant constraints has few modes."""
_SAME = 1e-4
"""Minima whose coordinates differ by less than this (rad, or times the size) are one."""


def with_least_modes(
    problem: Problem, givens: Sequence[Given], search: Search, found: list[Modes]
) -> list[Modes]:
    """The same modes of each input, or where there are none and the description's digits are why,
    those of least squares.
    """
    empty = [k for k, given in enumerate(givens) if not (found[k] or given.off_motion)]
    if not empty or not determination(problem).misfit:
        return found
    every = list(found)
    known = np.array([givens[k].values for k in empty])
    for k, points in zip(empty, _minima(problem, known, search), strict=True):
        listed = _listed(problem, givens[k], points)
        if len(listed):
            every[k] = _of_least_squares(problem, givens[k], search, every[k], listed)
    return every


def _of_least_squares(
    problem: Problem, given: Given, search: Search, found: Modes, listed: SolutionList
) -> Modes:
    note = misfit_note(problem, float(listed.residual.max()))
    return replace(
        found,
        modes=listed,
        completeness="sampled",
        complex_count=None,
        unresolved_paths=None,
        smallest_residual=None,
        groups=(),
        engine=None,
        starts=_starts(search),
        notes=(*given.notes, note),
    )


def _starts(search: Search) -> int:
    return min(_MOST_STARTS, search.starts)


def _minima(problem: Problem, known: np.ndarray, search: Search) -> list[np.ndarray]:
    """Minima (m, width) of the closure error at each row of known values (n, known): of parts that
    share no unknowns every combination, as many as there are starts at most.
    """
    system, most = problem.system, _starts(search)
    blocks = split_blocks(system)
    order = np.argsort(np.concatenate([_columns(system, block) for block in blocks]))
    found = []
    for rows in row_chunks(len(known), most):
        parts = [_block_minima(problem, block, known[rows], search) for block in blocks]
        for own in zip(*parts, strict=True):
            chosen = islice(product(*own), most)
            points = np.array([np.concatenate(choice) for choice in chosen])
            found.append(points.reshape(-1, system.width)[:, order])
    return found


def _columns(system: System, block: System) -> np.ndarray:
    """Where the unknowns of a block stand among those of its system."""
    places = [np.arange(system.width)[system.places[c.name]] for c in block.unknowns]
    return np.concatenate(places)


def _block_minima(
    problem: Problem, block: System, known: np.ndarray, search: Search
) -> list[np.ndarray]:
    """Distinct minima (m, width) of the error of one block at each row of known values, of those
    that close to the digits of a file.
    """
    size = block.characteristic_length
    # as many starts as the whole has, shared among its parts
    starts = -(-_starts(search) * block.freedom // problem.system.freedom)
    begin = [
        random_starts(problem, block, row, starts, np.random.default_rng(search.seed))
        for row in known
    ]
    every = np.repeat(known, starts, axis=0)
    ends = levenberg_marquardt(
        block, np.concatenate(begin), every, max_iterations=200, patience=30
    ).points
    kept = np.flatnonzero(np.isfinite(ends).all(axis=1))
    kept = kept[block.residuals(ends[kept], every[kept]) <= DIGITS * size]
    polished = block.polish_many(block.fold(ends[kept]), every[kept])
    # of ends at one minimum the lowest stands for it
    order = np.argsort(np.linalg.norm(polished.rows, axis=1), kind="stable")
    points, owner = polished.points[order], kept[order] // starts
    found = [points[owner == row] for row in range(len(known))]
    return [own[merge(features(block, own), _SAME * size)[0]] for own in found]


def _listed(problem: Problem, given: Given, points: np.ndarray) -> SolutionList:
    """The minima that are least squares of nothing but redundant rows, as they are listed."""
    system = problem.system
    every = np.tile(given.values, (len(points), 1))
    left = system.residuals(points, every)
    kept = [
        is_least(problem, given.values, z, float(residual))
        for z, residual in zip(points, left, strict=True)
    ]
    chosen = np.array(kept, dtype=bool)
    values = problem.join_values(points[chosen], every[chosen])
    solutions = checked_solutions(problem, values, given.notes)
    solutions = solutions.chosen(_distinct(problem, solutions.values))
    return solutions.chosen(order_of_modes(problem, solutions, np.zeros(len(solutions), dtype=int)))


def _distinct(problem: Problem, values: np.ndarray) -> list[int]:
    """The first of each set of configurations (m, variables) that are the same."""
    closure = problem.closure
    pairs = ((c, closure.slices[c.name]) for c in closure.coordinates)
    size = closure.characteristic_length
    return [int(k) for k in merge(features_of(pairs, values, size), _SAME * size)[0]]
