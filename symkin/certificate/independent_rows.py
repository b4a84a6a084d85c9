"""What is proved where rows are redundant: an exact root of as many independent rows as their rank, and a bound of the others.

No arithmetic with rounding can show that redundant rows vanish together. It can show that some of them do at one exact point
within a stated radius, and how far the others are from zero there at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from flint import arb

from symkin.certificate.ball_system import BallSystem
from symkin.certificate.certificate import certify
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import REAL, UP, Number, precision, upper
from symkin.position.solution import PartialProof

_RANK = 1e-8
"""Share of the longest row's length below which what is left of a row is none of its own."""
_BITS = 128


def prove_independent_rows(system: AlgebraicSystem, z: np.ndarray, known: Sequence[Number], size: float) -> PartialProof | None:
    """The proof about a real root z (width,) of more rows than unknowns; None where as many independent rows as unknowns are
    not found there, or no proof is."""
    freedom = system.width - bool(system.projective)
    if system.count <= freedom:
        return None
    chosen = independent_rows(system, z, np.array([float(v) for v in known], dtype=complex))
    if len(chosen) < freedom:
        return None
    found = certify(_part(system, chosen), z[:, None], known, size)
    if not (found.certified[0] and found.real[0] == "real" and found.pose[0]):
        return None
    with precision(_BITS):
        side = arb(0.0, float(found.ball[0]))
        box = [arb(float(c)) + side for c in found.centre[:, 0].real]
        values = BallSystem(system, tuple(known)).rows(REAL, box)
        others = [upper(v) for i, v in enumerate(values) if i not in chosen]
    return PartialProof(len(chosen), system.count, float(found.radius[0]), max(others, default=0.0) * size * UP)


def independent_rows(system: AlgebraicSystem, z: np.ndarray, known: np.ndarray) -> tuple[int, ...]:
    """As many rows as the rank at a point, the most independent ones."""
    _, jacobian = system.linearise(z[:, None].astype(complex), known[:, None])
    return most_independent(jacobian[0], system.width - bool(system.projective))


def most_independent(matrix: np.ndarray, most: int) -> tuple[int, ...]:
    """At most so many rows of a matrix: one after another the row that is farthest from the span of those taken."""
    left, first = matrix.copy(), 0.0
    chosen: list[int] = []
    while len(chosen) < most and np.isfinite(left).all():
        lengths = np.linalg.norm(left, axis=1)
        best = int(np.argmax(lengths))
        first = first or float(lengths[best])
        if not lengths[best] > _RANK * max(first, 1e-300):
            break
        chosen.append(best)
        along = left[best] / lengths[best]
        left = left - np.outer(left @ np.conj(along), along)
    return tuple(sorted(chosen))


@lru_cache(maxsize=256)
def _part(system: AlgebraicSystem, chosen: tuple[int, ...]) -> AlgebraicSystem:
    return replace(system, rows=system.rows[list(chosen), 0])
