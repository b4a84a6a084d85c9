"""A path of a serial arm's joints: the pose is a formula of them, so that there is nothing to follow."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symkin.following.follow import Branch, Place
from symkin.following.joint_limits import LimitWatch
from symkin.following.trajectory import Trajectory
from symkin.position.problem import Problem


def is_formula(problem: Problem, trajectory: Trajectory) -> bool:
    """Whether the unknowns are a position and a quaternion alone, as a function of the given joints."""
    kinds = [c.kind for c in problem.system.unknowns]
    if kinds != ["length", "length", "length", "quaternion"]:
        return False
    return problem.is_explicit and problem.forward(trajectory.samples[0]) is not None


def evaluate(
    problem: Problem,
    trajectory: Trajectory,
    unknown: np.ndarray,
    watch: LimitWatch,
    progress: Callable[[int, int], None] | None = None,
) -> Branch:
    """The poses at the samples, up to the first limit; the formula's quaternion is continuous, and has the start's sign."""
    sign = 1.0 if _unknown(problem, trajectory.samples[0], 1.0)[3:] @ unknown[3:] >= 0.0 else -1.0
    first = Place(0, 0.0, unknown, None)
    branch = Branch([first], first, (), formula=True)
    for row in range(len(trajectory) - 1):
        met = watch.given(row)
        u = 1.0 if met is None else met[0]
        branch.last = Place(row, u, _unknown(problem, trajectory.at(row, u), sign), None)
        branch.followed = trajectory.parameter(row, u)
        if met is not None:
            branch.ending, branch.limit = "limit", met[1]
            return branch
        branch.places.append(branch.last)
        if progress is not None:
            progress(row + 1, len(trajectory) - 1)
    return branch


def _unknown(problem: Problem, known: np.ndarray, sign: float) -> np.ndarray:
    pose = problem.forward(known)
    assert pose is not None  # noqa: S101 - `is_formula` has been asked
    return np.append(pose[:3], sign * pose[3:] / np.linalg.norm(pose[3:]))
