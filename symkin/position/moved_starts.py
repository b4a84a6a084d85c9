"""Starts moved off a singularity, where the Jacobian of the closure in the unknowns has less than
its generic rank.

With the singular values s_1 >= ... >= s_r at a start, r the generic rank, the start is singular
where s_r vanishes beside s_1: Newton's step divides by s_r, and least squares see no slope along
its direction. Moved starts are random directions from a fixed seed, at growing distances; of each
distance those are kept whose s_r is largest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.numeric.rank import count_above
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.solution import pose_of

SINGULAR_START = 1e-10
"""s_r / s_1 below this is rounding: no step is defined."""
NEARLY_SINGULAR_START = 1e-3
"""s_r / s_1 below this makes first steps a thousand times as long as the closure error: a start
that fails there is moved too.
"""
NEAR_CLOSING = 1e-2
"""A start whose closure error is below this times the size is meant as it is, singular or not."""
DISTANCES = (0.1, 0.2, 0.4)
"""Standard deviation of each unknown's move: rad, or times the size."""
DIRECTIONS, KEPT = 32, 3
"""Directions looked at for each distance, and those that are kept."""


@dataclass(frozen=True)
class StartRank:
    """Rank of the closure's Jacobian in the unknowns at a start, the generic one, and s_r / s_1."""

    value: int
    generic: int
    ratio: float

    @staticmethod
    def at(problem: Problem, z: np.ndarray, known: np.ndarray) -> StartRank:
        generic = problem.generic_rank
        _, jacobian = problem.system.linearise_one(problem.system.unit(z), known)
        if generic == 0 or not np.all(np.isfinite(jacobian)):
            return StartRank(generic, generic, 1.0)
        singular = np.linalg.svd(jacobian, compute_uv=False)
        largest = max(float(singular[0]), 1e-300)
        return StartRank(
            count_above(singular, SINGULAR_START, relative=True),
            generic,
            float(singular[generic - 1]) / largest,
        )

    @property
    def is_singular(self) -> bool:
        return self.ratio < SINGULAR_START

    @property
    def is_nearly_singular(self) -> bool:
        return self.ratio < NEARLY_SINGULAR_START

    def __str__(self) -> str:
        if self.is_singular:
            return f"singular (the closure's Jacobian has rank {self.value} of {self.generic})"
        return f"nearly singular (smallest singular value {self.ratio:.1e} of the largest)"


def is_singular(problem: Problem, z: np.ndarray, known: np.ndarray) -> bool:
    return StartRank.at(problem, z, known).is_singular


def nearly_closes(problem: Problem, z: np.ndarray, known: np.ndarray) -> bool:
    system = problem.system
    return system.residual(system.unit(z), known) <= NEAR_CLOSING * system.characteristic_length


def moved_starts(problem: Problem, start: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Starts (rows) about a singular one, nearest first, within `limits`; the same for the same
    start.
    """
    system, rng = problem.system, np.random.default_rng(0)
    rows = []
    for distance in DISTANCES:
        steps = (
            distance * system.characteristic_length * rng.normal(size=(DIRECTIONS, system.freedom))
        )
        points = _within_limits(
            problem, system.fold(system.move(np.tile(start, (DIRECTIONS, 1)), steps))
        )
        best = np.argsort(-_ratios(problem, points, known), kind="stable")[:KEPT]
        rows += [points[k] for k in best]
    return np.array(rows)


def _ratios(problem: Problem, points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """s_r / s_1 at each point, 0 where the Jacobian is not finite."""
    _, jacobians = problem.system.linearise(points, known)
    finite = np.all(np.isfinite(jacobians), axis=(1, 2))
    singular = np.linalg.svd(np.where(finite[:, None, None], jacobians, 0.0), compute_uv=False)
    return singular[:, problem.generic_rank - 1] / np.maximum(singular[:, 0], 1e-300)


def _within_limits(problem: Problem, points: np.ndarray) -> np.ndarray:
    for c, place in zip(problem.system.unknowns, problem.system.slices, strict=True):
        if c.limits is not None:
            points[:, place] = np.clip(points[:, place], *c.limits)
    return points


def moved_note(
    problem: Problem, given: Given, rank: StartRank, moved: np.ndarray, which: str
) -> str:
    """What was done, with the moved start as a user gives it: joints for an inverse problem, else a
    pose.
    """
    mechanism, values = problem.mechanism, problem.join_values(moved, given.values)
    if problem.of_pose:
        numbers = [float(values[problem.closure.slices[c.name]][0]) for c in mechanism.actuated]
        pairs = zip(mechanism.actuated, numbers, strict=True)
        shown = [mechanism.value_out(c, v) for c, v in pairs]
    else:
        pose = pose_of(problem.closure, values)
        shown = [float(v) for v in (*pose.position, *pose.quaternion)]
    text = ",".join(f"{v:.4g}" for v in shown)
    what = "joints" if problem.of_pose else "pose"
    return f"the {which} is {rank}: the iteration began at {what} {text} instead"
