"""Outlines of points: NumPy only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")


def outline(points: np.ndarray) -> np.ndarray:
    """Corners (k, n) of the convex hull of points (m, n) seen along the normal of their best plane,
    in order around it; fewer than three for points on a line.
    """
    centred = points - points.mean(axis=0)
    _, s, vt = np.linalg.svd(centred, full_matrices=True)
    if len(s) < 2 or s[1] <= 1e-6 * max(s[0], 1e-300):
        along = centred @ vt[0]
        return points[sorted({int(np.argmin(along)), int(np.argmax(along))})]
    return points[_hull(centred @ vt[:2].T)]


def distinct(points: np.ndarray, near: float) -> np.ndarray:
    """The points (n, 3) that are no nearer to one before them than `near`."""
    kept = [place for _, place in grouped(enumerate(points), near)]
    return np.array(kept).reshape(-1, 3)


def grouped(
    placed: Iterable[tuple[Item, np.ndarray]], near: float, order: float | None = None
) -> list[tuple[list[Item], np.ndarray]]:
    """Items by place: those that are nearer than `near` to the first of a group, by a norm of this
    order.
    """
    found: list[tuple[list[Item], np.ndarray]] = []
    for item, place in placed:
        here = next((own for own, at in found if np.linalg.norm(place - at, order) < near), None)
        if here is None:
            found.append(([item], place))
        else:
            here.append(item)
    return found


def _hull(flat: np.ndarray) -> list[int]:
    """Indices of the convex hull of points (n, 2), counter-clockwise (Andrew's monotone chain)."""
    order = [int(i) for i in np.lexsort((flat[:, 1], flat[:, 0]))]
    slack = 1e-9 * float(np.ptp(flat, axis=0).max()) ** 2

    def half(indices: Sequence[int]) -> list[int]:
        chain: list[int] = []
        for i in indices:
            while len(chain) >= 2 and _turn(flat[chain[-2]], flat[chain[-1]], flat[i]) <= slack:
                chain.pop()
            chain.append(i)
        return chain[:-1]

    return half(order) + half(order[::-1])


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
