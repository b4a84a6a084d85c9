"""The velocity equations at one configuration, as numbers, and the Jacobians that follow from them.

With E_i A_i t + E_i B_i q' = 0 the limbs' equations without passive joints (see `limb_ranks`), all
in lengths:

    t = J q',       J = -(E A)^+ E B                             all limbs' rows together
    q' = J^-1 t,    q_i' = -(E_i B_i)^+ E_i A_i t                each limb alone, for feasible t
    x' = Jp q',     x_i' = -P_i^+ (A_i J + B_i) q'

Ranks are those of generic configurations, and a configuration where one is lost is refused;
`singularities.limb_equations` eliminates passive joints by the ranks at the configuration itself,
for what holds at singular ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.computed_once import cached_property
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.solve_result import SolveError
from symkin.velocity.limb_ranks import LimbStructure, Matrices, span_projector


@dataclass(frozen=True, eq=False)
class VelocityMatrices:
    """A (m, 6), P (m, p), B (m, n) as numbers, and the Jacobians that follow from them.

    Least squares and shortest vectors take angles times the mechanism's size. SolveError says that
    a Jacobian is not defined: the mechanism has too few actuated joints for it, or the
    configuration is singular (a singular value below 1e-8 of the largest).
    """

    equations: LimbStructure
    twist: np.ndarray
    passive: np.ndarray
    actuated: np.ndarray

    @cached_property
    def direct_jacobian(self) -> np.ndarray:
        """J (6, n), t = J q'. With more actuated joints than freedoms, rates that no motion has
        give the t which leaves the smallest sum of squares in the rows of the closure.
        """
        e = self.equations
        if e.freedom:
            raise SolveError(
                f"{e.mechanism.name}: the direct Jacobian is not defined; with its "
                f"{self.actuated.shape[1]} actuated "
                f"joints held, the platform keeps {e.freedom} of its freedoms: actuate more "
                f"joints, or declare its motion"
            )
        twist = np.vstack([limb.twist for limb in self._eliminated])
        rates = np.vstack([limb.actuated for limb in self._eliminated])
        what = (
            "the direct Jacobian is not defined at this configuration: type 2 singularity, the "
            "platform moves with the actuated joints held"
        )
        return self._unscaled(
            -self._inverse(twist, len(e.columns), what) @ rates, 0, 2, rows=e.columns
        )

    @cached_property
    def inverse_jacobian(self) -> np.ndarray:
        """J^-1 (n, 6), q' = J^-1 t for feasible twists t; 0 for twists orthogonal to all feasible
        ones (angular velocities times the size). Where a limb's actuated joints have more freedom
        than the twist decides, the shortest q'.
        """
        e = self.equations
        result = np.zeros((self.actuated.shape[1], len(e.columns)))
        for part, limb in zip(e.limbs, self._eliminated, strict=True):
            what = (
                f"the inverse Jacobian is not defined at this configuration: type 1 singularity of "
                f"limb {part.name}"
            )
            own = limb.actuated[:, part.actuated]
            result[list(part.actuated)] = -self._inverse(own, part.rank, what) @ limb.twist
        return self._unscaled(result @ self.feasible_projector, 2, 0, columns=e.columns)

    @cached_property
    def passive_jacobian(self) -> np.ndarray:
        """(p, n), x' = Jp q', columns as `passive_names`; joints of a limb whose motion moves
        nothing else rest.
        """
        e = self.equations
        direct = (self.direct_jacobian * e.scales[0][:, None] / e.scales[2])[list(e.columns)]
        result = np.zeros((self.passive.shape[1], self.actuated.shape[1]))
        for part, limb in zip(e.limbs, self._eliminated, strict=True):
            rows = list(part.rows)
            left = self.scaled[0][rows] @ direct + self.scaled[2][rows]
            result[list(part.passive)] = -limb.passive_inverse @ left
        return self._unscaled(result, 1, 2)

    @cached_property
    def feasible_projector(self) -> np.ndarray:
        """(r, r), orthogonal, of the motion's twist components (velocity; size times angular
        velocity) onto the feasible ones.
        """
        e = self.equations
        constraints = np.vstack(
            [
                limb.twist - span_projector(limb.actuated[:, part.actuated], part.rank) @ limb.twist
                for part, limb in zip(e.limbs, self._eliminated, strict=True)
            ]
        )
        if e.constraints == 0:
            return np.eye(len(e.columns))
        what = (
            "the feasible twists are not defined at this configuration: constraint singularity, "
            "the limbs' constraints lose rank"
        )
        return np.asarray(
            np.eye(len(e.columns)) - self._inverse(constraints, e.constraints, what) @ constraints
        )

    @cached_property
    def scaled(self) -> Matrices:
        """A (the motion's columns), P and B by rates in lengths."""
        return self.equations.scaled(self.twist, self.passive, self.actuated)

    @cached_property
    def _eliminated(self) -> tuple[_Eliminated, ...]:
        found = []
        for part in self.equations.limbs:
            twist, passive, actuated = (matrix[list(part.rows)] for matrix in self.scaled)
            p = passive[:, part.passive]
            what = (
                f"the velocity equations of limb {part.name} are singular at this configuration: "
                f"passive joints move alone"
            )
            inverse = self._inverse(p, len(part.passive), what)
            span = span_projector(p, len(part.passive))
            found.append(_Eliminated(twist - span @ twist, actuated - span @ actuated, inverse))
        return tuple(found)

    def _inverse(self, matrix: np.ndarray, rank: int, what: str) -> np.ndarray:
        """Pseudo-inverse of a matrix of known rank."""
        if rank == 0:
            return np.zeros(matrix.shape[::-1])
        left, singular, right = np.linalg.svd(matrix, full_matrices=False)
        if len(singular) < rank or not singular[rank - 1] > RANK_TOLERANCE * singular[0]:
            raise SolveError(f"{self.equations.mechanism.name}: {what}")
        return np.asarray((right[:rank].T / singular[:rank]) @ left[:, :rank].T)

    def _unscaled(
        self,
        matrix: np.ndarray,
        to: int,
        of: int,
        rows: tuple[int, ...] | None = None,
        columns: tuple[int, ...] | None = None,
    ) -> np.ndarray:
        """From lengths to the units of rates, with zeros for twist components that the motion does
        not have.
        """
        scales = self.equations.scales
        full = np.zeros((len(scales[to]), len(scales[of])))
        full[
            np.ix_(
                range(len(full)) if rows is None else rows,
                range(full.shape[1]) if columns is None else columns,
            )
        ] = matrix
        return np.asarray(full / scales[to][:, None] * scales[of])


@dataclass(frozen=True, eq=False)
class _Eliminated:
    """A limb's rows without its passive joints, scaled, and the pseudo-inverse of its passive
    columns.
    """

    twist: np.ndarray
    actuated: np.ndarray
    passive_inverse: np.ndarray
