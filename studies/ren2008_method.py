"""The paper's experiment in numbers: groups of postures, noise, a fit, and the pose errors that are left in three frames.

raw      the joint frames of the paper: the frames of the fit and of the truth each stand in their own joints
fitted   frames fitted best to the nominal joints, for the fit and for the truth
aligned  after the best constant base and tool frames
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import symkin
from ren2008_tables import TILT, extensions, held_names, pose_at, random_pose
from symkin.calibration.calibrate import Calibration, calibrate
from symkin.calibration.direct import solve_postures
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import build_model
from symkin.model.closure import build_closure
from symkin.spatial.rotation import (
    conjugate,
    euler_from_quaternion,
    multiply,
    quaternion_from_matrix,
    rotation_vector_from_quaternion,
)

FRAMES = ("raw", "fitted", "aligned")
TESTS = 200


@dataclass(frozen=True)
class Precision:
    """Rod noise [m] and repeatability of the inclinometer [deg]; both uniform within +- half of them."""

    rod: float
    inclinometer: float

    @property
    def sigmas(self) -> tuple[float, float]:
        """Standard deviations: m, rad."""
        return self.rod / np.sqrt(12), np.radians(self.inclinometer) / np.sqrt(12)

    def __str__(self) -> str:
        return f"rod {1e6 * self.rod:g} um, inclinometer {self.inclinometer:g} deg"


EXACT = Precision(0.0, 0.0)
BEST = Precision(2e-6, 0.001)


@dataclass(frozen=True, eq=False)
class UnusedPoses:
    """Unused poses of the true mechanism, and the extensions there."""

    poses: list[symkin.Pose]
    joints: np.ndarray


def unused_poses(true: symkin.Mechanism, seed: int, count: int = TESTS) -> UnusedPoses:
    rng = np.random.default_rng([seed, 1])
    poses = [random_pose(true, rng)[0] for _ in range(count)]
    return UnusedPoses(poses, np.array([extensions(true, pose) for pose in poses]))


def random_truth(nominal: symkin.Mechanism, spread: float, rng: np.random.Generator) -> symkin.Mechanism:
    """The nominal geometry with errors uniform within +-spread [m], zero where the frames say so."""
    held = set(held_names(nominal))

    def moved(limb: symkin.RodLimb, key: str) -> tuple[float, ...]:
        values = getattr(limb, key)
        return tuple(
            v + (0.0 if f"{limb.name}.{key}.{k}" in held else rng.uniform(-spread, spread))
            for k, v in zip("xyz", values, strict=True)
        )

    limbs = [
        replace(
            limb, base=moved(limb, "base"), platform=moved(limb, "platform"), offset=limb.offset + rng.uniform(-spread, spread)
        )
        for limb in nominal.limbs
    ]
    return replace(nominal, limbs=limbs)


def inclinations(groups: int, rng: np.random.Generator) -> np.ndarray:
    """(alpha, beta) of the groups: equally spaced over +-20 deg, beta in random order."""
    steps = np.linspace(-TILT, TILT, groups)
    return np.column_stack([steps, rng.permutation(steps)])


def measure(true: symkin.Mechanism, groups: int, each: int, precision: Precision, rng: np.random.Generator) -> Measurements:
    """Groups of random postures, each group brought to one inclination as far as the inclinometer repeats."""
    held = np.repeat(inclinations(groups, rng), each, axis=0)
    half = 0.5 * precision.inclinometer
    poses = [random_pose(true, rng, pair + rng.uniform(-half, half, 2))[0] for pair in held]
    return readings(true, poses, np.repeat(np.arange(groups), each), precision, rng)


def measure_at(
    true: symkin.Mechanism,
    centres: np.ndarray,
    angles: np.ndarray,
    groups: np.ndarray,
    precision: Precision,
    rng: np.random.Generator,
) -> Measurements:
    """Planned postures: circle centres (n, 3) and angles (n, 3) in degrees."""
    half = 0.5 * precision.inclinometer
    tilted = angles + np.column_stack([rng.uniform(-half, half, (len(angles), 2)), np.zeros(len(angles))])
    poses = [pose_at(c, a) for c, a in zip(centres, tilted, strict=True)]
    return readings(true, poses, groups, precision, rng)


def readings(
    true: symkin.Mechanism, poses: Sequence[symkin.Pose], groups: np.ndarray, precision: Precision, rng: np.random.Generator
) -> Measurements:
    """Extensions with rod noise; standard deviations where there is noise."""
    joints = np.array([extensions(true, pose) for pose in poses])
    rod, tilt = precision.sigmas
    noise = rng.uniform(-0.5 * precision.rod, 0.5 * precision.rod, joints.shape)
    return Measurements(joints + noise, groups=groups, joint_sigma=rod or None, group_sigma=tilt or None)


def fit(nominal: symkin.Mechanism, measured: Measurements, residual: str = "means") -> Calibration:
    """The fit in the paper's frames."""
    return calibrate(nominal, measured, fixed=held_names(nominal), residual=residual, outliers="ignore")


def deviation(found: Calibration, true: symkin.Mechanism) -> float:
    """Largest error of the identified parameters [m]."""
    closure = build_closure(true)
    return max(
        abs(found.values[n] - v)
        for n, v in zip(closure.parameter_names, closure.parameter_values, strict=True)
        if n in found.values
    )


