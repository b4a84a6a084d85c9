"""Judge a fit by what it predicts: standard deviations of poses, whether the geometry is determined
enough, and the readings of postures that were held out.

The errors e of held-out readings (see `statistics`) have covariance S + J C J^T, so that e^T (S + J
C J^T)^-1 e has the chi-square distribution with as many degrees of freedom as readings were held
out, less two for the unknown inclination of each group.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.data.observables import PLATFORM, judged_link
from symkin.calibration.data.parameters import with_parameters
from symkin.calibration.estimate.configuration_model import model_of
from symkin.calibration.estimate.configurations import ClosedConfigurations, is_carried
from symkin.calibration.estimate.problem import PRIOR_SHARE
from symkin.calibration.estimate.starting import has_home
from symkin.calibration.estimate.workspace import Workspace, home_pose, lever
from symkin.calibration.judge.departure import judged_poses, less_frames, most_central
from symkin.calibration.judge.outliers import MAX_OUTLIER_SHARE, OUTLIER_LEVEL
from symkin.calibration.judge.result import Calibration
from symkin.calibration.judge.statistics import (
    SIGNIFICANCE,
    chi_square_tail,
    close_others,
    covariance_root,
    predict_readings,
)
from symkin.closure.closure import build_closure
from symkin.errors import InputError, SymkinError
from symkin.model.mechanism import Mechanism
from symkin.numeric.linear_algebra import largest_of
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
        return np.linalg.norm(self.sigma[:, :3], axis=1)

    @property
    def angle(self) -> np.ndarray:
        return np.linalg.norm(self.sigma[:, 3:], axis=1)


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
        home = Workspace.about(identified, start=home_pose(fit.mechanism))
        rng = np.random.default_rng(seed)
        with suppress(SymkinError):
            drawn = home.draw(home.inclinations(_ACCURACY_POSES, rng), rng, held=False)
            text = f"{_ACCURACY_POSES} random poses about home"
            about_home = pose_sigma_at(fit, identified, drawn, text)
    return replace(pose_sigma_at(fit, identified, made, where), about_home=about_home)


def pose_sigma_at(
    fit: Calibration, identified: Mechanism, made: ClosedConfigurations, where: str
) -> PoseSigma:
    """Standard deviations of the poses at closed configurations of the identified machine; `where`
    says which these are.
    """
    slopes, _ = pose_slopes(identified, made, fit.problem.names)
    slopes = less_frames(slopes, made.poses, lever(identified))
    # what noise drowns is known by the prior alone
    prior = PRIOR_SHARE * fit.mechanism.characteristic_length
    known = covariance_root(fit.covariance, fit.problem)
    root = np.hstack([known, prior * fit.identifiability.drowned])
    sigma = np.linalg.norm(slopes @ root, axis=2)
    spread = np.sqrt(np.mean(np.sum(sigma[:, :3] ** 2, axis=1))) / prior
    moved = largest_of(slopes @ fit.identifiability.blind)
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
    joints, closure = fit.problem.joints, build_closure(identified)
    measured, home = np.tile(closure.reference, (len(joints), 1)), home_pose(identified)
    if not identified.serial:
        observing = build_closure(identified, fit.problem.model.closure.partition)
        measured = many_elsewhere(closure, observing, np.hstack([joints, fit.state.z]))
        if not is_carried(closure):
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
        starts = solver.at_joints(drawn, a)
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
    model = model_of(mechanism, (PLATFORM["position"], PLATFORM["orientation"]), tuple(names))
    z = np.ascontiguousarray(made.values[:, made.joints.shape[1] :])
    e = model.evaluate(z, made.joints, model.nominal, made.poses[:, 3:])
    return e.slopes, e.left_over


# --- held-out postures ----------------------------------------------------------------------------


_COUNT_PATTERN = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(%?)\s*")


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Predictions at configurations that were held out, by their labels: root mean square of the
    errors and what was expected of it, by kind (radians, length unit); chi-square without the
    `outliers`, its degrees of freedom and probability; configurations `unsolved`.
    """

    labels: tuple[str, ...]
    unsolved: tuple[str, ...]
    seed: int
    rms: dict[str, float] = field(default_factory=dict)
    expected: dict[str, float] = field(default_factory=dict)
    chi_square: float = 0.0
    degrees: int = 0
    p_value: float | None = None
    outliers: tuple[str, ...] = ()

    @property
    def believable(self) -> bool:
        """Whether they are predicted as well as noise and the parameters' standard deviations let
        expect.
        """
        return not self.unsolved and (self.p_value is None or self.p_value > SIGNIFICANCE)

    @property
    def doubt(self) -> str:
        """Why the prediction is not believable."""
        if self.unsolved:
            return (
                f"the direct problem of {len(self.unsolved)} of {len(self.labels)} held-out "
                f"postures has no solution"
            )
        times = math.sqrt(self.chi_square / max(self.degrees, 1))
        return (
            f"the {len(self.labels)} held-out postures are missed by {times:.3g} times what noise "
            f"and parameters let expect, probability "
            f"{self.p_value:.1g}: the model lacks something that the fitted postures hide"
        )


