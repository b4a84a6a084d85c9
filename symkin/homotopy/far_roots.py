"""Roots that double precision cannot settle because angles have large imaginary parts, or rotations
large entries.

Near a special geometry, such as axes that are parallel but for 1e-4 rad, or values beside those of
a symmetry, some roots lie far from the real ones: sines and cosines of 1e4 and more are subtracted
from each other, and few digits are left. There Newton's method is done with more bits. At a ray x
of homogeneous coordinates its step d meets conj(x).d = 0.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.circles import distances, gaps
from symkin.homotopy.engine import track
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.point_checks import is_no_pose
from symkin.homotopy.tracker import LastPoints, TrackSettings, extrapolated
from symkin.numeric.balls import COMPLEX, BallFunction, Number, Prepared, precision, upper

_BITS = 128
_FAR = 4.0
"""Imaginary part of an angle from which on a root is far: its sine is 27."""
_REFINEMENTS = 10
"""Newton steps at most; near a regular root each doubles the digits."""
_LARGE_ENTRIES = 1e-2
"""|e.e| / |e|^2 and |e| / |(e, g)| of a ray below which a root is far: rotation matrices with
entries, positions beyond 100. Singular values fall with the fourth power of the distance, 1e-8 of
the largest there: half of the digits.
"""
_LAST_DIGITS = 1e-14
"""The same below which a root found by more bits, then rounded, is at infinity."""
_NEAREST = 1e-3
"""Largest distance of a root from the point that stands for it, of lengths beyond 1 as a share."""
_TOLERANCE = 1e-5
"""Largest first Newton step of a step along a path."""
_FIRST, _SMALLEST, _MOST_STEPS = 0.01, 1e-9, 1000
"""First and smallest step along a path, in u, and the most that are made."""
_SHARES = (0.95, 0.9, 0.8, 0.5)
"""Of a path: up to where double precision may lead."""
_SHORTER = (1e-4, 1e-5)
"""Largest first corrections of steps by which paths come nearer to far roots, or stop on them."""
_CAREFUL = TrackSettings(tolerance=1e-6, smallest_step=1e-10, most_steps=2000)
_NEAR_THE_END = 3e-3
"""What may be left of a path for Newton's method to lead to its end: along a smooth path it is off
by the square of that.
"""
_TRIED = 1.0
"""Way in u before the end is tried at first, and again."""
_LAST = 23.0
"""The u from which Newton's method leads to the end, 1e-10 of the path away."""


