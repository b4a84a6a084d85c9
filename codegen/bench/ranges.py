"""Where the goals of lines lie, and what their lines come to: at random about home, near to as far
as the joints go, anywhere, beside folds, on smooth paths. Each yields outcomes, batch by batch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from continuation import LONGEST
from directions import PLAIN, Direction, Outcome, Starts
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply

_BESIDE = {"double": 6.0, "float": 2.5}
"""Guesses beside a fold lie at most ten to this power nearer to it than the line was long."""
_BISECTED = 44
"""Times that a part of a way is bisected: to a double's rounding, but for a digit or two."""
_WAVES = 3
_REACH = 0.9
"""How far paths go from home (rad, or of the size), where no limits are nearer."""


@dataclass(frozen=True)
class Reach:
    """How far goals lie from home: positions of poses or sliding joints (a part of the size),
    rotations (rad).
    """

    part: float
    turn: float


SMALL, MIDDLE, WIDEST = Reach(0.05, 0.2), Reach(0.15, 0.6), Reach(0.5, np.pi)
"""The widest: whole turns, and half of the size or, where a joint has limits, all of them."""
RANGES = {"small": SMALL, "middle": MIDDLE, "widest": WIDEST}
POSES = {SMALL: Reach(0.1, 0.25), MIDDLE: Reach(180.0 / 531.2592, 1.0), WIDEST: WIDEST}
"""The same for platforms on six rods, whose goals are those of poses."""


def goals_about(lines: Direction, count: int, reach: Reach, rng: np.random.Generator) -> np.ndarray:
    """Joint values (count, joints) or a map's given ones: of poses about home, or about those of
    the reference; kept within limits. Of arms the tool's poses (count, 7) at such joint values.
    """
    kind, size = lines.kind, lines.size
    is_map = lines.asked.kind == "map"
    joints = lines.problem.known_coordinates if is_map else lines.asked.mechanism.actuated
    if isinstance(kind, RodPlatform):
        about = POSES.get(reach, reach)
        goals = np.array(
            [kind.lengths(_pose_about(kind.home, about, size, rng)) for _ in range(count)]
        )
    else:
        middle = np.array([c.reference[0] for c in joints])
        spread = np.array([reach.turn if c.is_angular else reach.part * size for c in joints])
        goals = middle + spread * rng.uniform(-1, 1, (count, len(joints)))
    for i, c in enumerate(joints):
        if c.limits is not None and reach == WIDEST:
            goals[:, i] = rng.uniform(*c.limits, count)
        elif c.limits is not None:
            goals[:, i] = np.clip(goals[:, i], *c.limits)
    return lines.asked.rounded(_known_at(lines, goals))


def _pose_about(home: Pose, reach: Reach, size: float, rng: np.random.Generator) -> Pose:
    shift = reach.part * size * rng.uniform(-1, 1, 3)
    turn = rng.uniform(-reach.turn, reach.turn, 3)
    half = 0.5 * float(np.linalg.norm(turn))
    turned = np.array([np.cos(half), *(np.sin(half) / (2 * half) * turn)])
    q = multiply(turned, np.asarray(home.quaternion))
    return Pose(np.asarray(home.position) + shift, np.asarray(q))


def _known_at(lines: Direction, joints: np.ndarray) -> np.ndarray:
    """What is given at joint values: of an arm the tool's poses."""
    kind = lines.kind
    return np.array([kind.forward_at(q) for q in joints]) if isinstance(kind, SerialArm) else joints


# --- about home, leg after leg --------------------------------------------------------------------


def by_legs(
    lines: Direction,
    count: int,
    rng: np.random.Generator,
    reach: Reach,
    legs: int = 2,
    folds: bool = True,
) -> Iterator[Outcome]:
    """Random goals: from home, then from answers of the leg before, where these were right, and
    last from beside the folds at which lines of the first leg stopped.
    """
    home = starts = lines.home.repeated(count)
    stopped = None
    for leg in range(legs + folds):
        if leg == legs and stopped is not None:
            starts = _beside_folds(lines, stopped, home, rng)
        outcome = lines.run(starts, goals_about(lines, count, reach, rng), rng)
        stopped = stopped or outcome
        yield outcome
        starts = lines.after(outcome, home)


def _beside_folds(
    lines: Direction, outcome: Outcome, home: Starts, rng: np.random.Generator
) -> Starts:
    """Guesses short of the folds at which lines stopped, where the code's other problem gives their
    known values back; else home.
    """
    stopped = outcome.walked & (outcome.ends.shortest == 0.0) & (outcome.ends.done > 0.0)
    nearer = 10.0 ** -rng.uniform(1.0, _BESIDE[lines.real], len(stopped))
    begin, z, good = outcome.starts.known, home.unknowns.copy(), np.zeros(len(stopped), bool)
    known = begin + (outcome.ends.done * (1.0 - nearer))[:, None] * (outcome.goals - begin)
    if stopped.any():
        at = outcome.starts.unknowns[stopped], begin[stopped], known[stopped]
        parts = lines.walker.reached(*at)
        z[stopped], good[stopped] = parts.unknowns, parts.shortest > 0.0
    starts = Starts(z, known, lines.stated(z, known))
    told = lines.gives_back(starts.guesses, known) & lines.tells(starts.guesses, known)
    return starts.where(good & told, home)


