"""Whether anything is ever lost: many random machines and inputs, every count checked.

    python tests/campaigns/completeness.py [--count 1000] [--seed 0]
        [--cases platforms,legs,arm,generic,closed,closed_platforms]

platforms: random 6-6 geometries at the lengths of a random pose. legs: one symmetric platform
(zhang2009) at random lengths. arm: gluon_6l3 at random poses, against EAIK where it is installed.
generic: other mechanisms against 20,000 random starts. closed: random arms of each structure that
has a closed form, against continuation; closed_platforms: the same of platforms. Each line says how
many inputs had an unresolved path, a wrong count of complex roots, a lost pose (the one that made
the input), a duplicate or an odd number of real modes, and the largest closure error over the size.
Exit status 1 where any of this, or a lost mode, was found.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations
from os import environ
from pathlib import Path
from typing import Any

import numpy as np

import symkin
from symkin import Modes, Solution

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", default=",".join(CASES))
    options = parser.parse_args()
    print(
        f"count {options.count}, seed {options.seed}, engine {environ.get('SYMKIN_ENGINE', 'auto')}"
    )
    with tempfile.TemporaryDirectory() as folder:
        environ["SYMKIN_CACHE"] = folder
        wrong = [
            CASES[name](options.count, np.random.default_rng(options.seed))
            for name in options.cases.split(",")
        ]
    return int(any(wrong))


def report(name: str, found: Iterator[tuple[Modes, int, symkin.Pose | None]]) -> bool:
    """Whether anything is wrong with results, counted in a line; each comes with its expected
    complex count and a pose that must be among the modes.
    """
    wrong: Counter[str] = Counter()
    real: Counter[int] = Counter()
    largest, inputs = 0.0, 0
    for modes, complex_count, pose in found:
        inputs += 1
        size = modes.problem.closure.characteristic_length
        real[len(modes)] += 1
        largest = max([largest, *(mode.residual / size for mode in modes)])
        wrong["unresolved"] += bool(modes.unresolved_paths)
        wrong["wrong count"] += modes.complex_count != complex_count
        wrong["not claimed"] += modes.completeness not in ("probability one", "proved")
        wrong["odd"] += len(modes) % 2
        wrong["duplicate"] += has_duplicate(modes)
        if pose is not None:
            wrong["lost"] += (
                min((distance(mode, pose, size) for mode in modes), default=math.inf) > 1e-6
            )
    print(
        f"{name}: {inputs} inputs; {dict(wrong)}; largest error / size {largest:.1e}; real modes "
        f"{dict(sorted(real.items()))}",
        flush=True,
    )
    return wrong.total() > 0


def distance(mode: Solution, pose: symkin.Pose, size: float) -> float:
    return max(
        float(np.max(np.abs(mode.position - pose.position))) / size,
        float(np.max(np.abs(mode.rotation - pose.rotation))),
    )


def has_duplicate(modes: Modes) -> bool:
    """Whether two modes have one pose and the same values of all joints."""
    size = modes.problem.closure.characteristic_length
    return any(
        np.abs(flat(one, size) - flat(other, size)).max() < 1e-9
        for one, other in combinations(modes, 2)
    )


def random_pose(rng: np.random.Generator, spread: float, height: float, turn: float) -> symkin.Pose:
    q = np.array([1.0, 0, 0, 0]) + turn * rng.normal(size=4)
    return symkin.Pose(spread * rng.normal(size=3) + [0, 0, height], q / np.linalg.norm(q))


def platforms(count: int, rng: np.random.Generator) -> bool:
    def found() -> Iterator[tuple[Modes, int, symkin.Pose]]:
        for _ in range(count):
            rods = [
                symkin.RodLimb(f"leg{i}", rng.normal(size=3), 0.6 * rng.normal(size=3))
                for i in range(6)
            ]
            platform = symkin.Mechanism("platform", rods, platform_position=(0, 0, 1.5))
            pose = random_pose(rng, 1.0, 0.0, 10.0)
            yield (
                symkin.modes(
                    platform, joints=symkin.solve(platform, pose=pose).solution.actuated_values
                ),
                40,
                pose,
            )

    return report("random 6-6", found())


def legs(count: int, rng: np.random.Generator) -> bool:
    platform = symkin.load("zhang2009")

    def found() -> Iterator[tuple[Modes, int, symkin.Pose]]:
        for _ in range(count):
            pose = random_pose(rng, 80.0, 300.0, 0.2)
            yield (
                symkin.modes(
                    platform, joints=symkin.solve(platform, pose=pose).solution.actuated_values
                ),
                28,
                pose,
            )

    return report("zhang2009, random legs", found())


def arm(count: int, rng: np.random.Generator) -> bool:
    """Every solution of continuation is one of EAIK's and the reverse, to 1e-9 rad times the
    condition; by their residual where two lie closer than 1e-3.
    """
    mechanism = symkin.load("gluon_6l3")

    def found() -> Iterator[tuple[Modes, int, None]]:
        for pose in poses:
            yield symkin.modes(mechanism, pose=pose), 8, None

    poses = [
        symkin.modes(mechanism, joints=rng.uniform(-180, 180, 6))[0].pose for _ in range(count)
    ]
    bad = report("gluon_6l3, random poses", found())
    try:
        from eaik.IK_DH import DhRobot
    except ImportError:
        print("gluon_6l3 against EAIK: EAIK is not installed (pip install eaik)")
        return bad
    rows = mechanism.dh.rows
    robot = DhRobot(
        np.array([r.alpha for r in rows]),
        np.array([r.a for r in rows]),
        np.array([r.d for r in rows]),
    )
    wrong, compared, worst = 0, 0, 0.0
    for pose in poses:
        target = np.eye(4)
        target[:3, :3], target[:3, 3] = pose.rotation, pose.position
        answer = robot.IK(target)
        theirs = np.array(
            [q for q, least in zip(answer.Q, answer.is_LS, strict=True) if not least]
        ).reshape(-1, 6)
        theirs = theirs - [r.theta for r in rows]
        modes = symkin.modes(mechanism, pose=pose)
        ours = np.radians([m.actuated for m in modes]).reshape(-1, 6)
        conditions = np.array([m.condition for m in modes])
        apart = np.abs(np.angle(np.exp(1j * (ours[:, None] - theirs[None])))).max(axis=2)
        close = np.abs(np.angle(np.exp(1j * (ours[:, None] - ours[None])))).max(
            axis=2
        ) + 10 * np.eye(len(ours))
        plain = close.min(axis=1, initial=10.0) > 1e-3
        compared += len(ours)
        misses = (apart.min(axis=1, initial=10.0) > 1e-9 * conditions) & plain
        wrong += bool(misses.any() or (len(ours) != len(theirs) and plain.all()))
        worst = max(
            worst,
            float(np.max(apart.min(axis=1, initial=10.0)[plain] / conditions[plain], initial=0.0)),
        )
    print(
        f"gluon_6l3 against EAIK: {compared} solutions at {count} poses, {wrong} poses differ; "
        f"largest difference / condition {worst:.1e} rad"
    )
    return bad or wrong > 0


def generic(count: int, rng: np.random.Generator) -> bool:
    """At `count` / 200 inputs each, no root of 20,000 random starts is missing."""
    from helpers.samples import delta, five_bar, three_rrr

    machines = [five_bar(), three_rrr("planar"), delta(), replace(delta(), motion="spatial")]
    machines += [
        symkin.load(name) for name in ("zhao2000", "zhao2000_links", "ren2008_true", "zhang2009")
    ]
    bad = False
    for mechanism in machines:
        lost = more = unresolved = 0
        inputs = max(1, count // 200)
        for _ in range(inputs):
            shift = rng.uniform(-0.15, 0.15, len(mechanism.actuated))
            joints = [
                mechanism.angle_out(c.reference[0] + d)
                if c.is_angular
                else c.reference[0] * (1 + 0.3 * d)
                for c, d in zip(mechanism.actuated, shift, strict=True)
            ]
            complete = symkin.modes(mechanism, joints=joints)
            sampled = symkin.modes(mechanism, joints=joints, method="multistart", starts=20_000)
            unresolved += bool(complete.unresolved_paths)
            lost += missing(sampled, complete)
            more += missing(complete, sampled)
        print(
            f"{mechanism.name} ({mechanism.motion}): {inputs} inputs; {lost} modes of 20,000 "
            f"starts lost, {more} found beyond them, {unresolved} unresolved",
            flush=True,
        )
        bad |= lost + unresolved > 0
    return bad


def missing(some: Modes, others: Modes) -> int:
    """How many of `some` are not among `others`."""
    size = some.problem.closure.characteristic_length
    known = [flat(m, size) for m in others]
    return sum(
        min((np.max(np.abs(flat(m, size) - k)) for k in known), default=1.0) > 1e-5 for m in some
    )


def flat(mode: Solution, size: float) -> np.ndarray:
    angles = [
        f(v)
        for n, v in mode.values.items()
        if isinstance(v, float) and not n.startswith("pose.")
        for f in (math.cos, math.sin)
    ]
    return np.concatenate([mode.position / size, mode.rotation.ravel(), angles])


def closed(count: int, rng: np.random.Generator) -> bool:
    """Of random arms of each structure that has a closed form: the modes of formulas are those of
    continuation.
    """
    from helpers.arms import random_values, structures

    arms = structures(rng) | {
        name: symkin.load(name) for name in ("gluon_6l3", "yao2020", "ur5e", "scara")
    }
    bad = False
    for name, mechanism in arms.items():
        values = [
            [
                mechanism.angle_out(v) if c.is_angular else v
                for c, v in zip(mechanism.actuated, random_values(mechanism, rng), strict=True)
            ]
            for _ in range(count)
        ]
        poses = [symkin.solve(mechanism, joints=v).solution.pose for v in values]
        bad |= _beside_paths(name, mechanism, pose=poses)
    return bad


def closed_platforms(count: int, rng: np.random.Generator) -> bool:
    """The same of platforms: direct problems at joint values of whole turns, inverse ones at poses
    that these give.
    """
    from helpers.samples import readme_five_bar, three_rrr

    platforms = (
        symkin.load("delta"),
        readme_five_bar("planar"),
        symkin.load("zhao2000"),
        three_rrr("planar"),
    )
    bad = False
    for mechanism in platforms:
        size, joints = mechanism.characteristic_length, mechanism.actuated
        spread = np.array([math.pi if c.is_angular else 0.4 * size for c in joints])
        middle = np.array([c.reference[0] for c in joints])
        values = middle + spread * rng.uniform(-1.0, 1.0, (count, len(joints)))
        values *= [mechanism.angle_out(1.0) if c.is_angular else 1.0 for c in joints]
        if mechanism.name != "three_rrr":
            bad |= _beside_paths(f"{mechanism.name}, direct", mechanism, joints=values)
        poses = [mode.pose for modes in symkin.modes(mechanism, joints=values) for mode in modes][
            :count
        ]
        if poses:
            bad |= _beside_paths(f"{mechanism.name}, inverse", mechanism, pose=poses)
    return bad


def _beside_paths(name: str, mechanism: symkin.Mechanism, **inputs: Any) -> bool:
    """Whether formulas find modes that paths do not, or the other way round, counted in a line."""
    ours = symkin.modes(mechanism, **inputs)
    theirs = symkin.modes(mechanism, **inputs, method="continuation")
    lost = sum(missing(b, a) for a, b in zip(ours, theirs, strict=True))
    more = sum(missing(a, b) for a, b in zip(ours, theirs, strict=True))
    left, solved = sum(a.method != "closed" for a in ours), sum(len(a) > 0 for a in ours)
    print(
        f"{name}: {len(ours)} inputs, {solved} with modes, {left} left to paths; {lost} modes of "
        f"paths lost, {more} found beyond them",
        flush=True,
    )
    return lost + more > 0


CASES: dict[str, Callable[[int, np.random.Generator], bool]] = {
    "platforms": platforms,
    "legs": legs,
    "arm": arm,
    "generic": generic,
    "closed": closed,
    "closed_platforms": closed_platforms,
}

if __name__ == "__main__":
    sys.exit(main())
