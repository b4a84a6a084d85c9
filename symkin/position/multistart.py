"""Roots from varied initial guesses.

All starts of a block run at once through one mapped function; roots are merged modulo whole turns
and quaternion sign and counted. Nothing here knows when all roots are found: the counts give an
estimate of how many are still unseen (Chao
1984) and how likely the next hit is a new one (Good 1953).
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.errors import InputError
from symkin.model.joint import Coordinate
from symkin.numeric.levenberg import Progress, levenberg_marquardt, patiently
from symkin.numeric.system import System
from symkin.position.least_squares import LeastSquares
from symkin.position.newton import Newton
from symkin.position.problem import Problem
from symkin.position.roots import Sample, distinct, unite
from symkin.position.solve import SOLVERS
from symkin.position.starts import random_starts, reach_at, turns_within
from symkin.spatial.rotation import wrapped
from symkin.text import not_among

DEFAULT_STARTS = 2000
_AT_ONCE = 4096
"""Starts of one batch, of several rows of known values together."""
_REFINED = 16
"""Ends of a row without a root that are refined."""

_END = 1e-6
"""Largest error over the size of an end that may become a root."""

LOG = logging.getLogger(__name__)


def row_chunks(rows: int, starts: int) -> list[slice]:
    """Rows of known values that are searched in one batch, from so many starts each."""
    each = max(1, _AT_ONCE // max(1, starts))
    return [slice(begin, begin + each) for begin in range(0, rows, each)]


def batched(problem: Problem, known: np.ndarray, starts: int, rng: np.random.Generator) -> Sample:
    """Roots of a problem that Levenberg-Marquardt on all rows reaches, all starts at once."""
    return batched_rows(problem, known[None], starts, [rng])[0]


def batched_rows(
    problem: Problem,
    known: np.ndarray,
    starts: int,
    rngs: Sequence[np.random.Generator],
    progress: Progress | None = None,
) -> list[Sample]:
    """As `batched`, at each row of known values (n, known), with random numbers of its own."""
    LOG.info("%d random starts", starts)
    return [
        sample
        for rows in row_chunks(len(known), starts)
        for sample in _samples(problem, known[rows], starts, rngs[rows], progress)
    ]


def _samples(
    problem: Problem,
    known: np.ndarray,
    starts: int,
    rngs: Sequence[np.random.Generator],
    progress: Progress | None,
) -> list[Sample]:
    system, n = problem.system, len(known)
    begin = [
        random_starts(problem, system, row, starts, rng)
        for row, rng in zip(known, rngs, strict=True)
    ]
    batch = levenberg_marquardt(
        system, np.concatenate(begin), np.repeat(known, starts, axis=0), progress=progress
    )
    points = batch.points.reshape(n, starts, -1)
    converged = batch.converged.reshape(n, starts)
    none = np.flatnonzero(~converged.any(axis=1))
    smallest = _smallest(
        system, points[none], batch.largest_row.reshape(n, starts)[none], known[none]
    )
    least = dict(zip(none.tolist(), smallest, strict=True))
    return [
        Sample.of_none(system, least[k], starts)
        if k in least
        else _reached(problem, points[k][converged[k]], known[k], starts)
        for k in range(n)
    ]


def _smallest(
    system: System, points: np.ndarray, largest: np.ndarray, known: np.ndarray
) -> list[float]:
    """The smallest residuals of rows without a root, their best ends refined so that these are of
    minima.
    """
    if not len(points):
        return []
    order = np.argsort(np.where(np.isfinite(largest), largest, np.inf), axis=1)[:, :_REFINED]
    best = np.take_along_axis(points, order[:, :, None], axis=1)
    every = np.repeat(known, order.shape[1], axis=0)
    ends = patiently(system, best.reshape(-1, best.shape[2]), every).points
    least = np.nanmin(system.residuals(ends, every).reshape(order.shape), axis=1)
    return [float(error) for error in least]


def one_by_one(
    problem: Problem,
    known: np.ndarray,
    starts: int,
    rng: np.random.Generator,
    solver: str | Newton | LeastSquares,
    progress: Progress | None,
) -> Sample:
    """Roots of the whole problem by a solver of `solve`, called once a start."""
    chosen = SOLVERS.get(solver) if isinstance(solver, str) else solver
    if chosen is None or not hasattr(chosen, "iterate"):
        raise InputError(f"solver = {not_among(solver, ['batched', *SOLVERS])}")
    system = problem.system
    ends, smallest = [], np.inf
    for k, start in enumerate(random_starts(problem, system, known, starts, rng), start=1):
        path = chosen.iterate(problem, start, known)
        z = system.wrap(system.unit(path[-1])) if np.all(np.isfinite(path[-1])) else path[-1]
        left = system.residual(z, known) if np.all(np.isfinite(z)) else np.inf
        smallest = min(smallest, left)
        if left <= _END * system.characteristic_length:
            ends.append(z)
        if progress is not None:
            progress(k, starts)
    if not ends:
        return Sample.of_none(system, smallest, starts)
    return _reached(problem, np.array(ends), known, starts)


def _reached(problem: Problem, ends: np.ndarray, known: np.ndarray, starts: int) -> Sample:
    """The roots that random starts have reached, and those to which screws lead from these."""
    found = distinct(problem.system, _listed(problem, ends, known), known, starts)
    return _with_next_turns(problem, found, known)


# --- angles whose whole turns count ---------------------------------------------------------------


def turning(problem: Problem) -> dict[str, tuple[float, float]]:
    """Limits of unknown angles whose whole turns count, for a coupling."""
    unknowns, advancing = problem.system.unknowns, problem.mechanism.advancing
    return {c.name: c.limits for c in unknowns if c.limits is not None and c.name in advancing}


def _listed(problem: Problem, points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The points, angles of `turning` beyond their limits within half a turn of the middle of these
    where that is a root as well: else it comes back turn by turn without end.
    """
    if not (limits := turning(problem)):
        return points
    system, moved = problem.system, points.copy()
    for name, (low, high) in limits.items():
        values, middle = moved[:, system.places[name]], 0.5 * (low + high)
        outside = (values < low) | (values > high)
        values[outside] = middle + wrapped(values[outside] - middle)
    error = system.residuals(moved, np.broadcast_to(known, (len(moved), len(known))))
    closed = error <= _END * system.characteristic_length
    return np.where(closed[:, None], moved, points)


