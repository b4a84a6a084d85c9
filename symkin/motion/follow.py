"""Following one branch of solutions along a trajectory, step by step with a proof, up to the first stop.

Each step goes from u to u + h of one interval: Newton at the far end, a cubic with the branch's slopes at both ends, and a
tube about it in which there is exactly one solution for every u (see `step_certificate`). Consecutive tubes are joined at
a point whose own box lies in both. Where steps shrink, a singular point is looked for ahead; a turning point is reached by
a last tube in the direction of the branch, which is regular there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from symkin.motion.path_system import PathSystem, coefficients, least_squares
from symkin.motion.step_certificate import Curve, Interval, Tube
from symkin.motion.trajectory import Trajectory
from symkin.motion.turning_point import SingularPoint, find_singular_point
from symkin.position.solution import ACCEPTED

Ending = Literal["reached", "singular", "limit", "open", "unproved"]

_FIRST = 0.05
"""Change of the unknowns (over the size, or rad) that the first step aims at."""
_SHORTEST = 1e-12
"""A step of less than this share of an interval is given up."""
_MOST_STEPS = 20_000
"""More steps on one interval are given up."""
_GROWTH, _STEADY = 1.6, 1.1
"""Factors of the next step after a proof with room to spare, and after one without."""
_ROOM = 0.75
"""A tube whose image fills less of it than this leaves room to spare."""
_SHRUNK = 0.3
"""A singular point is looked for whenever the step is below this times the one of the last search."""
_HALVINGS = 40
"""Halvings of a step to the place where loops open."""
_CLOSE = 1e-9
"""So near a turning point (share of an interval) it is taken without a last tube."""
_BEFORE = 1e-4
"""So near a bifurcation (share of an interval), to which no tube leads, the branch stops."""


@dataclass(frozen=True, eq=False)
class Station:
    """A point of the branch: y = (z, u) on interval `row`, the slope dz/du, and the half widths (w + 1,) of the box in which
    it is the only root at its u; None where that is not proved."""

    row: int
    y: np.ndarray
    slope: np.ndarray
    half: np.ndarray | None

    @property
    def z(self) -> np.ndarray:
        return self.y[:-1]

    @property
    def u(self) -> float:
        return float(self.y[-1])

    @property
    def is_regular(self) -> bool:
        return bool(np.isfinite(self.slope).all())


@dataclass(frozen=True)
class Limit:
    """A limit of a joint that the branch meets: the coordinate's name and the value."""

    name: str
    value: float


@dataclass(eq=False)
class Branch:
    """What was followed: `stations` at the samples, `last` the end, and why it ended. `joined`: a tube leads to the singular
    point. `residual` (length unit) is what is left open. `steps` counts tubes, of which images fill at most `tightest`; `link` is the last one."""

    stations: list[Station] = field(default_factory=list)
    ending: Ending = "reached"
    last: Station | None = None
    singular: SingularPoint | None = None
    joined: bool = False
    limit: Limit | None = None
    residual: float = 0.0
    steps: int = 0
    tightest: float = 0.0
    link: Tube | None = None


Watch = Callable[[Interval, Station, Curve], "tuple[Station, Limit] | None"]
"""Looks at a proved step from a station for a limit: where it is met first, and which; None where all hold."""


def follow(
    system: PathSystem, trajectory: Trajectory, z: np.ndarray, watch: Watch, progress: Callable[[int, int], None] | None = None
) -> Branch:
    """Follow the branch through z (scaled unknowns at the first sample) until the end or the first stop."""
    branch, pace = Branch(), _FIRST
    station = settled(interval_of(system, trajectory, 0), 0, z, 0.0)
    branch.stations.append(station)
    branch.last = station
    for row in range(len(trajectory) - 1):
        if not np.array_equal(trajectory.samples[row], trajectory.samples[row + 1]):
            interval = interval_of(system, trajectory, row)
            branch.last = station = _standing(interval, row, station.z)
            if branch.link is not None and not branch.link.holds(station.half):
                branch.ending = "unproved"
                return branch
            for reached, ahead in _steps(branch, interval, station, pace, watch):
                left = _left_open(system, trajectory, reached)
                if left > ACCEPTED * system.problem.closure.size:
                    branch.ending, branch.residual = "open", left
                    branch.last = _opening(system, trajectory, interval, station, reached)
                    return branch
                branch.last, station, pace = reached, reached, ahead
            if branch.ending != "reached":
                return branch
        branch.stations.append(station)
        if progress is not None:
            progress(row + 1, len(trajectory) - 1)
    return branch


def interval_of(system: PathSystem, trajectory: Trajectory, row: int) -> Interval:
    """The rows along the interval after sample `row`; about the last sample they stand still."""
    samples = trajectory.samples
    return Interval(system, coefficients(system.problem, samples[row], samples[min(row + 1, len(samples) - 1)]))


