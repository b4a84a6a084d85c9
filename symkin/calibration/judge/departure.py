"""Measure how far a geometry went from the file's, by the poses of both.

How far a geometry went from the file's, its departure, is measured by poses. Parameters tell it
badly: frames are free, nearly parallel axes move by hundreds of metres, and a small change of one
parameter may matter more than a large one of another. What counts is the map from joint readings to
poses: the poses of both geometries at the joint readings measured, after the best constant frames W
and T of base and tool,

    departure = rms |X_fit - W X_file T| / rms |X_fit - mean|,

angles times the lever of the platform's joint points, over the better four fifths of the
configurations: near a singularity of either geometry poses are far apart for nothing. A machine as
it is built differs from its drawing by some per mille, and its poses by about that share of their
spread. With columns exchanged, a sign turned, or the file of another machine it is a share that can
be seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    newton_configurations,
)
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State
from symkin.calibration.estimate.workspace import lever, platform_points
from symkin.calibration.judge.statistics import rms_of_better_part
from symkin.spatial.rotation import (
    conjugate,
    multiply,
    quaternion_from_matrix,
    quaternion_from_rotation_vector,
    rotate,
    rotation_vector_from_quaternion,
)

_COMPARED_CONFIGURATIONS = 80
"""Configurations that are compared, spread evenly over those used."""
_MAX_ALIGNMENT_STEPS = 30
"""Most Gauss-Newton steps of the frames."""


@dataclass(frozen=True)
class Departure:
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
    model = problem.model
    rows = spread_rows(len(state.z), _COMPARED_CONFIGURATIONS)
    joints = problem.measurements.joints
    fitted = judged_poses(problem, state.p, state.z[rows], joints[rows])
    whole = np.all(np.isfinite(fitted), axis=1)
    rows, fitted = rows[whole], fitted[whole]
    if not len(rows):
        return Departure(share=1.0, position=0.0, angle=0.0, unclosed=0, configurations=0)
    joints = joints[rows]
    with np.errstate(all="ignore"):
        z, closed = newton_configurations(
            model, state.z[rows], joints, model.nominal, tolerance=ROUGHLY_SOLVED_TOLERANCE
        )
    length, centre = lever(problem.mechanism), np.mean(platform_points(problem.mechanism), axis=0)
    here = _PoseSet.at(fitted, centre, length)
    spread = here.spread
    if not np.any(closed) or not spread > 0.0:
        return Departure(
            share=0.0 if np.any(closed) else 1.0,
            position=0.0,
            angle=0.0,
            unclosed=int(np.sum(~closed)),
            configurations=len(rows),
        )
    there = _PoseSet.at(
        judged_poses(problem, model.nominal, z[closed], joints[closed]), centre, length
    )
    off = _aligned_difference(here.take(closed), there)
    squares = np.concatenate([np.sum(off**2, axis=1), np.full(int(np.sum(~closed)), spread**2)])
    return Departure(
        share=rms_of_better_part(squares) / spread,
        position=float(np.sqrt(np.mean(np.sum(off[:, :3] ** 2, axis=1)))),
        angle=float(np.sqrt(np.mean(np.sum(off[:, 3:] ** 2, axis=1)))) / length,
        unclosed=int(np.sum(~closed)),
        configurations=len(rows),
    )


def judged_poses(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, joints: np.ndarray
) -> np.ndarray:
    """Return the poses (n, 7) of the platform, or of the link judged in its place, in the base
    frame; measuring frames among the parameters are left out.
    """
    measuring = np.array(
        [name.startswith(("world.", "target.")) for name in problem.names], dtype=bool
    )
    return problem.model.poses(z, joints, np.where(measuring, 0.0, p))


@dataclass(frozen=True, eq=False)
class _PoseSet:
    """Places (3, n) of the middle of the platform's joint points and orientations (4, n), with the
    length that angles count.
    """

    places: np.ndarray
    turns: np.ndarray
    length: float

    @staticmethod
    def at(poses: np.ndarray, centre: np.ndarray, length: float) -> _PoseSet:
        turns = poses[:, 3:].T
        return _PoseSet(
            poses[:, :3].T + np.asarray(rotate(turns, np.tile(centre[:, None], len(poses)))),
            turns,
            length,
        )

    def take(self, index: np.ndarray) -> _PoseSet:
        return _PoseSet(self.places[:, index], self.turns[:, index], self.length)

    def framed(self, step: np.ndarray) -> _PoseSet:
        """W X T for a step (12): translations (length unit) and rotation vectors (times the length)
        of W, then of T; W turns about the middle of the places.
        """
        world, tool = (
            _repeated_quaternion(step[k : k + 3] / self.length, self.places.shape[1])
            for k in (3, 9)
        )
        middle = np.mean(self.places, axis=1, keepdims=True)
        moved = self.places + np.asarray(
            rotate(self.turns, np.tile(step[6:9, None], self.places.shape[1]))
        )
        places = middle + np.asarray(rotate(world, moved - middle)) + step[:3, None]
        return _PoseSet(
            places, np.asarray(multiply(multiply(world, self.turns), tool)), self.length
        )

    def off(self, other: _PoseSet) -> np.ndarray:
        """These poses less others (n, 6), angles times the length."""
        turn = np.asarray(multiply(conjugate(other.turns), self.turns))
        return np.vstack(
            [
                self.places - other.places,
                self.length * np.asarray(rotation_vector_from_quaternion(turn)),
            ]
        ).T

    @property
    def spread(self) -> float:
        """Root mean square distance from the middle, orientations from the one nearest to all."""
        central = self.turns[:, int(np.argmax(np.sum((self.turns.T @ self.turns) ** 2, axis=1)))]
        middle = _PoseSet(
            np.tile(np.mean(self.places, axis=1, keepdims=True), self.places.shape[1]),
            np.tile(central[:, None], self.places.shape[1]),
            self.length,
        )
        return float(np.sqrt(np.mean(np.sum(self.off(middle) ** 2, axis=1))))


def _repeated_quaternion(vector: np.ndarray, count: int) -> np.ndarray:
    return np.tile(np.asarray(quaternion_from_rotation_vector(vector)).reshape(4, 1), count)


def _aligned_difference(here: _PoseSet, there: _PoseSet) -> np.ndarray:
    """Return here less W there T (n, 6) with the best constant frames."""
    best, cost = here.off(there), np.inf
    for begun in (there, there.framed(_frames_by_kabsch(here, there))):
        off = here.off(begun)
        for _ in range(_MAX_ALIGNMENT_STEPS):
            slopes = np.array(
                [(here.off(begun.framed(1e-6 * here.length * e)) - off).ravel() for e in np.eye(12)]
            ).T
            step = np.linalg.lstsq(slopes / (1e-6 * here.length), -off.ravel(), rcond=1e-9)[0]
            moved = begun.framed(step)
            trial = here.off(moved)
            if not np.sum(trial**2) < (1 - 1e-6) * np.sum(off**2):
                break
            begun, off = moved, trial
        if np.sum(off**2) < cost:
            best, cost = off, float(np.sum(off**2))
    return best


def _frames_by_kabsch(here: _PoseSet, there: _PoseSet) -> np.ndarray:
    """Find frames (12) that bring the middles of the places together and turn the places onto each
    other (Kabsch).
    """
    a, b = (p.places - np.mean(p.places, axis=1, keepdims=True) for p in (here, there))
    left, _, right = np.linalg.svd(a @ b.T)
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    step = np.zeros(12)
    step[:3] = np.mean(here.places, axis=1) - np.mean(there.places, axis=1)
    step[3:6] = here.length * np.asarray(
        rotation_vector_from_quaternion(np.asarray(quaternion_from_matrix(turn)))
    )
    return step