# --- screws ---------------------------------------------------------------------------------------


def screws_of(problem: Problem) -> list[Coordinate]:
    """Unknown angles of screws: each turn on is another configuration, a pitch away."""
    pitches = problem.mechanism.pitches
    return [c for c in problem.system.unknowns if c.is_advancing and pitches.get(c.name)]


def _with_next_turns(problem: Problem, sample: Sample, known: np.ndarray) -> Sample:
    """The same with the roots to which a screw leads that is turned once on or back from one that
    is known, and so on from one end of the reach to the other, by as many starts as there were
    random ones: of these, few begin at each turn.
    """
    system, points, left = problem.system, sample.points, sample.starts
    last, turned = points, True
    while len(last) and (beside := _next_turns(problem, last, known)).size:
        left -= len(beside)
        if left < 0:
            turned = False
            break
        batch = levenberg_marquardt(system, beside, known)
        last = _others(system, points, batch.points[batch.converged], known, sample.continuum)
        points = np.concatenate([points, last])
    hits = np.append(sample.hits, np.zeros(len(points) - len(sample.points), dtype=int))
    return replace(sample, points=points, hits=hits, turned=turned)


def _next_turns(problem: Problem, points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Points with one screw each a turn on or back."""
    closure, reach, found = problem.closure, reach_at(problem, known), []
    for c in screws_of(problem):
        place, span = problem.system.places[c.name], turns_within(problem.mechanism, c, reach)
        middle = closure.reference[closure.slices[c.name]]
        for turn in (-2.0 * np.pi, 2.0 * np.pi):
            moved = points.copy()
            moved[:, place] += turn
            found.append(moved[(np.abs(moved[:, place] - middle) <= span).all(axis=1)])
    return np.concatenate([points[:0], *found])


def _others(
    system: System, points: np.ndarray, ends: np.ndarray, known: np.ndarray, continuum: bool
) -> np.ndarray:
    """Roots among some ends that are none of the `points` (n, width)."""
    if not len(ends):
        return ends
    n, found = len(points), distinct(system, ends, known, 0)
    both = np.concatenate([points, found.points])
    first, labels = unite(system, both, known, continuum_met=continuum or found.continuum)
    return both[first[~np.isin(labels[first], labels[:n])]]
