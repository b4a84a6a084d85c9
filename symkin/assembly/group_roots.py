"""Real solutions of one structure group at many values of what it reads.

A group whose rows are linear, or couplings of whole numbers, is solved at once. Others have their
paths tracked for all values together (see `block_paths`); values that leave something in doubt, and
groups without a start, are searched one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.checked_roots import Candidates, checked_roots, no_ends
from symkin.assembly.closed_roots import ClosedBlock, accounts_for_all, closed_block
from symkin.assembly.continuation import by_continuation, least_error
from symkin.assembly.modes_result import Completeness
from symkin.assembly.search import Search
from symkin.computed_once import lru_cache
from symkin.homotopy.branches import complex_count
from symkin.homotopy.start_store import start_of
from symkin.homotopy.structure import MOST_UNKNOWNS, start_of_structure, structure_of
from symkin.homotopy.systems import squared, system_of, unsuitable
from symkin.numeric.levenberg import Progress
from symkin.numeric.newton import Polished
from symkin.numeric.root_checks import are_roots
from symkin.position.canonical import canonical
from symkin.position.gear_train import GearTrain, gear_train
from symkin.position.given import Given
from symkin.position.groups import implied_parts, is_linear, is_tied
from symkin.position.multistart import batched
from symkin.position.multistart import one_by_one as by_solver
from symkin.position.problem import Problem
from symkin.position.roots import (
    MOST_MODES,
    NOT_KNOWN,
    Roots,
    polished_roots,
    product_of_counts,
    unite,
)

STATEMENTS: tuple[Completeness, ...] = ("proved", "probability one", "incomplete", "sampled")
"""What is said of a list, from the strongest to the weakest; of several parts the weakest holds."""
_FEW_ROOTS = 32
"""Complex solutions of a group that are as soon followed together as part by part."""
_DIGITS = 6
"""Decimals to which values are rounded for the order of a group's solutions, so that rounding
errors do not decide it.
"""


@dataclass(frozen=True, eq=False)
class GroupRoots:
    """Solutions `points` (m, width) of a group at n rows of known values, the row `owner` (m,) of
    each, rising, and its `hits` (m,), infinite where it was not searched from random starts. Of
    each row (n,): the place of what is said of it in `STATEMENTS`, complex solutions and unresolved
    paths (`NOT_KNOWN`), the least closure error that a search without success has reached (else
    infinite), whether a set that is not isolated was met; `notes` of single rows, and the `samples`
    of those searched from random starts; `engine`, `orbits` (notes) and `theorem` (what
    proves that there are no others) of all; from paths all complex roots `ends` (width, e) of the
    rows `ends_of` (e,), rising.
    """

    points: np.ndarray
    owner: np.ndarray
    hits: np.ndarray
    statement: np.ndarray
    complex_count: np.ndarray
    unresolved: np.ndarray
    smallest: np.ndarray
    continuum: np.ndarray
    notes: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    engine: str | None = None
    orbits: tuple[str, ...] = ()
    theorem: str | None = None
    ends: np.ndarray = field(default_factory=no_ends)
    ends_of: np.ndarray = field(default_factory=partial(np.zeros, 0, dtype=int))
    samples: Mapping[int, Roots] = field(default_factory=dict)

    @property
    def counts(self) -> np.ndarray:
        """Solutions of each row (n,)."""
        return np.bincount(self.owner, minlength=len(self.statement))

    def with_rows(self, rows: np.ndarray, other: GroupRoots) -> GroupRoots:
        """The same with some rows, rising, as another search has them."""
        kept = ~np.isin(self.owner, rows)
        points = np.concatenate([self.points[kept], other.points])
        owner = np.concatenate([self.owner[kept], rows[other.owner]])
        hits = np.concatenate([self.hits[kept], other.hits])
        order = np.argsort(owner, kind="stable")
        arrays = {}
        for name in ("statement", "complex_count", "unresolved", "smallest", "continuum"):
            arrays[name] = getattr(self, name).copy()
            arrays[name][rows] = getattr(other, name)
        notes = {**self.notes, **{int(rows[i]): texts for i, texts in other.notes.items()}}
        samples = {**self.samples, **{int(rows[i]): roots for i, roots in other.samples.items()}}
        engine = engines_together([self.engine, other.engine])
        left = ~np.isin(self.ends_of, rows[other.ends_of])
        of = np.concatenate([self.ends_of[left], rows[other.ends_of]])
        parts = [part for part in (self.ends[:, left], other.ends) if part.size]
        by_row = np.argsort(of, kind="stable")
        return GroupRoots(
            points[order],
            owner[order],
            hits[order],
            **arrays,
            notes=notes,
            engine=engine,
            orbits=self.orbits,
            samples=samples,
            ends=np.hstack(parts)[:, by_row] if parts else self.ends[:, :0],
            ends_of=of[by_row],
        )

    def proved(self, complete: np.ndarray, theorem: str | None) -> GroupRoots:
        """The same where a theorem proves that these are all solutions of the rows `complete`
        (n,).
        """
        if not (complete & (self.statement > 0)).any():
            return self
        return replace(self, statement=np.where(complete, 0, self.statement), theorem=theorem)

    def in_order(self) -> GroupRoots:
        """The same with the solutions of each row in an order that rounding errors do not
        decide.
        """
        order = np.lexsort((*np.round(self.points.T[::-1], _DIGITS), self.owner))
        return replace(
            self, points=self.points[order], owner=self.owner[order], hits=self.hits[order]
        )


def group_roots(
    group: Problem, known: np.ndarray, search: Search, progress: Progress | None = None
) -> GroupRoots:
    """The solutions of a group at known values (n, known)."""
    if is_linear(group):
        return _linear(group, known)
    train = gear_train(group)
    if train is not None:
        return _geared(group, train, known)
    if search.method != "continuation":
        return one_by_one(group, known, search, progress)
    parts = solved_parts(group)
    if parts:
        return roots_of_parts(group, parts, known, search, progress)
    solver = group_solver(group, formulas=search.formulas)
    if solver is None:
        return one_by_one(group, known, search, progress)
    found, doubtful = _all_together(solver, known)
    if doubtful.size and solver.method == "closed" and (paths := _any_paths(group)) is not None:
        tracked, left = _all_together(paths, known[doubtful])
        found, doubtful = found.with_rows(doubtful, tracked), doubtful[left]
    if not doubtful.size:
        return found
    return found.with_rows(doubtful, one_by_one(group, known[doubtful], search, progress))


def _all_together(
    solver: BlockPaths | ClosedBlock, known: np.ndarray
) -> tuple[GroupRoots, np.ndarray]:
    """The solutions at known values (n, known) by formulas or paths, and which rows are left in
    doubt.
    """
    found = solver.roots(known, certify=False)
    return GroupRoots(
        found.points,
        found.owner,
        np.full(len(found.owner), np.inf),
        statement=np.full(len(known), STATEMENTS.index("probability one")),
        complex_count=found.complex_count.astype(float),
        unresolved=np.zeros(len(known)),
        smallest=np.full(len(known), np.inf),
        continuum=np.zeros(len(known), dtype=bool),
        engine=solver.engine,
        orbits=solver.notes,
        ends=found.ends,
        ends_of=found.ends_of,
    ), np.flatnonzero(~found.plain)


def one_by_one(
    group: Problem, known: np.ndarray, search: Search, progress: Progress | None = None
) -> GroupRoots:
    """The solutions of a group at known values (n, known), each searched alone, with random numbers
    that do not depend on the others.
    """
    searched = [
        _searched(group, Given("given", numbers, {}), search, progress) for numbers in known
    ]
    roots = [found for found, _ in searched]
    counts = [NOT_KNOWN if r.complex_count is None else r.complex_count for r in roots]
    return GroupRoots(
        points=np.concatenate([np.zeros((0, group.system.width)), *(r.points for r in roots)]),
        owner=np.repeat(np.arange(len(roots)), [len(r.points) for r in roots]),
        hits=np.concatenate(
            [
                np.zeros(0),
                *(np.full(len(r.points), np.inf) if r.hits is None else r.hits for r in roots),
            ]
        ),
        statement=np.array([STATEMENTS.index(_statement(r)) for r in roots], dtype=int),
        complex_count=np.array(counts, dtype=float),
        unresolved=np.array([NOT_KNOWN if r.sampled else r.unresolved for r in roots], dtype=float),
        smallest=np.array([r.smallest_residual for r in roots]),
        continuum=np.array([r.continuum is not None for r in roots], dtype=bool),
        notes={i: notes for i, (_, notes) in enumerate(searched) if notes},
        engine=engines_together([r.engine for r in roots]),
        samples={i: r for i, r in enumerate(roots) if r.hits is not None},
    )


def engines_together(engines: Iterable[str | None]) -> str | None:
    """Names of engines, each once."""
    return (
        ", ".join(dict.fromkeys(name for e in engines if e is not None for name in e.split(", ")))
        or None
    )


def _searched(
    group: Problem, given: Given, search: Search, progress: Progress | None
) -> tuple[Roots, tuple[str, ...]]:
    rng = np.random.default_rng(search.seed)
    if search.method != "continuation" and search.solver == "batched":
        return batched(group, group.blocks[0], given, search.starts, rng, progress), ()
    if search.method != "continuation":
        return by_solver(group, given, search.starts, rng, search.solver, progress), ()
    (roots,), notes, _ = by_continuation(group, given, search.starts, rng, progress)
    missing = (
        ()
        if roots.missing is None
        else (f"{', '.join(c.name for c in group.system.unknowns)}: {roots.missing}",)
    )
    return roots, (*notes, *missing)


def _statement(roots: Roots) -> Completeness:
    if roots.sampled:
        return "sampled"
    return (
        "incomplete"
        if roots.unresolved or roots.complex_sets or roots.continuum is not None
        else "probability one"
    )


def group_solver(group: Problem, *, formulas: bool = True) -> BlockPaths | ClosedBlock | None:
    """The formulas of a group, if they are wanted and account for all its solutions, else what
    tracks its paths; None where it has neither.
    """
    closed, paths = closed_block(group, 0) if formulas else None, group_paths(group)
    if closed is not None and accounts_for_all(closed, paths):
        return closed
    return _any_paths(group)


def _any_paths(group: Problem) -> BlockPaths | None:
    """What tracks the paths of a group, of combinations of its rows where these are more than its
    unknowns and known values must satisfy conditions.
    """
    return group_paths(group) or _combined_paths(group)


@lru_cache(maxsize=256)
def group_paths(group: Problem) -> BlockPaths | None:
    """What tracks the paths of a group; None where it has no start."""
    if unsuitable(group) is not None:
        return None
    (block,) = group.blocks
    system = system_of(group, block)
    structure = structure_of(group, system)
    if structure is not None:
        shared = start_of_structure(group, structure)
        if shared is not None:
            return BlockPaths(group, block, structure.system, shared, structure)
    if is_tied(group) and not system.projective:
        return None
    start, _ = start_of(group, system, block)
    return None if start is None else BlockPaths(group, block, system, start)


@lru_cache(maxsize=256)
def _combined_paths(group: Problem) -> BlockPaths | None:
    if unsuitable(group) is not None or not is_tied(group):
        return None
    (block,) = group.blocks
    system = squared(system_of(group, block))
    start, _ = start_of(group, system, block)
    return None if start is None else BlockPaths(group, block, system, start, combined=True)


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
    if solved_at_once(group) or closed_block(group, 0) is not None:
        return ()
    if group.system.freedom <= MOST_UNKNOWNS and group_paths(group) is not None:
        return ()
    parts = implied_parts(group)

    def own_count() -> int | None:
        paths = group_paths(group)
        return None if paths is None else paths.most_roots

    return parts if _are_taken(parts, own_count) else ()


@lru_cache(maxsize=128)
def parted_group(problem: Problem) -> Problem | None:
    """The group that a direct problem of limbs is as a whole, where implied rows take it apart as
    in `solved_parts`.
    """
    if problem.kind != "direct" or len(problem.blocks) != 1 or closed_block(problem, 0) is not None:
        return None
    group = replace(problem, kind="given", row_places=problem.places_of_rows)

    def own_count() -> int | None:
        if unsuitable(problem) is not None:
            return None
        (block,) = problem.blocks
        system = system_of(problem, block)
        start, _ = start_of(problem, system, block)
        return None if start is None else complex_count(system, start.z)

    return group if _are_taken(implied_parts(group), own_count) else None


def _are_taken(parts: Sequence[Problem], own_count: Callable[[], int | None]) -> bool:
    """Whether a group is left to its parts. Its own paths are taken where it has some, and passive
    joints, which implied rows leave, have one solution each, so that these paths are as many as
    those of the parts; or where all are few.
    """
    if not parts:
        return False
    single = all(part.implied or most_roots(part) == 1 for part in parts)
    if single and own_count() is not None:
        return False
    count = most_of_parts(parts)
    if count is None or count > _FEW_ROOTS:
        return count is not None
    own = own_count()
    return own is None or own < count


def solved_at_once(group: Problem) -> bool:
    """Whether a group needs neither formulas nor paths."""
    return is_linear(group) or gear_train(group) is not None


# --- groups that implied rows take apart ----------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Tree:
    """Partial configurations `values` (m, variables) of a group's first parts, of the inputs
    `owner` (m,), rising, with the `hits` (m,) of the rarest choice of each.
    """

    values: np.ndarray
    owner: np.ndarray
    hits: np.ndarray

    def extended(self, part: Problem, roots: GroupRoots, which: np.ndarray) -> _Tree:
        """Each with every solution of a part beside it; `which` (m,) are the rows that they ask
        for. Of more than can be listed no more are kept than show it.
        """
        first, counts = np.cumsum(roots.counts) - roots.counts, roots.counts[which]
        parent = np.repeat(np.arange(len(which)), counts)
        number = np.arange(len(parent)) - np.repeat(np.cumsum(counts) - counts, counts)
        owner = self.owner[parent]
        kept = np.arange(len(owner)) - np.searchsorted(owner, owner) <= MOST_MODES
        parent, place = parent[kept], (first[which[parent]] + number)[kept]
        values = self.values[parent]
        values[:, part.unknown_places] = roots.points[place]
        return _Tree(values, owner[kept], np.minimum(self.hits[parent], roots.hits[place]))


def roots_of_parts(
    group: Problem,
    parts: Sequence[Problem],
    known: np.ndarray,
    search: Search,
    progress: Progress | None = None,
) -> GroupRoots:
    """The solutions of a group from those of its parts, each for every choice of those before it,
    held against all rows of the group. Passive joints whose rows known values must agree with are
    left to formulas in any case.
    """
    n, search = len(known), replace(search, formulas=True)
    begin = np.zeros((n, int(group.closure.variables.shape[0])))
    begin[:, group.known_places] = known
    tree = _Tree(begin, np.arange(n), np.full(n, np.inf))
    statement, continuum = np.zeros(n, dtype=int), np.zeros(n, dtype=bool)
    complex_count, unresolved = np.ones(n), np.zeros(n)
    notes: dict[int, tuple[str, ...]] = {}
    engines: list[str | None] = []
    for part in parts:
        generic = most_roots(part)
        most = np.where(
            np.bincount(tree.owner, minlength=n) > 0, 0.0, NOT_KNOWN if generic is None else generic
        )
        if not len(tree.owner):
            complex_count *= most
            continue
        rows, which = np.unique(tree.values[:, part.known_places], axis=0, return_inverse=True)
        which = which.ravel()
        roots = group_roots(part, rows, search, progress)
        np.maximum.at(statement, tree.owner, roots.statement[which])
        np.logical_or.at(continuum, tree.owner, roots.continuum[which])
        pairs = np.unique(np.stack([tree.owner, which]), axis=1)
        np.add.at(unresolved, pairs[0], roots.unresolved[pairs[1]])
        with np.errstate(invalid="ignore"):  # a count that is not known stays so
            np.maximum.at(most, tree.owner, roots.complex_count[which])
        complex_count *= most
        for row, texts in roots.notes.items():
            for i in np.unique(tree.owner[which == row]).tolist():
                notes[i] = tuple(dict.fromkeys((*notes.get(i, ()), *texts)))
        engines.append(roots.engine)
        tree = tree.extended(part, roots, which)
        many = np.bincount(tree.owner, minlength=n) > MOST_MODES
        statement[many] = np.maximum(statement[many], STATEMENTS.index("incomplete"))
    points, owner, hits, met = _held_against(group, tree, known)
    return GroupRoots(
        points,
        owner,
        hits,
        statement=statement,
        complex_count=complex_count,
        unresolved=unresolved,
        smallest=np.full(n, np.inf),
        continuum=continuum | met,
        notes=notes,
        engine=engines_together(engines),
    )


def _held_against(
    group: Problem, tree: _Tree, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Distinct solutions (m, width) of all rows of a group among whole configurations, with their
    inputs, rising, and hits; and the inputs (n,) at which a set that is not isolated was met.
    """
    (block,) = group.blocks
    points, n = tree.values[:, group.unknown_places], len(known)
    candidates = Candidates(points, tree.owner, np.arange(len(points)))
    plain = np.ones(n, dtype=bool)
    found, origin = checked_roots(block, candidates, known, plain, np.zeros(n))
    parts = [
        (found.points[kept], found.owner[kept], tree.hits[origin[kept]])
        for kept in [plain[found.owner]]
    ]
    met = np.zeros(n, dtype=bool)
    places = {c.name: place for c, place in zip(block.unknowns, block.slices, strict=True)}
    for i in np.flatnonzero(~plain).tolist():
        mine = np.flatnonzero(tree.owner == i)
        polished = polished_roots(block, points[mine], known[i])
        met[i] = polished.continuum is not None
        first, _ = unite(block, polished.points, known[i], continuum_met=bool(met[i]))
        own = canonical(block.unknowns, places, polished.points[first])
        least = np.full(len(own), np.min(tree.hits[mine], initial=np.inf))
        parts.append((own, np.full(len(own), i), least))
    points, owner, hits = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(owner, kind="stable")
    return points[order], owner[order], hits[order], met


