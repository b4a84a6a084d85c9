"""Points of one block's branch: a root of its rows at a path parameter, the slope there, and the
box that holds no other root.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from symkin.certificate.independent_rows import most_independent
from symkin.computed_once import lru_cache
from symkin.following.ball_matrices import balls
from symkin.following.path_system import NEWTON_ARRIVED, PathSystem, coefficients, least_squares
from symkin.following.step_certificate import BITS, Interval
from symkin.following.trajectory import Trajectory
from symkin.numeric.balls import UP, precision, upper


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
    sigma: float = math.nan

    @property
    def z(self) -> np.ndarray:
        """The unknowns."""
        return self.y[:-1]

    @property
    def u(self) -> float:
        """The path parameter on the interval."""
        return float(self.y[-1])

    @property
    def is_regular(self) -> bool:
        """Whether the branch has a slope there."""
        return bool(np.isfinite(self.slope).all())

    @property
    def speed(self) -> float:
        """The largest change of an unknown per unit of u, never quite zero."""
        speed = float(np.max(np.abs(self.slope), initial=0.0))
        return speed + 1e-3 if np.isfinite(speed) else 1.0


def interval_of(system: PathSystem, trajectory: Trajectory, row: int) -> Interval:
    """The rows along the interval after sample `row`; about the last sample they stand still."""
    samples = trajectory.samples
    return Interval(
        system, coefficients(system.problem, samples[row], samples[min(row + 1, len(samples) - 1)])
    )


def station_near(interval: Interval, row: int, z: np.ndarray, u: float) -> Station:
    """The station that Newton reaches from z at a fixed u; its slope is NaN where it reaches
    none.
    """
    y, jacobian, size = interval.system.correct(np.append(z, u), interval.c)
    if not size < NEWTON_ARRIVED:
        return Station(row, y, slope=np.full(len(z), np.nan), half=None)
    return station_at(interval, row, y, jacobian)


def station_at(interval: Interval, row: int, y: np.ndarray, jacobian: np.ndarray) -> Station:
    """The station at a root y with dG/dy there: dz/du = -(dG/dz)^-1 dG/du."""
    slope = -least_squares(jacobian[:, :-1], jacobian[:, -1])
    singular = (
        np.linalg.svd(jacobian[:, :-1], compute_uv=False)
        if len(y) > 1 and np.isfinite(jacobian).all()
        else np.zeros(0)
    )
    sigma = float(singular[-1]) if len(singular) == len(y) - 1 and len(singular) else math.nan
    return Station(row, y, slope, interval.point(y, along_parameter(len(y)), jacobian), sigma)


def along_parameter(n: int) -> np.ndarray:
    """The direction of u."""
    return np.append(np.zeros(n - 1), 1.0)


def redundant_rows_bound(interval: Interval, y: np.ndarray) -> float:
    """An upper bound (length unit) of every row at the one exact root near y, at its u, of as many
    independent rows as unknowns; infinite where no such root is proved.
    """
    system = interval.system
    jacobian = interval.evaluate(y)[1]
    chosen = tuple(
        np.flatnonzero(most_independent(jacobian[None, :, :-1], system.width)[0]).tolist()
    )
    if len(chosen) < system.width:
        return float("inf")
    half = Interval(_with_rows(system, chosen), interval.c).point(
        y, along_parameter(len(y)), jacobian[list(chosen)]
    )
    if half is None:
        return float("inf")
    with precision(BITS):
        values = interval.series(0, balls(y, half))
        others = [upper(v) for i, v in enumerate(values) if i not in chosen]
    return max(others, default=0.0) * system.problem.closure.characteristic_length * UP


@lru_cache(maxsize=128)
def _with_rows(system: PathSystem, chosen: tuple[int, ...]) -> PathSystem:
    return replace(system, rows=system.rows[list(chosen), 0])
