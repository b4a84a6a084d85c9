"""The closed form of the Gluon-6L3's inverse problem, in numbers and as one CasADi function.

With B = A_1^-1 T, w = p - d6 a the wrist's point (a the third column of R), elements [row, column] from 1 as on the page:

    B[3,3] = c5,  B[3,4] = d4 + d6 c5    ->  s1 wx - c1 wy = d4: q1 (two), q5 (two each)
    B[3,1] = s5 c6,  B[3,2] = -s5 s6     ->  q6
    B[1,3] = -c234 s5,  B[2,3] = -s234 s5 ->  t2 + t3 + t4
    B (A_5 A_6)^-1 = A_2 A_3 A_4          ->  a planar two-link: q3 (two), q2, q4

Units: mm, radians. Source: `gluon_6l3`.
"""

from __future__ import annotations

from itertools import product

import casadi as ca
import numpy as np

from gluon_6l3_model import OFFSET, A, D, forward, link, pose_error

CLOSED = 1e-7
"""Largest error of a pose (mm; rotations times the size) that a solution of the closed form may leave."""


def wrap(angles: np.ndarray) -> np.ndarray:
    return (np.asarray(angles) + np.pi) % (2 * np.pi) - np.pi


def shoulders(T: np.ndarray) -> list[float]:
    """q1 from s1 wx - c1 wy = d4: two values, none where w is within d4 of axis 1 (a sine above 1, which the page discards)."""
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
    return B @ np.linalg.inv(link(4, q5) @ link(5, q6)), float(np.arctan2(-sign * B[1, 2], -sign * B[0, 2]))


def closed_form(T: np.ndarray) -> list[np.ndarray]:
    """All real q with forward(q) = T, up to eight; each is put back and verified against the whole pose."""
    found = []
    for q1, q5, q6 in wrists(T):
        for q2, q3, q4 in two_link(*middle(T, (q1, q5, q6))):
            q = wrap(np.array([q1, q2, q3, q4, q5, q6]))
            if pose_error(q, T) < CLOSED:
                found.append(q)
    return found


def closed_form_function() -> ca.Function:
    """T (4 x 4) -> q (6 x 8), one column for each choice of shoulder, wrist and elbow; not a number where it is not real."""
    T = ca.SX.sym("T", 4, 4)
    wx, wy = T[0, 3] - D[5] * T[0, 2], T[1, 3] - D[5] * T[1, 2]
    towards, lean = ca.atan2(wy, wx), ca.asin(D[3] / ca.sqrt(wx**2 + wy**2))
    columns = [_column(T, towards, lean, *choice) for choice in product((1, -1), repeat=3)]
    return ca.Function("closed_form", [T], [ca.horzcat(*columns)], ["T"], ["q"], {"cse": True})


def _column(T: ca.SX, towards: ca.SX, lean: ca.SX, shoulder: int, wrist: int, elbow: int) -> ca.SX:
    q1 = towards + lean if shoulder > 0 else towards + np.pi - lean
    c1, s1 = ca.cos(q1), ca.sin(q1)
    x, y, z = c1 * T[0, :] + s1 * T[1, :], T[2, :] - ca.horzcat(0, 0, 0, D[0]), s1 * T[0, :] - c1 * T[1, :]
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
    """How far each (q1, q5, q6) misses [3,1] and [3,2] of A_1^-1 T; `principal`: q6 by arctan of the quotient."""
    errors = []
    for q1, q5, q6 in wrists(T):
        B = np.linalg.inv(link(0, q1)) @ T
        angle = np.arctan(np.tan(q6)) if principal else q6
        errors.append(float(np.hypot(B[2, 0] - np.sin(q5) * np.cos(angle), B[2, 1] + np.sin(q5) * np.sin(angle))))
    return errors


def wrist_near_axis(distance: float) -> np.ndarray:
    """A pose of the example's rotation whose wrist point is so far from axis 1, at the example's height."""
    T = forward(np.radians(np.full(6, 15.0)))
    wrist = T[:3, 3] - D[5] * T[:3, 2]
    wrist[:2] *= distance / np.linalg.norm(wrist[:2])
    T[:3, 3] = wrist + D[5] * T[:3, 2]
    return T
