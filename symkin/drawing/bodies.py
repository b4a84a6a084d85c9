"""Shapes of links from their points: lines, plates and hulls of few points. NumPy only."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from symkin.drawing.outline import distinct, outline

_FLAT = 1e-6
"""Distance from a plane, over the size, below which a point lies in it."""
_MOST = 24
"""Points of a hull at most: its planes are found by trying every three of them."""


@dataclass(frozen=True, eq=False)
class Body:
    """A link's shape: distinct points (n, 3), edges as pairs of their indices, and faces as rings
    of indices.
    """

    points: np.ndarray
    edges: list[tuple[int, int]]
    faces: list[list[int]]


def body_of(points: np.ndarray, size: float) -> Body:
    """A line through two points, a plate through more in a plane, else their hull; a point inside
    is joined to the nearest corner.
    """
    kept = distinct(points, _FLAT * size)
    if len(kept) < 2:
        return Body(kept, [], [])
    rings = (
        [_ring(kept, list(range(len(kept))))] if _rank(kept, size) < 3 else _hull_faces(kept, size)
    )
    faces = [ring for ring in rings if len(ring) >= 3]
    edges = {_ordered(a, b) for ring in faces for a, b in pairwise([*ring, ring[0]])}
    # points on a line make no ring: they are joined in their order
    edges |= set() if faces else {_ordered(a, b) for a, b in pairwise(_along(kept))}
    held = {index for edge in edges for index in edge}
    for index in set(range(len(kept))) - held:
        nearest = min(held, key=lambda other: float(np.linalg.norm(kept[other] - kept[index])))
        edges.add(_ordered(index, nearest))
    return Body(kept, sorted(edges), faces)


def _rank(points: np.ndarray, size: float) -> int:
    return int(np.sum(np.linalg.svd(points - points.mean(axis=0), compute_uv=False) > _FLAT * size))


def _along(points: np.ndarray) -> list[int]:
    """Indices of points on a line, from one end to the other."""
    direction = np.linalg.svd(points - points.mean(axis=0))[2][0]
    return [int(k) for k in np.argsort(points @ direction)]


def _ring(points: np.ndarray, indices: list[int]) -> list[int]:
    """Indices of the corners of points in a plane, in order around them."""
    corners = outline(points[indices])
    return [
        indices[int(np.argmin(np.linalg.norm(points[indices] - corner, axis=1)))]
        for corner in corners
    ]


def _hull_faces(points: np.ndarray, size: float) -> list[list[int]]:
    """Faces of the convex hull: the planes through three points that have all others on one
    side.
    """
    if len(points) > _MOST:
        return []
    found: dict[tuple[int, ...], list[int]] = {}
    for a, b, c in combinations(range(len(points)), 3):
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        length = float(np.linalg.norm(normal))
        if length <= _FLAT * size**2:
            continue
        heights = (points - points[a]) @ normal / length
        if heights.max() < _FLAT * size or heights.min() > -_FLAT * size:
            on = [int(k) for k in np.flatnonzero(np.abs(heights) <= _FLAT * size)]
            found.setdefault(tuple(on), _ring(points, on))
    return list(found.values())


def _ordered(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a < b else (b, a)
