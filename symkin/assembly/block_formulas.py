"""Real roots of one block of a problem at many instances, by formulas, with what is in doubt left to others."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.assembly.block_proofs import BlockProver, block_prover
from symkin.assembly.block_roots import BlockRoots, Candidates, checked_roots
from symkin.computed_once import cached_property, lru_cache
from symkin.elimination.closed_form import ClosedForm, closed_form, samples_about
from symkin.homotopy.systems import system_of
from symkin.numeric.system import System
from symkin.position.problem import Problem


@dataclass(frozen=True, eq=False)
class BlockFormulas:
    """A block with its closed form."""

    problem: Problem
    block: System
    formulas: ClosedForm

    engine = "closed form"
    notes: tuple[str, ...] = ()

    @property
    def digest(self) -> bytes:
        """The derivation, by which the formulas are decided."""
        return "\n".join(self.formulas.steps).encode()

    @property
    def most_roots(self) -> int:
        """Complex roots of a generic instance."""
        return self.formulas.count

    @cached_property
    def prover(self) -> BlockProver:
        return block_prover(self.problem, system_of(self.problem, self.block), self.block)

    def roots(self, known: np.ndarray, *, certify: bool) -> BlockRoots:
        """Roots at instances known (n, values). One is plain where the formulas are clear and all their real values are roots."""
        found = self.formulas.solutions(known)
        owner, which = np.nonzero(found.real & found.clear[:, None])
        candidates = Candidates(found.values[owner, which], owner, np.full(len(owner), -1))
        counts = np.full(len(known), self.formulas.count)
        roots, _ = checked_roots(self.block, candidates, known, found.clear.copy(), counts)
        lost = roots.counts != np.bincount(owner, minlength=len(known))
        roots.plain[lost] = False
        if not certify:
            return roots
        proofs = self.prover.roots(None, roots.points, roots.owner, known, np.full(len(roots.points), -1))
        if self.block.rows.shape[0] == self.block.freedom:
            # where no row is redundant a regular root can be certified
            roots.plain[roots.owner[~proofs.certified]] = False
        return replace(roots, proofs=proofs)


@lru_cache(maxsize=256)
def block_formulas(problem: Problem, number: int) -> BlockFormulas | None:
    """The closed form of one of a problem's blocks, whatever is given; None where none is found."""
    block = problem.blocks[number]
    found = closed_form(block, samples_about(block, problem.reference_known))
    return None if found is None else BlockFormulas(problem, block, found)