# --- arms -----------------------------------------------------------------------------------------


def anywhere(
    lines: Direction, count: int, rng: np.random.Generator, *, folds: bool = False
) -> Iterator[Outcome]:
    """Arms at joints anywhere, and goals at the poses of others, a random part of the way from the
    first joints to such anywhere. With `folds` goals from which lines graze folds: on the way of
    the goal's joints to such anywhere the place from which on lines are stopped by a singularity is
    bisected by walks, and goals lie on either side of it, ever nearer.
    """
    begin, end = (_joints_anywhere(lines, count, rng) for _ in range(2))
    begin = lines.asked.rounded(begin)
    starts = Starts(begin, _known_at(lines, begin), begin)
    parts = 10.0 ** rng.uniform(-2.0, 0.0, (count, 1))
    if folds:
        end = _joints_anywhere(lines, count, rng)
        parts = _folds(lines, starts, end - begin)
        nearer = 10.0 ** -rng.uniform(1.0, 2.0 * _BESIDE[lines.real], parts.shape)
        parts *= 1.0 + rng.choice([-1.0, 1.0], parts.shape) * nearer
    yield lines.run(starts, _poses(lines, begin + parts * (end - begin)), rng)


def _folds(lines: Direction, starts: Starts, way: np.ndarray) -> np.ndarray:
    """The parts (n, 1) of ways of the goal's joints from which on lines are stopped."""
    low, high = np.zeros((len(way), 1)), np.ones((len(way), 1))
    for k in range(_BISECTED):
        middle = high if k == 0 else 0.5 * (low + high)
        goals = _poses(lines, starts.guesses + middle * way)
        parts = lines.far_walker.reached(starts.unknowns, *lines.line(starts.known, goals))
        passes = (parts.shortest > 0.0)[:, None]
        low, high = np.where(passes, middle, low), np.where(passes, high, middle)
    return low


def _joints_anywhere(lines: Direction, count: int, rng: np.random.Generator) -> np.ndarray:
    """Joint values (count, joints) of an arm all over their ranges; whole turns and a third of the
    size where there is none.
    """
    most = [np.pi if c.is_angular else lines.size / 3 for c in lines.asked.mechanism.actuated]
    spans = zip(most, lines.asked.mechanism.actuated, strict=True)
    low, high = np.array([c.limits or (-end, end) for end, c in spans]).T
    return np.asarray(rng.uniform(low, high, (count, len(low))))


def _poses(lines: Direction, joints: np.ndarray) -> np.ndarray:
    """Poses of an arm's joints as the C's numbers are."""
    return lines.asked.rounded(_known_at(lines, joints))


# --- smooth paths ---------------------------------------------------------------------------------


def paths(
    lines: Direction, count: int, rng: np.random.Generator, steps: int = 400
) -> Iterator[Outcome]:
    """Goals on smooth random paths, each from the last answer that was right. The guess of a map
    holds one side's values only: where these do not lead from home to where a path stands, it
    begins anew.
    """
    at = lines.home.repeated(count)
    for goal in lines.asked.rounded(paths_of(lines, count, steps, rng)):
        outcome = lines.run(at, goal, rng, share=1.0)
        yield outcome
        at = lines.after(outcome, at)


def paths_of(lines: Direction, count: int, steps: int, rng: np.random.Generator) -> np.ndarray:
    """Goals (steps, paths, known): sums of sines about home within limits; poses of an arm are
    those of such joints.
    """
    arm = lines.asked.mechanism.serial
    coordinates = lines.asked.mechanism.actuated if arm else lines.problem.known_coordinates
    home = lines.home.unknowns[0] if arm else lines.home.known[0]
    time, goals = np.linspace(0.0, 1.0, steps)[:, None], []
    for middle, c in zip(home, coordinates, strict=False):
        waves = sum(
            rng.uniform(-1, 1, count) * np.sin(2 * np.pi * (w * time + rng.uniform(0, 1, count)))
            for w in range(1, _WAVES + 1)
        )
        waves = (waves - waves[0]) / (2.0 * np.abs(waves).max() + 1e-30)
        reach = _REACH * (1.0 if c.is_angular else 0.4 * lines.size)
        limits = c.limits or (-np.inf, np.inf)
        low, high = max(limits[0], middle - reach), min(limits[1], middle + reach)
        way = np.where(waves > 0, (high - middle) * waves, (middle - low) * waves)
        goals.append(middle + 0.98 * way)
    found = np.stack(goals, axis=-1)
    return np.array([_known_at(lines, row) for row in found]) if arm else found


# --- the table ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Range:
    """What is sent: outcomes of a problem's lines, `count` a leg, and the longest step of walks."""

    outcomes: Callable[[Direction, int, np.random.Generator], Iterator[Outcome]]
    count: int = 2000
    longest: float = LONGEST


def range_of(word: str, legs: int, steps: int) -> Range:
    """A range by its name, or by how far goals lie from home."""
    special = {
        "anywhere": Range(anywhere),
        "folds": Range(partial(anywhere, folds=True)),
        "paths": Range(partial(paths, steps=steps), 25, PLAIN),
    }
    if word in special:
        return special[word]
    reach = RANGES.get(word) or Reach(*(float(number) for number in word.split(",")))
    return Range(partial(by_legs, reach=reach, legs=legs))
