"""Points from which loci are traced: random closed configurations over the plane, brought onto the curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.position.levenberg import levenberg_marquardt
from symkin.singularities.curve import correct
from symkin.singularities.locus_system import LocusSystem

_RADII = (0.1, 0.5, 3.0)
"""Random steps off the configuration, of the size: the same mode, its neighbours, anywhere."""
_NULL = 1e-9
"""A smallest singular value of J below this is zero."""
_CLOSED = 1e-8
"""A start is closed when no row exceeds this times the size; the curve's own correction follows."""


@dataclass(frozen=True, eq=False)
class Seeds:
    """Points of the curves in the window, how many starts closed the loops, and whether J has a null vector at most of them:
    then the mechanism moves so everywhere, and there are no curves."""

    points: list[np.ndarray]
    closed: int
    everywhere: bool


def seeds_of(system: LocusSystem, window: np.ndarray, starts: int, rng: np.random.Generator) -> Seeds:
    """Seeds from random closed configurations over the window (inside units)."""
    closed = _closed_starts(system, window, starts, rng)
    if not len(closed):
        return Seeds([], 0, False)
    lifted, smallest = zip(*(system.lift(z) for z in closed), strict=True)
    if float(np.median(smallest)) < _NULL:
        return Seeds([], len(closed), True)
    batch = levenberg_marquardt(system.curve, np.array(lifted), np.zeros(0), max_iterations=60, tolerance=1e-10)
    points = []
    for z in batch.points[batch.converged]:
        point = correct(system.curve, system.curve.fold(system.curve.unit(z)[None])[0])
        if point is not None:
            point[system.uv] = _towards(system, point[system.uv], window)
            points.extend([point] if inside(point[system.uv], window) else [])
    return Seeds(points, len(closed), False)


def inside(uv: np.ndarray, window: np.ndarray) -> bool:
    return bool(np.all(uv >= window[:, 0]) and np.all(uv <= window[:, 1]))


def _closed_starts(system: LocusSystem, window: np.ndarray, starts: int, rng: np.random.Generator) -> np.ndarray:
    """Closed configurations (n, width of free coordinates, u, v) from random steps off the plane's configuration."""
    part = system.closed
    begin = np.tile(system.centre, (starts, 1))
    radii = np.resize(_RADII, starts)[:, None] * part.size
    begin = part.move(begin, radii * rng.normal(size=(starts, part.freedom)))
    begin[:, system.uv] = rng.uniform(window[:, 0], window[:, 1], (starts, 2))
    if not part.rows.shape[0]:
        return begin
    batch = levenberg_marquardt(part, begin, np.zeros(0), max_iterations=60)
    ends = part.fold(batch.points[batch.converged])
    return np.array([z for z in ends if part.residual(part.unit(z), np.zeros(0)) <= _CLOSED * part.size])


def _towards(system: LocusSystem, uv: np.ndarray, window: np.ndarray) -> np.ndarray:
    """Angles of the plane that lie outside the window, moved by whole turns towards it."""
    turned = uv.copy()
    for k, (c, (low, high)) in enumerate(zip(system.plane.coordinates, window, strict=True)):
        if c.kind == "angle" and not low <= uv[k] <= high:
            turned[k] = low + np.remainder(uv[k] - low, 2 * np.pi)
    return turned
