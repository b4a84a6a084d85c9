"""Judge polished points: which of them are roots, which two are one, and which stand for two.

In the direction v in which the Jacobian is weakest the rows are c + s t + k t^2 / 2, with its
smallest singular value s and a curvature k of about one over the size. Two roots are 2 s / k apart,
and between them the rows are s^2 / (2 k). Where there is no root, s^2 <= 2 k |rows| wherever one
looks, however small the rows are: so rows and s are judged together. What is within `rounding` is
zero, and two roots between which the rows are rounding are one, a double one.
"""

from __future__ import annotations

import numpy as np

from symkin.numeric.linear_algebra import extreme_singular_values, squared_norms
from symkin.numeric.newton import Polished
from symkin.numeric.rank import null_space
from symkin.numeric.shared_library import library_of_extremes
from symkin.numeric.system import System
from symkin.numeric.tolerances import (
    CLOSURE_ROUNDING,
    CLOSURE_TOLERANCE,
    SINGULAR_VALUE,
    SUSPECT_CONDITION,
)
from symkin.spatial.rotation import wrapped

POLISHING = 60
"""Newton steps for roots that are judged: near a double root each step halves the distance to
it.
"""
_CURVATURE = 8.0
"""Curvature, over the size, that rows hardly exceed: angles are lengths there, and no lever is
longer than the size.
"""
_DIRECTION_KNOWN = 1e-7
"""Smallest over largest singular value from which rounding of a Jacobian leaves its weakest
direction known.
"""
_SLOPES = 1e3
"""Redundant rows that contradict each other by some share of the size may have slopes that differ
by this many times it.
"""
NEARLY_SINGULAR = 1e-4
"""Smallest singular value below which another root may be nearer than 1e-4 of the size, or within
rounding.
"""
_ASIDE = 1e-4
"""Of the size: steps by which a curvature is measured."""
_LEAST_CURVATURE = 1e-3
"""Curvature, over the size, below which more than two roots meet where s vanishes."""


def rounding(system: System, points: np.ndarray) -> np.ndarray:
    """What the norm of the rows may be at roots (n,), by the size of the numbers that cancel in
    them, in the length unit.
    """
    size = system.characteristic_length
    long = np.abs(points[:, system.lengths]).max(axis=1, initial=0.0)
    scale = np.maximum(long, max(size, system.farthest))
    return np.minimum(CLOSURE_ROUNDING * scale, CLOSURE_TOLERANCE * size)


def are_roots(system: System, polished: Polished, residuals: np.ndarray) -> np.ndarray:
    """Which polished points (n,) with these closure errors `residuals` (n,) are roots.

    Their rows are rounding; or they are no more than `CLOSURE_TOLERANCE`, and all that is left of
    them is that redundant rows contradict each other by the digits of what is written, at a point
    that is regular for such an error.
    """
    size = system.characteristic_length
    found = residuals <= CLOSURE_TOLERANCE * size
    left = np.sqrt(squared_norms(polished.rows))
    doubtful = (found & ~(left <= rounding(system, polished.points))).nonzero()[0]
    if doubtful.size:
        found[doubtful] = _only_redundant_rows(
            polished.rows[doubtful], polished.jacobians[doubtful], size
        )
    return found


def is_root(system: System, point: np.ndarray, known: np.ndarray) -> bool:
    """Whether one polished point (width,) is a root."""
    if not system.freedom:
        return system.residual(point, known) <= CLOSURE_TOLERANCE * system.characteristic_length
    found = Polished(point[None], *system.linearise(point[None], known))
    return bool(are_roots(system, found, system.residuals(found.points, known))[0])


def _only_redundant_rows(rows: np.ndarray, jacobians: np.ndarray, size: float) -> np.ndarray:
    """Points (n,) at which no motion of the unknowns could lessen the rows, and none is nearly
    lost.
    """
    if min(jacobians.shape[1:]) == 0:
        return np.ones(len(rows), dtype=bool)
    left, singular, _ = np.linalg.svd(jacobians, full_matrices=False)
    within = np.linalg.norm(np.einsum("nij,ni->nj", left, rows), axis=1) / size
    share, least = np.linalg.norm(rows, axis=1) / size, singular[:, -1]
    is_known = least > np.maximum(_DIRECTION_KNOWN * singular[:, 0], _SLOPES * share)
    return np.asarray(is_known & (2.0 * _CURVATURE * within < least**2))


