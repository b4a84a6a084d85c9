"""Know a branch that has come back to itself after whole turns of the given angles, so that later
turns need no steps.

Where all given coordinates that move on an interval are angles of which the rows have the period
2 pi, and a share P of the interval is whole turns of all of them, G(z, u) = 0 holds with G(z, u
+ P) = 0 too, and so with unknown angles moved by whole turns and quaternions of either sign. A
branch through (z0, 0) and (z0 + s, P), s such a shift, is then z(u + n P) = z(u) + n s for all
whole n: it is proved everywhere once it is proved up to P, and singular nowhere. A branch that
is at another mode after the share is followed on: modes are exchanged, and it comes back after
some more of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from symkin.following.path_system import PathSystem
from symkin.following.trajectory import Trajectory
from symkin.following.tube import COEFFICIENT_RADIUS

_MOST_TURNS = 60
"""Turns of the slowest angle within which all others must have made whole turns too."""
_TURN = 2 * math.pi


@dataclass(frozen=True, eq=False)
class ClosedBranch:
    """A branch of an interval that comes back after the share `period` of it; `shift` is what
    its unknowns z have gained then, `signs` (-1 for quaternions that have changed theirs)
    what they are multiplied by."""

    period: float
    shift: np.ndarray
    signs: np.ndarray

    def folded(self, u: float) -> tuple[float, int]:
        """The place within the first period that u is like, and the periods between them."""
        times = max(math.ceil(u / self.period) - 1, 0)
        return min(u - times * self.period, self.period), times

    def moved(self, z: np.ndarray, times: int) -> np.ndarray:
        """Unknowns of the first period so many periods later."""
        return self.signs**times * z + times * self.shift


def whole_turns(trajectory: Trajectory, row: int) -> float | None:
    """The share of an interval after which all moving coordinates have made whole turns; None
    where others move, or where it is longer than the interval."""
    change = trajectory.samples[row + 1] - trajectory.samples[row]
    others = [not c.is_periodic for c in trajectory.coordinates for _ in range(c.width)]
    moves: list[float] = change[change != 0.0].tolist()
    if not moves or change[others].any():
        return None
    slowest = min(abs(d) for d in moves)
    for turns in range(1, min(_MOST_TURNS, int(slowest / _TURN)) + 1):
        # what is left beside whole turns lies within the balls of the path's coefficients
        wholes = [round(d * turns / slowest) for d in moves]
        if all(
            abs(d - n * slowest / turns) <= COEFFICIENT_RADIUS * max(abs(d), 1.0)
            for d, n in zip(moves, wholes, strict=True)
        ):
            return turns * _TURN / slowest
    return None


def closed_branch(
    system: PathSystem, period: float, start: np.ndarray, end: np.ndarray
) -> ClosedBranch:
    """What unknowns gain from `start` to `end`, if they come back: whole turns of angles, signs
    of quaternions."""
    shift, signs = np.zeros(len(start)), np.ones(len(start))
    for c, place in zip(system.system.unknowns, system.system.slices, strict=True):
        if c.is_periodic:
            shift[place] = _TURN * np.round((end[place] - start[place]) / _TURN)
        elif c.is_rotation and end[place] @ start[place] < 0.0:
            signs[place] = -1.0
    return ClosedBranch(period, shift, signs)
