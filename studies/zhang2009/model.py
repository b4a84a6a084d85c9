"""Geometry of the 6-SPS Gough-Stewart platform, the paper's printed matrices and lines, its
equations (1) to (4), and other unknowns.

Notation: A_i platform joint centres on a circle of 250 mm at 240, 330, 0, 90, 120, 210 degrees, B_i
base joint centres on 275 mm at 270, 300, 30, 60, 150, 180 degrees (both z = 0), L_i the length of
limb i, X = (x, y, z, alpha, beta, gamma); A'_i = (x_i, y_i, z_i) = p + R A_i are the platform joint
centres in the base frame, p = (x, y, z) and R = Rx(alpha) Ry(beta) Rz(gamma) (moving axes). Units:
mm; degrees where printed, radians inside. Source: Zhang Zhaoyin 2009 (see `study`).

The direct problem in 24 unknowns, as references [3] and [4] of the paper have it, and in three,
stands beside its six. The paper says of them only that they solve quadratic equations in 24
unknowns, and its list of references is missing from the copy at hand. The system here is a natural
one of that size: the 18 coordinates of the platform joint centres C_i and the platform's first two
axes n, o, with m = (C_1 + ... + C_6) / 6, the platform's origin since the A_i sum to zero:

    |B_i - C_i|^2 = L_i^2,  i = 1..6
    C_i - m = a_ix n + a_iy o,  i = 1..5
    n.n = o.o = 1,  n.o = 0

6 + 15 + 3 = 24 equations of degree 2 at most. In the three angles alone: f_i - f_1 = 0 are linear
in p. Lengths in radii of the base.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

import symkin
from studies.shared.guesses import CLOSED, Closure, Search
from symkin.spatial.rotation import euler_from_quaternion

PLATFORM_DEG, BASE_DEG = (240, 330, 0, 90, 120, 210), (270, 300, 30, 60, 150, 180)
PLATFORM_RADIUS, BASE_RADIUS = 250.0, 275.0
A = PLATFORM_RADIUS * np.array([[math.cos(t), math.sin(t), 0.0] for t in np.radians(PLATFORM_DEG)])
B = BASE_RADIUS * np.array([[math.cos(t), math.sin(t), 0.0] for t in np.radians(BASE_DEG)])
_A_HALF, _B_HALF = math.sqrt(250**2 - 125**2), math.sqrt(275**2 - 137.5**2)
A_PRINTED = np.array(
    [
        [-125, -_A_HALF, 0],
        [_A_HALF, -125, 0],
        [250, 0, 0],
        [0, 250, 0],
        [-125, _A_HALF, 0],
        [-_A_HALF, -125, 0],
    ]
)
B_PRINTED = np.array(
    [
        [0, -125, 0],
        [137.5, -_B_HALF, 0],
        [_B_HALF, 137.5, 0],
        [137.5, _B_HALF, 0],
        [-_B_HALF, 137.5, 0],
        [-275, 0, 0],
    ]
)
"""The matrices A[6][3] and B[6][3] of section 2.1, as printed."""
B_IN_EQUATIONS = np.array([[0.0, -275.0, 0.0], *B_PRINTED[1:]])
"""The base joint centres as equations (2) have them."""
TABLE_1 = np.array([144.6, 347.0, 110.3, 178.6, 277.6, 269.4])
START = (0.0, 0.0, 100.0, 0.0, 0.0, 0.0)
"""Table 2 is missing: above the base, without rotation, is the start of this study."""
START_NEARBY = (0.0, 0.0, 100.0, 5.0, 5.0, 5.0)
EVIDENT_POSE = (119.0, 88.0, 72.0, 10.0, 21.0, 15.0)
"""Gives table 1 to its last digit: the pose from which the paper computed its example."""
SCALES = np.array([BASE_RADIUS, BASE_RADIUS, BASE_RADIUS, 1.0, 1.0, 1.0])
"""Units of the solvers' unknowns: lengths in radii of the base, angles in rad. Lengths in mm beside
angles in rad would leave IPOPT in local minima more often; Newton's method does not mind.
"""
NAMES = ("x", "y", "z", "alpha", "beta", "gamma")

Numbers = Sequence[float] | np.ndarray


# --- transformation (section 2.2) -----------------------------------------------------------------


def rotation(sines: ca.SX, cosines: ca.SX, *, misprint: bool = False) -> ca.SX:
    """R of the paper's T from the sines and cosines of alpha, beta, gamma; row 3, column 1 is
    printed with s_gamma where c_gamma must stand.
    """
    (sa, sb, sg), (ca_, cb, cg) = ca.vertsplit(sines), ca.vertsplit(cosines)
    return ca.vertcat(
        ca.horzcat(cb * cg, -cb * sg, sb),
        ca.horzcat(sa * sb * cg + ca_ * sg, ca_ * cg - sa * sb * sg, -sa * cb),
        ca.horzcat(
            sa * sg - ca_ * sb * (sg if misprint else cg), ca_ * sb * sg + sa * cg, ca_ * cb
        ),
    )


def rotation_of(angles: np.ndarray) -> np.ndarray:
    """R as numbers, angles in radians."""
    return np.array(ca.DM(rotation(ca.DM(np.sin(angles)), ca.DM(np.cos(angles)))))


def printed_joints(X: ca.SX) -> ca.SX:
    """The 18 lines x_1 to z_6 of section 2.2 as printed, one row for each joint."""
    x, y, z, *angles = ca.vertsplit(X)
    (sa, sb, sg), (ca_, cb, cg) = [ca.sin(a) for a in angles], [ca.cos(a) for a in angles]
    r = _A_HALF
    u, v, w = sa * sb * cg + ca_ * sg, ca_ * cg - sa * sb * sg, sa * sg - ca_ * sb * sg
    t = ca_ * sb * sg + sa * cg
    return ca.vertcat(
        ca.horzcat(-125 * cb * cg + r * cb * sg + x, -125 * u - r * v + y, -125 * w - r * t + z),
        ca.horzcat(r * cb * cg + 125 * cb * sg + x, r * u - 125 * v + y, r * w - 125 * t + z),
        ca.horzcat(250 * cb * cg + x, 250 * u + y, 250 * w + z),
        ca.horzcat(-250 * cb * sg + x, 250 * v + y, 250 * t + z),
        ca.horzcat(-125 * cb * cg - r * cb * sg + x, -125 * u + r * v + y, -125 * w + r * t + z),
        ca.horzcat(-r * cb * cg + 125 * cb * sg + x, -r * u - 125 * v + y, -r * w - 125 * t + z),
    )


def joints(p: ca.SX, R: ca.SX, platform: np.ndarray = A) -> ca.SX:
    """A'_i = p + R A_i, one row for each joint."""
    return ca.vertcat(*((p + ca.mtimes(R, ca.DM(a))).T for a in platform))


