"""Write the velocity equations A t + P x' + B q' = 0 of limbs, and solve them for rates.

t is the twist (velocity of the platform's or tool's origin; angular velocity), both in the base
frame, q' are the rates of the actuated joints in file order and x' those of the passive joints that
the closure has. Passive joints are eliminated with orthogonal projections: with U spanning the
columns of P, (1 - U U^T)(A t + B q') = 0, so that redundant rows, redundant actuation and serial
arms (whose rows are t - J q' = 0) need no case of their own. Least squares give t by q', the direct
Jacobian; elimination of P and B gives q' by t, the inverse one. A rod is q' = -A t / B,
(d, s x d) / length. Ranks of what is left of a limb say how many of its actuated rates the twist
decides, and which twists it forbids whatever its joints do (Gosselin and Angeles 1990; Zlatanov,
Bonev and Gosselin 2002).

Where these expressions have poles: the direct one where A loses rank (type 2), the inverse one
where B does (type 1), all where P does (passive joints that move alone). Only for limbs that forbid
twists which the declared motion has (`Ranks.constraints` > 0) the inverse one has others: as many
rows as there are independent constraints are chosen at generic closed configurations, and where
just these lose rank, though all together do not, it has a pole; so it has where the actuated joints
of a limb have more freedom than the twist decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import cached_property, lru_cache
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank, independent_rows, most_independent
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations, whole_system
from symkin.velocity.differential import Differential, by_name, differentiate, motion_columns
from symkin.velocity.elimination import (
    factored,
    inner_rates,
    nonzero_rows,
    outer_rates,
    shortest,
    without_span,
)
from symkin.velocity.limb_equations import Ranks, limbwise_equations
from symkin.velocity.roles import columns_by_name


@dataclass(frozen=True, eq=False)
class VelocityEquations:
    """A, P and B of a mechanism (see `Differential`), as expressions of the closure's variables
    and, unless its geometry is `bound`, its parameters; `size`, by which angles become lengths, is
    that of the description, of which they may be an arm.

    Rates are in the length unit or rad per unit of time; a passive unit quaternion has three
    columns, its angular velocity in the frame before the joint, axes as at the reference.
    """

    closure: Closure
    size: float
    bound: bool

    @cached_property
    def differential(self) -> Differential:
        return differentiate(self.closure, bound=self.bound)

    @property
    def columns(self) -> list[int]:
        """The twist's components that the platform's motion has."""
        return motion_columns(self.closure)

    @cached_property
    def _ranks_at(self) -> list[tuple[Ranks, np.ndarray]]:
        """Closed configurations near the reference (seed 0) and their ranks."""
        closure = self.closure
        return [
            (Ranks.of(limbwise_equations(closure, z, RANK_TOLERANCE), RANK_TOLERANCE), z)
            for z in closed_configurations(closure, 0)
        ]

    @cached_property
    def ranks(self) -> Ranks:
        """The generic ones."""
        return Ranks.generic(ranks for ranks, _ in self._ranks_at)

    @cached_property
    def samples(self) -> list[np.ndarray]:
        """Closed configurations at which the ranks are the generic ones."""
        return [z for ranks, z in self._ranks_at if ranks == self.ranks]

    @property
    def freedom(self) -> int:
        """Freedoms of the platform with the actuated joints held: the direct Jacobian is defined
        where there are none.
        """
        return len(self.columns) - self.ranks.twist

    @cached_property
    def used(self) -> list[int]:
        """Columns of P but for those of joints that are left at rest, since their motion moves
        nothing else.
        """
        _, jacobian = whole_system(self.closure).linearise_one(self.samples[0], np.zeros(0))
        names = [c.name for c in self.closure.role("passive", "body")]
        passive = jacobian[:, columns_by_name(self.closure, names)].T
        largest = float(np.max(np.linalg.norm(passive, axis=1), initial=0.0))
        return sorted(independent_rows(passive, RANK_TOLERANCE * largest))

    @cached_property
    def _parts(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """P, A and B, columns that move something, rows times what makes lengths of them where
        that differs.
        """
        d = self.differential
        weights = d.weights / d.weights.max(initial=0.0) if np.ptp(d.weights) else None
        parts = d.passive[:, self.used], d.twist[:, self.columns], d.actuated
        return tuple(
            ca.sparsify(p if weights is None else ca.mtimes(ca.diag(ca.DM(weights)), p))
            for p in parts
        )

    @cached_property
    def rates(self) -> dict[str, ca.SX]:
        """Rates of each coordinate by those of the actuated joints; passive joints that are held
        rest.
        """
        closure, (inner, outer, driving) = self.closure, self._parts
        # of redundant actuation lengths of rows matter
        loaded = self.ranks.rates > len(self.columns) - self.ranks.constraints
        joints = closure.role("passive", "body")
        levers = [c.lever(self.size) for c in joints for _ in range(c.freedom)]
        own = None if loaded else [levers[k] for k in self.used]
        found = outer_rates(inner, outer, driving, own)
        moving = ca.DM.eye(self.differential.passive.shape[1])[:, self.used]
        passive = ca.mtimes(moving, inner_rates(inner, outer, driving, found))
        return (
            by_name(closure.role("actuated"), ca.SX.eye(driving.shape[1]))
            | by_name(joints, passive)
            | by_name(closure.role("pose"), found)
        )

    # --- joint rates by twists --------------------------------------------------------------------

    @cached_property
    def inverse(self) -> ca.SX:
        """J^-1 (n, 6), of which columns that the motion does not have are zero."""
        rates, rows = self._driving
        if self.ranks.constraints:
            chosen = rows_at(
                self.closure, self._by_lengths(rows), self.samples, self.ranks.constraints
            )
            feasible = without_span(self._by_lengths(rates), self._by_lengths(rows)[chosen, :])
            rates = ca.mtimes(feasible, ca.inv(self._to_lengths))
        result = ca.SX(rates.shape[0], 6)
        result[:, self.columns] = rates
        return ca.sparsify(result)

    @property
    def chooses_rows(self) -> bool:
        """Whether the inverse one holds some of redundant rows, and fails where just these lose
        rank.
        """
        constraints = self.ranks.constraints
        among_limbs = constraints and self._driving[1].shape[0] > constraints
        return bool(among_limbs) or self._is_redundant

    @property
    def _is_redundant(self) -> bool:
        """Whether the twist leaves some of the actuated rates."""
        return self.ranks.rates < self.differential.actuated.shape[1]

    @cached_property
    def _driving(self) -> tuple[ca.SX, ca.SX]:
        """K (n, r), q' = K t for feasible t, and rows (., r) that every feasible t makes zero."""
        passive, twist, actuated = self._parts
        if self._is_redundant:
            return self._shortest_rates()
        parts = factored(ca.horzcat(passive, actuated), twist)
        left = parts.remainder
        return -parts.solution(passive.shape[1]), left[nonzero_rows(left), :]

    def _shortest_rates(self) -> tuple[ca.SX, ca.SX]:
        """The shortest rates (angles times the size) where the twist does not decide them."""
        passive, twist, actuated = self._parts
        left = factored(passive, ca.horzcat(twist, actuated)).remainder
        width, size = twist.shape[1], self.size
        twist, own = left[:, :width], left[:, width:]
        shrunk = ca.diag(ca.DM([1 / c.lever(size) for c in self.closure.role("actuated")]))
        scaled = ca.mtimes(own, shrunk)
        chosen = rows_at(self.closure, scaled, self.samples, self.ranks.rates)
        rates = -ca.mtimes(shrunk, shortest(scaled[chosen, :], twist[chosen, :]))
        others = [k for k in range(own.shape[0]) if k not in chosen]
        return rates, ca.sparsify(twist[others, :] + ca.mtimes(own[others, :], rates))

    @property
    def _to_lengths(self) -> ca.DM:
        """What columns by the motion's twist components are multiplied by, to be columns by
        lengths.
        """
        return ca.diag(ca.DM([1 / self.size if k > 2 else 1.0 for k in self.columns]))

    def _by_lengths(self, rows: ca.SX) -> ca.SX:
        return ca.mtimes(rows, self._to_lengths)


def rows_at(
    closure: Closure, rows: ca.SX, samples: Sequence[np.ndarray], count: int | None = None
) -> list[int]:
    """`count` rows, as many as their largest rank without, that are independent at all samples."""
    evaluate = ca.Function(
        "rows", [closure.variables, closure.parameters], [ca.densify(rows)], {"cse": True}
    )
    left = np.array([np.asarray(evaluate(z, closure.parameter_values)) for z in samples])
    count = max(Rank.of(matrix).value for matrix in left) if count is None else count
    if not count:
        return []
    left /= np.max(np.linalg.norm(left, axis=2), axis=1)[:, None, None]
    chosen = most_independent(left, count, 0.0, together=True)
    return [int(k) for k in np.flatnonzero(chosen.any(axis=0))]


@lru_cache(maxsize=128)
def velocity_equations(mechanism: Mechanism, size: float, *, bound: bool) -> VelocityEquations:
    """The velocity equations of a mechanism; angles times the size are lengths."""
    return VelocityEquations(build_closure(mechanism), size, bound)