def with_least_errors(
    group: Problem,
    roots: GroupRoots,
    known: np.ndarray,
    places: np.ndarray,
    search: Search,
    progress: Progress | None,
) -> GroupRoots:
    """The same with the least closure errors that are found at rows, by their `places`, of known
    values (n, known), which have no solution.
    """
    if not (search.method == "continuation" and solved_parts(group)):
        return roots.with_rows(places, one_by_one(group, known[places], search, progress))
    smallest = roots.smallest.copy()
    for place in places.tolist():
        smallest[place] = least_error(group, group.blocks[0], Given("given", known[place], {}))
    return replace(roots, smallest=smallest)


# --- groups that are linear, or linear but for whole turns ----------------------------------------


def _linear(group: Problem, known: np.ndarray) -> GroupRoots:
    points = group.system.polish_many(np.zeros((len(known), group.system.width)), known).points
    return _closed(group, known, points[:, None, :])


def _geared(group: Problem, train: GearTrain, known: np.ndarray) -> GroupRoots:
    points = train.solutions(known)
    unknowns, slices = group.system.unknowns, group.system.slices
    places = {c.name: place for c, place in zip(unknowns, slices, strict=True)}
    flat = canonical(unknowns, places, points.reshape(-1, group.system.width))
    found = _closed(group, known, flat.reshape(points.shape))
    return (
        found
        if len(train.places) == 1
        else replace(found, orbits=(_places_note(group, len(train.places)),))
    )


def _places_note(group: Problem, count: int) -> str:
    """What is said of wheels that have several places beside one place of those that drive them."""
    own, read = (
        ", ".join(c.name for c in part) for part in (group.system.unknowns, group.known_coordinates)
    )
    return (
        f"{own}: {count} places for one of {read}, whose whole turns are not told apart (ratio of "
        f"the coupling)"
    )


def _closed(group: Problem, known: np.ndarray, points: np.ndarray) -> GroupRoots:
    """The solutions that close, of all complex ones (n, count, width) at known values (n,
    known).
    """
    system, (n, count, width) = group.system, points.shape
    flat, given = points.reshape(-1, width), np.repeat(known, count, axis=0)
    residual = system.residuals(flat, given)
    closed = are_roots(system, Polished(flat, *system.linearise(flat, given)), residual).reshape(
        n, count
    )
    residual = residual.reshape(n, count)
    return GroupRoots(
        points[closed],
        np.nonzero(closed)[0],
        np.full(int(closed.sum()), np.inf),
        statement=np.zeros(n, dtype=int),
        complex_count=np.full(n, float(count)),
        unresolved=np.zeros(n),
        smallest=residual.min(axis=1),
        continuum=np.zeros(n, dtype=bool),
    )
