"""What all figures share: the reference kernel, runs timed in turn, and a figure beside its peer.

Times are those of the processor unless a name says otherwise, and only their ratios within one run
count: a busy machine slows both sides alike where they take turns.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Figure:
    """A measured figure: symkin over its peer, so that less is better; or a count of faults. None
    where the peer is not installed, which `text` then says."""

    name: str
    ratio: float | None
    text: str


class ReferenceKernel:
    """T: numpy.linalg.solve on 40 complex 8 x 8 systems."""

    def __init__(self) -> None:
        rng = np.random.default_rng(0)
        self.a = rng.normal(size=(40, 8, 8)) + 1j * rng.normal(size=(40, 8, 8))
        self.b = rng.normal(size=(40, 8, 1)) + 0j

    def __call__(self) -> None:
        np.linalg.solve(self.a, self.b)

    def seconds(self, repeats: int) -> float:
        """Median of `repeats` calls."""
        return statistics.median(seconds(self) for _ in range(repeats))


def seconds(run: Callable[[], object]) -> float:
    """Processor time of one run."""
    begin = time.process_time()
    run()
    return time.process_time() - begin


def in_turn(
    runs: Mapping[str, Callable[[], object]],
    repeats: int,
    clock: Callable[[Callable[[], object]], float] = seconds,
) -> dict[str, list[float]]:
    """Times of each run, taken in turn after one that prepares all."""
    for run in runs.values():
        run()
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            times[name].append(clock(run))
    return times


def median_ratio(own: Sequence[float], peer: Sequence[float]) -> float:
    """The median of ratios of times that were taken in turn."""
    return statistics.median(a / b for a, b in zip(own, peer, strict=True))


def verdict(good: bool) -> str:
    """What a line says of a figure and its limit."""
    return "ok" if good else "MISSED"
