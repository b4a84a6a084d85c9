"""Derive the Jacobians of a closure as expressions, from its velocity equations limb by limb.

For limb i with rows A_i t + P_i x_i' + B_i q_i' = 0, orthogonal elimination (see `elimination`) of
P_i leaves equations in t and q'; all limbs' together, solved by least squares, give the direct
Jacobian, and each limb's alone, solved for q_i', the inverse one. A limb with one row and one
actuated joint is q' = -A t / B: for a rod (d, s x d) / length.

Where these expressions have poles: the direct one where A loses rank (type 2), the inverse one
where B_i does (type 1), all where a P_i does (passive joints that move alone). Only for limbs that
forbid twists which the declared motion has (`VelocityEquations.constraints` > 0) the inverse one
has others: as many rows as there are independent constraints are chosen at generic closed
configurations, and where just these lose rank, though all together do not, it has a pole; so it has
for limbs whose actuated joints have more freedom than the twist decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.numeric.rank import most_independent
from symkin.position.closed_configurations import closed_configurations
from symkin.velocity.differential import Differential, pose_rates
from symkin.velocity.elimination import (
    back_substituted,
    cofactors,
    factored,
    nonzero_rows,
    shortest,
    without_span,
)
from symkin.velocity.equations import VelocityEquations
from symkin.velocity.limb_ranks import LimbPart

_LARGEST_MINOR = 2
"""Passive joints of a limb up to which one remaining equation is made of minors, without
divisions.
"""


@dataclass(frozen=True, eq=False)
class Expressions:
    """Jacobians of `equations`, from a differential of the same closure with geometry as numbers or
    symbols.

    All are (rows, columns) in the units of rates; columns and rows that a motion does not have are
    zero.
    """

    equations: VelocityEquations
    differential: Differential

    @property
    def closure(self) -> Closure:
        return self.equations.closure

    @cached_property
    def direct(self) -> ca.SX:
        """J (6, n)."""
        columns = list(self.equations.columns)
        twist, actuated = (
            ca.vertcat(*parts)
            for parts in zip(
                *(self._platform_rows(part) for part in self.equations.limbs), strict=True
            )
        )
        kept = nonzero_rows(twist)
        result = ca.SX(6, int(actuated.shape[1]))
        result[columns, :] = -factored(twist[kept, :], actuated[kept, :]).solution()
        return ca.sparsify(result)

    @cached_property
    def inverse(self) -> ca.SX:
        """J^-1 (n, 6)."""
        rates, rows = self._limb_rates
        if self.equations.constraints:
            forbidden = ca.mtimes(rows[self._chosen, :], self._to_lengths)
            rates = ca.mtimes(
                without_span(ca.mtimes(rates, self._to_lengths), forbidden),
                ca.inv(self._to_lengths),
            )
        result = ca.SX(int(rates.shape[0]), 6)
        result[:, list(self.equations.columns)] = rates
        return ca.sparsify(result)

    @cached_property
    def passive(self) -> ca.SX:
        """Jp (p, n); passive joints that are held rest."""
        result = ca.SX(
            int(self.differential.passive.shape[1]), int(self.differential.actuated.shape[1])
        )
        direct = self.direct[list(self.equations.columns), :]
        for part in self.equations.limbs:
            twist, passive, actuated = self._rows(part)
            width = int(twist.shape[1])
            parts = factored(passive, ca.horzcat(twist, actuated))
            moved = ca.mtimes(parts.coefficients[:, :width], direct) + parts.coefficients[:, width:]
            result[list(part.passive), :] = -back_substituted(parts.triangular, moved)
        return ca.sparsify(result)

    @cached_property
    def analytic(self) -> ca.SX:
        """Rates of the pose coordinates by q': x' = v; the unit quaternion's are (0, w) q / 2,
        gamma' = w_z.
        """
        return ca.sparsify(
            ca.vertcat(
                *(pose_rates(c, self._quaternion, self.direct) for c in self.closure.role("pose"))
            )
        )

    @property
    def _quaternion(self) -> ca.SX:
        """The pose's unit quaternion: that of the joints for a serial arm."""
        return self.differential.pose.quaternion

    @cached_property
    def _weights(self) -> np.ndarray:
        """Factors of the rows: those that make lengths, where they differ."""
        weights = self.differential.weights
        return weights / weights.max() if np.ptp(weights) else np.ones(len(weights))

    def _rows(self, part: LimbPart) -> tuple[ca.SX, ca.SX, ca.SX]:
        """A_i (columns of the motion), P_i and B_i (all actuated columns)."""
        d, rows = self.differential, list(part.rows)
        weights = (
            ca.diag(ca.DM(self._weights[rows]))
            if len(rows) > 1 or self._is_redundantly_actuated
            else ca.DM.eye(len(rows))
        )
        own = ca.SX(len(rows), int(d.actuated.shape[1]))
        own[:, list(part.actuated)] = d.actuated[rows, list(part.actuated)]
        return tuple(
            ca.sparsify(ca.mtimes(weights, m))
            for m in (
                d.twist[rows, list(self.equations.columns)],
                d.passive[rows, list(part.passive)],
                own,
            )
        )

    @property
    def _is_redundantly_actuated(self) -> bool:
        e = self.equations
        return sum(part.rank for part in e.limbs) > len(e.columns) - e.constraints

    def _platform_rows(self, part: LimbPart) -> tuple[ca.SX, ca.SX]:
        """The limb's equations in twist and actuated rates."""
        twist, passive, actuated = self._rows(part)
        both, width = ca.horzcat(twist, actuated), int(twist.shape[1])
        m, p = passive.shape
        if p == 0:
            return twist, actuated
        if m - p == 1 and p <= _LARGEST_MINOR and not self._is_redundantly_actuated:
            left = ca.mtimes(cofactors(passive), both)
        else:
            left = factored(passive, both).remainder if m > p else ca.SX(0, both.shape[1])
        left = left[nonzero_rows(left), :]
        return left[:, :width], left[:, width:]

    @cached_property
    def _limb_rates(self) -> tuple[ca.SX, ca.SX]:
        """K (n, r), q' = K t for feasible t, and rows (., r) that every feasible t makes zero."""
        count, r = int(self.differential.actuated.shape[1]), len(self.equations.columns)
        rates, constraints = ca.SX(count, r), [ca.SX(0, r)]
        for part in self.equations.limbs:
            twist, passive, actuated = self._rows(part)
            own = actuated[:, list(part.actuated)]
            if part.is_redundant:
                part_rates, rows = self._redundant_limb(part, twist, passive, own)
            else:
                parts = factored(ca.horzcat(passive, own), twist)
                part_rates, rows = -parts.solution(len(part.passive)), parts.remainder
            rates[list(part.actuated), :] = part_rates
            if len(part.rows) > len(part.passive) + part.rank:
                constraints.append(rows[nonzero_rows(rows), :])
        return ca.sparsify(rates), ca.vertcat(*constraints)

    def _redundant_limb(
        self, part: LimbPart, twist: ca.SX, passive: ca.SX, own: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """The shortest rates (angles times the size) of a limb whose twist does not decide them."""
        left = factored(passive, ca.horzcat(twist, own)).remainder
        twist, own = left[:, : twist.shape[1]], left[:, twist.shape[1] :]
        size = self.closure.characteristic_length
        joints = [self.closure.role("actuated")[k] for k in part.actuated]
        scales = ca.diag(ca.DM([c.lever(size) for c in joints]))
        scaled = ca.mtimes(own, ca.inv(scales))
        chosen = self._independent_rows(scaled, part.rank)
        rates = -ca.mtimes(ca.inv(scales), shortest(scaled[chosen, :], twist[chosen, :]))
        others = [k for k in range(int(own.shape[0])) if k not in chosen]
        return rates, ca.sparsify(twist[others, :] + ca.mtimes(own[others, :], rates))

    @property
    def chooses_rows(self) -> bool:
        """Whether the inverse one holds some of redundant rows, and fails where just these lose
        rank.
        """
        among_limbs = (
            self.equations.constraints
            and int(self._limb_rates[1].shape[0]) > self.equations.constraints
        )
        return bool(among_limbs) or any(part.is_redundant for part in self.equations.limbs)

    @cached_property
    def _chosen(self) -> list[int]:
        """Independent ones among the rows that feasible twists make zero."""
        return self._independent_rows(
            ca.mtimes(self._limb_rates[1], self._to_lengths), self.equations.constraints
        )

    @property
    def _to_lengths(self) -> ca.DM:
        """What columns by the motion's twist components are multiplied by, to be columns by
        lengths.
        """
        size = self.closure.characteristic_length
        return ca.diag(ca.DM([1 / size if k > 2 else 1.0 for k in self.equations.columns]))

    def _independent_rows(self, rows: ca.SX, count: int) -> list[int]:
        """`count` rows that are independent at all samples."""
        closure = self.closure
        if count == 0:
            return []
        evaluate = ca.Function(
            "rows", [closure.variables, closure.parameters], [ca.densify(rows)], {"cse": True}
        )
        left = np.array([np.asarray(evaluate(z, closure.parameter_values)) for z in self._samples])
        left /= np.max(np.linalg.norm(left, axis=2), axis=1)[:, None, None]
        chosen = most_independent(left, count, 0.0, together=True)
        return [int(k) for k in np.flatnonzero(chosen.any(axis=0))]

    @cached_property
    def _samples(self) -> list[np.ndarray]:
        """Closed configurations at which the ranks are the generic ones."""
        return [
            values
            for values in closed_configurations(self.closure, 0)
            if self.equations.is_generic(values)
        ]
