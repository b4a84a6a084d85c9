"""Follow one configuration along a trajectory: its independent blocks one by one on each interval,
up to the first stop.

Limbs whose platform pose is given are blocks of their own (see `split_blocks`); each has its own
steps and proof (see `block_follower`). Blocks that stop at the same place stop the configuration
together.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from operator import attrgetter

import numpy as np

from symkin.following.block_follower import SAME_PLACE, BlockFollower, Ending
from symkin.following.dependent_rows import rows_suffice
from symkin.following.joint_limits import Limit, LimitWatch
from symkin.following.path_system import path_systems
from symkin.following.station import stations_near
from symkin.following.steps import Step, Ways, ways
from symkin.following.trajectory import Trajectory, coefficients
from symkin.following.tube import Interval
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.problem import Problem
from symkin.text import counted


@dataclass(frozen=True, eq=False)
class PathPoint:
    """A configuration of the path: its unknowns (in radians and the length unit) at u of interval
    `row`, and the radius (length unit; angles times the size) of the box in which it is the only
    one, None where that is not proved.
    """

    row: int
    u: float
    unknown: np.ndarray
    radius: float | None


@dataclass(frozen=True, eq=False)
class Way:
    """Configurations (u, unknowns) that lead from the beginning of an interval to a place of it:
    those of `turn`, after which they are the same, so many times, and then those of `rest`.
    """

    turn: tuple[tuple[float, np.ndarray], ...]
    times: int
    rest: tuple[tuple[float, np.ndarray], ...]


@dataclass(eq=False)
class Branch:
    """What was followed: `places` at the samples, `last` the end, and why it ended: `stopped` are
    the blocks that end there. `followed` is the path parameter up to which steps lead; `steps`
    counts tubes, of which images fill at most `tightest`; `proved`: every step, and the last one to
    a turning point, is proved; `formula`: no step is needed (see `evaluate_formula`).
    """

    places: list[PathPoint]
    last: PathPoint
    blocks: tuple[BlockFollower, ...]
    ending: Ending = "reached"
    stopped: list[BlockFollower] = field(default_factory=list)
    limit: Limit | None = None
    followed: float = 0.0
    formula: bool = False

    @property
    def steps(self) -> int:
        return sum(block.steps for block in self.blocks)

    @property
    def tightest(self) -> float:
        return max((block.tightest for block in self.blocks), default=0.0)

    def way(self, row: int, u: float) -> Way:
        """The configurations that lead to a place of an interval; none where one of several blocks
        comes back to itself.
        """
        turning = [block.closed_branches.get(row) for block in self.blocks]
        if not self.blocks or (len(self.blocks) > 1 and any(turning)):
            return Way((), 0, ())
        closed = turning[0]
        place, times = (u, 0) if closed is None else closed.folded(u)
        ends = self._ends(row)
        turn = [end for end in ends if closed is not None and end[0] <= closed.period]
        return Way(tuple(turn), times, tuple(end for end in ends if end[0] <= place))

    def _ends(self, row: int) -> list[tuple[float, np.ndarray]]:
        """The configurations (u, unknowns) at the ends of all blocks' steps on an interval: between
        its own ends a block is where it goes straight, near enough to tell turns.
        """
        passed = []
        for ends in (block.passed for block in self.blocks):
            first, last = (
                side(ends, row, key=attrgetter("row")) for side in (bisect_left, bisect_right)
            )
            passed.append(ends[first:last])
        if not all(passed):
            return []
        shares = sorted({station.u for stations in passed for station in stations})
        unknown = np.empty((len(shares), self.last.unknown.size))
        for block, stations in zip(self.blocks, passed, strict=True):
            z, own = np.array([s.z for s in stations]), [s.u for s in stations]
            at = [np.interp(shares, own, column) for column in z.T]
            unknown[:, block.system.places] = block.system.unknowns(np.array(at).T)
        return list(zip(shares, unknown, strict=True))

    @property
    def suffices(self) -> bool:
        """Whether rows are as many as unknowns, but for such as follow from the others."""
        return all(block.suffices for block in self.blocks)

    @property
    def proves_pieces(self) -> bool:
        """Whether the way from each of the `places` to the next one is proved."""
        return self.formula or (
            self.suffices and all(place.radius is not None for place in self.places)
        )

    @property
    def proved(self) -> bool:
        """Whether no row is redundant but such as follow from others, and proofs lead to the
        end.
        """
        if self.formula:
            return True
        if not self.suffices or self.places[0].radius is None:
            return False
        folds = all(w.stop is not None and w.stop.fold is not None for w in self.stopped)
        return self.ending not in ("open", "unproved") and (folds or self.ending == "limit")


def follow(
    problem: Problem,
    trajectory: Trajectory,
    unknown: np.ndarray,
    watch: LimitWatch,
    progress: Callable[[int, int], None] | None = None,
    known: Sequence[list[Step]] = (),
) -> Branch:
    """Follow the branch through the unknowns at the first sample until the end or the first
    stop; `known` are steps of each block on the first interval that have been proved.
    """
    blocks = tuple(
        BlockFollower.begin(system, trajectory, watch, unknown) for system in path_systems(problem)
    )
    for block, steps in zip(blocks, known, strict=False):
        block.ahead, block.looked = {0: steps}, 0
    first = path_point(blocks, problem, 0, 0.0)
    branch = Branch([first], first, blocks)
    for row in range(len(trajectory) - 1):
        moved = not np.array_equal(trajectory.samples[row], trajectory.samples[row + 1])
        if moved and not _interval(branch, problem, trajectory, row, watch):
            return branch
        branch.last = PathPoint(row, 1.0, branch.last.unknown, branch.last.radius)
        branch.places.append(branch.last)
        branch.followed = trajectory.parameter(row, 1.0)
        if progress is not None:
            progress(row + 1, len(trajectory) - 1)
    return branch


def _interval(
    branch: Branch, problem: Problem, trajectory: Trajectory, row: int, watch: LimitWatch
) -> bool:
    """Follow all blocks over one interval; whether its end is reached."""
    given = watch.given(row)
    until = 1.0 if given is None else given[0]
    for block in branch.blocks:
        block.enter(row)
        block.go(until)
        if block.stop is not None:
            until = min(until, block.stop.u)
    branch.last = path_point(branch.blocks, problem, row, until)
    branch.stopped = [
        w for w in branch.blocks if w.stop is not None and w.stop.u <= until + SAME_PLACE
    ]
    if not branch.stopped and given is None:
        return True
    branch.followed = trajectory.parameter(
        row, min([until, *(w.station.u for w in branch.stopped)])
    )
    stops = [w.stop for w in branch.stopped if w.stop is not None]
    order: tuple[Ending, ...] = ("open", "unproved", "limit", "singular")
    branch.ending = next((e for e in order if any(s.ending == e for s in stops)), "limit")
    branch.limit = next(
        (s.limit for s in stops if s.limit is not None), None if given is None else given[1]
    )
    return False


def path_point(
    blocks: tuple[BlockFollower, ...], problem: Problem, row: int, u: float
) -> PathPoint:
    """The configuration of all blocks at a u that they have passed or at which they stop."""
    halves = [block.station.half if block.station.u == u else None for block in blocks]
    radius, size = None, problem.closure.characteristic_length
    if all(half is not None for half in halves):
        radius = size * max((float(np.max(h[:-1], initial=0.0)) for h in halves), default=0.0)  # type: ignore[index]
    return PathPoint(row, u, joined(problem, blocks, (block.at(u) for block in blocks)), radius)


def joined(
    problem: Problem, blocks: Sequence[BlockFollower], parts: Iterable[np.ndarray]
) -> np.ndarray:
    """The unknowns (in radians and the length unit) that the blocks' z make."""
    unknown = np.empty(problem.system.width)
    for block, z in zip(blocks, parts, strict=True):
        unknown[block.system.places] = block.system.unknown(z)
    return unknown


