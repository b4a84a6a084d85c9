"""What finds the solutions of a structure group, formulas, paths, or its parts; and what is proved
of them: each one by a certificate, their number where a theorem bounds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from symkin.assembly.block_paths import BlockPaths, own_paths, paths_of_rows
from symkin.assembly.closed_roots import ClosedBlock, closed_block, closing
from symkin.assembly.complex_branches import complex_ends, misses_none
from symkin.assembly.group_roots import GroupRoots
from symkin.assembly.prover import PartProofs, Prover, prover_of
from symkin.computed_once import lru_cache
from symkin.elimination.closed_form import ClosedForm
from symkin.homotopy.six_distances import redundant_distances
from symkin.homotopy.structure import MOST_UNKNOWNS, start_of_structure, structure_of
from symkin.homotopy.systems import system_of, unsuitable
from symkin.homotopy.values import known_values, real_values
from symkin.numeric.cache_folder import cache_folder
from symkin.position.gear_train import gear_train
from symkin.position.groups import implied_parts, is_linear
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN, product_of_counts

if TYPE_CHECKING:
    from symkin.assembly.families import Member
    from symkin.certificate.certificate import CertificateBatch
    from symkin.certificate.discs import Knowns

_FEW_ROOTS = 32
"""Complex solutions of a group that are as soon followed together as part by part."""


def group_solver(group: Problem, *, formulas: bool = True) -> BlockPaths | ClosedBlock | None:
    """The formulas of a group, if they are wanted and account for all its solutions, else what
    tracks its paths; None where it has neither.
    """
    closed = closed_block(group) if formulas else None
    return closed if closed is not None and accounts_for_all(closed) else any_paths(group)


@lru_cache(maxsize=256)
def accounts_for_all(closed: ClosedBlock) -> bool:
    """Whether each complex solution of a generic instance is one of the formulas' branches, as by
    their derivation those of rods and of an arm are: they are as many as paths find, and all of
    them close. Where no paths tell, as where known values must meet conditions, all of them close
    at the regular configuration, or near one that is singular, and random starts over the complex
    numbers find no other there.
    """
    group, formulas = closed.problem, closed.formulas
    if not isinstance(formulas, ClosedForm):
        return True
    paths = group_paths(group)
    if paths is None:
        return any(
            closing(group, formulas, known[None]).all() and misses_none(group, formulas, known)
            for known in (closed.regular, *closed.generic_known)
        )
    if formulas.count != paths.most_roots:
        return False
    return bool(closing(group, formulas, closed.generic_known).all())


def any_paths(group: Problem) -> BlockPaths | None:
    """What tracks the paths of a group, of combinations of its rows where these are more than its
    unknowns and known values must satisfy conditions.
    """
    found = group_paths(group)
    return found if found is not None or redundant_distances(group) else own_paths(group)[0]


def group_paths(group: Problem) -> BlockPaths | None:
    """What tracks the paths of a group, whose start is read from the cache folder once in a
    process; None where it has no start.
    """
    return _group_paths(group, str(cache_folder()))


@lru_cache(maxsize=256)
def _group_paths(group: Problem, _folder: str) -> BlockPaths | None:
    if unsuitable(group) is not None or redundant_distances(group):
        return None
    system = system_of(group)
    # the own start of limbs tells their operation modes; that of a structure has one
    structure = structure_of(group, system) if group.by_name else None
    if structure is not None:
        shared = start_of_structure(group, structure)
        if shared is not None:
            return BlockPaths(group, structure.system, shared, structure)
    return paths_of_rows(group)[0]


def most_roots(group: Problem) -> int | None:
    """The most isolated solutions of a group at one row of values; None where no paths tell."""
    if is_linear(group):
        return 1
    train = gear_train(group)
    if train is not None:
        return len(train.places)
    parts = solved_parts(group)
    if parts:
        return most_of_parts(parts)
    paths = group_solver(group)
    return None if paths is None else paths.most_roots


def most_of_parts(parts: Sequence[Problem]) -> int | None:
    """The most isolated solutions of parts that are solved one after another."""
    counts = (most_roots(part) for part in parts)
    return product_of_counts(NOT_KNOWN if count is None else count for count in counts)


def solvers_of(group: Problem) -> list[BlockPaths | ClosedBlock]:
    """What finds the solutions of a group, or those of its parts, where it takes formulas or
    paths.
    """
    if solved_at_once(group):
        return []
    parts = solved_parts(group)
    if parts:
        return [solver for part in parts for solver in solvers_of(part)]
    solver = group_solver(group)
    return [] if solver is None else [solver]


@lru_cache(maxsize=256)
def solved_parts(group: Problem) -> tuple[Problem, ...]:
    """The parts of a group that has no formulas of its own, where implied rows take it apart and
    each part has formulas or paths; of a group of few unknowns only where it has no paths.
    """
    if solved_at_once(group) or closed_block(group) is not None:
        return ()
    few = group.system.freedom <= MOST_UNKNOWNS and group_paths(group) is not None
    parts = () if few or group.of_pose else implied_parts(group)
    return parts if parts and not _are_followed_together(group, parts) else ()


def _are_followed_together(group: Problem, parts: Sequence[Problem]) -> bool:
    """Whether a group is not left to its parts. Its own paths are taken where it has some, and
    passive joints, which implied rows leave, have one solution each, so that these paths are as
    many as those of the parts; or where all are few.
    """
    single = all(part.implied or most_roots(part) == 1 for part in parts)
    if single and group_paths(group) is not None:
        return True
    count = most_of_parts(parts)
    if count is None or count > _FEW_ROOTS:
        return count is None
    return group_paths(group) is not None


def solved_at_once(group: Problem) -> bool:
    """Whether a group needs neither formulas nor paths."""
    return is_linear(group) or gear_train(group) is not None


# --- what is proved of them -----------------------------------------------------------------------


def proofs_of_group(
    group: Problem,
    roots: GroupRoots,
    known: np.ndarray,
    away: np.ndarray,
    member: Member | None = None,
) -> tuple[PartProofs, GroupRoots]:
    """What is proved of the solutions of a group at known values (n, known) that are within `away`
    (n, known) of exact ones (length unit); and the solutions, proved to be all where a theorem
    allows it, with notes where some have no certificate. A `member` has its family's formulas.
    """
    near = np.isfinite(away).all(axis=1)
    if not near.all():
        return _proofs_of_near(group, roots, (known, away), near, member)
    prover = prover_of(group, system_of(group))
    knowns, owner = prover.knowns(known, away), roots.owner
    paths, ends = group_paths(group) if len(roots.ends_of) else None, None
    of_paths = prover if paths is None else paths.prover
    if paths is not None and of_paths.may_complete(paths.most_roots):
        ends = roots.certificates or of_paths.ends(roots.ends, knowns, roots.ends_of)
    own = ends if paths is not None and paths.shared is None else None
    proofs, complete, reasons = prover.proofs(roots.points, owner, knowns, own, roots.origin)
    roots = roots.with_notes(
        {
            int(owner[place]): f"not certified: {reason}"
            for place, reason in reasons.items()
            if np.isinf(proofs.radius[place])
        }
    )
    listed = np.bincount(owner, minlength=knowns.count)
    whole = np.bincount(owner[proofs.certified], minlength=knowns.count) == listed
    if ends is not None and not complete.all():
        complete = complete | (whole & of_paths.completes(ends, listed))
    if paths is None and not complete.all():
        source = (group, known) if member is None else (member.family, member.known(known))
        branches = _ends_of_formulas(prover, knowns, *source)
        if branches is not None:
            by_formulas = whole & prover.completes(branches, listed)
            roots = roots.counted(by_formulas, len(branches.instance) // knowns.count)
            complete = complete | by_formulas
    return proofs, roots.proved(complete, of_paths.theorem)


def _ends_of_formulas(
    prover: Prover, knowns: Knowns, group: Problem, known: np.ndarray
) -> CertificateBatch | None:
    """Certificates, by the rows of a prover at its known values, of all branches of the formulas of
    a group with the same solutions at known values (n, known), complex ones included, where so many
    may be all.
    """
    closed = closed_block(group) if prover.bound is not None else None
    if closed is None or not prover.may_complete(closed.most_roots):
        return None
    if not isinstance(closed.formulas, ClosedForm):
        return None
    try:
        z = complex_ends(group, closed.formulas, known)
    except NotImplementedError:
        return None
    return prover.ends(z, knowns, np.arange(len(known)).repeat(closed.most_roots))


def proved_roots(group: Problem, known: np.ndarray) -> tuple[GroupRoots | None, np.ndarray]:
    """The solutions of a group at known values (n, known) where certificates of its formulas'
    branches tell that these are all, and the rows that are left.
    """
    nothing = None, np.arange(len(known))
    if closed_block(group) is None or unsuitable(group) is not None:
        return nothing
    algebraic = system_of(group)
    prover = prover_of(group, algebraic)
    found = _ends_of_formulas(prover, prover.knowns(known), group, known)
    if found is None or not (whole := prover.tells_all(found)).any():
        return nothing
    real = found.proved_real & whole[found.instance]
    owner = found.instance[real]
    values = real_values(
        group, algebraic, found.centre[:, real], known_values(group, known[owner].T)
    )
    points = np.concatenate([values[c.name] for c in group.system.unknowns], axis=1)
    count = np.bincount(found.instance[whole[found.instance]], minlength=len(known))
    return GroupRoots.of_all(points, owner, count, engine="closed form"), (~whole).nonzero()[0]


def _proofs_of_near(
    group: Problem,
    roots: GroupRoots,
    knowns: tuple[np.ndarray, np.ndarray],
    near: np.ndarray,
    member: Member | None,
) -> tuple[PartProofs, GroupRoots]:
    """The same where nothing is known of how far `away` values are but of some, `near` (n,)."""
    rows, mine = near.nonzero()[0], near[roots.owner]
    certified, ground = np.zeros(len(mine), dtype=bool), np.zeros((len(mine), 4))
    ground[:, 2] = np.inf
    if rows.size:
        known, away = (part[rows] for part in knowns)
        some, proved = proofs_of_group(group, roots.at(rows), known, away, member)
        certified[mine], ground[mine] = some.certified, some.ground
        roots = roots.with_rows(rows, proved)
    return PartProofs(certified, ground), roots
