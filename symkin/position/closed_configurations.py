"""Closed configurations of a mechanism beside its reference."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION

_STARTS, _FEW_STARTS, _MANY_FREEDOMS = 8, 2, 40
"""Random steps of each of three lengths; of a mechanism of many freedoms, whose single steps take long, fewer."""


@lru_cache(maxsize=128)
def whole_system(closure: Closure) -> System:
    """The closure with every coordinate unknown."""
    rows, errors = closure.bound(closure.rows), closure.bound(closure.errors)
    return System(closure.coordinates, closure.variables, ca.SX(0, 1), rows, errors, closure.characteristic_length)


def closed_configurations(closure: Closure, seed: int) -> list[np.ndarray]:
    """Closed configurations from random steps off the reference; the reference itself where none closes."""
    ends = least_squares_ends(closure, seed)
    return list(ends.points[ends.closed]) or [closure.reference]


@dataclass(frozen=True, eq=False)
class LeastSquaresEnds:
    """Where least squares from random steps off the reference end: variables (n, width), what each leaves the loops open by (length
    unit), and which of them are closed configurations."""

    points: np.ndarray
    misfits: np.ndarray
    closed: np.ndarray


def least_squares_ends(closure: Closure, seed: int) -> LeastSquaresEnds:
    """Least squares on all rows from random steps of three lengths off the reference."""
    system = whole_system(closure)
    rng = np.random.default_rng(seed)
    each = _FEW_STARTS if system.freedom > _MANY_FREEDOMS else _STARTS
    begin = np.tile(closure.reference, (3 * each, 1))
    radii = np.repeat([0.03, 0.1, 0.3], each)[:, None] * closure.characteristic_length
    starts = system.move(begin, radii * rng.normal(size=(3 * each, system.freedom)))
    nothing = np.zeros(0)
    batch = levenberg_marquardt(system, starts, nothing, max_iterations=200)
    points = system.polish_many(batch.points, nothing).points
    misfits = system.residuals(points, nothing)
    closed = batch.converged & (misfits <= CLOSED_CONFIGURATION * closure.characteristic_length)
    return LeastSquaresEnds(points, misfits, closed)
