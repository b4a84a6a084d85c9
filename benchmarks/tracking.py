"""Whether a followed mode is ever left unnoticed: many random smooth paths of a hexapod, every one
checked.

    python benchmarks/tracking.py [--count 1000] [--seed 0] [--samples 16] [--amplitude 20]
        [--mechanism zhang2009]

Each path starts at a random regular pose and goes along a random smooth curve in joint space (two
Fourier terms a joint), through `--samples` points. At both ends the complete enumeration must
contain the followed mode, and an independent continuation, Newton at a fixed step of a twentieth of
each interval (of a thousandth where that fails beside a fold), judged by nothing but closeness,
must end at the same one. The line at the end counts the paths: those that reached the end or
stopped at a singularity, those certified, and what is wrong (see FAULTS).
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

import symkin
from cases import FOLLOWED
from symkin.following.track import track
from symkin.following.track_result import Track
from symkin.position.problem import Problem
from symkin.position.roots import features
from symkin.position.solution import Solution
from symkin.position.solution_list import make_solution
from timing import Figure, seconds

FAULTS = ("lost", "astray", "unnoticed", "false stop")
"""What can be wrong: an end that the enumeration lacks; an independent continuation that comes to
no end; one that comes to another mode; a stop at a configuration that is not singular.
"""
_SAME = 1e-6
"""Configurations nearer than this (over the size) are one."""
_FINE = (20, 1000)
"""Steps of the independent continuation between two samples; the second number where it leaves the
branch with the first.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--amplitude", type=float, default=20.0, help="of each joint, in its unit")
    parser.add_argument("--mechanism", default=FOLLOWED)
    o = parser.parse_args()
    print(
        f"{o.mechanism}: {o.count} paths, {o.samples} samples each, amplitude {o.amplitude:g}, "
        f"seed {o.seed}"
    )
    mechanism = symkin.load(o.mechanism)
    counts, times = run(mechanism, o.count, o.samples, o.amplitude, np.random.default_rng(o.seed))
    print(in_words(counts))
    print(
        f"CPU seconds a path for tracking alone, median {np.median(times):.3f}, mean "
        f"{np.mean(times):.3f}, longest {max(times):.2f}"
    )


def run(
    mechanism: symkin.Mechanism,
    count: int,
    samples: int,
    amplitude: float,
    rng: np.random.Generator,
) -> tuple[Counter[str], list[float]]:
    """Counts of what happened, and seconds for each path."""
    counts: Counter[str] = Counter(
        dict.fromkeys(("reached", "turning point", "certified", *FAULTS), 0)
    )
    times = []
    for k in range(1, count + 1):
        start = random_configuration(mechanism, rng)
        path = smooth_path(np.array(start.actuated_values), samples, amplitude, rng)
        begin = time.process_time()
        found = track(mechanism, joints=path, start=start, name_modes=False)
        times.append(time.process_time() - begin)
        counts["reached" if found.stop is None else found.stop.kind] += 1
        counts["certified"] += found.certified
        counts.update(faults(found, path))
        if k % 100 == 0:
            print(f"after {k}: {in_words(counts)}", flush=True)
    return counts, times


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:
    """A followed path, proved, over Newton's method at fixed steps, which proves nothing; and paths
    that are wrong.
    """
    mechanism, rng = symkin.load(FOLLOWED), np.random.default_rng(seed)
    ratios, wrong, count = [], 0, 8 if quick else 100
    for _ in range(count + 1):
        start = random_configuration(mechanism, rng)
        path = smooth_path(np.array(start.actuated_values), 16, 20.0, rng)
        found: list[Track] = []
        own = seconds(
            lambda start=start, path=path, found=found: found.append(
                track(mechanism, joints=path, start=start, name_modes=False)
            )
        )
        wrong += bool(faults(found[0], path))
        if found[0].stop is None:
            problem, begin = found[0].problem, found[0].samples[0].solution
            ratios.append(
                own
                / seconds(
                    lambda problem=problem, begin=begin, path=path: newton(
                        problem, begin, path, _FINE[0]
                    )
                )
            )
    # the first path compiles what all others use
    told = f"median of {len(ratios) - 1} paths"
    yield Figure(
        f"tracking: {FOLLOWED}, a path over Newton's at fixed steps",
        statistics.median(ratios[1:]),
        told,
    )
    yield Figure(
        "tracking: paths that are lost, astray, unnoticed or stopped for nothing",
        wrong,
        f"of {count + 1}",
    )


