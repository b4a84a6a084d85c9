"""Close the loops of a robot: the closed configuration nearest to the file's own, by
Levenberg-Marquardt on all closures and couplings.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from symkin.formats.closure_rows import ROWS, constraint_rows
from symkin.formats.robot import Robot
from symkin.formats.tree_motion import Placed, State, Step, Tree
from symkin.spatial.pose import Pose

CLOSED = 1e-10
"""Of the size: loops that stay open by less are closed."""
DIGITS = 1e-5
"""Of the size: loops that stay open by less close to the digits that files are written with."""
RANK_SHARE = 1e-8
"""Share of the largest singular value below which others count as zero, as for every closure of
symkin.
"""
_NOTHING = 1e-12
"""Singular value (a length for a length) below which no motion is felt at all: rounding, as where
two joints have one axis.
"""
_ROUNDING = 1e-14
"""Of the size: loops of a file that stay open by less are left as they are."""
_ITERATIONS = 300
"""Steps of one search; those that arrive take 10 to 100."""
_MOST_DAMPING = 1e8
"""Damping (singular values of lengths) at which a step that makes nothing smaller ends a search."""
_FELT = 1e-4
"""Share of the rows' values that steps can change, below which a search is at a local minimum: a
millionth of a percent of their squares is left to gain.
"""
_STALLED = 25
"""Steps in a row that shrink the gap by less than a tenth, after which a search has ended at a
local minimum.
"""
_SEARCHES = ((0.05, 4), (0.3, 8), (1.0, 24))
"""Further searches where the first does not close: radians (or shares of the size) of their random
steps, and how many.
"""
_NEAREST_STEPS = 30
"""Steps along the closed configurations towards the file's own."""
_NEIGHBOURS = 2
_STEPS_ASIDE = (0.1, 0.01)
"""How many closed configurations beside one its generic rank is taken at, and how far from it they
are looked for (shares of the size).
"""
_LEAST_KEPT, _GAP = 1e-6, 1e-3
"""Of the largest singular value, and of the smallest that counts: what makes a rank clear."""
_NEIGHBOURS_TO_DIGITS, _STEP_TO_DIGITS, _GAP_TO_DIGITS = 4, 0.3, 2e-2
"""The same where loops close only to the digits of a file: their misfit blurs what is zero, and
steps are larger than it.
"""
_SEED = 0


@dataclass(frozen=True, eq=False)
class Closed:
    """The closed configuration of a robot that is nearest to the file's own, or what comes nearest
    to one.

    `values` are of every coordinate (radians, metres; the quaternion of a ball from the file's
    configuration); `displacements` move links from their places in the file. `gaps` tell what each
    closure and coupling leaves open in the file, `residuals` what it leaves here (metres). `state`
    is the same configuration as `values`, for `tree`.
    """

    tree: Tree
    state: State
    placed: Placed
    gaps: Mapping[str, float]
    residuals: Mapping[str, float]

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

    @property
    def values(self) -> dict[str, tuple[float, ...]]:
        return {
            step.name: tuple(map(float, value))
            for step, value in zip(self.tree.steps, self.state, strict=True)
        }

    @property
    def displacements(self) -> dict[str, Pose]:
        return {link: self.placed.displacement(link) for link in self.placed.rotations}

    def rank(self) -> int:
        """Rank of the constraints here."""
        return rank_at(self.tree, self.state)


def nearest_closed(robot: Robot) -> Closed:
    """Close the loops from the file's own configuration, and go along the closed ones to the
    nearest. Where the first search ends open, others begin at random steps from there.
    """
    tree = Tree(robot)
    best = tree.own
    if _largest(tree, best) <= _ROUNDING * tree.size:
        return Closed(tree, best, tree.placed(best), misfits(tree, best), misfits(tree, best))
    best = _searched(tree, best)
    rng = np.random.default_rng(_SEED)
    for start in _random_starts(tree, rng):
        if _largest(tree, best) <= CLOSED * tree.size:
            break
        found = _searched(tree, start)
        best = min(best, found, key=lambda state: _largest(tree, state))
    if _largest(tree, best) <= CLOSED * tree.size:
        best = _nearest(tree, _without_turns(tree, best))
    return Closed(tree, best, tree.placed(best), misfits(tree, tree.own), misfits(tree, best))


