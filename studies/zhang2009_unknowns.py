"""The direct problem in 24 unknowns, as references [3] and [4] of the paper have it, and in three, beside its six.

The paper says of them only that they solve quadratic equations in 24 unknowns, and its list of references is missing from
the copy at hand. The system here is a natural one of that size: the 18 coordinates of the platform joint centres C_i and the
platform's first two axes n, o, with m = (C_1 + ... + C_6) / 6, the platform's origin since the A_i sum to zero:

    |B_i - C_i|^2 = L_i^2,  i = 1..6      C_i - m = a_ix n + a_iy o,  i = 1..5      n.n = o.o = 1,  n.o = 0

6 + 15 + 3 = 24 equations of degree 2 at most. In the three angles alone: f_i - f_1 = 0 are linear in p. Lengths in radii of the
base.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import casadi as ca
import numpy as np

from guesses import CLOSED, Closure, Search
from zhang2009_model import BASE_RADIUS, NAMES, A, B, rotation, rotation_of, same_pose

JOINTS, AXES = 18, 6


def named(names: Iterable[str]) -> ca.SX:
    return ca.vertcat(*(ca.SX.sym(name) for name in names))


def quadratic_unknowns() -> Closure:
    """The 24 equations in C_1, ..., C_6, n, o and the lengths L."""
    C, N = named(f"{c}_{i}" for i in range(1, 7) for c in "xyz"), named(f"{v}_{c}" for v in "no" for c in "xyz")
    L = named(f"L_{i}" for i in range(1, 7))
    points, n, o, a = ca.reshape(C, 3, 6), N[:3], N[3:], A / BASE_RADIUS
    middle = ca.sum2(points) / 6
    limbs = [ca.sumsqr(points[:, i] - ca.DM(B[i] / BASE_RADIUS)) - L[i] ** 2 for i in range(6)]
    plane = [points[:, i] - middle - a[i, 0] * n - a[i, 1] * o for i in range(5)]
    frame = [ca.dot(n, n) - 1, ca.dot(o, o) - 1, ca.dot(n, o)]
    return Closure(ca.vertcat(C, N), L, ca.vertcat(*limbs, *plane, *frame), (False,) * (JOINTS + AXES), 1.0)


def three_unknowns() -> Closure:
    """The angles alone: f_i - f_1 = 0 are linear in p, so that three of them give p(R), and f_5 - f_1, f_6 - f_1, f_1 remain."""
    angles, L = named(NAMES[3:]), ca.SX.sym("L", 6)
    R = rotation(ca.sin(angles), ca.cos(angles))
    arms = [ca.mtimes(R, ca.DM(a / BASE_RADIUS)) - ca.DM(b / BASE_RADIUS) for a, b in zip(A, B, strict=True)]
    slopes = ca.horzcat(*(2 * (v - arms[0]) for v in arms[1:])).T
    constants = ca.vertcat(*(ca.sumsqr(v) - L[i] ** 2 - ca.sumsqr(arms[0]) + L[0] ** 2 for i, v in enumerate(arms) if i))
    p = -ca.solve(slopes[:3, :], constants[:3])
    rows = ca.vertcat(ca.mtimes(slopes[3:, :], p) + constants[3:], ca.sumsqr(p + arms[0]) - L[0] ** 2)
    return Closure(angles, L, rows, (True, True, True), 1.0)


def position_from_angles(angles: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """p from the rotation alone, all five differences f_i - f_1 = 0, linear in p, by least squares."""
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
    angles = math.atan2(-third[1], third[2]), math.atan2(third[0], math.hypot(n[0], o[0])), math.atan2(-o[0], n[0])
    return np.array([*unknowns[:JOINTS].reshape(6, 3).mean(axis=0), *angles])


def as_six(search: Search, six: Closure) -> Search:
    """A search in the 24 unknowns whose guesses and ends are poses; an end that does not close all 24 equations is none."""

    def solver(guess: np.ndarray, u: np.ndarray) -> np.ndarray:
        end = np.asarray(search.solver(unknowns_of(guess), u), dtype=float).ravel()
        closed = bool(np.all(np.isfinite(end))) and search.closure.residual(end, u) <= CLOSED
        return pose_of(end) if closed else np.full(6, np.nan)

    return replace(search, closure=six, solver=solver)


def from_angles(search: Search, six: Closure) -> Search:
    """A search in the three angles whose guesses and ends are poses; the guess's position is not used."""

    def solver(guess: np.ndarray, u: np.ndarray) -> np.ndarray:
        end = np.asarray(search.solver(guess[3:], u), dtype=float).ravel()
        return same_pose(np.array([*position_from_angles(end, u), *end])) if np.all(np.isfinite(end)) else np.full(6, np.nan)

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
