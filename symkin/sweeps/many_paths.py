"""Paths of many instances tracked in one call, and which instances need no more than that.

An instance is plain where every path arrives at a regular root of its own; `endgame.finish` decides the same for one
instance, and does what is to be done for others.
"""

from __future__ import annotations

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.circles import gaps, separations
from symkin.homotopy.engine import aligned, newton, track
from symkin.homotopy.local import is_no_pose
from symkin.homotopy.monodromy import Fibre

_PATHS_AT_ONCE = 1400
"""Paths that are tracked in one call: enough to fill vectors, few enough to stay in the cache."""
_BESIDE = 1e-7
"""Distance from a root at which a Newton step shows that it is well conditioned."""
_ONE = 1e-7
"""Distance below which two ends are one root, so that a path has jumped or the root is multiple."""


def plain_roots(system: AlgebraicSystem, start: Fibre, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roots (n, width, roots) of n instances with known values (known, n), and which of the instances are plain; the roots
    of others mean nothing."""
    each = max(1, _PATHS_AT_ONCE // max(1, start.z.shape[1]))
    count = known.shape[1]
    parts = [_group(system, start, known[:, i : i + each]) for i in range(0, count, each)]
    return np.concatenate([z for z, _ in parts]), np.concatenate([plain for _, plain in parts])


def _group(system: AlgebraicSystem, start: Fibre, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    mirrors, n = start.mirrors, known.shape[1]
    begin = start.z if mirrors is None else start.z[:, mirrors.first]
    each = begin.shape[1]
    target = aligned(system, start.k, np.asarray(known, dtype=complex))
    tracked = track(system, np.tile(begin, (1, n)), start.k, np.repeat(target, each, axis=1))
    ends = tracked.z.reshape(system.width, n, each).transpose(1, 0, 2)
    arrived = tracked.arrived.reshape(n, each).all(axis=1)
    if mirrors is not None:
        ends = np.stack([mirrors.unfold(z) for z in ends])
    plain = arrived & np.isfinite(ends).all(axis=(1, 2))
    places = np.flatnonzero(plain)
    if places.size:
        plain[places] = _are_regular(system, ends[places], target[:, places])
    return ends, plain


def _are_regular(system: AlgebraicSystem, ends: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Instances (n,) whose roots (n, width, roots) are well conditioned poses apart from each other: a Newton step from
    beside each leads back to it."""
    n, _, roots = ends.shape
    z = ends.transpose(1, 0, 2).reshape(system.width, n * roots)
    rng = np.random.default_rng(0)
    shift = _BESIDE * (rng.normal(size=(system.width, roots)) + 1j * rng.normal(size=(system.width, roots)))
    back, _ = newton(system, z + np.tile(shift, (1, n)), np.repeat(target, roots, axis=1), 1)
    good = (gaps(system, back, z) < 0.05 * _BESIDE) & ~is_no_pose(system, z)
    apart = np.array([separations(system, roots_of).min() > _ONE for roots_of in ends])
    return np.asarray(good.reshape(n, roots).all(axis=1) & apart)
