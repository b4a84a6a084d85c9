"""Does NAME_OK mean the branch? Random goals about home, against a fine continuation.

For each goal the joints are followed along the straight line from home in many small steps; a line is regular where det J
keeps its sign and steps of 1/25600 of it converge; what is OK on others must be right as well. The generated C is then
asked for the same joint values with home as the guess. With `--legs N`, N such lines follow each other: the next one begins
at an answer that was OK, others at home. An answer is on the same pose when it differs by no more than
rounding makes of the rows: 16 units in the last place times the condition there, and 2e-7 of the size.

    python codegen/bench/branches.py [NAME|FILE ...] [--count 5000] [--range PART,TURN] [--legs 1] [--real double] [--seed 0] [--write]

A platform on rods gets goals by poses (within 0.34 of its size, 180 mm for the first, and 1 rad), any other one by joint
values (within 0.15 of its size and 0.6 rad); `--range` gives other ones, up to whole turns. `machines/` holds mechanisms that are
not shipped. Lines on which a limb passes a dead centre count as regular here, and the C refuses them.
"""

from __future__ import annotations

import argparse
import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench_cases import HOME
from continuation import Walker
from readme import written
from symkin.codegen.c_emitter import Real
from symkin.codegen.folder import write_folder
from symkin.codegen.options import Options
from symkin.codegen.program import Kind, build_program
from symkin.codegen.rod_platform import RodPlatform
from symkin.formats.load import load
from symkin.model.mechanism import Mechanism
from symkin.position.problem import build_problem
from symkin.position.solution import pose_of
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply

STUDIED = ("zhang2009", "ren2008", "zhao2000")
HOMES = {"zhang2009": HOME}


@dataclass(frozen=True)
class Reach:
    """How far goals lie from home: positions of poses or sliding joints (a part of the size), rotations (rad)."""

    part: float
    turn: float


REGULAR = 1.0 / 25600
"""A line that needs shorter steps than this part of it passes too near a singularity to be called regular."""
WIDE_POSES = Reach(180.0 / 531.2592, 1.0)
WIDE_JOINTS = Reach(0.15, 0.6)


@dataclass(frozen=True)
class Found:
    """Counts of one study: all goals; regular lines within the joints' ranges; OK; OK on another pose than the line's."""

    goals: int
    regular: int
    ok: int
    wrong: int
    ok_of_regular: float
    mean_steps: float
    most_steps: int

    def row(self, name: str, real: str) -> str:
        return (
            f"| {name} {real} | {self.goals:,} | {self.regular:,} | {self.ok_of_regular:.1f} % | {self.wrong} | "
            f"{self.mean_steps:.1f} | {self.most_steps} |"
        )


def goals_about(kind: Kind, count: int, reach: Reach, rng: np.random.Generator) -> np.ndarray:
    """Joint values (count, joints): of poses about home, or about the reference's joint values; kept within limits."""
    size, joints = kind.mechanism.characteristic_length, kind.mechanism.actuated
    if isinstance(kind, RodPlatform):
        goals = np.array([kind.lengths(_pose_about(kind.home, reach, size, rng)) for _ in range(count)])
    else:
        middle = np.array([c.reference[0] for c in joints])
        spread = np.array([reach.turn if c.is_angular else reach.part * size for c in joints])
        goals = middle + spread * rng.uniform(-1, 1, (count, len(joints)))
    for i, c in enumerate(joints):
        if c.limits is not None:
            goals[:, i] = np.clip(goals[:, i], *c.limits)
    return goals


def _pose_about(home: Pose, reach: Reach, size: float, rng: np.random.Generator) -> Pose:
    shift = reach.part * size * rng.uniform(-1, 1, 3)
    turn = rng.uniform(-reach.turn, reach.turn, 3)
    angle = float(np.linalg.norm(turn))
    q = multiply(np.array([np.cos(angle / 2), *(np.sin(angle / 2) / angle * turn)]), np.asarray(home.quaternion))
    return Pose(np.asarray(home.position) + shift, np.asarray(q))


