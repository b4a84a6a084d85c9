"""A sweep beside the same enumeration in one process: time per point and core, and memory; then
what a point of a grid takes.

    python benchmarks/sweep.py [--points 10000] [--workers 2] [--seed 0] [--chunk 500]
        [--directory DIR] [--grids 1.0] [--named 10000]

Random leg lengths of `zhang2009` (+-40 mm about its example), all modes. The reference enumerates
some of the same chunks in this process and stores nothing, half of them before the sweep and half
after it, so that a busy machine slows both. "wall": time that passed, times the workers, over the
points, start-up of processes and writing included; "cpu": processor time of all processes, which a
busy machine changes less. `symkin.modes`, with certificates, is timed on a few points. 100,000
points on two processors must take at most 1.3 times the reference's, and all processes together 1
GB.

Grids over two joints of a five-bar, a planar 3-RRR and two hexapods (28 and 40 paths), in this
process, storing included: time a point in T, `numpy.linalg.solve` on 40 complex 8 x 8 systems,
measured before and after each; `--grids` scales their sizes, 0 leaves them out. On a busy machine
the processor's time in T says more.

Graphs of links by coordinates told by name (`--named` points each, 0: none): a four-bar by its
crank and by its follower, a Jansen leg, an ankle both ways, a five-link suspension; the processor's
time a point and a mode, storing included, in T too, the peak of memory, and how many of some points
have other counts of modes than `symkin.modes` finds (none is allowed).
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import symkin
from cases import FOLLOWED, NAMED, Grid, grids
from symkin.sweeps.plan import Plan, make_plan
from symkin.sweeps.run import sweep
from symkin.sweeps.space import make_space
from timing import Figure, ReferenceKernel, verdict

LIMIT, MEMORY_MB = 1.3, 1024.0
"""Most that a point may cost, of the reference, and most memory of all processes."""
ABOUT_MM = 40.0
REFERENCE_POINTS, MODES_POINTS = 10_000, 50
"""Points of the reference and of `symkin.modes`."""
QUICK_POINTS, QUICK_GRIDS = 1_000, 0.1
"""Points of a quick sweep, and the share of the sizes of grids."""


def main() -> None:
    options = arguments()
    if options.points:
        time_sample(options)
    for grid in grids(options.grids) if options.grids else []:
        time_grid(grid)
    for name, ranges in NAMED if options.named else []:
        time_named(name, ranges, options.named)


def time_sample(options: argparse.Namespace) -> float:
    """Sweep random points and return what one costs, over the reference (processor time)."""
    mechanism = symkin.load(FOLLOWED)
    ranges = {
        c.name: (v - ABOUT_MM, v + ABOUT_MM)
        for c, v in zip(mechanism.actuated, mechanism.example.joints, strict=True)
    }
    space = make_space(mechanism, ranges, sample=options.points, seed=options.seed)
    plan = make_plan(space, chunk=options.chunk)
    print(
        f"{FOLLOWED}, direct problem, {options.points} random points in {len(plan.blocks)} chunks, "
        f"{options.workers} workers"
    )
    some = np.unique(
        np.linspace(0, len(plan.blocks) - 1, min(len(plan.blocks), REFERENCE_POINTS // plan.chunk))
        .round()
        .astype(int)
    )
    before = Reference(plan, [int(i) for i in some[::2]])
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(options.directory or temporary) / "sweep"
        wall, cpu = time.perf_counter(), processor_seconds()
        swept = sweep(
            mechanism,
            ranges,
            folder,
            random=options.points,
            seed=options.seed,
            chunk=options.chunk,
            workers=options.workers,
        )
        wall, cpu = time.perf_counter() - wall, processor_seconds() - cpu
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    after = Reference(plan, [int(i) for i in some[1::2]])
    points = before.points + after.points
    reference, reference_cpu = (
        (before.wall + after.wall) / points,
        (before.cpu + after.cpu) / points,
    )
    print(swept)
    print(
        f"in one process  {1e3 * reference:8.3f} ms a point (cpu {1e3 * reference_cpu:.3f}), "
        f"{points} points"
    )
    print(f"symkin.modes    {1e3 * modes_seconds(plan):8.3f} ms a point, certificates included")
    each, each_cpu = wall * options.workers / options.points, cpu / options.points
    print(
        f"sweep           {1e3 * each:8.3f} ms a point and core (cpu {1e3 * each_cpu:.3f}), "
        f"{wall:.1f} s in all, {size / 1e6:.1f} MB"
    )
    ratios = each / reference, each_cpu / reference_cpu
    print(
        f"ratio           {ratios[0]:8.2f} of wall time, {ratios[1]:.2f} of cpu; allowed {LIMIT}: "
        f"{verdict(ratios[0] <= LIMIT)}"
    )
    load, cores = os.getloadavg()[0], os.cpu_count()
    print(
        f"                the machine's load was {load:.1f} on {cores} processors; above "
        f"{options.workers} or so wall times mislead"
    )
    driver, worker = (
        resource.getrusage(who).ru_maxrss / KILO
        for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    total = driver + options.workers * worker
    print(
        f"memory          {total:8.0f} MB: this process {driver:.0f}, workers {options.workers} x "
        f"{worker:.0f} (largest); "
        f"allowed {MEMORY_MB:.0f}: {verdict(total <= MEMORY_MB)}"
    )
    return float(ratios[1])


def time_grid(grid: Grid) -> float:
    """Sweep a grid once, after a small one that prepares all; what a point takes, in T."""
    mechanism, kernel = grid.mechanism, ReferenceKernel()
    at = [
        mechanism.angle_out(c.reference[0]) if c.is_angular else c.reference[0]
        for c in mechanism.actuated
    ]
    if all(isinstance(limb, symkin.RodLimb) for limb in mechanism.limbs):
        raised = symkin.Pose(
            np.array([0.0, 0.0, mechanism.characteristic_length]),
            np.array([1.0, 0.05, 0.08, 0.1]) / np.linalg.norm([1.0, 0.05, 0.08, 0.1]),
        )
        at = list(symkin.solve(mechanism, pose=raised).solution.actuated)
    ends = [
        (c.name, v - grid.half_range, v + grid.half_range)
        for c, v in zip(mechanism.actuated[:2], at[:2], strict=True)
    ]
    rest = at if len(mechanism.actuated) > len(ends) else None
    with tempfile.TemporaryDirectory() as folder:
        sweep(
            mechanism,
            {name: np.linspace(low, high, 3) for name, low, high in ends},
            Path(folder) / "first",
            at=rest,
            workers=0,
        )
        before, wall, cpu = kernel.seconds(100), time.perf_counter(), time.process_time()
        values = {name: np.linspace(low, high, grid.values) for name, low, high in ends}
        found = sweep(mechanism, values, Path(folder) / "s", at=rest, workers=0)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    unit = 0.5 * (before + kernel.seconds(100)) * found.points
    print(
        f"{mechanism.name:16}{found.points:7d} points in {found.chunks} chunks: "
        f"{1e6 * wall / found.points:8.1f} us a point, "
        f"{wall / unit:6.2f} T (cpu {cpu / unit:.2f} T); allowed {grid.most_t} T: "
        f"{verdict(cpu / unit <= grid.most_t)}"
    )
    return float(cpu / unit)


def time_named(name: str, ranges: dict[str, tuple[float, float]], points: int) -> tuple[float, int]:
    """Sweep coordinates told by name once, after a small sweep that prepares all; what a point
    takes, in T, and how many points have other counts than `symkin.modes` finds.
    """
    mechanism, kernel = symkin.load(name), ReferenceKernel()
    count = round(points ** (1.0 / len(ranges)))
    given = {
        coordinate: np.linspace(low, high, count, endpoint=False)
        for coordinate, (low, high) in ranges.items()
    }
    with tempfile.TemporaryDirectory() as folder:
        sweep(
            mechanism,
            directory=Path(folder) / "first",
            given={n: v[:2] for n, v in given.items()},
            workers=0,
        )
        before, cpu = kernel.seconds(100), time.process_time()
        found = sweep(mechanism, directory=Path(folder) / "s", given=given, workers=0)
        cpu = time.process_time() - cpu
        counts = found.open()["count"].values
    unit = 0.5 * (before + kernel.seconds(100)) * found.points
    places = np.random.default_rng(0).integers(0, counts.shape, (MODES_POINTS, counts.ndim))
    rows = [
        {n: float(v[k]) for (n, v), k in zip(given.items(), place, strict=True)} for place in places
    ]
    other = sum(
        len(symkin.modes(mechanism, given=row)) != counts[tuple(place)]
        for row, place in zip(rows, places, strict=True)
    )
    modes = sum(number * many for number, many in found.points_by_count.items())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KILO
    print(
        f"{name} by {', '.join(given)}: {found.points} points, {modes} modes: "
        f"{1e6 * cpu / found.points:.0f} us a point, "
        f"{1e6 * cpu / modes:.1f} us a mode (cpu), {cpu / unit:.2f} T a point; peak {peak:.0f} MB; "
        f"other counts than symkin.modes: {other} of {MODES_POINTS}: {verdict(not other)}"
    )
    return float(cpu / unit), int(other)


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:
    """A point of a random sweep over the same enumeration in one process; points of grids and of
    graphs in T; miscounts.
    """
    points = QUICK_POINTS if quick else REFERENCE_POINTS
    options = arguments(
        ["--points", str(points), "--workers", "1", "--seed", str(seed), "--chunk", "250"]
    )
    yield Figure(
        f"sweep: {FOLLOWED}, a point over the enumeration alone",
        time_sample(options),
        "processor time",
    )
    for grid in grids(QUICK_GRIDS if quick else 1.0):
        yield Figure(f"sweep: {grid.mechanism.name}, a point of a grid", time_grid(grid), "T")
    miscounted = 0
    for name, ranges in NAMED[::3] if quick else NAMED:
        ratio, other = time_named(name, ranges, QUICK_POINTS if quick else REFERENCE_POINTS)
        miscounted += other
        yield Figure(f"sweep: {name} by {', '.join(ranges)}, a point", ratio, "T")
    yield Figure("sweep: points with other counts than modes", miscounted, "of graphs by name")


KILO = 1024.0 * (1024.0 if sys.platform == "darwin" else 1.0)
"""What `ru_maxrss` counts in, of a megabyte."""


def arguments(words: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--chunk", type=int, default=500)
    parser.add_argument(
        "--grids", type=float, default=1.0, help="size of the grids; 0 leaves them out"
    )
    parser.add_argument(
        "--named", type=int, default=10_000, help="points of each graph by name; 0 leaves them out"
    )
    parser.add_argument("--directory", help="where the folder is left; default: a temporary one")
    return parser.parse_args(words)


class Reference:
    """Seconds of the same enumeration of some chunks, in this process."""

    def __init__(self, plan: Plan, chunks: list[int]) -> None:
        finder = plan.finder()
        plan.compute(finder, 0)
        wall, cpu = time.perf_counter(), time.process_time()
        for index in chunks:
            plan.compute(finder, index)
        self.wall, self.cpu = time.perf_counter() - wall, time.process_time() - cpu
        self.points = sum(
            plan.blocks[index][0].stop - plan.blocks[index][0].start for index in chunks
        )


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


if __name__ == "__main__":
    main()
