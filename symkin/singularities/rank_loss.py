"""Equations for the loss of rank: where a matrix J(z) of m rows and n columns has less than its
generic rank r.

A unit vector w of r entries tells it:

    r = n          J w = 0
    r < n          (R J)^T w = 0 with R (r, m) of constant orthonormal rows, square where r = m

With r < n some J w = 0 hold everywhere (redundant actuated joints, freedoms without an actuator),
so that only a relation of the rows tells a further loss. Where r < m too, the rows of R span the
column space of J at a generic configuration, or what stands for it at a point of a locus
(`around`); a zero at which R, not J, is to blame is told by `is_lost`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property
from symkin.numeric.rank import Rank
from symkin.numeric.tolerances import SINGULAR_VALUE


@dataclass(frozen=True, eq=False)
class RankLoss:
    """`kernel` evaluates J (m, n) at (free, u, v); `generic` is J at a generic configuration.
    `telling` are the columns of J that tell the kind of a locus: pose for type 2, actuated joints
    for type 1; the others are passive joints. `given` is R where it is not the generic one.
    """

    kernel: ca.Function
    generic: np.ndarray
    telling: list[int]
    given: np.ndarray | None = None

    @cached_property
    def rank(self) -> int:
        return Rank.of(self.generic).value

    @property
    def free_motions(self) -> int:
        """n - r: motions that J w = 0 leaves everywhere."""
        return self.generic.shape[1] - self.rank

    @cached_property
    def combinations(self) -> np.ndarray:
        """R (r, m)."""
        if self.given is not None:
            return self.given
        return (
            np.asarray(np.linalg.svd(self.generic)[0][:, : self.rank].T)
            if self.chooses_rows
            else np.eye(self.rank)
        )

    @property
    def chooses_rows(self) -> bool:
        """Whether r < m and r < n, so that R matters."""
        return self.free_motions > 0 and self.rank < self.generic.shape[0]

    def around(self, z: np.ndarray, w: np.ndarray) -> tuple[RankLoss, np.ndarray]:
        """With R at a point of a locus: the combinations of rows that J keeps there, then those
        that it loses; and the same w (any length).
        """
        left = np.linalg.svd(np.asarray(self.kernel(z)))[0]
        lost = self.null_space(z) @ self.combinations
        rows = np.vstack([left[:, : self.rank - len(lost)].T, lost])
        return replace(self, given=rows), rows @ (w @ self.combinations)

    def equations(self, jacobian: ca.SX, w: ca.SX) -> ca.SX:
        """The rows that vanish with J's symbols in place of its numbers."""
        return (
            jacobian @ w if not self.free_motions else (ca.DM(self.combinations) @ jacobian).T @ w
        )

    def vectors(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unit w (r, r) at a closed configuration as rows, and their singular values (r,), the
        smallest first.
        """
        if self.free_motions:
            left, singular, _ = np.linalg.svd(self.combinations @ np.asarray(self.kernel(z)))
            return left.T[::-1], singular[::-1]
        _, singular, right = np.linalg.svd(np.asarray(self.kernel(z)))
        return right[::-1], singular[::-1]

    def null_space(self, z: np.ndarray) -> np.ndarray:
        """The w (c, r) of singular values that are lost at a point of a locus; c = 1 where no more
        than one is.
        """
        vectors, singular = self.vectors(z)
        return vectors[singular <= SINGULAR_VALUE * self._scale]

    def is_lost(self, z: np.ndarray) -> bool:
        """Whether J itself has less than its generic rank at a closed configuration."""
        return self._loses_rank(np.asarray(self.kernel(z)), self.rank)

    def is_passive(self, points: np.ndarray, w: np.ndarray) -> bool:
        """Whether passive joints alone lose the rank at points of a locus with unit vectors w
        (rows).
        """
        if not self.free_motions:
            return float(np.abs(w[:, self.telling]).max(initial=0.0)) <= SINGULAR_VALUE
        passive = [k for k in range(self.generic.shape[1]) if k not in self.telling]
        rank = Rank.of(self.generic[:, passive]).value
        return rank > 0 and all(
            self._loses_rank(np.asarray(self.kernel(z))[:, passive], rank) for z in points
        )

    @cached_property
    def _scale(self) -> float:
        return float(np.linalg.norm(self.generic, 2))

    def _loses_rank(self, matrix: np.ndarray, rank: int) -> bool:
        return bool(
            np.linalg.svd(matrix, compute_uv=False)[rank - 1] <= SINGULAR_VALUE * self._scale
        )


def generic_matrix(
    jacobians: Sequence[np.ndarray], rows: list[int], columns: list[int]
) -> np.ndarray:
    """The part of one of the Jacobians, at configurations of one mechanism, that has the largest
    rank.
    """
    parts = [jacobian[np.ix_(rows, columns)] for jacobian in jacobians]
    return max(parts, key=lambda part: Rank.of(part).value)
