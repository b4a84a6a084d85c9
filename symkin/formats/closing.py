"""Close the loops of a robot: the closed configuration nearest to the file's own, by
Levenberg-Marquardt on all closures and couplings.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symkin.computed_once import cached_property
from symkin.formats.robot import Robot
from symkin.formats.tree import NOTHING, Tree
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.rank import Rank, row_space
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import wrapped

CLOSED = 1e-10
"""Of the size: loops that stay open by less are closed."""
DIGITS = 1e-5
"""Of the size: loops that stay open by less close to the digits that files are written with."""
RANK_SHARE = 1e-8
"""Share of the largest singular value below which others count as zero, as for every closure of
symkin.
"""
_NOTHING = 1e-12
"""Derivative (a length for a length) below which no motion is felt at all: rounding, as where two
joints have one axis.
"""
_ROUNDING = 1e-14
"""Of the size: loops of a file that stay open by less are left as they are."""
_ITERATIONS = 300
"""Steps of one search; those that arrive take 10 to 100."""
_STALLED = 25
"""Steps in a row that shrink the gap by less than a tenth, after which a search has ended at a
local minimum.
"""
_STALLED_NEAR = 3
"""The same of a search from a step off a closed configuration."""
_SEARCHES = ((0.05, 4), (0.3, 8), (1.0, 24))
"""Further searches where the first does not close: radians (or shares of the size) of their random
steps, and how many.
"""
_NEAREST_STEPS = 30
"""Steps along the closed configurations towards the file's own."""
_SAME_DISTANCE = 1e-15
"""Share of a distance by which another one differs in rounding only: it comes no nearer."""
_NEIGHBOURS = 2
_STEPS_ASIDE = (0.1, 0.01)
"""How many closed configurations beside one its generic rank is taken at, and how far from it they
are looked for (shares of the size).
"""
_LEAST_KEPT, _GAP = 1e-6, 1e-3
"""Of the largest singular value, and of the smallest that counts: what makes a rank clear."""
_NEIGHBOURS_TO_DIGITS, _STEP_TO_DIGITS, _GAP_TO_DIGITS = 16, 0.3, 2e-2
"""The same where loops close only to the digits of a file: their misfit blurs what is zero, and
steps are larger than it.
"""
_SEED = 0


@dataclass(frozen=True, eq=False)
class Closed:
    """The closed configuration of a robot that is nearest to the file's own, or what comes nearest
    to one: `state` holds the values of the tree's coordinates.

    `displacements` move links from their places in the file. `gaps` tell what each closure and
    coupling leaves open in the file, `residuals` what it leaves here (metres).
    """

    tree: Tree
    state: np.ndarray

    @cached_property
    def gaps(self) -> Mapping[str, float]:
        return self.tree.misfits(self.tree.own)

    @cached_property
    def residuals(self) -> Mapping[str, float]:
        return self.tree.misfits(self.state)

    @property
    def open_by(self) -> float:
        """How far the file's own configuration leaves the loops open."""
        return max(self.gaps.values(), default=0.0)

    @property
    def residual(self) -> float:
        """The largest closure error left."""
        return max(self.residuals.values(), default=0.0)

    @property
    def resists(self) -> str:
        """The closure or coupling that has it."""
        return max(self.residuals, key=lambda name: self.residuals[name], default="")

    @property
    def closed(self) -> bool:
        return self.residual <= CLOSED * self.tree.size

    @property
    def to_digits(self) -> bool:
        """Whether the loops close, if only to the digits of a file."""
        return self.residual <= DIGITS * self.tree.size

    @cached_property
    def values(self) -> dict[str, tuple[float, ...]]:
        """Of every coordinate, in radians and metres; the quaternion of a ball from the file's
        configuration.
        """
        return self.tree.by_name(self.state)

    @cached_property
    def displacements(self) -> dict[str, Pose]:
        return self.tree.displacements(self.state)

    def rank(self) -> int:
        """Rank of the constraints here."""
        return rank_at(self.tree, self.state)


