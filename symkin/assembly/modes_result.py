"""What `modes` returns: all solutions of a problem, with a statement of how complete the list
is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypedDict

import numpy as np

from symkin.assembly.mode_groups import differing_universal_joints, sets_of_modes
from symkin.computed_once import cached_property
from symkin.position.problem import Problem
from symkin.position.roots import Sample
from symkin.position.solution import Solution, finite, heading, read_together
from symkin.position.solution_list import SolutionList
from symkin.position.table import given_text, solution_table
from symkin.result import Result, Summary
from symkin.text import counted, first_of

Completeness = Literal["proved", "probability one", "incomplete", "sampled"]

_DOUBT = 0.05
"""Probability that the bound of what random starts have not hit does not hold."""
_NO_PATHS = {None, "closed form"}
"""Engines that track no paths."""
_PRINTED_ROWS = 64
"""Modes that the command prints; of more, one at each pose and set of actuated joints."""


@dataclass(frozen=True)
class Group:
    """A structure group of a problem: its unknown coordinates, its complex solutions and the real
    ones (`count`, the most) for one choice of what it reads, and what is said of its list.
    """

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


class Sampling(TypedDict, total=False):
    """What random starts tell of the roots that they have not hit, as `Modes` holds it."""

    starts: int | None
    estimated_unseen: float | None
    next_new: float | None
    unseen_share: float | None


def sampling(searches: Sequence[Sample]) -> Sampling:
    """What searches from random starts tell together; nothing where there are none. The bound of
    the share of hits at roots that are not hit yet holds for all of the searches at once.
    """
    if not searches:
        return {}
    return {
        "starts": max(one.starts for one in searches),
        "estimated_unseen": sum(one.unseen for one in searches),
        "next_new": max(one.next_new for one in searches),
        "unseen_share": max(one.unseen_share(_DOUBT / len(searches)) for one in searches),
    }


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Result):
    """All solutions found for one set of given values, with a statement of completeness that is
    never too large.

    `estimated_unseen` is Chao's lower-bound estimate of modes not yet hit, `next_new` the
    Good-Turing estimate of the probability that one more hit is new, `unseen_share` an upper bound
    of that probability, true in 95 of 100 cases (all for random starts only); `engine` is what
    solved the equations: a closed form, or the program that tracked the paths. A list of
    `Solution`s: it has a length, is iterated and indexed.

    >>> import symkin
    >>> found = symkin.modes(symkin.load("zhao2000"), joints=[81.6, 202.8, 330.6, 105.2])
    >>> len(found), found.completeness, all(mode.certified for mode in found)
    (4, 'probability one', True)
    """

    problem: Problem
    given: dict[str, Any]
    modes: SolutionList
    completeness: Completeness
    method: str
    seed: int | None
    elapsed_s: float
    starts: int | None = None
    estimated_unseen: float | None = None
    next_new: float | None = None
    unseen_share: float | None = None
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
    def _sets(self) -> np.ndarray:
        """The set (n,) of each mode: one pose, and one value of each actuated joint that is not
        given.
        """
        return sets_of_modes(self.problem, self.modes, joints=True)

    @cached_property
    def first_of_sets(self) -> list[int]:
        """Places of the first mode at each distinct pose and actuated joints, which were found; of
        all modes where neither was.
        """
        return np.unique(self._sets, return_index=True)[1].tolist()

    @cached_property
    def representatives(self) -> list[Solution]:
        """The first mode at each distinct pose and set of actuated joints, where they were found;
        else all of them.
        """
        return [self.modes[place] for place in self.first_of_sets]

    @property
    def total(self) -> int:
        """Count of modes, which may exceed those that are listed."""
        return len(self) if self.count is None else self.count

    @property
    def poses(self) -> int:
        """Count of distinct poses among the modes."""
        return len(set(sets_of_modes(self.problem, self.modes, joints=False).tolist()))

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of `symkin modes --json`."""
        hits = [mode.hits for mode in self.modes]
        read_together(self.modes)
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
            "unseen_share_95": self.unseen_share,
            "engine": self.engine,
            "notes": list(self.notes),
        }

    # --- text -------------------------------------------------------------------------------------

    def summary(self, most_rows: int | None = None, *, everything: bool = False) -> Summary:
        """The modes as a table, and what is known of their completeness; with `everything` all
        joints and named points too.
        """
        mechanism = self.problem.mechanism
        title = mechanism.name + (f" ({mechanism.title})" if mechanism.title else "")
        above = [f"{title}: {self.problem.name} problem, {given_text(self.given)}"]
        below = [
            *self._universal_joints(),
            self._statement(),
            *(f"note: {note}" for note in self.notes),
        ]
        places = self._shown(most_rows)
        if len(places) < len(self):
            below.insert(0, self._left_out(len(places), most_rows))
        table = solution_table(
            self.problem,
            [self.modes[place] for place in places],
            everything,
            [place + 1 for place in places],
        )
        below = [*([table.left_out] if table.left_out else []), *below]
        return Summary(above, table.header, table.rows, below)

    def _shown(self, most_rows: int | None) -> list[int]:
        """Places of the modes that are printed."""
        most = _PRINTED_ROWS if most_rows is None else most_rows
        if most_rows is None and len(self) > most:
            return self.first_of_sets[:most]
        return list(range(min(most, len(self))))

    def _left_out(self, shown: int, most_rows: int | None) -> str:
        sets = len(self.first_of_sets)
        if most_rows is None and sets < len(self):
            what = "poses" if sets == self.poses else "sets of pose and actuated joints"
            return (
                f"one of the modes at each of {shown} {what} of {sets}; all {len(self)} modes with "
                f"--json"
            )
        return f"the first {shown} of {len(self)} modes"

    def _universal_joints(self) -> list[str]:
        """What is said of modes that differ in U joints alone."""
        sets = len(self.first_of_sets)
        names = (
            differing_universal_joints(self.problem, self.modes, self._sets)
            if sets < len(self)
            else ()
        )
        if not names:
            return []
        what = "pose" if sets == self.poses else "pose and set of actuated joints"
        joints = f"U joint {names[0]}" if len(names) == 1 else f"U joints {first_of(names, 6)}"
        return [
            f"modes of one {what} differ in the {joints} alone: the link behind is turned about "
            f"its line to the next joint, by half a turn where that is across both axes"
        ]

    def _statement(self) -> str:
        """Count, completeness and what it rests on."""
        count, unit = len(self), self.problem.mechanism.length_unit
        parts = [f"{self.counted}; completeness: {self.completeness}"]
        if self.complex_count is not None and self.method != "forward":
            parts.append(counted(self.complex_count, "complex solution"))
            if self.unresolved_paths or self.engine not in _NO_PATHS:
                parts[-1] += f", {counted(self.unresolved_paths or 0, 'unresolved path')}"
        radii = [mode.radius or 0.0 for mode in self if mode.certified]
        if radii:
            every = "each mode" if len(radii) == count else f"{len(radii)} of them"
            parts.append(f"{every} certified to {max(radii):.1e} {unit}")
        if self.engine is not None:
            parts.append(f"engine: {self.engine}")
        if self.starts is not None:
            parts.append(f"{self.starts} starts, seed {self.seed}")
        if self.unseen_share is not None and count:
            parts.append(
                f"what is not hit yet has at most {100 * self.unseen_share:.2g} % of the hits (95 "
                f"% confidence), however many modes it is"
            )
        if self.estimated_unseen and count:
            parts.append(f"estimated still unseen: {self.estimated_unseen:.3g} or more (Chao)")
        if self.smallest_residual is not None:
            parts.append(f"smallest closure error reached: {self.smallest_residual:.4g} {unit}")
        return "; ".join(parts)

    @property
    def counted(self) -> str:
        """The count of modes, poses and sets of actuated joints in words."""
        count, poses = len(self), self.poses
        if not count:
            return nothing_found(self)
        if self.total > count:
            return (
                f"{self.total} modes, of which {count} are listed: each block's solutions beside "
                f"the first ones of the others"
            )
        sets = len(self.first_of_sets)
        at = f" at {poses} {_plural('pose', poses)}" if poses != count else ""
        return f"{count} {_plural('mode', count)}{at}" + (
            f", {sets} sets of actuated joints" if poses < sets < count else ""
        )


def _plural(word: str, count: int) -> str:
    return word if count == 1 else word + "s"


def nothing_found(modes: Modes) -> str:
    """What is said of an empty list: that there is none where the list is complete, that none was
    found where it is a sample.
    """
    if modes.positive_dimensional:
        return "no isolated solution"
    return "no real solution found" if modes.completeness == "sampled" else "no real solution"
