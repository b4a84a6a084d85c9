"""Find the place of a path that is nearest to a singularity of the followed problem."""

from __future__ import annotations

import math

import numpy as np

from symkin.following.block_follower import BlockFollower
from symkin.following.follow import Branch, PathPoint
from symkin.following.station import Station, interval_of, station_near
from symkin.following.trajectory import Trajectory
from symkin.position.problem import Problem

_SECTIONS = 40
"""Golden sections of the interval that holds the least value: it shrinks to 4e-9 of itself."""
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
"""Share of an interval that each section keeps (Kiefer 1953)."""

_SAME = 1e-9
"""Singular values that differ by less than this share are the same."""


def nearest_to_singularity(
    branch: Branch, problem: Problem, trajectory: Trajectory
) -> PathPoint | None:
    """Where the smallest singular value of the blocks' unknowns is least among the ends of steps
    and, by golden section, between the neighbours of the least one; the singular stop where there
    is one, None where no step was needed.
    """
    blocks = [block for block in branch.blocks if block.passed]
    if not blocks:
        return None
    if branch.ending == "singular" and branch.stopped:
        return branch.last
    block = min(blocks, key=lambda b: min(p.sigma for p in b.passed))
    least = min(p.sigma for p in block.passed)
    # where a branch comes back to itself its first place is its last one too, with other neighbours
    equal = [k for k, p in enumerate(block.passed) if p.sigma <= least * (1.0 + _SAME)][:2]
    there, u = min((_least_near(block, trajectory, k) for k in equal), key=lambda found: found[0])[
        1:
    ]
    unknown = np.empty(problem.system.width)
    for each in branch.blocks:
        unknown[each.system.places] = each.system.unknown(_between(each, trajectory, there.row, u))
    return PathPoint(there.row, u, unknown, None)


def _least_near(
    block: BlockFollower, trajectory: Trajectory, k: int
) -> tuple[float, Station, float]:
    """The least singular value between the neighbours of the end of a step, this end, and where
    (u) it is."""
    there = block.passed[k]
    low, high = (
        p if p is not None and p.row == there.row else there
        for p in (_at(block, k - 1), _at(block, k + 1))
    )
    value, u = _least(block, trajectory, (low, there, high))
    return value, there, u


def _at(block: BlockFollower, k: int) -> Station | None:
    return block.passed[k] if 0 <= k < len(block.passed) else None


def _least(
    block: BlockFollower, trajectory: Trajectory, around: tuple[Station, Station, Station]
) -> tuple[float, float]:
    """The least singular value between two ends of steps, not above that of the end between
    them, and its u."""
    a, b = around[0].u, around[2].u
    interval = interval_of(block.system, trajectory, around[1].row)

    def sigma(u: float) -> float:
        one, two = (around[0], around[1]) if u <= around[1].u else (around[1], around[2])
        value = station_near(interval, one.row, _interpolated(one, two, u), u).sigma
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
    found = min(at_c, at_d)
    return (found, 0.5 * (a + b)) if found < around[1].sigma else (around[1].sigma, around[1].u)


def _between(block: BlockFollower, trajectory: Trajectory, row: int, u: float) -> np.ndarray:
    """z of a block at a place that another one has reached."""
    closed = block.closed_branches.get(row)
    if closed is not None and u > closed.period:
        place, times = closed.folded(u)
        return closed.moved(_between(block, trajectory, row, place), times)
    own = [p for p in block.passed if p.row == row] or block.passed[-1:]
    before = max((p for p in own if p.u <= u), key=lambda p: p.u, default=own[0])
    after = min((p for p in own if p.u >= u), key=lambda p: p.u, default=own[-1])
    station = station_near(
        interval_of(block.system, trajectory, row), row, _interpolated(before, after, u), u
    )
    return station.z if station.is_regular else _interpolated(before, after, u)


def _interpolated(one: Station, two: Station, u: float) -> np.ndarray:
    share = (u - one.u) / (two.u - one.u) if two.u > one.u else 0.0
    return np.asarray(one.z + share * (two.z - one.z))
