"""Geometry of the Gluon-6L3: its DH table, the six matrices that the page prints, symbolic transforms, and the Jacobian.

Notation: standard DH, A_i = Rz(t_i) Tz(d_i) Tx(a_i) Rx(alpha_i), T = A_1 ... A_6. The page writes q_i for the DH angle; here q_i
is the joint value and t_i = q_i + offset_i the DH angle, so that zero joints are the vertical arm. Units: mm, radians.
Source: `gluon_6l3`.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

import symkin
from forward_transform import Chain, Transform, chain_of_dh, forward_transform
from symkin.spatial.screw import exponential, move_screw, revolute_screw

D = (105.03, 0.0, 0.0, 75.66, 80.09, 44.36)
A = (0.0, -174.42, -174.42, 0.0, 0.0, 0.0)
ALPHA = np.radians([90.0, 0.0, 0.0, 90.0, -90.0, 0.0])
OFFSET = np.radians([0.0, -90.0, 0.0, -90.0, 0.0, 0.0])
EXAMPLE = np.radians(np.full(6, 15.0))
"""Joint values of the page's example."""
SIZE = 400.0
"""Reach of the arm in round numbers, mm: makes rotations and lengths comparable."""


# --- forward, in numbers -----------------------------------------------------------------------------------------


def link(i: int, t: float) -> np.ndarray:
    """A_i at the DH angle t, from the table (the page's second listing)."""
    c, s, ca_, sa = np.cos(t), np.sin(t), np.cos(ALPHA[i]), np.sin(ALPHA[i])
    return np.array([[c, -s * ca_, s * sa, A[i] * c], [s, c * ca_, -c * sa, A[i] * s], [0, sa, ca_, D[i]], [0, 0, 0, 1]])


def printed_links(q: np.ndarray) -> list[np.ndarray]:
    """A1 to A6 as the page's first listing prints them, at joint values q."""
    q1, q2, q3, q4, q5, q6 = q + np.array([0, -np.pi / 2, 0, -np.pi / 2, 0, 0])
    d1, d4, d5, d6, a2, a3 = 105.03, 75.66, 80.09, 44.36, -174.42, -174.42
    cos, sin = np.cos, np.sin
    return [
        np.array([[cos(q1), 0, sin(q1), 0], [sin(q1), 0, -cos(q1), 0], [0, 1, 0, d1], [0, 0, 0, 1]]),
        np.array([[cos(q2), -sin(q2), 0, a2 * cos(q2)], [sin(q2), cos(q2), 0, a2 * sin(q2)], [0, 0, 1, 0], [0, 0, 0, 1]]),
        np.array([[cos(q3), -sin(q3), 0, a3 * cos(q3)], [sin(q3), cos(q3), 0, a3 * sin(q3)], [0, 0, 1, 0], [0, 0, 0, 1]]),
        np.array([[cos(q4), 0, sin(q4), 0], [sin(q4), 0, -cos(q4), 0], [0, 1, 0, d4], [0, 0, 0, 1]]),
        np.array([[cos(q5), 0, -sin(q5), 0], [sin(q5), 0, cos(q5), 0], [0, -1, 0, d5], [0, 0, 0, 1]]),
        np.array([[cos(q6), -sin(q6), 0, 0], [sin(q6), cos(q6), 0, 0], [0, 0, 1, d6], [0, 0, 0, 1]]),
    ]


def frames(q: np.ndarray) -> list[np.ndarray]:
    """I, A_1, A_1 A_2, ..., T."""
    chain = [np.eye(4)]
    for i in range(6):
        chain.append(chain[-1] @ link(i, q[i] + OFFSET[i]))
    return chain


def forward(q: np.ndarray) -> np.ndarray:
    return frames(q)[-1]


def printed_forward(q: np.ndarray) -> np.ndarray:
    """T1 = A1*A2*A3*A4*A5*A6 of the page's first listing."""
    return np.asarray(np.linalg.multi_dot(printed_links(q)))


def inverse_by_formula(T: np.ndarray) -> np.ndarray:
    """The inverse of a transform as the page inserts it: (R^T, -R^T p)."""
    R, p = T[:3, :3], T[:3, 3]
    return np.vstack([np.column_stack([R.T, -R.T @ p]), [0, 0, 0, 1]])


