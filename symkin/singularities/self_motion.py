"""Decide whether a mechanism moves while both coordinates of a plane are held; finite steps must
show it.

A locus that stands in one point of the plane may belong to a motion with both coordinates held, or
to curves that nearly touch, where the equations are too ill-conditioned for the next step.
Configurations z_0 ... z_n at finite steps along the null direction are brought to F(z_k, u, v) = 0
together, with one (u, v) for all of them; only where every row vanishes and the configurations stay
apart is there a motion.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from symkin.numeric.rank import null_space
from symkin.numeric.system import System
from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.singularities.curve import CORRECTED, distance
from symkin.singularities.locus_system import LocusSystem

_COUNT, _STEP = 6, 0.01
"""How many finite steps show a motion, and the length of each, of the size."""
_LEAST_DISTANCE = 0.5
"""Least distance of neighbours after the correction, of a step: an isolated configuration draws all
of them together.
"""
_MOST_DRIFT = 1e-5
"""Most that (u, v) may move in the correction, of the size: beyond, the motion belongs to another
point of the plane.
"""
_ITERATIONS = 15
"""Gauss-Newton steps of the correction of all configurations together."""


def has_self_motion(system: LocusSystem, z: np.ndarray) -> bool:
    """Whether from the curve's point z the free coordinates move over a finite length with one (u,
    v), every row of F below 1e-11 of the size at each step.
    """
    if not system.free:
        return False
    begin = z[: system.uv.stop]
    for sense in (1.0, -1.0):
        chain = _close_all(system.closed, _steps_along(system.closed, begin, sense))
        if chain is not None and _finite_motion(system, begin, chain):
            return True
    return False


def _steps_along(closed: System, begin: np.ndarray, sense: float) -> np.ndarray:
    """Configurations (n, width) at finite steps along the null direction with u and v held, roughly
    closed.
    """
    points, length = [begin], _STEP * closed.characteristic_length
    direction = sense * _null_space(closed, begin)[-1]
    for _ in range(_COUNT):
        z = _moved(closed, points[-1], length * direction)
        for _ in range(3):
            values, jacobian = closed.linearise_one(z, np.zeros(0))
            step = np.linalg.lstsq(jacobian[:, :-2], -values, rcond=SINGULAR_VALUE)[0]
            z = _moved(
                closed, z, step * min(1.0, length / max(float(np.linalg.norm(step)), length))
            )
        basis = _null_space(closed, z)
        ahead = basis.T @ (basis @ direction)
        direction = ahead / max(float(np.linalg.norm(ahead)), 1e-12)
        points.append(z)
    return np.array(points)


def _moved(closed: System, z: np.ndarray, step: np.ndarray) -> np.ndarray:
    """A step of the free coordinates alone."""
    return closed.move(z[None], np.append(step, [0.0, 0.0])[None])[0]


def _null_space(closed: System, z: np.ndarray) -> np.ndarray:
    """Orthonormal rows; the last one belongs to the smallest singular value, however large it
    is.
    """
    jacobian = closed.linearise_one(z, np.zeros(0))[1][:, :-2]
    return null_space(jacobian, SINGULAR_VALUE, relative=True, least=1)


def _close_all(closed: System, points: np.ndarray) -> np.ndarray | None:
    """Zeros of all rows at all points with one step of (u, v) for all of them, by least-norm
    Gauss-Newton; None where they are not reached.
    """
    count, freedom = len(points), closed.freedom - 2
    for _ in range(_ITERATIONS):
        values, jacobians = closed.linearise(points, np.zeros(0))
        if not (np.isfinite(values).all() and np.isfinite(jacobians).all()):
            return None
        if float(np.abs(values).max(initial=0.0)) <= CORRECTED * closed.characteristic_length:
            return points
        rows = values.shape[1]
        matrix = np.zeros((count * rows, count * freedom + 2))
        for k, jacobian in enumerate(jacobians):
            matrix[k * rows : (k + 1) * rows, k * freedom : (k + 1) * freedom] = jacobian[:, :-2]
            matrix[k * rows : (k + 1) * rows, -2:] = jacobian[:, -2:]
        step = np.linalg.lstsq(matrix, -values.ravel(), rcond=SINGULAR_VALUE)[0]
        shared = np.tile(step[-2:], (count, 1))
        points = closed.move(points, np.hstack([step[:-2].reshape(count, freedom), shared]))
    return None


def _finite_motion(system: LocusSystem, begin: np.ndarray, chain: np.ndarray) -> bool:
    closed, count = system.closed, len(system.free)
    steps = [distance(closed, a, b, count) for a, b in pairwise(chain)]
    length = _STEP * closed.characteristic_length
    scale = np.array([c.lever(closed.characteristic_length) for c in system.plane.coordinates])
    strayed = float(np.max(np.abs((chain[0] - begin)[system.uv] * scale)))
    reached = distance(closed, chain[-1], chain[0], count)
    return (
        min(steps) >= _LEAST_DISTANCE * length
        and reached >= 0.5 * _COUNT * _LEAST_DISTANCE * length
        and strayed <= _MOST_DRIFT * closed.characteristic_length
    )
