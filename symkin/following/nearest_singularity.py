"""Find the place of a path that is nearest to a singularity of the followed problem."""

from __future__ import annotations

import numpy as np

from symkin.following.block_follower import BlockFollower
from symkin.following.follow import Branch, PathPoint, joined
from symkin.following.station import Station, interval_of, singular_values_near, station_near
from symkin.following.trajectory import Trajectory

_PLACES, _ROUNDS = 17, 9
"""Places at which an interval that holds the least value is looked at, and how often that is
repeated between the neighbours of the best one: it shrinks to 1e-8 of itself.
"""
_SAME = 1e-9
"""Singular values that differ by less than this share are the same."""


def nearest_to_singularity(branch: Branch, trajectory: Trajectory) -> PathPoint | None:
    """Where the smallest singular value of the blocks' unknowns is least among the ends of steps
    and, at places that grow denser, between the neighbours of the least one; the singular stop
    where there is one, None where no step was needed.
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
    parts = (_between(each, trajectory, there.row, u) for each in branch.blocks)
    unknown = joined(trajectory.problem, branch.blocks, parts)
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
    before, there, after = around
    interval = interval_of(block.system, trajectory, there.row)
    low, high, best = before.u, after.u, (there.sigma, there.u)
    for _ in range(_ROUNDS if high > low else 0):
        u = np.linspace(low, high, _PLACES)
        y = [
            [*_interpolated(*((before, there) if v <= there.u else (there, after)), v), v]
            for v in u.tolist()
        ]
        sigma = singular_values_near(interval, np.array(y))
        k = int(np.argmin(sigma))
        best = min(best, (float(sigma[k]), float(u[k])))
        low, high = float(u[max(k - 1, 0)]), float(u[min(k + 1, _PLACES - 1)])
    return best


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
    return one.z + share * (two.z - one.z)
