"""Roots on parts of a closure that loops of the known values do not connect.

The pairs (z, k) that satisfy F(z, k) = 0 may fall into several components: a limb that closes in
two ways whatever the known values are, say. Loops stay on the component where they begin. Here
points are drawn on all of them, complex ones by Newton's method and real ones by least squares,
known values free in both, and each is carried to the base of a start.
"""

from __future__ import annotations

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem, first_of_each
from symkin.homotopy.monodromy import Fibre, roots_beside
from symkin.homotopy.seeds import Points, carried, regular, seed_roots
from symkin.homotopy.values import algebraic_points, known_values
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.position.problem import Problem
from symkin.position.starts import random_starts

COMPLEX_POINTS, REAL_POINTS = 32, 32
"""Points drawn: a component that attracts a share p of them is missed with probability (1 - p)^64,
1 % at p = 0.07.
"""
_REAL_STARTS = 96


def roots_elsewhere(
    problem: Problem,
    system: AlgebraicSystem,
    points: Points,
    rank: int,
    start: Fibre,
    seed: int,
) -> np.ndarray:
    """Roots (width, n) at the start's base that it lacks and points anywhere on the closure lead
    to, some more than once: a search from them unites equal ones.
    """
    rng = np.random.default_rng([seed, 1])
    drawn = (
        seed_roots(system, points, rng, rank, COMPLEX_POINTS),
        real_roots(problem, system, rng),
    )
    z, k = (np.hstack(parts) for parts in zip(*drawn, strict=True))
    return roots_beside(system, start, z, k)


def real_seeds(
    problem: Problem,
    system: AlgebraicSystem,
    points: Points,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Roots (width, n) at a random complex base, and this: closed configurations carried there.
    Rows that are redundant at closed configurations alone, as those of Bennett's linkage are, have
    no other points near which Newton's method finds a root.
    """
    z, k = real_roots(problem, system, rng)
    if not z.shape[1]:
        return None
    base = points(rng, True)[1]
    ends = carried(system, z, k, base)
    return (ends[:, first_of_each(system, ends)], base) if ends.shape[1] else None


def real_roots(
    problem: Problem, system: AlgebraicSystem, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Regular closed configurations z (width, n) with known values k (known, n), from starts
    anywhere, known coordinates free as well.
    """
    free = problem.system.freed(problem.known_coordinates)
    reference = problem.select_values(problem.closure.reference, problem.known_coordinates)
    starts = random_starts(problem, free, reference, _REAL_STARTS, rng)
    batch = levenberg_marquardt(free, starts, np.zeros(0))
    points = batch.points[batch.converged][:REAL_POINTS]
    z = algebraic_points(problem, system, free, points)
    k = known_values(problem, points[:, problem.system.width :].T).astype(complex)
    good = regular(system, z, k)
    return z[:, good], k[:, good]
