"""A body that six distances hold, wherever they come from: its rows are those of the universal
system of six distances.

In Study coordinates x = (e, g) a row s (|2 g + e m - b e|^2 - L^2 |e|^2) is a quadratic form. Its
derivatives by e and g are linear in the points b and m, those by e alone then give the length L. So
the points and lengths of a block's rows are found as functions of its known values, a moving base's
pose among them.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import DISTANCES, universal_system

_RAY = 8
"""Numbers of a pose in Study coordinates."""


def distances_of(system: AlgebraicSystem) -> ca.SX | None:
    """L, b and m of each of six rows (42 numbers, in units of the size) as an expression of the
    known values; None where the block is no body in Study coordinates alone. Whether the rows are
    distances is for the caller to see.
    """
    if system.unknowns or len(system.projective) != _RAY or system.count != DISTANCES + 1:
        return None
    # the last row is e.g = 0
    rows = system.rows[:DISTANCES]
    origin = ca.SX.zeros(_RAY, 1)
    hessians = [
        ca.substitute(ca.hessian(rows[i], system.z)[0], system.z, origin) for i in range(DISTANCES)
    ]
    # a row that does not hold the position's square is no distance
    if any(hessian[4, 4].is_zero() for hessian in hessians):
        return None
    return ca.vertcat(*(_distance(hessian) for hessian in hessians))


@lru_cache(maxsize=16)
def universal_system_of(body: str) -> AlgebraicSystem:
    """The system of six distances, whose roots are poses of the named body."""
    return replace(universal_system(), body=body)


def _distance(hessian: ca.SX) -> ca.SX:
    """L, b, m of one row from its second derivatives."""
    scale = hessian[4, 4] / _derivatives()[4, 4, 0]
    mixed = ca.vec(hessian[:4, 4:]) / scale
    points = ca.mtimes(ca.sparsify(ca.DM(_points_from_mixed())), mixed)
    b, m = points[:3], points[3:]
    # for e = 1, g = 0 the row is |m - b|^2 - L^2 over two, and so is half the second derivative by
    # e1
    return ca.vertcat(ca.sqrt(ca.sumsqr(m - b) - hessian[0, 0] / scale), b, m)


@lru_cache(maxsize=1)
def _points_from_mixed() -> np.ndarray:
    """Matrix (6, 16) that takes the derivatives by e and g, column by column, to b and m."""
    along = _derivatives()[:4, 4:]
    return np.linalg.pinv(np.stack([along[:, :, k + 1].ravel(order="F") for k in range(6)], axis=1))


@lru_cache(maxsize=1)
def _derivatives() -> np.ndarray:
    """Second derivatives (8, 8, 7) of the universal system's first distance for L = 0: with b = m =
    0, and what unit points add to those by e and g.
    """
    system = universal_system()
    evaluate = ca.Function("h", [system.k], [ca.hessian(system.rows[1], system.z)[0]])
    found = []
    for place in (None, *range(1, 7)):
        k = np.zeros(system.k.shape[0])
        if place is not None:
            k[place] = 1.0
        found.append(np.asarray(evaluate(k)))
    base = found[0]
    return np.stack([base, *(h - base for h in found[1:])], axis=2)
