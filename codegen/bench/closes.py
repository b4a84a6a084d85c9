"""Whether OK of generated C means that all loops close: values on and off what machines can take.

What C answers is put into the closures of tests/oracle (plain_closure.py, plain_graph.py), where
every joint keeps its coordinates; passive joints are looked for from many starts. Each answer is
asked for once more, from itself: standing still has to be OK.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from asked import Asked
from campaigns.twin_oracle import Limbs, Oracle, numbers_only, oracle_of
from directions import Direction, directions
from rows import Row
from symkin.model.writer import mechanism_to_toml
from symkin.spatial.rotation import multiply

CLOSES = {"float": 4e-5, "double": 4e-6}
"""Largest closure error of an OK, over the size: 1e-6, or 64 roundings, of each row, a few of which
add up in rows written otherwise.
"""
SPREADS = (0.05, 0.3)
"""How far configurations that close lie from the reference: half of them each."""
BESIDE = 0.05
"""How far guesses lie from the joints of such configurations (rad, or of the size)."""

Side = tuple[str, ...] | None
"""What is given or found: joints by name, or the pose."""


def closes(asked: Asked, count: int, rng: np.random.Generator) -> Row:
    """Ask a machine's code both ways, an arm's for joints, about `count` configurations and values
    aside.
    """
    oracle = oracle_of(numbers_only(tomllib.loads(mechanism_to_toml(asked.mechanism))))
    near = np.vstack([oracle.closed(count // 2, spread, rng) for spread in SPREADS])
    row = Row()
    for problem in Plain(asked, oracle, near, rng).problems() if len(near) else ():
        row.add(problem)
    return row


@dataclass(frozen=True, eq=False)
class Plain:
    """A machine's code and its plain closure, configurations of which are `near` the reference."""

    asked: Asked
    oracle: Oracle
    near: np.ndarray
    rng: np.random.Generator

    def problems(self) -> Iterator[Row]:
        joints, options = tuple(self.oracle.actuated), self.asked.options
        ways = directions(self.asked)
        if self.asked.kind == "map":
            yield self._judged(options.given, options.find, ways[0])
            yield self._judged(options.find, options.given, ways[1])
            return
        yield self._judged(None, joints, ways[0] if self.asked.kind == "arm" else None)
        if self.asked.kind == "platform":
            yield self._judged(joints, None, ways[0])

    def _judged(self, known: Side, wanted: Side, way: Direction | None) -> Row:
        """Ask for goals, of a problem that takes guesses by its `way`, and then for each answer
        from itself. Goals of the closed configurations come first: if these are poses, or joints
        that are asked for from beside them, the machine can take them.
        """
        on, count = self._values(known), len(self.near)
        goals = np.vstack([on, self._aside(known, on)])
        if way is None:
            goals = np.vstack([goals, self._of_motion(goals[count:])])
            status, found = self.asked.back(goals)
            again = 0 * status
        else:
            guesses = np.repeat(way.home.guesses, len(goals), axis=0)
            if wanted is not None:
                beside = BESIDE * self.rng.normal(size=(count, len(wanted)))
                guesses[:count] = self._values(wanted) + beside * self._units(wanted)[0]
            status, found, _ = way.answers(goals, guesses)
            again = way.answers(goals, np.where(status[:, None] == 0, found, guesses)).status
        row = Row(len(goals), int(np.sum(status == 0)), feasible=count if wanted else 0)
        row.taken = int(np.sum(status[: row.feasible] == 0))
        for k in np.flatnonzero(status == 0):
            sides = {known: goals[k], wanted: found[k]}
            gap, _ = self.oracle.fitted(self._mode(sides), self.near[k % count])
            wrong = gap > CLOSES[self.asked.options.real]
            row.wrong, row.moved = row.wrong + wrong, row.moved + int(again[k] != 0)
            if (wrong or again[k]) and len(row.said) < 3:
                given = f"{known or 'pose'} {goals[k].tolist()} gives {found[k].tolist()}"
                row.said.append(f"{given}, open by {gap:.2g}, from itself {again[k]}")
        return row

    def _mode(self, sides: dict[Side, np.ndarray]) -> dict[str, Any]:
        """A configuration as a mode of the oracle's: joints in the file's units, and a pose."""
        mode: dict[str, Any] = {"joints": {}, "pose": None}
        for names, values in sides.items():
            if names is None:
                mode["pose"] = [*values[:3], *(values[3:] / np.linalg.norm(values[3:]))]
            else:
                mode["joints"] |= zip(names, values / self._units(names)[1], strict=True)
        return mode

    def _values(self, side: Side) -> np.ndarray:
        """What C would state at the closed configurations."""
        if side is None:
            return np.array([self.oracle.pose(x) for x in self.near])
        rows = [[self.oracle.joints(x)[name] for name in side] for x in self.near]
        return np.array(rows) * self._units(side)[1]

    def _units(self, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
        """The size or a radian of each joint, and the unit in which files and oracle state it."""
        mechanism = self.asked.mechanism
        known = {c.name: c for c in (*mechanism.coordinates, *mechanism.actuated)}
        angular = np.array([known[name].is_angular for name in names])
        stated = np.pi / 180 if mechanism.angle_unit == "deg" else 1.0
        return np.where(angular, 1.0, self.oracle.size), np.where(angular, stated, 1.0)

    def _aside(self, side: Side, on: np.ndarray) -> np.ndarray:
        """Poses aside by 1e-3 to a third of the size and as many radians, joints up to three."""
        far = 10.0 ** self.rng.uniform(-3.0, -0.5 if side is None else 0.5, (len(on), 1))
        step = far * self.rng.normal(size=(len(on), 6 if side is None else len(side)))
        if side is not None:
            return on + step * self._units(side)[0]
        turns = np.column_stack([np.ones(len(on)), 0.5 * step[:, 3:]])
        q = np.array([multiply(turn, q) for turn, q in zip(turns, on[:, 3:], strict=True)])
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        return np.column_stack([on[:, :3] + self.oracle.size * step[:, :3], q])

    def _of_motion(self, poses: np.ndarray) -> np.ndarray:
        """Poses with the numbers that the declared motion has; none of a graph, whose joints alone
        decide how the platform moves.
        """
        if not isinstance(self.oracle, Limbs):
            return poses[:0]
        m = self.oracle.m
        placed = (m.with_pose(m.reference[None], pose[:3], pose[3:])[0] for pose in poses)
        return np.array([self.oracle.pose(x) for x in placed])