def are_suspect(extremes: np.ndarray) -> np.ndarray:
    """Which roots (n,) may be several in one, or of a continuum, by the largest and smallest
    singular values (n, 2) there: by their ratio, and by the smallest alone, since a block of one
    unknown has no other.
    """
    largest, smallest = extremes.T
    return ~((largest < SUSPECT_CONDITION * smallest) & (smallest >= SINGULAR_VALUE))


def suspects(jacobians: np.ndarray) -> np.ndarray:
    """Which roots (n,) `are_suspect`, by their Jacobians (n, rows, freedom). Where singular values
    are dear most are cleared by Frobenius's norms of these and of their inverses, which are no
    smaller.
    """
    if library_of_extremes(jacobians) is not None:
        return are_suspect(extreme_singular_values(jacobians))
    found = np.ones(len(jacobians), dtype=bool)
    if len(jacobians) and jacobians.shape[1] == jacobians.shape[2]:
        try:
            inverse, square = squared_norms(np.linalg.inv(jacobians)), squared_norms(jacobians)
        except np.linalg.LinAlgError:
            pass
        else:
            found = ~(inverse * np.maximum(square, 1.0) < 0.5 * SUSPECT_CONDITION**2)
    if found.any():
        found[found] = are_suspect(extreme_singular_values(jacobians[found]))
    return found


def are_one(system: System, point: np.ndarray, others: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Which roots `others` (n, width) near the root `point` (width,) are the same to rounding: the
    rows halfway are no more.
    """
    middle = _halfway(system, point, others)
    here = np.linalg.norm(
        system.linearise(np.concatenate([point[None], others, middle]), known)[0], axis=1
    )
    n = len(others)
    misfit = np.maximum(here[0], here[1 : n + 1])
    return here[n + 1 :] <= np.maximum(rounding(system, middle), 2.0 * misfit)


def _halfway(system: System, point: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Points (n, width) between one (width,) and each of `others` (n, width), which are near it."""
    apart = others - point
    for c, place in zip(system.unknowns, system.slices, strict=True):
        if c.is_periodic:
            apart[:, place] = wrapped(apart[:, place])
        elif c.is_rotation:
            opposite = others[:, place] @ point[place] < 0.0
            apart[:, place] = (
                np.where(opposite[:, None], -others[:, place], others[:, place]) - point[place]
            )
    middle = point + 0.5 * apart
    return system.move(middle, np.zeros((len(middle), system.freedom)))


def are_double(system: System, points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Which roots (n,) at known values (n, known) stand for two or more that meet within rounding:
    s^2 / (2 k) is no more.
    """
    if not len(points) or not system.freedom:
        return np.zeros(len(points), dtype=bool)
    size = system.characteristic_length
    left, singular, right = np.linalg.svd(system.linearise(points, known)[1])
    if singular.shape[1] < system.freedom:
        return np.zeros(len(points), dtype=bool)
    weakest, step = left[:, :, system.freedom - 1], right[:, -1]
    slopes = [
        system.linearise(system.move(points, sign * _ASIDE * size * step), known)[1]
        for sign in (1.0, -1.0)
    ]
    bent = np.einsum("ni,nij,nj->n", weakest, slopes[0] - slopes[1], step) / (2.0 * _ASIDE)
    depth = singular[:, -1] ** 2 * size / (2.0 * np.maximum(np.abs(bent), _LEAST_CURVATURE))
    return depth <= rounding(system, points)


def lost_directions(jacobian: np.ndarray, share: float) -> np.ndarray:
    """Unit tangent steps (n, freedom), both ways, in which a Jacobian loses its rank: singular
    values below a share of the largest, at least the smallest; with several, mixtures of them too.
    """
    lost = null_space(jacobian, share, relative=True, least=1)
    mixed = np.random.default_rng(0).normal(size=(4 * len(lost), len(lost))) @ lost
    return np.vstack([lost, -lost, mixed / np.linalg.norm(mixed, axis=1, keepdims=True)])