def are_far(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Which points (width, n) have an angle with a large imaginary part, or a rotation with large
    entries.
    """
    angles = [i for i, c in enumerate(system.unknowns) if c.is_periodic]
    far = np.max(np.abs(z[angles].imag), axis=0, initial=0.0) > _FAR
    if system.projective:
        far |= is_no_pose(system, z, thin=_LARGE_ENTRIES, far=_LARGE_ENTRIES)
    return np.isfinite(z).all(axis=0) & far


def settled(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (width, n) moved to the regular roots nearby where Newton's method with more bits
    settles, and which of them do: about a multiple root it halves its steps, and does not come down
    to the last digits. Of conjugates at real known values one is settled.
    """
    found, points = np.zeros(z.shape[1], dtype=bool), z.copy()
    if not is_square(system):
        return found, points
    for i in range(z.shape[1]):
        mates = points[:, found].conj() if not np.imag(k).any() else points[:, :0]
        mates = mates[:, gaps(system, mates, z[:, [i]]) < _NEAREST]
        if mates.size:
            points[:, i], found[i] = mates[:, 0], True
            continue
        root = _settle(system, z[:, i], k)
        if root is not None and np.max(np.abs(root - z[:, i]) / _reach(system, z[:, i])) < _NEAREST:
            points[:, i], found[i] = root, True
    return found, points


def are_infinite(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Which roots (width, n) found by more bits are no pose."""
    return is_no_pose(system, z, thin=_LAST_DIGITS, far=_LAST_DIGITS)


def is_square(system: AlgebraicSystem) -> bool:
    """Whether there are as many rows as unknowns, a ray's length left out."""
    return system.count + bool(system.projective) == system.width


def _reach(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """What steps of the coordinates (width,) of a point are measured by: 1, or a larger length."""
    reach = np.maximum(1.0, np.abs(z))
    reach[[i for i, c in enumerate(system.unknowns) if c.is_periodic]] = 1.0
    return reach


def _settle(system: AlgebraicSystem, z: np.ndarray, k: np.ndarray) -> np.ndarray | None:
    """The root to which Newton's method comes from a point; None where its steps do not become as
    small as 0.6 of the digits.
    """
    with precision(_BITS):
        rows, known = _at(system, k)
        point, reach = [COMPLEX.number(v) for v in z.tolist()], _reach(system, z).tolist()
        for _ in range(_REFINEMENTS):
            try:
                (step,) = _solved(system, rows, known, point, rows.evaluate(0, point, known))
            except ZeroDivisionError:
                return None
            size = max(upper(d) / r for d, r in zip(step, reach, strict=True))
            if not size < 1.0:
                return None
            point = [(p - d).mid() for p, d in zip(point, step, strict=True)]
            if size < 2.0 ** (-0.6 * _BITS):
                return np.array([complex(p) for p in point])
    return None


def _solved(
    system: AlgebraicSystem,
    rows: BallFunction,
    known: Prepared,
    point: list[Number],
    *right: list[Number],
) -> list[list[Number]]:
    """For each right hand side x with dF/dz x = right at a point, and conj(p).x = 0 for the point's
    ray p. Raises ZeroDivisionError where the derivatives have no inverse.
    """
    derivatives, columns = list(rows.evaluate(1, point, known)), [list(column) for column in right]
    if system.projective:
        still = COMPLEX.number(0.0)
        ray = [complex(p).conjugate() for p in point]
        derivatives += [
            COMPLEX.number(ray[i]) if i in system.projective else still for i in range(len(point))
        ]
        columns = [[*column, still] for column in columns]
    matrix = COMPLEX.matrix(len(point), len(point), derivatives).mid()
    beside = [column[i] for i in range(len(point)) for column in columns]
    found = matrix.solve(COMPLEX.matrix(len(point), len(columns), beside).mid()).mid().entries()
    return [list(found[k :: len(columns)]) for k in range(len(columns))]


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


def completed(
    system: AlgebraicSystem, start: Fibre, z: np.ndarray, missing: np.ndarray, end: np.ndarray
) -> np.ndarray:
    """Put roots of F(., end) in place of those of the points z (width, n) that are `missing`, at
    which paths from `start` stopped: what double precision finds by shorter steps, conjugates where
    known values are real, and what of the rest is followed with more bits from where double
    precision leads. The places that stay missing.
    """
    for tolerance in _SHORTER:
        if missing.size:
            settings = TrackSettings(tolerance=tolerance)
            points = track(system, start.z[:, missing], start.k, end, settings).z
            found, z[:, missing] = settled(system, points, end)
            missing = _without_conjugates(system, z, missing[~found], end)
    while missing.size:
        first = start.z[:, missing[:1]]
        came, points = carried(system, *advanced(system, first, start.k, end), end)
        if came.all():
            came, points = settled(system, points, end)
        if not came.all():
            break
        z[:, missing[:1]] = points
        missing = _without_conjugates(system, z, missing[1:], end)
    return missing


def _without_conjugates(
    system: AlgebraicSystem, z: np.ndarray, missing: np.ndarray, end: np.ndarray
) -> np.ndarray:
    """The places that stay missing where roots have conjugates that are none of the others: these
    are put where the paths next to them stopped.
    """
    if np.imag(end).any():
        return missing
    others = z[:, np.setdiff1d(np.arange(z.shape[1]), missing)]
    apart = distances(system, others.conj(), others).min(axis=1, initial=np.inf)
    for root in others[:, apart > _NEAREST].conj().T[: missing.size]:
        place = missing[np.argmin(distances(system, root[:, None], z[:, missing]))]
        z[:, place], missing = root, missing[missing != place]
    return missing


def advanced(
    system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Roots (width, n) of F(., begin) and these known values, or where double precision leads: the
    roots and known values from which the rest of the way needs more bits.
    """
    for share in _SHARES:
        near = begin + share * (end - begin)
        tracked = track(system, z, begin, near, _CAREFUL)
        if tracked.arrived.all():
            return tracked.z, near
    return z, begin


def _follow(
    system: AlgebraicSystem, z: np.ndarray, begin: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, bool]:
    """One path: the polynomial through the last three points and their tangents predicts, two
    Newton steps correct. It is followed over u = -log(1 - s), s its share: a root that is far
    away is neared as s is, one at infinity by steps that are equally long in u; a ray that is no
    pose to the last digits is not followed on.
    """
    way, u, h, tried = end - begin, 0.0, _FIRST, 1.0
    first = _corrected(system, z, begin, way)
    if first is None:
        return z, False
    last, only = LastPoints.begun(first[0][:, None], first[1][:, None]), np.zeros(1, dtype=int)
    for _ in range(_MOST_STEPS):
        ahead = min(u + h, _LAST)
        left = float(np.exp(-ahead))
        (predicted,) = extrapolated(system, last, np.array([ahead - u])).T
        found = _corrected(system, predicted, end - left * way, left * way)
        if found is not None and are_infinite(system, found[0][:, None])[0]:
            break
        if found is None:
            h = 0.3 * (ahead - u)
            if h < _SMALLEST:
                break
            continue
        last.push(only, found[0][:, None], found[1][:, None], np.array([ahead]))
        step, u = ahead - u, ahead
        if u >= _LAST or (u > tried + _TRIED and np.max(np.abs(found[1])) < _NEAR_THE_END):
            # dz/du there is what is left of the way times dz/ds
            tried, root = u, _corrected(system, found[0] + found[1], end, way)
            if u >= _LAST:
                return (found[0], False) if root is None else (root[0], True)
            if root is not None and not are_infinite(system, root[0][:, None])[0]:
                return root[0], True
        h = step * float(
            np.clip(
                0.9 * (0.3 * _TOLERANCE / max(found[2], 1e-16)) ** (0.5 / last.count[0]), 0.3, 2.5
            )
        )
    return last.z[0][:, 0], False


def _corrected(
    system: AlgebraicSystem, z: np.ndarray, k: np.ndarray, along: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """The root that two Newton steps from z lead to, its tangent for k moving `along`, and the
    first step's size; None where the steps are too large or do not shrink.
    """
    motion, values = _motion(system), [*(complex(v) for v in k), *(complex(v) for v in along)]
    sizes: list[float] = []
    with precision(_BITS):
        rows, known = _at(system, k)
        moving = motion.prepare(COMPLEX, values)
        point = [COMPLEX.number(v) for v in z.tolist()]
        for last in (False, True):
            columns = [rows.evaluate(0, point, known)]
            columns += [motion.evaluate(0, point, moving)] if last else []
            try:
                step, *tangents = _solved(system, rows, known, point, *columns)
            except ZeroDivisionError:
                return None
            point = [(p - d).mid() for p, d in zip(point, step, strict=True)]
            sizes.append(max(upper(d) for d in step))
            if not sizes[-1] <= (
                min(_TOLERANCE, 0.01 * (sizes[0] + 1e-12)) if last else _TOLERANCE
            ):
                return None
    (tangent,) = tangents
    root = np.array([complex(p) for p in point])
    along = -np.array([complex(t) for t in tangent])
    ray = list(system.projective)
    if ray:
        along[ray] /= np.linalg.norm(root[ray])
    return system.unit_rays(root), along, sizes[0]


def _at(system: AlgebraicSystem, k: np.ndarray) -> tuple[BallFunction, Prepared]:
    """Rows and their derivatives, and what known values make of them, at the present precision."""
    rows = rows_over_balls(system)
    return rows, rows.prepare(COMPLEX, [complex(v) for v in k])


@lru_cache(maxsize=128)
def rows_over_balls(system: AlgebraicSystem) -> BallFunction:
    """Rows and first derivatives."""
    return BallFunction(system.z, system.k, system.rows, ("value", "slope"))


@lru_cache(maxsize=16)
def _motion(system: AlgebraicSystem) -> BallFunction:
    """dF/dk dk over (k, dk)."""
    along = ca.SX.sym("dk", system.k.shape[0])
    return BallFunction(
        system.z, ca.vertcat(system.k, along), ca.jtimes(system.rows, system.k, along)
    )