def closed_neighbours(closed: Closed, count: int, seed: int, step: float = 0.1) -> list[State]:
    """Closed configurations from random steps off a closed one; those searches that stay open are
    left out.
    """
    tree = closed.tree
    starts = _starts_aside(closed, count, seed, step, np.ones(tree.freedom, dtype=bool))
    bound = max(CLOSED * tree.size, closed.residual)
    ends = [_searched(tree, start) for start in starts]
    return [end for end in ends if _largest(tree, end) <= bound]


def _starts_aside(
    closed: Closed, count: int, seed: int, step: float, moved: np.ndarray
) -> list[State]:
    """Random steps (share of the size) off a closed configuration, of some of the freedoms."""
    tree, rng = closed.tree, np.random.default_rng(seed)
    steps = [step * tree.size * rng.normal(size=tree.freedom) * moved for _ in range(count)]
    return [tree.moved(closed.state, _unscaled(tree, lengths)) for lengths in steps]


def rank_at(tree: Tree, state: State, share: float = RANK_SHARE) -> int:
    """Rank of the derivative of all closures and couplings, lengths and angles times the size
    alike.
    """
    values = _singular_values(tree, state)
    return int(np.sum(values > share * max(values[:1], default=0.0)))


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
    if not row_count(tree.robot) or not tree.freedom:
        return GenericRank(0, False)
    for step in _STEPS_ASIDE if closed.closed else ():
        ranks = _clear_ranks(
            tree, closed_neighbours(closed, _NEIGHBOURS, seed, step), RANK_SHARE, _GAP
        )
        if ranks:
            return GenericRank(max(ranks), False)
    # joints of one coordinate are moved alone: what a rounded file leaves to others is not their
    # motion
    starts = _starts_aside(closed, _NEIGHBOURS_TO_DIGITS, seed, _STEP_TO_DIGITS, _single(tree))
    ends = [
        end
        for start in starts
        if _largest(tree, end := _searched(tree, start)) <= DIGITS * tree.size
    ]
    ranks = _clear_ranks(tree, ends, DIGITS, _GAP_TO_DIGITS)
    return GenericRank(max(set(ranks), key=ranks.count), True) if ranks else None


def _clear_ranks(tree: Tree, states: list[State], share: float, gap: float) -> list[int]:
    """Ranks at those states at which the singular values that count are far from those that do
    not.
    """
    found = []
    for state in states:
        values = _singular_values(tree, state)
        counted = int(np.sum(values > share * values[0]))
        dropped = values[counted] if counted < len(values) else 0.0
        if values[counted - 1] >= _LEAST_KEPT * values[0] and dropped <= gap * values[counted - 1]:
            found.append(counted)
    return found


def _single(tree: Tree) -> np.ndarray:
    """Which freedoms are those of joints of one coordinate."""
    names = {entry.joint.name for entry in tree.robot.joints}
    return np.array(
        [
            step.name in names and step.freedom == 1
            for step in tree.steps
            for _ in range(step.freedom)
        ]
    )


def _singular_values(tree: Tree, state: State) -> np.ndarray:
    jacobian = constraint_rows(tree).rates(state)
    if min(jacobian.shape) == 0:
        return np.zeros(0)
    values = np.linalg.svd(jacobian / _scales(tree), compute_uv=False)
    return np.where(values > _NOTHING, values, 0.0)


def row_count(robot: Robot) -> int:
    """Constraints that the closures and couplings are counted with, each by itself."""
    return sum(ROWS[closure.type] for closure in robot.closures) + len(robot.couplings)


def misfits(tree: Tree, state: State) -> dict[str, float]:
    """What each closure and coupling leaves open (metres), by its name."""
    rows = constraint_rows(tree)
    values = rows.values(state)
    return {name: float(np.linalg.norm(values[place])) for name, place in rows.places}


# --- searches -------------------------------------------------------------------------------------


def _scales(tree: Tree) -> np.ndarray:
    """What steps are multiplied by to be lengths."""
    return np.where(tree.angular, tree.size, 1.0)


