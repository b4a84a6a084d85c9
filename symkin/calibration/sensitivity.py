"""How readings and poses change with the geometry, at closed configurations: the material of plans and of predictions.

With the closure F(z; q, p) = 0 solved for z, a reading h(z, p) has dh/dp = h_p - h_z F_z^+ F_p, and joint noise gives it the
covariance H_q diag(sigma_q^2) H_q^T with H_q = -h_z F_z^+ F_q. Parameters are scaled as in `model`: one unit of each is one
length unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.calibration.closing import Configurations
from symkin.calibration.direct import solved_steps
from symkin.calibration.measurements import NO_GROUP, Measurements
from symkin.calibration.model import build_model
from symkin.calibration.parameters import FRAMES
from symkin.calibration.residuals import build_readings, whitening
from symkin.calibration.simulate import Noise, read
from symkin.calibration.workspace import platform_points
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Slopes:
    """Readings over their standard deviations, joint noise included: A (n, K, P) by scaled parameters, and B (n, K, 2) by
    the unknown inclination of the posture's group, zero where it has none."""

    parameters: np.ndarray
    group: np.ndarray


def reading_slopes(
    mechanism: Mechanism, made: Configurations, readings: Sequence[str], noise: Noise, names: Sequence[str], *, grouped: bool
) -> Slopes:
    """Slopes of the readings that would be taken at closed configurations. Raises InputError where a
    reading is without a standard deviation."""
    quiet = np.random.default_rng(0)
    groups = np.zeros(len(made), dtype=int) if grouped else np.full(len(made), NO_GROUP)
    taken = read(mechanism, made, groups, readings, noise, quiet)
    for kind in ("group", "inclination", "position", "orientation"):
        present = grouped if kind == "group" else getattr(taken, kind) is not None
        if present and taken.sigma(kind) is None:
            raise InputError(f"the standard deviation of {kind} readings is zero or not given; a plan needs it")
    model = build_model(mechanism, taken, names)
    values, weights = build_readings(model, taken), noise.joints(mechanism)
    z = _unknowns(mechanism, made)
    e = model.evaluate(z, made.joints, model.nominal, made.poses[:, 3:])
    slopes = e.readings_p - e.readings_z @ solved_steps(e.rows_z, e.rows_p)
    by_joint = e.readings_z @ solved_steps(e.rows_z, model.rows_by_joint(z, made.joints, model.nominal)) * weights
    whiten = whitening(values, by_joint @ by_joint.transpose(0, 2, 1))
    basis = whiten[:, :, values.grouped] if grouped else np.zeros((*whiten.shape[:2], 0))
    return Slopes(whiten @ slopes, basis)


def pose_slopes(mechanism: Mechanism, made: Configurations, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Pose by scaled parameters (n, 6, P) and by the twelve constant frames that an alignment removes (n, 6, 12): position in the
    length unit, rotation vector in radians, joints held. Frames may be among the parameters."""
    poses = Measurements(made.joints, position=made.poses[:, :3], orientation=made.poses[:, 3:])
    model = build_model(mechanism, poses, tuple(dict.fromkeys((*names, *FRAMES))))
    e = model.evaluate(_unknowns(mechanism, made), made.joints, model.nominal, made.poses[:, 3:])
    slopes = e.readings_p - e.readings_z @ solved_steps(e.rows_z, e.rows_p)
    return slopes[:, :, : len(names)], slopes[:, :, [model.names.index(name) for name in FRAMES]]


def lever(mechanism: Mechanism) -> float:
    """Length by which angles are compared with positions: root mean square distance of the platform's joint points from
    their middle; where they coincide, a quarter of the size."""
    points = platform_points(mechanism)
    spread = float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))
    return spread if spread > 1e-9 * mechanism.size else 0.25 * mechanism.size


def without_frames(slopes: np.ndarray, frames: np.ndarray, length: float) -> np.ndarray:
    """Pose slopes (n, 6, P) less what the best constant base and tool frames take away; angles weigh `length`."""
    weight = np.array([1.0] * 3 + [length] * 3)[:, None]
    flat, columns = (weight * slopes).reshape(-1, slopes.shape[2]), (weight * frames).reshape(-1, frames.shape[2])
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    left = left[:, singular > 1e-9 * singular[0]]
    return np.asarray((flat - left @ (left.T @ flat)).reshape(slopes.shape) / weight)


def _unknowns(mechanism: Mechanism, made: Configurations) -> np.ndarray:
    """Passive and pose coordinates, in the order of the closure."""
    return np.ascontiguousarray(made.values[:, len(build_closure(mechanism).role("actuated")) :])