def nearest_closed(robot: Robot) -> Closed:
    """Close the loops from the file's own configuration, and go along the closed ones to the
    nearest. Where the first search ends open, others begin at random steps from there.
    """
    tree = Tree(robot)
    if _largest(tree, tree.own) <= _ROUNDING * tree.size:
        return Closed(tree, tree.own)

    def is_closed(state: np.ndarray) -> bool:
        return _largest(tree, state) <= CLOSED * tree.size

    (best,) = _searched(tree, tree.own[None])
    rng = np.random.default_rng(_SEED)
    for radius, count in _SEARCHES:
        if is_closed(best):
            break
        ends = _searched(tree, _random_steps(tree, tree.own, count, radius, rng))
        closed = [_without_turns(tree, end) for end in ends if is_closed(end)]
        best = (
            min(closed, key=lambda z: float(np.linalg.norm(way_between(tree, z, tree.own))))
            if closed
            else min((best, *ends), key=lambda z: _largest(tree, z))
        )
    if is_closed(best):
        best = _nearest(tree, _without_turns(tree, best))
    return Closed(tree, best)


def closed_neighbours(closed: Closed, count: int, seed: int, step: float = 0.1) -> list[np.ndarray]:
    """Closed configurations from random steps off a closed one; those searches that stay open are
    left out.
    """
    every = np.ones(closed.tree.freedom, dtype=bool)
    bound = max(CLOSED * closed.tree.size, closed.residual)
    return _ends_aside(closed, count, seed, step, every, bound)


def _ends_aside(
    closed: Closed, count: int, seed: int, step: float, moved: np.ndarray, bound: float
) -> list[np.ndarray]:
    """Where searches from random steps (share of the size) off a closed configuration, of some of
    the freedoms, end with loops that are open by no more than `bound`.
    """
    tree, rng = closed.tree, np.random.default_rng(seed)
    ends = _searched(tree, _random_steps(tree, closed.state, count, step, rng, moved))
    return [end for end in ends if _largest(tree, end) <= bound]


def rank_at(tree: Tree, state: np.ndarray, share: float = RANK_SHARE) -> int:
    """Rank of the derivative of all closures and couplings, lengths and angles times the size
    alike.
    """
    return _rank(tree, state, share).value


def _rank(tree: Tree, state: np.ndarray, share: float) -> Rank:
    _, jacobian = tree.system.linearise_one(state, NOTHING)
    return Rank.of(np.where(np.abs(jacobian) > _NOTHING, jacobian, 0.0), share)


@dataclass(frozen=True)
class GenericRank:
    """The rank at closed configurations beside one; `to_digits`: these close only to the digits of
    the file, and so the rank holds.
    """

    value: int
    to_digits: bool


def generic_rank(closed: Closed, seed: int) -> GenericRank | None:
    """The rank at closed configurations beside a closed one; None where no search finds one at
    which it is clear.
    """
    tree = closed.tree
    if not row_count(tree) or not tree.coordinates:
        return GenericRank(0, False)
    for step in _STEPS_ASIDE if closed.closed else ():
        ranks = _clear_ranks(
            tree, closed_neighbours(closed, _NEIGHBOURS, seed, step), RANK_SHARE, _GAP
        )
        if ranks:
            return GenericRank(max(ranks), False)
    # joints of one coordinate are moved alone: what a rounded file leaves to others is not their
    # motion
    names = {entry.joint.name for entry in tree.robot.tree}
    single = np.array(
        [c.name in names and c.freedom == 1 for c in tree.coordinates for _ in range(c.freedom)]
    )
    ends = _ends_aside(
        closed, _NEIGHBOURS_TO_DIGITS, seed, _STEP_TO_DIGITS, single, DIGITS * tree.size
    )
    ranks = _clear_ranks(tree, ends, DIGITS, _GAP_TO_DIGITS)
    return GenericRank(max(set(ranks), key=ranks.count), True) if ranks else None


