"""Paths of many instances tracked in one call, and which instances need no more than that.

An instance is plain where every path arrives at a regular root of its own; `endgame.finish` decides
the same for one instance, and does what is to be done for others.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.endgame import are_well_conditioned, finish
from symkin.homotopy.ends import Ends
from symkin.homotopy.engine import aligned, track
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.point_checks import is_no_pose
from symkin.homotopy.symmetry import Orbits
from symkin.homotopy.tracker import Tracked

_PATHS_AT_ONCE = 1400
"""Paths that are tracked in one call: enough to fill vectors, few enough to stay in the cache."""
Proves = Callable[[np.ndarray], np.ndarray]
"""Which instances (n,) a theorem proves to have no roots but those (n, width, roots), all regular
and different.
"""
APART = 1e-5
"""Distance of two ends (see `nearest`) above which they are two roots, whatever is asked of them:
equal roots are told by 1e-6.
"""


def instances_at_once(start: Fibre) -> int:
    """How many instances are tracked in one call."""
    return max(1, _PATHS_AT_ONCE // max(1, start.z.shape[1]))


def plain_instances(
    system: AlgebraicSystem, start: Fibre, known: np.ndarray, proves: Proves | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Roots (n, width, roots) of n instances with known values (known, n), and which of the
    instances are plain; the roots of others mean nothing. Those that a theorem `proves` need no
    other look.
    """
    each, count = instances_at_once(start), known.shape[1]
    parts = [_group(system, start, known[:, i : i + each], proves) for i in range(0, count, each)]
    if len(parts) == 1:
        return parts[0]
    return np.concatenate([z for z, _ in parts]), np.concatenate([plain for _, plain in parts])


def _group(
    system: AlgebraicSystem, start: Fibre, known: np.ndarray, proves: Proves | None
) -> tuple[np.ndarray, np.ndarray]:
    mirrors, n = start.mirrors, known.shape[1]
    begin = start.z if mirrors is None else start.z[:, mirrors.first]
    each = begin.shape[1]
    target = aligned(system, start.k, np.asarray(known, dtype=complex))
    if n == 1:
        tracked = track(system, begin, start.k, target[:, 0])
    else:
        tracked = track(system, np.tile(begin, (1, n)), start.k, np.repeat(target, each, axis=1))
    plain = tracked.arrived.reshape(n, each).all(axis=1)
    plain &= np.isfinite(tracked.z).all(axis=0).reshape(n, each).all(axis=1)
    ends = tracked.z.reshape(system.width, n, each).transpose(1, 0, 2)
    if mirrors is not None:
        ends = _unfolded(mirrors, ends)
    if proves is not None and plain.all() and proves(ends).all():
        return ends, plain
    places = plain.nonzero()[0]
    if places.size:
        # by symmetry what holds of roots holds of their images
        kept = tracked.z if places.size == n else tracked.z[:, np.repeat(plain, each)]
        good = ~is_no_pose(system, kept) & are_well_conditioned(
            system, kept, target[:, 0] if n == 1 else np.repeat(target[:, places], each, axis=1)
        )
        plain[places] = good.reshape(places.size, each).all(axis=1)
    places = plain.nonzero()[0]
    plain[places] = nearest(system, ends[places]) > APART
    return ends, plain


def _unfolded(mirrors: Orbits, ends: np.ndarray) -> np.ndarray:
    """All roots (n, width, roots) from those (n, width, orbits) that stand for them."""
    matrices, shifts = (
        mirrors.symmetries.matrices[mirrors.maps],
        mirrors.symmetries.shifts[mirrors.maps],
    )
    return np.einsum("rij,njr->nir", matrices, ends[:, :, mirrors.labels]) + shifts.T


def nearest(system: AlgebraicSystem, ends: np.ndarray) -> np.ndarray:
    """Least distance (n,) of two roots of each instance (n, width, roots): angles up to whole
    turns, large lengths by their ratio, rays by their sine (to 1e-7); infinite for single roots. A
    rod's length and its negative are one root.
    """
    n, _, roots = ends.shape
    if roots < 2:
        return np.full(n, np.inf)
    ray = list(system.projective)
    found = np.zeros((n, roots, roots))
    for i in range(len(system.unknowns)):
        np.maximum(found, _differences(system, ends[:, i], i), out=found)
    if ray:
        rays = ends[:, ray]
        rays = rays / np.sqrt((rays.real**2 + rays.imag**2).sum(axis=1))[:, None]
        cosines = np.conj(rays.transpose(0, 2, 1)) @ rays
        np.maximum(
            found, np.sqrt(np.maximum(1.0 - cosines.real**2 - cosines.imag**2, 0.0)), out=found
        )
    diagonal = np.arange(roots)
    found[:, diagonal, diagonal] = np.inf
    return found.min(axis=(1, 2))


def _differences(system: AlgebraicSystem, values: np.ndarray, i: int) -> np.ndarray:
    """Distances (n, roots, roots) of one unknown's values (n, roots)."""
    c = system.unknowns[i]
    gap = values[:, :, None] - values[:, None, :]
    if c.is_periodic:
        gap -= 2.0 * np.pi * np.rint(gap.real / (2.0 * np.pi))
        return np.abs(gap)
    if c.least is not None:
        least = c.least / system.characteristic_length
        gap = gap * (values[:, :, None] + values[:, None, :] - 2.0 * least)
    return np.abs(gap) / np.maximum(1.0, np.abs(values))[:, None, :]


# --- one instance with its endgame ----------------------------------------------------------------


def instance(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Ends:
    """Track all generic roots to known values `target`; what does not arrive at a regular root of
    its own is decided by the endgame.
    """
    target = aligned(system, start.k, target)
    return finish(system, start, target, _tracked(system, start, target))


def _tracked(system: AlgebraicSystem, start: Fibre, target: np.ndarray) -> Tracked:
    """All paths; of those that symmetries carry to each other, one is followed."""
    mirrors = start.mirrors
    if mirrors is None:
        return track(system, start.z, start.k, target)
    return mirrors.unfold_tracked(track(system, start.z[:, mirrors.first], start.k, target))
