"""What is proved of a block's modes: each one by a certificate, and their number where a theorem
bounds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.systems import whole_system
from symkin.homotopy.values import algebraic_point
from symkin.numeric.system import System
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.roots import Proofs
from symkin.position.solution import PartialProof

if TYPE_CHECKING:
    from symkin.certificate.bounds import Bound
    from symkin.certificate.certificate import Certificates


@dataclass(frozen=True, eq=False)
class Prover:
    """Certificates of a block's complex roots, where the paths' system holds all its coordinates,
    and of its modes.
    """

    problem: Problem
    block: System
    given: Given
    whole: AlgebraicSystem
    bound: Bound | None
    ends: Certificates | None

    @staticmethod
    def of(
        problem: Problem, system: AlgebraicSystem, block: System, ends: np.ndarray, given: Given
    ) -> Prover:
        """`ends` (width, n) are regular complex roots of `system`."""
        from symkin.certificate.bounds import bound_of
        from symkin.certificate.certificate import certify
        from symkin.certificate.exact import knowns_of

        whole, bound = whole_system(problem, block), bound_of(problem, system)
        found, values = None, given.values[None]
        if bound is not None:
            found = certify(
                bound.system, ends, bound.knowns(values), problem.closure.characteristic_length
            )
        elif whole is system and not system.limbs:
            found = certify(
                whole, ends, knowns_of(problem, values), problem.closure.characteristic_length
            )
        return Prover(problem, block, given, whole, bound, found)

    def not_real(self, count: int) -> np.ndarray:
        """Which of the `count` roots are proved not to be real, however near to it."""
        return np.zeros(count, dtype=bool) if self.ends is None else self.ends.real == "not real"

    def proofs(self, points: np.ndarray) -> Proofs:
        """What is proved of real roots `points` (m, width) of the block."""
        from symkin.certificate.bounds import proves
        from symkin.certificate.certificate import certify
        from symkin.certificate.exact import knowns_of

        named = [
            {c.name: z[s] for c, s in zip(self.block.unknowns, self.block.slices, strict=True)}
            for z in points
        ]
        real = [algebraic_point(self.problem, self.whole, values) for values in named]
        found, columns = self.ends, np.array(real).T.reshape(self.whole.width, len(real))
        if found is None or found.system.width != self.whole.width:
            # complex roots are poses, or none: real ones, with passive joints beside the pose, are
            # proved by themselves
            found = certify(
                self.whole,
                columns,
                knowns_of(self.problem, self.given.values[None]),
                self.problem.closure.characteristic_length,
            )
        index, radius = found.batch.find(columns)
        theorem = None
        if (
            self.bound is not None
            and proves(found, self.bound)
            and len(points) == int(np.sum(found.real == "real"))
        ):
            t = self.bound.theorem
            theorem = f"{t.count}: {t.about} ({t.reference})"
        return Proofs(
            index >= 0,
            radius,
            theorem,
            found.distinct,
            next((reason for reason in found.reasons if reason), None)
            if np.any(index < 0)
            else None,
            self._partial(columns, index < 0),
        )

    def _partial(self, z: np.ndarray, open_ones: np.ndarray) -> tuple[PartialProof | None, ...]:
        """What is proved of those of the roots z (width, m) that have no certificate, which is
        where `open_ones` (m,).
        """
        from symkin.certificate.exact import knowns_of
        from symkin.certificate.independent_rows import prove_independent_rows

        found: list[PartialProof | None] = [None] * z.shape[1]
        chosen, knowns = np.flatnonzero(open_ones), knowns_of(self.problem, self.given.values[None])
        proofs = prove_independent_rows(
            self.whole,
            z[:, chosen],
            knowns,
            np.zeros(chosen.size, dtype=int),
            self.problem.closure.characteristic_length,
        )
        for place, proof in zip(chosen.tolist(), proofs, strict=True):
            found[place] = proof
        return tuple(found)


def ground_notes(problem: Problem, grounds: Sequence[PartialProof], count: int) -> list[str]:
    """What is proved of those of `count` modes whose rows are redundant."""
    if not grounds:
        return []
    one, unit = grounds[0], problem.mechanism.length_unit
    every = "each mode" if len(grounds) == count else f"{len(grounds)} of the modes"
    return [
        f"proved of {every}: {one.independent} independent rows of {one.rows} vanish at one exact "
        f"point within "
        f"{max(g.radius for g in grounds):.1e} {unit}, and no other row is more than "
        f"{max(g.remaining for g in grounds):.1e} {unit} there"
    ]
