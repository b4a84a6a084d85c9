"""A start from measured poses: parameters that close the loops best there.

With the whole pose of a posture measured, its closure rows are equations in the parameters (and passive joints) alone:
min sum |F(x_i, X_i measured, q_i, p)|^2. For rods this is one small regression a limb, which converges from geometry that
is far off; the direct problem is not needed.
"""

from __future__ import annotations

import numpy as np

from symkin.calibration.direct import known_poses, start_points
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import PostureModel

_STEPS = 40
"""Most Gauss-Newton steps; a start needs no more."""
_ROWS = 2000
"""Most postures that are used, spread evenly over the file: a start needs no more."""
_SMALLEST = 1e-6
"""Directions with singular values below this of the largest are left at their start."""


def parameters_from_poses(model: PostureModel, measurements: Measurements) -> np.ndarray | None:
    """Parameters (P,) at which the loops close best at the measured poses; None where too few poses are whole, or where
    frames between mechanism and measurement are unknown."""
    given = np.array([pose is not None for pose in known_poses(measurements, measured=True)])
    if np.sum(given) * int(model.system.rows.shape[0]) < len(model.names) or model.observes_through_frames:
        return None
    if np.sum(given) > _ROWS:
        some = np.flatnonzero(given)[np.linspace(0, np.sum(given) - 1, _ROWS).astype(int)]
        return parameters_from_poses(model, measurements.subset(some))
    joints, z = measurements.joints[given], start_points(model, measurements, measured=True)[given]
    passive = np.flatnonzero([c.role == "passive" for c in model.system.unknowns for _ in range(c.freedom)])
    with np.errstate(all="ignore"):
        return _fit(model, z, joints, passive)


def _fit(model: PostureModel, z: np.ndarray, joints: np.ndarray, passive: np.ndarray) -> np.ndarray | None:
    """Gauss-Newton with halved steps; passive joints are condensed posture by posture."""
    p = model.nominal

    def rows_at(p: np.ndarray, z: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
        e = model.evaluate(z, joints, p, np.zeros((len(z), 4)))
        return float(np.sum(e.rows**2)), e.rows, e.rows_z[:, :, passive], e.rows_p

    cost, rows, by_x, by_p = rows_at(p, z)
    for _ in range(_STEPS):
        if not (np.isfinite(cost) and np.all(np.isfinite(by_p))):
            return None
        inverse = np.linalg.pinv(by_x, rcond=1e-10)
        project = np.eye(rows.shape[1]) - by_x @ inverse
        left, right = (project @ by_p).reshape(-1, len(p)), -(project @ rows[:, :, None]).reshape(-1)
        step = np.linalg.lstsq(left, right, rcond=_SMALLEST)[0]
        follow = -(inverse @ (rows + (by_p @ step))[:, :, None])[:, :, 0]
        for _ in range(8):
            whole = np.zeros((len(z), model.system.freedom))
            whole[:, passive] = follow
            trial = p + model.scales * step, model.system.move(z, whole)
            found = rows_at(*trial)
            if found[0] < cost:
                break
            step, follow = 0.5 * step, 0.5 * follow
        else:
            break
        gained = cost - found[0]
        (p, z), (cost, rows, by_x, by_p) = trial, found
        if gained < 1e-9 * cost:
            break
    return p