def study(mechanism: Mechanism, options: Options, count: int, reach: Reach | None = None, seed: int = 0, legs: int = 1) -> Found:
    """Asks the generated C for random goals, `count` at a time, and compares what it calls OK with the fine continuation."""
    kind = build_program(mechanism, options).kind
    problem = build_problem(mechanism, "direct")
    home = kind.home_values  # type: ignore[union-attr]
    rng, epsilon, size = np.random.default_rng(seed), Real(options.real).epsilon, mechanism.characteristic_length
    reach = reach or (WIDE_POSES if isinstance(kind, RodPlatform) else WIDE_JOINTS)
    walker, ask = Walker(problem), asking(mechanism, options)
    first, pose = problem.select_values(home, problem.system.unknowns), pose_of(problem.closure, home)
    zs, begins = np.tile(first, (count, 1)), np.tile(problem.select_values(home, problem.known_coordinates), (count, 1))
    guesses = np.tile([*pose.position, *pose.quaternion], (count, 1))
    home_rows = zs.copy(), begins.copy(), guesses.copy()
    totals = []
    for _ in range(legs):
        goals = goals_about(kind, count, reach, rng)
        goals = goals.astype(np.float32 if options.real == "float" else np.float64).astype(float)
        status, poses, steps = ask(goals, guesses)
        ok = status == 0
        z, shortest = walker.reached(zs, begins, goals)
        right = np.zeros(count, dtype=bool)
        for k in np.flatnonzero(ok & (shortest > 0.0)):
            reached = pose_of(problem.closure, problem.join_values(z[k], goals[k]))
            near = 2e-7 + 16 * epsilon * problem.system.condition(z[k], goals[k])
            right[k] = _distance(poses[k], reached, size) < near * size
        within = (shortest >= REGULAR) & (status != 4)
        totals.append([within.sum(), ok.sum(), (ok & ~right).sum(), (ok & within).sum(), steps.sum(), steps.max()])
        rows = zip((z, goals, poses), home_rows, strict=True)
        zs, begins, guesses = (np.where(right[:, None], there, at_home) for there, at_home in rows)
    regular, answered, wrong, good, taken, _ = (int(n) for n in np.sum(totals, axis=0))
    return Found(count * legs, regular, answered, wrong, 100.0 * good / max(1, regular), taken / (count * legs), int(np.max(totals, axis=0)[5]))  # fmt: skip


def _distance(found: np.ndarray, reached: Pose, size: float) -> float:
    """Largest difference of positions, and of quaternions up to sign times the size."""
    q = np.asarray(reached.quaternion)
    turned = min(np.max(np.abs(found[3:] - q)), np.max(np.abs(found[3:] + q)))
    return float(max(np.max(np.abs(found[:3] - reached.position)), 2 * size * turned))


Answers = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""Status, pose and count of steps of NAME_direct for each goal (n, joints) from each guess (n, 7)."""


def asking(mechanism: Mechanism, options: Options) -> Answers:
    """The generated C, compiled."""
    folder, name = Path(tempfile.mkdtemp()), mechanism.name
    write_folder(mechanism, folder, options)
    flags = ["-O2", "-std=c99", "-fno-math-errno", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run(["gcc", *flags, f"{name}.c", "-o", "code.so", "-lm"], cwd=folder, check=True)
    call = getattr(ctypes.CDLL(str(folder / "code.so")), f"{name}_direct")
    number = ctypes.c_float if options.real == "float" else ctypes.c_double

    def answers(goals: np.ndarray, guesses: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        pose, info = (number * 7)(), (ctypes.c_ubyte * 64)()
        status, poses, steps = np.zeros(len(goals), int), np.zeros((len(goals), 7)), np.zeros(len(goals), int)
        for k, (goal, guess) in enumerate(zip(goals, guesses, strict=True)):
            status[k] = call(None, (number * len(goal))(*goal), (number * 7)(*guess), pose, info)
            poses[k], steps[k] = pose[:], info[0]
        return status, poses, steps

    return answers


def report(names: list[str], count: int, reals: list[str], seed: int, legs: int, reach: Reach | None = None) -> str:
    lines = [
        f"Seed {seed}.", "",
        "| solver | goals | regular lines | OK of these | OK on another pose | mean steps | most steps |", "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    for name in names:
        for real in reals:
            found = study(load(name), Options(real, home=HOMES.get(name)), count, reach, seed=seed, legs=legs)  # type: ignore[arg-type]
            lines.append(found.row(Path(name).stem, real))
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", default=list(STUDIED))
    parser.add_argument("--range", metavar="PART,TURN", help="how far goals lie from home: a part of the size, and rad")
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--legs", type=int, default=1, help="lines that follow each other (default: 1)")
    parser.add_argument("--real", choices=("float", "double"), action="append", help="default: both")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", action="store_true", help="write the table into codegen/README.md")
    chosen = parser.parse_args()
    given = Reach(*(float(number) for number in chosen.range.split(","))) if chosen.range else None
    measured = report(chosen.names, chosen.count, chosen.real or ["double", "float"], chosen.seed, chosen.legs, given)
    print(measured)
    if chosen.write:
        written("branches", measured)
