"""Whether OK of generated C means that all loops close: values on and off what machines can take.

What C answers is put into the closure of tests/oracle/plain_closure.py and plain_graph.py, where
every joint keeps its coordinates; passive joints are looked for from many starts. Each answer is
asked for once more, from itself: standing still has to be OK.
"""

from __future__ import annotations

import sys
import tempfile
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))

from asked import Asked, Machine, built
from oracle import plain_graph
from oracle.plain_closure import PlainMechanism, matrix_quaternion
from oracle.plain_search import closed_configurations, random_configurations, solve
from rows import Row
from symkin.machine.limbs import with_limbs
from symkin.model.writer import mechanism_to_toml
from symkin.spatial.rotation import multiply

CLOSES = {"float": 4e-5, "double": 4e-6}
"""Largest closure error of an OK, over the size: 1e-6, or 64 roundings, of each row, a few of which
add up in rows written otherwise.
"""
STARTS = 24
SPREADS = (0.05, 0.3)
"""How far configurations that close lie from the reference: half of them each."""


def closes(machine: Machine, real: str, count: int, rng: np.random.Generator) -> Row:
    """Ask a machine's code about `count` configurations, and values aside."""
    mechanism = machine.mechanism
    if not machine.given:
        mechanism = with_limbs(mechanism, "firmware", "")
    code = Code(Asked(mechanism, machine.options(real), built(machine, real)), Row())
    (_of_map if machine.given else _of_limbs)(machine, code, count, rng)
    return code.row


@dataclass(frozen=True, eq=False)
class Code:
    """A machine's code and what came of it."""

    asked: Asked
    row: Row

    def ask(
        self,
        what: str,
        goals: np.ndarray,
        guesses: np.ndarray | None,
        gaps: Callable[[np.ndarray, np.ndarray], np.ndarray],
        feasible: int = 0,
        way: str = "ask_all",
    ) -> None:
        """Ask for goals, from guesses where a problem has some, and then for each answer from
        itself. `gaps` tell of answers, with the places of their goals, how far from closing they
        are; the first `feasible` goals are such that the machine can take.
        """
        if guesses is None:
            status, found = self.asked.back(goals)
        else:
            status, found, _ = self.asked.answers(goals, guesses, way)
        at = np.flatnonzero(status == 0)
        again = np.zeros(len(at), int)
        if guesses is not None and len(at):
            again = self.asked.answers(goals[at], found[at], way).status
        off = gaps(at, found[at])
        wrong, taken = off > CLOSES[self.asked.options.real], int(np.sum(at < feasible))
        said = [
            f"{what}: {goals[at[k]].tolist()} gives {found[at[k]].tolist()}, open by {off[k]:.2g}, "
            f"from itself {again[k]}"
            for k in np.flatnonzero(wrong | (again != 0))[:3]
        ]
        row = Row(len(goals), len(at), int(wrong.sum()), int(np.sum(again != 0)), said=said)
        row.feasible, row.taken = feasible, taken
        self.row.add(row)


