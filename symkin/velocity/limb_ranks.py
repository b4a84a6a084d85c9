"""The blocks of the velocity equations, limb by limb, and their ranks at a configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.closure.closure import Closure
from symkin.numeric.rank import RANK_TOLERANCE, Rank
from symkin.velocity.velocity_matrices import VelocityMatrices, span_projector


@dataclass(frozen=True)
class LimbPart:
    """Where a limb stands in the equations: its rows, the columns of its passive joints (`held` are those left at rest,
    since their motion moves nothing else) and of its actuated joints; `rank` is that of its actuated columns once the
    passive ones are eliminated, at generic closed configurations."""

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


Structure = tuple[tuple[LimbPart, ...], int, int]


def structure(matrices: VelocityMatrices) -> Structure:
    """Blocks and ranks at one closed configuration."""
    equations, closure = matrices.equations, matrices.equations.closure
    actuated_limb, passive_limb = _limb_of_columns(closure)
    parts, twists, constraints = [], [], []
    for limb in closure.mechanism.limbs:
        rows = tuple(k for k, name in enumerate(equations.differential.limbs) if name == limb.name)
        twist, passive, actuated = (matrix[list(rows)] for matrix in matrices.scaled)
        own = [k for k, name in enumerate(passive_limb) if name == limb.name]
        used = independent_columns(passive, own)
        span = span_projector(passive[:, used], len(used))
        joints = tuple(k for k, name in enumerate(actuated_limb) if name == limb.name)
        free = (actuated - span @ actuated)[:, joints]
        rank = Rank.of(_beside(free, actuated)).value
        twists.append(twist - span @ twist)
        constraints.append(twists[-1] - span_projector(free, rank) @ twists[-1])
        held = tuple(k for k in own if k not in used)
        parts.append(LimbPart(limb.name, rows, tuple(used), held, joints, rank))
    r = len(equations.columns)
    return tuple(parts), Rank.of(_beside(np.vstack(constraints), matrices.scaled[0])).value, r - Rank.of(np.vstack(twists)).value


def _beside(matrix: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """The matrix, or zeros where it is but rounding noise of what it was made from."""
    return matrix if np.max(np.abs(matrix), initial=0.0) > RANK_TOLERANCE * np.max(np.abs(whole), initial=0.0) else 0.0 * matrix


def genericity(structure: Structure) -> tuple[int, int, int, int]:
    limbs, constraints, freedom = structure
    return sum(len(part.passive) for part in limbs), sum(part.rank for part in limbs), constraints, -freedom


def _limb_of_columns(closure: Closure) -> tuple[list[str], list[str]]:
    """The limb of each actuated and of each passive column."""
    limb_of = {c.name: limb.name for limb, joint in closure.mechanism.joints for c in joint.coordinates}
    both = []
    for role in ("actuated", "passive"):
        both.append([limb_of.get(c.name, c.name) for c in closure.role(role) for _ in range(c.freedom)])
    return both[0], both[1]


def independent_columns(matrix: np.ndarray, among: list[int]) -> list[int]:
    """Columns that span those `among`, in order, chosen by largest remaining part; RANK_TOLERANCE of the largest decides."""
    left = matrix[:, among].copy()
    norms = np.linalg.norm(left, axis=0)
    largest = float(np.max(norms, initial=0.0))
    chosen: list[int] = []
    while len(chosen) < min(left.shape):
        k = int(np.argmax(norms))
        if norms[k] <= RANK_TOLERANCE * largest:
            break
        chosen.append(k)
        direction = left[:, k] / norms[k]
        left -= np.outer(direction, direction @ left)
        norms = np.linalg.norm(left, axis=0)
        norms[chosen] = 0.0
    return [among[k] for k in sorted(chosen)]