def _unscaled(tree: Tree, lengths: np.ndarray) -> np.ndarray:
    return np.asarray(lengths / _scales(tree))


def _largest(tree: Tree, state: State) -> float:
    return max(misfits(tree, state).values(), default=0.0)


def _random_starts(tree: Tree, rng: np.random.Generator) -> Iterator[State]:
    for radius, count in _SEARCHES:
        for _ in range(count):
            yield tree.moved(
                tree.own, _unscaled(tree, radius * tree.size * rng.normal(size=tree.freedom))
            )


def _searched(tree: Tree, start: State) -> State:
    """Minimise the squares of all rows: (J^T J + l^2 1) d = -J^T F, in lengths, until they are
    rounding or none of F is felt by J: a local minimum.
    """
    state, scales, rows = start, _scales(tree), constraint_rows(tree)
    values, slopes, damping = rows.values(state), _Slopes(rows.rates(state) / scales), 0.1
    mark, since = np.inf, 0
    for _ in range(_ITERATIONS):
        cost, felt = float(np.linalg.norm(values)), slopes.felt(values)
        mark, since = (cost, 0) if cost < 0.9 * mark else (mark, since + 1)
        done = cost <= _ROUNDING * tree.size or np.linalg.norm(felt) <= _FELT * cost
        if done or since > _STALLED:
            break
        while damping < _MOST_DAMPING:
            trial = tree.moved(state, slopes.step(felt, damping) / scales)
            trial_values = rows.values(trial)
            if np.linalg.norm(trial_values) < cost:
                break
            damping *= 5.0
        else:
            break
        state, values = trial, trial_values
        slopes, damping = _Slopes(rows.rates(state) / scales), max(0.2 * damping, 1e-10)
    return state


class _Slopes:
    """A derivative by its singular values, so that directions that no row feels are left alone."""

    def __init__(self, jacobian: np.ndarray) -> None:
        u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
        kept = s > 1e-12 * max(s[:1], default=0.0)
        self.u, self.s, self.vt = u[:, kept], s[kept], vt[kept]

    def felt(self, values: np.ndarray) -> np.ndarray:
        """What steps can change of values."""
        return np.asarray(values @ self.u)

    def step(self, felt: np.ndarray, damping: float) -> np.ndarray:
        return np.asarray(-(felt * self.s / (self.s**2 + damping**2)) @ self.vt)


def _nearest(tree: Tree, state: State) -> State:
    """Go along the closed configurations towards the file's own, as long as that comes nearer."""
    scales, share = _scales(tree), 1.0
    far = float(np.linalg.norm(scales * tree.between(state, tree.own)))
    for _ in range(_NEAREST_STEPS):
        back = scales * tree.between(state, tree.own)
        free = back - _felt(constraint_rows(tree).rates(state) / scales, back)
        if share < 1e-3 or np.linalg.norm(free) <= 1e-9 * tree.size:
            break
        trial = _searched(tree, tree.moved(state, share * free / scales))
        distance = float(np.linalg.norm(scales * tree.between(trial, tree.own)))
        if distance < far and _largest(tree, trial) <= CLOSED * tree.size:
            state, far = trial, distance
        else:
            share *= 0.3
    return state


def _felt(jacobian: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """The part of a step that the rows feel."""
    _, s, vt = np.linalg.svd(jacobian, full_matrices=False)
    kept = vt[s > RANK_SHARE * max(float(s[0]), 1e-300)] if s.size else vt[:0]
    return np.asarray(kept.T @ (kept @ vector))


def _without_turns(tree: Tree, state: State) -> State:
    """The same configuration with angles within half a turn of the file's, but those that a
    coupling or a screw counts.
    """
    counted = {name for c in tree.robot.couplings for name in (c.joint, *c.names)}
    return tuple(
        _wrapped(value, step.zero) if _turns(step, counted) else value
        for value, step in zip(state, tree.steps, strict=True)
    )


def _turns(step: Step, counted: Collection[str]) -> bool:
    return step.kind == "turn" and step.lead == 0.0 and step.name not in counted


def _wrapped(value: np.ndarray, zero: float) -> np.ndarray:
    turns = np.rint((value - zero) / (2.0 * np.pi))
    return np.asarray(value - 2.0 * np.pi * turns)