# --- platforms and arms by limbs ------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Limbs:
    """The plain closure of a mechanism of limbs, and configurations of it."""

    plain: PlainMechanism
    rng: np.random.Generator

    def poses(self, x: np.ndarray) -> np.ndarray:
        position, rotation = self.plain.pose(x)
        return np.column_stack([position, np.array([matrix_quaternion(r) for r in rotation])])

    def joints(self, x: np.ndarray) -> np.ndarray:
        return np.column_stack([x[:, self.plain.slices[i]] for i in self.plain.places("actuated")])

    def moved(self, poses: np.ndarray) -> np.ndarray:
        """Poses aside, by 1e-3 to a third of the size and as many radians."""
        far = 10.0 ** self.rng.uniform(-3.0, -0.5, (len(poses), 1))
        step = self.rng.normal(size=(len(poses), 6))
        half = 0.5 * far * step[:, 3:]
        turned = np.array(
            [multiply(np.array([1.0, *h]), q) for h, q in zip(half, poses[:, 3:], strict=True)]
        )
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        return np.column_stack([poses[:, :3] + self.plain.size * far * step[:, :3], turned])

    def projected(self, poses: np.ndarray) -> np.ndarray:
        """Poses with the numbers that the declared motion has."""
        m = self.plain
        return self.poses(
            np.vstack([m.with_pose(m.reference[None], pose[:3], pose[3:]) for pose in poses])
        )

    def gaps(self, begin: np.ndarray, poses: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """How far from closing (n,), over the size, configurations with poses and joint values are
        at best.
        """
        m, found = self.plain, []
        passive = m.places("passive")
        for x, pose, values in zip(begin, poses, joints, strict=True):
            start = m.with_pose(x[None], pose[:3], pose[3:] / np.linalg.norm(pose[3:]))
            for i, value in zip(m.places("actuated"), values, strict=True):
                start[:, m.slices[i]] = value
            gap = float(m.residual(solve(m, start, m.tangent(passive), 40))[0])
            if gap > 1e-6 and passive:
                many = random_configurations(m, np.tile(start, (STARTS, 1)), passive, self.rng)
                gap = min(gap, float(m.residual(solve(m, many, m.tangent(passive), 60)).min()))
            found.append(gap)
        return np.array(found)


def _of_limbs(machine: Machine, code: Code, count: int, rng: np.random.Generator) -> None:
    """Ask a platform's or an arm's code."""
    mechanism = code.asked.mechanism
    plain = PlainMechanism(tomllib.loads(mechanism_to_toml(mechanism)))
    limbs = Limbs(plain, rng)
    x = np.vstack([closed_configurations(plain, count // 2, spread, rng) for spread in SPREADS])
    if not len(x):
        return
    on, number = limbs.poses(x), len(mechanism.actuated)
    units = np.array([1.0 if c.is_angular else plain.size for c in mechanism.actuated])
    targets = [on, limbs.moved(on)]
    if not plain.serial:
        targets.append(limbs.projected(limbs.moved(on)))
    goals, begin = np.vstack(targets), np.vstack([x] * len(targets))

    def of_joints(at: np.ndarray, joints: np.ndarray) -> np.ndarray:
        return limbs.gaps(begin[at], goals[at], joints)

    joints = np.vstack([limbs.joints(x)] * 2)
    if plain.serial:
        # from beside the answer
        guesses = joints + 0.05 * rng.normal(size=joints.shape) * units
        code.ask("inverse", goals, guesses, of_joints, len(x))
        return
    code.ask("inverse", goals, None, of_joints, len(x))
    joints[len(x) :] += 0.3 * rng.normal(size=(len(x), number)) * units
    home = limbs.poses(plain.reference[None]) if machine.home is None else np.array([machine.home])

    def of_poses(at: np.ndarray, found: np.ndarray) -> np.ndarray:
        return limbs.gaps(begin[at], found, joints[at])

    code.ask("direct", joints, np.tile(home, (len(joints), 1)), of_poses)


# --- maps -----------------------------------------------------------------------------------------


def _of_map(machine: Machine, code: Code, count: int, rng: np.random.Generator) -> None:
    """Ask a map's code, both ways."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(mechanism_to_toml(machine.mechanism))
        file.flush()
        g = plain_graph.read(Path(file.name))
    places = [[g.place(n) for n in part] for part in (machine.given, machine.find)]
    units = np.array([1.0 if c.angle else g.size for c in g.coordinates])
    near = np.vstack([plain_graph.generic(g, count // 2, spread, seed=1) for spread in SPREADS])
    if not len(near):
        return
    values = g.values(near) * units
    home = np.array([c.zero for c in g.coordinates]) * units
    for what, function, known, wanted in (
        ("direct", "ask_all", *places),
        ("inverse", "ask_inverse", *reversed(places)),
    ):
        on, both = values[:, known], [*known, *wanted]
        goals = np.vstack([on, on + rng.normal(size=on.shape) * units[known]])
        guesses = np.vstack([values[:, wanted], np.tile(home[wanted], (len(near), 1))])

        def gaps(at: np.ndarray, found: np.ndarray, goals=goals, both=both) -> np.ndarray:  # type: ignore[no-untyped-def]
            numbers = np.hstack([goals[at], found]) / units[both]
            rows = (dict(zip(both, row, strict=True)) for row in numbers.tolist())
            each = zip(near[at % len(near)], rows, strict=True)
            return np.array([_graph_gap(g, x, fixed, rng) for x, fixed in each])

        code.ask(what, goals, guesses, gaps, len(near), function)


def _graph_gap(
    g: plain_graph.Graph, x: np.ndarray, fixed: dict[int, float], rng: np.random.Generator
) -> float:
    """How far from closing a graph is at best with fixed coordinates: from a configuration, then
    from random starts.
    """
    start = x[None].copy()
    for k, value in fixed.items():
        start[:, 7 * len(g.names) + k] = value
    columns = np.setdiff1d(np.arange(g.freedom), [6 * len(g.names) + k for k in fixed])
    gap = float(np.max(np.abs(g.closure(plain_graph.solve(g, start, columns))[0])))
    if gap > 1e-6:
        many = plain_graph.solve(g, plain_graph.random_starts(g, 4 * STARTS, fixed, rng), columns)
        gap = min(gap, float(np.max(np.abs(g.closure(many)[0]), axis=1).min()))
    return gap
