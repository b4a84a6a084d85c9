"""What is proved of the roots of one block at many instances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.caching import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.systems import whole_system
from symkin.homotopy.values import algebraic_points
from symkin.numeric.system import System
from symkin.position.problem import Problem

if TYPE_CHECKING:
    from symkin.certificate.bounds import Bound
    from symkin.certificate.certificate import Certificates


@dataclass(frozen=True, eq=False)
class RootProofs:
    """Of each root (m,): whether it is certified, and its radius (length unit; NaN without certificate); of each instance (n,):
    whether as many roots are certified as a theorem allows."""

    certified: np.ndarray
    radius: np.ndarray
    complete: np.ndarray


@dataclass(frozen=True, eq=False)
class EndProofs:
    """Certificates of the complex roots of each instance; `not_real` (n,): roots that are proved not to be real."""

    certificates: dict[int, Certificates]
    not_real: np.ndarray


@dataclass(frozen=True, eq=False)
class BlockProver:
    """Certificates of a block's roots: of all complex ones where the paths' system holds all its coordinates, else of the real
    ones. `bound` is a theorem on their number, where one is known."""

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

    def ends(self, z: np.ndarray, known: np.ndarray, instance: np.ndarray) -> EndProofs | None:
        """Certificates of complex roots z (width, m) of the instances known (n, values); None where those of the real roots say
        all."""
        if not self.proves_ends:
            return None
        from symkin.certificate.certificate import certify
        from symkin.certificate.exact import exact_known

        found, not_real = {}, np.zeros(z.shape[1], dtype=bool)
        for i in np.unique(instance).tolist():
            mine = instance == i
            if self.bound is not None:
                found[i] = certify(self.bound.system, z[:, mine], self.bound.known(known[i]), self.problem.closure.size)
            else:
                found[i] = certify(self.whole, z[:, mine], exact_known(self.problem, known[i]), self.problem.closure.size)
            not_real[mine] = found[i].real == "not real"
        return EndProofs(found, not_real)

    def roots(self, ends: EndProofs | None, points: np.ndarray, owner: np.ndarray, known: np.ndarray) -> RootProofs:
        """What is proved of real roots `points` (m, width) of the block at the instances `owner`."""
        from symkin.certificate.bounds import proves
        from symkin.certificate.certificate import certify
        from symkin.certificate.exact import exact_known

        values = {c.name: points[:, s] for c, s in zip(self.block.unknowns, self.block.slices, strict=True)}
        z = algebraic_points(self.problem, self.whole, values)
        certified, radius = np.zeros(len(points), dtype=bool), np.full(len(points), np.nan)
        complete = np.zeros(len(known), dtype=bool)
        for i in np.unique(owner).tolist():
            mine = np.flatnonzero(owner == i)
            found = None if ends is None else ends.certificates[i]
            if found is None:
                found = certify(self.whole, z[:, mine], exact_known(self.problem, known[i]), self.problem.closure.size)
            for j in mine:
                pair = found.find(z[:, j])
                if pair is not None:
                    certified[j], radius[j] = True, pair[1]
            complete[i] = self.bound is not None and proves(found, self.bound) and len(mine) == int(np.sum(found.real == "real"))
        return RootProofs(certified, radius, complete)


@lru_cache(maxsize=128)
def block_prover(problem: Problem, algebraic: AlgebraicSystem, block: System) -> BlockProver:
    """The prover of a block whose paths are those of `algebraic`."""
    from symkin.certificate.bounds import bound_of

    whole, bound = whole_system(problem, block), bound_of(problem, algebraic)
    return BlockProver(problem, block, whole, bound, bound is not None or (whole is algebraic and not algebraic.limbs))
