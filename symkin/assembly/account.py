"""What is known of inputs and of each group of a problem, gathered while the groups are solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import compress

import numpy as np

from symkin.assembly.group_roots import STATEMENTS, GroupRoots, engines_together
from symkin.assembly.modes_result import Completeness, Group
from symkin.position.problem import Problem
from symkin.position.roots import NOT_KNOWN, Sample, product_of_counts

Part = tuple[list[int], bool]
"""Numbers of groups that read each other's values, two or more, and whether given values must meet
conditions for which a later one refuses choices of those before it.
"""
FEW = -1
"""In place of the group at which choices are too many: there is none."""


@dataclass(eq=False)
class Account:
    """What is known of n inputs and each group (n, groups): whether it was reached, the place of
    what is said of it in `STATEMENTS`, the most complex and real solutions for one choice before
    it, for how many choices it was `asked` and the complex solutions of `all_choices`, unresolved
    paths, whether a set that is not isolated was met. Of each input: what was searched from random
    starts (`samples`), and (n,) the least closure error of the group that has no solution, the
    group at which choices are too many, and whether each of `engines` has found its solutions.
    """

    seen: np.ndarray
    statement: np.ndarray
    complex_count: np.ndarray
    count: np.ndarray
    asked: np.ndarray
    all_choices: np.ndarray
    unresolved: np.ndarray
    continuum: np.ndarray
    smallest: np.ndarray
    too_many: np.ndarray
    notes: dict[int | None, list[tuple[int, tuple[str, ...]]]] = field(default_factory=dict)
    """Of each input, and of all of them (None), what is said of groups."""
    engines: dict[str, np.ndarray] = field(default_factory=dict)
    theorems: dict[int, str] = field(default_factory=dict)
    samples: dict[int, list[Sample]] = field(default_factory=dict)

    @staticmethod
    def empty(n: int, groups: int) -> Account:
        whole, numbers, flags = (np.zeros((3, n, groups), dtype=t) for t in (int, float, bool))
        least, many = np.full(n, np.inf), np.full(n, FEW)
        counts = numbers[0], whole[1], whole[2], numbers[1], numbers[2]
        return Account(flags[0], whole[0], *counts, flags[1], least, many)

    def add(self, number: int, roots: GroupRoots, owner: np.ndarray, which: np.ndarray) -> None:
        """What a group's roots say of inputs: each pair of `owner` (k,) and `which` (k,) is an
        input and a row that it asks for.
        """
        n = len(self.seen)
        self.seen[owner, number] = True
        with np.errstate(invalid="ignore"):  # a count that is not known stays so
            np.maximum.at(self.complex_count[:, number], owner, roots.complex_count[which])
            self.all_choices[:, number] = np.bincount(owner, roots.complex_count[which], n)
        self.asked[:, number] = np.bincount(owner, minlength=n)
        np.maximum.at(self.count[:, number], owner, roots.counts[which])
        for array, values in (
            (self.statement, roots.statement),
            (self.continuum, roots.continuum),
        ):
            if values.any():
                np.maximum.at(array[:, number], owner, values[which])
        if roots.unresolved.any():
            # of all different rows that an input asks for
            pairs = np.unique(np.stack([owner, which]), axis=1)
            np.add.at(self.unresolved[:, number], pairs[0], roots.unresolved[pairs[1]])
        if roots.orbits:
            self.notes.setdefault(None, []).append((number, roots.orbits))
        if roots.notes:
            asked = np.isin(which, list(roots.notes))
            pairs = np.unique(np.stack([owner[asked], which[asked]], axis=1), axis=0)
            for i, row in pairs.tolist():
                self.notes.setdefault(i, []).append((number, roots.notes[row]))
        if roots.theorem is not None:
            self.theorems[number] = roots.theorem
        for name in dict.fromkeys(roots.engine.tolist()):
            if name is not None:
                own = self.engines.setdefault(name, np.zeros(n, dtype=bool))
                own[owner[roots.engine[which] == name]] = True
        for row, sample in roots.samples.items():
            for i in np.unique(owner[which == row]).tolist():
                self.samples.setdefault(i, []).append(sample)

    @property
    def each_engine(self) -> list[str | None]:
        """What has found the solutions of each input."""
        if len(self.engines) < 2:
            names = [None, *self.engines]
            found = next(iter(self.engines.values()), np.zeros(len(self.seen), dtype=bool))
            return [names[used] for used in found.tolist()]
        used = list(zip(*(own.tolist() for own in self.engines.values()), strict=True))
        told = {kind: engines_together(compress(self.engines, kind)) for kind in set(used)}
        return [told[kind] for kind in used]

    @property
    def whole(self) -> np.ndarray:
        """Inputs (n,) that have reached all groups."""
        return np.asarray(self.seen.all(axis=1))

    def factors(self, parts: Sequence[Part]) -> np.ndarray:
        """Numbers (n, groups) whose product is the count of an input's complex solutions, of groups
        that are these parts. Where a group has not as many for each choice before it, or may refuse
        choices, they are counted choice by choice if no choice is complex; else they are not known.
        """
        found = self.complex_count.copy()
        for part, refuses in parts:
            uneven = self.all_choices[:, part] != (self.asked * self.complex_count)[:, part]
            rows = (uneven[:, 1:].any(axis=1) | refuses).nonzero()[0]
            asked, counts = self.asked[rows[:, None], part], self.all_choices[rows[:, None], part]
            real = (asked[:, 1:] == counts[:, :-1]).all(axis=1)
            found[rows[:, None], part] = 1.0
            found[rows, part[-1]] = np.where(real, counts[:, -1], NOT_KNOWN)
        return found

    def theorem_notes_of(self, number: int) -> list[str]:
        """What is said of the bounds that the solutions of an input's groups reach, in their order:
        of several those that are about more than one unknown alone.
        """
        if not self.theorems:
            return []
        proved = (self.seen[number] & (self.statement[number] == 0)).nonzero()[0].tolist()
        found = dict.fromkeys(self.theorems[k] for k in proved if k in self.theorems)
        return [f"at most {text}" for text in found if len(found) == 1 or "alone" not in text]

    def notes_of(self, number: int) -> list[str]:
        """What is said of an input's groups, in their order."""
        if not self.notes:
            return []
        told = [*self.notes.get(None, ()), *self.notes.get(number, ())]
        chosen = sorted(
            ((group, texts) for group, texts in told if self.seen[number, group]),
            key=lambda note: note[0],
        )
        return [text for _, texts in chosen for text in texts]

    def group_of(self, number: int, place: int, group: Problem) -> Group:
        """A group as it is for one input."""
        unknowns = tuple(c.name for c in group.system.unknowns)
        complex_count = product_of_counts([self.complex_count[number, place]])
        statement: Completeness = STATEMENTS[self.statement[number, place]]
        count = int(self.count[number, place])
        return Group(", ".join(unknowns), unknowns, complex_count, statement, count)
