"""Real roots of a block of limbs at many instances by its parts: a pose by rows that the limbs
imply, then the passive joints of each limb. What is in doubt is left to others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.block_solver import BlockSolver
from symkin.assembly.checked_roots import BlockRoots, with_proofs
from symkin.assembly.closed_roots import ClosedBlock
from symkin.assembly.group_roots import STATEMENTS, engines_together
from symkin.assembly.group_solvers import most_of_parts, solvers_of
from symkin.assembly.search import Search
from symkin.assembly.tree import roots_of_parts
from symkin.computed_once import cached_property
from symkin.numeric.linear_algebra import extreme_singular_values
from symkin.numeric.root_checks import are_suspect
from symkin.position.problem import Problem


@dataclass(frozen=True, eq=False)
class PartedBlock(BlockSolver):
    """The group that a direct problem is, solved by its `parts` (`group_solvers.parted_group`)."""

    parts: tuple[Problem, ...]

    @property
    def engine(self) -> str:
        """What tracks the paths or has the formulas."""
        return engines_together(solver.engine for solver in self._solvers) or "none"

    @cached_property
    def _solvers(self) -> list[BlockPaths | ClosedBlock]:
        return [solver for part in self.parts for solver in solvers_of(part)]

    @cached_property
    def most_roots(self) -> int:
        """Complex roots of a generic instance."""
        count = most_of_parts(self.parts)
        assert count is not None  # noqa: S101 - parts are taken where each tells its count
        return count

    @property
    def digest(self) -> bytes:
        """What the roots begin from."""
        return b"".join(solver.digest for solver in self._solvers)

    def roots(self, known: np.ndarray, *, certify: bool) -> BlockRoots:
        """Roots at instances known (n, values)."""
        found = roots_of_parts(self.problem, self.parts, known, Search.of(None))
        here = known[found.owner]
        extremes = extreme_singular_values(self.block.linearise(found.points, here)[1])
        plain = (found.statement <= STATEMENTS.index("probability one")) & ~found.continuum
        plain[found.owner[are_suspect(extremes)]] = False
        roots = BlockRoots(
            points=found.points,
            owner=found.owner,
            residual=self.block.residuals(found.points, here),
            extremes=extremes,
            plain=plain,
            complex_count=found.complex_count,
        )
        if not certify:
            return roots
        required = not self.prover.is_redundant
        return with_proofs(
            roots, self.prover, None, self.prover.knowns(known), None, required=required
        )
