"""Geometry of the Gluon-6L3: its DH table, the six matrices that the page prints, its Jacobian, and
the closed form.

Notation: standard DH, A_i = Rz(t_i) Tz(d_i) Tx(a_i) Rx(alpha_i), T = A_1 ... A_6. The page writes
q_i for the DH angle; here q_i is the joint value and t_i = q_i + offset_i the DH angle, so that
zero joints are the vertical arm. Units: mm, radians. Source: see `study`.

The closed form of the inverse problem, in numbers and as one CasADi function: with B = A_1^-1 T,
w = p - d6 a the wrist's point (a the third column of R), elements [row, column] from 1 as on the
page:

    B[3,3] = c5,  B[3,4] = d4 + d6 c5    ->  s1 wx - c1 wy = d4: q1 (two), q5 (two each)
    B[3,1] = s5 c6,  B[3,2] = -s5 s6     ->  q6
    B[1,3] = -c234 s5,  B[2,3] = -s234 s5 ->  t2 + t3 + t4
    B (A_5 A_6)^-1 = A_2 A_3 A_4          ->  a planar two-link: q3 (two), q2, q4
"""

from __future__ import annotations

from itertools import product

import casadi as ca
import numpy as np

import symkin
from studies.gluon_6l3.forward_transform import Chain, Transform, chain_of_dh, forward_transform
from studies.shared.screws import exponential, move_screw
from symkin.spatial.screw import revolute_screw

D = (105.03, 0.0, 0.0, 75.66, 80.09, 44.36)
A = (0.0, -174.42, -174.42, 0.0, 0.0, 0.0)
ALPHA = np.radians([90.0, 0.0, 0.0, 90.0, -90.0, 0.0])
OFFSET = np.radians([0.0, -90.0, 0.0, -90.0, 0.0, 0.0])
EXAMPLE = np.radians(np.full(6, 15.0))
"""Joint values of the page's example."""
SIZE = 400.0
"""Reach of the arm in round numbers, mm: makes rotations and lengths comparable."""


# --- forward, in numbers --------------------------------------------------------------------------


def link(i: int, t: float) -> np.ndarray:
    """A_i at the DH angle t, from the table (the page's second listing)."""
    c, s, ca_, sa = np.cos(t), np.sin(t), np.cos(ALPHA[i]), np.sin(ALPHA[i])
    return np.array(
        [
            [c, -s * ca_, s * sa, A[i] * c],
            [s, c * ca_, -c * sa, A[i] * s],
            [0, sa, ca_, D[i]],
            [0, 0, 0, 1],
        ]
    )