# --- pose errors -------------------------------------------------------------------------------------------------


def direct(nominal: symkin.Mechanism, values: dict[str, float], tests: UnusedPoses) -> list[symkin.Pose]:
    """Poses that a controller with these parameter values computes from the true extensions."""
    names = tuple(build_closure(nominal).parameter_names)
    starts = np.array([[*pose.position, *pose.quaternion] for pose in tests.poses])
    measured = Measurements(tests.joints, starts=starts)
    model = build_model(nominal, measured, names)
    p = np.array([values.get(n, v) for n, v in zip(names, model.nominal, strict=True)])
    solved = solve_postures(model, measured, p)
    if not solved.solved.all():
        raise SystemExit(f"{int((~solved.solved).sum())} test poses have no solution")
    return [symkin.Pose(row[:3], row[3:]) for row in model.poses(solved.z, p)]


@dataclass(frozen=True)
class PoseErrors:
    """Largest infinity norms over the test poses: mm, deg."""

    position: float
    angle: float


def pose_errors(
    nominal: symkin.Mechanism, true: symkin.Mechanism, values: dict[str, float], tests: UnusedPoses
) -> dict[str, PoseErrors]:
    """Errors in the three kinds of frames."""
    found = direct(nominal, values, tests)
    raw = [_gap(a, b) for a, b in zip(found, tests.poses, strict=True)]
    estimated = with_values(nominal, values)
    ours, theirs = best_frames(estimated, nominal), best_frames(true, nominal)
    pairs = [(ours[0] @ a @ ours[1], theirs[0] @ b @ theirs[1]) for a, b in zip(found, tests.poses, strict=True)]
    return {
        "raw": _largest(np.array(raw)),
        "fitted": _largest(np.array([_gap(a, b) for a, b in pairs])),
        "aligned": _largest(aligned(found, tests.poses)),
    }


def with_values(nominal: symkin.Mechanism, values: dict[str, float]) -> symkin.Mechanism:
    """The mechanism of identified values."""
    from symkin.calibration.corrected import with_parameters

    return with_parameters(nominal, values)


def best_frames(mechanism: symkin.Mechanism, nominal: symkin.Mechanism) -> tuple[symkin.Pose, symkin.Pose]:
    """(W, T): W moves the base joints, T^-1 the platform joints, to the nominal ones as nearly as may be."""
    base, platform = (
        procrustes([getattr(x, key) for x in mechanism.limbs], [getattr(x, key) for x in nominal.limbs])
        for key in ("base", "platform")
    )
    return base, platform.inverse()


def procrustes(points: list, goals: list) -> symkin.Pose:
    """The rigid motion that brings points nearest to goals (Kabsch)."""
    a, b = np.array(points, dtype=float), np.array(goals, dtype=float)
    u, _, vt = np.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = vt.T @ turn @ u.T
    return symkin.Pose(b.mean(axis=0) - rotation @ a.mean(axis=0), quaternion_from_matrix(rotation))


def aligned(found: Sequence[symkin.Pose], true: Sequence[symkin.Pose], rounds: int = 3) -> np.ndarray:
    """Errors (n, 6) of found poses after the constant base and tool frames that make them least, angles weighed by the
    platform circle's radius: Gauss-Newton on small frames W, T in W X T."""
    moved, radius = list(found), 0.48
    for _ in range(rounds):
        gaps = np.array([_gap(a, b) for a, b in zip(moved, true, strict=True)])
        rows = np.concatenate([_frame_columns(pose) for pose in moved])
        weight = np.tile([1.0] * 3 + [radius] * 3, len(moved))
        step = -np.linalg.lstsq(weight[:, None] * rows, weight * gaps.ravel(), rcond=1e-10)[0]
        base, tool = _small(step[:6]), _small(step[6:])
        moved = [base @ pose @ tool for pose in moved]
    return np.array([_gap(a, b) for a, b in zip(moved, true, strict=True)])


def _gap(a: symkin.Pose, b: symkin.Pose) -> np.ndarray:
    """Position and rotation vector (base frame) of a less b."""
    turn = rotation_vector_from_quaternion(multiply(a.quaternion, conjugate(b.quaternion)))
    return np.concatenate([np.asarray(a.position) - np.asarray(b.position), np.asarray(turn)])


def _frame_columns(pose: symkin.Pose) -> np.ndarray:
    """d(position, rotation vector) (6, 12) by a small base frame (shift, turn) and a small tool frame."""
    x, y, z = np.asarray(pose.position)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    zero, one, r = np.zeros((3, 3)), np.eye(3), np.asarray(pose.rotation)
    return np.vstack([np.hstack([one, -cross, r, zero]), np.hstack([zero, one, zero, r])])


def _small(step: np.ndarray) -> symkin.Pose:
    from symkin.spatial.rotation import quaternion_from_rotation_vector

    return symkin.Pose(step[:3], quaternion_from_rotation_vector(step[3:]))


def _largest(gaps: np.ndarray) -> PoseErrors:
    return PoseErrors(1e3 * float(np.abs(gaps[:, :3]).max()), float(np.degrees(np.abs(gaps[:, 3:]).max())))


def angles_of(pose: symkin.Pose) -> np.ndarray:
    """(alpha, beta, gamma) in degrees."""
    return np.degrees(euler_from_quaternion(np.asarray(pose.quaternion), "xyz"))
