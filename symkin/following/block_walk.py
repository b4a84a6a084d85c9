"""Following one block's branch along an interval of a trajectory, step by step with a proof, up to the first stop.

Each step goes from u to u + h of one interval: Newton at the far end, a cubic with the branch's slopes at both ends, and a
tube about it in which there is exactly one solution for every u (see `step_certificate`). Consecutive tubes are joined at
a point whose own box lies in both. Where steps shrink, a singular point is looked for ahead; a turning point is reached by
a last tube in the direction of the branch, which is regular there (see `last_tube`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from symkin.following.cubic import Curve
from symkin.following.joint_limits import Limit, LimitWatch
from symkin.following.last_tube import Arrival, arrival
from symkin.following.path_system import PathSystem, coefficients, least_squares
from symkin.following.redundant_rows import left_on_others
from symkin.following.series_tube import series_tube
from symkin.following.step_certificate import Interval, Tube
from symkin.following.trajectory import Trajectory
from symkin.following.turning_point import SingularPoint, find_singular_point
from symkin.position.problem import Problem
from symkin.position.solution import ACCEPTED

Ending = Literal["reached", "singular", "limit", "open", "unproved"]

_FIRST = 0.05
"""Change of the unknowns (over the size, or rad) that the first step aims at."""
_SHORTEST = 1e-12
"""A step of less than this share of an interval is given up."""
_MOST_EFFORT = 20_000
"""Steps on one interval after which it is given up; those that need a longer proof count `_LONGER`."""
_LONGER = 10
"""What a step with a longer proof counts, about its time over a plain one's."""
_GROWTH, _STEADY = 1.6, 1.1
"""Factors of the next step after a proof with room to spare, and after one without."""
_ROOM = 0.75
"""A tube whose image fills less of it than this leaves room to spare."""
_SHRUNK = 0.3
"""A singular point is looked for whenever the step is below this times the one of the last search."""
_STUCK = 0.05
"""Where steps that change the unknowns by less than this (over the size, or rad) have no plain tube, a longer proof is tried."""
_HALVINGS = 40
"""Halvings of a step to the place where loops open."""
_CLOSE = 1e-9
"""So near a turning point (share of an interval) it is taken without a last tube."""
_BEFORE = 1e-4
"""So near a bifurcation (share of an interval, or change of the unknowns over the size or in rad), to which no tube leads, the
branch stops."""
TOGETHER = 1e-9
"""Blocks that stop within this share of an interval stop at the same place."""


@dataclass(frozen=True, eq=False)
class Station:
    """A point of the branch: y = (z, u) on interval `row`, the slope dz/du, and the half widths (w + 1,) of the box in which
    it is the only root at its u; None where that is not proved."""

    row: int
    y: np.ndarray
    slope: np.ndarray
    half: np.ndarray | None
    sigma: float = math.nan

    @property
    def z(self) -> np.ndarray:
        return self.y[:-1]

    @property
    def u(self) -> float:
        return float(self.y[-1])

    @property
    def is_regular(self) -> bool:
        return bool(np.isfinite(self.slope).all())


@dataclass(frozen=True, eq=False)
class Passed:
    """The end of a step: z at u of the interval after sample `row`, and the smallest singular value of dG/dz."""

    row: int
    u: float
    z: np.ndarray
    sigma: float


@dataclass(frozen=True, eq=False)
class BlockStop:
    """Why and where (u) a block's branch ends. `arrival`: a tube leads to the turning point. `residual` (length unit) is what
    is left open."""

    ending: Ending
    u: float
    singular: SingularPoint | None = None
    arrival: Arrival | None = None
    limit: Limit | None = None
    residual: float = 0.0