# --- equations (1) to (4) -------------------------------------------------------------------------


@dataclass(frozen=True)
class Equations:
    """F, D = dF/dX and the joints for one reading of the paper: its T as printed or right, its B as
    printed or as in (2).
    """

    X: ca.SX
    F: ca.SX
    evaluate: ca.Function
    lengths: ca.Function
    R: ca.Function


def equations(*, misprint: bool = False, base: np.ndarray = B) -> Equations:
    """f_i = |B_i - A'_i|^2 - L_i^2 with the lengths of table 1."""
    X = ca.SX.sym("X", 6)
    R = rotation(ca.sin(X[3:]), ca.cos(X[3:]), misprint=misprint)
    squares = ca.sum2((ca.DM(base) - joints(X[:3], R)) ** 2)
    F = squares - TABLE_1**2
    evaluate = ca.Function("F_D", [X], [F, ca.jacobian(F, X)])
    return Equations(
        X, F, evaluate, ca.Function("L", [X], [ca.sqrt(squares)]), ca.Function("R", [X], [R])
    )


def six_unknowns() -> Closure:
    """Equations (2) over the base's radius squared, in the pose (radii, rad) and the lengths L
    (radii).
    """
    X, L = ca.vertcat(*(ca.SX.sym(name) for name in NAMES)), ca.SX.sym("L", 6)
    R = rotation(ca.sin(X[3:]), ca.cos(X[3:]))
    squares = ca.sum2((ca.DM(B / BASE_RADIUS) - joints(X[:3], R, A / BASE_RADIUS)) ** 2)
    return Closure(X, L, squares - L**2, (False, False, False, True, True, True), 1.0)


