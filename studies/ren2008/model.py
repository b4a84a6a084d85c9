"""XJ-HEXAS as its paper prints it, what is assumed where it prints nothing, and its equations for
many postures.

Notation: |t + R m_i - b_i| = dl_i + l_i; m_i platform joints, b_i base joints in the paper's joint
frames, dl_i the fixed rod length, l_i the measured extension; R = Rz(gamma) Ry(beta) Rx(alpha),
turns about fixed axes ('xyz'). Units: m, deg. Source: Ren, Feng, Su, Journal of Xi'an Jiaotong
University 42(12), 2008, tables 1 (nominal), 2 (true), 3 (deviations).

Every entry of table 1 is read. In table 2 two are illegible in our copy and assumed; hidden zeros
are zero by the frames. The workspace is not printed and is assumed: centre of the platform's joint
circle within 0.25 m in x and y of the centre of the base's, z 1.15 to 1.45 m, angles within 20 deg,
extensions 0 to 0.55 m.

The closure of the direct problem, its derivatives, and equations (1), (2) and (8):

    F_i(X; q, eta) = |t + R m_i - b_i| - dl_i - q_i = 0,   i = 1 ... 6,
    X = (x, y, z, alpha, beta, gamma)
    R = Rz(gamma) Ry(beta) Rx(alpha),
    eta = (m_1 ... m_6, b_1 ... b_6, dl_1 ... dl_6), 42 parameters
    (1) X = F(q, eta) is the root, near a start, by Newton's method on all postures at once
    dX/dl = F_X^-1,   dX/deta = -F_X^-1 F_eta
        (the derivatives that (8) wants; the paper takes them numerically)

The extensions, l in the paper, are q here; equations are in m and rad. Arrays have one row a
posture: X (n, 6), q (n, 6).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

import symkin
from studies.shared.guesses import Closure
from symkin.calibration.data.parameters import joint_frames

NOMINAL = {
    "base": [
        (0, 0, 0),
        (0.1504, 0, 0),
        (0.6283, 0.8278, 0),
        (0.5531, 0.958, 0),
        (-0.4027, 0.958, 0),
        (-0.4779, 0.8278, 0),
    ],
    "platform": [
        (0, 0, 0),
        (0.7687, 0, 0),
        (0.8255, 0.0984, 0),
        (0.4412, 0.7642, 0),
        (0.3275, 0.7642, 0),
        (-0.0568, 0.0984, 0),
    ],
    "offset": [1.2] * 6,
}
TRUE = {
    "base": [
        (0, 0, 0),
        (0.1543, 0, 0.0025),
        (0.6233, 0.8256, -0.005),
        (0.5506, 0.9599, 0.003),
        (-0.4068, 0.9549, 0.0049),
        (-0.4761, 0.8251, 0.004),
    ],
    "platform": [
        (0, 0, 0),
        (0.7637, 0, 0),
        (0.8295, 0.0993, 0.002),
        (0.4436, 0.7672, 0.005),
        (0.3233, 0.7612, -0.003),
        (-0.0587, 0.0964, 0),
    ],
    "offset": [1.2037, 1.1981, 1.205, 1.1963, 1.2026, 1.1969],
}
DEVIATIONS = {
    "base": [
        (0, 0, 0),
        (-3.6e-11, 0, -6.6e-12),
        (3.5e-10, 7.1e-10, -7.9e-10),
        (-3.7e-10, 2.1e-10, 1e-11),
        (-2.8e-10, -9.9e-11, -2.3e-10),
        (-3.4e-10, -8.7e-11, 1.8e-10),
    ],
    "platform": [
        (0, 0, 0),
        (-3.6e-11, 0, 0),
        (-1.7e-10, 1.3e-10, 6.1e-10),
        (-1.3e-10, 1.1e-10, 3.2e-10),
        (-6.6e-11, -3.1e-11, -2.4e-10),
        (-1.7e-10, 1.7e-10, 0),
    ],
    "offset": [-1.8e-11, -5.2e-11, -8.6e-11, -5.5e-11, -1.1e-11, -2.4e-10],
}
"""Table 3: identified less true without noise."""
ASSUMED = {"z of M5": -0.0030, "z of B2": 0.0025}
"""The two true values that are illegible: z of M5 is negative, z of B2 positive, each at most 5
mm.
"""
BY_FRAME = ("leg1", "leg2", "leg6"), ("leg1", "leg2")
"""Joints in which the paper's platform and base frames stand: ten entries are zero by
definition.
"""
HEIGHTS, ASIDE, TILT, EXTENSIONS = (1.15, 1.45), 0.25, 20.0, (0.0, 0.55)


def circle(points: list) -> tuple[np.ndarray, float, float]:
    """Centre, radius and largest distance from the circle of points in the xy plane: |x|^2 = 2
    c.x + k.
    """
    xy = np.array(points)[:, :2]
    solution = np.linalg.lstsq(
        np.column_stack([2 * xy, np.ones(len(xy))]), (xy**2).sum(axis=1), rcond=None
    )[0]
    distances = np.linalg.norm(xy - solution[:2], axis=1)
    radius = float(distances.mean())
    return np.append(solution[:2], 0.0), radius, float(np.abs(distances - radius).max())


PLATFORM_CENTRE, BASE_CENTRE = circle(NOMINAL["platform"])[0], circle(NOMINAL["base"])[0]


def held_names(mechanism: symkin.Mechanism) -> tuple[str, ...]:
    """The ten parameters that are zero by the paper's frames."""
    return joint_frames(mechanism, *BY_FRAME)


