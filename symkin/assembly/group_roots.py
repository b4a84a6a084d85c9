"""Real solutions of one structure group at many values of what it reads: the record that all ways
of finding them fill, and the check of candidates, which are polished, held against all rows and
told apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.assembly.mode_order import places_by
from symkin.assembly.modes_result import Completeness
from symkin.computed_once import lru_cache
from symkin.numeric.linear_algebra import extreme_singular_values
from symkin.numeric.newton import polish
from symkin.numeric.root_checks import POLISHING, are_roots, are_suspect, suspects
from symkin.numeric.system import System
from symkin.numeric.tolerances import DISTINCT_ROOTS
from symkin.position.readings import canonical
from symkin.position.roots import NOT_KNOWN, Sample, features

if TYPE_CHECKING:
    from symkin.certificate.certificate import CertificateBatch

STATEMENTS: tuple[Completeness, ...] = ("proved", "probability one", "incomplete", "sampled")
"""What is said of a list, from the strongest to the weakest; of several parts the weakest holds."""
NO_ENDS = np.zeros((0, 0), dtype=complex)
"""Complex roots of what was found without paths."""
_PER_ROW = ("statement", "complex_count", "unresolved", "smallest", "continuum", "engine")
"""The arrays that tell of rows."""
_PER_ROOT = ("points", "owner", "hits", "origin", "judged")
"""Those that tell of solutions."""


@dataclass(frozen=True, eq=False)
class GroupRoots:
    """Solutions `points` (m, width) of a group at n rows of known values, the row `owner` (m,) of
    each, rising, and its `hits` (m,), infinite where it was not searched from random starts. Of
    each row (n,): the place of what is said of it in `STATEMENTS`, complex solutions and unresolved
    paths (`NOT_KNOWN`), the least closure error that a search without success has reached (else
    infinite), whether a set that is not isolated was met, what `engine` found them (None where none
    was needed); `notes` of single rows, and the `samples` of those searched from random starts;
    `orbits` (notes) and `theorem` (what proves that there are no others) of all; from paths all
    complex roots `ends` (width, e) of the rows `ends_of` (e,), rising, their `certificates`, where
    these have been tried, and where they are told the `origin` (m,) of the solutions among these;
    where they are kept the largest and smallest singular value of the group's rows at each solution
    and its closure error, `judged` (m, 3), `NOT_KNOWN` of single ones.
    """

    points: np.ndarray
    owner: np.ndarray
    hits: np.ndarray
    statement: np.ndarray
    complex_count: np.ndarray
    unresolved: np.ndarray
    smallest: np.ndarray
    continuum: np.ndarray
    engine: np.ndarray
    notes: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    orbits: tuple[str, ...] = ()
    theorem: str | None = None
    ends: np.ndarray = field(default_factory=lambda: NO_ENDS)
    ends_of: np.ndarray = field(default_factory=partial(np.zeros, 0, dtype=int))
    samples: Mapping[int, Sample] = field(default_factory=dict)
    origin: np.ndarray | None = None
    judged: np.ndarray | None = None
    certificates: CertificateBatch | None = None

    @staticmethod
    def of_all(
        points: np.ndarray,
        owner: np.ndarray,
        count: np.ndarray,
        *,
        engine: str | None = None,
        **told: Any,
    ) -> GroupRoots:
        """All solutions of each row, of as many complex ones as `count` (n,) says."""
        none = np.zeros(len(count))
        standard = {
            "statement": none.astype(int) + STATEMENTS.index("probability one"),
            "unresolved": none,
            "smallest": none + np.inf,
            "continuum": none > 0.0,
            "complex_count": count.astype(float),
            "hits": np.full(len(owner), np.inf),
            "engine": np.full(len(count), engine, dtype=object),
        }
        return GroupRoots(points, owner, **standard | told)

    @property
    def counts(self) -> np.ndarray:
        """Solutions of each row (n,)."""
        return np.bincount(self.owner, minlength=len(self.statement))

    @staticmethod
    def sampled(sample: Sample, notes: tuple[str, ...]) -> GroupRoots:
        """Of one row what random starts have reached."""
        return GroupRoots.of_all(
            sample.points,
            np.zeros(len(sample.points), dtype=int),
            np.array([NOT_KNOWN]),
            hits=sample.hits.astype(float),
            statement=np.array([STATEMENTS.index("sampled")]),
            unresolved=np.array([NOT_KNOWN]),
            smallest=np.array([sample.smallest_residual]),
            continuum=np.array([sample.continuum]),
            notes={0: notes} if notes else {},
            samples={0: sample},
        )

    def with_rows(self, rows: np.ndarray, other: GroupRoots) -> GroupRoots:
        """The same with some rows, rising, as another search has them."""
        others = np.setdiff1d(np.arange(len(self.statement)), rows)
        joined = GroupRoots.joined([self.at(others), other])
        return joined.at(np.argsort(np.append(others, rows)))

    @staticmethod
    def joined(parts: Sequence[GroupRoots]) -> GroupRoots:
        """The rows of several, one after another."""
        before = np.cumsum([0, *(len(part.statement) for part in parts)]).tolist()
        begun = list(zip(before, parts, strict=False))
        ends = [part.ends for part in parts if part.ends.size]
        judged = [
            np.full((len(part.points), 3), NOT_KNOWN) if part.judged is None else part.judged
            for part in parts
        ]
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in ("points", "hits", *_PER_ROW)
        }
        return GroupRoots(
            owner=np.concatenate([part.owner + begin for begin, part in begun]),
            **arrays,
            notes={row + begin: told for begin, part in begun for row, told in part.notes.items()},
            orbits=parts[0].orbits,
            theorem=next((part.theorem for part in parts if part.theorem), None),
            samples={
                row + begin: one for begin, part in begun for row, one in part.samples.items()
            },
            ends=np.hstack(ends) if ends else NO_ENDS,
            ends_of=np.concatenate(
                [part.ends_of + begin for begin, part in begun if part.ends.size]
            )
            if ends
            else parts[0].ends_of[:0],
            judged=np.concatenate(judged),
        )

    def proved(self, complete: np.ndarray, theorem: str | None) -> GroupRoots:
        """The same where a theorem proves that these are all solutions of the rows `complete`
        (n,).
        """
        if not (complete & (self.statement > 0)).any():
            return self
        return self._but(statement=np.where(complete, 0, self.statement), theorem=theorem)

    def counted(self, rows: np.ndarray, count: int) -> GroupRoots:
        """The same where formulas tell all complex solutions of the rows (n,), `count` of each,
        whatever paths have left of them.
        """
        rows = rows & ((self.complex_count != count) | (self.unresolved != 0.0))
        if not rows.any():
            return self
        return self._but(
            complex_count=np.where(rows, count, self.complex_count),
            unresolved=np.where(rows, 0.0, self.unresolved),
            notes={row: told for row, told in self.notes.items() if not rows[row]},
        )

    def with_notes(self, more: Mapping[int, str]) -> GroupRoots:
        """The same with another note of some rows."""
        notes = {row: (*self.notes.get(row, ()), text) for row, text in more.items()}
        return self._but(notes={**self.notes, **notes}) if more else self

    def in_order(self) -> GroupRoots:
        """The same with the solutions of each row in an order that rounding errors do not
        decide.
        """
        return self._with(places_by(self.owner, self.owner, self.points))

    def _with(self, places: np.ndarray, **told: Any) -> GroupRoots:
        """Some of the solutions, with what else is `told`."""
        arrays = ((name, getattr(self, name)) for name in _PER_ROOT)
        chosen: dict[str, Any] = {
            name: None if array is None else array[places] for name, array in arrays
        }
        return self._but(**chosen | told)

    def _but(self, **told: Any) -> GroupRoots:
        """The same but for what is told: without the loops of `replace`, at every answer."""
        other = object.__new__(GroupRoots)
        vars(other).update(vars(self))
        vars(other).update(told)
        return other

    def at(self, rows: np.ndarray) -> GroupRoots:
        """Some of the rows, in their order."""
        rank = np.full(len(self.statement), -1)
        rank[rows] = np.arange(len(rows))
        own, ends = (places_of(owner, rank) for owner in (self.owner, self.ends_of))
        kept = dict(zip(rows.tolist(), range(len(rows)), strict=True))
        return self._with(
            own,
            owner=rank[self.owner[own]],
            **{name: getattr(self, name)[rows] for name in _PER_ROW},
            notes={kept[row]: told for row, told in self.notes.items() if row in kept},
            samples={kept[row]: one for row, one in self.samples.items() if row in kept},
            ends=self.ends[:, ends],
            ends_of=rank[self.ends_of[ends]],
            origin=None,
            certificates=None,
        )


def places_of(owner: np.ndarray, rank: np.ndarray) -> np.ndarray:
    """Places of what belongs to rows that have a rank, by this."""
    kept = np.flatnonzero(rank[owner] >= 0)
    return kept[np.argsort(rank[owner[kept]], kind="stable")]


def engines_together(engines: Iterable[str | None]) -> str | None:
    """Names of engines, each once, in an order that other inputs have no part in."""
    return (
        ", ".join(sorted({name for e in engines if e is not None for name in e.split(", ")}))
        or None
    )


_FEW = 64
"""Roots of one instance up to which each is held against each other."""


def checked_roots(
    block: System,
    points: np.ndarray,
    owner: np.ndarray,
    known: np.ndarray,
    plain: np.ndarray,
    judged: tuple[np.ndarray, ...] | None = None,
    *,
    judges: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Points (m, width) near real roots of the instances `owner` (m,), rising, polished on the
    block's own rows: those that close on all rows, written in the standard way, their places among
    the given ones, which may have been `judged`, and, if it `judges`, what `GroupRoots` holds as
    that. Instances (n,) with roots that are badly conditioned or equal are no longer `plain`.
    """
    known = known[owner]
    rows, jacobians, residuals = block.judge(points, known) if judged is None else judged
    polished = polish(block, points, known, POLISHING, begun=(rows, jacobians))
    moved = (polished.points != points).any(axis=1).nonzero()[0]
    if moved.size:
        residuals[moved] = block.residuals(polished.points[moved], known[moved])
    points = canonical(block, polished.points)
    closed = are_roots(block, polished, residuals).nonzero()[0]
    points, owner = points[closed], owner[closed]
    plain[_owners_of_equal(block, points, owner)] = False
    jacobians = polished.jacobians[closed]
    if not judges:
        plain[owner[suspects(jacobians)]] = False
        return points, closed, None
    extremes = extreme_singular_values(jacobians)
    plain[owner[are_suspect(extremes)]] = False
    return points, closed, np.column_stack([extremes, residuals[closed]])