def printed_links(q: np.ndarray) -> list[np.ndarray]:
    """A1 to A6 as the page's first listing prints them, at joint values q."""
    q1, q2, q3, q4, q5, q6 = q + np.array([0, -np.pi / 2, 0, -np.pi / 2, 0, 0])
    d1, d4, d5, d6, a2, a3 = 105.03, 75.66, 80.09, 44.36, -174.42, -174.42
    cos, sin = np.cos, np.sin
    return [
        np.array(
            [[cos(q1), 0, sin(q1), 0], [sin(q1), 0, -cos(q1), 0], [0, 1, 0, d1], [0, 0, 0, 1]]
        ),
        np.array(
            [
                [cos(q2), -sin(q2), 0, a2 * cos(q2)],
                [sin(q2), cos(q2), 0, a2 * sin(q2)],
                [0, 0, 1, 0],
                [0, 0, 0, 1],
            ]
        ),
        np.array(
            [
                [cos(q3), -sin(q3), 0, a3 * cos(q3)],
                [sin(q3), cos(q3), 0, a3 * sin(q3)],
                [0, 0, 1, 0],
                [0, 0, 0, 1],
            ]
        ),
        np.array(
            [[cos(q4), 0, sin(q4), 0], [sin(q4), 0, -cos(q4), 0], [0, 1, 0, d4], [0, 0, 0, 1]]
        ),
        np.array(
            [[cos(q5), 0, -sin(q5), 0], [sin(q5), 0, cos(q5), 0], [0, -1, 0, d5], [0, 0, 0, 1]]
        ),
        np.array(
            [[cos(q6), -sin(q6), 0, 0], [sin(q6), cos(q6), 0, 0], [0, 0, 1, d6], [0, 0, 0, 1]]
        ),
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
    """Largest difference of a pose's entries, in mm; those of the rotation count times the arm's
    size.
    """
    difference = forward(q) - T
    return float(max(SIZE * np.abs(difference[:3, :3]).max(), np.abs(difference[:3, 3]).max()))


def random_poses(count: int, seed: int) -> list[np.ndarray]:
    """Poses of joint values that are uniform in a turn."""
    rng = np.random.default_rng(seed)
    return [forward(q) for q in rng.uniform(-np.pi, np.pi, (count, 6))]


# --- forward, in symbols --------------------------------------------------------------------------


def symbolic_chain(first: int, last: int) -> Chain:
    """Joints first to last, lengths named d1, a2, ... where the table has one."""
    rows = range(first - 1, last)
    d, a = (
        [ca.SX.sym(f"{name}{i + 1}") if table[i] else 0 for i in rows]
        for name, table in (("d", D), ("a", A))
    )
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
    """Multiply the six matrices to T(q) without sums of angles, each simplified by its zeros and
    ones.
    """
    T = ca.SX.eye(4)
    for i in range(6):
        t, (x, y) = q[i] + OFFSET[i], np.round([np.cos(ALPHA[i]), np.sin(ALPHA[i])])
        c, s = ca.cos(t), ca.sin(t)
        rows = [
            [c, -s * x, s * y, A[i] * c],
            [s, c * x, -c * y, A[i] * s],
            [0, y, x, D[i]],
            [0, 0, 0, 1],
        ]
        T = ca.mtimes(T, ca.vertcat(*(ca.horzcat(*row) for row in rows)))
    return T


# --- Jacobian -------------------------------------------------------------------------------------


def symbolic_jacobian(arm: symkin.Mechanism) -> tuple[ca.Function, ca.SX]:
    """J(q), 6 x 6, (angular velocity; velocity of the tool point): column i is joint i's screw
    carried by the joints before it in the product of exponentials, and moved to the tool point.
    """
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
    """det J = -a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234): zero for the elbow stretched, the wrist
    aligned (axis 6 parallel to axes 2 to 4), and the meeting point of axes 5 and 6 in the plane of
    axis 1 that is parallel to axis 2.
    """
    t = q + OFFSET
    reach = A[1] * np.cos(t[1]) + A[2] * np.cos(t[1] + t[2]) + D[4] * np.sin(t[1] + t[2] + t[3])
    return float(-A[1] * A[2] * np.sin(t[2]) * np.sin(t[4]) * reach)


# --- closed form of the inverse problem -----------------------------------------------------------

CLOSED = 1e-7
"""Largest error of a pose (mm; rotations times the size) that a solution of the closed form may
leave.
"""


def wrap(angles: np.ndarray) -> np.ndarray:
    return (np.asarray(angles) + np.pi) % (2 * np.pi) - np.pi


def shoulders(T: np.ndarray) -> list[float]:
    """q1 from s1 wx - c1 wy = d4: two values, none where w is within d4 of axis 1 (a sine above 1,
    which the page discards).
    """
    wx, wy = T[:2, 3] - D[5] * T[:2, 2]
    ratio = D[3] / np.hypot(wx, wy)
    if ratio > 1.0:
        return []
    return [np.arctan2(wy, wx) + np.arcsin(ratio), np.arctan2(wy, wx) + np.pi - np.arcsin(ratio)]


def wrists(T: np.ndarray) -> list[tuple[float, float, float]]:
    """(q1, q5, q6), up to four."""
    found = []
    for q1 in shoulders(T):
        B = np.linalg.inv(link(0, q1)) @ T
        for q5 in np.arccos(np.clip(B[2, 2], -1, 1)) * np.array([1, -1]):
            sign = np.sign(q5) or 1.0
            found.append((q1, float(q5), float(np.arctan2(-sign * B[2, 1], sign * B[2, 0]))))
    return found


def two_link(M: np.ndarray, t234: float) -> list[tuple[float, float, float]]:
    """(q2, q3, q4) with A_2 A_3 A_4 = M: elbow up and down, none out of reach."""
    x, y = M[0, 3], M[1, 3]
    c3 = (x * x + y * y - A[1] ** 2 - A[2] ** 2) / (2 * A[1] * A[2])
    if abs(c3) > 1.0:
        return []
    found = []
    for t3 in (np.arccos(c3), -np.arccos(c3)):
        t2 = np.arctan2(y, x) - np.arctan2(A[2] * np.sin(t3), A[1] + A[2] * c3)
        found.append((t2 - OFFSET[1], t3 - OFFSET[2], t234 - t2 - t3 - OFFSET[3]))
    return found


def middle(T: np.ndarray, wrist: tuple[float, float, float]) -> tuple[np.ndarray, float]:
    """A_2 A_3 A_4 and t2 + t3 + t4 for one (q1, q5, q6)."""
    q1, q5, q6 = wrist
    B, sign = np.linalg.inv(link(0, q1)) @ T, np.sign(q5) or 1.0
    return B @ np.linalg.inv(link(4, q5) @ link(5, q6)), float(
        np.arctan2(-sign * B[1, 2], -sign * B[0, 2])
    )


def closed_form(T: np.ndarray) -> list[np.ndarray]:
    """All real q with forward(q) = T, up to eight; each is put back and verified against the whole
    pose.
    """
    found = []
    for q1, q5, q6 in wrists(T):
        for q2, q3, q4 in two_link(*middle(T, (q1, q5, q6))):
            q = wrap(np.array([q1, q2, q3, q4, q5, q6]))
            if pose_error(q, T) < CLOSED:
                found.append(q)
    return found


def closed_form_function() -> ca.Function:
    """T (4 x 4) -> q (6 x 8), one column for each choice of shoulder, wrist and elbow; not a number
    where it is not real.
    """
    T = ca.SX.sym("T", 4, 4)
    wx, wy = T[0, 3] - D[5] * T[0, 2], T[1, 3] - D[5] * T[1, 2]
    towards, lean = ca.atan2(wy, wx), ca.asin(D[3] / ca.sqrt(wx**2 + wy**2))
    columns = [_column(T, towards, lean, *choice) for choice in product((1, -1), repeat=3)]
    return ca.Function("closed_form", [T], [ca.horzcat(*columns)], ["T"], ["q"], {"cse": True})


def _column(T: ca.SX, towards: ca.SX, lean: ca.SX, shoulder: int, wrist: int, elbow: int) -> ca.SX:
    q1 = towards + lean if shoulder > 0 else towards + np.pi - lean
    c1, s1 = ca.cos(q1), ca.sin(q1)
    x, y, z = (
        c1 * T[0, :] + s1 * T[1, :],
        T[2, :] - ca.horzcat(0, 0, 0, D[0]),
        s1 * T[0, :] - c1 * T[1, :],
    )
    q5, q6 = wrist * ca.acos(z[2]), ca.atan2(-wrist * z[1], wrist * z[0])
    t234 = ca.atan2(-wrist * y[2], -wrist * x[2])
    px = x[3] - D[5] * x[2] - D[4] * ca.sin(t234)
    py = y[3] - D[5] * y[2] + D[4] * ca.cos(t234)
    c3 = (px**2 + py**2 - A[1] ** 2 - A[2] ** 2) / (2 * A[1] * A[2])
    t3 = elbow * ca.acos(c3)
    t2 = ca.atan2(py, px) - ca.atan2(A[2] * ca.sin(t3), A[1] + A[2] * c3)
    return ca.vertcat(q1, t2, t3, t234 - t2 - t3, q5, q6) - ca.DM(OFFSET)


def real_columns(q: np.ndarray) -> list[np.ndarray]:
    """The columns that are numbers, in (-pi, pi]."""
    return [wrap(column) for column in np.asarray(q).T if np.all(np.isfinite(column))]


def third_row_errors(T: np.ndarray, *, principal: bool) -> list[float]:
    """How far each (q1, q5, q6) misses [3,1] and [3,2] of A_1^-1 T; `principal`: q6 by arctan of
    the quotient.
    """
    errors = []
    for q1, q5, q6 in wrists(T):
        B = np.linalg.inv(link(0, q1)) @ T
        angle = np.arctan(np.tan(q6)) if principal else q6
        errors.append(
            float(
                np.hypot(B[2, 0] - np.sin(q5) * np.cos(angle), B[2, 1] + np.sin(q5) * np.sin(angle))
            )
        )
    return errors


def wrist_near_axis(distance: float) -> np.ndarray:
    """A pose of the example's rotation whose wrist point is so far from axis 1, at the example's
    height.
    """
    T = forward(np.radians(np.full(6, 15.0)))
    wrist = T[:3, 3] - D[5] * T[:3, 2]
    wrist[:2] *= distance / np.linalg.norm(wrist[:2])
    T[:3, 3] = wrist + D[5] * T[:3, 2]
    return T
