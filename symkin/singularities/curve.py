"""Trace curves F(z) = 0 with one freedom by pseudo-arclength continuation; every point is corrected
to a true zero.

At a regular point dF/dz has one null vector t, |t| = 1: the tangent. A step predicts z + h t and
corrects to F = 0 by the shortest Newton steps, which move across the curve (Keller 1977; Allgower
and Georg, Introduction to Numerical Continuation Methods, 2003). The tangent is defined at folds
too, where a coordinate of the plane turns back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symkin.numeric.system import System
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.spatial.rotation import wrapped

CORRECTED = 1e-11
"""A point lies on the curve when no row exceeds this times the size."""
_MOST_CORRECTIONS = 12
"""Corrector steps at most; a step that is short enough needs three."""
_MOST_POINTS = 4000
"""Points of a curve each way, at most."""
_REGULAR = 1e-4
"""Where the last singular value but one is below this times the largest, a zero is nearly a
multiple one.
"""
_LEAST_COSINE = 0.95
"""Least cosine between the tangents of neighbouring points: steps are shortened where the curve
bends more.
"""
_SHORTEST_STEP, _LONGEST_STEP = 1e-7, 0.1
"""Bounds of a step, of the size."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Points (n, width) in order and their unit tangents (n, freedom); `closed`: the last is
    followed by the first.
    """

    points: np.ndarray
    tangents: np.ndarray
    closed: bool


def correct(system: System, z: np.ndarray) -> np.ndarray | None:
    """Gauss-Newton by least-norm steps to a zero of all rows; None where it is not reached."""
    found = system.polish_many(z[None], np.zeros(0), steps=_MOST_CORRECTIONS)
    return (
        found.points[0]
        if np.max(np.abs(found.rows), initial=0.0) <= CORRECTED * system.characteristic_length
        else None
    )


def tangent(system: System, z: np.ndarray) -> np.ndarray | None:
    """The unit tangent at a point, either sense; None where the point is isolated or the freedoms
    are more than one.
    """
    _, jacobian = system.linearise_one(z, np.zeros(0))
    _, singular, right = np.linalg.svd(jacobian)
    padded = np.zeros(system.freedom)
    padded[: len(singular)] = singular
    if padded[-1] > RANK_TOLERANCE * padded[0] or padded[-2] <= RANK_TOLERANCE * padded[0]:
        return None
    return right[-1]


def is_regular(system: System, z: np.ndarray) -> bool:
    """Whether a point of a curve is far from crossings and other places without one tangent."""
    singular = np.linalg.svd(system.linearise_one(z, np.zeros(0))[1], compute_uv=False)
    return len(singular) >= system.freedom - 1 and bool(
        singular[system.freedom - 2] > _REGULAR * singular[0]
    )


@dataclass(frozen=True, eq=False)
class Window:
    """Where a curve is wanted: `inside` of a point; `cap`, the longest step along a tangent, so
    that the curve's picture is as fine as it must be; `leading`, how many of the unknown
    coordinates tell points apart (null vectors have two signs).
    """

    inside: Callable[[np.ndarray], bool]
    cap: Callable[[np.ndarray], float]
    leading: int


def trace(system: System, start: np.ndarray, window: Window) -> Curve | None:
    """The curve through a point, both ways until it leaves the window or returns; None without a
    tangent there.
    """
    first = tangent(system, start)
    if first is None:
        return None
    ahead, closed = _one_way(system, start, first, window)
    if closed:
        return _curve(ahead, closed=True)
    back, _ = _one_way(system, start, -first, window)
    return _curve([(z, -t) for z, t in reversed(back[1:])] + ahead, closed=False)


def distance(system: System, a: np.ndarray, b: np.ndarray, leading: int | None = None) -> float:
    """How far two points are apart in the first `leading` coordinates (length unit): angles modulo
    a turn and rotations times the size, quaternions up to sign.
    """
    step, column = system.difference(a[None], b[None])[0], 0
    size = system.characteristic_length
    for c in system.unknowns[:leading]:
        if c.is_periodic:
            step[column] = size * wrapped(step[column] / size)
        column += c.freedom
    return float(np.linalg.norm(step[:column]))


Step = tuple[np.ndarray, np.ndarray]


def _one_way(
    system: System, start: np.ndarray, direction: np.ndarray, window: Window
) -> tuple[list[Step], bool]:
    path: list[Step] = [(start, direction)]
    length = min(window.cap(direction), _LONGEST_STEP * system.characteristic_length)
    while len(path) < _MOST_POINTS:
        z, t = path[-1]
        length = min(length, window.cap(t), _LONGEST_STEP * system.characteristic_length)
        found = _step(system, z, t, length)
        if found is None:
            length /= 2
            if length < _SHORTEST_STEP * system.characteristic_length:
                break
            continue
        path.append(found)
        if len(path) > 3 and _returned(system, path, window.leading):
            return path[:-1], True
        if not window.inside(found[0]):
            break
        length *= 1.3
    return path, False


def _step(system: System, z: np.ndarray, t: np.ndarray, length: float) -> Step | None:
    """One predictor and corrector step; None where the corrector moves far or the tangent turns too
    much.
    """
    predicted = system.move(z[None], length * t[None])[0]
    corrected = correct(system, predicted)
    if corrected is None or distance(system, corrected, predicted) > 0.3 * length:
        return None
    turned = tangent(system, corrected)
    if turned is None:
        return None
    cosine = float(turned @ t)
    return (corrected, turned if cosine > 0 else -turned) if abs(cosine) >= _LEAST_COSINE else None


def _returned(system: System, path: list[Step], leading: int) -> bool:
    """Whether the last step has passed the start, in the same sense."""
    freedom = sum(c.freedom for c in system.unknowns[:leading])
    (start, direction), (before, t), (now, _) = path[0], path[-2], path[-1]
    a, b = t[:freedom], direction[:freedom]
    if float(a @ b) < 0.8 * float(np.linalg.norm(a) * np.linalg.norm(b)):
        return False
    gaps = [
        distance(system, *pair, leading) for pair in ((before, start), (now, start), (before, now))
    ]
    return gaps[0] + gaps[1] < 1.1 * gaps[2]


def _curve(path: list[Step], *, closed: bool) -> Curve:
    return Curve(np.array([z for z, _ in path]), np.array([t for _, t in path]), closed)
