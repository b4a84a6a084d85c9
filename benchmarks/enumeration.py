"""All modes by continuation, beside a reference kernel in the same process.

    python benchmarks/enumeration.py [--inputs 40] [--seed 0]

T is the median time of `numpy.linalg.solve` on a batch of 40 complex 8 x 8 systems. For each case: time of the first
answer of a never-seen mechanism (an empty cache), then the median over random inputs with the start kept, in ms and T,
and how many inputs had an unresolved path. Run with OMP_NUM_THREADS=1 for one thread.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from dataclasses import replace

import numpy as np

import symkin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    kernel = reference_kernel()
    print(f"T = {1e6 * kernel:.1f} us, {options.inputs} inputs, seed {options.seed}")
    print("case                    first s   median ms        T   complex   unresolved inputs")
    rng = np.random.default_rng(options.seed)
    for name, mechanism, kind in cases(rng):
        with tempfile.TemporaryDirectory() as folder:
            os.environ["SYMKIN_CACHE"] = folder
            run(name, mechanism, kind, options.inputs, rng, kernel)


def reference_kernel() -> float:
    rng = np.random.default_rng(0)
    a = rng.normal(size=(40, 8, 8)) + 1j * rng.normal(size=(40, 8, 8))
    b = rng.normal(size=(40, 8, 1)) + 0j
    times = []
    for _ in range(300):
        begin = time.perf_counter()
        np.linalg.solve(a, b)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def cases(rng: np.random.Generator) -> list[tuple[str, symkin.Mechanism, str]]:
    rods = [symkin.RodLimb(f"leg{i}", rng.normal(size=3), 0.6 * rng.normal(size=3)) for i in range(6)]
    general = symkin.Mechanism("general66", rods, platform_position=(0, 0, 1.5))
    axes = [symkin.Joint(f"q{i}", "R", rng.normal(size=3), rng.normal(size=3), actuated=True) for i in range(6)]
    general_6r = symkin.Mechanism("general_6r", [symkin.Limb("arm", axes)], platform_position=rng.normal(size=3), serial=True)
    shipped = [(name, symkin.load(name), "direct") for name in ("zhang2009", "ren2008_true", "zhao2000", "zhao2000_links")]
    arms = [("yao2020", symkin.load("yao2020"), "inverse"), ("gluon_6l3", symkin.load("gluon_6l3"), "inverse")]
    return [("general 6-6", general, "direct"), *shipped, *arms, ("general 6R", general_6r, "inverse")]


def run(name: str, mechanism: symkin.Mechanism, kind: str, inputs: int, rng: np.random.Generator, kernel: float) -> None:
    renamed = replace(mechanism, title="benchmark")
    times, unresolved, count = [], 0, 0
    for _ in range(inputs + 1):
        found = symkin.modes(renamed, **random_input(mechanism, kind, rng))
        times.append(found.elapsed_s)
        unresolved += bool(found.unresolved_paths)
        count = max(count, found.complex_count or 0)
    median = statistics.median(times[1:])
    print(f"{name:22} {times[0]:8.2f}   {1e3 * median:9.1f}   {median / kernel:6.0f}   {count:7d}   {unresolved} of {inputs + 1}")


def random_input(mechanism: symkin.Mechanism, kind: str, rng: np.random.Generator) -> dict[str, object]:
    """Joint values about the reference, or the pose of random joint values."""
    if kind == "inverse":
        joints = [
            mechanism.angle_out(rng.uniform(-3, 3)) if c.is_angular else rng.uniform(-0.3, 0.3) * mechanism.size
            for c in mechanism.actuated
        ]
        return {"pose": symkin.modes(mechanism, joints=joints)[0].pose}
    return {
        "joints": [
            mechanism.angle_out(c.reference[0] + rng.uniform(-0.15, 0.15))
            if c.is_angular
            else c.reference[0] * rng.uniform(0.9, 1.1)
            for c in mechanism.actuated
        ]
    }


if __name__ == "__main__":
    main()
