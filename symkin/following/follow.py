"""Following one configuration along a trajectory: its independent blocks one by one on each interval, up to the first stop.

Limbs whose platform pose is given are blocks of their own (see `Problem.blocks`); each has its own steps and proof (see
`block_walk`). Blocks that stop at the same place stop the configuration together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from symkin.following.block_walk import TOGETHER, Ending, Walk
from symkin.following.joint_limits import Limit, LimitWatch
from symkin.following.path_system import path_systems
from symkin.following.trajectory import Trajectory
from symkin.position.problem import Problem


@dataclass(frozen=True, eq=False)
class Place:
    """A configuration of the path: its unknowns (in radians and the length unit) at u of interval `row`, and the radius (length
    unit; angles times the size) of the box in which it is the only one, None where that is not proved."""

    row: int
    u: float
    unknown: np.ndarray
    radius: float | None


@dataclass(eq=False)
class Branch:
    """What was followed: `places` at the samples, `last` the end, and why it ended: `stopped` are the blocks that end there.
    `followed` is the path parameter up to which steps lead; `steps` counts tubes, of which images fill at most `tightest`;
    `proved`: every step, and the last one to a turning point, is proved; `formula`: no step is
    needed (see `formula`)."""

    places: list[Place]
    last: Place
    walks: tuple[Walk, ...]
    ending: Ending = "reached"
    stopped: list[Walk] = field(default_factory=list)
    limit: Limit | None = None
    followed: float = 0.0
    formula: bool = False

    @property
    def steps(self) -> int:
        return sum(walk.steps for walk in self.walks)

    @property
    def tightest(self) -> float:
        return max((walk.tightest for walk in self.walks), default=0.0)

    @property
    def is_square(self) -> bool:
        return all(walk.system.is_square for walk in self.walks)

    @property
    def proved(self) -> bool:
        """Whether rows are as many as unknowns, and proofs lead to the end."""
        if self.formula:
            return True
        if not self.is_square or self.places[0].radius is None or self.ending in ("open", "unproved"):
            return False
        return all(w.stop is not None and w.stop.arrival is not None for w in self.stopped) or self.ending == "limit"


def follow(
    problem: Problem,
    trajectory: Trajectory,
    unknown: np.ndarray,
    watch: LimitWatch,
    progress: Callable[[int, int], None] | None = None,
) -> Branch:
    """Follow the branch through the unknowns at the first sample until the end or the first stop."""
    walks = tuple(Walk.begin(system, trajectory, watch, unknown) for system in path_systems(problem))
    first = standing(walks, problem, 0, 0.0)
    branch = Branch([first], first, walks)
    for row in range(len(trajectory) - 1):
        moved = not np.array_equal(trajectory.samples[row], trajectory.samples[row + 1])
        if moved and not _interval(branch, problem, trajectory, row, watch):
            return branch
        end = Place(row, 1.0, branch.last.unknown, branch.last.radius)
        branch.places.append(end)
        branch.last, branch.followed = end, trajectory.parameter(row, 1.0)
        if progress is not None:
            progress(row + 1, len(trajectory) - 1)
    return branch


def _interval(branch: Branch, problem: Problem, trajectory: Trajectory, row: int, watch: LimitWatch) -> bool:
    """Follow all blocks over one interval; whether its end is reached."""
    given = watch.given(row)
    until = 1.0 if given is None else given[0]
    for walk in branch.walks:
        walk.enter(row)
        walk.go(until)
        if walk.stop is not None:
            until = min(until, walk.stop.u)
    branch.last = standing(branch.walks, problem, row, until)
    branch.stopped = [w for w in branch.walks if w.stop is not None and w.stop.u <= until + TOGETHER]
    if not branch.stopped and given is None:
        return True
    branch.followed = trajectory.parameter(row, min([until, *(w.station.u for w in branch.stopped)]))
    stops = [w.stop for w in branch.stopped if w.stop is not None]
    order: tuple[Ending, ...] = ("open", "unproved", "limit", "singular")
    branch.ending = next((e for e in order if any(s.ending == e for s in stops)), "limit")
    branch.limit = next((s.limit for s in stops if s.limit is not None), None if given is None else given[1])
    return False


def standing(walks: tuple[Walk, ...], problem: Problem, row: int, u: float) -> Place:
    """The configuration of all blocks at a u that they have passed or at which they stop."""
    unknown = np.empty(problem.system.width)
    radius: float | None = 0.0
    for walk in walks:
        unknown[walk.system.places] = walk.system.unknown(walk.at(u))
        half = walk.station.half if walk.station.u == u else None
        radius = None if half is None or radius is None else max(radius, float(np.max(half[:-1], initial=0.0)))
    return Place(row, u, unknown, None if radius is None else radius * problem.closure.size)