# --- equations ------------------------------------------------------------------------------------

LIMBS = 6
UNKNOWNS = ("x", "y", "z", "alpha", "beta", "gamma")
NAMES = (
    *(f"leg{i}.platform.{k}" for i in range(1, LIMBS + 1) for k in "xyz"),
    *(f"leg{i}.base.{k}" for i in range(1, LIMBS + 1) for k in "xyz"),
    *(f"leg{i}.offset" for i in range(1, LIMBS + 1)),
)
"""The 42 parameters in the order of eta, by symkin's names."""
SIZE = 1.5
"""About the largest distance of the machine, m: residuals of the closure are judged against it."""
CLOSED = 1e-13
"""|F| [m] at which Newton's method on the closure ends: rounding of lengths of 1.5 m."""


def eta_of(mechanism: symkin.Mechanism) -> np.ndarray:
    """The 42 parameters of a mechanism's file."""
    limbs = mechanism.limbs
    return np.concatenate(
        [*(x.platform for x in limbs), *(x.base for x in limbs), [x.offset for x in limbs]]
    )


def eta_from(values: dict[str, float], nominal: np.ndarray) -> np.ndarray:
    """Identified values, the nominal ones where there are none."""
    return np.array([values.get(name, v) for name, v in zip(NAMES, nominal, strict=True)])