def pose_error(q: np.ndarray, T: np.ndarray) -> float:
    """Largest difference of a pose's entries, in mm; those of the rotation count times the arm's size."""
    difference = forward(q) - T
    return float(max(SIZE * np.abs(difference[:3, :3]).max(), np.abs(difference[:3, 3]).max()))


def random_poses(count: int, seed: int) -> list[np.ndarray]:
    """Poses of joint values that are uniform in a turn."""
    rng = np.random.default_rng(seed)
    return [forward(q) for q in rng.uniform(-np.pi, np.pi, (count, 6))]


# --- forward, in symbols -----------------------------------------------------------------------------------------


def symbolic_chain(first: int, last: int) -> Chain:
    """Joints first to last, lengths named d1, a2, ... where the table has one."""
    rows = range(first - 1, last)
    d, a = ([ca.SX.sym(f"{name}{i + 1}") if table[i] else 0 for i in rows] for name, table in (("d", D), ("a", A)))
    return chain_of_dh(d, a, ALPHA[list(rows)], first)


def symbolic_transform(first: int = 1, last: int = 6) -> Transform:
    """A_first ... A_last in sines and cosines of sums of DH angles."""
    return forward_transform(symbolic_chain(first, last))


def numeric_chain() -> Chain:
    """The same with the table's lengths."""
    return chain_of_dh(D, A, ALPHA)


def tool_expression(q: ca.SX) -> ca.SX:
    """T(q), 4 x 4, by the simplified symbolic transform."""
    return forward_transform(numeric_chain()).function()(q + ca.DM(OFFSET))


def product_expression(q: ca.SX) -> ca.SX:
    """T(q) as the plain product of the six matrices, each simplified by its zeros and ones."""
    T = ca.SX.eye(4)
    for i in range(6):
        t, (x, y) = q[i] + OFFSET[i], np.round([np.cos(ALPHA[i]), np.sin(ALPHA[i])])
        c, s = ca.cos(t), ca.sin(t)
        rows = [[c, -s * x, s * y, A[i] * c], [s, c * x, -c * y, A[i] * s], [0, y, x, D[i]], [0, 0, 0, 1]]
        T = ca.mtimes(T, ca.vertcat(*(ca.horzcat(*row) for row in rows)))
    return T


# --- Jacobian ----------------------------------------------------------------------------------------------------


def symbolic_jacobian(arm: symkin.Mechanism) -> tuple[ca.Function, ca.SX]:
    """J(q), 6 x 6, (angular velocity; velocity of the tool point): column i is joint i's screw carried by the joints
    before it in the product of exponentials, and moved to the tool point."""
    q, moved = ca.SX.sym("q", 6), symkin.Pose(ca.SX([0, 0, 0]), ca.SX([1, 0, 0, 0]))
    columns = []
    for k, (_, joint) in enumerate(arm.joints):
        screw = revolute_screw(ca.SX(ca.DM(joint.point)), ca.SX(ca.DM(joint.axis)))
        columns.append(move_screw(moved, screw))
        moved = moved @ exponential(screw, q[k])
    tool = moved.apply(ca.SX(ca.DM(arm.platform_position)))
    J = ca.horzcat(*(ca.vertcat(s[:3], s[3:] + ca.cross(s[:3], tool)) for s in columns))
    return ca.Function("jacobian", [q], [J], ["q"], ["J"]), J


def difference_jacobian(q: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """The same by central differences of the DH product."""
    columns, R = [], forward(q)[:3, :3]
    for k in range(6):
        e = step * np.eye(6)[k]
        dT = (forward(q + e) - forward(q - e)) / (2 * step)
        W = dT[:3, :3] @ R.T
        columns.append([W[2, 1], W[0, 2], W[1, 0], *dT[:3, 3]])
    return np.array(columns).T


def determinant(q: np.ndarray) -> float:
    """det J = -a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234): zero for the elbow stretched, the wrist aligned (axis 6 parallel to axes
    2 to 4), and the meeting point of axes 5 and 6 in the plane of axis 1 that is parallel to axis 2."""
    t = q + OFFSET
    reach = A[1] * np.cos(t[1]) + A[2] * np.cos(t[1] + t[2]) + D[4] * np.sin(t[1] + t[2] + t[3])
    return float(-A[1] * A[2] * np.sin(t[2]) * np.sin(t[4]) * reach)
