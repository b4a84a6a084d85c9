"""Predict the standard deviations of poses after a calibration, and whether the geometry is
determined enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.observables import judged_link
from symkin.calibration.data.parameters import with_parameters
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import ClosedConfigurations, is_carried
from symkin.calibration.estimate.problem import PRIOR_SHARE
from symkin.calibration.estimate.starting import has_home
from symkin.calibration.estimate.workspace import Workspace, home_pose, lever
from symkin.calibration.judge.departure import judged_poses, less_frames, most_central
from symkin.calibration.judge.prediction import covariance_root
from symkin.calibration.judge.result import Calibration
from symkin.closure.closure import build_closure
from symkin.errors import SymkinError
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
_DRAWN_POSES = 5 * _ACCURACY_POSES // 4
"""Poses that are drawn for these; a few do not close or are near a singularity."""


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
    made, where = _measured_region(identified, fit, np.random.default_rng(seed))
    if identified.platform_link is None:
        where = f"of link {judged_link(identified)}, {where}"
    about_home = None
    if has_home(fit.mechanism):
        home, rng = (
            Workspace.about(identified, start=home_pose(fit.mechanism)),
            np.random.default_rng(seed),
        )
        try:
            drawn = home.draw(home.inclinations(_ACCURACY_POSES, rng), rng, held=False)
            text = f"{_ACCURACY_POSES} random poses about home"
            about_home = _pose_sigma_at(fit, identified, drawn, text)
        except SymkinError:
            pass
    return replace(_pose_sigma_at(fit, identified, made, where), about_home=about_home)


def _pose_sigma_at(
    fit: Calibration, identified: Mechanism, made: ClosedConfigurations, where: str
) -> PoseSigma:
    slopes, _ = pose_slopes(identified, made, fit.problem.names)
    slopes = less_frames(slopes, made.poses, lever(identified))
    # what noise drowns is known by the prior alone
    prior = PRIOR_SHARE * fit.mechanism.characteristic_length
    known = covariance_root(fit.covariance, fit.problem)
    root = np.hstack([known, prior * fit.identifiability.drowned])
    sigma = np.linalg.norm(slopes @ root, axis=2)
    spread = float(np.sqrt(np.mean(np.sum(sigma[:, :3] ** 2, axis=1)))) / prior
    moved = np.max(np.abs(slopes @ fit.identifiability.blind), initial=0.0)
    read = fit.measurements.joints[list(fit.used)]
    outside = np.any((made.joints < read.min(axis=0)) | (made.joints > read.max(axis=0)), axis=1)
    return PoseSigma(
        poses=made.poses,
        sigma=sigma,
        blind=bool(moved > np.clip(spread, *_UNDETERMINED_SLOPES)),
        where=where,
        outside=outside,
    )


# --- poses ----------------------------------------------------------------------------------------


def _measured_region(
    identified: Mechanism, fit: Calibration, rng: np.random.Generator
) -> tuple[ClosedConfigurations, str]:
    """Draw random configurations between pairs of measured ones (an arm: within its measured joint
    values; where joints carry the platform, followed part of the way to the joints of others), else
    the configurations measured.
    """
    joints, closure = fit.problem.measurements.joints, build_closure(identified)
    measured, home = np.tile(closure.reference, (len(joints), 1)), home_pose(identified)
    if not identified.serial:
        observing = build_closure(identified, fit.problem.model.closure.partition)
        measured = many_elsewhere(closure, observing, np.hstack([joints, fit.state.z]))
    if not identified.serial and not is_carried(closure):
        poses = judged_poses(fit.problem, fit.state.p, fit.state.z, joints)
        central = poses[most_central(poses[:, 3:])]
        home = Pose(central[:3], central[3:])
    solver = Workspace.about(identified, start=home)
    first, second = rng.integers(len(measured), size=(2, _DRAWN_POSES))
    share, (a, b) = rng.uniform(0.0, 1.0, (_DRAWN_POSES, 1)), measured[[first, second]]
    starts = (1 - share) * a + share * b
    for place in (closure.slices[c.name] for c in closure.coordinates if c.is_rotation):
        shorter = np.sign(np.sum(a[:, place] * b[:, place], axis=1, keepdims=True))
        turned = (1 - share) * a[:, place] + share * shorter * b[:, place]
        starts[:, place] = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    if identified.serial:
        drawn = rng.uniform(joints.min(axis=0), joints.max(axis=0), (len(first), joints.shape[1]))
        starts = solver.with_tool(np.hstack([drawn, a[:, joints.shape[1] :]]))
    elif is_carried(closure):
        starts = solver.at_joints((1 - share) * joints[first] + share * joints[second], a)
    made, good = solver.close(starts, None, limits=False)
    if good.any():
        return made.take(np.flatnonzero(good)[:_ACCURACY_POSES]), _REGION_TEXT
    return solver.close(measured, None, limits=False)[0], "the postures measured"


def pose_slopes(
    mechanism: Mechanism, made: ClosedConfigurations, names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Differentiate the pose by scaled parameters (n, 6, P): position in the length unit, rotation
    vector in radians, joints held; and rows that redundant loops leave over, (n, m, P).
    """
    whole = Measurements(made.joints, position=made.poses[:, :3], orientation=made.poses[:, 3:])
    model = build_model(mechanism, whole, tuple(names))
    z = np.ascontiguousarray(made.values[:, made.joints.shape[1] :])
    e = model.evaluate(z, made.joints, model.nominal, whole.quaternions)
    return e.slopes, e.left_over
