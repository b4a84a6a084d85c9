"""What is proved where rows are redundant: an exact root of as many independent rows as their rank,
and a bound of the others.

No arithmetic with rounding can show that redundant rows vanish together. It can show that some of
them do at one exact point within a stated radius, and how far the others are from zero there at
most.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symkin.certificate.certificate import CertificateBatch, certify_batch
from symkin.certificate.disc_arithmetic import UP, modulus
from symkin.certificate.discs import Discs, Knowns
from symkin.certificate.quick_test import disc_function
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.rank import most_independent


def prove_independent_rows(
    system: AlgebraicSystem, z: np.ndarray, knowns: Knowns, instance: np.ndarray, size: float
) -> np.ndarray:
    """The proofs about real roots z (width, m) of more rows than unknowns, of the instances
    `instance` (m,), ascending, of known values: numbers of a `PartialProof` (m, 4), the radius
    infinite where as many independent rows as unknowns are not found there, or no proof is.
    """
    freedom = system.width - bool(system.projective)
    found = np.tile([freedom, system.count, np.inf, 0.0], (z.shape[1], 1))
    if system.count <= freedom:
        return found
    _, jacobians = system.linearise(
        z.astype(complex), knowns.discs.middle[instance].T.astype(complex)
    )
    takes = most_independent(jacobians, freedom)
    for chosen in {t.tobytes(): t for t in takes[takes.sum(axis=1) == freedom]}.values():
        here = np.flatnonzero((takes == chosen).all(axis=1))
        batch = certify_batch(
            _part(system, tuple(np.flatnonzero(chosen).tolist())),
            z[:, here],
            knowns,
            instance[here],
            size,
        )
        sure = np.flatnonzero(batch.certified & batch.proved_real & batch.pose)
        found[here[sure], 2] = batch.radius[sure]
        found[here[sure], 3] = _largest_other(system, ~chosen, batch, sure) * size * UP
    return found


def _largest_other(
    system: AlgebraicSystem, others: np.ndarray, batch: CertificateBatch, sure: np.ndarray
) -> np.ndarray:
    """No row among `others` (rows,) is larger within the boxes of the roots `sure` (m,) of a batch:
    (m,).
    """
    centre, half = batch.centre[:, sure].T.real, batch.ball[sure]
    function = disc_function(system)
    assert function is not None  # noqa: S101 - boxes are proved by the same operations
    box = Discs(np.ascontiguousarray(centre), np.repeat(half[:, None], system.width, axis=1))
    values = function.evaluate(0, box, function.prepare(batch.knowns.discs), batch.instance[sure])
    size = np.zeros((len(sure), system.count))
    size[:, function.tape.patterns[0][0]] = (modulus(values.middle) + values.radius) * UP
    return np.max(size[:, others], axis=1, initial=0.0)


@lru_cache(maxsize=256)
def _part(system: AlgebraicSystem, chosen: tuple[int, ...]) -> AlgebraicSystem:
    return replace(system, rows=system.rows[list(chosen), 0])
