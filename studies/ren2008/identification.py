"""The paper's own identification: residuals (4), cost (6), Levenberg-Marquardt; what it tells
apart; equation (8).

    C = [C_alpha^1 ... C_alpha^s, C_beta^1 ... C_beta^s],
    C_alpha^i = (alpha_i2 - alpha_i1, ..., alpha_it - alpha_i,t-1)
    cost(eta) = |C|^2,   dC/deta by the implicit function (`model.slopes`)

This is written here beside `symkin.calibration`, which has the same residuals as "differences", so
that each checks the other. Units: m, rad. Source: Ren, Feng, Su 2008, 1.2 to 1.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.ren2008.model import NAMES, direct, inverse, joints_of, slopes, turn

STEPS = 60
ENDED = 1e-13
"""Step of the parameters [m] at which the search has ended: rounding of lengths of 1.5 m, magnified
a hundredfold.
"""
RANK = 1e-9
"""Singular values below this share of the largest count as zero: exact ones come out at 1e-15."""


def neighbours(groups: np.ndarray) -> np.ndarray:
    """The matrix that takes (n,) values to differences of neighbours in each group (3)."""
    later = np.flatnonzero(groups[1:] == groups[:-1]) + 1
    D = np.zeros((len(later), len(groups)))
    D[np.arange(len(later)), later], D[np.arange(len(later)), later - 1] = 1.0, -1.0
    return D


def residuals(X: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """C of (4): differences of alpha, then of beta."""
    D = neighbours(groups)
    return np.concatenate([D @ X[:, 3], D @ X[:, 4]])


def jacobian(by_eta: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """dC/deta from dX/deta (n, 6, P)."""
    D = neighbours(groups)
    return np.vstack([D @ by_eta[:, 3], D @ by_eta[:, 4]])


# --- (4) to (6) -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Identified:
    """Parameters eta (42,), the cost at the start and after each step, and dC/deta of the free
    parameters at the end.
    """

    eta: np.ndarray
    costs: list[float]
    jacobian: np.ndarray

    def evidence(self) -> dict[str, object]:
        return {
            "by": f"{__name__}.identify",
            "method": "Levenberg-Marquardt",
            "text": "Levenberg-Marquardt on (6)",
        }


def identify(
    q: np.ndarray, groups: np.ndarray, nominal: np.ndarray, free: np.ndarray, start: np.ndarray
) -> Identified:
    """Least cost (6) over the free parameters, from the nominal ones; `start` (6,) is where direct
    problems begin.
    """
    eta, damping = nominal.copy(), 1e-4
    X = direct(q, eta, np.tile(start, (len(q), 1)))
    C = residuals(X, groups)
    costs, J = [float(C @ C)], np.zeros((len(C), len(free)))
    for _ in range(STEPS):
        J = jacobian(slopes(X, q, eta).by_eta[:, :, free], groups)
        scale = np.sqrt(damping) * np.linalg.norm(J, axis=0)
        step = -np.linalg.lstsq(
            np.vstack([J, np.diag(scale)]), np.concatenate([C, np.zeros(len(free))]), rcond=None
        )[0]
        trial = eta.copy()
        trial[free] += step
        moved = direct(q, trial, X)
        tried = residuals(moved, groups)
        if tried @ tried < C @ C:
            eta, X, C, damping = trial, moved, tried, 0.1 * damping
            costs.append(float(C @ C))
        else:
            damping *= 10.0
        if np.abs(step).max() < ENDED or damping > 1e6:
            break
    return Identified(eta, costs, J)


# --- what is identifiable (1.2) -------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Singular values of an identification Jacobian, its rank, and largest over smallest singular
    value that counts.
    """

    values: np.ndarray

    @property
    def rank(self) -> int:
        return int(np.sum(self.values > RANK * self.values[0]))

    @property
    def condition(self) -> float:
        return float(self.values[0] / self.values[self.rank - 1])


def spectrum(matrix: np.ndarray) -> Spectrum:
    return Spectrum(np.linalg.svd(matrix, compute_uv=False))


def frame_motions(eta: np.ndarray) -> np.ndarray:
    """(42, 10): what the six motions of the platform frame, and three shifts and the yaw of the
    base frame, do to eta.
    """
    m, b, _ = joints_of(eta)
    columns = np.zeros((len(NAMES), 10))
    for k, e in enumerate(np.eye(3)):
        columns[:18, k], columns[:18, 3 + k] = np.tile(e, 6), np.cross(e, m).ravel()
        columns[18:36, 6 + k] = np.tile(e, 6)
    columns[18:36, 9] = np.cross(np.eye(3)[2], b).ravel()
    return columns


def normal_jacobian(X: np.ndarray, by_eta: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """dC/deta where (alpha, beta) would say where the platform's normal stands in the base frame, R
    e_z: its x and y.
    """
    by_angles = np.stack(
        [turn(X[:, 3:] + 1e-30j * e)[:, :2, 2].imag / 1e-30 for e in np.eye(3)], axis=2
    )
    D, normals = neighbours(groups), by_angles @ by_eta[:, 3:]
    return np.vstack([D @ normals[:, 0], D @ normals[:, 1]])


def lifts(eta: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(42, 6): joint m_i moves along `up`, a direction of the platform frame, and b_i as far along
    z. While the vertical stays at `up` in the platform frame, no rod's length changes by it.
    """
    columns = np.zeros((len(eta), 6))
    for i in range(6):
        columns[3 * i : 3 * i + 3, i] = up
        columns[18 + 3 * i + 2, i] = 1.0
    return columns


# --- (8) ------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Causes:
    """Both sides of (8) for one set of errors: differences between neighbours (pairs, 2) in alpha
    and beta [rad].
    """

    left: np.ndarray
    rods: np.ndarray
    parameters: np.ndarray
    inclinometer: np.ndarray

    @property
    def remainder(self) -> float:
        """Root mean square of left less right, over that of the left."""
        right = self.rods + self.parameters + self.inclinometer
        return rms(self.left - right) / rms(self.left)


def causes(
    X: np.ndarray,
    groups: np.ndarray,
    nominal: np.ndarray,
    errors: np.ndarray,
    rod_errors: np.ndarray,
    tilts: np.ndarray,
) -> Causes:
    """(8) on postures that truly have X (n, 6), equal (alpha, beta) in a group but for `tilts` (n,
    2); `errors` (42,) is true less nominal, `rod_errors` (n, 6) true less measured extensions.
    """
    D, truth = neighbours(groups), nominal + errors
    posed = X.copy()
    posed[:, 3:5] += tilts
    q = inverse(posed, truth) - rod_errors
    found = direct(q, nominal, posed)
    at = slopes(found, q, nominal)
    by_rods = (at.by_rods[:, 3:5] @ rod_errors[:, :, None])[:, :, 0]
    by_parameters = at.by_eta[:, 3:5] @ errors
    return Causes(D @ found[:, 3:5], -(D @ by_rods), -(D @ by_parameters), D @ tilts)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def difference_slopes(
    X: np.ndarray, groups: np.ndarray, eta: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Slopes of neighbour differences in alpha and beta by the free parameters, pairs stacked:
    dC/deta at postures X.
    """
    return jacobian(slopes(X, inverse(X, eta), eta).by_eta[:, :, free], groups)
