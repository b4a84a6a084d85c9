"""Write the velocity equations A t + P x' + B q' = 0 of a closure, and count their ranks.

t is the twist (velocity of the platform's or tool's origin; angular velocity), both in the base
frame, q' are the rates of the actuated joints in file order and x' those of the passive joints that
the closure has. Passive joints are eliminated with orthogonal projections: with U spanning the
columns of P, (1 - U U^T)(A t + B q') = 0, so that redundant rows, redundant actuation and serial
arms (whose rows are t - J q' = 0) need no case of their own. Ranks of what is left of a limb say
how many of its actuated rates the twist decides, and which twists it forbids whatever its joints do
(Gosselin and Angeles 1990; Zlatanov, Bonev and Gosselin 2002).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.machine.lower import arm_or_limbs
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import independent_rows, rank_of
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations, whole_system
from symkin.position.solution import Solution
from symkin.position.transfer import many_of_machine, own_closure
from symkin.velocity.differential import Differential, differentiate, motion_columns
from symkin.velocity.limb_equations import limbwise_equations
from symkin.velocity.roles import columns_by_name


@dataclass(frozen=True, eq=False)
class VelocityEquations:
    """A, P and B of a mechanism (see `Differential`), as expressions of the closure's variables and
    parameters, with their ranks at generic closed configurations.

    `used` are the columns of P but for those of joints that are left at rest, since their motion
    moves nothing else; `decided` counts the actuated rates that the twist decides, `constraints`
    the twists that the limbs forbid among the motion's, `freedom` those that remain with the
    actuated joints held (0 where the direct Jacobian is defined). Rates are in the length unit or
    rad per unit of time; a passive unit quaternion has three columns, its angular velocity in the
    frame before the joint, axes as at the reference.
    """

    closure: Closure
    differential: Differential
    used: tuple[int, ...] = ()
    decided: int = 0
    constraints: int = 0
    freedom: int = 0

    @property
    def columns(self) -> tuple[int, ...]:
        """The twist's components that the platform's motion has."""
        return tuple(motion_columns(self.closure))

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Pickle as the mechanism, from which the symbols are built anew."""
        return velocity_equations, (self.closure.mechanism,)

    @property
    def genericity(self) -> tuple[int, int, int, int]:
        """Ranks in an order in which a generic configuration has the largest."""
        return len(self.used), self.decided, self.constraints, -self.freedom

    def at(self, values: np.ndarray) -> VelocityEquations:
        """The equations with the ranks of a closed configuration."""
        found = limbwise_equations(self.closure, values, RANK_TOLERANCE)
        _, jacobian = whole_system(self.closure).linearise_one(values, np.zeros(0))
        names = [c.name for c in self.closure.role("passive", "body")]
        passive = jacobian[:, columns_by_name(self.closure, names)].T
        largest = float(np.max(np.linalg.norm(passive, axis=1), initial=0.0))
        return replace(
            self,
            used=tuple(sorted(independent_rows(passive, RANK_TOLERANCE * largest))),
            decided=sum(rank_of(limb.rates, RANK_TOLERANCE) for limb in found.limbs),
            constraints=rank_of(found.constraints, RANK_TOLERANCE),
            freedom=len(found.motion.T) - rank_of(found.twist, RANK_TOLERANCE),
        )

    def is_generic(self, values: np.ndarray) -> bool:
        """Whether the ranks at a closed configuration are those of generic ones."""
        return self.at(values).genericity == self.genericity


@lru_cache(maxsize=128)
def velocity_equations(mechanism: Mechanism) -> VelocityEquations:
    """The velocity equations of a mechanism; ranks are judged at closed configurations near the
    reference (seed 0).
    """
    closure = build_closure(mechanism)
    blank = VelocityEquations(closure, differentiate(closure))
    return max(
        (blank.at(values) for values in closed_configurations(closure, 0)),
        key=lambda found: found.genericity,
    )


def variables_of(
    closure: Closure,
    values: Solution | Mapping[str, Any] | np.ndarray,
    needed: Collection[str] | None = None,
) -> np.ndarray:
    """The full vector of a closure's variables from a Solution, its `values`, or the vector itself;
    coordinates that are not `needed` may be missing, and are NaN then.
    """
    named: Any = values
    if isinstance(values, Solution):
        low = None if values.mechanism == closure.mechanism else arm_or_limbs(values.mechanism)
        if (values.mechanism if low is None else low.machine) == closure.mechanism:
            own = own_closure(values)
            named = many_of_machine(closure, own, values.variables[None], low)[0]
        else:
            named = values.all_values
    if isinstance(named, Mapping):
        names = [c.name for c in closure.coordinates if needed is None or c.name in needed]
        missing = [name for name in names if name not in named]
        if missing:
            raise InputError(f"values: {missing[0]} is missing; needed are {', '.join(names)}")
        parts = [
            np.atleast_1d(np.asarray(named.get(c.name, [np.nan] * c.width), dtype=float))
            for c in closure.coordinates
        ]
        named = np.concatenate(parts)
    vector = np.asarray(named, dtype=float)
    if vector.shape != closure.reference.shape:
        raise InputError(
            f"values: shape {vector.shape} given, the closure has {closure.reference.size} "
            f"variables"
        )
    return vector