def joints_of(eta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """m (6, 3), b (6, 3), dl (6,)."""
    return eta[:18].reshape(6, 3), eta[18:36].reshape(6, 3), eta[36:]


def free_columns(nominal: symkin.Mechanism) -> np.ndarray:
    """Indices of the 32 parameters that the paper's frames leave."""
    zeros = set(held_names(nominal))
    return np.array([k for k, name in enumerate(NAMES) if name not in zeros])


# --- rotations ------------------------------------------------------------------------------------


def turn(angles: np.ndarray) -> np.ndarray:
    """R = Rz(gamma) Ry(beta) Rx(alpha) (n, 3, 3) of angles (n, 3) in rad."""
    (sa, sb, sc), (ca_, cb, cc) = np.sin(angles).T, np.cos(angles).T
    rows = [
        [cc * cb, cc * sb * sa - sc * ca_, cc * sb * ca_ + sc * sa],
        [sc * cb, sc * sb * sa + cc * ca_, sc * sb * ca_ - cc * sa],
        [-sb, cb * sa, cb * ca_],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def angles_of(rotations: np.ndarray) -> np.ndarray:
    """(alpha, beta, gamma) (n, 3) in rad, beta within a quarter turn."""
    r = rotations
    beta = np.arctan2(-r[:, 2, 0], np.hypot(r[:, 2, 1], r[:, 2, 2]))
    return np.column_stack(
        [np.arctan2(r[:, 2, 1], r[:, 2, 2]), beta, np.arctan2(r[:, 1, 0], r[:, 0, 0])]
    )


def symbolic_turn(angles: ca.SX) -> ca.SX:
    """R of symbols."""
    (sa, sb, sc), (ca_, cb, cc) = (ca.vertsplit(f(angles)) for f in (ca.sin, ca.cos))
    x = ca.vertcat(cc * cb, sc * cb, -sb)
    y = ca.vertcat(cc * sb * sa - sc * ca_, sc * sb * sa + cc * ca_, cb * sa)
    z = ca.vertcat(cc * sb * ca_ + sc * sa, sc * sb * ca_ - cc * sa, cb * ca_)
    return ca.horzcat(x, y, z)


# --- closure --------------------------------------------------------------------------------------


class PoseClosure(Closure):
    """A closure in a pose: two triples of angles are the same mode if their rotations are."""

    def distance(self, X: np.ndarray, mode: np.ndarray) -> float:
        turns = turn(np.array([X[3:], mode[3:]]))
        return float(
            max(np.abs(X[:3] - mode[:3]).max() / self.size, np.abs(turns[0] - turns[1]).max())
        )


def rod_rows(
    X: ca.SX, q: ca.SX, m: np.ndarray | ca.SX, b: np.ndarray | ca.SX, dl: np.ndarray | ca.SX
) -> ca.SX:
    """F of symbols; m and b have a row a limb."""
    R, rows = symbolic_turn(X[3:]), []
    for i in range(LIMBS):
        end = X[:3] + ca.mtimes(R, ca.SX(m[i, :]).reshape((3, 1))) - ca.SX(b[i, :]).reshape((3, 1))
        rows.append(ca.norm_2(end) - dl[i] - q[i])
    return ca.vertcat(*rows)


def closure(eta: np.ndarray) -> PoseClosure:
    """The six rows with numbers for the parameters: unknowns X, given extensions l1 ... l6."""
    X = ca.vertcat(*(ca.SX.sym(name) for name in UNKNOWNS))
    q = ca.vertcat(*(ca.SX.sym(f"l{i}") for i in range(1, LIMBS + 1)))
    return PoseClosure(X, q, rod_rows(X, q, *joints_of(eta)), (False,) * 3 + (True,) * 3, SIZE)


@lru_cache(maxsize=1)
def _function() -> ca.Function:
    """F, F_X, F_eta of (X, q, eta)."""
    X, q, eta = ca.SX.sym("X", 6), ca.SX.sym("q", 6), ca.SX.sym("eta", len(NAMES))
    m, b = (ca.reshape(eta[k : k + 18], 3, 6).T for k in (0, 18))
    F = rod_rows(X, q, m, b, eta[36:])
    return ca.Function(
        "F", [X, q, eta], [F, ca.densify(ca.jacobian(F, X)), ca.densify(ca.jacobian(F, eta))]
    )


@lru_cache(maxsize=64)
def _mapped(count: int) -> ca.Function:
    return _function().map(count)


def rows(
    X: np.ndarray, q: np.ndarray, eta: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """F (n, 6), F_X (n, 6, 6), F_eta (n, 6, 42) of many postures."""
    n = len(X)
    F, by_pose, by_eta = (
        np.asarray(part) for part in _mapped(n)(X.T, q.T, np.repeat(eta[:, None], n, axis=1))
    )
    return (
        F.T,
        by_pose.reshape(6, n, 6).swapaxes(0, 1),
        by_eta.reshape(6, n, len(NAMES)).swapaxes(0, 1),
    )


def inverse(X: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """l_i = |t + R m_i - b_i| - dl_i (n, 6): the inverse problem is a formula."""
    m, b, dl = joints_of(eta)
    ends = X[:, None, :3] + m @ turn(X[:, 3:]).swapaxes(1, 2) - b
    return np.linalg.norm(ends, axis=2) - dl


def direct(q: np.ndarray, eta: np.ndarray, start: np.ndarray, most: int = 50) -> np.ndarray:
    """(1): X (n, 6) for extensions q, by Newton's method from `start` (n, 6). Ends the study where
    a posture has no root.
    """
    X = np.array(start, dtype=float)
    for _ in range(most):
        F, F_X, _ = rows(X, q, eta)
        if np.abs(F).max() < CLOSED:
            return X
        X = X - np.linalg.solve(F_X, F[:, :, None])[:, :, 0]
    left = np.abs(rows(X, q, eta)[0]).max(axis=1)
    if left.max() > 1e3 * CLOSED:
        raise SystemExit(
            f"ren2008: the direct problem of {int((left > 1e3 * CLOSED).sum())} postures was not "
            f"solved"
        )
    return X


@dataclass(frozen=True, eq=False)
class Slopes:
    """dX/dl (n, 6, 6) and dX/deta (n, 6, 42) at roots."""

    by_rods: np.ndarray
    by_eta: np.ndarray


def slopes(X: np.ndarray, q: np.ndarray, eta: np.ndarray) -> Slopes:
    """The implicit function's derivatives at roots X."""
    _, F_X, F_eta = rows(X, q, eta)
    return Slopes(np.linalg.inv(F_X), -np.linalg.solve(F_X, F_eta))


# --- the two geometries ---------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Case:
    """Both geometries, as mechanisms and as parameters, the free parameters, and the home
    posture.
    """

    nominal: symkin.Mechanism
    true: symkin.Mechanism
    seed: int

    @property
    def eta(self) -> np.ndarray:
        return eta_of(self.nominal)

    @property
    def truth(self) -> np.ndarray:
        return eta_of(self.true)

    @property
    def free(self) -> np.ndarray:
        return free_columns(self.nominal)

    @property
    def home(self) -> np.ndarray:
        pose = self.nominal.reference_pose
        return np.concatenate([pose.position, angles_of(np.array([pose.rotation]))[0]])

    def rng(self, *numbers: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, *numbers])
