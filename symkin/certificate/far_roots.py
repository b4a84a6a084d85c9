"""Roots that double precision cannot settle because angles have large imaginary parts.

Near a special geometry, such as axes that are parallel but for 1e-4 rad, some roots of the inverse problem lie far from the real
ones: sines and cosines of 1e4 and more are subtracted from each other, and few digits are left. There Newton's method and the
proof that a regular root is met are done with more bits.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.caching import lru_cache
from symkin.certificate.ball_system import BallSystem
from symkin.certificate.balls import COMPLEX, BallFunction, precision, upper
from symkin.certificate.krawczyk import Chart, enclose
from symkin.homotopy.algebraic import AlgebraicSystem

_BITS = 128
_FAR = 4.0
"""Imaginary part of an angle from which on a root is far: its sine is 27."""
_NEAREST = 1e-3
"""Largest distance of a proved root from the point that stands for it."""
_TOLERANCE = 1e-5
"""Largest first Newton step of a step along a path."""
_FIRST, _SMALLEST, _MOST_STEPS = 0.01, 1e-9, 1000
"""First and smallest step along a path, as shares of it, and the most that are made."""


def are_far(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Which points (width, n) have an angle with a large imaginary part."""
    angles = [i for i, c in enumerate(system.unknowns) if c.kind == "angle"]
    return np.asarray(np.isfinite(z).all(axis=0) & (np.max(np.abs(z[angles].imag), axis=0, initial=0.0) > _FAR))


def settled(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (width, n) moved to the proved regular roots nearby, and which of them have one."""
    found, points = np.zeros(z.shape[1], dtype=bool), z.copy()
    if system.projective or system.count != system.width:
        return found, points
    balls = BallSystem(system, tuple(complex(v) for v in k))
    chart = Chart(balls.all_rows, balls.all_columns, None, system.width)
    for i in range(z.shape[1]):
        box = enclose(balls, chart, COMPLEX, z[:, i], _BITS)
        if box is not None and np.max(np.abs(box.point - z[:, i])) < _NEAREST:
            points[:, i], found[i] = box.point, True
    return found, points


def carried(system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roots (width, n) of F(., begin) followed to roots of F(., end) with Newton's method in more bits: whether each path came
    to its end, and where it is. Stops at the first that does not come there."""
    came, points = np.zeros(z.shape[1], dtype=bool), z.copy()
    for i in range(z.shape[1]):
        points[:, i], came[i] = _follow(system, z[:, i], begin, end)
        if not came[i]:
            break
    return came, points


def _follow(system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, bool]:
    """One path: the polynomial through the last three points and their tangents predicts, two Newton steps correct."""
    along, s, h = end - begin, 0.0, _FIRST
    first = _corrected(system, z, begin, along)
    if first is None:
        return z, False
    stations: list[_Station] = [(0.0, *first[:2])]
    for _ in range(_MOST_STEPS):
        step = min(h, 1.0 - s)
        ahead = 1.0 if step >= 1.0 - s else s + step
        found = _corrected(system, _predicted(stations[-3:], s + step), begin + ahead * along, along)
        if found is None:
            h = 0.3 * step
            if h < _SMALLEST:
                break
            continue
        stations, s = [*stations[-2:], (ahead, *found[:2])], ahead
        if s >= 1.0:
            return found[0], True
        h = step * float(np.clip(0.9 * (0.3 * _TOLERANCE / max(found[2], 1e-16)) ** (0.5 / len(stations)), 0.3, 2.5))
    return stations[-1][1], False


_Station = tuple[float, np.ndarray, np.ndarray]
"""Place s on a path, point and tangent there."""


def _predicted(stations: list[_Station], s: float) -> np.ndarray:
    """Hermite's polynomial through points and tangents, at s: Newton's divided differences over doubled places."""
    places = [place for place, _, _ in stations for _ in (0, 1)]
    column = [z for _, z, _ in stations for _ in (0, 1)]
    tangents = [t for _, _, t in stations]
    total, product = column[0].copy(), 1.0
    for order in range(1, len(places)):
        gaps = [places[i + order] - places[i] for i in range(len(places) - order)]
        column = [
            tangents[i // 2] if gap == 0.0 else (b - a) / gap
            for i, (gap, a, b) in enumerate(zip(gaps, column[:-1], column[1:], strict=True))
        ]
        product *= s - places[order - 1]
        total += product * column[0]
    return total


def _corrected(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, along: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """The root that two Newton steps from z lead to, its tangent for k moving `along`, and the first step's size; None where
    the steps are too large or do not shrink."""
    balls = BallSystem(system, tuple(complex(v) for v in k))
    motion = _motion(system)
    sizes: list[float] = []
    with precision(_BITS):
        point = [COMPLEX.number(v) for v in z.tolist()]
        for _ in range(2):
            matrix = COMPLEX.matrix(system.width, system.width, balls.jacobian(COMPLEX, point)).mid()
            try:
                step = matrix.solve(COMPLEX.column(balls.rows(COMPLEX, point)).mid()).mid()
            except ZeroDivisionError:
                return None
            point = [(p - d).mid() for p, d in zip(point, step.entries(), strict=True)]
            sizes.append(max(upper(d) for d in step.entries()))
            if not sizes[-1] <= min(_TOLERANCE, 0.01 * (sizes[0] + 1e-12) if len(sizes) > 1 else _TOLERANCE):
                return None
        moved = motion.evaluate(0, point, motion.prepare(COMPLEX, [*(complex(v) for v in k), *(complex(v) for v in along)]))
        tangent = matrix.solve(COMPLEX.column(moved)).entries()
    return np.array([complex(p) for p in point]), -np.array([complex(t) for t in tangent]), sizes[0]


@lru_cache(maxsize=16)
def _motion(system: AlgebraicSystem) -> BallFunction:
    """dF/dk dk over (k, dk)."""
    along = ca.SX.sym("dk", system.k.shape[0])
    return BallFunction(system.z, ca.vertcat(system.k, along), ca.jtimes(system.rows, system.k, along))
