"""What is proved of the roots of one group at many instances: each one by a certificate, and their
number where a theorem bounds it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.computed_once import cached_property, lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import DISTANCES, redundant_distances
from symkin.homotopy.structure import Structure
from symkin.homotopy.systems import system_of
from symkin.homotopy.values import algebraic_points
from symkin.position.closed_configurations import closed_configurations
from symkin.position.problem import Problem
from symkin.position.solution import PartialProof

if TYPE_CHECKING:
    from symkin.certificate.bounds import Bound
    from symkin.certificate.certificate import CertificateBatch
    from symkin.certificate.discs import Knowns


@dataclass(frozen=True, eq=False)
class PartProofs:
    """What is proved of m partial configurations: whether they are `certified`, and in `ground`
    (m, 4) the numbers of a `PartialProof`, its radius infinite where nothing is proved.
    """

    certified: np.ndarray
    ground: np.ndarray

    @staticmethod
    def of_nothing(count: int) -> PartProofs:
        """Of configurations without parts: they are exact."""
        return PartProofs(np.ones(count, dtype=bool), np.zeros((count, 4)))

    @property
    def radius(self) -> np.ndarray:
        return self.ground[:, 2]

    def of(self, places: np.ndarray | slice) -> PartProofs:
        """Of some configurations."""
        return PartProofs(self.certified[places], self.ground[places])

    def beside(self, other: PartProofs) -> PartProofs:
        """Of the configurations with another part beside each."""
        ground = np.maximum(self.ground, other.ground)
        ground[:, :2] = self.ground[:, :2] + other.ground[:, :2]
        return PartProofs(self.certified & other.certified, ground)

    def told(self) -> dict[str, np.ndarray]:
        """What is proved of them as a `SolutionList` has it."""
        ground = np.full(len(self.certified), None, dtype=object)
        for i in (~self.certified & np.isfinite(self.radius)).nonzero()[0].tolist():
            independent, rows, radius, remaining = self.ground[i].tolist()
            ground[i] = PartialProof(int(independent), int(rows), radius, remaining)
        return {
            "certified": self.certified.astype(int),
            "radius": np.where(self.certified, self.radius, np.nan),
            "ground": ground,
        }


@dataclass(frozen=True, eq=False)
class Prover:
    """Certificates of a group's roots: of all complex ones where the paths' system holds all its
    coordinates (`proves_ends`), else of the real ones. `bound` is a theorem on their number, where
    one is known.
    """

    problem: Problem
    whole: AlgebraicSystem
    bound: Bound | None
    proves_ends: bool

    @property
    def is_redundant(self) -> bool:
        """Whether there are more rows than unknowns, which no root can be proved to meet all, but
        for those of a plane in space.
        """
        return self.whole.count > self.whole.width - bool(self.whole.projective)

    @property
    def theorem(self) -> str | None:
        """The bound in words."""
        if self.bound is None:
            return None
        t = self.bound.theorem
        return f"{t.count}: {t.about} ({t.reference})"

    def may_complete(self, count: int) -> bool:
        """Whether so many complex roots may be all that a theorem allows."""
        return self.bound is not None and self.bound.theorem.count == count

    def knowns(self, known: np.ndarray, away: np.ndarray | None = None) -> Knowns:
        """Known values (n, known) of n instances, which are exact or within `away` (n, known) of
        exact ones (length unit; angles times the size).
        """
        from symkin.certificate.exact import knowns_of

        values = knowns_of(self.problem, known)
        return values if away is None or not away.any() else values.widened(away / self._size)

    def ends(self, z: np.ndarray, knowns: Knowns, instance: np.ndarray) -> CertificateBatch:
        """Certificates of complex roots z (width, m) of the instances `instance` (m,), where these
        say all (`proves_ends`).
        """
        from symkin.certificate.certificate import certify_batch

        if self.bound is None:
            return certify_batch(self.whole, z, knowns, instance, self._size)
        return certify_batch(self.bound.system, z, self.bound.knowns(knowns), instance, self._size)

    def proofs(
        self,
        points: np.ndarray,
        owner: np.ndarray,
        knowns: Knowns,
        ends: CertificateBatch | None = None,
        origin: np.ndarray | None = None,
    ) -> tuple[PartProofs, np.ndarray, Mapping[int, str]]:
        """What is proved of real roots `points` (m, width) of the group at the instances `owner`,
        rising, by certificates of the complex roots `ends`, which say what is complete, where these
        stand among them (at `origin`, where that is told), else by their own: of all rows of those
        that are certified, of independent ones of others where rows are redundant; of which
        instances (n,) a theorem tells that there are no others; why single roots, by their places,
        are not certified.
        """
        certified, radius, complete, reasons = self._certified(points, owner, knowns, ends, origin)
        ground = np.zeros((len(owner), 4))
        ground[:, :2], ground[:, 2] = self.problem.system.count, np.where(certified, radius, np.inf)
        left = np.flatnonzero(~certified) if self.is_redundant else ()
        if len(left):
            from symkin.certificate.independent_rows import prove_independent_rows

            z = self._algebraic(points[left])
            ground[left] = prove_independent_rows(self.whole, z, knowns, owner[left], self._size)
        return PartProofs(certified, ground), complete, reasons

    def _certified(
        self,
        points: np.ndarray,
        owner: np.ndarray,
        knowns: Knowns,
        ends: CertificateBatch | None,
        origin: np.ndarray | None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, Mapping[int, str]]:
        """Which roots are certified, and within which radius; then as `proofs`."""
        from symkin.certificate.certificate import certify_batch

        count, nothing = len(owner), np.zeros(knowns.count, dtype=bool)
        if self._unproved is not None:
            reasons = dict.fromkeys(range(count), self._unproved)
            return np.zeros(count, dtype=bool), np.zeros(count), nothing, reasons
        z, left, radius = self._algebraic(points), np.arange(count), np.zeros(count)
        # a theorem on poses tells nothing of passive joints beside them
        if ends is not None and ends.system.width == len(z):
            index, radius = ends.find(z, owner, origin)
            # the roots of one instance are told apart together
            left = np.bincount(owner[index < 0], minlength=knowns.count)[owner].nonzero()[0]
            if not left.size:
                return index >= 0, radius, nothing, {}
        certified = np.ones(count, dtype=bool)
        found = certify_batch(self.whole, z[:, left], knowns, owner[left], self._size)
        certified[left], radius[left] = found.is_real & found.certified, found.radius
        reasons = {int(left[place]): why for place, why in found.reasons.items()}
        complete = self.completes(found, np.bincount(owner, minlength=knowns.count))
        return certified, radius, complete, reasons

    @cached_property
    def _unproved(self) -> str | None:
        """Why no root can be certified, where that is so: more distances than six, and redundant
        rows of which no square part is known to imply the others at a closed configuration.
        """
        from symkin.certificate.certificate import certify_batch

        more = redundant_distances(self.problem)
        if more:
            return (
                f"of {DISTANCES + more} distances six have been solved, the others are met up to "
                f"rounding"
            )
        if not self.is_redundant:
            return None
        values = closed_configurations(self.problem.closure, 0)[0]
        one = values[self.problem.unknown_places]
        knowns = self.knowns(values[self.problem.known_places][None])
        tried = certify_batch(self.whole, self._algebraic(one[None]), knowns, size=self._size)
        return None if tried.certified.any() else tried.reason(0)

    def completes(self, found: CertificateBatch, listed: np.ndarray) -> np.ndarray:
        """Instances (n,) whose certified roots are all that there are, the real ones as many as
        those `listed` (n,).
        """
        if self.bound is None:
            return np.zeros(len(listed), dtype=bool)
        real = np.bincount(found.instance[found.proved_real], minlength=len(listed))
        return self.tells_all(found) & (real == listed)

    def tells_all(self, found: CertificateBatch) -> np.ndarray:
        """Instances (n,) that by the theorem have no roots but those that are certified."""
        from symkin.certificate.bounds import proves

        return (
            np.zeros(found.knowns.count, bool) if self.bound is None else proves(found, self.bound)
        )

    @property
    def _size(self) -> float:
        return self.problem.system.characteristic_length

    def _algebraic(self, points: np.ndarray) -> np.ndarray:
        """The roots (width, m) of the paths' system that real roots `points` (m, width) are."""
        return algebraic_points(self.problem, self.whole, self.problem.system, points)


@lru_cache(maxsize=128)
def prover_of(
    problem: Problem, algebraic: AlgebraicSystem, structure: Structure | None = None
) -> Prover:
    """The prover of a group whose paths are those of `algebraic`, which may be the system of its
    structure.
    """
    from symkin.certificate.bounds import bound_of

    whole = system_of(problem)
    if structure is not None and not structure.system.projective:
        # the unknowns of a structure of joints are those of the group
        algebraic, structure = whole, None
    if algebraic.width == whole.width and algebraic.count < whole.count:
        # roots of combined rows need not be roots of all of them
        return Prover(problem, whole, None, proves_ends=False)
    bound = bound_of(problem, algebraic, structure)
    proves_ends = bound is not None or whole is algebraic
    return Prover(problem, whole, bound, proves_ends)
