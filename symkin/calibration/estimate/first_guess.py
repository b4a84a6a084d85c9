"""Guess measuring frames from solved configurations, before the least squares begin.

A laser tracker stands anywhere and sees a reflector that is mounted anywhere on the platform:
observed pose = world, platform pose, target one after the other. Frames have no nominal value near
which they could be sought. With the platform's poses known from the mechanism's own geometry, only
the frames are fitted: from many orientations of the world frame, the target's orientation from
those that were read.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.estimator import estimate
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.spatial.rotation import (
    conjugate,
    multiply,
    rotation_vector_from_quaternion,
)

_FRAME_CONFIGURATIONS = 40
"""Configurations that the start is found from, spread evenly: twelve numbers at most are wanted,
and only nearly.
"""
_TRIAL_STEPS, _FOLLOWED_TRIALS, _FINAL_STEPS = 4, 3, 40
"""Steps from each orientation, how many of what they lead to are followed, and the steps from
there.
"""


def fit_measuring_frames(
    problem: CalibrationProblem, z: np.ndarray, p: np.ndarray, solved: np.ndarray
) -> np.ndarray:
    """Fit the free measuring frames to the configurations z (n, width) that are solved (n,), all
    other parameters nominal.
    """
    free = np.flatnonzero([name in MEASURING_FRAMES for name in problem.names])
    if not len(free) or not solved.any():
        return p
    closed = np.flatnonzero(solved)
    rows = closed[spread_rows(len(closed), _FRAME_CONFIGURATIONS)]
    frames = [problem.names[k] for k in free]
    whole = build_calibration(problem.mechanism, problem.measurements, parameters=frames)
    few = whole.of(rows)

    def fitted(start: np.ndarray, steps: int) -> tuple[float, np.ndarray]:
        state = estimate(few, z[rows], p=start, max_iterations=steps).state
        return state.cost if np.isfinite(state.cost) else np.inf, state.p

    trials = [fitted(start, _TRIAL_STEPS) for start in _frame_starts(few, z[rows], p[free])]
    best = sorted(trials, key=lambda trial: trial[0])[:_FOLLOWED_TRIALS]
    ends = [fitted(near, _FINAL_STEPS) for _, near in best]
    found = p.copy()
    found[free] = min(ends, key=lambda end: end[0])[1]
    return found


def _frame_starts(
    problem: CalibrationProblem, z: np.ndarray, p: np.ndarray
) -> Iterator[np.ndarray]:
    """Yield p, and p with the world frame in the orientations of a cube where all of its rotation
    is free; the target's orientation is then the mean of those that were read, where all of it is
    free.
    """
    yield p
    places = {name: k for k, name in enumerate(problem.names)}
    world, target = (
        [places.get(f"{frame}.rotation.{k}", -1) for k in "xyz"] for frame in ("world", "target")
    )
    m, start = problem.measurements, p.copy()
    read = None if min(target) < 0 else m.orientation
    given = np.flatnonzero([] if read is None else np.isfinite(read[:, 0]))
    for turn in _cube_orientations() if min(world) >= 0 else (None,):
        if turn is not None:
            start[world] = rotation_vector_from_quaternion(turn)
        if read is not None and len(given):
            start[target] = 0.0
            seen = problem.model.poses(z[given], m.joints[given], start)[:, 3:].T
            turns = np.asarray(multiply(conjugate(seen), read[given].T))
            # the mean orientation is the eigenvector of the sum of q q^T (Markley and others 2007)
            mean = np.linalg.eigh(turns @ turns.T)[1][:, -1]
            start[target] = rotation_vector_from_quaternion(mean)
        yield start.copy()


def _cube_orientations() -> Iterator[np.ndarray]:
    """Quaternions of the 24 orientations of a cube."""
    for q in product((-1.0, 0.0, 1.0), repeat=4):
        if q.count(0.0) != 1 and q > tuple(-v for v in q):
            yield np.array(q) / np.linalg.norm(q)
