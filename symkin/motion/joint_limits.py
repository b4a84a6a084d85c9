"""Where a followed branch first meets a joint limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.model.joint import Coordinate
from symkin.motion.follow import Limit, Station, settled
from symkin.motion.path_system import PathSystem
from symkin.motion.step_certificate import Curve, Interval
from symkin.motion.trajectory import Trajectory

_SLACK = 1e-9
"""A value beyond its limit by less than this (of the size, or rad) keeps it: a path may touch a limit."""
_NEAR = 1e-4
"""Values of the cubic nearer to their limits than this (of the size, or rad) are looked at on the branch itself."""
_HALVINGS = 60


@dataclass(frozen=True, eq=False)
class LimitWatch:
    """Looks at each step for the first limit that it passes, given values and unknowns alike, extremes within the step
    included."""

    system: PathSystem
    trajectory: Trajectory

    def __call__(self, interval: Interval, station: Station, curve: Curve) -> tuple[Station, Limit] | None:
        first: tuple[float, Limit] | None = None
        for c in self._limited():
            share = self._crossing(c, station.row, curve, interval)
            if share is not None and (first is None or share < first[0]):
                first = (share, Limit(c.name, _nearest(c, self._value(c, station.row, curve.at(share)))))
        return None if first is None else (self._on_branch(interval, station.row, curve.at(first[0])), first[1])

    def _on_branch(self, interval: Interval, row: int, y: np.ndarray) -> Station:
        return settled(interval, row, y[:-1], float(np.clip(y[-1], 0.0, 1.0)))

    def violated(self, station: Station) -> Limit | None:
        """A limit that does not hold at a station."""
        for c in self._limited():
            value = self._value(c, station.row, station.y)
            if _excess(c, value, self._size) > 0.0:
                return Limit(c.name, _nearest(c, value))
        return None

    @property
    def _size(self) -> float:
        return self.system.problem.closure.size

    def _limited(self) -> list[Coordinate]:
        return [c for c in self.system.problem.closure.coordinates if c.limits is not None]

    def _crossing(self, c: Coordinate, row: int, curve: Curve, interval: Interval) -> float | None:
        """The first share of the step at which the coordinate leaves its limits."""

        def excess(share: float) -> float:
            y = curve.at(share)
            beyond = _excess(c, self._value(c, row, y), self._size)
            if beyond < -_NEAR * (1.0 if c.is_angular else self._size):
                return beyond
            return _excess(c, self._value(c, row, self._on_branch(interval, row, y).y), self._size)

        before = 0.0
        for share in (*self._extremes(c, curve), 1.0):
            if excess(share) > 0.0:
                low, high = before, share
                for _ in range(_HALVINGS):
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if excess(middle) > 0.0 else (middle, high)
                return low
            before = share
        return None

    def _extremes(self, c: Coordinate, curve: Curve) -> list[float]:
        """Shares of the step, in order, at which an unknown coordinate's cubic has an extreme."""
        places = dict(zip(self.system.problem.system.unknowns, self.system.problem.system.slices, strict=True))
        if c not in places:
            return []
        b = np.diff(curve.control[:, places[c].start])
        roots = np.roots([b[0] - 2 * b[1] + b[2], 2 * (b[1] - b[0]), b[0]])
        return sorted(float(r.real) for r in roots if abs(r.imag) < 1e-12 and 0.0 < r.real < 1.0)

    def _value(self, c: Coordinate, row: int, y: np.ndarray) -> float:
        problem = self.system.problem
        values = problem.assemble(y[:-1] * self.system.scale, self.trajectory.at(row, float(np.clip(y[-1], 0.0, 1.0))))
        return float(values[problem.closure.slices[c.name].start])


def _excess(c: Coordinate, value: float, size: float) -> float:
    """How far a value lies beyond its limits and their slack; negative inside."""
    low, high = c.limits or (-np.inf, np.inf)
    return max(low - value, value - high) - _SLACK * (1.0 if c.is_angular else size)


def _nearest(c: Coordinate, value: float) -> float:
    low, high = c.limits or (-np.inf, np.inf)
    return low if abs(value - low) < abs(value - high) else high
