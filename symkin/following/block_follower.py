"""Follow one block's branch along an interval of a trajectory, step by step with a proof, up to the
first stop.

Where steps (see `steps`) shrink, a singular point is looked for ahead; a turning point is reached
by a last tube, over which u has one extreme (see `fold`). A branch that comes back to itself after
whole turns of the given angles is known from there on (see `whole_turns`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Literal

import numpy as np

from symkin.following.cubic import Cubic
from symkin.following.dependent_rows import redundant_rows_bound, rows_suffice
from symkin.following.joint_limits import Limit, LimitWatch
from symkin.following.path_system import NEWTON_ARRIVED, PathSystem, along
from symkin.following.singular_point import Fold, SingularPoint, find_singular_point, prove_fold
from symkin.following.station import (
    ALONE,
    Station,
    interval_of,
    station_at,
    station_near,
    stations_near,
)
from symkin.following.steps import Link, Pace, Step, one_step, ways
from symkin.following.trajectory import Trajectory
from symkin.following.tube import Interval, Tubes
from symkin.following.whole_turns import ClosedBranch, closed_branch, whole_turns
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.determination import DIGITS

Ending = Literal["reached", "singular", "limit", "open", "unproved"]

_FIRST_CHANGE = 0.05
"""Change of the unknowns (over the size, or rad) that the first step aims at."""
_SHORTEST_STEP = 1e-12
"""A step of less than this share of an interval is given up."""
MOST_EFFORT = 20_000
"""Steps on one interval after which it is given up."""
_SEARCH_AT = 0.3
"""A singular point is looked for whenever the step is below this times the one of the last
search.
"""
_PIECE = 0.1
"""Change of the unknowns (over the size, or rad) between points from which steps are looked for
ahead.
"""
_FIRST_AHEAD, _MOST_AHEAD = 48, 512
"""Such points at most, at the start and later."""
_SAME_STATION = 1e-9
"""Points that differ by less (over the size, or rad) may be the same."""
_HALVINGS = 40
"""Halvings of a step to the place where loops open: to 1e-12 of it."""
_AT_TURNING_POINT = 1e-9
"""So near a turning point (share of an interval) it is taken without a proof."""
_AT_BIFURCATION = 1e-4
"""So near a bifurcation (share of an interval, or change of the unknowns over the size or in rad),
to which no tube leads, the branch stops.
"""
_MORE_MISFIT = 100.0
"""A path that begins at a configuration of least squares, in loops of redundant constraints that
close only to the digits of a file, is followed while its misfit is below this many times that of
its start.
"""
_ROUNDED_SHARE = 8 * np.finfo(float).eps
"""A share of an interval is told to this: times the slope of an unknown, what its place is told
to."""
SAME_PLACE = 1e-9
"""Blocks that stop within this share of an interval stop at the same place."""


@dataclass(frozen=True, eq=False)
class BlockStop:
    """Why and where (u) a block's branch ends. `fold` leads to a turning point. `residual`
    (length unit) is what is left open; `is_spent`: no step has failed, but as many as one interval
    may take are made.
    """

    ending: Ending
    u: float
    singular: SingularPoint | None = None
    fold: Fold | None = None
    limit: Limit | None = None
    residual: float = 0.0
    is_spent: bool = False


@dataclass(eq=False)
class BlockFollower:
    """One block's branch as far as it has been followed.

    `station` is its end, `passed` the ends of all steps. `steps` counts tubes, of which images
    fill at most `tightest`; `link` is the last one; `curves` are the cubics of the present
    interval with their tubes. `closed_branches` are the intervals (by row) on which the branch
    comes back to itself, `begun` is the first station of the present one. `ahead` holds steps that
    have been proved, by row of the path up to row `looked`, before it is known that they are
    joined; `goes_on` tells that as many were found as are looked for at once. `closed` is the
    largest closure error (length unit) of closed loops. `suffices`: no row is redundant but such as
    follow from the others (see `dependent_rows`).
    """

    system: PathSystem
    trajectory: Trajectory
    watch: LimitWatch
    interval: Interval
    station: Station
    pace: float = _FIRST_CHANGE
    steps: int = 0
    tightest: float = 0.0
    link: Link | None = None
    ahead: dict[int, list[Step]] = field(default_factory=dict)
    looked: int = -1
    goes_on: bool = False
    curves: list[tuple[Cubic, Tubes]] = field(default_factory=list)
    begun: Station | None = None
    closed_branches: dict[int, ClosedBranch] = field(default_factory=dict)
    stop: BlockStop | None = None
    passed: list[Station] = field(default_factory=list)
    closed: float = 0.0
    suffices: bool = True

    @staticmethod
    def begin(
        system: PathSystem, trajectory: Trajectory, watch: LimitWatch, unknown: np.ndarray
    ) -> BlockFollower:
        """Stand at the first sample, whose unknowns (in radians and the length unit) are given."""
        interval = interval_of(system, trajectory, 0)
        size = system.problem.closure.characteristic_length
        station = station_near(interval, 0, unknown[system.places] / system.scale, 0.0)
        follower = BlockFollower(system, trajectory, watch, interval, station)
        known = trajectory.samples[:1]
        follower.suffices = bool(rows_suffice(system, station.z[None], known)[0])
        left, follower.closed = follower._closure_error(follower.station), CLOSURE_TOLERANCE * size
        if follower.closed < left <= DIGITS * size:
            follower.closed = min(_MORE_MISFIT * left, DIGITS * size)
        return follower

    @property
    def is_of_least_squares(self) -> bool:
        """Whether loops that close only to the digits of a file are followed."""
        return self.closed > CLOSURE_TOLERANCE * self.system.problem.closure.characteristic_length

    @property
    def redundant_bound(self) -> float:
        """A bound of redundant rows at the ends of steps (length unit)."""
        if self.system.is_square:
            return 0.0
        rows, which = np.unique([station.row for station in self.passed], return_inverse=True)
        y = np.array([station.y for station in self.passed])
        return redundant_rows_bound(self._intervals(rows.tolist()), y, which.astype(np.intc))

    def _intervals(self, rows: Sequence[int]) -> Interval:
        """The intervals of several rows of the path."""
        c = [interval_of(self.system, self.trajectory, row).c[0] for row in rows]
        return Interval(self.system, np.array(c), self.suffices and not self.system.is_square)

    def enter(self, row: int) -> None:
        """Stand at the beginning of an interval, where the branch may have a corner."""
        self.interval, self.curves = self._intervals([row]), []
        if row > self.looked:
            self._look_ahead(row)
        begin, known = np.append(self.station.z, 0.0), self.ahead.get(row, [])
        if known and known[0].begin.u == 0.0 and self._may_be(known[0].begin, begin):
            self.station = known[0].begin
        else:
            self.station = station_at(self.interval, row, begin)
            self.ahead.pop(row, None)
        if self.link is not None and self.interval.of_combinations:
            combined = self.link.tubes.combined
            self.station = station_at(self.interval, row, self.station.y, combined)
        self._record()
        self.begun = self.station
        away = np.abs(self.station.y - begin)
        if self.link is not None and not self.link.holds(self.station.half, away):
            self.stop = BlockStop("unproved", 0.0)

    def _look_ahead(self, row: int, u: float = 0.0) -> None:
        """Prove steps from here on, all at once, from points to which Newton's method leads; those
        that turn out to be joined to the branch are part of it.
        """
        most = _MOST_AHEAD if self.looked >= 0 else _FIRST_AHEAD
        pieces = list(islice(self._pieces(row, u), most))
        self.goes_on = len(pieces) == most
        if not pieces:
            self.looked = row
            return
        rows, begin, ends = (np.array(v) for v in zip(*pieces, strict=True))
        first, which = np.unique(rows, return_inverse=True)
        interval, which = self._intervals(first.tolist()), which.astype(np.intc)
        found = ways(interval, stations_near(interval, begin, which), ends, which)
        self.looked, self.ahead = int(rows[-1]), {}
        for k, r in enumerate(rows.tolist()):
            self.ahead.setdefault(r, []).extend(found.steps_of(r, k))

    def _pieces(self, row: int, u: float) -> Iterator[tuple[int, np.ndarray, float]]:
        """Where (row, y) Newton's method leads along the path, and the u to which the next step may
        go, up to a place where it leads no further."""
        y = np.append(self.station.z, u)
        samples = self.trajectory.samples
        for r in range(row, len(samples) - 1):
            if np.array_equal(samples[r], samples[r + 1]):
                continue
            if whole_turns(self.trajectory, r) is not None:
                return
            interval = interval_of(self.system, self.trajectory, r)
            y = np.append(y[:-1], u if r == row else 0.0)
            while y[-1] < 1.0:
                slope = along(interval.evaluate(y[None], ALONE)[1])[0]
                speed = float(np.max(np.abs(slope), initial=0.0))
                if not np.isfinite(speed):
                    return
                pieces = math.ceil((1.0 - y[-1]) * speed / _PIECE) or 1
                end = 1.0 if pieces == 1 else float(y[-1] + (1.0 - y[-1]) / pieces)
                yield r, y, end
                guess = np.append(y[:-1] + (end - y[-1]) * slope, end)
                reached, _, size = self.system.correct(guess[None], interval.c)
                if not (size[0] < NEWTON_ARRIVED and np.abs(reached[0] - guess).max() < _PIECE):
                    return
                y = reached[0]

    def _known_step(self, until: float) -> Step | None:
        """The step from here, if it has been proved before; what begins before is left behind."""
        known, station = self.ahead.get(self.station.row, []), self.station
        while known and known[0].begin.u < station.u:
            known.pop(0)
        if not known or known[0].begin.u > station.u or known[0].end.u > until:
            return None
        step = known.pop(0)
        if step.begin is station or (
            np.array_equal(step.begin.y, station.y)
            and np.array_equal(step.begin.half, station.half)  # type: ignore[arg-type]
        ):
            return step
        if station.half is None or not self._may_be(step.begin, station.y):
            return None
        joined = step.tubes.hold(0.0, station.y[None], station.half[None])
        return step if joined[0] else None

    def _may_be(self, station: Station, y: np.ndarray) -> bool:
        """Whether a station that was found ahead is that at y, up to rounding."""
        return bool((np.abs(station.y - y) <= _SAME_STATION).all())

    def go(self, until: float) -> None:
        """Follow the branch to u = `until` of the interval, or the first stop before."""
        h = min(1.0, self.pace / self.station.speed)
        searched, pace = h / _SEARCH_AT, Pace.begun(np.array([h]))
        effort, turn = 0, whole_turns(self.trajectory, self.station.row)
        mark = until if turn is None else min(turn, until)
        while self.station.u < until and self.stop is None:
            station = self.station
            if h < _SHORTEST_STEP or effort > MOST_EFFORT or not station.is_regular:
                if not (station.is_regular and self._meets_singular_point(until)):
                    self.stop = BlockStop(
                        "unproved", station.u, is_spent=station.is_regular and h >= _SHORTEST_STEP
                    )
                return
            if h < _SEARCH_AT * searched and h < 0.5 * (until - station.u):
                searched = h
                if self._meets_singular_point(until):
                    return
            step = self._known_step(mark)
            if step is None and self.goes_on and not self.ahead.get(station.row):
                self._look_ahead(station.row, station.u)
                step = self._known_step(mark)
            if step is None:
                end = mark if station.u + 1.01 * h >= mark else station.u + h
                step = one_step(self.interval, station, end, pace)
                h = float(pace.h[0])
            if step is None:
                continue
            end = step.end.u
            self._accept(step)
            effort += 1
            searched = max(searched, h)
            self.pace = h * self.station.speed
            if turn is not None and self.stop is None and end == mark < until:
                if self._comes_back() and self._skip_to(until):
                    return
                mark = min(mark + turn, until)

    def _comes_back(self) -> bool:
        """Whether the branch is where it began on this interval, up to whole turns: the box of
        its first root lies in the last tube."""
        first, here = self.begun, self.station
        if first is None or first.half is None or self.link is None:
            return False
        closed = closed_branch(self.system, here.u, first.z, here.z)
        away = np.abs(closed.moved(first.z, 1) - here.z) + _ROUNDED_SHARE * np.abs(here.slope)
        if not self.link.holds(first.half + np.append(away, 0.0)):
            return False
        limited = [
            place
            for c, place in zip(self.system.system.unknowns, self.system.system.slices, strict=True)
            if c.limits
        ]
        if not self.watch.off and any(closed.shift[place].any() for place in limited):
            return False
        self.closed_branches[here.row] = closed
        return True

    def _skip_to(self, u: float) -> bool:
        """Stand at a u that is whole turns behind a place of the branch that has been followed,
        if that is what is found there."""
        row = self.station.row
        closed = self.closed_branches[row]
        place, times = closed.folded(u)
        curve, tubes = next((c, t) for c, t in self.curves if place <= c.control[-1, -1])
        share = curve.share_at(place)
        guess = closed.moved(curve.at(share)[:-1], times)
        combined = tubes.combined if self.interval.of_combinations else None
        there = station_near(self.interval, row, guess, u, combined)
        if not there.is_regular or there.half is None:
            return False
        away = np.abs(there.z - guess) + _ROUNDED_SHARE * np.abs(there.slope)
        link = Link(tubes, share, curve.at(share), np.append(away, 0.0))
        if not link.holds(there.half) or self._closure_error(there) > self.closed:
            return False
        # what the next interval begins at is a box within this tube, moved by whole turns
        self.station, self.link = there, link
        return True

    def at(self, u: float) -> np.ndarray:
        """z of the branch at a u of the interval that it has passed, or at which it stops."""
        if self.stop is not None and self.stop.singular is not None:
            point = self.stop.singular
            if abs(point.u - u) <= SAME_PLACE:
                return point.y[:-1]
            if u > self.station.u:
                share = (u - self.station.u) / (point.u - self.station.u)
                return station_near(
                    self.interval, 0, self.station.z + share * (point.y[:-1] - self.station.z), u
                ).z
        if u == self.station.u:
            return self.station.z
        closed, times = self.closed_branches.get(self.station.row), 0
        if closed is not None:
            u, times = closed.folded(u)
        for curve, _ in self.curves:
            if curve.control[0, -1] <= u < curve.control[-1, -1]:
                z = station_near(self.interval, 0, curve.at(curve.share_at(u))[:-1], u).z
                return z if closed is None else closed.moved(z, times)
        return self.station.z

    def _accept(self, step: Step) -> None:
        """Accept a proved step, up to a limit or to the place where loops open."""
        before, self.station, curve = step.begin, step.end, step.curve
        self.steps, self.link = self.steps + 1, step.link
        self.tightest = max(self.tightest, float(step.tubes.tightness[0]))
        self.curves.append((curve, step.tubes))
        met = self.watch.unknown(self.interval, curve)
        if met is not None:
            *z, u = curve.at(met[0])
            self.station = station_near(self.interval, before.row, np.array(z), float(u))
            self.stop = BlockStop("limit", self.station.u, limit=met[1])
        left = self._closure_error(self.station)
        if left > self.closed:
            self.station = self._opening(before, self.station)
            self.stop = BlockStop("open", self.station.u, residual=left)
        self._record()

    def _record(self) -> None:
        """Keep the station among the ends of steps."""
        if math.isfinite(self.station.sigma):
            self.passed.append(self.station)

    def _closure_error(self, station: Station) -> float:
        """The largest closure error at a station (length unit), redundant rows and whole rotations
        included, and those that given values alone must satisfy.
        """
        known = self.trajectory.at(station.row, station.u)
        own = self.system.system.residual(self.system.unknown(station.z), known)
        conditions = self.system.problem.conditions
        if not conditions.errors.numel():
            return own
        return max(own, conditions.residual(np.zeros(0), known))

    def _opening(self, closed: Station, opened: Station) -> Station:
        """The last station between the two at which the loops close, by halving."""
        low, high = closed.u, opened.u
        for _ in range(_HALVINGS):
            middle = station_near(self.interval, closed.row, closed.z, 0.5 * (low + high))
            if self._closure_error(middle) <= self.closed:
                closed, low = middle, middle.u
            else:
                high = middle.u
        return closed

    def _meets_singular_point(self, until: float) -> bool:
        """Whether a singular point lies ahead on this interval, and near enough to stop there."""
        a = self.station
        found = find_singular_point(self.interval, a)
        if found is None or found.u > until + SAME_PLACE:
            return False
        fold = prove_fold(self.interval, a, found) if found.kind == "turning point" else None
        away, near = found.u - a.u, _AT_TURNING_POINT
        if found.kind == "bifurcation":
            away *= min(1.0, float(np.max(np.abs(a.slope), initial=0.0)))
            near = _AT_BIFURCATION
        if fold is None and not away <= near:
            return False
        self.stop = BlockStop("singular", found.u, singular=found, fold=fold)
        return True
