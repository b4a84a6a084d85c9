"""Real solutions of one structure group at many values of what it reads.

A group whose rows are linear, or couplings of whole numbers, is solved at once. Others have their
formulas or paths for all values together (see `block_paths`), or are searched one by one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.checked_roots import no_ends
from symkin.assembly.closed_roots import ClosedBlock
from symkin.assembly.continuation import by_continuation
from symkin.assembly.modes_result import Completeness
from symkin.assembly.search import Search
from symkin.numeric.levenberg import Progress
from symkin.numeric.newton import Polished
from symkin.numeric.root_checks import are_roots
from symkin.position.canonical import canonical
from symkin.position.gear_train import GearTrain
from symkin.position.given import Given
from symkin.position.multistart import batched
from symkin.position.multistart import one_by_one as by_solver
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN, Roots

STATEMENTS: tuple[Completeness, ...] = ("proved", "probability one", "incomplete", "sampled")
"""What is said of a list, from the strongest to the weakest; of several parts the weakest holds."""
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

    def part(self, begin: int, end: int) -> GroupRoots:
        """Those of some rows, which lie together."""
        own, ends = (
            slice(*np.searchsorted(owner, [begin, end])) for owner in (self.owner, self.ends_of)
        )
        arrays = {
            name: getattr(self, name)[begin:end]
            for name in ("statement", "complex_count", "unresolved", "smallest", "continuum")
        }
        return replace(
            self,
            points=self.points[own],
            owner=self.owner[own] - begin,
            hits=self.hits[own],
            **arrays,
            notes={row - begin: told for row, told in self.notes.items() if begin <= row < end},
            samples={row - begin: r for row, r in self.samples.items() if begin <= row < end},
            ends=self.ends[:, ends],
            ends_of=self.ends_of[ends] - begin,
        )


def all_together(
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


# --- groups that are linear, or linear but for whole turns ----------------------------------------


def linear_roots(group: Problem, known: np.ndarray) -> GroupRoots:
    points = group.system.polish_many(np.zeros((len(known), group.system.width)), known).points
    return _closed(group, known, points[:, None, :])


def geared_roots(group: Problem, train: GearTrain, known: np.ndarray) -> GroupRoots:
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
