"""Closed configurations of a mechanism beside its reference."""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION

_STARTS, _FEW_STARTS, _MANY_FREEDOMS = 8, 2, 40
"""Random steps of each of three lengths; of a graph of many freedoms, whose single steps take long, fewer."""


def whole_system(closure: Closure) -> System:
    """The closure with every coordinate unknown."""
    rows, errors = closure.bound(closure.rows), closure.bound(closure.errors)
    return System(closure.coordinates, closure.variables, ca.SX(0, 1), rows, errors, closure.characteristic_length)


def closed_configurations(closure: Closure, seed: int) -> list[np.ndarray]:
    """Closed configurations from random steps off the reference; the reference itself where none closes."""
    system, nothing = whole_system(closure), np.zeros(0)
    ends = least_squares_ends(closure, seed)
    closed = list(ends[system.residuals(ends, nothing) <= CLOSED_CONFIGURATION * closure.characteristic_length])
    return closed or [closure.reference]


def least_squares_ends(closure: Closure, seed: int) -> np.ndarray:
    """Where least squares from random steps off the reference end: closed configurations (n, width), and for graphs those that are
    closed to the digits of a file, or to none."""
    system = whole_system(closure)
    rng = np.random.default_rng(seed)
    each = _FEW_STARTS if closure.mechanism.is_graph and system.freedom > _MANY_FREEDOMS else _STARTS
    begin = np.tile(closure.reference, (3 * each, 1))
    radii = np.repeat([0.03, 0.1, 0.3], each)[:, None] * closure.characteristic_length
    starts = system.move(begin, radii * rng.normal(size=(3 * each, system.freedom)))
    nothing = np.zeros(0)
    batch = levenberg_marquardt(system, starts, nothing, max_iterations=200)
    kept = batch.points if closure.mechanism.is_graph else batch.points[batch.converged]
    return system.polish_many(kept, nothing).points
