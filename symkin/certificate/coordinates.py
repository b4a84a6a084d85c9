"""Coordinates of roots: writings of one root, and how much coordinates can differ within a box."""

from __future__ import annotations

import casadi as ca
import numpy as np
from flint import arb

from symkin.certificate.discs import DiscFunction, Discs, Knowns
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import REAL, BallFunction, Number, precision, upper
from symkin.spatial.rotation import conjugate, multiply

_ROUNDING = 2.0**-49
"""Allowance for coordinates that are computed from z in double precision, relative to 1 and to each
coordinate.
"""


def spread(
    system: AlgebraicSystem,
    points: np.ndarray,
    distance: np.ndarray,
    knowns: Knowns,
    instance: np.ndarray,
) -> np.ndarray:
    """No coordinate at a real point within `distance` (n,) of its point (width, n) differs by more
    from the one there: lengths and position over the size, angles, unit quaternion.
    """
    result = np.full(points.shape[1], np.inf)
    function = _disc_coordinates(system)
    if function is not None and knowns.discs.is_real:
        middle, radius = points.T, distance[:, None]
        if system.eliminated or system.projective:
            values = Discs(middle, np.repeat(radius, system.width, axis=1))
            values = function.evaluate(0, values, function.prepare(knowns.discs), instance)
            middle, radius = values.middle, values.radius
        # 2 r + _ROUNDING (1 + |m| + r)
        every = (2.0 + _ROUNDING) * radius + _ROUNDING * np.abs(middle)
        result = every.max(axis=1, initial=0.0) + _ROUNDING
    if np.isfinite(result).all():
        return result
    for i in np.flatnonzero(~np.isfinite(result)).tolist():
        result[i] = _ball_spread(
            system, points[:, i], float(distance[i]), knowns.numbers(int(instance[i]))
        )
    return result


def _ball_spread(
    system: AlgebraicSystem, point: np.ndarray, distance: float, known: tuple[Number, ...]
) -> float:
    """`spread` of one point, by balls."""
    with precision(64):
        side, function = arb(0.0, distance), _coordinates(system)
        z = [arb(v) + side for v in point.tolist()]
        values = function.evaluate(0, z, function.prepare(REAL, known))
        return max(
            (2.0 * upper(v.rad()) + _ROUNDING * (1.0 + upper(v)) for v in values), default=0.0
        )


@lru_cache(maxsize=64)
def _disc_coordinates(system: AlgebraicSystem) -> DiscFunction | None:
    try:
        return DiscFunction(_coordinates(system).tape)
    except NotImplementedError:
        return None


@lru_cache(maxsize=64)
def _coordinates(system: AlgebraicSystem) -> BallFunction:
    """Coordinates of a root, lengths in units of the size: affine ones, eliminated angles,
    position, unit quaternion.
    """
    parts = [system.z[i] for i in range(len(system.unknowns))] + [
        angle for _, angle in system.eliminated
    ]
    if system.projective:
        ray = system.z[list(system.projective)]
        e = ray[:4]
        squared = ca.dot(e, e)
        parts.append(e / ca.sqrt(squared))
        if len(system.projective) == 8:
            parts.append(2 * multiply(ray[4:], conjugate(e))[1:] / squared)
    return BallFunction(system.z, system.k, ca.vertcat(*parts))


def in_phase(system: AlgebraicSystem, z: np.ndarray) -> np.ndarray:
    """Points (width, n) with rays of unit length, turned so that real ones are real."""
    z = z.copy()
    if system.projective:
        ray = slice(system.projective[0], system.projective[-1] + 1)
        x = z[ray]
        with np.errstate(all="ignore"):
            squares = x.real**2 + x.imag**2
            largest = (squares.argmax(axis=0), np.arange(x.shape[1]))
            z[ray] = x * (x[largest].conj() / np.sqrt(squares[largest] * squares.sum(axis=0)))
    return z


def aligned(system: AlgebraicSystem, points: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """The same roots as `points` (width, n), each written as near as possible to its centre (width,
    n): angles by whole turns, rods by the sign of their length, rays by their phase.
    """
    points = np.array(points, dtype=complex)
    for i, c in enumerate(system.unknowns):
        if c.is_periodic:
            points[i] += 2 * np.pi * np.round((centres[i] - points[i]).real / (2 * np.pi))
        elif c.least is not None:
            other = 2 * c.least / system.characteristic_length - points[i]
            points[i] = np.where(
                np.abs(other - centres[i]) < np.abs(points[i] - centres[i]), other, points[i]
            )
    if system.projective:
        ray = list(system.projective)
        x = points[ray] / np.linalg.norm(points[ray], axis=0)
        along = np.sum(np.conj(x) * centres[ray], axis=0)
        with np.errstate(all="ignore"):
            points[ray] = x * (along / np.abs(along))
    return points