def settled(interval: Interval, row: int, z: np.ndarray, u: float) -> Station:
    """The station that Newton reaches at a fixed u; its slope is NaN where it reaches none."""
    z, jacobian, size = interval.system.correct(z, u, interval.c)
    y = np.append(z, u)
    if not size < 1e-7:
        return Station(row, y, np.full(len(z), np.nan), None)
    return _station(interval, row, y, jacobian)


def _standing(interval: Interval, row: int, z: np.ndarray) -> Station:
    """The same point as the beginning of the next interval, where the branch may have a corner."""
    y = np.append(z, 0.0)
    return _station(interval, row, y, interval.evaluate(y)[1])


def _station(interval: Interval, row: int, y: np.ndarray, jacobian: np.ndarray) -> Station:
    slope = -least_squares(jacobian[:, :-1], jacobian[:, -1])
    return Station(row, y, slope, interval.point(y, along_parameter(len(y)), jacobian))


def along_parameter(n: int) -> np.ndarray:
    """The direction of u."""
    return np.append(np.zeros(n - 1), 1.0)


def _steps(branch: Branch, interval: Interval, station: Station, pace: float, watch: Watch) -> Iterator[tuple[Station, float]]:
    """Stations on one interval, each with the change of the unknowns that the next step aims at."""
    h = min(1.0, pace / _speed(station))
    searched = h / _SHRUNK
    most = branch.steps + _MOST_STEPS
    while station.u < 1.0:
        if h < _SHORTEST or branch.steps > most or not station.is_regular:
            branch.ending = "unproved"
            return
        if h < _SHRUNK * searched and h < 0.5 * (1.0 - station.u):
            searched = h
            if _meets_singular_point(branch, interval, station):
                return
        end = 1.0 if station.u + 1.01 * h >= 1.0 else station.u + h
        found = _step(interval, station, end)
        if found is None:
            h = 0.5 * (end - station.u)
            continue
        reached, curve, tube = found
        branch.steps, branch.link = branch.steps + 1, tube
        branch.tightest = max(branch.tightest, tube.tightness)
        met = watch(interval, station, curve)
        if met is not None:
            branch.ending, branch.limit = "limit", met[1]
            yield met[0], pace
            return
        h = (end - station.u) * (_GROWTH if tube.tightness < _ROOM else _STEADY)
        searched = max(searched, h)
        station = reached
        yield station, h * _speed(station)


def _step(interval: Interval, a: Station, end: float) -> tuple[Station, Curve, Tube] | None:
    """A proved step to u = end, or None."""
    h = end - a.u
    b = settled(interval, a.row, a.z + h * a.slope, end)
    if not b.is_regular:
        return None
    curve = Curve.hermite(a.y, np.append(a.slope, 1.0), b.y, np.append(b.slope, 1.0), h)
    tube = interval.tube(curve, along_parameter(len(a.y)), a.half, b.half)
    return None if tube is None else (b, curve, tube)


def _speed(station: Station) -> float:
    speed = float(np.max(np.abs(station.slope), initial=0.0))
    return speed + 1e-3 if np.isfinite(speed) else 1.0


def _left_open(system: PathSystem, trajectory: Trajectory, station: Station) -> float:
    """The largest closure error at a station (length unit), redundant rows and whole rotations included."""
    return system.problem.system.residual(system.unknown(station.z), trajectory.at(station.row, station.u))


def _opening(system: PathSystem, trajectory: Trajectory, interval: Interval, closed: Station, opened: Station) -> Station:
    """The last station between the two at which the loops close, by halving."""
    low, high = closed.u, opened.u
    for _ in range(_HALVINGS):
        middle = settled(interval, closed.row, closed.z, 0.5 * (low + high))
        if _left_open(system, trajectory, middle) <= ACCEPTED * system.problem.closure.size:
            closed, low = middle, middle.u
        else:
            high = middle.u
    return closed


def _meets_singular_point(branch: Branch, interval: Interval, station: Station) -> bool:
    """Whether a singular point lies ahead on this interval, and near enough to stop there."""
    found = find_singular_point(interval.system, interval.c, station.y, station.slope)
    if found is None or found.u > 1.0 + 1e-9:
        return False
    joined = found.kind == "turning point" and _is_joined(interval, station, found)
    nearest = _BEFORE if found.kind == "bifurcation" else _CLOSE
    if not joined and found.u - station.u > nearest:
        return False
    branch.ending, branch.singular, branch.joined = "singular", found, joined
    return True


def _is_joined(interval: Interval, a: Station, point: SingularPoint) -> bool:
    """Whether a tube over the null vector's direction leads from a station to the turning point, where it is the branch's own."""
    v = point.null[:, 0]
    direction = np.append(v if v @ a.slope > 0.0 else -v, 0.0)
    length = float(direction @ (point.y - a.y))
    pace = float(direction[:-1] @ a.slope)
    if length <= 0.0 or pace <= 0.0:
        return False
    curve = Curve.hermite(a.y, np.append(a.slope, 1.0) / pace, point.y, direction, length)
    return interval.tube(curve, direction, a.half) is not None
