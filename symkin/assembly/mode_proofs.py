"""What is proved of modes, from what is proved of the parts that they are solved in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from symkin.assembly.group_roots import GroupRoots
from symkin.assembly.group_solvers import group_paths
from symkin.assembly.prover import PartProofs, prover_of
from symkin.computed_once import lru_cache
from symkin.homotopy.systems import system_of, unsuitable
from symkin.position.groups import is_linear
from symkin.position.problem import Problem
from symkin.position.solution import PartialProof


@lru_cache(maxsize=128)
def can_be_proved(groups: tuple[Problem, ...]) -> bool:
    """Whether proofs can be tried: the rows of all groups are algebraic."""
    return all(is_linear(group) or unsuitable(group) is None for group in groups)


def proofs_of_group(
    group: Problem, roots: GroupRoots, known: np.ndarray, away: np.ndarray
) -> tuple[PartProofs, GroupRoots]:
    """What is proved of the solutions of a group at known values (n, known) that are within `away`
    (n, known) of exact ones (length unit); and the solutions, proved to be all where a theorem
    allows it, with notes where some have no certificate.
    """
    near = np.isfinite(away).all(axis=1)
    if not near.all():
        return _proofs_of_near(group, roots, (known, away), near)
    prover = prover_of(group, system_of(group))
    knowns, owner = prover.knowns(known, away), roots.owner
    paths, ends = group_paths(group) if len(roots.ends_of) else None, None
    of_paths = prover if paths is None else paths.prover
    if of_paths.bound is not None and paths is not None:
        ends = of_paths.ends(roots.ends, knowns, roots.ends_of)
    own = ends if paths is not None and paths.shared is None else None
    proofs, complete, reasons = prover.proofs(roots.points, owner, knowns, own, roots.origin)
    roots = roots.with_notes(
        {
            int(owner[place]): f"not certified: {reason}"
            for place, reason in reasons.items()
            if np.isinf(proofs.radius[place])
        }
    )
    if ends is not None and not complete.all():
        listed = np.bincount(owner, minlength=knowns.count)
        whole = np.bincount(owner[proofs.certified], minlength=knowns.count) == listed
        complete = complete | (whole & of_paths.completes(ends, listed))
    return proofs, roots.proved(complete, of_paths.theorem)


def _proofs_of_near(
    group: Problem, roots: GroupRoots, knowns: tuple[np.ndarray, np.ndarray], near: np.ndarray
) -> tuple[PartProofs, GroupRoots]:
    """The same where nothing is known of how far `away` values are but of some, `near` (n,)."""
    rows, mine = near.nonzero()[0], near[roots.owner]
    certified, ground = np.zeros(len(mine), dtype=bool), np.zeros((len(mine), 4))
    ground[:, 2] = np.inf
    if rows.size:
        some, proved = proofs_of_group(group, roots.at(rows), *(part[rows] for part in knowns))
        certified[mine], ground[mine] = some.certified, some.ground
        roots = roots.with_rows(rows, proved)
    return PartProofs(certified, ground), roots


def theorem_notes(theorems: Iterable[str | None]) -> tuple[str, ...]:
    """What is said of the bounds that the solutions of parts reach: of several those that are about
    more than one unknown alone.
    """
    found = dict.fromkeys(text for text in theorems if text is not None)
    return tuple(f"at most {text}" for text in found if len(found) == 1 or "alone" not in text)


def ground_notes(problem: Problem, grounds: Sequence[PartialProof], count: int) -> list[str]:
    """What is proved of those of `count` modes whose rows are redundant."""
    if not grounds:
        return []
    one, unit = grounds[0], problem.mechanism.length_unit
    every = "each mode" if len(grounds) == count else f"{len(grounds)} of the modes"
    return [
        f"proved of {every}: {one.independent} independent rows of {one.rows} vanish at one exact "
        f"point within {max(g.radius for g in grounds):.1e} {unit}, and no other row is more than "
        f"{max(g.remaining for g in grounds):.1e} {unit} there"
    ]
