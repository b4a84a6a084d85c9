"""Errors of the poses that a controller computes, in named frames, and their rows before
calibration (2).

An error is the pose that a controller with some parameter values computes from the true rods of an
unused pose, less that pose: position (x, y, z) and angles (alpha, beta, gamma), each in the
infinity norm as in the paper, in one of three kinds of frames:

    joint    the paper's frames: those of the fit and of the truth each stand in their own joints
    fitted   frames fitted best to the nominal joints, for the fit and for the truth
    aligned  after the one constant base frame and tool frame that bring the computed poses nearest
             to the true ones

Units: m, rad inside; mm, deg in errors. Arrays as in `model`. Rows: the simulated machine's tables,
what is assumed, and the errors before calibration in each kind of frames. Source: Ren, Feng, Su
2008, 2 (see `study`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from studies.ren2008.method import inclinations, random_postures, unused_poses
from studies.ren2008.model import (
    ASSUMED,
    NAMES,
    Case,
    angles_of,
    circle,
    direct,
    inverse,
    joints_of,
    turn,
)
from studies.ren2008.model import NOMINAL as TABLE_1
from studies.shared.report import Report

FRAMES = ("joint", "fitted", "aligned")
RADIUS = 0.48
"""Radius of the platform's joint circle, m: the arm at which angles count beside positions when
frames are aligned.
"""


@dataclass(frozen=True, eq=False)
class PoseErrors:
    """Infinity norms at each test pose: mm, deg."""

    positions: np.ndarray
    angles: np.ndarray

    @property
    def worst(self) -> list[float]:
        return [float(self.positions.max()), float(self.angles.max())]

    @property
    def mean(self) -> list[float]:
        return [float(self.positions.mean()), float(self.angles.mean())]


@dataclass(frozen=True, eq=False)
class Frame:
    """Rigid motions: shifts (..., 3) and turns (..., 3, 3)."""

    t: np.ndarray
    R: np.ndarray

    def __matmul__(self, other: Frame) -> Frame:
        return Frame(self.t + (self.R @ other.t[..., None])[..., 0], self.R @ other.R)

    def inverse(self) -> Frame:
        back = np.swapaxes(self.R, -1, -2)
        return Frame(-(back @ self.t[..., None])[..., 0], back)


def frames_of(X: np.ndarray) -> Frame:
    return Frame(X[:, :3], turn(X[:, 3:]))


def pose_errors(
    found: np.ndarray, eta: np.ndarray, nominal: np.ndarray, tests: np.ndarray
) -> dict[str, PoseErrors]:
    """Errors, in the three kinds of frames, of a controller with parameters `found` where the truth
    is `eta`.
    """
    ours, truth = frames_of(direct(inverse(tests, eta), found, tests)), frames_of(tests)
    (base, tool), (base_true, tool_true) = (best_frames(own, nominal) for own in (found, eta))
    return {
        "joint": _errors(ours, truth),
        "fitted": _errors(base @ ours @ tool, base_true @ truth @ tool_true),
        "aligned": _errors(aligned(ours, truth), truth),
    }


def best_frames(eta: np.ndarray, nominal: np.ndarray) -> tuple[Frame, Frame]:
    """(W, T): W moves the base joints, T^-1 the platform joints, to the nominal ones as nearly as
    may be.
    """
    (m, b, _), (goals_m, goals_b, _) = joints_of(eta), joints_of(nominal)
    return procrustes(b, goals_b), procrustes(m, goals_m).inverse()


def procrustes(points: np.ndarray, goals: np.ndarray) -> Frame:
    """The rigid motion that brings points nearest to goals (Kabsch)."""
    a, b = np.asarray(points, dtype=float), np.asarray(goals, dtype=float)
    u, _, vt = np.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
    R = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ u.T
    return Frame(b.mean(axis=0) - R @ a.mean(axis=0), R)


def aligned(found: Frame, true: Frame, rounds: int = 3) -> Frame:
    """Found poses after the constant base and tool frames that bring them nearest to the true ones,
    angles weighed by the platform circle's radius: Gauss-Newton on small frames W, T in W X T.
    """
    moved, weight = found, np.tile([1.0] * 3 + [RADIUS] * 3, len(found.t))
    for _ in range(rounds):
        gaps = np.hstack([moved.t - true.t, rotation_vectors(moved.R @ np.swapaxes(true.R, 1, 2))])
        columns = weight[:, None] * _frame_columns(moved)
        step = -np.linalg.lstsq(
            columns.T @ columns, columns.T @ (weight * gaps.ravel()), rcond=1e-12
        )[0]
        moved = _small(step[:6]) @ moved @ _small(step[6:])
    return moved


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """angle * axis (n, 3) of turns (n, 3, 3) of less than half a turn."""
    axis = 0.5 * np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1
    )
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(R, axis1=1, axis2=2) - 1))
    return axis * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)[:, None]


def _frame_columns(poses: Frame) -> np.ndarray:
    """d(position, rotation vector) (6 n, 12) by a small base frame (shift, turn) and a small tool
    frame.
    """
    columns = np.zeros((len(poses.t), 6, 12))
    columns[:, :3, :3] = columns[:, 3:, 3:6] = np.eye(3)
    columns[:, :3, 3:6] = -cross(poses.t)
    columns[:, :3, 6:9] = columns[:, 3:, 9:] = poses.R
    return columns.reshape(-1, 12)


def cross(v: np.ndarray) -> np.ndarray:
    """The matrices (n, 3, 3) of v x, for rows v."""
    x, y, z = v.T
    o = np.zeros_like(x)
    return np.moveaxis(np.array([[o, -z, y], [z, o, -x], [-y, x, o]]), 2, 0)


def _small(step: np.ndarray) -> Frame:
    """The frame of a shift and a small rotation vector (Rodrigues)."""
    K, angle = cross(step[None, 3:])[0], float(np.linalg.norm(step[3:]))
    R = np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * K @ K
    return Frame(step[:3], R)


def _errors(found: Frame, true: Frame) -> PoseErrors:
    gap = angles_of(found.R) - angles_of(true.R)
    wrapped = np.degrees((gap + np.pi) % (2 * np.pi) - np.pi)
    return PoseErrors(1e3 * np.abs(found.t - true.t).max(axis=1), np.abs(wrapped).max(axis=1))


# --- rows on the machine before calibration -------------------------------------------------------

BEFORE = (9.0, 0.8)
HIDDEN = tuple(product((-0.005, -0.0025, 0.0), (0.0, 0.0025, 0.005)))
"""Values tried of z of M5 and z of B2, m."""
SETS = 3
"""Sets of 200 unused poses over which errors before calibration are taken for each of them."""


def with_hidden(truth: np.ndarray, z_m5: float, z_b2: float) -> np.ndarray:
    """The true parameters with other values of the two illegible entries."""
    other = truth.copy()
    other[NAMES.index("leg5.platform.z")], other[NAMES.index("leg2.base.z")] = z_m5, z_b2
    return other


@dataclass(frozen=True, eq=False)
class Before:
    """Worst errors (choices x sets, 2) before calibration in each frame: mm, deg."""

    worst: dict[str, np.ndarray]

    def range(self, frame: str) -> tuple[np.ndarray, np.ndarray]:
        return self.worst[frame].min(axis=0), self.worst[frame].max(axis=0)


def errors_before(case: Case) -> Before:
    worst: dict[str, list[list[float]]] = {frame: [] for frame in FRAMES}
    for choice, k in product(HIDDEN, range(SETS)):
        truth = with_hidden(case.truth, *choice)
        for frame, errors in pose_errors(
            case.eta, truth, case.eta, unused_poses(truth, case.seed + k)
        ).items():
            worst[frame].append(errors.worst)
    return Before({frame: np.array(rows) for frame, rows in worst.items()})


def report_assumed(report: Report, case: Case) -> None:
    report.row(
        "true values illegible in our copy, assumed: z of M5, z of B2",
        None,
        list(ASSUMED.values()),
        "m",
        place="table 2",
        run="studies/ren2008/model.py",
    )
    for name in ("platform", "base"):
        centre, radius, off = circle(TABLE_1[name])
        report.row(
            f"{name} joint circle: centre x, y, radius, largest departure",
            None,
            [float(centre[0]), float(centre[1]), radius, off],
            "m",
            place="table 1",
            run=circle,
        )
    alphas = np.degrees(inclinations(10, case.rng(20))[:, 0])
    report.row(
        "10 groups: alpha equally spaced over +-20 deg, beta the same in random order",
        [-20, 20],
        [float(alphas[0]), float(alphas[-1])],
        "deg",
        place="2.1",
        run=inclinations,
    )
    poses, drawn = random_postures(case.eta, np.full((2000, 2), np.nan), case.rng(60))
    report.row(
        "workspace, not printed, assumed: share of postures that the rods' range rejects",
        None,
        100 * (1 - len(poses) / drawn),
        "%",
        place="2.1",
        run=random_postures,
    )


def report_before(
    report: Report, case: Case, tests: np.ndarray
) -> tuple[dict[str, PoseErrors], Before]:
    """9 mm and 0.8 deg: in which frames?"""
    report.row(
        "unused poses at which errors are told", 200, len(tests), place="2.2", run=unused_poses
    )
    errors = pose_errors(case.eta, case.truth, case.eta, tests)
    for frame, error in errors.items():
        report.row(
            f"before calibration, {frame} frames, 200 poses: worst",
            None,
            error.worst,
            "mm, deg",
            place="2",
            run=pose_errors,
        )
        report.row(
            f"before calibration, {frame} frames: mean",
            None,
            error.mean,
            "mm, deg",
            place="2",
            run=pose_errors,
        )
    before = errors_before(case)
    for frame in FRAMES:
        low, high = before.range(frame)
        inside = bool(np.all((low <= BEFORE) & (high >= BEFORE)))
        name = (
            f"before calibration, {frame} frames, {len(HIDDEN)} choices of the illegible entries, "
            f"{SETS} sets of 200 poses"
        )
        report.row(
            f"{name}: worst, least and most of them",
            BEFORE,
            [float(low[0]), float(high[0]), float(low[1]), float(high[1])],
            "mm, mm, deg, deg",
            place="2",
            run=errors_before,
            verdict="reproduced" if inside else "differs",
        )
    return errors, before
