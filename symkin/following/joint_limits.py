"""Find where a followed branch first meets a joint limit.

As in `solve`, an angle's limits hold whole turns apart: the turns that bring it within its limits
at the start, if any do, are subtracted along the whole path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from symkin.following.cubic import Cubic
from symkin.following.path_system import PathSystem
from symkin.following.trajectory import Trajectory
from symkin.following.tube import Interval
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import LIMIT_SLACK
from symkin.position.problem import Problem
from symkin.text import counted

_NEAR_LIMIT = 1e-4
"""Values of the cubic nearer to their limits than this (of the size, or rad) are looked at on the
branch itself.
"""
_HALVINGS = 60
"""Halvings of a step to the place where a limit is met: beyond a double's digits."""


@dataclass(frozen=True)
class Limit:
    """A limit of a joint that the branch meets: the coordinate's name and the value; `turns` (rad)
    are the whole turns that are subtracted from the coordinate; `is_passed`: the start lies beyond
    it.
    """

    name: str
    value: float
    turns: float = 0.0
    is_passed: bool = False

    def text(self, mechanism: Mechanism) -> str:
        """Which limit is met, in the mechanism's units."""
        c = next(c for c in mechanism.coordinates if c.name == self.name)
        value = mechanism.value_out(c, self.value)
        unit = mechanism.unit_of(c)
        text = f"{self.name} meets its limit {value:g} {unit}"
        if self.is_passed:
            text = f"{self.name} lies beyond its limit {value:g} {unit} at the start"
        turns = abs(round(self.turns / (2 * math.pi)))
        return f"{text}, {counted(turns, 'whole turn')} apart" if turns else text


@dataclass(frozen=True, eq=False)
class LimitWatch:
    """Looks for the first limit that is passed, of given values and unknowns alike, extremes within
    a step included. `turns` are what is subtracted from angles; `off` ignores all limits.
    """

    problem: Problem
    trajectory: Trajectory
    off: bool = False
    turns: dict[str, float] = field(default_factory=dict)

    def start(self, values: np.ndarray) -> Limit | None:
        """Take the turns of a start configuration; a limit that does not hold there."""
        found = None
        for c in self.problem.closure.coordinates:
            value = float(values[self.problem.closure.slices[c.name].start])
            self.turns[c.name] = _turns(c, value)
            if found is None and self._excess(c, value) > 0.0:
                found = replace(self._limit(c, value), is_passed=True)
        return found

    def given(self, row: int) -> tuple[float, Limit] | None:
        """The first share of an interval at which a given value, which moves straight, leaves its
        limits.
        """
        met, samples, start = list[tuple[float, Limit]](), self.trajectory.samples, 0
        for c in self.problem.known_coordinates:
            ends = (row, min(row + 1, len(samples) - 1))
            a, b = (float(samples[k][start]) for k in ends)
            if self._excess(c, b) > 0.0:
                limit = self._limit(c, b)
                share = (limit.value + limit.turns - a) / (b - a) if a != b else 0.0
                met.append((min(max(share, 0.0), 1.0), limit))
            start += c.width
        return min(met, key=lambda one: one[0], default=None)

    def unknown(self, interval: Interval, curve: Cubic) -> tuple[float, Limit] | None:
        """The first share of a proved step at which an unknown of its block leaves its limits."""
        system, met = interval.system, list[tuple[float, Limit]]()
        for c, place in zip(system.system.unknowns, system.system.slices, strict=True):
            share = self._crossing(c, place.start, curve, interval)
            if share is not None:
                value = _value(system, place.start, curve.at(share))
                met.append((share, self._limit(c, value)))
        return min(met, key=lambda one: one[0], default=None)

    def _crossing(
        self, c: Coordinate, place: int, curve: Cubic, interval: Interval
    ) -> float | None:
        """The first share of the step at which the coordinate leaves its limits."""
        system = interval.system

        def excess(share: float) -> float:
            y = curve.at(share)
            beyond = self._excess(c, _value(system, place, y))
            if beyond < -_NEAR_LIMIT * self._unit(c):
                return beyond
            return self._excess(c, _value(system, place, system.correct(y[None], interval.c)[0][0]))

        values = curve.control[:, place] * system.scale[place]
        near = max(self._excess(c, float(v)) for v in (values.min(), values.max()))
        if near < -_NEAR_LIMIT * self._unit(c):
            return None
        before = 0.0
        for share in (*_extremes(curve, place), 1.0):
            if excess(share) > 0.0:
                low, high = before, share
                for _ in range(_HALVINGS):
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if excess(middle) > 0.0 else (middle, high)
                return low
            before = share
        return None

    def _excess(self, c: Coordinate, value: float) -> float:
        """How far a value lies beyond its limits and their slack; negative inside."""
        if self.off or c.limits is None:
            return -np.inf
        low, high = c.limits
        value -= self.turns.get(c.name, 0.0)
        return max(low - value, value - high) - LIMIT_SLACK * self._unit(c)

    def _limit(self, c: Coordinate, value: float) -> Limit:
        """The limit that is nearest to a value."""
        low, high = c.limits or (-np.inf, np.inf)
        turns = self.turns.get(c.name, 0.0)
        own = value - turns
        return Limit(c.name, low if abs(own - low) < abs(own - high) else high, turns)

    def _unit(self, c: Coordinate) -> float:
        return c.unit(self.problem.closure.characteristic_length)


def _turns(c: Coordinate, value: float) -> float:
    """The whole turns (rad) that bring an angle within its limits; zero where none do or none are
    needed.
    """
    low, high = c.limits or (-np.inf, np.inf)
    if not c.is_angular or low - LIMIT_SLACK <= value <= high + LIMIT_SLACK:
        return 0.0
    turns = 2 * math.pi * math.ceil((low - LIMIT_SLACK - value) / (2 * math.pi))
    return -turns if value + turns <= high + LIMIT_SLACK else 0.0


def _value(system: PathSystem, place: int, y: np.ndarray) -> float:
    """An unknown in radians or the length unit."""
    return float(y[place] * system.scale[place])


def _extremes(curve: Cubic, place: int) -> list[float]:
    """Shares of the step, in order, at which an unknown's cubic has an extreme."""
    b = np.diff(curve.control[:, place])
    roots = np.roots([b[0] - 2 * b[1] + b[2], 2 * (b[1] - b[0]), b[0]])
    return sorted(float(r.real) for r in roots if abs(r.imag) < 1e-12 and 0.0 < r.real < 1.0)