def symbols() -> tuple[ca.SX, ca.SX]:
    """The lines of section 2.2 and equations (2) in the paper's letters, for print: A'_i in p,
    s_alpha, c_alpha, ..., and f_i in x_i, y_i, z_i, L_i.
    """
    p = ca.vertcat(*(ca.SX.sym(name) for name in NAMES[:3]))
    sines, cosines = (ca.vertcat(*(ca.SX.sym(f"{f}_{name}") for name in NAMES[3:])) for f in "sc")
    place = ca.vertcat(*(ca.horzcat(*(ca.SX.sym(f"{c}_{i}") for c in "xyz")) for i in range(1, 7)))
    L = ca.vertcat(*(ca.SX.sym(f"L_{i}") for i in range(1, 7)))
    return joints(p, rotation(sines, cosines)), ca.sum2((ca.DM(B) - place) ** 2) - L**2


def jacobian_by_axes(X: np.ndarray) -> np.ndarray:
    """D without differentiation: row i is 2 (A'_i - B_i) . (I | e_k x R A_i), e_k the axes about
    which the angles turn.
    """
    R = rotation_of(X[3:])
    e = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(X[3]), math.sin(X[3])], R[:, 2]])
    arms = A @ R.T
    along = 2.0 * (X[:3] + arms - B)
    return np.hstack(
        [along, np.array([[along[i] @ np.cross(axis, arms[i]) for axis in e] for i in range(6)])]
    )


# --- poses ----------------------------------------------------------------------------------------


def inside(pose: Numbers) -> np.ndarray:
    """Degrees to radians in the last three."""
    return np.concatenate([pose[:3], np.radians(pose[3:])])


def outside(X: np.ndarray) -> np.ndarray:
    """Radians to degrees in (-180, 180] in the last three."""
    return np.concatenate([X[:3], np.degrees(np.arctan2(np.sin(X[3:]), np.cos(X[3:])))])


def scaled(pose: Numbers) -> np.ndarray:
    """A pose in mm and degrees as the solvers' six unknowns."""
    return inside(pose) / SCALES


def same_pose(X: np.ndarray) -> np.ndarray:
    """The angles of the same pose with |beta| <= 90 degrees: (alpha, beta, gamma) is also (alpha +
    180, 180 - beta, gamma + 180).
    """
    turned = (
        X
        if math.cos(X[4]) >= 0
        else np.array([*X[:3], X[3] + math.pi, math.pi - X[4], X[5] + math.pi])
    )
    return np.concatenate([turned[:3], np.arctan2(np.sin(turned[3:]), np.cos(turned[3:]))])


def leg_lengths(system: Equations, pose: Numbers) -> np.ndarray:
    """L_i at a pose in mm and degrees."""
    return np.asarray(system.lengths(inside(pose))).ravel()


def euler_pose(pose: symkin.Pose) -> np.ndarray:
    """x, y, z in mm, alpha, beta, gamma in degrees."""
    return np.concatenate(
        [pose.position, np.degrees(euler_from_quaternion(pose.quaternion, "XYZ"))]
    )


def quaternion_pose(pose: Numbers) -> symkin.Pose:
    return symkin.Pose.from_euler(np.array(pose[:3]), np.radians(pose[3:]), "XYZ")


# --- 24 and three unknowns ------------------------------------------------------------------------

JOINTS, AXES = 18, 6


def named(names: Iterable[str]) -> ca.SX:
    return ca.vertcat(*(ca.SX.sym(name) for name in names))


def quadratic_unknowns() -> Closure:
    """The 24 equations in C_1, ..., C_6, n, o and the lengths L."""
    C, N = (
        named(f"{c}_{i}" for i in range(1, 7) for c in "xyz"),
        named(f"{v}_{c}" for v in "no" for c in "xyz"),
    )
    L = named(f"L_{i}" for i in range(1, 7))
    points, n, o, a = ca.reshape(C, 3, 6), N[:3], N[3:], A / BASE_RADIUS
    middle = ca.sum2(points) / 6
    limbs = [ca.sumsqr(points[:, i] - ca.DM(B[i] / BASE_RADIUS)) - L[i] ** 2 for i in range(6)]
    plane = [points[:, i] - middle - a[i, 0] * n - a[i, 1] * o for i in range(5)]
    frame = [ca.dot(n, n) - 1, ca.dot(o, o) - 1, ca.dot(n, o)]
    return Closure(
        ca.vertcat(C, N), L, ca.vertcat(*limbs, *plane, *frame), (False,) * (JOINTS + AXES), 1.0
    )