@dataclass(eq=False)
class Walk:
    """One block's branch. `steps` counts tubes, of which images fill at most `tightest`; `link` is the last one, `curves` are
    those of the present interval; `passed` are the intervals behind; `left` bounds redundant rows at the ends of steps (length unit);
    `is_clear`: the last search has found no singular point ahead."""

    system: PathSystem
    trajectory: Trajectory
    watch: LimitWatch
    interval: Interval
    station: Station
    pace: float = _FIRST
    steps: int = 0
    tightest: float = 0.0
    link: Tube | None = None
    curves: list[Curve] = field(default_factory=list)
    is_clear: bool = False
    stop: BlockStop | None = None
    passed: list[Passed] = field(default_factory=list)
    left: float = 0.0

    @staticmethod
    def begin(system: PathSystem, trajectory: Trajectory, watch: LimitWatch, unknown: np.ndarray) -> Walk:
        """Stand at the first sample, whose unknowns (in radians and the length unit) are given."""
        interval = interval_of(system, trajectory, 0)
        return Walk(system, trajectory, watch, interval, settled(interval, 0, unknown[system.places] / system.scale, 0.0))

    def enter(self, row: int) -> None:
        """Stand at the beginning of an interval, where the branch may have a corner."""
        self.interval, self.curves = interval_of(self.system, self.trajectory, row), []
        y = np.append(self.station.z, 0.0)
        self.station = _station(self.interval, row, y, self.interval.evaluate(y)[1])
        self._pass()
        if self.link is not None and not self.link.holds(self.station.half):
            self.stop = BlockStop("unproved", 0.0)

    def go(self, until: float) -> None:
        """Follow the branch to u = `until` of the interval, or the first stop before."""
        h = min(1.0, self.pace / _speed(self.station))
        searched = h / _SHRUNK
        effort = 0
        while self.station.u < until and self.stop is None:
            station = self.station
            if h < _SHORTEST or effort > _MOST_EFFORT or not station.is_regular:
                if not (station.is_regular and self._meets_singular_point(until)):
                    self.stop = BlockStop("unproved", station.u)
                return
            if h < _SHRUNK * searched and h < 0.5 * (until - station.u):
                searched = h
                if self._meets_singular_point(until):
                    return
            end = until if station.u + 1.01 * h >= until else station.u + h
            found = _step(self.interval, station, end, longer=self.is_clear)
            if found is None:
                h = 0.5 * (end - station.u)
                continue
            self._take(*found)
            effort += 1 if found[2].frame is None else _LONGER
            h = (end - station.u) * (_GROWTH if self.link is not None and self.link.tightness < _ROOM else _STEADY)
            searched = max(searched, h)
            self.pace = h * _speed(self.station)

    def at(self, u: float) -> np.ndarray:
        """z of the branch at a u of the interval that it has passed, or at which it stops."""
        if self.stop is not None and self.stop.singular is not None:
            point = self.stop.singular
            if abs(point.u - u) <= TOGETHER:
                return point.y[:-1]
            if u > self.station.u:
                share = (u - self.station.u) / (point.u - self.station.u)
                return settled(self.interval, 0, self.station.z + share * (point.y[:-1] - self.station.z), u).z
        for curve in self.curves:
            if curve.control[0, -1] <= u < curve.control[-1, -1]:
                return settled(self.interval, 0, curve.at((u - curve.control[0, -1]) / curve.length)[:-1], u).z
        return self.station.z

    def _take(self, reached: Station, curve: Curve, tube: Tube) -> None:
        """Accept a proved step, up to a limit or to the place where loops open."""
        before, self.station = self.station, reached
        self.steps, self.link, self.tightest = self.steps + 1, tube, max(self.tightest, tube.tightness)
        self.curves.append(curve)
        if not self.system.is_square:
            self.left = max(self.left, left_on_others(self.interval, reached.y))
        met = self.watch.unknown(self.interval, curve)
        if met is not None:
            self.station = settled(self.interval, before.row, curve.at(met[0])[:-1], float(curve.at(met[0])[-1]))
            self.stop = BlockStop("limit", self.station.u, limit=met[1])
        left = self._left_open(self.station)
        if left > ACCEPTED * self.system.problem.closure.size:
            self.station = self._opening(before, self.station)
            self.stop = BlockStop("open", self.station.u, residual=left)
        self._pass()

    def _pass(self) -> None:
        """Keep the station among those at which steps end."""
        s = self.station
        if math.isfinite(s.sigma):
            self.passed.append(Passed(s.row, s.u, s.z, s.sigma))

    def _left_open(self, station: Station) -> float:
        """The largest closure error at a station (length unit), redundant rows and whole rotations included, and those that
        given values alone must satisfy."""
        known = self.trajectory.at(station.row, station.u)
        own = self.system.system.residual(self.system.unknown(station.z), known)
        return max(own, left_by_given(self.system.problem, known))

    def _opening(self, closed: Station, opened: Station) -> Station:
        """The last station between the two at which the loops close, by halving."""
        low, high = closed.u, opened.u
        for _ in range(_HALVINGS):
            middle = settled(self.interval, closed.row, closed.z, 0.5 * (low + high))
            if self._left_open(middle) <= ACCEPTED * self.system.problem.closure.size:
                closed, low = middle, middle.u
            else:
                high = middle.u
        return closed

    def _meets_singular_point(self, until: float) -> bool:
        """Whether a singular point lies ahead on this interval, and near enough to stop there."""
        a = self.station
        found = find_singular_point(self.interval.system, self.interval.c, a.y, a.slope)
        self.is_clear = found is None or found.u > until + TOGETHER
        if found is None or self.is_clear:
            return False
        tube = arrival(self.interval, a.y, a.slope, a.half, found) if found.kind == "turning point" else None
        away = found.u - a.u
        moves = away * min(1.0, float(np.max(np.abs(a.slope), initial=0.0)))
        near = moves <= _BEFORE if found.kind == "bifurcation" else away <= _CLOSE
        if tube is None and not near:
            return False
        self.stop = BlockStop("singular", found.u, singular=found, arrival=tube)
        return True


