"""Coordinates of roots: writings of one root, and how much coordinates can differ within a box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from flint import arb

from symkin.caching import cached_property, lru_cache
from symkin.certificate.ball_system import BallSystem
from symkin.certificate.balls import REAL, BallFunction, precision, upper
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.spatial.rotation import conjugate, multiply

_ROUNDING = 2.0**-49
"""Allowance for coordinates that are computed from z in double precision, relative to 1 and to each coordinate."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates of a system's real roots at given known values."""

    balls: BallSystem

    @cached_property
    def _prepared(self) -> list[Any]:
        with precision(64):
            return _coordinates(self.balls.system).prepare(REAL, self.balls.known)

    def spread(self, point: np.ndarray, distance: float) -> float:
        """No coordinate at a real point within `distance` of `point` (width,) differs by more from the one at `point`:
        lengths and position over the size, angles, unit quaternion."""
        with precision(64):
            side = arb(0.0, distance)
            z = [arb(v) + side for v in point.real.tolist()]
            values = _coordinates(self.balls.system).evaluate(0, z, self._prepared)
            return max((2.0 * upper(v.rad()) + _ROUNDING * (1.0 + upper(v)) for v in values), default=0.0)


@lru_cache(maxsize=64)
def _coordinates(system: AlgebraicSystem) -> BallFunction:
    """Coordinates of a root, lengths in units of the size: affine ones, eliminated angles, position, unit quaternion."""
    parts = [system.z[i] for i in range(len(system.unknowns))] + [angle for _, angle in system.eliminated]
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
        ray = list(system.projective)
        x = z[ray]
        largest = x[np.argmax(np.abs(x), axis=0), np.arange(x.shape[1])]
        with np.errstate(all="ignore"):
            x = x * (np.conj(largest) / np.abs(largest))
            z[ray] = x / np.linalg.norm(x, axis=0)
    return z


def aligned(system: AlgebraicSystem, point: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """The same root as `point` (width,), written as near as possible to each of the centres (width, n): angles by whole
    turns, rods by the sign of their length, rays by their phase."""
    points = np.repeat(point[:, None], centres.shape[1], axis=1)
    for i, c in enumerate(system.unknowns):
        if c.kind == "angle":
            points[i] += 2 * np.pi * np.round((centres[i] - points[i]).real / (2 * np.pi))
        elif c.least is not None:
            other = 2 * c.least / system.size - points[i]
            points[i] = np.where(np.abs(other - centres[i]) < np.abs(points[i] - centres[i]), other, points[i])
    if system.projective:
        ray = list(system.projective)
        x = point[ray] / np.linalg.norm(point[ray])
        along = np.conj(x) @ centres[ray]
        with np.errstate(all="ignore"):
            points[ray] = x[:, None] * (along / np.abs(along))
    return points
