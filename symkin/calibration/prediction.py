"""What a calibration says of poses: their standard deviation over the workspace, and whether the geometry is whole enough."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.calibrate import Calibration
from symkin.calibration.closing import Closing, Configurations, home_pose
from symkin.calibration.corrected import with_parameters
from symkin.calibration.departure import platform_poses
from symkin.calibration.direct import solve_postures
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import build_model
from symkin.calibration.sensitivity import lever, pose_slopes, without_frames
from symkin.calibration.starting import has_home
from symkin.calibration.workspace import Workspace
from symkin.closure.closure import build_closure
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose

_POSES = 200
"""Poses of the workspace at which standard deviations are computed."""
_OFF = 1e-3
"""Share of the size by which the nominal geometry may be off along a direction that no reading tells."""
_BLIND = (1e-4, 1e-2)
"""Such a direction moves the pose when the aligned pose slope along it, times that error, is more than the pose's standard deviation:
slopes below the first are rounding (parameters that matter have about 1), slopes above the second always count."""
_REGION = f"{_POSES} random poses in the region measured"
_DRAWN = 2 * _POSES
"""Poses that are drawn for these; some do not close or are near a singularity."""


@dataclass(frozen=True, eq=False)
class PoseSigma:
    """Standard deviations (n, 6) of position (length unit) and rotation vector (radians) at poses (n, 7), constant base and
    tool frames taken away. `blind` says that a direction which no reading tells moves the pose: the geometry is then not
    whole. `where` names the poses; `outside` (n,) are those at which some joint is beyond all of its readings. `about_home` is the same
    over the default workspace about home, None where that is not known or cannot be taken."""

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


def pose_sigma(fit: Calibration, seed: int = 0) -> PoseSigma:
    """Standard deviations over random poses of the region that was measured, else at the postures measured; and about home."""
    identified = with_parameters(replace(fit.mechanism, example=None), fit.values)
    made, where = _measured_region(identified, fit, seed)
    about_home = None
    if has_home(fit.mechanism):
        home = Workspace.about(identified, start=home_pose(fit.mechanism))
        drawn = _drawn(home, seed)
        about_home = None if drawn is None else _sigma(fit, identified, drawn, f"{_POSES} random poses about home")
    return replace(_sigma(fit, identified, made, where), about_home=about_home)


def _sigma(fit: Calibration, identified: Mechanism, made: Configurations, where: str) -> PoseSigma:
    names, scales = fit.problem.names, fit.problem.model.scales
    slopes, frames = pose_slopes(identified, made, names)
    slopes = without_frames(slopes, frames, lever(identified))
    scaled = fit.covariance[: len(names), : len(names)] / np.outer(scales, scales)
    variance = np.einsum("nkp,pq,nkq->nk", slopes, scaled, slopes)
    sigma = np.sqrt(np.maximum(variance, 0.0))
    spread = float(np.sqrt(np.mean(np.sum(sigma[:, :3] ** 2, axis=1)))) / (_OFF * fit.mechanism.size)
    blind = bool(np.max(np.abs(slopes @ fit.identifiability.null_space), initial=0.0) > np.clip(spread, *_BLIND))
    read = fit.measurements.joints[list(fit.used)]
    outside = np.any((made.joints < read.min(axis=0)) | (made.joints > read.max(axis=0)), axis=1)
    return PoseSigma(made.poses, sigma, blind, where, outside)


# --- poses -----------------------------------------------------------------------------------------------------------


def _measured_region(identified: Mechanism, fit: Calibration, seed: int) -> tuple[Configurations, str]:
    """Random poses between pairs of measured ones (an arm: within its measured joint values), else the postures measured."""
    joints = fit.measurements.joints[list(fit.used)]
    rng = np.random.default_rng(seed)
    if identified.serial:
        drawn = rng.uniform(joints.min(axis=0), joints.max(axis=0), (_POSES, joints.shape[1]))
        return _at_joints(identified, drawn, None), _REGION
    poses = platform_poses(fit.problem, fit.state.p, fit.state.z)
    turns = poses[:, 3:]
    near = np.sum((turns @ (turns.T @ turns)) * turns, axis=1)  # of each the sum of squared cosines to all
    central = poses[int(np.argmax(near))]
    closing = Closing(identified, Pose(central[:3], central[3:]))
    made, good = closing.close(_between(fit, rng), None, limits=False)
    kept = np.flatnonzero(good)[:_POSES]
    return (made.take(kept), _REGION) if len(kept) else (_at_joints(identified, joints, poses), "the postures measured")


def _between(fit: Calibration, rng: np.random.Generator) -> np.ndarray:
    """Variables of the closure (k, width) between pairs of measured postures, quaternions by the shorter way."""
    measured = np.hstack([fit.problem.measurements.joints, fit.state.z])
    first, second = measured[rng.integers(len(measured), size=(2, _DRAWN))]
    share = rng.uniform(0.0, 1.0, (_DRAWN, 1))
    closure = build_closure(fit.mechanism)
    for c in closure.coordinates:
        if c.kind == "quaternion":
            place = closure.slices[c.name]
            second[:, place] *= np.where(np.sum(first[:, place] * second[:, place], axis=1, keepdims=True) < 0, -1.0, 1.0)
    made = (1 - share) * first + share * second
    for c in closure.coordinates:
        if c.kind == "quaternion":
            place = closure.slices[c.name]
            made[:, place] /= np.linalg.norm(made[:, place], axis=1, keepdims=True)
    return np.asarray(made)


def _drawn(workspace: Workspace, seed: int) -> Configurations | None:
    rng = np.random.default_rng(seed)
    try:
        return workspace.draw(workspace.inclinations(_POSES, rng), rng, held=False)
    except SymkinError:
        return None


def _at_joints(mechanism: Mechanism, joints: np.ndarray, starts: np.ndarray | None) -> Configurations:
    """Closed configurations at joint values, those that are solved."""
    m = Measurements(joints, starts=starts)
    model = build_model(mechanism, m, ())
    postures = solve_postures(model, m, np.zeros(0))
    z, joints = postures.z[postures.solved], joints[postures.solved]
    return Configurations(np.hstack([joints, z]), joints, model.poses(z, np.zeros(0)))
