"""What each way to L6 takes, over many poses: the printed loop, the chord in place of its midpoint, Newton's method, no loop.

Poses are those of random joint values: theta1 to theta5 within 60 degrees, L6 between -300 and 0. Every way is given the same
poses; an end counts as right where it is the L6 that the pose was made from, as another root where it is one, else as none.
Units: mm. Source: Yao Haifeng et al. 2020 (see `yao2020`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from guesses import Search, rootfinder
from yao2020_inverse import (
    STROKE,
    axis5_origin,
    distance_function,
    f_iteration,
    full_angle_of_planes,
    paper_search,
    plane_closure,
    secant_search,
    slides,
)
from yao2020_model import A2, pose_of

LARGEST_ANGLE, LONGEST = 60.0, -300.0
SAME = 1e-6
"""Difference of two values of L6, mm, below which they are one root."""
Way = Callable[[np.ndarray, np.ndarray], tuple[float, int]]


@dataclass(frozen=True, eq=False)
class Runs:
    """The ends of one way over the poses: which of right, other, none; the steps where it ended at a root; seconds a pose."""

    name: str
    ends: list[str]
    steps: list[int]
    seconds: float

    def evidence(self) -> dict[str, object]:
        return {"by": "study", "method": self.name, "poses": len(self.ends), "text": f"{self.name}, {len(self.ends)} poses"}

    @property
    def iterates(self) -> bool:
        return any(self.steps)

    @property
    def counts(self) -> list[int]:
        return [self.ends.count(kind) for kind in ("right", "other", "none")]

    @property
    def spread(self) -> list[int]:
        """Least, median and most steps."""
        return [min(self.steps), int(np.median(self.steps)), max(self.steps)]


def random_poses(seed: int, count: int) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """L6, A and R of each."""
    rng, poses = np.random.default_rng(seed), []
    for _ in range(count):
        joints = np.append(rng.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, 5), rng.uniform(LONGEST, 0.0))
        poses.append((float(joints[5]), *pose_of(joints)))
    return poses


def printed_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The loop in the order that finds the printed answer, with (6) as the text says it."""
    return paper_search(f_iteration(A, R), "right")


def mended_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The same with the angle of the planes between -180 and 180 degrees."""
    return paper_search(f_iteration(A, R, full_angle_of_planes), "right")


def chord_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The chord's zero in place of the midpoint, on the part of the interval right of e_x, where f rises."""
    f, low = f_iteration(A, R, full_angle_of_planes), max(STROKE[0], float(axis5_origin(A, R)[0]))
    return secant_search(f, low, STROKE[1]) if low < STROKE[1] and f(low) * f(STROKE[1]) < 0 else (math.nan, 0)


def newton_way() -> Way:
    """Newton's method by CasADi on (5) to (8) in L6 and theta5, from zero joints."""
    search: Search = rootfinder(plane_closure())

    def newton(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
        end = search.end(np.zeros(2), axis5_origin(A, R))
        return (float(end.X[0]), end.iterations) if end.closed else (math.nan, end.iterations)

    return newton


def without_loop(A: np.ndarray, R: np.ndarray) -> tuple[float, int]:
    """The closed form's largest root."""
    return max(slides(A, R)), 0


def run(name: str, way: Way, poses: list[tuple[float, np.ndarray, np.ndarray]]) -> Runs:
    """Take one way over the poses."""
    begin = time.perf_counter()
    found = [way(A, R) for _, A, R in poses]
    seconds = (time.perf_counter() - begin) / len(poses)
    ends = [_kind(slide, wanted, A, R) for (slide, _), (wanted, A, R) in zip(found, poses, strict=True)]
    return Runs(name, ends, [n for (_, n), end in zip(found, ends, strict=True) if end != "none"], seconds)


def _kind(slide: float, wanted: float, A: np.ndarray, R: np.ndarray) -> str:
    if abs(slide - wanted) < SAME:
        return "right"
    roots = [x for s in (1, -1) for x in slides(A, R, s)]
    return "other" if any(abs(slide - x) < SAME for x in roots) else "none"


def all_ways(seed: int, count: int) -> list[Runs]:
    """Every way over the same poses."""
    poses = random_poses(seed, count)
    ways = {"printed loop": printed_loop, "loop with the full angle": mended_loop, "chord": chord_loop,
            "rootfinder": newton_way(), "closed form": without_loop}  # fmt: skip
    return [run(name, way, poses) for name, way in ways.items()]


def minima(A: np.ndarray, R: np.ndarray) -> int:
    """How many minima |OF2| has along the retreat, counted on a fine grid about e_x."""
    f, e = distance_function(A, R), axis5_origin(A, R)
    values = np.array([f(e[0] + x) for x in np.arange(-400.0, 400.5, 0.5)])
    return int(np.sum((values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:])))


def minima_of_poses(seed: int, count: int) -> tuple[list[int], int]:
    """Poses whose |OF2| has one minimum and two, and those with |e_y| < a2."""
    poses = random_poses(seed, count)
    numbers = [minima(A, R) for _, A, R in poses]
    near = sum(bool(abs(axis5_origin(A, R)[1]) < A2) for _, A, R in poses)
    return [numbers.count(1), numbers.count(2)], near
