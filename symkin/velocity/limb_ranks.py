"""Which rows and columns of the velocity equations belong to each limb, and their ranks at a
configuration.

Limb i has the rows A_i t + P_i x' + B_i q' = 0. With E_i = 1 - U_i U_i^T, U_i an orthonormal basis
of the columns of P_i, the rates x' of its passive joints drop out: E_i A_i t + E_i B_i q' = 0. The
rank of E_i B_i says how many of the limb's actuated rates the twist decides. With V_i an
orthonormal basis of the columns of E_i B_i, the rows (1 - V_i V_i^T) E_i A_i hold whatever the
limb's joints do: they are its constraint wrenches (Gosselin and Angeles 1990; Zlatanov, Bonev and
Gosselin 2002).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.closure.closure import Closure
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank, independent_rows
from symkin.numeric.tolerances import RANK_TOLERANCE

Matrices = tuple[np.ndarray, np.ndarray, np.ndarray]
"""A, P and B, the matrices of twist, passive and actuated rates, rows and columns in lengths."""


@dataclass(frozen=True)
class LimbPart:
    """Where a limb stands in the equations: its rows, the columns of its passive joints (`held` are
    those left at rest, since their motion moves nothing else) and of its actuated joints; `rank` is
    that of its actuated columns once the passive ones are eliminated, at generic closed
    configurations.
    """

    name: str
    rows: tuple[int, ...]
    passive: tuple[int, ...]
    held: tuple[int, ...]
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


@dataclass(frozen=True, eq=False, kw_only=True)
class LimbStructure(LimbRanks):
    """What the velocity equations of a mechanism have in common at all generic configurations:
    their ranks, `columns`, the twist's components that the platform's motion has, and `scales`,
    which make lengths of twists, passive and actuated rates (the size for angles, 1 for lengths).
    """

    mechanism: Mechanism
    columns: tuple[int, ...]
    scales: Matrices

    def scaled(self, twist: np.ndarray, passive: np.ndarray, actuated: np.ndarray) -> Matrices:
        """A (the motion's columns), P and B with columns by rates in lengths."""
        by_twist, by_passive, by_actuated = self.scales
        return (
            twist[:, self.columns] / by_twist[list(self.columns)],
            passive / by_passive,
            actuated / by_actuated,
        )


def ranks_at(closure: Closure, row_limbs: Sequence[str], scaled: Matrices) -> LimbRanks:
    """The limbs' parts and ranks at one closed configuration, from A, P and B in lengths there;
    `row_limbs` names the limb of each row.
    """
    actuated_limb, passive_limb = _limb_of_columns(closure)
    parts, twists, constraints = [], [], []
    for limb in closure.mechanism.limbs:
        rows = tuple(k for k, name in enumerate(row_limbs) if name == limb.name)
        twist, passive, actuated = (matrix[list(rows)] for matrix in scaled)
        own = [k for k, name in enumerate(passive_limb) if name == limb.name]
        used = independent_columns(passive, own)
        span = span_projector(passive[:, used], len(used))
        joints = tuple(k for k, name in enumerate(actuated_limb) if name == limb.name)
        free = (actuated - span @ actuated)[:, joints]
        rank = Rank.of(_without_noise(free, actuated)).value
        twists.append(twist - span @ twist)
        constraints.append(twists[-1] - span_projector(free, rank) @ twists[-1])
        held = tuple(k for k in own if k not in used)
        parts.append(
            LimbPart(limb.name, rows, passive=tuple(used), held=held, actuated=joints, rank=rank)
        )
    forbidden = Rank.of(_without_noise(np.vstack(constraints), scaled[0])).value
    freedom = scaled[0].shape[1] - Rank.of(np.vstack(twists)).value
    return LimbRanks(limbs=tuple(parts), constraints=forbidden, freedom=freedom)


def span_projector(matrix: np.ndarray, rank: int) -> np.ndarray:
    """The orthogonal projector U U^T onto the span of the columns of a matrix of known rank."""
    left = (
        np.linalg.svd(matrix, full_matrices=False)[0][:, :rank]
        if rank
        else np.zeros((len(matrix), 0))
    )
    return np.asarray(left @ left.T)


def independent_columns(matrix: np.ndarray, among: list[int]) -> list[int]:
    """Columns that span those `among`, in order, chosen by largest remaining part; RANK_TOLERANCE
    of the largest decides.
    """
    columns = matrix[:, among].T
    largest = float(np.max(np.linalg.norm(columns, axis=1), initial=0.0))
    return [among[k] for k in sorted(independent_rows(columns, RANK_TOLERANCE * largest))]


def _without_noise(matrix: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """The matrix, or zeros where it is but rounding noise of what it was made from."""
    return (
        matrix
        if np.max(np.abs(matrix), initial=0.0) > RANK_TOLERANCE * np.max(np.abs(whole), initial=0.0)
        else 0.0 * matrix
    )


def _limb_of_columns(closure: Closure) -> tuple[list[str], list[str]]:
    """The limb of each actuated and of each passive column; a rod's coordinate is named as its
    limb.
    """
    limb_of = {
        c.name: limb.name for limb, joint in closure.mechanism.joints for c in joint.coordinates
    }
    actuated, passive = (
        [limb_of.get(c.name, c.name) for c in closure.role(role) for _ in range(c.freedom)]
        for role in ("actuated", "passive")
    )
    return actuated, passive
