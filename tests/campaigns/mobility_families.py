"""Families of machines whose mobility is known by theory: does `mobility` count it, whatever the
seed?

    python tests/campaigns/mobility_families.py [--count 500] [--seed 0] [--seeds 10]
        [--family NAME] [-o FOLDER]

Each machine is drawn with round or with random numbers, turned in space and scaled between 1e-8 and
1e6. What moves is moved by this program too, with the joints' screws (a product of exponentials) or
the rods' lengths, NumPy only; what is rigid by theory is of full rank in the same screws, or is
named shaky. Sources: parallel cranks, translations; R. Bricard, Memoire sur la theorie de
l'octaedre articule, 1897 (octahedra, line- and plane-symmetric) and Lecons de cinematique, 1927
(loops of six revolutes); equal parallel rods, translations on a sphere alone. Exit status 1 where a
count is wrong, or depends on the seed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from helpers.inside import parse

Array = np.ndarray
CLOSED = 1e-11
"""Of the size: what a moved machine leaves open."""
MOVED = 0.02
"""Of the size: how far a machine that moves is moved, in steps of a tenth."""


@dataclass(frozen=True)
class Machine:
    """Revolutes (links, point, axis) or rods (from, to) from base to platform, and the mobility;
    `shaky`: rigid, though of a lower rank.
    """

    family: str
    mobility: int
    joints: tuple[tuple[str, str, Array, Array], ...] = ()
    rods: tuple[tuple[Array, Array], ...] = ()
    shaky: bool = False

    def placed(self, turn: Array, shift: Array, scale: float) -> Machine:
        """The same machine turned, moved and scaled."""

        def at(point: Array) -> Array:
            return scale * (turn @ point + shift)

        joints = tuple((a, b, at(point), turn @ axis) for a, b, point, axis in self.joints)
        return replace(self, joints=joints, rods=tuple((at(p), at(q)) for p, q in self.rods))

    def text(self) -> str:
        """The mechanism file."""
        lines = ["format = 1", f'name = "{self.family}"', 'length_unit = "m"', 'angle_unit = "rad"']
        for k, (a, b, point, axis) in enumerate(self.joints):
            lines += [
                "[[joint]]",
                f'name = "j{k}"',
                'type = "R"',
                f'links = ["{a}", "{b}"]',
                f"point = {_numbers(point)}",
            ]
            lines += [f"axis = {_numbers(axis)}", *(["actuated = true"] if k == 0 else [])]
        for k, (start, end) in enumerate(self.rods):
            lines += [
                "[[rod]]",
                f'name = "rod{k}"',
                'links = ["base", "platform"]',
                f"from = {_numbers(start)}",
            ]
            lines += [f"to = {_numbers(end)}"]
        return "\n".join(lines) + "\n"


def _numbers(vector: Array) -> str:
    return "[" + ", ".join(repr(float(v)) for v in vector) + "]"


# --- families -------------------------------------------------------------------------------------


def _draw(rng: np.random.Generator, round_numbers: bool, size: int = 3) -> Array:
    """A random point, or one of round numbers."""
    return rng.integers(-20, 21, size) / 10.0 if round_numbers else rng.uniform(-2.0, 2.0, size)


def _apart(rng: np.random.Generator, round_numbers: bool, count: int) -> Array:
    """Points no two of which are near each other."""
    while True:
        points = np.array([_draw(rng, round_numbers) for _ in range(count)])
        gaps = [np.linalg.norm(p - q) for k, p in enumerate(points) for q in points[:k]]
        if (
            min(gaps) > 0.3
            and np.linalg.svd(points - points.mean(axis=0))[1][min(2, count - 2)] > 0.3
        ):
            return points


def _cranks(family: str, pivots: Array, arms: Array, **known: object) -> Machine:
    z = np.array([0.0, 0.0, 1.0])
    joints = []
    for k, (pivot, arm) in enumerate(zip(pivots, arms, strict=True)):
        joints += [("base", f"c{k}", pivot, z), (f"c{k}", "coupler", pivot + arm, z)]
    return Machine(family, joints=tuple(joints), **known)  # type: ignore[arg-type]


def _flat(points: Array) -> Array:
    return np.column_stack([points[:, :2], np.zeros(len(points))])


def lift(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """A platform on three to five equal parallel cranks."""
    pivots = _flat(_apart(rng, round_numbers, int(rng.integers(3, 6))))
    arm = _flat(_apart(rng, round_numbers, 2))[0] + [0.45, 0.35, 0.0]
    return _cranks("lift", pivots, np.tile(arm, (len(pivots), 1)), mobility=1)


def folded_lift(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """The same with all pivots and cranks in one line: the reference is singular."""
    across = np.sort(rng.choice(np.arange(1, 12), 3, replace=False)) * (
        0.5 if round_numbers else rng.uniform(0.3, 0.7)
    )
    pivots = np.column_stack([across, np.zeros(3), np.zeros(3)])
    return _cranks("folded_lift", pivots, np.tile([0.31, 0.0, 0.0], (3, 1)), mobility=1)


def uneven_lift(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """One of three parallel cranks of another length: it can begin to move, and does not."""
    made = lift(rng, round_numbers)
    pivots = np.array([j[2] for j in made.joints[0:6:2]])
    arms = np.array([j[2] for j in made.joints[1:6:2]]) - pivots
    return _cranks(
        "uneven_lift", pivots, arms * np.array([1.0, 1.0, 1.5])[:, None], mobility=0, shaky=True
    )


def skew_lift(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """One of three parallel cranks turned to the side."""
    made = lift(rng, round_numbers)
    pivots = np.array([j[2] for j in made.joints[0:6:2]])
    arms = np.array([j[2] for j in made.joints[1:6:2]]) - pivots
    arms[2] = [-arms[2][1], arms[2][0], 0.0]
    return _cranks("skew_lift", pivots, arms, mobility=0)


def _loop(family: str, points: Array, axes: Array, mobility: int) -> Machine:
    links = ["base", "k1", "k2", "k3", "k4", "k5", "base"]
    joints = tuple(
        (links[k], links[k + 1], points[k], axes[k] / np.linalg.norm(axes[k])) for k in range(6)
    )
    return Machine(family, mobility, joints)


def line_symmetric(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """Three axes and their images in a half turn about z."""
    half = np.array([-1.0, -1.0, 1.0])
    points, axes = _apart(rng, round_numbers, 3), _apart(rng, round_numbers, 3)
    return _loop(
        "line_symmetric", np.vstack([points, points * half]), np.vstack([axes, axes * half]), 1
    )


def plane_symmetric(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """Two opposite axes in the plane z = 0, the others images of each other in it."""
    mirror, flat = np.array([1.0, 1.0, -1.0]), np.array([1.0, 1.0, 0.0])
    points, axes = _apart(rng, round_numbers, 4), _apart(rng, round_numbers, 4)
    points[[0, 3]] *= flat
    axes[[0, 3]] = axes[[0, 3]] * flat + [0.37, 0.21, 0.0]
    whole = np.vstack([points, points[[2, 1]] * mirror])
    return _loop("plane_symmetric", whole, np.vstack([axes, axes[[2, 1]] * mirror]), 1)


def moved_axis(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """A line-symmetric loop with one point displaced."""
    made = line_symmetric(rng, round_numbers)
    points = np.array([j[2] for j in made.joints])
    points[4] += _apart(rng, round_numbers, 2)[0] + [0.3, 0.5, 0.2]
    return _loop("moved_axis", points, np.array([j[3] for j in made.joints]), 0)


def six_axes(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """A loop of six revolutes without any relation."""
    return _loop("six_axes", _apart(rng, round_numbers, 6), _apart(rng, round_numbers, 6), 0)


def _octahedron(family: str, base: Array, opposite: Array, mobility: int) -> Machine:
    rods = tuple((base[i], opposite[j]) for i in range(3) for j in range(3) if i != j)
    return Machine(family, mobility, rods=rods)


def line_octahedron(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """Opposite vertices are images of each other in a half turn."""
    base = _apart(rng, round_numbers, 3)
    return _octahedron("line_octahedron", base, base * [-1.0, -1.0, 1.0], 1)


def plane_octahedron(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """Two pairs of opposite vertices are images of each other in a plane, the third pair lies in
    it.
    """
    base, other = _apart(rng, round_numbers, 3), _apart(rng, round_numbers, 3)
    base[2, 2] = 0.0
    opposite = base * [1.0, 1.0, -1.0]
    opposite[2] = other[2] * [1.0, 1.0, 0.0] + [0.0, 0.4, 0.0]
    return _octahedron("plane_octahedron", base, opposite, 1)


def rigid_octahedron(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """One vertex of a flexible one displaced."""
    base = _apart(rng, round_numbers, 3)
    opposite = base * [-1.0, -1.0, 1.0]
    opposite[1] += _apart(rng, round_numbers, 2)[0] + [0.3, 0.5, 0.2]
    return _octahedron("rigid_octahedron", base, opposite, 0)


def equal_rods(rng: np.random.Generator, round_numbers: bool) -> Machine:
    """Five to seven equal parallel rods: translations on a sphere; a turn about the rods ends at
    once.
    """
    points = _apart(rng, round_numbers, int(rng.integers(5, 8)))
    rod = np.array([0.3, 0.4, 1.2]) if round_numbers else rng.normal(size=3) + [0.0, 0.0, 2.0]
    return Machine("equal_rods", 2, rods=tuple((p, p + rod) for p in points))


FAMILIES: tuple[Callable[[np.random.Generator, bool], Machine], ...] = (
    lift,
    folded_lift,
    uneven_lift,
    skew_lift,
    line_symmetric,
    plane_symmetric,
    moved_axis,
    six_axes,
    line_octahedron,
    plane_octahedron,
    rigid_octahedron,
    equal_rods,
)


# --- the judge: screws and rods -------------------------------------------------------------------


def _turned(axis: Array, angle: float) -> Array:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


class Judge:
    """Rows and their derivatives of a machine of size 1 at joint angles, or at a platform's turn
    and shift.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine, self.loops = machine, []
        joints = machine.joints
        if len(joints) == 6 and joints[-1][1] == "base":
            self.loops = [[(k, 1.0) for k in range(6)]]
        elif joints:
            self.loops = [
                [(0, 1.0), (1, 1.0), (2 * k + 1, -1.0), (2 * k, -1.0)]
                for k in range(1, len(joints) // 2)
            ]
        self.freedom = len(joints) or 6

    def rows(self, z: Array) -> tuple[Array, Array]:
        """Closure errors and their derivatives along steps of `moved`."""
        if self.machine.rods:
            return self._rods(z)
        values, slopes = [], []
        for loop in self.loops:
            turn, shift, slope = np.eye(3), np.zeros(3), np.zeros((6, self.freedom))
            for k, sign in loop:
                _, _, point, axis = self.machine.joints[k]
                now, arm = turn @ axis, turn @ point + shift
                slope[:, k] = sign * np.concatenate([now, np.cross(arm, now)])
                by = _turned(axis, sign * z[k])
                turn, shift = turn @ by, turn @ (point - by @ point) + shift
            off = 0.5 * np.array(
                [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
            )
            values.append(np.concatenate([off, shift]))
            slopes.append(slope)
        return np.concatenate(values), np.vstack(slopes)

    def _rods(self, z: Array) -> tuple[Array, Array]:
        turn, shift = z[:9].reshape(3, 3), z[9:]
        starts, ends = (np.array(p) for p in zip(*self.machine.rods, strict=True))
        arms = ends @ turn.T
        along = arms + shift - starts
        values = 0.5 * (np.sum(along**2, axis=1) - np.sum((ends - starts) ** 2, axis=1))
        return values, np.hstack([np.cross(arms, along), along])

    @property
    def start(self) -> Array:
        return (
            np.concatenate([np.eye(3).ravel(), np.zeros(3)])
            if self.machine.rods
            else np.zeros(self.freedom)
        )

    def moved(self, z: Array, step: Array) -> Array:
        if not self.machine.rods:
            return z + step
        angle = float(np.linalg.norm(step[:3]))
        turn = _turned(step[:3] / angle, angle) if angle else np.eye(3)
        return np.concatenate([(turn @ z[:9].reshape(3, 3)).ravel(), z[9:] + step[3:]])

    def rank(self, z: Array) -> int:
        s = np.linalg.svd(self.rows(z)[1], compute_uv=False)
        return int(np.sum(s > 1e-9 * s[0]))

    def moves(self, rng: np.random.Generator) -> bool:
        """Whether small steps along first-order motions, each brought back to closed loops, lead
        away from the reference.
        """
        z, way = self.start, rng.normal(size=self.freedom)
        for _ in range(10):
            _, j = self.rows(z)
            _, s, v = np.linalg.svd(j)
            null = v[int(np.sum(s > 1e-9 * s[0])) :]
            way = null.T @ (null @ way)
            way /= np.linalg.norm(way)
            there = self.moved(z, 0.1 * MOVED * way)
            for _ in range(60):
                f, j = self.rows(there)
                there = self.moved(there, -np.linalg.pinv(j, rcond=1e-6) @ f)
            if not np.max(np.abs(self.rows(there)[0])) < CLOSED:
                return False
            z = there
        return True


def doubt(machine: Machine, rng: np.random.Generator) -> str:
    """Why theory is in doubt of this very machine: chance relations of round numbers, for
    example.
    """
    judge = Judge(machine)
    free = judge.freedom - judge.rank(judge.start)
    if machine.family in ("folded_lift", "equal_rods"):
        return ""
    if machine.mobility:
        return "" if free == machine.mobility and judge.moves(rng) else "the judge does not move it"
    return "" if free == int(machine.shaky) else "its rank is not what theory says"


# --- the campaign ---------------------------------------------------------------------------------


def drawn(index: int, seed: int, family: str | None) -> tuple[Machine, Machine]:
    """A machine of size about one, and the same turned and scaled."""
    rng = np.random.default_rng([seed, index])
    made = [make for make in FAMILIES if family in (None, make.__name__)]
    while True:
        machine = made[index % len(made)](rng, bool((index // len(made)) % 2))
        if not doubt(machine, rng):
            break
    turn = (
        _turned(*((v := rng.normal(size=3)) / np.linalg.norm(v), float(rng.uniform(0.0, 3.0))))
        if index % 5
        else np.eye(3)
    )
    shift = rng.normal(size=3) if index % 5 else np.zeros(3)
    scale = 10.0 ** float(rng.uniform(-8.0, 6.0)) if index % 3 else 1.0
    return machine, machine.placed(turn, shift, scale)


def wrong(text: str, machine: Machine, seeds: int) -> list[str]:
    """What is said that theory does not."""
    found, told = [], parse(text)
    for seed in range(seeds):
        account = symkin.mobility(told, seed=seed)
        if account.mobility != machine.mobility or not account.closed:
            found.append(f"seed {seed}: mobility {account.mobility} for {machine.mobility}")
        if account.digits is not None or (account.other_ranks and machine.family != "folded_lift"):
            found.append(f"seed {seed}: {account.warnings[0]}")
        if bool(account.infinitesimal) != (machine.shaky or machine.family == "equal_rods"):
            found.append(f"seed {seed}: {account.infinitesimal} freedoms of first order alone")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=10, help="seeds of `mobility`, each machine")
    parser.add_argument("--family", choices=[make.__name__ for make in FAMILIES])
    parser.add_argument("-o", "--output", type=Path, help="folder for the files of findings")
    options = parser.parse_args()
    begin, counts, bad = time.perf_counter(), Counter[str](), Counter[str]()
    for index in range(options.count):
        machine, placed = drawn(index, options.seed, options.family)
        counts[machine.family] += 1
        if index % 50 == 49:
            print(f"{index + 1} machines", flush=True)
        findings = wrong(placed.text(), machine, options.seeds)
        if findings:
            bad[machine.family] += 1
            print(f"{index} {machine.family}: " + "; ".join(findings[:3]))
            if options.output is not None:
                options.output.mkdir(parents=True, exist_ok=True)
                (options.output / f"{index}_{machine.family}.toml").write_text(placed.text())
    for family, count in counts.items():
        print(f"{family}: {count} machines, {bad[family]} wrong")
    print(
        f"{options.count} machines, {options.seeds} seeds each, {sum(bad.values())} wrong, "
        f"{time.perf_counter() - begin:.0f} s"
    )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
