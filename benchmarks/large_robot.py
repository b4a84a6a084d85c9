"""How long a robot of 60 joints and 6 loops takes to be read, closed and shown, in each format of
others; 3 s are allowed.

    python benchmarks/large_robot.py [--limbs 6] [--open 0.2]

`--open` tells joints from other zeros, up to that many radians away, at which the loops are open
(MJCF, URDF). Seconds of the processor in this process (imports done); of whole commands those of
the processor, by which they are judged, and of the clock.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

import symkin
from helpers.made_robots import humanoid, opened
from helpers.robot_texts import write
from symkin.formats.load import read_robot
from symkin.position.describe import describe

ALLOWED_S = 3.0


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """`--open` tells joints from other zeros, up to that many radians away, at which the loops are
    open (MJCF, URDF). Seconds of the processor and of the clock.
    """
    processor, clock = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - processor, time.perf_counter() - clock


def commands(path: Path) -> dict[str, tuple[float, float]]:
    """Seconds of the processor and of the clock of each command, as a process of its own."""
    found = {}
    for verb in ("close", "show"):
        clock, before = time.perf_counter(), os.times()
        subprocess.run(
            [sys.executable, "-m", "symkin", verb, str(path)], check=True, stdout=subprocess.DEVNULL
        )
        after = os.times()
        processor = (
            after.children_user
            + after.children_system
            - before.children_user
            - before.children_system
        )
        found[verb] = processor, time.perf_counter() - clock
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--limbs", type=int, default=6)
    parser.add_argument("--open", type=float, default=0.0)
    options = parser.parse_args()
    machine = opened(humanoid(options.limbs), options.open)
    slowest = 0.0
    print(f"{len(machine.parts)} joints, {len(machine.pins)} loops, mobility {machine.mobility}")
    print(
        f"{'format':8s} {'read':>7s} {'closed':>8s} {'loaded':>8s} {'shown':>8s}   s of the "
        f"processor; commands (of the clock)"
    )
    with tempfile.TemporaryDirectory() as folder:
        for suffix in ("xml", "urdf", "sdf"):
            path = write(machine, suffix, Path(folder))
            timed(lambda path=path: read_robot(path))  # imports
            steps = [
                timed(lambda path=path: read_robot(path))[0],
                timed(lambda path=path: symkin.close(path))[0],
                timed(lambda path=path: symkin.load(path))[0],
                timed(lambda path=path: describe(symkin.load(path)))[0],
            ]
            found = symkin.close(path)
            assert found.closed
            assert found.mobility == machine.mobility
            assert symkin.mobility(symkin.load(path)).mobility == machine.mobility
            whole = commands(path)
            slowest = max(slowest, *(processor for processor, _ in whole.values()))
            times = " ".join(f"{seconds:8.2f}" for seconds in steps)
            print(
                f"{suffix:7s}{times}   "
                + ", ".join(
                    f"{verb} {cpu:.2f} ({clock:.2f})" for verb, (cpu, clock) in whole.items()
                ),
                flush=True,
            )
    print(f"slowest command: {slowest:.2f} s (allowed: {ALLOWED_S:g})")
    return 0 if slowest <= ALLOWED_S else 1


if __name__ == "__main__":
    sys.exit(main())
