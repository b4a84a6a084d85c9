"""Real solutions of one structure group at many values of what it reads: the record that all ways
of finding them fill.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from symkin.assembly.modes_result import Completeness
from symkin.position.roots import Roots

STATEMENTS: tuple[Completeness, ...] = ("proved", "probability one", "incomplete", "sampled")
"""What is said of a list, from the strongest to the weakest; of several parts the weakest holds."""
NO_ENDS = np.zeros((0, 0), dtype=complex)
"""Complex roots of what was found without paths."""
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
    rows `ends_of` (e,), rising, and where they are told the `origin` (m,) of the solutions among
    these.
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
    ends: np.ndarray = field(default_factory=lambda: NO_ENDS)
    ends_of: np.ndarray = field(default_factory=partial(np.zeros, 0, dtype=int))
    samples: Mapping[int, Roots] = field(default_factory=dict)
    origin: np.ndarray | None = None

    @staticmethod
    def of_all(points: np.ndarray, owner: np.ndarray, count: np.ndarray, **told: Any) -> GroupRoots:
        """All solutions of each row, of as many complex ones as `count` (n,) says."""
        n = len(count)
        standard = {
            "statement": np.full(n, STATEMENTS.index("probability one")),
            "unresolved": np.zeros(n),
            "smallest": np.full(n, np.inf),
            "continuum": np.zeros(n, dtype=bool),
        }
        hits = np.full(len(owner), np.inf)
        return GroupRoots(points, owner, hits, complex_count=count.astype(float), **standard | told)

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

    def with_notes(self, more: Mapping[int, str]) -> GroupRoots:
        """The same with another note of some rows."""
        notes = {row: (*self.notes.get(row, ()), text) for row, text in more.items()}
        return replace(self, notes={**self.notes, **notes}) if more else self

    def in_order(self) -> GroupRoots:
        """The same with the solutions of each row in an order that rounding errors do not
        decide.
        """
        order = np.lexsort((*np.round(self.points.T[::-1], _DIGITS), self.owner))
        return replace(
            self,
            points=self.points[order],
            owner=self.owner[order],
            hits=self.hits[order],
            origin=None if self.origin is None else self.origin[order],
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
            origin=None,
        )


def engines_together(engines: Iterable[str | None]) -> str | None:
    """Names of engines, each once."""
    return (
        ", ".join(dict.fromkeys(name for e in engines if e is not None for name in e.split(", ")))
        or None
    )
