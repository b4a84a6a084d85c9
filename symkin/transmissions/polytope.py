"""Which torques and rates of joints the limits of motors allow: exact polytopes.

Torques are a zonotope, the image of the motors' box by tau_j = G^T tau_m; rates are what satisfies
low <= G rate_j <= high. Source: P. Chiacchio, Y. Bouffard-Vercelli, F. Pierrot, Force polytope and
force ellipsoid for redundant manipulators, J. Robotic Systems 14 (1997) 613-620.
"""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from symkin.numeric.rank import count_above

_ZERO = 1e-10
"""Share of the longest generator that is rounding."""


def zonotope(generators: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Vertices (k, n) of the sums middle + x1 g1 + x2 g2 + ..., x from -1 to 1, of generators
    (m, n); those of a plane in their order around it.
    """
    return _around(middle + _unique(_corners(generators)))


def torque_vertices(slopes: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Vertices (k, n) of G^T tau for G = `slopes` (m, n) and tau within limits (m, 2)."""
    low, high = limits.T
    return zonotope(slopes * (0.5 * (high - low))[:, None], 0.5 * (high + low) @ slopes)


def facets(generators: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normals d (f, n) of half of a zonotope's facets and their heights (f,): |d x| <= h, each of
    the other half being opposite to one of these.
    """
    n = generators.shape[1]
    found: list[np.ndarray] = []
    for chosen in combinations(range(len(generators)), n - 1):
        normal = _normal(generators[list(chosen)])
        if normal is not None and not any(
            abs(abs(normal @ other) - 1.0) < _ZERO for other in found
        ):
            found.append(normal)
    normals = np.array(found).reshape(-1, n)
    return normals, np.abs(normals @ generators.T).sum(axis=1)


def between_planes(normals: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Vertices (k, n) of low <= normals x <= high, for normals (m, n) of rank n."""
    count, n = normals.shape
    scale = np.maximum(np.abs(low), np.abs(high)) + np.linalg.norm(normals, axis=1) * _ZERO
    found = []
    for chosen in map(list, combinations(range(count), n)):
        if np.linalg.matrix_rank(normals[chosen], tol=_ZERO * np.abs(normals).max()) < n:
            continue
        for ends in product((low, high), repeat=n):
            x = np.linalg.solve(
                normals[chosen], [end[k] for end, k in zip(ends, chosen, strict=True)]
            )
            values = normals @ x
            if np.all((values <= high + _ZERO * scale) & (values >= low - _ZERO * scale)):
                found.append(x)
    return _around(_unique(np.array(found).reshape(-1, n)))


def _corners(generators: np.ndarray) -> np.ndarray:
    """Vertices of a zonotope about 0, repeated ones too: those of its facets, which are zonotopes
    of the generators in their planes, moved by the sum of all others.
    """
    largest = np.linalg.norm(generators, axis=1).max(initial=0.0)
    used = generators[np.linalg.norm(generators, axis=1) > _ZERO * largest]
    if not len(used):
        return np.zeros((1, generators.shape[1]))
    _, values, basis = np.linalg.svd(used)
    rank = count_above(values, _ZERO, relative=True)
    inside = used @ basis[:rank].T
    if rank == 1:
        end = np.abs(inside).sum() * basis[:1]
        return np.vstack([-end, end])
    found = []
    for chosen in combinations(range(len(inside)), rank - 1):
        normal = _normal(inside[list(chosen)])
        if normal is None:
            continue
        heights = inside @ normal
        on = np.abs(heights) <= _ZERO * largest
        side = np.sign(heights[~on]) @ used[~on]
        facet = _corners(used[on])
        found += [facet + side, facet - side]
    return np.vstack(found)


def _normal(vectors: np.ndarray) -> np.ndarray | None:
    """The unit vector across n - 1 vectors (n - 1, n), None where these are fewer."""
    if not len(vectors):
        return np.ones(1)
    _, values, right = np.linalg.svd(vectors)
    return None if values[-1] <= _ZERO * values[0] or not values[0] else np.asarray(right[-1])


def _unique(points: np.ndarray) -> np.ndarray:
    """The points without those that repeat others to rounding."""
    scale = np.abs(points).max(initial=0.0)
    kept: list[np.ndarray] = []
    for point in points:
        if all(np.abs(point - other).max() > 1e-9 * scale for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, points.shape[1])


def _around(points: np.ndarray) -> np.ndarray:
    """Points of a line or a plane in order; those of a space as they are."""
    if points.shape[1] == 1:
        return np.sort(points, axis=0)
    if points.shape[1] != 2 or len(points) < 3:
        return points
    x, y = (points - points.mean(axis=0)).T
    return points[np.argsort(np.arctan2(y, x))]
