"""What finds the solutions of a structure group: formulas, paths, or its parts."""

from __future__ import annotations

from collections.abc import Sequence

from symkin.assembly.account import Part
from symkin.assembly.block_paths import BlockPaths, own_paths, paths_of_rows
from symkin.assembly.closed_roots import ClosedBlock, closed_block, closing
from symkin.assembly.complex_branches import misses_none
from symkin.assembly.rod_lengths import rod_lengths
from symkin.assembly.search import Search
from symkin.computed_once import lru_cache
from symkin.elimination.closed_form import ClosedForm
from symkin.homotopy.six_distances import redundant_distances
from symkin.homotopy.structure import MOST_UNKNOWNS, start_of_structure, structure_of
from symkin.homotopy.systems import system_of, unsuitable
from symkin.numeric.cache_folder import cache_folder
from symkin.position.gear_train import gear_train
from symkin.position.groups import (
    implied_parts,
    independent_parts,
    is_linear,
    is_tied,
    joined_groups,
    structure_groups,
)
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN, product_of_counts

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
    at the regular configuration, and random starts over the complex numbers find no other there.
    """
    group, formulas, regular = closed.problem, closed.formulas, closed.regular
    if not isinstance(formulas, ClosedForm):
        return True
    paths = group_paths(group)
    if paths is None:
        closes = bool(closing(group, formulas, regular[None]).all())
        return closes and misses_none(group, formulas, regular)
    if formulas.count != paths.most_roots:
        return False
    return bool(closing(group, formulas, closed.generic_known).all())


def any_paths(group: Problem) -> BlockPaths | None:
    """What tracks the paths of a group, of combinations of its rows where these are more than its
    unknowns and known values must satisfy conditions.
    """
    found = group_paths(group)
    return found if found is not None or redundant_distances(group) else own_paths(group)[0]


def solved_groups(problem: Problem, search: Search) -> tuple[Problem, ...]:
    """The structure groups of a problem in the order of their solution. Where no answer lists them,
    those that formulas solve together are one: those of a limb, and rods whose ends are known.
    """
    formulas = search.method == "continuation" and search.formulas
    return _joined(problem) if formulas and not problem.by_name else structure_groups(problem)


@lru_cache(maxsize=128)
def _joined(problem: Problem) -> tuple[Problem, ...]:
    groups, found = structure_groups(problem), list[Problem]()
    for numbers in independent_parts(groups):
        own = tuple(groups[k] for k in numbers)
        is_one = len(own) > 1 and _is_solved_as_one(joined_groups(problem, own), own)
        found += [joined_groups(problem, own)] if is_one else own
    given = {*problem.known_coordinates}
    rods = tuple(g for g in found if given >= {*g.known_coordinates} and rod_lengths(g.system))
    if len(rods) < 2:
        return tuple(found)
    return (joined_groups(problem, rods), *(group for group in found if group not in rods))


@lru_cache(maxsize=128)
def dependent_parts(problem: Problem, groups: tuple[Problem, ...]) -> tuple[Part, ...]:
    """The parts of a problem that are several groups."""
    parts = [numbers for numbers in independent_parts(groups) if len(numbers) > 1]
    own = [tuple(groups[k] for k in numbers) for numbers in parts]
    ties = [_may_refuse(some) and is_tied(joined_groups(problem, some)) for some in own]
    return tuple(zip(parts, ties, strict=True))


def _may_refuse(groups: tuple[Problem, ...]) -> bool:
    """Whether further rows of later groups may refuse solutions of earlier ones."""
    return any(g.system.rows.shape[0] > g.system.freedom for g in groups[1:])


def _is_solved_as_one(joined: Problem, own: tuple[Problem, ...]) -> bool:
    """Whether formulas solve groups together, or further rows of a later one refuse solutions of
    an earlier one, so that products of their counts are too large.
    """
    if solved_at_once(joined):
        return False
    solver = group_solver(joined)
    return isinstance(solver, ClosedBlock) or (_may_refuse(own) and solver is not None)


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
