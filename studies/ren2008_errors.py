"""Pose errors of a controller, and the frames in which they are told.

An error is the pose that a controller with some parameter values computes from the true rods of an unused pose, less that pose:
position (x, y, z) and angles (alpha, beta, gamma), each in the infinity norm as in the paper, in one of three kinds of frames:

    joint    the paper's frames: those of the fit and of the truth each stand in their own joints
    fitted   frames fitted best to the nominal joints, for the fit and for the truth
    aligned  after the one constant base frame and tool frame that bring the computed poses nearest to the true ones

Units: m, rad inside; mm, deg in errors. Arrays as in `ren2008_model`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ren2008_model import angles_of, direct, inverse, joints_of, turn

FRAMES = ("joint", "fitted", "aligned")
RADIUS = 0.48
"""Radius of the platform's joint circle, m: the arm at which angles count beside positions when frames are aligned."""


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


def pose_errors(found: np.ndarray, eta: np.ndarray, nominal: np.ndarray, tests: np.ndarray) -> dict[str, PoseErrors]:
    """Errors, in the three kinds of frames, of a controller with parameters `found` where the truth is `eta`."""
    ours, truth = frames_of(direct(inverse(tests, eta), found, tests)), frames_of(tests)
    (base, tool), (base_true, tool_true) = (best_frames(own, nominal) for own in (found, eta))
    return {
        "joint": _errors(ours, truth),
        "fitted": _errors(base @ ours @ tool, base_true @ truth @ tool_true),
        "aligned": _errors(aligned(ours, truth), truth),
    }


def best_frames(eta: np.ndarray, nominal: np.ndarray) -> tuple[Frame, Frame]:
    """(W, T): W moves the base joints, T^-1 the platform joints, to the nominal ones as nearly as may be."""
    (m, b, _), (goals_m, goals_b, _) = joints_of(eta), joints_of(nominal)
    return procrustes(b, goals_b), procrustes(m, goals_m).inverse()


def procrustes(points: np.ndarray, goals: np.ndarray) -> Frame:
    """The rigid motion that brings points nearest to goals (Kabsch)."""
    a, b = np.asarray(points, dtype=float), np.asarray(goals, dtype=float)
    u, _, vt = np.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
    R = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ u.T
    return Frame(b.mean(axis=0) - R @ a.mean(axis=0), R)


def aligned(found: Frame, true: Frame, rounds: int = 3) -> Frame:
    """Found poses after the constant base and tool frames that bring them nearest to the true ones, angles weighed by the
    platform circle's radius: Gauss-Newton on small frames W, T in W X T."""
    moved, weight = found, np.tile([1.0] * 3 + [RADIUS] * 3, len(found.t))
    for _ in range(rounds):
        gaps = np.hstack([moved.t - true.t, rotation_vectors(moved.R @ np.swapaxes(true.R, 1, 2))])
        columns = weight[:, None] * _frame_columns(moved)
        step = -np.linalg.lstsq(columns.T @ columns, columns.T @ (weight * gaps.ravel()), rcond=1e-12)[0]
        moved = _small(step[:6]) @ moved @ _small(step[6:])
    return moved


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """angle * axis (n, 3) of turns (n, 3, 3) of less than half a turn."""
    axis = 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(R, axis1=1, axis2=2) - 1))
    return axis * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)[:, None]


def _frame_columns(poses: Frame) -> np.ndarray:
    """d(position, rotation vector) (6 n, 12) by a small base frame (shift, turn) and a small tool frame."""
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
