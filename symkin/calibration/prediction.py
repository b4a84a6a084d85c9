"""What a calibration says of poses: their standard deviation over the workspace, and whether the geometry is whole enough."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.calibrate import Calibration
from symkin.calibration.closing import Configurations, home_pose
from symkin.calibration.corrected import with_parameters
from symkin.calibration.direct import solve_postures
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import build_model
from symkin.calibration.sensitivity import lever, pose_slopes, without_frames
from symkin.calibration.workspace import Workspace
from symkin.errors import SymkinError

_POSES = 200
"""Poses of the workspace at which standard deviations are computed."""
_OFF = 1e-3
"""Share of the size by which the nominal geometry may be off along a direction that no reading tells."""
_BLIND = (1e-4, 1e-2)
"""Such a direction moves the pose when the aligned pose slope along it, times that error, is more than the pose's standard deviation:
slopes below the first are rounding (parameters that matter have about 1), slopes above the second always count."""


@dataclass(frozen=True, eq=False)
class PoseSigma:
    """Standard deviations (n, 6) of position (length unit) and rotation vector (radians) at poses (n, 7), constant base and
    tool frames taken away. `blind` says that a direction which no reading tells moves the pose: the geometry is then not
    whole. `where` names the poses; `outside` (n,) are those at which some joint is beyond all of its readings."""

    poses: np.ndarray
    sigma: np.ndarray
    blind: bool
    where: str
    outside: np.ndarray

    @property
    def position(self) -> np.ndarray:
        """Root of the summed variances of the components (n,)."""
        return np.asarray(np.linalg.norm(self.sigma[:, :3], axis=1))

    @property
    def angle(self) -> np.ndarray:
        return np.asarray(np.linalg.norm(self.sigma[:, 3:], axis=1))


def pose_sigma(fit: Calibration, seed: int = 0) -> PoseSigma:
    """Standard deviations over random poses of the identified mechanism's workspace, else over the postures measured."""
    identified = with_parameters(replace(fit.mechanism, example=None), fit.values)
    workspace = Workspace.about(identified, start=home_pose(fit.mechanism))
    made, where = _poses(workspace, fit.measurements.joints[list(fit.used)], seed)
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


def _poses(workspace: Workspace, joints: np.ndarray, seed: int) -> tuple[Configurations, str]:
    rng = np.random.default_rng(seed)
    try:
        return workspace.draw(workspace.inclinations(_POSES, rng), rng, held=False), f"{_POSES} random poses about home"
    except SymkinError:
        m = Measurements(joints)
        model = build_model(workspace.mechanism, m, ())
        postures = solve_postures(model, m, np.zeros(0))
        z, joints = postures.z[postures.solved], joints[postures.solved]
        return Configurations(np.hstack([joints, z]), joints, model.poses(z, np.zeros(0))), "the postures measured"