def held_out_count(asked: str, configurations: int) -> int:
    """Read how many configurations `20` or `20%` are. Raises InputError where none or all of them
    would be held out.
    """
    match = _COUNT_PATTERN.fullmatch(asked)
    if match is None or (not match[2] and "." in match[1]):
        raise InputError(
            f"--hold-out {asked!r}: a number of postures, or a share such as 20%, is needed"
        )
    share = float(match[1]) / 100.0
    count = max(int(share > 0.0), round(share * configurations)) if match[2] else int(match[1])
    if not 1 <= count < configurations:
        raise InputError(
            f"--hold-out {asked.strip()}: {count} of {configurations} postures would be held out; "
            f"allowed: 1 to {configurations - 1}"
        )
    return count


def draw_held_out(measurements: Measurements, count: int, seed: int) -> np.ndarray:
    """Draw the configurations (n,) to be held out: at random, and whole groups, until there are
    `count` of them or just more; none without a reading beside the joints. Raises InputError where
    nothing is left.
    """
    groups, left = measurements.group_of, measurements.is_read
    held = np.zeros(len(left), dtype=bool)
    for k in np.random.default_rng([seed, len(measurements)]).permutation(len(measurements)):
        if left[k] and not held[k] and held.sum() < count:
            held |= (groups == groups[k]) if groups[k] != NO_GROUP else np.arange(len(held)) == k
    if not np.any(left & ~held):
        raise InputError(
            "--hold-out: whole groups are held out, and none would be left; hold out less, or take "
            "more groups"
        )
    return held


def predict_held_out(fit: Calibration, measurements: Measurements, seed: int) -> HeldOut:
    """Predict held-out configurations by a fit; their direct problems begin at their neighbours'
    solutions.
    """
    problem, z, solved = close_others(fit.problem, fit.state, measurements, seed)
    lost = HeldOut(tuple(measurements.labels), measurements.named(~solved), seed)
    if not len(z):
        return lost
    root, factor = covariance_root(fit.covariance, fit.problem), 1.0
    if not fit.problem.readings.known:
        factor = max(fit.chi_square / max(fit.degrees, 1), 1e-300)
    predict = partial(predict_readings, problem, fit.state.p, z, root, factor)
    left = None if fit.problem.readings.known else fit.degrees

    def probability(chi_square: float, degrees: int) -> float | None:
        tested = degrees > 0 and fit.degrees > 0
        return chi_square_tail(chi_square, degrees, left) if tested else None

    made = clean = predict()
    taken, group, kept = problem.readings.taken, problem.readings.group, np.ones(len(z), dtype=bool)
    level = 1.0 - (1.0 - OUTLIER_LEVEL) ** (1.0 / len(z))
    chances = [
        probability(made.chi_square(np.array([k])), int(count))
        for k, count in enumerate(taken.sum(axis=1))
    ]
    off = np.array([chance is not None and chance < level for chance in chances])
    if 0 < off.sum() <= MAX_OUTLIER_SHARE * len(z):
        kept = ~off
        clean = predict(kept)
    degrees = int(taken[kept].sum()) - 2 * len(set(group[kept].tolist()) - {-1})
    chi_square = clean.chi_square(kept)
    squares, expected = made.errors**2, np.diagonal(made.covariance, axis1=1, axis2=2)
    kinds = np.array([kind for kind, _ in problem.model.columns])
    inside = {kind: taken & (kinds == kind) for kind in dict.fromkeys(kinds.tolist())}
    rms, expectation = (
        {kind: float(np.sqrt(v[some].mean())) for kind, some in inside.items() if some.any()}
        for v in (squares, expected)
    )
    return replace(
        lost,
        rms=rms,
        expected=expectation,
        chi_square=chi_square,
        degrees=degrees,
        p_value=probability(chi_square, degrees),
        outliers=problem.measurements.named(~kept),
    )
