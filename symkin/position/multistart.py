"""Roots from varied initial guesses.

All starts of a block run at once through one mapped function; roots are merged modulo whole turns
and quaternion sign and counted. Nothing here knows when all roots are found: the counts give an
estimate of how many are still unseen (Chao
1984) and how likely the next hit is a new one (Good 1953).
"""

from __future__ import annotations

import logging

import numpy as np

from symkin.errors import InputError
from symkin.numeric.levenberg import Progress, levenberg_marquardt, patiently
from symkin.numeric.system import System
from symkin.position.least_squares import LeastSquares
from symkin.position.newton import Newton
from symkin.position.problem import Problem
from symkin.position.roots import Sample, distinct
from symkin.position.solve import SOLVERS
from symkin.position.starts import random_starts
from symkin.text import not_among

DEFAULT_STARTS = 2000


LOG = logging.getLogger(__name__)


def batched(
    problem: Problem,
    known: np.ndarray,
    starts: int,
    rng: np.random.Generator,
    progress: Progress | None = None,
) -> Sample:
    """Roots of a problem that Levenberg-Marquardt on all rows reaches, all starts at once."""
    LOG.info("%d random starts", starts)
    system = problem.system
    points = random_starts(problem, system, known, starts, rng)
    batch = levenberg_marquardt(system, points, known, progress=progress)
    ends = batch.points[batch.converged]
    if not len(ends):
        return _no_roots(system, batch.points, batch.largest_row, known, starts)
    return distinct(system, ends, known, starts)


def _no_roots(
    system: System, points: np.ndarray, largest: np.ndarray, known: np.ndarray, starts: int
) -> Sample:
    """Refine the best ends, so that the smallest residual is that of a minimum."""
    order = np.argsort(np.where(np.isfinite(largest), largest, np.inf))[:16]
    batch = patiently(system, points[order], known)
    smallest = float(np.nanmin(system.residuals(batch.points, known)))
    return Sample.of_none(system, smallest, starts)


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
        if left <= 1e-6 * system.characteristic_length:
            ends.append(z)
        if progress is not None:
            progress(k, starts)
    if not ends:
        return Sample.of_none(system, smallest, starts)
    return distinct(system, np.array(ends), known, starts)
