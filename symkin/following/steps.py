"""Go along branches step by step with a proof: many at once, each on an interval of its own.

Each step goes from u to u + h: Newton at the far end, a cubic with the branch's slopes at both
ends, and a tube about it in which there is exactly one solution for every u (see `tube`).
Consecutive tubes are joined at a point whose own box lies in both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.following.cubic import Cubic
from symkin.following.station import ALONE, Station, Stations, stations_near
from symkin.following.tube import Interval, Tubes

_MOST_EFFORT = 0.12
"""Effort of a tube (see `Tubes`) that a pace aims at, at most."""
_LESS, _MORE = 0.5, 1.1
"""Factors of what is aimed at after a tube that was not proved, and after one that was."""
_LEAST_CHANGE, _MOST_CHANGE, _AFTER_FAILURE = 0.3, 2.0, 0.7
"""Factors between which the next step's length lies over the last one's; at most the third one
where that was not proved.
"""
_SHORTEST_SHARE = 2e-3
"""Steps of many branches below this share of their way are left to whoever follows one."""


@dataclass(frozen=True, eq=False)
class Step:
    """A proved step between two points of a branch, with the cubic and the tube about it."""

    begin: Station
    end: Station
    curve: Cubic
    tubes: Tubes

    @property
    def link(self) -> Link:
        """What the next step is joined to."""
        return Link(self.tubes, 1.0, self.end.y)


@dataclass(frozen=True, eq=False)
class Link:
    """A proved tube, and the branch's point y at a share of it, up to `away`."""

    tubes: Tubes
    share: float
    y: np.ndarray
    away: np.ndarray | float = 0.0

    def holds(self, half: np.ndarray | None, away: np.ndarray | float = 0.0) -> bool:
        """Whether a box of these half widths about the point, up to `away`, lies in the tube."""
        if half is None:
            return False
        wide = half + self.away + away
        return bool(self.tubes.hold(self.share, self.y[None], wide[None])[0])


def steps(
    interval: Interval, a: Stations, ends: np.ndarray, which: np.ndarray
) -> tuple[Stations, Cubic, Tubes, np.ndarray]:
    """Steps from stations to path parameters `ends` (n,): where they lead, cubics with the
    branches' slopes at both ends, tubes about these, and whether each is proved to hold one
    solution for every u of its step (n,).
    """
    h = ends - a.y[:, -1]
    y = a.y + h[:, None] * a.tangent
    y[:, -1] = ends
    b = stations_near(interval, y, which)
    curve = between((a.y, a.tangent), (b.y, b.tangent))
    tubes = interval.tubes(curve, which, a.half, b.half)
    if interval.of_combinations:
        b.half[:] = stations_near(interval, b.y, which, tubes.combined).half
    proved = tubes.grows & tubes.hold(0.0, a.y, a.half) & tubes.hold(1.0, b.y, b.half)
    return b, curve, tubes, proved


def between(a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]) -> Cubic:
    """Cubics from points with tangents (n, w + 1) to others, over the length along the chord: near
    a fold the path parameter would tell of unknowns that turn about."""
    chord = b[0] - a[0]
    length = np.linalg.norm(chord, axis=1)
    with np.errstate(all="ignore"):
        along = chord / length[:, None]
        slopes = [t / np.sum(t * along, axis=1, keepdims=True) for _, t in (a, b)]
    return Cubic.hermite(a[0], slopes[0], b[0], slopes[1], length)


@dataclass(eq=False)
class Pace:
    """Lengths `h` (n,) of the next steps of branches, and the efforts of their tubes that these aim
    at."""

    h: np.ndarray
    aims: np.ndarray

    @staticmethod
    def begun(h: np.ndarray) -> Pace:
        """The pace of first steps."""
        return Pace(h, np.full(len(h), _MOST_EFFORT))

    def learn(
        self, numbers: np.ndarray, h: np.ndarray, effort: np.ndarray, proved: np.ndarray
    ) -> None:
        """Go on after steps of some branches, which tubes of this effort proved or did not."""
        aims = self.aims[numbers] * np.where(proved, _MORE, _LESS)
        self.aims[numbers] = np.minimum(aims, _MOST_EFFORT)
        with np.errstate(all="ignore"):
            # an effort grows about as the square of a step
            wanted = np.sqrt(self.aims[numbers] / effort)
        most = np.where(proved, _MOST_CHANGE, _AFTER_FAILURE)
        self.h[numbers] = h * np.clip(wanted, _LEAST_CHANGE, most)


def one_step(interval: Interval, station: Station, end: float, pace: Pace) -> Step | None:
    """The step of one branch to u = end, None where it is not proved."""
    found, curve, tubes, proved = steps(interval, station.several, np.array([end]), ALONE)
    pace.learn(ALONE, np.array([end - station.u]), tubes.effort, proved)
    if not proved[0]:
        return None
    return Step(station, found.one(station.row), curve.among(0), tubes)


@dataclass(frozen=True, eq=False)
class Ways:
    """What was proved of branches (n,): `rounds` of steps, each with the numbers of the branches
    that it took on, and `last`, where each has come to."""

    rounds: tuple[tuple[np.ndarray, Stations, Stations, Cubic, Tubes], ...]
    last: Stations

    def steps_of(self, row: int, k: int) -> list[Step]:
        """The steps of a branch, in order; its interval is that of a row of a trajectory."""
        found = []
        for numbers, a, b, curve, tubes in self.rounds:
            place = int(np.searchsorted(numbers, k))
            if place < len(numbers) and numbers[place] == k:
                begin, end = a.one(row, place), b.one(row, place)
                tube = tubes.among(slice(place, place + 1))
                found.append(Step(begin, end, curve.among(place), tube))
        return found


def ways(interval: Interval, begin: Stations, ends: np.ndarray, which: np.ndarray) -> Ways:
    """Go along branches from stations to path parameters `ends` (n,), as far as that is easy."""
    at = begin.among(np.arange(len(ends)))
    whole = ends - begin.y[:, -1]
    pace, rounds = Pace.begun(whole.copy()), []
    going = np.flatnonzero(at.is_regular & (whole > 0.0))
    while len(going):
        a, left = at.among(going), ends[going] - at.y[going, -1]
        reach = np.where(1.01 * pace.h[going] >= left, left, pace.h[going])
        target = np.where(reach == left, ends[going], a.y[:, -1] + reach)
        b, curve, tubes, proved = steps(interval, a, target, which[going])
        pace.learn(going, reach, tubes.effort, proved)
        taken = np.flatnonzero(proved)
        rounds.append(
            (
                going[taken],
                a.among(taken),
                b.among(taken),
                curve.among(taken),
                tubes.among(taken),
            )
        )
        at.put(going[taken], b.among(taken))
        goes = (at.y[:, -1] < ends) & (pace.h > _SHORTEST_SHARE * whole)
        going = going[goes[going]]
    return Ways(tuple(rounds), at)
