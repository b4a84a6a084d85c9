"""Eliminate the passive joints from each limb's velocity equations, in one normal form.

Where what is driven and what is wanted are told by name (see `roles`), t and q' are these, x' all
other rates, and a "limb" is a part of the rows that shares no x' with others. The rows of limb i,
differentiated, are A_i t + P_i x' + B_i q' = 0. With the rows of U_i spanning the y for which y
P_i = 0, what is left is U_i A_i t + U_i B_i q' = 0, and an orthonormal basis of these rows,

    a_i t + b_i q' = 0,    a_i a_i^T + b_i b_i^T = 1,

depends neither on how the closure is written nor on units. Twists are t = (velocity of the platform
origin; size times angular velocity) on the coordinates of the platform's motion, rates of angles
are times the size. The rows a_i are the wrenches that the limb can exert while its actuated joints
are held; those with b_i = 0 are its constraints.

Ranks are counted at the configuration itself, so that more is said where one is lost, and rows of
unit length make distances that do not depend on the closure's rows. Those of generic configurations
are the ranks of the symbolic elimination (see `equations`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.numeric.rank import count_above, null_space, rank_of
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.position.closed_configurations import whole_system
from symkin.velocity.differential import motion_columns
from symkin.velocity.roles import Roles

_SHORTEST_ROW = 1e-4
"""Rows of the closure have derivatives of about 1; a limb whose rows are all below this times the
rank tolerance has none.
"""


@dataclass(frozen=True, eq=False)
class LimbEquations:
    """`twist` (k, r) and `rates` (k, n) of one limb, rows orthonormal together; `constraints` (c,
    r), rows orthonormal, are the wrenches that it exerts whatever its actuated joints do. `idle`
    counts passive motions that move neither platform nor actuated joints, `passive` are the
    singular values of P_i, all rows of the limb orthonormal.
    """

    limb: str
    twist: np.ndarray
    rates: np.ndarray
    constraints: np.ndarray
    passive: np.ndarray
    idle: int


@dataclass(frozen=True, eq=False)
class LimbwiseEquations:
    """All limbs at one configuration; `motion` (6, r) maps the twist coordinates to (velocity; size
    times angular velocity). `spectrum` are the singular values of all rows by all rates, over the
    largest, one for each rate.
    """

    limbs: tuple[LimbEquations, ...]
    motion: np.ndarray
    spectrum: np.ndarray

    @property
    def twist(self) -> np.ndarray:
        """The matrix of the direct problem, (k, r): type 2 where it loses rank."""
        return np.vstack([limb.twist for limb in self.limbs])

    @property
    def rates(self) -> np.ndarray:
        """The matrix of the inverse problem, (k, n): type 1 where it loses rank."""
        return np.vstack([limb.rates for limb in self.limbs])

    @property
    def constraints(self) -> np.ndarray:
        """Wrenches that the platform bears from all limbs with every actuated joint free, (c,
        r).
        """
        return np.vstack([limb.constraints for limb in self.limbs])

    @property
    def idle(self) -> int:
        return sum(limb.idle for limb in self.limbs)


@dataclass(frozen=True)
class Ranks:
    """What is counted at a configuration: feasible motions (t, q') and the ranks of their parts,
    passive motions alone, and the ranks of A, of B and of the constraint wrenches C.
    """

    motions: int
    inputs: int
    outputs: int
    idle: int
    twist: int
    rates: int
    constraints: int

    @staticmethod
    def of(equations: LimbwiseEquations, tolerance: float) -> Ranks:
        motions = feasible_motions(equations, tolerance)
        r = equations.twist.shape[1]
        return Ranks(
            motions=len(motions),
            inputs=rank_of(motions[:, r:], tolerance),
            outputs=rank_of(motions[:, :r], tolerance),
            idle=equations.idle,
            twist=rank_of(equations.twist, tolerance),
            rates=rank_of(equations.rates, tolerance),
            constraints=rank_of(equations.constraints, tolerance),
        )

    @staticmethod
    def generic(found: Iterable[Ranks]) -> Ranks:
        """Of ranks at several configurations those with the fewest motions."""
        return min(found, key=lambda ranks: (ranks.freedoms, -ranks.twist, -ranks.rates))

    @property
    def freedoms(self) -> int:
        """Freedoms of the whole mechanism: feasible motions and those of passive joints alone."""
        return self.motions + self.idle

    @property
    def permanent_freedoms(self) -> dict[str, int]:
        """Of generic ranks: freedoms of each kind of singularity that every configuration has,
        where there are any.
        """
        counts = {
            "type 1": self.motions - self.outputs,
            "type 2": self.motions - self.inputs,
            "passive": self.idle,
        }
        return {kind: count for kind, count in counts.items() if count}

    def at_other_assembly(self, here: Ranks) -> Ranks:
        """Generic ranks for a configuration whose limbs constrain less than at the reference
        although it moves no more freely in all: its rows are as independent as they ever are, so
        that no constraint is lost there; the limbs lie in another assembly, with fewer freedoms of
        their own.
        """
        if here.constraints < self.constraints and here.freedoms <= self.freedoms:
            return replace(self, constraints=here.constraints)
        return self


def feasible_motions(equations: LimbwiseEquations, tolerance: float) -> np.ndarray:
    """Orthonormal rows (t, q') with A t + B q' = 0."""
    return null_space(np.hstack([equations.twist, equations.rates]), tolerance)


def limbwise_equations(
    closure: Closure, values: np.ndarray, tolerance: float, roles: Roles | None = None
) -> LimbwiseEquations:
    """The normal form at a closed configuration (a full vector of variables). Singular values below
    `tolerance` count as zero.
    """
    roles = roles or Roles.of_limbs(closure.mechanism)
    _, jacobian = whole_system(closure).linearise_one(values, np.zeros(0))
    outputs, inputs = roles.output_columns(closure), roles.input_columns(closure)
    # parts that loops share lose rank together at a configuration that is known to half of its
    # digits only
    dependent = max(tolerance, roles.dependent_rows) if roles.by_name else RANK_TOLERANCE
    limbs = [
        eliminated(
            block.limb,
            row_basis(jacobian[block.rows], dependent),
            outputs,
            inputs,
            block.passive,
            tolerance,
        )
        for block in limb_blocks(closure, roles)
    ]
    nothing = eliminated("", np.zeros((0, jacobian.shape[1])), outputs, inputs, [], tolerance)
    motion = motion_basis(closure) if roles.has_twist else np.zeros((6, len(outputs)))
    return LimbwiseEquations(tuple(limbs) or (nothing,), motion, _spectrum(jacobian))


def _spectrum(jacobian: np.ndarray) -> np.ndarray:
    """Singular values over the largest, one for each column."""
    found = np.zeros(jacobian.shape[1])
    singular = np.linalg.svd(jacobian, compute_uv=False) if min(jacobian.shape) else np.zeros(0)
    found[: len(singular)] = singular / max(float(np.max(singular, initial=0.0)), _SHORTEST_ROW)
    return found


def motion_basis(closure: Closure) -> np.ndarray:
    """(6, r): the unit motions of the platform's coordinates as (velocity of its origin; size times
    angular velocity).
    """
    return np.eye(6)[:, motion_columns(closure)]


@dataclass(frozen=True, eq=False)
class LimbBlock:
    """Where a limb stands in the closure's Jacobian: its rows, and the columns of the actuated and
    the passive joints in them.
    """

    limb: str
    rows: list[int]
    actuated: list[int]
    passive: list[int]

    @property
    def joints(self) -> list[int]:
        """The columns of all of its joints, in order."""
        return sorted(self.actuated + self.passive)


@lru_cache(maxsize=128)
def limb_blocks(closure: Closure, roles: Roles | None = None) -> tuple[LimbBlock, ...]:
    """The limbs' blocks, in the order of their rows; limbs that share passive coordinates are
    one.
    """
    roles = roles or Roles.of_limbs(closure.mechanism)
    inputs = roles.input_columns(closure)
    owners, others = closure.owners, {*inputs, *roles.output_columns(closure)}
    passive = [k for k in range(len(owners)) if k not in others]
    pattern = np.asarray(ca.DM(ca.jacobian_sparsity(closure.rows, closure.variables), 1)) != 0

    def held(columns: list[int], rows: list[int]) -> list[int]:
        return [k for k in columns if pattern[rows, closure.slices[owners[k].name]].any()]

    parts: list[tuple[str, list[int]]] = []
    for name in dict.fromkeys(row.limb for row in closure.row_sources):
        own = [k for k, row in enumerate(closure.row_sources) if row.limb == name]
        shared = [part for part in parts if set(held(passive, part[1])) & set(held(passive, own))]
        parts = [part for part in parts if part not in shared]
        parts.append(
            (
                shared[0][0] if shared else name,
                sorted([*(k for part in shared for k in part[1]), *own]),
            )
        )
    return tuple(
        LimbBlock(name, rows, held(inputs, rows), held(passive, rows)) for name, rows in parts
    )


def eliminated(
    name: str,
    rows: np.ndarray,
    pose: list[int],
    actuated: list[int],
    passive: list[int],
    tolerance: float,
) -> LimbEquations:
    """One limb's rows (m, all columns) without its passive joints; columns by number."""
    rows = row_basis(rows)
    left, singular, _ = np.linalg.svd(rows[:, passive])
    rank = count_above(singular, tolerance)
    kept = row_basis(left[:, rank:].T @ rows[:, [*pose, *actuated]])
    twist, rates = kept[:, : len(pose)], kept[:, len(pose) :]
    padded = np.zeros(len(passive))
    padded[: len(singular)] = singular
    return LimbEquations(
        name, twist, rates, null_space(rates.T, tolerance) @ twist, padded, len(passive) - rank
    )


def row_basis(rows: np.ndarray, tolerance: float = RANK_TOLERANCE) -> np.ndarray:
    """Orthonormal rows of the same span; rows that others imply are dropped, singular values below
    `tolerance` of the largest.
    """
    _, lengths, basis = np.linalg.svd(rows, full_matrices=False)
    return basis[lengths > tolerance * max(float(np.max(lengths, initial=0.0)), _SHORTEST_ROW)]
