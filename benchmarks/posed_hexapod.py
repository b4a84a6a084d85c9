"""A hexapod's whole poses, and SciPy's least squares over them by a direct solver and derivatives
in NumPy, without symkin's equations: the peer of benchmarks/calibration.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

import symkin
from helpers.hexapods import matrices


def turned(w: np.ndarray) -> np.ndarray:
    """Rotation matrices of rotation vectors (n, 3), Rodrigues."""
    angle = np.maximum(np.linalg.norm(w, axis=1), 1e-9)[:, None, None]
    k = np.zeros((len(w), 3, 3))
    k[:, 2, 1], k[:, 0, 2], k[:, 1, 0] = w.T
    k -= k.transpose(0, 2, 1)
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * (k @ k)


@dataclass
class PosedHexapod:
    """Rod readings and whole poses of a platform on six rods, with the standard deviation of each
    component (metres, radians); 42 parameters: ends and offset of each rod.
    """

    nominal: symkin.Mechanism
    readings: symkin.Measurements
    sigma: float
    last: tuple[np.ndarray, np.ndarray] | None = field(default=None)

    def __post_init__(self) -> None:
        self.rotations = matrices(self.readings.orientation)

    def direct(self, p: np.ndarray) -> tuple[np.ndarray, ...]:
        """Newton for all postures at once, from its last solutions: places, rotations, directions
        of the rods and the Jacobian.
        """
        base, platform, offset = np.split(p.reshape(6, 7), [3, 6], axis=1)
        t, r = self.last or (self.readings.position, self.rotations)
        for _ in range(20):
            arms = platform @ r.transpose(0, 2, 1)
            rods = t[:, None] + arms - base
            length = np.linalg.norm(rods, axis=2)
            gap = length - self.readings.joints - offset[:, 0]
            u = rods / length[:, :, None]
            jacobian = np.concatenate([u, np.cross(arms, u)], axis=2)
            if np.max(np.abs(gap)) < 1e-13:
                break
            step = -np.linalg.solve(jacobian, gap[:, :, None])[:, :, 0]
            t, r = t + step[:, :3], turned(step[:, 3:]) @ r
        self.last = t, r
        return t, r, u, jacobian

    def residuals(self, p: np.ndarray) -> np.ndarray:
        t, r, *_ = self.direct(p)
        d = self.rotations.transpose(0, 2, 1) @ r
        turn = np.stack(
            [d[:, 2, 1] - d[:, 1, 2], d[:, 0, 2] - d[:, 2, 0], d[:, 1, 0] - d[:, 0, 1]], axis=1
        )
        return np.concatenate([t - self.readings.position, 0.5 * turn], axis=1).ravel() / self.sigma

    def jacobian(self, p: np.ndarray) -> np.ndarray:
        _, r, u, jacobian = self.direct(p)
        rods, by_p = np.arange(6), np.zeros((len(r), 6, 6, 7))
        by_p[:, rods, rods, :3] = -u
        by_p[:, rods, rods, 3:6] = u @ r
        by_p[:, rods, rods, 6] = -1.0
        moved = -np.linalg.solve(jacobian, by_p.reshape(len(r), 6, 42))
        moved[:, 3:] = r.transpose(0, 2, 1) @ moved[:, 3:]
        return (moved / self.sigma).reshape(-1, 42)

    def fit(self) -> float:
        """Chi-square at SciPy's minimum from nominal."""
        from scipy.optimize import least_squares

        self.last = None
        start = [[*limb.base, *limb.platform, limb.offset] for limb in self.nominal.limbs]
        found = least_squares(
            self.residuals,
            np.ravel(start),
            jac=self.jacobian,
            method="lm",
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        return 2.0 * float(found.cost)
