"""Points of a block's branches: roots of its rows at path parameters, the slopes there, and boxes
that hold no other root. Those of many branches go together, each on an interval of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.following.path_system import NEWTON_ARRIVED, PathSystem, along
from symkin.following.trajectory import Trajectory, coefficients
from symkin.following.tube import Interval

ALONE = np.zeros(1, dtype=np.intc)
"""The number of the only interval."""


@dataclass(frozen=True, eq=False)
class Stations:
    """Points of branches: y (n, w + 1) = (z, u), the slopes dz/du (n, w), NaN where there is none,
    and the half widths (n, w + 1) of boxes in which they are the only roots at their u, infinite
    where that is not proved; `sigma` (n,) are the smallest singular values of dG/dz.
    """

    y: np.ndarray
    slope: np.ndarray
    half: np.ndarray
    sigma: np.ndarray

    @property
    def is_regular(self) -> np.ndarray:
        """Whether branches have slopes there (n,)."""
        return np.isfinite(self.slope).all(axis=1)

    @property
    def speed(self) -> np.ndarray:
        """The largest changes of unknowns per unit of u (n,), never quite zero."""
        speed = np.max(np.abs(self.slope), axis=1, initial=0.0) + 1e-3
        return np.where(np.isfinite(speed), speed, 1.0)

    @property
    def tangent(self) -> np.ndarray:
        """dy/du (n, w + 1)."""
        return np.concatenate([self.slope, np.ones((len(self.slope), 1))], axis=1)

    def among(self, chosen: np.ndarray) -> Stations:
        """Some of the points."""
        return Stations(*(a[chosen] for a in (self.y, self.slope, self.half, self.sigma)))

    def put(self, chosen: np.ndarray, others: Stations) -> None:
        """Go on to other points, where `chosen` says so."""
        for own, new in zip(vars(self).values(), vars(others).values(), strict=True):
            own[chosen] = new

    def one(self, row: int, k: int = 0) -> Station:
        """One of the points, on an interval of a trajectory."""
        half = self.half[k] if np.isfinite(self.half[k]).all() else None
        return Station(row, self.y[k], self.slope[k], half, float(self.sigma[k]))


@dataclass(frozen=True, eq=False)
class Station:
    """A point of the branch: y = (z, u) on interval `row`, the slope dz/du, and the half widths
    (w + 1,) of the box in which it is the only root at its u, None where that is not proved;
    `sigma` is the smallest singular value of dG/dz.
    """

    row: int
    y: np.ndarray
    slope: np.ndarray
    half: np.ndarray | None
    sigma: float

    @property
    def z(self) -> np.ndarray:
        """The unknowns."""
        return self.y[:-1]

    @property
    def u(self) -> float:
        """The path parameter on the interval."""
        return float(self.y[-1])

    @property
    def several(self) -> Stations:
        """The only one of several."""
        half = np.full(len(self.y), np.inf) if self.half is None else self.half
        return Stations(*(np.array(v)[None] for v in (self.y, self.slope, half, self.sigma)))

    @property
    def is_regular(self) -> bool:
        """Whether the branch has a slope there."""
        return bool(np.isfinite(self.slope).all())

    @property
    def speed(self) -> float:
        """The largest change of an unknown per unit of u, never quite zero."""
        return float(self.several.speed[0])


def interval_of(system: PathSystem, trajectory: Trajectory, row: int) -> Interval:
    """The rows along the interval after sample `row`; about the last sample they stand still."""
    samples = trajectory.samples
    ends = samples[row], samples[min(row + 1, len(samples) - 1)]
    c = coefficients(trajectory.coordinates, *ends)
    return Interval(system, c[None])


def station_near(
    interval: Interval, row: int, z: np.ndarray, u: float, combined: np.ndarray | None = None
) -> Station:
    """The station that Newton reaches from z at a fixed u; its slope is NaN where it reaches
    none.
    """
    return stations_near(interval, np.append(z, u)[None], ALONE, combined).one(row)


def station_at(
    interval: Interval, row: int, y: np.ndarray, combined: np.ndarray | None = None
) -> Station:
    """The station at a root y."""
    jacobian = interval.evaluate(y[None], ALONE)[1]
    return _stations_at(interval, y[None], jacobian, ALONE, combined).one(row)


def stations_near(
    interval: Interval, y: np.ndarray, which: np.ndarray, combined: np.ndarray | None = None
) -> Stations:
    """The stations that Newton reaches from points at their u, with boxes of `combined` rows."""
    y, jacobian, size = interval.system.correct(y, interval.c[which])
    found = _stations_at(interval, y, jacobian, which, combined)
    lost = ~(size < NEWTON_ARRIVED)
    found.slope[lost], found.half[lost], found.sigma[lost] = np.nan, np.inf, np.nan
    return found


def _stations_at(
    interval: Interval,
    y: np.ndarray,
    jacobian: np.ndarray,
    which: np.ndarray,
    combined: np.ndarray | None,
) -> Stations:
    """The stations at roots y with dG/dy there: dz/du = -(dG/dz)^-1 dG/du."""
    width = interval.system.width
    slope = along(jacobian)
    across = np.eye(width + 1)[:, :-1]
    half = interval.boxes(y, jacobian, across, which, combined)
    return Stations(y, slope, half, _least_singular_values(jacobian))


def singular_values_near(interval: Interval, y: np.ndarray) -> np.ndarray:
    """The smallest singular values (n,) of dG/dz at the roots that Newton reaches from points of
    one interval at their u, infinite where it reaches none."""
    _, jacobian, size = interval.system.correct(y, np.repeat(interval.c, len(y), axis=0))
    sigma = _least_singular_values(jacobian)
    return np.where((size < NEWTON_ARRIVED) & np.isfinite(sigma), sigma, np.inf)


def _least_singular_values(jacobian: np.ndarray) -> np.ndarray:
    """Those (n,) of dG/dz, NaN where it is not finite or has too few rows."""
    sigma, width = np.full(len(jacobian), np.nan), jacobian.shape[2] - 1
    fine = np.isfinite(jacobian).all(axis=(1, 2))
    if width and jacobian.shape[1] >= width:
        sigma[fine] = np.linalg.svd(jacobian[fine, :, :-1], compute_uv=False)[:, -1]
    return sigma
