"""What a linkage is at many configurations: its Jacobians and second derivatives both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.computed_once import cached_property
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.transmissions.linkage import Linkage


@dataclass(frozen=True, eq=False)
class States:
    """n closed configurations w (n, width) of a linkage, rows of NaN where there is none; its
    motors m and joints j in radians and the length unit. What a singularity leaves undefined is
    NaN.
    """

    linkage: Linkage
    w: np.ndarray

    @property
    def motors(self) -> np.ndarray:
        return self.w[:, self.linkage.motor_places]

    @property
    def joints(self) -> np.ndarray:
        return self.w[:, self.linkage.joint_places]

    @cached_property
    def _chart(self) -> tuple[np.ndarray, np.ndarray]:
        """w_s (n, width, k) and w_ss (n, width, k, k) with lengths over the size; NaN where a
        freedom is gained.
        """
        linkage, n = self.linkage, len(self.w)
        width, free = linkage.units.size, linkage.mobility
        first, second = np.full((n, width, free), np.nan), np.full((n, width, free, free), np.nan)
        known = np.flatnonzero(np.isfinite(self.w).all(axis=1))
        if known.size:
            tangents, solving, regular = linkage.tangents(self.w[known])
            first[known[regular]] = tangents[regular]
            second[known[regular]] = linkage.bends(
                self.w[known][regular], tangents[regular], solving[regular]
            )
        return first, second

    def _part(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        first, second = self._chart
        units = self.linkage.units[places]
        return first[:, places] * units[:, None], second[:, places] * units[:, None, None]

    def _derivatives(self, of: np.ndarray, by: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivatives (n, of, by), (n, of, by, by) of coordinates at some places
        of w by those at others.
        """
        (of_s, of_ss), (by_s, by_ss) = self._part(of), self._part(by)
        back = self._inverse(by_s, by)
        slopes = of_s @ back
        return slopes, _pulled_back(of_ss - np.einsum("nij,njab->niab", slopes, by_ss), back)

    @cached_property
    def _by_joints(self) -> tuple[np.ndarray, np.ndarray]:
        return self._derivatives(self.linkage.motor_places, self.linkage.joint_places)

    @cached_property
    def _by_motors(self) -> tuple[np.ndarray, np.ndarray]:
        if len(self.linkage.motors) == self.linkage.mobility:
            return self._derivatives(self.linkage.joint_places, self.linkage.motor_places)
        slopes = _least_norm(self.inverse_jacobian)
        bent = _pulled_back(self.inverse_second, slopes)
        return slopes, -np.asarray(np.einsum("nij,njab->niab", slopes, bent))

    @property
    def inverse_jacobian(self) -> np.ndarray:
        """G = d motors / d joints (n, motors, joints)."""
        return self._by_joints[0]

    @property
    def inverse_second(self) -> np.ndarray:
        """d2 motors / d joints2 (n, motors, joints, joints)."""
        return self._by_joints[1]

    @property
    def jacobian(self) -> np.ndarray:
        """J = d joints / d motors (n, joints, motors); of redundant motors the pseudo-inverse of G,
        for rates that agree.
        """
        return self._by_motors[0]

    @property
    def second(self) -> np.ndarray:
        """d2 joints / d motors2 (n, joints, motors, motors)."""
        return self._by_motors[1]

    def inertia(self, motors: np.ndarray) -> np.ndarray:
        """J^-T I J^-1 (n, joints, joints) for inertias I of the motors."""
        g = self.inverse_jacobian
        return np.einsum("nai,a,naj->nij", g, motors, g)

    def bias(self, motors: np.ndarray) -> np.ndarray:
        """What multiplies squares of joint rates, G^T I d2m/dj2 (n, joints, joints, joints)."""
        return np.einsum("nai,a,najk->nijk", self.inverse_jacobian, motors, self.inverse_second)

    def _inverse(self, matrices: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Inverses (n, k, k), NaN where there is none: judged with lengths over the size."""
        scaled = matrices / self.linkage.units[places][:, None]
        values = np.linalg.svd(np.nan_to_num(scaled), compute_uv=False)
        regular = (values[:, -1] > RANK_TOLERANCE) & np.isfinite(matrices).all(axis=(1, 2))
        found = np.full(matrices.shape, np.nan)
        found[regular] = np.linalg.inv(matrices[regular])
        return found

    def lost(self, row: int) -> str:
        """Which direction a singular configuration loses, as words; empty at a regular one."""
        linkage, first = self.linkage, self._chart[0][row]
        if not np.isfinite(first).all():
            return "the loops gain a freedom there: neither motors nor joints decide the motion"
        sides = ((linkage.joints, linkage.motors), (linkage.motors, linkage.joints))
        for (names, others), what in zip(sides, ("motors", "joints"), strict=True):
            _, values, right = np.linalg.svd(first[linkage.places_of(others)])
            if len(values) < first.shape[1] or values[-1] < _NEARLY_LOST:
                way = first[linkage.places_of(names)] @ right[-1]
                moving = direction(names, way / np.abs(way).max())
                return f"{moving} moves while the {what} stand"
        return ""


_NEARLY_LOST = 1e-2
"""Singular value of motors or joints by a unit motion below which a direction is called lost where
a line ends.
"""


def direction(names: tuple[str, ...], parts: np.ndarray) -> str:
    """A direction as a sum of coordinates, those below a thousandth left out."""
    told = ""
    for name, part in zip(names, parts, strict=True):
        factor = "" if abs(abs(part) - 1.0) < 5e-3 else f"{abs(part):.2g} "
        told += "" if abs(part) < 1e-3 else f" {'-' if part < 0.0 else '+'} {factor}{name}"
    return told.removeprefix(" + ").strip()


def _least_norm(matrices: np.ndarray) -> np.ndarray:
    found = np.full(matrices.transpose(0, 2, 1).shape, np.nan)
    known = np.isfinite(matrices).all(axis=(1, 2))
    found[known] = np.linalg.pinv(matrices[known])
    return found


def _pulled_back(bent: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Second derivatives (n, i, a, b) by what `slopes` (n, a, c) lead to: (n, i, c, d)."""
    return np.einsum("niab,nac,nbd->nicd", bent, slopes, slopes)