def in_words(counts: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.items())


def faults(found: Track, path: np.ndarray) -> list[str]:
    """What is wrong with a followed path, as FAULTS says; the end of a path that was stopped is its
    last sample before.
    """
    problem = found.problem
    place = None if found.stop is None else found.stop.place
    samples = [sample for sample in found.samples if sample is not place]
    wrong = []
    for sample in (samples[0], samples[-1]):
        solution = sample.solution
        every = symkin.modes(problem.mechanism, joints=solution.actuated_values)
        if min((apart(problem, solution, mode) for mode in every), default=math.inf) > _SAME:
            wrong.append("lost")
    end = fine(problem, samples[0].solution, path[: len(samples)])
    if end is None:
        wrong.append("astray")
    elif apart(problem, samples[-1].solution, end) > _SAME:
        wrong.append("unnoticed")
    if (
        place is not None
        and found.stop.kind != "unproved"
        and place.smallest_singular_value > _SAME
    ):
        wrong.append("false stop")
    return wrong


def random_configuration(mechanism: symkin.Mechanism, rng: np.random.Generator) -> Solution:
    """A regular configuration: the pose is random about the reference, and its lengths lie above
    zero.
    """
    while True:
        turn = rng.normal(size=3) * 0.3
        half = 0.5 * float(np.linalg.norm(turn))
        quaternion = [math.cos(half), *(math.sin(half) / (2 * half) * turn)]
        position = np.array([*rng.uniform(-100, 100, 2), rng.uniform(60, 200)])
        inverse = symkin.solve(mechanism, pose=[*position, *quaternion], check=False)
        if inverse.solution is None:
            continue
        pose = inverse.solution.pose
        direct = symkin.solve(
            mechanism, joints=inverse.solution.actuated_values, start=pose, check=False
        )
        if direct.solution is not None and direct.solution.condition < 1e3:
            return direct.solution


def smooth_path(
    start: np.ndarray, samples: int, amplitude: float, rng: np.random.Generator
) -> np.ndarray:
    """Rows of joint values along q(t) = q0 + sum a_k sin(k pi t) + b_k (1 - cos(k pi t)), k = 1, 2,
    all above zero.
    """
    t = np.linspace(0.0, 1.0, samples)[:, None]
    while True:
        path = np.tile(start, (samples, 1))
        for k in (1, 2):
            a, b = rng.normal(size=(2, len(start))) * amplitude / (2 * k)
            path = path + a * np.sin(k * math.pi * t) + b * (1 - np.cos(k * math.pi * t))
        if np.min(path) > 1.0:
            return path


def fine(problem: Problem, start: Solution, path: np.ndarray) -> Solution | None:
    """The end of an independent continuation, None where it leaves the branch."""
    return next(
        (end for steps in _FINE if (end := newton(problem, start, path, steps)) is not None), None
    )


def newton(problem: Problem, start: Solution, path: np.ndarray, steps: int) -> Solution | None:
    """The same with a number of steps between two samples."""
    system = problem.system
    z = np.concatenate([np.atleast_1d(start.values[c.name]) for c in system.unknowns])
    for a, b in pairwise(path):
        for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
            known = a + share * (b - a)
            before = z
            z = system.polish(z, known, steps=6)
            if (
                system.residual(z, known) > 1e-9 * system.characteristic_length
                or np.max(np.abs(z - before)) > 0.05 * system.characteristic_length
            ):
                return None
    return make_solution(problem, problem.join_values(z, path[-1]))


def apart(problem: Problem, a: Solution, b: Solution) -> float:
    """Largest difference of two configurations over the size; signs of quaternions do not count."""

    def unknowns(solution: Solution) -> np.ndarray:
        return np.concatenate(
            [np.atleast_1d(solution.values[c.name]) for c in problem.system.unknowns]
        )

    difference = features(problem.system, unknowns(a)[None]) - features(
        problem.system, unknowns(b)[None]
    )
    return float(np.max(np.abs(difference))) / problem.closure.characteristic_length


if __name__ == "__main__":
    main()
