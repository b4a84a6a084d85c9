"""The place of a path that is nearest to a singularity of the followed problem."""

from __future__ import annotations

import math

import numpy as np

from symkin.following.block_walk import Passed, Walk, interval_of, settled
from symkin.following.follow import Branch, Place
from symkin.following.trajectory import Trajectory
from symkin.position.problem import Problem

_SECTIONS = 40
"""Golden sections of the interval that holds the least value: it shrinks to 4e-9 of itself."""
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def nearest_place(branch: Branch, problem: Problem, trajectory: Trajectory) -> Place | None:
    """Where the smallest singular value of the blocks' unknowns is least among the ends of steps and, by golden section, between
    the neighbours of the least one; the singular stop where there is one, None where no step was needed."""
    walks = [walk for walk in branch.walks if walk.passed]
    if not walks:
        return None
    if branch.ending == "singular" and branch.stopped:
        return branch.last
    walk = min(walks, key=lambda w: min(p.sigma for p in w.passed))
    k = min(range(len(walk.passed)), key=lambda i: walk.passed[i].sigma)
    there = walk.passed[k]
    low, high = (p if p is not None and p.row == there.row else there for p in (_at(walk, k - 1), _at(walk, k + 1)))
    u = _least(walk, trajectory, (low, there, high))
    unknown = np.empty(problem.system.width)
    for each in branch.walks:
        unknown[each.system.places] = each.system.unknown(_between(each, trajectory, there.row, u))
    return Place(there.row, u, unknown, None)


def _at(walk: Walk, k: int) -> Passed | None:
    return walk.passed[k] if 0 <= k < len(walk.passed) else None


def _least(walk: Walk, trajectory: Trajectory, around: tuple[Passed, Passed, Passed]) -> float:
    """u of the least singular value between two ends of steps, not above that of the end between them."""
    a, b = around[0].u, around[2].u
    interval = interval_of(walk.system, trajectory, around[1].row)

    def sigma(u: float) -> float:
        one, two = (around[0], around[1]) if u <= around[1].u else (around[1], around[2])
        value = settled(interval, one.row, _mixed(one, two, u), u).sigma
        return value if math.isfinite(value) else math.inf

    c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
    at_c, at_d = sigma(c), sigma(d)
    for _ in range(_SECTIONS if b > a else 0):
        if at_c < at_d:
            b, d, at_d = d, c, at_c
            c = b - _GOLDEN * (b - a)
            at_c = sigma(c)
        else:
            a, c, at_c = c, d, at_d
            d = a + _GOLDEN * (b - a)
            at_d = sigma(d)
    return 0.5 * (a + b) if min(at_c, at_d) < around[1].sigma else around[1].u


def _between(walk: Walk, trajectory: Trajectory, row: int, u: float) -> np.ndarray:
    """z of a block at a place that another one has reached."""
    own = [p for p in walk.passed if p.row == row] or walk.passed[-1:]
    before = max((p for p in own if p.u <= u), key=lambda p: p.u, default=own[0])
    after = min((p for p in own if p.u >= u), key=lambda p: p.u, default=own[-1])
    station = settled(interval_of(walk.system, trajectory, row), row, _mixed(before, after, u), u)
    return station.z if station.is_regular else _mixed(before, after, u)


def _mixed(one: Passed, two: Passed, u: float) -> np.ndarray:
    share = (u - one.u) / (two.u - one.u) if two.u > one.u else 0.0
    return np.asarray(one.z + share * (two.z - one.z))
