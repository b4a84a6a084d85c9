"""Follow many configurations at once, each along a straight line of its known values.

A step from z0 to z1 is taken where the Jacobians at its ends are near to each other, |J1^+ J0 - I|
at most `_NEAR`: every mean of such Jacobians is regular, so that no other solution lies between.
What cannot be reached in this way is told with the share of the line up to which it leads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.linear_algebra import least_squares_steps
from symkin.numeric.system import System
from symkin.numeric.tolerances import ROUNDED_STEP

_NEAR, _EASY = 0.5, 0.15
"""Largest row sum of |J1^+ J0 - I| of a step that is taken, and of one after which the next is
twice as long.
"""
_LONGEST = 0.3
"""Of a step of any unknown: radians, and lengths over the size."""
_SHORTEST = 1e-7
"""Share of a line below which steps end: what is left is a singularity, or opens."""
_CLOSED = 1e-12
"""Closure error of a point, over the size."""
_NEWTON = 6
_TINY = 1e-14
"""Of the normal equations' trace, added to their diagonal, so that they can be solved where they
are singular but for rounding: directions of singular values below 1e-7 count as lost.
"""
_MOST_STEPS = 2000


@dataclass(frozen=True, eq=False)
class Followed:
    """Points (n, width), and the share of its line (n,) that each has come: 1 at the goal."""

    points: np.ndarray
    shares: np.ndarray

    @property
    def reached(self) -> np.ndarray:
        return self.shares >= 1.0


def follow_lines(
    system: System, start: np.ndarray, begin: np.ndarray, goals: np.ndarray
) -> Followed:
    """Follow the unknowns `start` (n, width) while the known values move from `begin` (n, known) to
    `goals` (n, known). Goals that are not finite are not followed.
    """
    size = system.characteristic_length
    points, shares = start.copy(), np.zeros(len(goals))
    steps = np.full(len(goals), 1.0)
    jacobians = system.linearise(points, begin)[1]
    going = np.flatnonzero(np.isfinite(goals).all(axis=1))
    eye = np.eye(system.freedom)
    for _ in range(_MOST_STEPS):
        if not going.size:
            break
        share = np.minimum(shares[going] + steps[going], 1.0)
        known = begin[going] + share[:, None] * (goals[going] - begin[going])
        moved = system.polish_many(points[going], known, _NEWTON)
        change = np.abs(system.difference(points[going], moved.points)).max(axis=1, initial=0.0)
        closed = np.abs(moved.rows).max(axis=1, initial=0.0) <= _CLOSED * size
        turned = _distances(moved.jacobians, jacobians[going], eye)
        good = closed & (turned <= _NEAR) & (change <= _LONGEST * size)
        taken = going[good]
        points[taken], jacobians[taken] = moved.points[good], moved.jacobians[good]
        shares[taken] = share[good]
        steps[taken] *= np.where(turned[good] <= _EASY, 2.0, 1.0)
        steps[going[~good]] *= 0.5
        going = going[(shares[going] < 1.0) & (steps[going] > _SHORTEST)]
    # what counts as closed may be far from the solution in directions that close little
    done = np.flatnonzero(shares >= 1.0)
    rows, slopes = system.linearise(points[done], goals[done])
    points[done] = system.move(points[done], least_squares_steps(slopes, rows, ROUNDED_STEP))
    return Followed(points, shares)


def _distances(after: np.ndarray, before: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """The largest row sum of |J1^+ J0 - I| (n,), at least 1 where J1 has no such inverse."""
    if not eye.size:
        return np.zeros(len(after))
    finite = np.isfinite(after).all(axis=(1, 2), keepdims=True)
    after = np.where(finite, after, 0.0)
    # by the normal equations, kept solvable: half of the digits suffice to judge a step
    turned = after.transpose(0, 2, 1)
    gram = turned @ after
    floor = _TINY * np.trace(gram, axis1=1, axis2=2) + np.finfo(float).tiny
    near = np.linalg.solve(gram + floor[:, None, None] * eye, turned @ before) - eye
    return np.abs(near).sum(axis=2).max(axis=1)
