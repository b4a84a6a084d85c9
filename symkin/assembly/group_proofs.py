"""Certificates of modes group by group: the known values of a group are the boxes in which those
before it are proved to be.

A group is proved once for each of its own solutions, however many modes these combine to. Where a
group's rows are redundant, as many independent ones as its unknowns are proved to vanish at one
exact point, and the others to be small there (`PartialProof`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import arb

from symkin.certificate.certificate import certify_batch
from symkin.certificate.discs import Discs
from symkin.certificate.exact import knowns_of
from symkin.certificate.independent_rows import prove_independent_rows
from symkin.certificate.knowns import Knowns
from symkin.homotopy.systems import system_of, unsuitable
from symkin.homotopy.values import algebraic_points
from symkin.numeric.balls import UP, Number, precision
from symkin.position.groups import is_linear
from symkin.position.problem import Problem
from symkin.position.solution import PartialProof
from symkin.position.solution_list import SolutionList

_BITS = 128


@dataclass(frozen=True, eq=False)
class _Proved:
    """Of n solutions of a group: which are certified, how far the exact ones are (length unit;
    infinite: nothing is proved), and what is proved of those whose rows are redundant.
    """

    certified: np.ndarray
    radius: np.ndarray
    partial: np.ndarray


def with_certificates(groups: Sequence[Problem], found: SolutionList) -> SolutionList:
    """The solutions with what is proved of them; as they are where no proof can be tried: rows of
    some group are not algebraic.
    """
    if not len(found) or not all(is_linear(group) or unsuitable(group) is None for group in groups):
        return found
    values = found.values
    reach = np.zeros(values.shape)
    certified, radius = np.ones(len(values), dtype=bool), np.zeros(len(values))
    parts: list[np.ndarray] = []
    for group in groups:
        columns = np.concatenate([group.known_places, group.unknown_places])
        _, first, which = np.unique(
            values[:, columns], axis=0, return_index=True, return_inverse=True
        )
        which = which.ravel()
        far = np.zeros((len(first), len(group.known_places)))
        np.maximum.at(far, which, reach[:, group.known_places])
        proved = _of_group(group, values[first], far)
        certified &= proved.certified[which]
        radius = np.maximum(radius, proved.radius[which])
        parts.append(proved.partial[which])
        reach[:, group.unknown_places] = proved.radius[which][:, None]
    ground = np.full(len(certified), None, dtype=object)
    for i in np.flatnonzero(~certified).tolist():
        ground[i] = PartialProof.joined([part[i] for part in parts])
    return replace(
        found,
        certified=certified.astype(int),
        radius=np.where(certified, radius, np.nan),
        ground=ground,
        _made={},
    )


def _of_group(group: Problem, values: np.ndarray, far: np.ndarray) -> _Proved:
    """Of solutions (n, variables) whose known values are within `far` (n, known) of what is given
    (length unit).
    """
    n = len(values)
    found = _Proved(np.zeros(n, dtype=bool), np.full(n, np.inf), np.full(n, None, dtype=object))
    (block,) = group.blocks
    system, size = system_of(group, block), group.closure.characteristic_length
    named = {c.name: values[:, group.closure.slices[c.name]] for c in block.unknowns}
    z = algebraic_points(group, system, named)
    near = np.flatnonzero(np.isfinite(far).all(axis=1))
    if not near.size:
        return found
    knowns = _widened(knowns_of(group, values[near][:, group.known_places]), far[near] / size)
    rows = int(system.count)
    if rows > system.width - bool(system.projective):
        proofs = prove_independent_rows(system, z[:, near].real, knowns, np.arange(near.size), size)
        for i, proof in zip(near.tolist(), proofs, strict=True):
            if proof is not None:
                found.partial[i], found.radius[i] = proof, proof.radius
        return found
    batch = certify_batch(system, z[:, near], knowns, np.arange(near.size), size)
    index, radius = batch.find(z[:, near], np.arange(near.size), None)
    sure = near[index >= 0]
    found.certified[sure], found.radius[sure] = True, radius[index >= 0]
    for i in sure.tolist():
        found.partial[i] = PartialProof.whole(rows, float(found.radius[i]))
    return found


def _widened(knowns: Knowns, radius: np.ndarray) -> Knowns:
    """Known values that are only known to within a radius (m, known)."""
    discs = Discs(knowns.discs.middle, (knowns.discs.radius + radius) * UP)

    def numbers(j: int) -> tuple[Number, ...]:
        with precision(_BITS):
            return tuple(
                arb(float(m), float(r)) if r > 0.0 else v
                for v, m, r in zip(
                    knowns.numbers(j), discs.middle[j].real, discs.radius[j], strict=True
                )
            )

    return Knowns(discs, numbers)
