"""Predict the standard deviations of poses after a calibration, and whether the geometry is
determined enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import judged_link
from symkin.calibration.data.parameters import MEASURING_FRAMES, with_parameters
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import (
    ClosedConfigurations,
    is_carried,
    solve_configurations,
)
from symkin.calibration.estimate.problem import PRIOR_SHARE
from symkin.calibration.estimate.starting import has_home
from symkin.calibration.estimate.workspace import ClosureSolver, Workspace, home_pose, lever
from symkin.calibration.judge.departure import judged_poses
from symkin.calibration.judge.result import Calibration
from symkin.closure.closure import build_closure
from symkin.errors import InputError, SymkinError
from symkin.model.mechanism import Mechanism
from symkin.position.transfer import many_elsewhere
from symkin.spatial.pose import Pose

_ACCURACY_POSES = 200
"""Poses of the workspace at which standard deviations are computed."""
_UNDETERMINED_SLOPES = (1e-4, 1e-2)
"""A direction that no reading determines moves the pose when the aligned pose slope along it, times
the prior's standard deviation, is more than the pose's: by the prior alone is it known where the
geometry lies there. Slopes below the first are rounding (parameters that matter have about 1),
slopes above the second always count.
"""
_REGION_TEXT = f"{_ACCURACY_POSES} random poses in the region measured"
_DRAWN_POSES = 2 * _ACCURACY_POSES
"""Poses that are drawn for these; some do not close or are near a singularity."""


@dataclass(frozen=True, eq=False)
class PoseSigma:
    """Standard deviations (n, 6) of position (length unit) and rotation vector (radians) at poses
    (n, 7), constant base and tool frames taken away. `blind` says that a direction which no reading
    determines moves the pose: part of the geometry is then unknown. `where` names the poses;
    `outside` (n,) are those at which some joint is beyond all of its readings. `about_home` is the
    same over the default workspace about home, None where that is not known or cannot be taken.
    """

    poses: np.ndarray
    sigma: np.ndarray
    blind: bool
    where: str
    outside: np.ndarray
    about_home: PoseSigma | None = None

    @property
    def position(self) -> np.ndarray:
        """Root of the summed variances of the components (n,)."""
        return np.asarray(np.linalg.norm(self.sigma[:, :3], axis=1))

    @property
    def angle(self) -> np.ndarray:
        return np.asarray(np.linalg.norm(self.sigma[:, 3:], axis=1))


def predict_pose_sigma(fit: Calibration, seed: int = 0) -> PoseSigma:
    """Predict standard deviations over random poses of the region that was measured, else at the
    configurations measured; and about home.
    """
    identified = with_parameters(replace(fit.mechanism, example=None), fit.values)
    made, where = _measured_region(identified, fit, seed)
    about_home = None
    if has_home(fit.mechanism):
        home = Workspace.about(identified, start=home_pose(fit.mechanism))
        drawn = _drawn_about_home(home, seed)
        about_home = (
            None
            if drawn is None
            else _pose_sigma_at(
                fit, identified, drawn, f"{_ACCURACY_POSES} random poses about home"
            )
        )
    if identified.platform_link is None:
        where = f"of link {judged_link(identified)}, {where}"
    return replace(_pose_sigma_at(fit, identified, made, where), about_home=about_home)


def _pose_sigma_at(
    fit: Calibration, identified: Mechanism, made: ClosedConfigurations, where: str
) -> PoseSigma:
    names, scales = fit.problem.names, fit.problem.model.scales
    slopes, frames, _ = pose_slopes(identified, made, names)
    slopes = less_frames(slopes, frames, lever(identified))
    scaled = fit.covariance[: len(names), : len(names)] / np.outer(scales, scales)
    variance = np.einsum("nkp,pq,nkq->nk", slopes, scaled, slopes)
    # what noise drowns is known by the prior alone
    prior = PRIOR_SHARE * fit.mechanism.characteristic_length
    drowned = prior * fit.identifiability.drowned
    variance += np.sum((slopes @ drowned) ** 2, axis=2)
    sigma = np.sqrt(np.maximum(variance, 0.0))
    spread = float(np.sqrt(np.mean(np.sum(sigma[:, :3] ** 2, axis=1)))) / prior
    blind = bool(
        np.max(np.abs(slopes @ fit.identifiability.blind), initial=0.0)
        > np.clip(spread, *_UNDETERMINED_SLOPES)
    )
    read = fit.measurements.joints[list(fit.used)]
    outside = np.any((made.joints < read.min(axis=0)) | (made.joints > read.max(axis=0)), axis=1)
    return PoseSigma(poses=made.poses, sigma=sigma, blind=blind, where=where, outside=outside)


# --- poses ----------------------------------------------------------------------------------------


def _measured_region(
    identified: Mechanism, fit: Calibration, seed: int
) -> tuple[ClosedConfigurations, str]:
    """Random poses between pairs of measured ones (an arm: within its measured joint values), else
    the configurations measured.
    """
    joints = fit.measurements.joints[list(fit.used)]
    rng = np.random.default_rng(seed)
    if identified.serial:
        drawn = rng.uniform(
            joints.min(axis=0), joints.max(axis=0), (_ACCURACY_POSES, joints.shape[1])
        )
        return _at_joints(identified, drawn, None), _REGION_TEXT
    if is_carried(build_closure(identified)):
        return _followed_between(identified, fit, rng)
    poses = judged_poses(fit.problem, fit.state.p, fit.state.z, fit.problem.measurements.joints)
    turns = poses[:, 3:]
    # of each the sum of squared cosines to all
    near = np.sum((turns @ (turns.T @ turns)) * turns, axis=1)
    central = poses[int(np.argmax(near))]
    solver = ClosureSolver(identified, Pose(central[:3], central[3:]))
    made, good = solver.close(_between_measured(fit, rng), None, limits=False)
    kept = np.flatnonzero(good)[:_ACCURACY_POSES]
    return (
        (made.take(kept), _REGION_TEXT)
        if len(kept)
        else (_at_joints(identified, joints, poses), "the postures measured")
    )


def _followed_between(
    identified: Mechanism, fit: Calibration, rng: np.random.Generator
) -> tuple[ClosedConfigurations, str]:
    """Configurations followed from measured ones part of the way to the joints of others."""
    observing = build_closure(identified, fit.problem.model.closure.partition)
    joints = fit.problem.measurements.joints
    measured = many_elsewhere(
        build_closure(identified), observing, np.hstack([joints, fit.state.z])
    )
    first, second = rng.integers(len(joints), size=(2, _DRAWN_POSES))
    solver = ClosureSolver(identified, home_pose(identified))
    towards = joints[first] + rng.uniform(0.0, 1.0, (_DRAWN_POSES, 1)) * (
        joints[second] - joints[first]
    )
    made, good = solver.close(solver.at_joints(towards, measured[first]), None, limits=False)
    kept = np.flatnonzero(good)[:_ACCURACY_POSES]
    if not len(kept):
        made, kept = solver.close(measured, None, limits=False)[0], np.arange(len(measured))
    return made.take(kept), _REGION_TEXT if good.any() else "the postures measured"


def _between_measured(fit: Calibration, rng: np.random.Generator) -> np.ndarray:
    """Variables of the closure (k, width) between pairs of measured configurations, quaternions by
    the shorter way.
    """
    model = fit.problem.model
    measured = many_elsewhere(
        build_closure(fit.mechanism),
        model.closure,
        np.hstack([fit.problem.measurements.joints, fit.state.z]),
    )
    first, second = measured[rng.integers(len(measured), size=(2, _DRAWN_POSES))]
    share = rng.uniform(0.0, 1.0, (_DRAWN_POSES, 1))
    closure = build_closure(fit.mechanism)
    for c in closure.coordinates:
        if c.kind == "quaternion":
            place = closure.slices[c.name]
            second[:, place] *= np.where(
                np.sum(first[:, place] * second[:, place], axis=1, keepdims=True) < 0, -1.0, 1.0
            )
    made = (1 - share) * first + share * second
    for c in closure.coordinates:
        if c.kind == "quaternion":
            place = closure.slices[c.name]
            made[:, place] /= np.linalg.norm(made[:, place], axis=1, keepdims=True)
    return np.asarray(made)


def _drawn_about_home(workspace: Workspace, seed: int) -> ClosedConfigurations | None:
    rng = np.random.default_rng(seed)
    try:
        return workspace.draw(workspace.inclinations(_ACCURACY_POSES, rng), rng, held=False)
    except SymkinError:
        return None


def _at_joints(
    mechanism: Mechanism, joints: np.ndarray, starts: np.ndarray | None
) -> ClosedConfigurations:
    """Closed configurations at joint values, those that are solved."""
    m = Measurements(joints, starts=starts)
    model = build_model(mechanism, m, ())
    configurations = solve_configurations(model, m, np.zeros(0))
    z, joints = configurations.z[configurations.solved], joints[configurations.solved]
    return ClosedConfigurations(np.hstack([joints, z]), joints, model.poses(z, joints, np.zeros(0)))


def pose_sigma(
    calibration: Calibration, joints: np.ndarray, starts: np.ndarray | None = None
) -> np.ndarray:
    """Propagate the parameters' covariance to the pose at joint readings (n, actuated): standard
    deviations (n, 6), position in the length unit, rotation vector in the platform frame in
    radians, in the frames of the calibration.

    C_X = J C_p J^T, J = dX/dp at fixed joints. Raises InputError where a direct problem has no
    solution near `starts` (n, 7; default: the reference pose).
    """
    problem = calibration.problem
    joints = np.asarray(joints, dtype=float)
    p = calibration.state.p
    measured = Measurements(
        joints,
        position=np.zeros((len(joints), 3)),
        orientation=np.tile([1.0, 0, 0, 0], (len(joints), 1)),
    )
    measured.check(calibration.mechanism)
    model = build_model(calibration.mechanism, measured, problem.names)
    configurations = solve_configurations(model, Measurements(joints, starts=starts), p)
    if not configurations.solved.all():
        raise InputError(
            f"the direct problem of joint readings {int(np.argmin(configurations.solved)) + 1} has "
            f"no solution near its start"
        )
    poses = model.poses(configurations.z, joints, p)
    by_p = model.evaluate(configurations.z, joints, p, poses[:, 3:]).slopes
    free = calibration.covariance[: len(p), : len(p)] / np.outer(model.scales, model.scales)
    covariance = by_p @ free @ by_p.transpose(0, 2, 1)
    return np.asarray(np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0)))


def pose_slopes(
    mechanism: Mechanism, made: ClosedConfigurations, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Differentiate the pose by scaled parameters (n, 6, P) and by the twelve constant frames that
    an alignment removes (n, 6, 12): position in the length unit, rotation vector in radians, joints
    held; and rows that redundant loops leave over, by scaled parameters (n, m, P). Frames may be
    among the parameters.
    """
    poses = Measurements(made.joints, position=made.poses[:, :3], orientation=made.poses[:, 3:])
    model = build_model(mechanism, poses, tuple(dict.fromkeys((*names, *MEASURING_FRAMES))))
    e = model.evaluate(
        unknown_coordinates(mechanism, made), made.joints, model.nominal, made.poses[:, 3:]
    )
    slopes = e.slopes
    frames = [model.names.index(name) for name in MEASURING_FRAMES]
    return (
        slopes[:, :, : len(names)],
        slopes[:, :, frames],
        e.left_over[:, :, : len(names)],
    )


def less_frames(slopes: np.ndarray, frames: np.ndarray, length: float) -> np.ndarray:
    """Take from pose slopes (n, 6, P) what the best constant base and tool frames remove; angles
    weigh `length`.
    """
    weight = np.array([1.0] * 3 + [length] * 3)[:, None]
    flat, columns = (
        (weight * slopes).reshape(-1, slopes.shape[2]),
        (weight * frames).reshape(-1, frames.shape[2]),
    )
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    left = left[:, singular > 1e-9 * singular[0]]
    return np.asarray((flat - left @ (left.T @ flat)).reshape(slopes.shape) / weight)


def unknown_coordinates(mechanism: Mechanism, made: ClosedConfigurations) -> np.ndarray:
    """Return passive and pose coordinates, in the order of the closure."""
    return np.ascontiguousarray(made.values[:, len(build_closure(mechanism).role("actuated")) :])
