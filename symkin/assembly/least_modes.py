"""Modes of mechanisms whose loops of redundant constraints close only to the digits of a file:
minima of the closure error.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.modes_result import Modes
from symkin.assembly.search import Search
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.position.determination import determination, is_least, misfit_note
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.roots import features_of, merge
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.position.starts import random_starts

_MOST_STARTS = 400
"""Random starts at most; a loop of redundant constraints has few modes."""
_SAME = 1e-4
"""Minima whose coordinates differ by less than this (rad, or times the size) are one."""


def with_least_modes(problem: Problem, given: Given, search: Search, found: Modes) -> Modes:
    """The same modes, or where there are none and the description's digits are why, those of least
    squares.
    """
    if len(found) or not determination(problem).misfit or given.off_motion > 0.0:
        return found
    listed = _minima(problem, given, search)
    if not len(listed):
        return found
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


def _minima(problem: Problem, given: Given, search: Search) -> SolutionList:
    system = problem.system
    starts = random_starts(
        problem, system, given.values, _starts(search), np.random.default_rng(search.seed)
    )
    ends = levenberg_marquardt(system, starts, given.values, max_iterations=200, patience=30).points
    ends = system.polish_many(system.fold(ends[np.isfinite(ends).all(axis=1)]), given.values).points
    left = system.residuals(ends, given.values)
    kept = [
        z
        for z, residual in zip(ends, left, strict=True)
        if is_least(problem, given.values, z, float(residual))
    ]
    values = problem.join_values(
        np.array(kept).reshape(-1, system.width), np.tile(given.values, (len(kept), 1))
    )
    solutions = checked_solutions(problem, values, given.notes)
    solutions = solutions.chosen(_distinct(problem, solutions.values))
    return solutions.chosen(order_of_modes(problem, solutions, np.zeros(len(solutions), dtype=int)))


def _distinct(problem: Problem, values: np.ndarray) -> list[int]:
    """The first of each set of configurations (m, variables) that are the same."""
    closure = problem.closure
    pairs = ((c, closure.slices[c.name]) for c in closure.coordinates)
    size = closure.characteristic_length
    return [int(k) for k in merge(features_of(pairs, values, size), _SAME * size)[0]]
