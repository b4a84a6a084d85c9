"""Candidates for real roots of one block at many instances: polished, checked on all rows, told
apart.
"""

from __future__ import annotations

import numpy as np

from symkin.computed_once import lru_cache
from symkin.numeric.newton import polish
from symkin.numeric.root_checks import POLISHING, are_roots, suspects
from symkin.numeric.system import System
from symkin.numeric.tolerances import DISTINCT_ROOTS
from symkin.position.canonical import canonical
from symkin.position.roots import features

_FEW = 64
"""Roots of one instance up to which each is held against each other."""


def checked_roots(
    block: System,
    points: np.ndarray,
    owner: np.ndarray,
    known: np.ndarray,
    plain: np.ndarray,
    judged: tuple[np.ndarray, ...] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Points (m, width) near real roots of the instances `owner` (m,), rising, polished on the
    block's own rows: those that close on all rows, written in the standard way, and their places
    among the given ones, which may have been `judged`. Instances (n,) with roots that are badly
    conditioned or equal are no longer `plain`.
    """
    here = known[owner]
    rows, jacobians, residuals = block.judge(points, here) if judged is None else judged
    polished = polish(block, points, here, POLISHING, begun=(rows, jacobians))
    moved = (polished.points != points).any(axis=1).nonzero()[0]
    if moved.size:
        residuals[moved] = block.residuals(polished.points[moved], here[moved])
    points = canonical(block.unknowns, block.places, polished.points)
    closed = are_roots(block, polished, residuals).nonzero()[0]
    points, owner = points[closed], owner[closed]
    plain[owner[suspects(polished.jacobians[closed])]] = False
    plain[_owners_of_equal(block, points, owner)] = False
    return points, closed


def _owners_of_equal(block: System, points: np.ndarray, owner: np.ndarray) -> list[int]:
    """Instances with two roots that are not distinct (see `roots.unite`).

    Roots differ where a combination of their features does by more than the sum of its weights
    times the tolerance; sorted by one, nearly all instances are told by neighbours alone.
    """
    if len(points) < 2:
        return []
    f = features(block, points)
    if owner[0] == owner[-1] and len(f) <= _FEW:
        return [int(owner[0])] if _has_equal(block, f) else []
    weights = _weights(f.shape[1])
    mixed = f @ weights
    order = np.lexsort((mixed, owner))
    sorted_owner, gap = owner[order], np.diff(mixed[order])
    near = (sorted_owner[1:] == sorted_owner[:-1]) & ~(
        gap > DISTINCT_ROOTS * block.characteristic_length * float(np.sum(np.abs(weights)))
    )
    return [
        i
        for i in np.flatnonzero(np.bincount(sorted_owner[1:][near])).tolist()
        if _has_equal(block, f[owner == i])
    ]


@lru_cache(maxsize=64)
def _weights(count: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, count)


def _has_equal(block: System, f: np.ndarray) -> bool:
    """Whether two of some roots' features (m, any) are one."""
    apart = np.max(np.abs(f[:, None] - f[None]), axis=2)
    return bool(np.sum(apart <= DISTINCT_ROOTS * block.characteristic_length) > len(f))
