"""Geometry of the 3-TRT + SPS platform, its inverse problem, and the direct problem in closed form
and as equations (6).

Notation: a_i, c_i corners of the base (side 240 mm) and platform (120 mm) triangles at -90, 30, 150
degrees; the platform stays level, X = (Xp, Yp, Zp, gamma); theta_i direction of limb i seen from
above, l_op = |OP|; limb = links 70 + 70 mm. Units: mm; degrees where printed, radians inside.
Source: Zhao Tieshi et al. 2000 (see `study`).
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from studies.shared.guesses import Closure

CORNERS = np.array([[math.cos(t), math.sin(t)] for t in np.radians([-90.0, 30.0, 150.0])])
BASE, PLATFORM, LINK = 240.0 / math.sqrt(3) * CORNERS, 120.0 / math.sqrt(3) * CORNERS, 70.0
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
TABLE_1 = (
    ((0.0, 0.0, 100.0, 0.0), (90.0, 210.0, 330.0, 100.0)),
    ((5.0, 5.0, 105.0, 5.0), (81.6, 202.8, 330.6, 105.2)),
)
INPUT = TABLE_1[1][1]
PAPER_POSES = tuple(
    (x, y, s * z, g)
    for x, y, z, g in ((4.95, 5.01, 104.96, 5.02), (-3.85, 23.60, 102.45, 14.99))
    for s in (1, -1)
)
SIZE = 240.0
"""Side of the base triangle, mm: rows and residuals are judged against it."""
STARTING_POSE = (0.0, 0.0, 100.0, 0.0)
"""The paper's initial position: first row of table 1."""


# --- geometry, inverse problem --------------------------------------------------------------------


def turned(points: np.ndarray, gamma: float) -> np.ndarray:
    """Rz(gamma) on rows (x, y)."""
    return math.cos(gamma) * points + math.sin(gamma) * points @ QUARTER.T


def corners(pose) -> np.ndarray:
    """C_i, rows (x, y, z), of a pose with gamma in degrees."""
    flat = np.array(pose[:2]) + turned(PLATFORM, math.radians(pose[3]))
    return np.column_stack([flat, np.full(3, pose[2])])


def inverse(pose, base: np.ndarray = BASE, flip: float = 1.0) -> np.ndarray:
    """theta_1, theta_2, theta_3 in [0, 360), l_op; `flip` scales the platform."""
    flat = np.array(pose[:2]) + turned(flip * PLATFORM, math.radians(pose[3])) - base
    return np.array(
        [*np.degrees(np.arctan2(flat[:, 1], flat[:, 0])) % 360.0, math.hypot(*pose[:3])]
    )


def limb_lengths(pose) -> np.ndarray:
    """|a_i C_i|: at most 140 mm for links of 70 + 70."""
    return np.linalg.norm(corners(pose) - np.column_stack([BASE, np.zeros(3)]), axis=1)


def normals(theta) -> np.ndarray:
    return np.column_stack([-np.sin(np.radians(theta)), np.cos(np.radians(theta))])


def line_misses(pose, theta=INPUT[:3]) -> np.ndarray:
    """Signed distances of C_i from the vertical planes of the limbs."""
    return np.sum(normals(theta) * (corners(pose)[:, :2] - BASE), axis=1)


# --- direct problem, three ways -------------------------------------------------------------------


def coefficients(theta, platform: np.ndarray = PLATFORM) -> np.ndarray:
    """A, B, C of the equation in gamma."""
    n = normals(theta)
    w = np.array([np.linalg.det(n[[1, 2]]), np.linalg.det(n[[2, 0]]), np.linalg.det(n[[0, 1]])])
    return np.array([w @ np.sum(n * v, axis=1) for v in (platform @ QUARTER.T, platform, -BASE)])


def position(theta, gamma: float, lines=(0, 1, 2), platform: np.ndarray = PLATFORM) -> np.ndarray:
    """Xp, Yp from two of the lines, or all three, which agree at a root gamma (radians)."""
    n, rows = normals(theta), list(lines)
    right = np.sum(n * (BASE - turned(platform, gamma)), axis=1)
    return np.linalg.lstsq(n[rows], right[rows], rcond=None)[0]


def closed_form(given) -> list[np.ndarray]:
    """All poses (gamma in degrees), up to four."""
    theta, length = given[:3], given[3]
    A, B, C = coefficients(theta)
    poses = []
    for turn in math.acos(-C / math.hypot(A, B)) * np.array([-1.0, 1.0]):
        gamma = math.remainder(math.atan2(A, B) + turn, 2 * math.pi)
        x, y = position(theta, gamma)
        z = math.sqrt(length**2 - x * x - y * y)
        poses += [np.array([x, y, s * z, math.degrees(gamma)]) for s in (1, -1)]
    return sorted(poses, key=lambda p: (abs(p[3]), -p[2]))


def closure() -> Closure:
    """X = (Xp, Yp, Zp, gamma), inputs u = (theta, l_op), and the paper's equations (6), each in mm:
    lines written without tan, and (|P|^2 - l_op^2) / l_op.
    """
    X = ca.vertcat(*(ca.SX.sym(name) for name in ("Xp", "Yp", "Zp", "gamma")))
    u = ca.vertcat(*(ca.SX.sym(name) for name in ("theta1", "theta2", "theta3", "l_op")))
    s, c = ca.sin(X[3]), ca.cos(X[3])
    rows = []
    for i in range(3):
        (cx, cy), (ax, ay) = PLATFORM[i], BASE[i]
        across, along = X[0] + c * cx - s * cy - ax, X[1] + s * cx + c * cy - ay
        rows.append(ca.cos(u[i]) * along - ca.sin(u[i]) * across)
    F = ca.vertcat(*rows, (ca.sumsqr(X[:3]) - u[3] ** 2) / u[3])
    return Closure(X, u, F, (False, False, False, True), SIZE)


def inside(given) -> np.ndarray:
    """Inputs with their angles in radians."""
    return np.array([*np.radians(given[:3]), given[3]])
