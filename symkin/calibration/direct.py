"""The direct problem of all postures at once, at any parameter values."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.measurements import Measurements
from symkin.calibration.model import PostureModel
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.system import System
from symkin.position.given import pose_coordinates, pose_from

CLOSED = 1e-10
"""A posture is solved when its largest closure row, over the size, is below this."""
ROUGH = 1e-6
"""The same where an estimator goes on from there and corrects what is left to first order."""
_LONGEST = 0.3
"""Longest Newton step, in sizes."""
_TRIES = 12
"""Random starts for a posture that neither the reference nor its neighbours reach."""


@dataclass(frozen=True, eq=False)
class Postures:
    """Unknown coordinates z (n, width), and which of them are solved (n,)."""

    z: np.ndarray
    solved: np.ndarray


def newton_postures(
    model: PostureModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray, *, tolerance: float = CLOSED, iterations: int = 20
) -> tuple[np.ndarray, np.ndarray]:
    """Newton or Gauss-Newton with a bounded step for all postures: points and which of them closed."""
    size = model.closure.size
    largest = np.full(len(z), np.inf)
    for _ in range(iterations):
        rows, rows_z = model.rows(z, joints, p)
        largest = np.max(np.abs(rows), axis=1, initial=0.0) / size
        if not np.any(largest > tolerance):
            break
        step = -solved_steps(rows_z, rows[:, :, None])[:, :, 0]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, _LONGEST * size / np.maximum(length, 1e-300))[:, None]
        moved = model.system.move(z, np.nan_to_num(step))
        z = np.where((largest > tolerance)[:, None], moved, z)
    return z, largest <= tolerance


def solved_steps(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Least-squares solutions of n systems matrix (n, m, f), right (n, m, k); of no use (NaN) where singular."""
    if matrix.shape[1] == matrix.shape[2]:
        try:
            return np.asarray(np.linalg.solve(matrix, right))
        except np.linalg.LinAlgError:
            pass
    if not np.all(np.isfinite(matrix)):
        matrix = np.nan_to_num(matrix)
    return np.asarray(np.linalg.pinv(matrix, rcond=1e-12) @ right)


def solve_postures(
    model: PostureModel, measurements: Measurements, p: np.ndarray, *, z: np.ndarray | None = None, seed: int = 0,
    tolerance: float = CLOSED,
) -> Postures:  # fmt: skip
    """Solve F(z; q, p) = 0 for every posture, from `z` if given, else from the measurements' starts, the measured poses
    or the reference. Where Newton fails, Levenberg-Marquardt tries solved neighbours and random starts (`seed`)."""
    start = start_points(model, measurements) if z is None else z
    joints = measurements.joints
    with np.errstate(all="ignore"):
        found, solved = newton_postures(model, start, joints, p, tolerance=tolerance)
        if not solved.all():
            for k in np.flatnonzero(~solved):
                near = _neighbours(joints, found, solved, int(k))
                better = _rescue(model, measurements, p, int(k), np.vstack([start[k], near]), seed)
                found[k] = found[k] if better is None else better
            found, solved = newton_postures(model, found, joints, p, tolerance=tolerance)
        if tolerance <= CLOSED:
            found = np.where(solved[:, None], _corrected(model, found, joints, p), found)
    return Postures(found, solved)


def _corrected(model: PostureModel, z: np.ndarray, joints: np.ndarray, p: np.ndarray) -> np.ndarray:
    """One Newton step more: closed to rounding."""
    rows, rows_z = model.rows(z, joints, p)
    return model.system.move(z, np.nan_to_num(-solved_steps(rows_z, rows[:, :, None])[:, :, 0]))


def signs(rows_z: np.ndarray) -> np.ndarray:
    """Sign of det F_z (n,), 0 where F_z is not square: it changes only across a singularity."""
    if rows_z.shape[1] != rows_z.shape[2] or rows_z.shape[2] == 0:
        return np.zeros(len(rows_z))
    return np.asarray(np.sign(np.linalg.slogdet(rows_z)[0]))


def start_points(model: PostureModel, measurements: Measurements, *, measured: bool = False) -> np.ndarray:
    """Unknowns (n, width) at the starts: the pose given or measured (only so if `measured`), else the reference. Poses that are
    seen through unknown frames are no starts."""
    if model.observes_through_frames:
        measurements = without_poses(measurements)
    closure, system = model.closure, model.system
    places = dict(zip((c.name for c in system.unknowns), system.slices, strict=True))
    begin = np.empty((len(measurements), system.width))
    for name, place in places.items():
        begin[:, place] = closure.reference[closure.slices[name]]
    for k, pose in enumerate(known_poses(measurements, measured=measured)):
        if pose is None:
            continue
        values, _ = pose_coordinates(model.mechanism, pose_from(pose.tolist(), f"starts: posture {measurements.labels[k]}"))
        taken = 0
        for c in closure.role("pose"):
            begin[k, places[c.name]] = values[taken : taken + c.width]
            taken += c.width
    return begin


def known_poses(measurements: Measurements, *, measured: bool = False) -> list[np.ndarray | None]:
    """A whole pose of each posture: its start (unless `measured`), else what was measured."""
    poses: list[np.ndarray | None] = [None] * len(measurements)
    both = (measurements.position, measurements.orientation)
    read = None if any(part is None for part in both) else np.hstack(both)  # type: ignore[arg-type]
    for table in (read, None if measured else measurements.starts):
        if table is not None:
            poses = [row if np.all(np.isfinite(row)) else old for row, old in zip(table, poses, strict=True)]
    return poses


def without_poses(measurements: Measurements) -> Measurements:
    """The measurements without positions and orientations."""
    return replace(measurements, position=None, orientation=None)


def _neighbours(joints: np.ndarray, z: np.ndarray, solved: np.ndarray, k: int, count: int = 5) -> np.ndarray:
    near = [int(i) for i in np.argsort(np.linalg.norm(joints - joints[k], axis=1)) if solved[i]]
    return z[near[:count]]


def _rescue(
    model: PostureModel, measurements: Measurements, p: np.ndarray, k: int, starts: np.ndarray, seed: int
) -> np.ndarray | None:
    """A solution of one posture nearest to its first start, or None."""
    system: System = model.system
    rng = np.random.default_rng([seed, k])
    steps = 0.2 * model.closure.size * rng.normal(size=(_TRIES, system.freedom))
    starts = np.vstack([starts, system.move(np.tile(starts[:1], (_TRIES, 1)), steps)])
    batch = levenberg_marquardt(system, starts, np.concatenate([measurements.joints[k], p]))
    good = batch.points[batch.converged]
    if len(good) == 0:
        return None
    return np.asarray(good[np.argmin(np.linalg.norm(good - starts[0], axis=1))])
