"""How well a calibrated mechanism knows its pose."""

from __future__ import annotations

import numpy as np

from symkin.calibration.direct import solve_postures
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import build_model
from symkin.calibration.result import Calibration
from symkin.calibration.state import slopes
from symkin.errors import InputError


def pose_sigma(calibration: Calibration, joints: np.ndarray, starts: np.ndarray | None = None) -> np.ndarray:
    """Standard deviations (n, 6) of the pose at joint readings (n, actuated) that the parameters' covariance leaves:
    position in the length unit, rotation vector in the platform frame in radians, in the frames of the calibration.

    C_X = J C_p J^T, J = dX/dp at fixed joints. Raises InputError where a direct problem has no solution near `starts`
    (n, 7; default: the reference pose).
    """
    problem = calibration.problem
    joints = np.asarray(joints, dtype=float)
    p = calibration.state.p
    measured = Measurements(joints, position=np.zeros((len(joints), 3)), orientation=np.tile([1.0, 0, 0, 0], (len(joints), 1)))
    measured.check(calibration.mechanism)
    model = build_model(calibration.mechanism, measured, problem.names)
    postures = solve_postures(model, Measurements(joints, starts=starts), p)
    if not postures.solved.all():
        raise InputError(
            f"the direct problem of joint readings {int(np.argmin(postures.solved)) + 1} has no solution near its start"
        )
    poses = model.poses(postures.z, p)
    by_p = slopes(model.evaluate(postures.z, joints, p, poses[:, 3:]))
    free = calibration.covariance[: len(p), : len(p)] / np.outer(model.scales, model.scales)
    covariance = by_p @ free @ by_p.transpose(0, 2, 1)
    return np.asarray(np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0)))
