"""Real roots of one block of a problem at many instances, by formulas, with what is in doubt left to paths.

Where each equation of the formulas is far from a double root and from leaving its unknown undecided, their branches are all solutions
that there are. Every one is polished and checked on all rows as the ends of paths are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from symkin.assembly.block_proofs import BlockProver, block_prover
from symkin.assembly.checked_roots import BlockRoots, Candidates, checked_roots, with_proofs
from symkin.computed_once import cached_property, lru_cache
from symkin.elimination.closed_form import Solutions, closed_form, samples_about
from symkin.homotopy.systems import system_of
from symkin.numeric.system import System
from symkin.position.arm_formulas import arm_formulas
from symkin.position.groups import is_linear
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN

_SOLVES, _FAILS = 1e-7, 1e-4
"""Closure errors, of the size, of branches that are solutions to rounding, and of branches that are none; between them is doubt."""


class Formulas(Protocol):
    """Formulas of all unknowns of a block; `count` solutions over the complex numbers, `steps` the derivation."""

    @property
    def count(self) -> int: ...
    @property
    def steps(self) -> tuple[str, ...]: ...
    def solutions(self, known: np.ndarray) -> Solutions:
        """All values for known values (n, known)."""


@dataclass(frozen=True, eq=False)
class ClosedBlock:
    """A block with its formulas; `regular` are known values (known,) of a regular configuration."""

    problem: Problem
    block: System
    formulas: Formulas
    regular: np.ndarray
    method: ClassVar[str] = "closed"

    @property
    def engine(self) -> str:
        """What finds the roots."""
        return "closed form"

    @property
    def most_roots(self) -> int:
        """Complex roots of a generic instance."""
        return self.formulas.count

    @property
    def notes(self) -> tuple[str, ...]:
        return ()

    @cached_property
    def prover(self) -> BlockProver:
        return block_prover(self.problem, system_of(self.problem, self.block), self.block)

    @property
    def digest(self) -> bytes:
        """What the roots begin from."""
        return "\n".join(self.formulas.steps).encode()

    @property
    def _is_square(self) -> bool:
        """Whether no row is more than the unknowns need."""
        return int(self.block.rows.shape[0]) <= self.block.freedom

    @cached_property
    def is_determined(self) -> bool:
        """Whether each real branch is a solution: where there are more rows than unknowns, known values must meet conditions, and
        some branches may not."""
        if self._is_square:
            return True
        found = self.formulas.solutions(self.regular[None])
        values = found.values[0][found.real[0]]
        return bool(
            found.clear[0] and np.all(self.block.residuals(values, self.regular) <= _SOLVES * self.block.characteristic_length)
        )

    def roots(self, known: np.ndarray, *, certify: bool) -> BlockRoots:
        """Roots at instances known (n, values)."""
        points, real, plain = self.formulas.solutions(known)
        owner, branch = np.nonzero(real & plain[:, None])
        chosen, plain = points[owner, branch], plain.copy()
        complex_count: float = self.formulas.count
        if not self.is_determined:
            # branches must meet further conditions, and only real ones are held against them
            complex_count = NOT_KNOWN
            left = self.block.residuals(chosen, known[owner]) / self.block.characteristic_length
            plain[owner[(left > _SOLVES) & (left < _FAILS)]] = False
            chosen, owner = chosen[left <= _SOLVES], owner[left <= _SOLVES]
        candidates = Candidates(chosen, owner, np.full(len(owner), -1))
        found, kept = checked_roots(self.block, candidates, known, plain, np.full(len(known), complex_count))
        # a branch that solves all steps and fails the check leaves a doubt
        plain[np.bincount(owner, minlength=len(known)) != found.counts] = False
        return with_proofs(found, self.prover, None, known, kept, required=self._certifies) if certify else found

    @cached_property
    def _certifies(self) -> bool:
        """Whether roots can be certified: with more rows than unknowns, where those of a regular configuration can."""
        if self._is_square:
            return True
        found = self.roots(self.regular[None], certify=False)
        proofs = self.prover.roots(None, found.points, found.owner, self.regular[None], np.full(len(found.owner), -1))
        return bool(len(found.owner) and proofs.certified.all())


@lru_cache(maxsize=256)
def closed_block(problem: Problem, number: int) -> ClosedBlock | None:
    """One of a problem's blocks with the formulas that solve it; None where there are none."""
    block, arm = problem.blocks[number], arm_formulas(problem)
    if arm is not None:
        return ClosedBlock(problem, block, arm, arm.random_known())
    if problem.is_explicit or (problem.kind == "given" and is_linear(problem)):
        return None
    near = problem.reference_known
    found = closed_form(block, samples_about(block, near))
    return None if found is None else ClosedBlock(problem, block, found, near)