def left_by_given(problem: Problem, known: np.ndarray) -> float:
    """The largest error (length unit) of the conditions on given values alone."""
    return problem.conditions.residual(np.zeros(0), known) if problem.conditions.errors.numel() else 0.0


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


def _station(interval: Interval, row: int, y: np.ndarray, jacobian: np.ndarray) -> Station:
    slope = -least_squares(jacobian[:, :-1], jacobian[:, -1])
    singular = np.linalg.svd(jacobian[:, :-1], compute_uv=False) if len(y) > 1 and np.isfinite(jacobian).all() else np.zeros(0)
    sigma = float(singular[-1]) if len(singular) == len(y) - 1 and len(singular) else math.nan
    return Station(row, y, slope, interval.point(y, along_parameter(len(y)), jacobian), sigma)


def along_parameter(n: int) -> np.ndarray:
    """The direction of u."""
    return np.append(np.zeros(n - 1), 1.0)


def _step(interval: Interval, a: Station, end: float, *, longer: bool) -> tuple[Station, Curve, Tube] | None:
    """A proved step to u = end, or None; with the longer proof, where it is allowed and steps are short."""
    h = end - a.u
    b = settled(interval, a.row, a.z + h * a.slope, end)
    if not b.is_regular:
        return None
    curve = Curve.hermite(a.y, np.append(a.slope, 1.0), b.y, np.append(b.slope, 1.0), h)
    tube = interval.tube(curve, along_parameter(len(a.y)), a.half, b.half)
    if tube is None and longer and h * _speed(a) < _STUCK:
        tube = series_tube(interval, curve, a.half, b.half)
    return None if tube is None else (b, curve, tube)


def _speed(station: Station) -> float:
    speed = float(np.max(np.abs(station.slope), initial=0.0))
    return speed + 1e-3 if np.isfinite(speed) else 1.0