def three_unknowns() -> Closure:
    """The angles alone: f_i - f_1 = 0 are linear in p, so that three of them give p(R), and f_5 -
    f_1, f_6 - f_1, f_1 remain.
    """
    angles, L = named(NAMES[3:]), ca.SX.sym("L", 6)
    R = rotation(ca.sin(angles), ca.cos(angles))
    arms = [
        ca.mtimes(R, ca.DM(a / BASE_RADIUS)) - ca.DM(b / BASE_RADIUS)
        for a, b in zip(A, B, strict=True)
    ]
    slopes = ca.horzcat(*(2 * (v - arms[0]) for v in arms[1:])).T
    constants = ca.vertcat(
        *(
            ca.sumsqr(v) - L[i] ** 2 - ca.sumsqr(arms[0]) + L[0] ** 2
            for i, v in enumerate(arms)
            if i
        )
    )
    p = -ca.solve(slopes[:3, :], constants[:3])
    rows = ca.vertcat(
        ca.mtimes(slopes[3:, :], p) + constants[3:], ca.sumsqr(p + arms[0]) - L[0] ** 2
    )
    return Closure(angles, L, rows, (True, True, True), 1.0)


def position_from_angles(angles: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """p from the rotation alone, all five differences f_i - f_1 = 0, linear in p, by least
    squares.
    """
    v = (A @ rotation_of(angles).T - B) / BASE_RADIUS
    constants = np.sum(v * v, axis=1) - np.square(lengths)
    return np.linalg.lstsq(2.0 * (v[1:] - v[0]), constants[0] - constants[1:], rcond=None)[0]


def unknowns_of(X: np.ndarray) -> np.ndarray:
    """The 24 unknowns at a pose (radii, rad)."""
    R = rotation_of(X[3:])
    points = X[:3] + A / BASE_RADIUS @ R.T
    return np.concatenate([points.ravel(), R[:, 0], R[:, 1]])


def pose_of(unknowns: np.ndarray) -> np.ndarray:
    """The pose (radii, rad) of 24 unknowns that close the loops."""
    n, o = unknowns[JOINTS : JOINTS + 3], unknowns[JOINTS + 3 :]
    third = np.cross(n, o)
    angles = (
        math.atan2(-third[1], third[2]),
        math.atan2(third[0], math.hypot(n[0], o[0])),
        math.atan2(-o[0], n[0]),
    )
    return np.array([*unknowns[:JOINTS].reshape(6, 3).mean(axis=0), *angles])


def as_six(search: Search, six: Closure) -> Search:
    """A search in the 24 unknowns whose guesses and ends are poses; an end that does not close all
    24 equations is none.
    """

    def solver(guess: np.ndarray, u: np.ndarray) -> np.ndarray:
        end = np.asarray(search.solver(unknowns_of(guess), u), dtype=float).ravel()
        closed = bool(np.all(np.isfinite(end))) and search.closure.residual(end, u) <= CLOSED
        return pose_of(end) if closed else np.full(6, np.nan)

    return replace(search, closure=six, solver=solver)


def from_angles(search: Search, six: Closure) -> Search:
    """A search in the three angles whose guesses and ends are poses; the guess's position is not
    used.
    """

    def solver(guess: np.ndarray, u: np.ndarray) -> np.ndarray:
        end = np.asarray(search.solver(guess[3:], u), dtype=float).ravel()
        return (
            same_pose(np.array([*position_from_angles(end, u), *end]))
            if np.all(np.isfinite(end))
            else np.full(6, np.nan)
        )

    return replace(search, closure=six, solver=solver)


def to_same_pose(search: Search) -> Search:
    """A search in the six unknowns whose ends have |beta| <= 90 degrees."""

    def solver(guess: np.ndarray, u: np.ndarray) -> np.ndarray:
        end = np.asarray(search.solver(guess, u), dtype=float).ravel()
        return same_pose(end) if np.all(np.isfinite(end)) else end

    return replace(search, solver=solver)


def third_derivative(closure: Closure) -> float:
    """Largest third derivative of the rows at a generic point: zero where they are quadratic."""
    X = closure.X
    second = ca.jacobian(ca.jacobian(closure.F, X), X)
    third = ca.Function("third", [X, closure.u], [ca.jacobian(second, X)])
    point = np.random.default_rng(0).uniform(0.2, 1.0, X.shape[0])
    return float(np.abs(np.asarray(third(point, np.ones(6)))).max())
