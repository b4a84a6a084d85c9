"""A sweep beside the same enumeration in one process: time per point and core, and memory.

    python benchmarks/sweep.py [--points 10000] [--workers 2] [--seed 0] [--chunk 500] [--directory DIR]

Random leg lengths of `zhang2009` (+-40 mm about its example), all modes. The reference enumerates some of the same chunks in
this process and stores nothing, half of them before the sweep and half after it, so that a busy machine slows both. "wall":
time that passed, times the workers, over the points, start-up of processes and writing included; "cpu": processor time of
all processes, which a busy machine changes less. `symkin.modes`, with certificates, is timed on a few points. 100,000
points on two processors must take at most 1.3 times the reference's, and all processes together 1 GB.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import symkin
from symkin.sweeps.plan import Plan, make_plan
from symkin.sweeps.run import sweep
from symkin.sweeps.space import make_space

LIMIT, MEMORY_MB = 1.3, 1024.0
"""Most that a point may cost, of the reference, and most memory of all processes."""
ABOUT_MM = 40.0
REFERENCE_POINTS, MODES_POINTS = 10_000, 50
"""Points of the reference and of `symkin.modes`."""


def main() -> None:
    options = arguments()
    mechanism = symkin.load("zhang2009")
    ranges = {c.name: (v - ABOUT_MM, v + ABOUT_MM) for c, v in zip(mechanism.actuated, mechanism.example.joints, strict=True)}
    space = make_space(mechanism, ranges, sample=options.points, seed=options.seed)
    plan = make_plan(space, chunk=options.chunk)
    print(f"zhang2009, direct problem, {options.points} random points in {len(plan.blocks)} chunks, {options.workers} workers")
    some = np.unique(
        np.linspace(0, len(plan.blocks) - 1, min(len(plan.blocks), REFERENCE_POINTS // plan.chunk)).round().astype(int)
    )
    before = Reference(plan, [int(i) for i in some[::2]])
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(options.directory or temporary) / "sweep"
        wall, cpu = time.perf_counter(), processor_seconds()
        swept = sweep(
            mechanism, ranges, folder, random=options.points, seed=options.seed, chunk=options.chunk, workers=options.workers
        )
        wall, cpu = time.perf_counter() - wall, processor_seconds() - cpu
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    after = Reference(plan, [int(i) for i in some[1::2]])
    points = before.points + after.points
    reference, reference_cpu = (before.wall + after.wall) / points, (before.cpu + after.cpu) / points
    print(swept)
    print(f"in one process  {1e3 * reference:8.3f} ms a point (cpu {1e3 * reference_cpu:.3f}), {points} points")
    print(f"symkin.modes    {1e3 * modes_seconds(plan):8.3f} ms a point, certificates included")
    each, each_cpu = wall * options.workers / options.points, cpu / options.points
    print(
        f"sweep           {1e3 * each:8.3f} ms a point and core (cpu {1e3 * each_cpu:.3f}), {wall:.1f} s in all, {size / 1e6:.1f} MB"
    )
    ratios = each / reference, each_cpu / reference_cpu
    print(
        f"ratio           {ratios[0]:8.2f} of wall time, {ratios[1]:.2f} of cpu; allowed {LIMIT}: {verdict(ratios[0] <= LIMIT)}"
    )
    load, cores = os.getloadavg()[0], os.cpu_count()
    print(
        f"                the machine's load was {load:.1f} on {cores} processors; above {options.workers} or so wall times mislead"
    )
    driver, worker = (resource.getrusage(who).ru_maxrss / KILO for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    total = driver + options.workers * worker
    print(
        f"memory          {total:8.0f} MB: this process {driver:.0f}, workers {options.workers} x {worker:.0f} (largest); "
        f"allowed {MEMORY_MB:.0f}: {verdict(total <= MEMORY_MB)}"
    )


KILO = 1024.0 * (1024.0 if sys.platform == "darwin" else 1.0)
"""What `ru_maxrss` counts in, of a megabyte."""


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--chunk", type=int, default=500)
    parser.add_argument("--directory", help="where the folder is left; default: a temporary one")
    return parser.parse_args()


class Reference:
    """Seconds of the same enumeration of some chunks, in this process."""

    def __init__(self, plan: Plan, chunks: list[int]) -> None:
        finder = plan.finder()
        plan.compute(finder, 0)
        wall, cpu = time.perf_counter(), time.process_time()
        for index in chunks:
            plan.compute(finder, index)
        self.wall, self.cpu = time.perf_counter() - wall, time.process_time() - cpu
        self.points = sum(plan.blocks[index][0].stop - plan.blocks[index][0].start for index in chunks)


def modes_seconds(plan: Plan) -> float:
    points = plan.space.points((slice(0, min(MODES_POINTS, plan.space.size)),))
    begin = time.perf_counter()
    for point in points:
        symkin.modes(plan.mechanism, **plan.space.given(point))
    return (time.perf_counter() - begin) / len(points)


def processor_seconds() -> float:
    """Of this process and of those that it has ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


def verdict(good: bool) -> str:
    return "ok" if good else "MISSED"


if __name__ == "__main__":
    main()
