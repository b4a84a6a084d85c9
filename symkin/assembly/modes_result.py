"""What `modes` returns: all solutions of a problem, with a statement of how complete the list is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from symkin.computed_once import cached_property
from symkin.position.problem import Problem
from symkin.position.solution import Solution, finite, heading
from symkin.position.table import given_text, solution_table
from symkin.result import Result, Summary
from symkin.text import counted

Completeness = Literal["proved", "probability one", "incomplete", "sampled"]

_PRINTED_ROWS = 64
"""Modes that the command prints; of more, one at each pose."""


@dataclass(frozen=True)
class Group:
    """A structure group of a problem: its unknown coordinates, its complex solutions and the real ones (`count`, the most) for one
    choice of what it reads, and what is said of its list."""

    name: str
    unknowns: tuple[str, ...]
    complex_count: int | None
    completeness: Completeness
    count: int | None = None

    def to_dict(self) -> dict[str, Any]:
        """One entry of `blocks` in the JSON of `symkin modes --json`."""
        return {
            "name": self.name,
            "unknowns": list(self.unknowns),
            "complex_count": self.complex_count,
            "count": self.count,
            "completeness": self.completeness,
        }


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Result):
    """All solutions found for one set of given values, with a statement of completeness that is never too large.

    `estimated_unseen` is Chao's lower-bound estimate of modes not yet hit, `next_new` the Good-Turing probability that
    one more start finds a new mode (both for multistart only); `engine` is what solved the equations: a closed form, or the
    program that tracked the paths. A list of `Solution`s: it has a length, is iterated and indexed.

    >>> import symkin
    >>> found = symkin.modes(symkin.load("zhao2000"), joints=[81.6, 202.8, 330.6, 105.2])
    >>> len(found), found.completeness, all(mode.certified for mode in found)
    (4, 'probability one', True)
    """

    problem: Problem
    given: dict[str, Any]
    modes: Sequence[Solution]
    completeness: Completeness
    method: str
    seed: int | None
    elapsed_s: float
    starts: int | None = None
    estimated_unseen: float | None = None
    next_new: float | None = None
    complex_count: int | None = None
    unresolved_paths: int | None = None
    smallest_residual: float | None = None
    positive_dimensional: bool = False
    notes: tuple[str, ...] = field(default=())
    engine: str | None = None
    groups: tuple[Group, ...] = ()
    count: int | None = None

    def __len__(self) -> int:
        return len(self.modes)

    def __iter__(self) -> Iterator[Solution]:
        return iter(self.modes)

    def __getitem__(self, index: int) -> Solution:
        return self.modes[index]

    @property
    def _has_platform(self) -> bool:
        return self.problem.mechanism.platform_link is not None

    @cached_property
    def representatives(self) -> list[Solution]:
        """The first mode at each distinct pose; all of them without a platform."""
        if not self._has_platform:
            return list(self.modes)
        size = self.problem.closure.characteristic_length
        kept: list[Solution] = []
        known = np.zeros((0, 12))
        for mode in self.modes:
            feature = np.concatenate([mode.position, size * mode.rotation.ravel()])
            if np.all(np.max(np.abs(known - feature), axis=1, initial=0.0) > 1e-6 * size):
                kept.append(mode)
                known = np.vstack([known, feature])
        return kept

    @property
    def total(self) -> int:
        """Count of modes, which may exceed those that are listed."""
        return len(self) if self.count is None else self.count

    @property
    def poses(self) -> int:
        """Count of distinct poses among the modes."""
        return len(self.representatives)

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of `symkin modes --json`."""
        hits = [mode.hits for mode in self.modes]
        return {
            **heading(self.problem, self.given),
            "modes": [mode.to_dict() for mode in self.modes],
            "count": self.total,
            "listed": len(self),
            "poses": self.poses if self._has_platform else None,
            "blocks": [group.to_dict() for group in self.groups] or None,
            "complex_count": self.complex_count,
            "completeness": self.completeness,
            "unresolved_paths": self.unresolved_paths,
            "smallest_residual": finite(self.smallest_residual),
            "method": self.method,
            "seed": self.seed,
            "elapsed_s": self.elapsed_s,
            "starts": self.starts,
            "hits": hits if any(h is not None for h in hits) else None,
            "estimated_unseen": self.estimated_unseen,
            "engine": self.engine,
            "notes": list(self.notes),
        }

    # --- text ------------------------------------------------------------------------------------------------------

    def summary(self, most_rows: int | None = None, *, everything: bool = False) -> Summary:
        """The modes as a table, and what is known of their completeness; with `everything` all joints and named points too."""
        mechanism = self.problem.mechanism
        title = mechanism.name + (f" ({mechanism.title})" if mechanism.title else "")
        above = [f"{title}: {self.problem.name} problem, {given_text(self.given)}"]
        below = [self._statement(), *(f"note: {note}" for note in self.notes)]
        shown = self._shown(most_rows)
        if len(shown) < len(self):
            below.insert(0, self._left_out(len(shown), most_rows))
        table = solution_table(self.problem, shown, everything)
        below = [*([table.left_out] if table.left_out else []), *below]
        return Summary(above, table.header, table.rows, below)

    def _shown(self, most_rows: int | None) -> list[Solution]:
        most = _PRINTED_ROWS if most_rows is None else most_rows
        if most_rows is None and len(self) > most:
            return self.representatives[:most]
        return list(self.modes[:most])

    def _left_out(self, shown: int, most_rows: int | None) -> str:
        if most_rows is None and self._has_platform:
            return f"one of the modes at each of {shown} poses of {self.poses}; all {len(self)} modes with --json"
        return f"the first {shown} of {len(self)} modes"

    def _statement(self) -> str:
        """Count, completeness and what it rests on."""
        count, unit = len(self), self.problem.mechanism.length_unit
        parts = [f"{self._count()}; completeness: {self.completeness}"]
        if self.complex_count is not None and self.method != "forward":
            paths = self.unresolved_paths or 0
            parts.append(f"{counted(self.complex_count, 'complex solution')}, {counted(paths, 'unresolved path')}")
        radii = [mode.radius or 0.0 for mode in self if mode.certified]
        if radii:
            every = "each mode" if len(radii) == count else f"{len(radii)} of them"
            parts.append(f"{every} certified to {max(radii):.1e} {unit}")
        if self.engine is not None:
            parts.append(f"engine: {self.engine}")
        if self.estimated_unseen is not None and count:
            parts.append(
                f"{self.starts} starts, seed {self.seed}; estimated still unseen: {self.estimated_unseen:.3g} or more (Chao), "
                f"chance that the next hit is new: {self.next_new:.2g} (Good-Turing)"
            )
        elif self.starts and not count:
            parts.append(f"{self.starts} starts, seed {self.seed}")
        if self.smallest_residual is not None:
            parts.append(f"smallest closure error reached: {self.smallest_residual:.4g} {unit}")
        return "; ".join(parts)

    def _count(self) -> str:
        count, poses = len(self), self.poses
        if not count:
            return nothing_found(self)
        if self.total > count:
            return f"{self.total} modes, of which {count} are listed: each block's solutions beside the first ones of the others"
        return f"{count} {_plural('mode', count)}" + (f" at {poses} {_plural('pose', poses)}" if poses != count else "")


def _plural(word: str, count: int) -> str:
    return word if count == 1 else word + "s"


def nothing_found(modes: Modes) -> str:
    """What is said of an empty list: that there is none where the list is complete, that none was found where it is a sample."""
    if modes.positive_dimensional:
        return "no isolated solution"
    return "no real solution found" if modes.completeness == "sampled" else "no real solution"
