"""What is known of inputs and of each group of a problem, gathered while the groups are solved."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from symkin.assembly.group_roots import STATEMENTS, GroupRoots, engines_together
from symkin.assembly.modes_result import Completeness, Group
from symkin.position.problem import Problem
from symkin.position.roots import Sample, product_of_counts

FEW = -1
"""In place of the group at which choices are too many: there is none."""


@dataclass(eq=False)
class Account:
    """What is known of n inputs and each group (n, groups): whether it was reached, the place of
    what is said of it in `STATEMENTS`, the most complex and real solutions for one choice before
    it, unresolved paths, whether a set that is not isolated was met. Of each input: what was
    searched from random starts (`samples`), and (n,) the least closure error of the group that has
    no solution, and the group at which choices are too many.
    """

    seen: np.ndarray
    statement: np.ndarray
    complex_count: np.ndarray
    count: np.ndarray
    unresolved: np.ndarray
    continuum: np.ndarray
    smallest: np.ndarray
    too_many: np.ndarray
    notes: dict[int | None, list[tuple[int, tuple[str, ...]]]] = field(default_factory=dict)
    """Of each input, and of all of them (None), what is said of groups."""
    engines: list[str] = field(default_factory=list)
    theorems: dict[int, str] = field(default_factory=dict)
    samples: dict[int, list[Sample]] = field(default_factory=dict)

    @staticmethod
    def empty(n: int, groups: int) -> Account:
        whole, numbers, flags = (np.zeros((2, n, groups), dtype=t) for t in (int, float, bool))
        least, many = np.full(n, np.inf), np.full(n, FEW)
        return Account(flags[0], whole[0], numbers[0], whole[1], numbers[1], flags[1], least, many)

    def add(self, number: int, roots: GroupRoots, owner: np.ndarray, which: np.ndarray) -> None:
        """What a group's roots say of inputs: each pair of `owner` (k,) and `which` (k,) is an
        input and a row that it asks for.
        """
        self.seen[owner, number] = True
        with np.errstate(invalid="ignore"):  # a count that is not known stays so
            np.maximum.at(self.complex_count[:, number], owner, roots.complex_count[which])
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
        self.engines += [roots.engine] if roots.engine is not None else []
        for row, sample in roots.samples.items():
            for i in np.unique(owner[which == row]).tolist():
                self.samples.setdefault(i, []).append(sample)

    @property
    def engine(self) -> str | None:
        return engines_together(self.engines)

    @property
    def whole(self) -> np.ndarray:
        """Inputs (n,) that have reached all groups."""
        return np.all(self.seen, axis=1)

    @property
    def complex_counts(self) -> list[int | None]:
        """Complex solutions of each input; None where they are not known."""
        rows = zip(self.complex_count.tolist(), self.whole.tolist(), strict=True)
        return [product_of_counts(row) if whole else None for row, whole in rows]

    def theorems_of(self, number: int) -> list[str]:
        """What proves an input's groups complete, in their order."""
        if not self.theorems:
            return []
        proved = (self.seen[number] & (self.statement[number] == 0)).nonzero()[0].tolist()
        return [self.theorems[k] for k in proved if k in self.theorems]

    def notes_of(self, number: int) -> list[str]:
        """What is said of an input's groups, in their order."""
        told = [*self.notes.get(None, ()), *self.notes.get(number, ())] if self.notes else []
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