def _owners_of_equal(block: System, points: np.ndarray, owner: np.ndarray) -> list[int]:
    """Instances with two roots that are not distinct (see `roots.unite`).

    Roots differ where a combination of their features does by more than the sum of its weights
    times the tolerance: one tells nearly all of an instance's apart, held against those before.
    """
    if len(points) < 2:
        return []
    f = features(block, points)
    if owner[0] == owner[-1] and len(f) <= _FEW:
        return [int(owner[0])] if _has_equal(block, f) else []
    weights = _weights(f.shape[1])
    mixed = f @ weights
    bound = DISTINCT_ROOTS * block.characteristic_length * float(np.sum(np.abs(weights)))
    near = np.zeros(len(f), dtype=bool)
    for back in range(1, int(np.bincount(owner).max())):
        close = ~(np.abs(mixed[back:] - mixed[:-back]) > bound)
        near[back:] |= close & (owner[back:] == owner[:-back])
    found = np.bincount(owner[near]).nonzero()[0].tolist()
    return [i for i in found if _has_equal(block, f[owner == i])]


@lru_cache(maxsize=64)
def _weights(count: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, count)


def _has_equal(block: System, f: np.ndarray) -> bool:
    """Whether two of some roots' features (m, any) are one."""
    apart = np.abs(f[:, None] - f[None]).max(axis=2)
    return bool(np.count_nonzero(apart <= DISTINCT_ROOTS * block.characteristic_length) > len(f))