def _clear_ranks(tree: Tree, states: list[np.ndarray], share: float, gap: float) -> list[int]:
    """Ranks at those states at which the singular values that count are far from those that do
    not.
    """
    ranks = [_rank(tree, state, share) for state in states]
    return [rank.value for rank in ranks if rank.least >= _LEAST_KEPT and rank.gap * gap >= 1.0]


def row_count(tree: Tree) -> int:
    """Constraints that the closures and couplings are counted with, each by itself."""
    return int(tree.system.rows.shape[0])


# --- searches -------------------------------------------------------------------------------------


def _largest(tree: Tree, state: np.ndarray) -> float:
    return max(tree.misfits(state).values(), default=0.0)


def _random_steps(
    tree: Tree,
    state: np.ndarray,
    count: int,
    radius: float,
    rng: np.random.Generator,
    moved: np.ndarray | bool = True,
) -> np.ndarray:
    """Configurations (count, width) at random steps (share of the size) of some of the freedoms."""
    steps = radius * tree.size * rng.normal(size=(count, tree.freedom)) * moved
    return tree.system.move(np.tile(state, (count, 1)), steps)


def _searched(tree: Tree, starts: np.ndarray) -> np.ndarray:
    """Where least squares on all rows ends: at rounding, or at a local minimum."""
    return _polished(tree, _ends(tree, starts, _STALLED))


def _polished(tree: Tree, points: np.ndarray) -> np.ndarray:
    return np.asarray(tree.system.polish_many(points, NOTHING).points)


def _ends(tree: Tree, starts: np.ndarray, patience: int) -> np.ndarray:
    """The same to the digits that its steps reach."""
    if not row_count(tree):
        return starts
    batch = levenberg_marquardt(
        tree.system,
        starts,
        NOTHING,
        tolerance=_ROUNDING,
        max_iterations=_ITERATIONS,
        patience=patience,
    )
    return batch.points


def _nearest(tree: Tree, state: np.ndarray) -> np.ndarray:
    """Go along the closed configurations towards the file's own, as long as that comes nearer."""
    share, far = 1.0, float(np.linalg.norm(way_between(tree, state, tree.own)))
    for _ in range(_NEAREST_STEPS):
        back = way_between(tree, state, tree.own)
        felt = row_space(tree.system.linearise_one(state, NOTHING)[1], RANK_SHARE, relative=True)
        free = back - felt.T @ (felt @ back)
        if share < 1e-3 or np.linalg.norm(free) <= 1e-9 * tree.size:
            break
        (trial,) = _ends(tree, tree.system.move(state[None], share * free[None]), _STALLED_NEAR)
        distance = float(np.linalg.norm(way_between(tree, trial, tree.own)))
        if distance < far and _largest(tree, trial) <= CLOSED * tree.size:
            state, far = trial, distance
        elif abs(distance - far) <= _SAME_DISTANCE * far:
            break
        else:
            share *= 0.3
    (found,) = _polished(tree, state[None])
    return np.asarray(found)


def way_between(tree: Tree, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The step of all freedoms, in lengths, from one configuration to another; of balls the angle
    times the size.
    """
    step = tree.system.difference(start[None], end[None])[0]
    begin = 0
    for c in tree.coordinates:
        if c.freedom == 3:
            turn = step[begin : begin + 3]
            tangent = float(np.linalg.norm(turn)) / (2.0 * tree.size)
            turn *= np.arctan(tangent) / tangent if tangent else 1.0
        begin += c.freedom
    return np.asarray(step)


def _without_turns(tree: Tree, state: np.ndarray) -> np.ndarray:
    """The same configuration with angles within half a turn of the file's, but those that a
    coupling or a screw counts.
    """
    counted = {name for c in tree.robot.couplings for name in (c.joint, *c.names)}
    turns = np.array(
        [
            c.kind == "angle" and c.name not in counted
            for c in tree.coordinates
            for _ in range(c.width)
        ]
    )
    away = state - tree.own
    return np.asarray(np.where(turns, state - (away - wrapped(away)), state))