@dataclass(frozen=True, eq=False)
class Carried:
    """Configurations that were followed from one sample to another, all together: their unknowns
    `end` (n, w) where they have come to, whether they `reached` (n,) the other sample without a
    singularity, and the ways of their blocks; `suffices` (n,) says whether no row is redundant but
    such as follow from others.
    """

    end: np.ndarray
    reached: np.ndarray
    suffices: np.ndarray
    ways: tuple[Ways, ...]

    def steps_of(self, k: int) -> list[list[Step]]:
        """The proved steps of each block of a configuration."""
        return [found.steps_of(0, k) for found in self.ways]


def carried(
    problem: Problem, begin: np.ndarray, samples: Sequence[tuple[np.ndarray, np.ndarray]]
) -> Carried:
    """Follow configurations by their unknowns (n, w), each from one sample to another."""
    end, reached, blocks = begin.copy(), np.ones(len(begin), dtype=bool), []
    suffices, known = reached.copy(), np.array([a for a, _ in samples])
    c = np.array([coefficients(problem.known_coordinates, a, b) for a, b in samples])
    which = np.arange(len(begin), dtype=np.intc)
    for system in path_systems(problem):
        y = np.append(begin[:, system.places] / system.scale, np.zeros((len(begin), 1)), axis=1)
        own = rows_suffice(system, y[:, :-1], known)
        suffices &= own
        interval = Interval(system, c, bool(own.any()) and not system.is_square)
        found = ways(interval, stations_near(interval, y, which), np.ones(len(begin)), which)
        for numbers, _, there, *_ in found.rounds if not system.is_square else ():
            left = np.abs(interval.evaluate(there.y, numbers)[0]).max(axis=1, initial=0.0)
            reached[numbers[left > CLOSURE_TOLERANCE]] = False
        reached &= found.last.y[:, -1] == 1.0
        end[:, system.places] = system.unknowns(found.last.y[:, :-1])
        blocks.append(found)
    return Carried(end, reached, suffices, tuple(blocks))


