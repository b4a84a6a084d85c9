"""Say which rows and columns of the velocity equations belong to each limb, and their ranks at a
configuration.

Limb i has the rows A_i t + P_i x' + B_i q' = 0. Without the rates x' of its passive joints (see
`limb_equations`), the rank of what is left of B_i says how many of the limb's actuated rates the
twist decides; rows that hold whatever the limb's joints do are its constraint wrenches (Gosselin
and Angeles 1990; Zlatanov, Bonev and Gosselin 2002).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.closure.closure import Closure
from symkin.numeric.rank import independent_rows, rank_of
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import whole_system
from symkin.velocity.limb_equations import limb_blocks, limbwise_equations
from symkin.velocity.roles import columns_by_name


@dataclass(frozen=True)
class LimbPart:
    """Where a limb stands in the equations: its rows, the columns of its passive joints (without
    those that are left at rest, since their motion moves nothing else) and of its actuated joints;
    `rank` is that of its actuated columns once the passive ones are eliminated, at generic closed
    configurations.
    """

    name: str
    rows: tuple[int, ...]
    passive: tuple[int, ...]
    actuated: tuple[int, ...]
    rank: int

    @property
    def is_redundant(self) -> bool:
        """The platform's motion does not decide the rates of its actuated joints."""
        return self.rank < len(self.actuated)


@dataclass(frozen=True, eq=False, kw_only=True)
class LimbRanks:
    """The limbs' parts of the velocity equations; `constraints` is the number of twists that the
    limbs forbid among the motion's, `freedom` that of the twists that remain with the actuated
    joints held (0 where the direct Jacobian is defined).
    """

    limbs: tuple[LimbPart, ...] = ()
    constraints: int = 0
    freedom: int = 0

    @property
    def genericity(self) -> tuple[int, int, int, int]:
        """Ranks in an order in which a generic configuration has the largest."""
        ranks = sum(part.rank for part in self.limbs)
        return sum(len(part.passive) for part in self.limbs), ranks, self.constraints, -self.freedom


def ranks_at(closure: Closure, row_limbs: Sequence[str], values: np.ndarray) -> LimbRanks:
    """The limbs' parts and ranks at one closed configuration; `row_limbs` names the limb of each
    row of the equations.
    """
    equations = limbwise_equations(closure, values, RANK_TOLERANCE)
    _, jacobian = whole_system(closure).linearise_one(values, np.zeros(0))
    actuated, passive = (
        columns_by_name(closure, [c.name for c in closure.role(role)])
        for role in ("actuated", "passive")
    )
    parts = []
    for block, limb in zip(limb_blocks(closure), equations.limbs, strict=True):
        used = independent_columns(jacobian[block.rows], block.passive)
        parts.append(
            LimbPart(
                block.limb,
                rows=tuple(k for k, name in enumerate(row_limbs) if name == block.limb),
                passive=tuple(passive.index(k) for k in used),
                actuated=tuple(actuated.index(k) for k in block.actuated),
                rank=rank_of(limb.rates, RANK_TOLERANCE),
            )
        )
    freedom = len(equations.motion.T) - rank_of(equations.twist, RANK_TOLERANCE)
    constraints = rank_of(equations.constraints, RANK_TOLERANCE)
    return LimbRanks(limbs=tuple(parts), constraints=constraints, freedom=freedom)


def independent_columns(matrix: np.ndarray, among: list[int]) -> list[int]:
    """Columns that span those `among`, in order, chosen by largest remaining part; RANK_TOLERANCE
    of the largest decides.
    """
    columns = matrix[:, among].T
    largest = float(np.max(np.linalg.norm(columns, axis=1), initial=0.0))
    return [among[k] for k in sorted(independent_rows(columns, RANK_TOLERANCE * largest))]
