"""Roots that double precision cannot settle because angles have large imaginary parts.

Near a special geometry, such as axes that are parallel but for 1e-4 rad, some roots of the inverse
problem lie far from the real ones: sines and cosines of 1e4 and more are subtracted from each
other, and few digits are left. There Newton's method is done with more bits.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import COMPLEX, BallFunction, Number, precision, upper

_BITS = 128
_FAR = 4.0
"""Imaginary part of an angle from which on a root is far: its sine is 27."""
_REFINEMENTS = 10
"""Newton steps at most; near a regular root each doubles the digits."""
_NEAREST = 1e-3
"""Largest distance of a root from the point that stands for it."""
_TOLERANCE = 1e-5
"""Largest first Newton step of a step along a path."""
_FIRST, _SMALLEST, _MOST_STEPS = 0.01, 1e-9, 1000
"""First and smallest step along a path, as shares of it, and the most that are made."""


def are_far(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Which points (width, n) have an angle with a large imaginary part."""
    angles = [i for i, c in enumerate(system.unknowns) if c.is_periodic]
    return np.asarray(
        np.isfinite(z).all(axis=0) & (np.max(np.abs(z[angles].imag), axis=0, initial=0.0) > _FAR)
    )


def settled(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (width, n) moved to the regular roots nearby where Newton's method with more bits
    settles, and which of them do: about a multiple root it halves its steps, and does not come down
    to the last digits.
    """
    found, points = np.zeros(z.shape[1], dtype=bool), z.copy()
    if system.projective or system.count != system.width:
        return found, points
    for i in range(z.shape[1]):
        root = _settle(system, z[:, i], k)
        if root is not None and np.max(np.abs(root - z[:, i])) < _NEAREST:
            points[:, i], found[i] = root, True
    return found, points


def _settle(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray | None:
    """The root to which Newton's method comes from a point; None where its steps do not become as
    small as 0.6 of the digits.
    """
    with precision(_BITS):
        rows, known = _at(system, k)
        point = [COMPLEX.number(v) for v in z.tolist()]
        for _ in range(_REFINEMENTS):
            step = _newton_step(rows, known, point)
            size = 1.0 if step is None else max(upper(d) for d in step)
            if step is None or not size < 1.0:
                return None
            point = [(p - d).mid() for p, d in zip(point, step, strict=True)]
            if size < 2.0 ** (-0.6 * _BITS):
                return np.array([complex(p) for p in point])
    return None


def _newton_step(rows: BallFunction, known: list[Any], point: list[Number]) -> list[Number] | None:
    """What Newton's method subtracts at a point; None where the derivatives have no inverse."""
    matrix = COMPLEX.matrix(len(point), len(point), rows.evaluate(1, point, known)).mid()
    try:
        return list(
            matrix.solve(COMPLEX.column(rows.evaluate(0, point, known)).mid()).mid().entries()
        )
    except ZeroDivisionError:
        return None


def carried(
    system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Roots (width, n) of F(., begin) followed to roots of F(., end) with Newton's method in more
    bits: whether each path came to its end, and where it is. Stops at the first that does not come
    there.
    """
    came, points = np.zeros(z.shape[1], dtype=bool), z.copy()
    for i in range(z.shape[1]):
        points[:, i], came[i] = _follow(system, z[:, i], begin, end)
        if not came[i]:
            break
    return came, points


def _follow(
    system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, bool]:
    """One path: the polynomial through the last three points and their tangents predicts, two
    Newton steps correct.
    """
    along, s, h = end - begin, 0.0, _FIRST
    first = _corrected(system, z, begin, along)
    if first is None:
        return z, False
    stations: list[_Station] = [(0.0, *first[:2])]
    for _ in range(_MOST_STEPS):
        step = min(h, 1.0 - s)
        ahead = 1.0 if step >= 1.0 - s else s + step
        found = _corrected(
            system, _predicted(stations[-3:], s + step), begin + ahead * along, along
        )
        if found is None:
            h = 0.3 * step
            if h < _SMALLEST:
                break
            continue
        stations, s = [*stations[-2:], (ahead, *found[:2])], ahead
        if s >= 1.0:
            return found[0], True
        h = step * float(
            np.clip(
                0.9 * (0.3 * _TOLERANCE / max(found[2], 1e-16)) ** (0.5 / len(stations)), 0.3, 2.5
            )
        )
    return stations[-1][1], False


_Station = tuple[float, np.ndarray, np.ndarray]
"""Place s on a path, point and tangent there."""


def _predicted(stations: list[_Station], s: float) -> np.ndarray:
    """Hermite's polynomial through points and tangents, at s: Newton's divided differences over
    doubled places.
    """
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
    """The root that two Newton steps from z lead to, its tangent for k moving `along`, and the
    first step's size; None where the steps are too large or do not shrink.
    """
    motion = _motion(system)
    sizes: list[float] = []
    with precision(_BITS):
        rows, known = _at(system, k)
        point = [COMPLEX.number(v) for v in z.tolist()]
        for _ in range(2):
            before, step = point, _newton_step(rows, known, point)
            if step is None:
                return None
            point = [(p - d).mid() for p, d in zip(point, step, strict=True)]
            sizes.append(max(upper(d) for d in step))
            if not sizes[-1] <= min(
                _TOLERANCE, 0.01 * (sizes[0] + 1e-12) if len(sizes) > 1 else _TOLERANCE
            ):
                return None
        matrix = COMPLEX.matrix(system.width, system.width, rows.evaluate(1, before, known)).mid()
        moved = motion.evaluate(
            0,
            point,
            motion.prepare(COMPLEX, [*(complex(v) for v in k), *(complex(v) for v in along)]),
        )
        tangent = matrix.solve(COMPLEX.column(moved)).entries()
    return np.array([complex(p) for p in point]), -np.array([complex(t) for t in tangent]), sizes[0]


def _at(system: AlgebraicSystem, k: np.ndarray) -> tuple[BallFunction, list[Any]]:
    """Rows and their derivatives, and what known values make of them, at the present precision."""
    rows = _rows(system)
    return rows, rows.prepare(COMPLEX, [complex(v) for v in k])


@lru_cache(maxsize=16)
def _rows(system: AlgebraicSystem) -> BallFunction:
    return BallFunction(system.z, system.k, system.rows, ("value", "slope"))


@lru_cache(maxsize=16)
def _motion(system: AlgebraicSystem) -> BallFunction:
    """dF/dk dk over (k, dk)."""
    along = ca.SX.sym("dk", system.k.shape[0])
    return BallFunction(
        system.z, ca.vertcat(system.k, along), ca.jtimes(system.rows, system.k, along)
    )