# --- on what ground -------------------------------------------------------------------------------


def ground(branch: Branch, certified: bool, residual: float, length_unit: str) -> str:
    """On what ground the samples of a branch are said to be one mode."""
    steps, turns = counted(branch.steps, "step"), ""
    if any(block.closed_branches for block in branch.blocks):
        turns = (
            "; after whole turns of the given angles the branch is where it began, and later turns "
            "are the same"
        )
    if branch.formula:
        return (
            "proved: the pose is a formula of the joints, one for every input; no steps are needed"
        )
    if certified and not branch.steps:
        return "proved: ball arithmetic shows exactly one solution at the start"
    if certified:
        return (
            f"proved: {steps}, in each of which ball arithmetic shows exactly one solution for "
            f"every input{_last_tube(branch)}{turns}{_dependent_rows(branch)}"
        )
    if not branch.blocks:
        return "checked: nothing was followed"
    if branch.suffices:
        return (
            f"proved up to parameter {branch.followed:.9g} by {steps}, in each of which ball "
            f"arithmetic shows exactly one "
            f"solution for every input{turns}; beyond, checked in double precision only"
        )
    rows, unknowns = (
        sum(n) for n in zip(*((b.system.count, b.system.width) for b in branch.blocks), strict=True)
    )
    return (
        f"checked: rows are redundant ({rows} for {unknowns} unknowns; `symkin show` names the "
        f"motion that removes some, where "
        f"there is one); in each of {steps} ball arithmetic shows at most one "
        f"solution for every input (margin {1 - branch.tightest:.2g}), and "
        f"{_existence(branch, residual, length_unit)}"
        + _redundant_rows(branch, length_unit)
        + turns
    )


def _dependent_rows(branch: Branch) -> str:
    """Which rows no proof needs."""
    beyond = sum(block.system.count - block.system.width for block in branch.blocks)
    if not beyond:
        return ""
    return (
        f"; {counted(beyond, 'row')} more than unknowns follow from the others: at random "
        "configurations they vanish with them"
    )


def _existence(branch: Branch, residual: float, length_unit: str) -> str:
    """What speaks for a solution where rows are redundant."""
    if any(block.is_of_least_squares for block in branch.blocks):
        return (
            f"it is one of least squares: loops that close only to the digits of the description "
            f"stay open by up to {residual:.1e} {length_unit}"
        )
    return f"the residual, at most {residual:.1e} {length_unit}, that there is one"


def _redundant_rows(branch: Branch, length_unit: str) -> str:
    """What is proved of redundant rows at the ends of steps."""
    bound = max((block.redundant_bound for block in branch.blocks), default=0.0)
    if not branch.steps or not math.isfinite(bound):
        return ""
    return (
        "; proved at the end of each step: as many independent rows as unknowns vanish at exactly "
        "one point there, and no other "
        f"row is more than {bound:.1e} {length_unit} at it"
    )


def _last_tube(branch: Branch) -> str:
    if branch.ending != "singular":
        return ""
    return (
        ", and a last one in which it shows that the path parameter grows up to the turning point, "
        "which is the first singularity"
    )


# --- serial arms: the pose is a formula of the joints ---------------------------------------------


def is_formula(problem: Problem) -> bool:
    """Whether the unknowns are a position and a quaternion alone, as a function of the given
    joints.
    """
    kinds = [c.kind for c in problem.system.unknowns]
    return problem.is_explicit and kinds == ["length", "length", "length", "quaternion"]


def evaluate_formula(
    problem: Problem,
    trajectory: Trajectory,
    unknown: np.ndarray,
    watch: LimitWatch,
    progress: Callable[[int, int], None] | None = None,
) -> Branch:
    """The poses at the samples, up to the first limit; the formula's quaternion is continuous, and
    has the start's sign.
    """
    sign = 1.0 if _arm_pose(problem, trajectory.samples[0], 1.0)[3:] @ unknown[3:] >= 0.0 else -1.0
    first = PathPoint(0, 0.0, unknown, None)
    branch = Branch([first], first, (), formula=True)
    for row in range(len(trajectory) - 1):
        met = watch.given(row)
        u = 1.0 if met is None else met[0]
        branch.last = PathPoint(row, u, _arm_pose(problem, trajectory.at(row, u), sign), None)
        branch.followed = trajectory.parameter(row, u)
        if met is not None:
            branch.ending, branch.limit = "limit", met[1]
            return branch
        branch.places.append(branch.last)
        if progress is not None:
            progress(row + 1, len(trajectory) - 1)
    return branch


def _arm_pose(problem: Problem, known: np.ndarray, sign: float) -> np.ndarray:
    pose = problem.forward(known)
    assert pose is not None  # noqa: S101 - `is_formula` has been asked
    return np.append(pose[:3], sign * pose[3:] / np.linalg.norm(pose[3:]))
