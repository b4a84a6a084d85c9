"""Measure how far a geometry went from the file's, by the poses of both.

How far a geometry went from the file's, its departure, is measured by poses. Parameters tell it
badly: frames are free, nearly parallel axes move by hundreds of metres, and a small change of one
parameter may matter more than a large one of another. What counts is the map from joint readings to
poses: the poses of both geometries at the joint readings measured, less what the best small motions
of constant frames of base and tool take of their difference,

    departure = rms |X_fit - X_file - frames| / rms |X_fit - mean|,

angles times the lever of the platform's joint points, over the better four fifths of the
configurations: near a singularity of either geometry poses are far apart for nothing. The frames
move the pose half way between the two, so that of a turn only about a twelfth of its cube is left.
A machine as it is built differs from its drawing by some per mille, and its poses by about that
share of their spread. With columns exchanged, a sign turned, or the file of another machine it is a
share that can be seen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    newton_configurations,
)
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State
from symkin.calibration.estimate.workspace import lever, moved_point, platform_points
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.spatial.rotation import (
    conjugate,
    matrix_from_quaternion,
    multiply,
    rotation_vector_from_quaternion,
)

_COMPARED_CONFIGURATIONS = 80
"""Configurations that are compared, spread evenly over those used."""


class Departure(NamedTuple):
    """`share` is the departure, `position` (length unit) and `angle` (radians) the root mean
    squares of its parts, `unclosed` the number of configurations, of `configurations`, that the
    file's geometry cannot take near the fitted pose; these count as one spread.
    """

    share: float
    position: float
    angle: float
    unclosed: int
    configurations: int


def measure_departure(problem: CalibrationProblem, state: State) -> Departure:
    """Measure the departure of a fit from the nominal geometry, over the configurations fitted."""
    nominal, rows = problem.model.nominal, spread_rows(len(state.z), _COMPARED_CONFIGURATIONS)
    joints, length = problem.joints[rows], lever(problem.mechanism)
    z, closed = newton_configurations(
        problem.model, state.z[rows], joints, nominal, tolerance=ROUGHLY_SOLVED_TOLERANCE
    )
    centre = np.mean(platform_points(problem.mechanism), axis=0)

    def middles(p: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Poses (n, 7) with the place of the middle of the platform's joint points."""
        poses = judged_poses(problem, p, points, joints)
        return np.hstack([moved_point(poses, centre), poses[:, 3:]])

    here, there = middles(state.p, state.z[rows]), middles(nominal, z)
    whole = np.isfinite(here).all(axis=1)
    unclosed, count = int(np.sum(whole & ~closed)), int(whole.sum())
    closed &= whole
    spread = _spread(here[whole], length) if whole.any() else 0.0
    if not closed.any() or not spread > 0.0:
        return Departure(0.0 if closed.any() else 1.0, 0.0, 0.0, unclosed, count)
    here, there = here[closed], there[closed]
    there[:, 3:] *= np.sign(np.sum(here[:, 3:] * there[:, 3:], axis=1, keepdims=True))
    between = 0.5 * (here + there)
    between[:, 3:] /= np.linalg.norm(between[:, 3:], axis=1, keepdims=True)
    off = less_frames(_difference(here, there)[:, :, None], between, length)[:, :, 0]
    parts = np.sum(off.reshape(-1, 2, 3) ** 2, axis=2)
    squares = np.append(parts @ [1.0, length**2], np.full(unclosed, spread**2))
    position, angle = map(float, np.sqrt(parts.mean(axis=0)))
    return Departure(rms_of_better_part(squares) / spread, position, angle, unclosed, count)


def judged_poses(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, joints: np.ndarray
) -> np.ndarray:
    """Return the poses (n, 7) of the platform, or of the link judged in its place, in the base
    frame; measuring frames among the parameters are left out.
    """
    measuring = [name.startswith(("world.", "target.")) for name in problem.names]
    return problem.model.poses(z, joints, np.where(measuring, 0.0, p))


def less_frames(values: np.ndarray, poses: np.ndarray, length: float) -> np.ndarray:
    """Take from changes of poses (n, 6, k), position and rotation vector in the turned axes, what
    the best small motions of constant base and tool frames remove at poses (n, 7): of W and T in W
    X T by (t, w) it is (t + w x position, R^T w) and (R t, w). Angles weigh `length`.
    """
    n, unit = len(poses), np.broadcast_to(np.eye(3), (len(poses), 3, 3))
    turn = matrix_from_quaternion(poses[:, 3:].T).transpose(2, 0, 1)
    across = np.cross(unit, poses[:, None, :3]).transpose(0, 2, 1)
    none = np.zeros((n, 3, 3))
    base = np.block([[unit, across / length], [none, turn.transpose(0, 2, 1)]])
    frames = np.concatenate([base, np.block([[turn, none], [none, unit]])], axis=2)
    frames = frames.reshape(-1, 12)
    weight = np.repeat([1.0, length], 3)[:, None]
    flat = (weight * values).reshape(6 * n, -1)
    left, singular, _ = np.linalg.svd(frames, full_matrices=False)
    left = left[:, singular > 1e-9 * singular[0]]
    return (flat - left @ (left.T @ flat)).reshape(values.shape) / weight


def most_central(turns: np.ndarray) -> int:
    """Find, of unit quaternions (n, 4), that with the largest sum of squared cosines to all."""
    return int(np.argmax(np.sum((turns @ (turns.T @ turns)) * turns, axis=1)))


def _difference(poses: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Poses (n, 7) less others (n, 6): positions, and rotation vectors in the turned axes."""
    turn = multiply(conjugate(others[:, 3:].T), poses[:, 3:].T)
    turned = rotation_vector_from_quaternion(turn).T
    return np.hstack([poses[:, :3] - others[:, :3], turned])


def _spread(poses: np.ndarray, length: float) -> float:
    """Root mean square distance from the middle, orientations from the one nearest to all."""
    middle = np.append(poses[:, :3].mean(axis=0), poses[most_central(poses[:, 3:]), 3:])
    away = _difference(poses, np.tile(middle, (len(poses), 1)))
    return float(np.sqrt(np.mean(np.sum((away * np.repeat([1.0, length], 3)) ** 2, axis=1))))
