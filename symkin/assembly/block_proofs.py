"""What is proved of the roots of one block at many instances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.systems import whole_system
from symkin.homotopy.values import algebraic_points
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.position.solution import PartialProof

if TYPE_CHECKING:
    from symkin.certificate.bounds import Bound
    from symkin.certificate.certificate import CertificateBatch


@dataclass(frozen=True, eq=False)
class RootProofs:
    """Of each root (m,): whether it is certified, and its radius (length unit; NaN without
    certificate); of each instance (n,): whether as many roots are certified as a theorem allows.
    """

    certified: np.ndarray
    radius: np.ndarray
    complete: np.ndarray


@dataclass(frozen=True, eq=False)
class BlockProver:
    """Certificates of a block's roots: of all complex ones where the paths' system holds all its
    coordinates, else of the real ones. `bound` is a theorem on their number, where one is known.
    """

    problem: Problem
    block: System
    whole: AlgebraicSystem
    bound: Bound | None
    proves_ends: bool

    @property
    def theorem(self) -> str | None:
        """The bound in words."""
        if self.bound is None:
            return None
        t = self.bound.theorem
        return f"{t.count}: {t.about} ({t.reference})"

    def ends(self, z: np.ndarray, known: np.ndarray, instance: np.ndarray) -> CertificateBatch:
        """Certificates of complex roots z (width, m) of the instances known (n, values), where
        these say all (`proves_ends`).
        """
        from symkin.certificate.certificate import certify_batch
        from symkin.certificate.exact import knowns_of

        if self.bound is not None:
            return certify_batch(
                self.bound.system,
                z,
                self.bound.knowns(known),
                instance,
                self.problem.closure.characteristic_length,
            )
        return certify_batch(
            self.whole,
            z,
            knowns_of(self.problem, known),
            instance,
            self.problem.closure.characteristic_length,
        )

    def roots(
        self,
        ends: CertificateBatch | None,
        points: np.ndarray,
        owner: np.ndarray,
        known: np.ndarray,
        origin: np.ndarray,
    ) -> RootProofs:
        """What is proved of real roots `points` (m, width) of the block at the instances `owner`;
        `origin` (m,) are the ends that they come from, -1 where they combine several.
        """
        from symkin.certificate.certificate import certify_batch
        from symkin.certificate.exact import knowns_of

        z = self._algebraic(points)
        if ends is not None and ends.system.width != len(z):
            ends = (
                None  # the theorem is one on poses, and these roots have passive joints beside them
            )
        if ends is None and self._is_redundant:
            return RootProofs(
                np.zeros(len(owner), dtype=bool),
                np.full(len(owner), np.nan),
                np.zeros(len(known), dtype=bool),
            )
        found = ends
        if found is None:
            found = certify_batch(
                self.whole,
                z,
                knowns_of(self.problem, known),
                owner,
                self.problem.closure.characteristic_length,
            )
        expected = (
            np.arange(z.shape[1]) if ends is None else origin if (origin >= 0).all() else None
        )
        index, radius = found.find(z, owner, expected)
        complete = self._complete(found, np.bincount(owner, minlength=len(known)))
        return RootProofs(index >= 0, radius, complete)

    def grounds(
        self, points: np.ndarray, owner: np.ndarray, known: np.ndarray
    ) -> list[PartialProof | None]:
        """What is proved of real roots as in `roots`: of all rows of those that are certified, of
        independent ones of the others.
        """
        from symkin.certificate.exact import knowns_of
        from symkin.certificate.independent_rows import prove_independent_rows

        rows, size = int(self.block.rows.shape[0]), self.problem.closure.characteristic_length
        if self._is_redundant:
            return prove_independent_rows(
                self.whole, self._algebraic(points), knowns_of(self.problem, known), owner, size
            )
        proofs = self.roots(None, points, owner, known, np.full(len(owner), -1))
        return [
            PartialProof.whole(rows, radius) if certified else None
            for certified, radius in zip(
                proofs.certified.tolist(), proofs.radius.tolist(), strict=True
            )
        ]

    @property
    def _is_redundant(self) -> bool:
        """Whether there are more rows than unknowns, so that no root can have a certificate."""
        return self.whole.count > self.whole.width - bool(self.whole.projective)

    def _algebraic(self, points: np.ndarray) -> np.ndarray:
        """The roots (width, m) of the paths' system that real roots `points` (m, width) are."""
        values = {
            c.name: points[:, s]
            for c, s in zip(self.block.unknowns, self.block.slices, strict=True)
        }
        return algebraic_points(self.problem, self.whole, values)

    def _complete(self, found: CertificateBatch, listed: np.ndarray) -> np.ndarray:
        """Instances (n,) whose certified roots are all that the theorem allows, each known to be
        real or not, the real ones as many as those `listed` (n,); see `bounds.proves`.
        """
        if self.bound is None or found.system is not self.bound.system:
            return np.zeros(len(listed), dtype=bool)
        real, count = found.real == "real", self.bound.theorem.count
        whole = found.certified & found.pose & (found.real != "unknown")
        sums = [
            np.bincount(found.instance[some], minlength=len(listed))
            for some in (whole, found.instance >= 0, real)
        ]
        return np.asarray(
            (sums[0] == count)
            & (sums[1] == count)
            & (found.distinct == count)
            & (sums[2] == listed)
        )


@lru_cache(maxsize=128)
def block_prover(problem: Problem, algebraic: AlgebraicSystem, block: System) -> BlockProver:
    """The prover of a block whose paths are those of `algebraic`."""
    from symkin.certificate.bounds import bound_of

    whole, bound = whole_system(problem, block), bound_of(problem, algebraic)
    return BlockProver(
        problem,
        block,
        whole,
        bound,
        bound is not None or (whole is algebraic and not algebraic.limbs),
    )
