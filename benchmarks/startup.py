"""Cold processes: importing symkin and first answers, beside the libraries alone; processor seconds
of fresh interpreters and of what they start.

python benchmarks/startup.py [--repeats 9]
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterator

from timing import Figure, in_turn, median_ratio

PEER = "libraries alone"
COMMANDS = {
    "python -c pass": ["-c", "pass"],
    PEER: ["-c", "import casadi, numpy"],
    "import symkin": ["-c", "import symkin"],
    "symkin list": ["-m", "symkin", "list"],
    "symkin modes zhao2000": ["-m", "symkin", "modes", "zhao2000"],
    "symkin modes zhang2009": ["-m", "symkin", "modes", "zhang2009"],
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--repeats", type=int, default=9)
    for name, times in measured(parser.parse_args().repeats).items():
        print(
            f"{name:24} median {statistics.median(times):.3f} s   min {min(times):.3f}   max "
            f"{max(times):.3f}"
        )


def measured(repeats: int) -> dict[str, list[float]]:
    """Processor seconds of each command, in turn."""
    return in_turn(
        {name: lambda words=words: run(words) for name, words in COMMANDS.items()},
        repeats,
        seconds_of_children,
    )


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:  # noqa: ARG001 - nothing is drawn
    """Commands over a process that imports CasADi and NumPy alone."""
    times = measured(3 if quick else 9)
    for name in list(COMMANDS)[2:]:
        ratio = median_ratio(times[name], times[PEER])
        yield Figure(
            f"startup: {name}, over the libraries alone",
            ratio,
            f"{statistics.median(times[name]):.2f} s",
        )


def seconds_of_children(run: Callable[[], object]) -> float:
    """Processor time of the processes that a run starts and ends."""
    before = os.times()
    run()
    after = os.times()
    return (
        after.children_user + after.children_system - before.children_user - before.children_system
    )


def run(arguments: list[str]) -> None:
    """Run a fresh interpreter to its end."""
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
