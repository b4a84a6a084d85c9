"""Derive the Jacobians of a closure as expressions, from its velocity equations.

With the rows A t + P x' + B q' = 0, orthogonal elimination (see `elimination`) of P leaves
equations in t and q', from which least squares give t by q', the direct Jacobian; elimination of P
and B gives q' by t, the inverse one. A rod is q' = -A t / B, (d, s x d) / length.

Where these expressions have poles: the direct one where A loses rank (type 2), the inverse one
where B does (type 1), all where P does (passive joints that move alone). Only for limbs that forbid
twists which the declared motion has (`VelocityEquations.constraints` > 0) the inverse one has
others: as many rows as there are independent constraints are chosen at generic closed
configurations, and where just these lose rank, though all together do not, it has a pole; so it has
where the actuated joints of a limb have more freedom than the twist decides.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.numeric.rank import most_independent
from symkin.position.closed_configurations import closed_configurations
from symkin.velocity.differential import TWIST_COLUMNS, Differential, by_name
from symkin.velocity.elimination import (
    factored,
    inner_rates,
    nonzero_rows,
    outer_rates,
    shortest,
    without_span,
)
from symkin.velocity.equations import VelocityEquations


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

    @property
    def free(self) -> Collection[str]:
        is_open = self.differential is self.equations.differential
        return self.closure.parameter_names if is_open else ()

    @property
    def following(self) -> ca.SX:
        """All rates (q'; x'; t) by q'."""
        unit = ca.SX.eye(self.differential.actuated.shape[1])
        return ca.vertcat(unit, self.passive, self.direct)

    def split(self, rates: ca.SX) -> dict[str, ca.SX]:
        """Rates of each coordinate among all rates (q'; x'; t)."""
        twist = rates[-6:, :]
        poses = {c.name: twist[list(TWIST_COLUMNS[c.name]), :] for c in self.closure.role("pose")}
        return by_name(self.closure.role("actuated", "passive", "body"), rates) | poses

    @cached_property
    def direct(self) -> ca.SX:
        """J (6, n)."""
        minors = not self._is_loaded
        result = ca.SX(6, self._actuated.shape[1])
        result[list(self.equations.columns), :] = outer_rates(
            self._passive, self._twist, self._actuated, minors=minors
        )
        return ca.sparsify(result)

    @cached_property
    def passive(self) -> ca.SX:
        """Jp (p, n); passive joints that are held rest."""
        twist = self.direct[list(self.equations.columns), :]
        result = ca.SX(self.differential.passive.shape[1], self._actuated.shape[1])
        result[self._used, :] = inner_rates(self._passive, self._twist, self._actuated, twist)
        return ca.sparsify(result)

    @cached_property
    def inverse(self) -> ca.SX:
        """J^-1 (n, 6)."""
        rates, rows = self._driving
        if self.equations.constraints:
            forbidden = ca.mtimes(rows[self._chosen, :], self._to_lengths)
            rates = ca.mtimes(
                without_span(ca.mtimes(rates, self._to_lengths), forbidden),
                ca.inv(self._to_lengths),
            )
        result = ca.SX(rates.shape[0], 6)
        result[:, list(self.equations.columns)] = rates
        return ca.sparsify(result)

    @property
    def quaternion(self) -> ca.SX:
        """That of the platform's or tool's pose."""
        return self.differential.pose.quaternion

    @property
    def _used(self) -> list[int]:
        return list(self.equations.used)

    @cached_property
    def _weights(self) -> ca.DM:
        """Factors of the rows: those that make lengths, where they differ."""
        weights = self.differential.weights
        alike = not np.ptp(weights)
        return ca.diag(ca.DM(np.ones(len(weights)) if alike else weights / weights.max()))

    @cached_property
    def _twist(self) -> ca.SX:
        """A, columns of the motion."""
        columns = list(self.equations.columns)
        return ca.sparsify(ca.mtimes(self._weights, self.differential.twist[:, columns]))

    @cached_property
    def _passive(self) -> ca.SX:
        """P, columns of passive joints that move something else."""
        return ca.sparsify(ca.mtimes(self._weights, self.differential.passive[:, self._used]))

    @cached_property
    def _actuated(self) -> ca.SX:
        return ca.sparsify(ca.mtimes(self._weights, self.differential.actuated))

    @property
    def _is_loaded(self) -> bool:
        """Whether actuation is redundant, so that lengths of rows matter."""
        e = self.equations
        return e.decided > len(e.columns) - e.constraints

    @cached_property
    def _driving(self) -> tuple[ca.SX, ca.SX]:
        """K (n, r), q' = K t for feasible t, and rows (., r) that every feasible t makes zero."""
        twist, passive, actuated = self._twist, self._passive, self._actuated
        if self.equations.decided < actuated.shape[1]:
            return self._shortest_rates()
        parts = factored(ca.horzcat(passive, actuated), twist)
        left = parts.remainder
        return -parts.solution(len(self._used)), left[nonzero_rows(left), :]

    def _shortest_rates(self) -> tuple[ca.SX, ca.SX]:
        """The shortest rates (angles times the size) where the twist does not decide them."""
        left = factored(self._passive, ca.horzcat(self._twist, self._actuated)).remainder
        width, size = self._twist.shape[1], self.closure.characteristic_length
        twist, own = left[:, :width], left[:, width:]
        scales = ca.diag(ca.DM([c.lever(size) for c in self.closure.role("actuated")]))
        scaled = ca.mtimes(own, ca.inv(scales))
        chosen = self._independent_rows(scaled, self.equations.decided)
        rates = -ca.mtimes(ca.inv(scales), shortest(scaled[chosen, :], twist[chosen, :]))
        others = [k for k in range(own.shape[0]) if k not in chosen]
        return rates, ca.sparsify(twist[others, :] + ca.mtimes(own[others, :], rates))

    @property
    def chooses_rows(self) -> bool:
        """Whether the inverse one holds some of redundant rows, and fails where just these lose
        rank.
        """
        constraints = self.equations.constraints
        among_limbs = constraints and self._driving[1].shape[0] > constraints
        return bool(among_limbs) or self.equations.decided < self._actuated.shape[1]

    @cached_property
    def _chosen(self) -> list[int]:
        """Independent ones among the rows that feasible twists make zero."""
        return self._independent_rows(
            ca.mtimes(self._driving[1], self._to_lengths), self.equations.constraints
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
