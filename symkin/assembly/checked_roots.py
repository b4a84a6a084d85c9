"""Candidates for real roots of one block at many instances: polished, checked on all rows, told
apart, proved.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symkin.assembly.prover import Prover
from symkin.certificate.certificate import CertificateBatch
from symkin.certificate.knowns import Knowns
from symkin.computed_once import lru_cache
from symkin.numeric.linear_algebra import extreme_singular_values
from symkin.numeric.root_checks import POLISHING, are_roots, are_suspect
from symkin.numeric.system import System
from symkin.numeric.tolerances import DISTINCT_ROOTS
from symkin.position.canonical import canonical
from symkin.position.roots import Proofs, features

no_ends = partial(np.zeros, (0, 0), dtype=complex)
"""Complex roots of what was found without paths."""


@dataclass(frozen=True, eq=False)
class BlockRoots:
    """Distinct real roots of a block at n instances: `points` (m, width) in their standard writing,
    `owner` (m,) their instances, rising, `residual` (m,), `extremes` (m, 2): the largest and
    smallest singular values of their Jacobians; `plain` (n,) the instances to which this applies,
    `complex_count` (n,), and what is proved, if asked. From paths all complex roots `ends` (width,
    e) of the instances `ends_of` (e,), rising.
    """

    points: np.ndarray
    owner: np.ndarray
    residual: np.ndarray
    extremes: np.ndarray
    plain: np.ndarray
    complex_count: np.ndarray
    proofs: Proofs | None = None
    ends: np.ndarray = field(default_factory=no_ends)
    ends_of: np.ndarray = field(default_factory=partial(np.zeros, 0, dtype=int))

    @property
    def counts(self) -> np.ndarray:
        """Roots of each instance."""
        return np.bincount(self.owner, minlength=len(self.plain))


@dataclass(frozen=True, eq=False)
class Candidates:
    """Points (m, width) of the block near real roots, their instances `owner` (m,), rising, and the
    ends `origin` (m,) that they come from, -1 where they combine several.
    """

    points: np.ndarray
    owner: np.ndarray
    origin: np.ndarray


def checked_roots(
    block: System, candidates: Candidates, known: np.ndarray, plain: np.ndarray, counts: np.ndarray
) -> tuple[BlockRoots, np.ndarray]:
    """Candidates polished on the block's own rows; those that close on all rows, written in the
    standard way, and their origin. Instances (n,) with roots that are badly conditioned or equal
    are no longer `plain`; `counts` (n,) are their complex roots.
    """
    owner = candidates.owner
    here = known[owner]
    polished = block.polish_many(candidates.points, here, POLISHING)
    places = {c.name: place for c, place in zip(block.unknowns, block.slices, strict=True)}
    points = canonical(block.unknowns, places, polished.points)
    residual = block.residuals(points, here)
    closed = np.flatnonzero(are_roots(block, polished, residual))
    points, owner, extremes = (
        points[closed],
        owner[closed],
        extreme_singular_values(polished.jacobians[closed]),
    )
    plain[owner[are_suspect(extremes)]] = False
    plain[_owners_of_equal(block, points, owner)] = False
    return BlockRoots(
        points=points,
        owner=owner,
        residual=residual[closed],
        extremes=extremes,
        plain=plain,
        complex_count=counts,
    ), candidates.origin[closed]


def with_proofs(
    found: BlockRoots,
    prover: Prover,
    ends: CertificateBatch | None,
    knowns: Knowns,
    origin: np.ndarray | None,
    *,
    required: bool = True,
) -> BlockRoots:
    """The roots with what is proved of them; where certificates are `required`, instances with a
    root that has none are no longer plain.
    """
    proofs = prover.proofs(ends, found.points, found.owner, knowns, origin)
    if required:
        found.plain[found.owner[~proofs.certified]] = False
    return replace(found, proofs=proofs)


def _owners_of_equal(block: System, points: np.ndarray, owner: np.ndarray) -> list[int]:
    """Instances with two roots that are not distinct (see `roots.unite`).

    Roots differ where a combination of their features does by more than the sum of its weights
    times the tolerance; sorted by one, nearly all instances are told by neighbours alone.
    """
    if len(points) < 2:
        return []
    f = features(block, points)
    weights = _weights(f.shape[1])
    mixed = f @ weights
    order = np.lexsort((mixed, owner))
    sorted_owner, gap = owner[order], np.diff(mixed[order])
    near = (sorted_owner[1:] == sorted_owner[:-1]) & ~(
        gap > DISTINCT_ROOTS * block.characteristic_length * float(np.sum(np.abs(weights)))
    )
    return [
        i
        for i in np.flatnonzero(np.bincount(sorted_owner[1:][near])).tolist()
        if _has_equal(block, f[owner == i])
    ]


@lru_cache(maxsize=64)
def _weights(count: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, count)


def _has_equal(block: System, f: np.ndarray) -> bool:
    """Whether two of some roots' features (m, any) are one."""
    apart = np.max(np.abs(f[:, None] - f[None]), axis=2)
    return bool(np.sum(apart <= DISTINCT_ROOTS * block.characteristic_length) > len(f))
