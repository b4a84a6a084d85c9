"""All modes of a problem by its structure groups, for one set of given values or for many.

Each group is solved for every choice of those before it that it depends on, for all inputs
together. The modes of an input are the tree of the groups' choices. A group is solved once for each
set of values that it reads, so that the cost grows with the sum of the groups and not with their
product; groups that do not read each other's values are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import prod

import numpy as np

from symkin.assembly.group_roots import (
    STATEMENTS,
    GroupRoots,
    engines_together,
    group_roots,
    with_least_errors,
)
from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.mode_proofs import (
    PartProofs,
    can_be_proved,
    ground_notes,
    proofs_of_group,
    theorem_notes,
)
from symkin.assembly.modes_result import Completeness, Group, Modes, sampling
from symkin.assembly.search import Search
from symkin.errors import InputError, TooManyModesError
from symkin.numeric.levenberg import Progress
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.given import Given
from symkin.position.groups import structure_groups
from symkin.position.problem import Problem
from symkin.position.roots import MOST_MODES, Roots, product_of_counts, sum_of_counts
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.text import shown

FEW = -1
"""In place of the group at which choices are too many: there is none."""


@dataclass(frozen=True, eq=False)
class GroupedModes:
    """Modes of n inputs: `listed` (m,) of the inputs `owner` (m,), rising, and of each input how
    many there are (`total`), the place of what is said of them in `STATEMENTS`, and what the groups
    tell (`account`).
    """

    problem: Problem
    search: Search
    listed: SolutionList
    owner: np.ndarray
    total: tuple[int, ...]
    statement: np.ndarray
    account: _Account

    def modes_of(self, number: int, given: Given) -> Modes:
        """The modes of one input. Raises TooManyModesError where its groups' choices are more than
        can be held.
        """
        account, groups = self.account, structure_groups(self.problem)
        if account.too_many[number] != FEW:
            raise TooManyModesError(_too_many(self.problem, groups, int(account.too_many[number])))
        mine = np.flatnonzero(self.owner == number)
        found = replace(self.listed.chosen(mine), notes=given.notes)
        reached = np.flatnonzero(account.seen[number]).tolist()
        grounds = (
            []
            if found.ground is None
            else [ground for ground in found.ground if ground is not None]
        )
        smallest = float(account.smallest[number])
        continuum = bool(account.continuum[number].any())
        return Modes(
            problem=self.problem,
            given=given.echo,
            modes=found,
            completeness=STATEMENTS[self.statement[number]],
            method=self.search.name,
            seed=self.search.seed,
            elapsed_s=0.0,
            **sampling(account.samples.get(number, [])),
            complex_count=account.complex_count_of(number),
            unresolved_paths=account.unresolved_of(number),
            smallest_residual=None
            if len(found) or continuum or not np.isfinite(smallest)
            else smallest,
            positive_dimensional=continuum,
            notes=tuple(
                dict.fromkeys(
                    (
                        *given.notes,
                        *account.notes_of(number),
                        *theorem_notes(account.theorems_of(number)),
                        *ground_notes(self.problem, grounds, len(found)),
                    )
                )
            ),
            engine=account.engine,
            groups=tuple(account.group_of(number, k, groups[k]) for k in reached),
            count=self.total[number],
        )


@dataclass(eq=False)
class _Account:
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
    notes: list[tuple[int, np.ndarray | None, tuple[str, ...]]] = field(default_factory=list)
    engines: list[str] = field(default_factory=list)
    theorems: dict[int, str] = field(default_factory=dict)
    samples: dict[int, list[Roots]] = field(default_factory=dict)

    @staticmethod
    def empty(n: int, groups: int) -> _Account:
        statement, count = (np.zeros((n, groups), dtype=int) for _ in range(2))
        complex_count, unresolved = (np.zeros((n, groups)) for _ in range(2))
        seen, continuum = (np.zeros((n, groups), dtype=bool) for _ in range(2))
        return _Account(
            seen,
            statement,
            complex_count,
            count,
            unresolved,
            continuum,
            np.full(n, np.inf),
            np.full(n, FEW),
        )

    def add(self, number: int, roots: GroupRoots, owner: np.ndarray, which: np.ndarray) -> None:
        """What a group's roots say of inputs: each pair of `owner` (k,) and `which` (k,) is an
        input and a row that it asks for.
        """
        self.seen[owner, number] = True
        counts = roots.counts
        for array, values in (
            (self.statement, roots.statement),
            (self.complex_count, roots.complex_count),
            (self.count, counts),
        ):
            with np.errstate(invalid="ignore"):  # a count that is not known stays so
                np.maximum.at(array[:, number], owner, values[which])
        self._add_unresolved(number, roots, owner, which)
        np.logical_or.at(self.continuum[:, number], owner, roots.continuum[which])
        self.notes.append((number, None, roots.orbits))
        self.notes += [
            (number, np.unique(owner[which == row]), texts) for row, texts in roots.notes.items()
        ]
        if roots.theorem is not None:
            self.theorems[number] = roots.theorem
        self.engines += [roots.engine] if roots.engine is not None else []
        for row, sample in roots.samples.items():
            for i in np.unique(owner[which == row]).tolist():
                self.samples.setdefault(i, []).append(sample)

    def _add_unresolved(
        self, number: int, roots: GroupRoots, owner: np.ndarray, which: np.ndarray
    ) -> None:
        """Unresolved paths of all different rows that an input asks for."""
        pairs = (
            np.unique(np.stack([owner, which]), axis=1)
            if roots.unresolved.any()
            else np.zeros((2, 0), dtype=int)
        )
        np.add.at(self.unresolved[:, number], pairs[0], roots.unresolved[pairs[1]])

    @property
    def engine(self) -> str | None:
        return engines_together(self.engines)

    @property
    def whole(self) -> np.ndarray:
        """Inputs (n,) that have reached all groups."""
        return np.asarray(self.seen.all(axis=1))

    def complex_count_of(self, number: int) -> int | None:
        """Complex solutions of an input; None where they are not known."""
        return (
            product_of_counts(self.complex_count[number].tolist())
            if self.seen[number].all()
            else None
        )

    def unresolved_of(self, number: int) -> int | None:
        """Unresolved paths of an input; None where some group was searched without paths."""
        return sum_of_counts(self.unresolved[number].tolist())

    def theorems_of(self, number: int) -> list[str]:
        """What proves an input's groups complete, in their order."""
        proved = np.flatnonzero(self.seen[number] & (self.statement[number] == 0)).tolist()
        return [self.theorems[k] for k in proved if k in self.theorems]

    def notes_of(self, number: int) -> list[str]:
        """What is said of an input's groups, in their order."""
        told = [
            k for k, (_, inputs, _) in enumerate(self.notes) if inputs is None or number in inputs
        ]
        chosen = sorted(
            (self.notes[k] for k in told if self.seen[number, self.notes[k][0]]),
            key=lambda note: note[0],
        )
        return [text for _, _, texts in chosen for text in texts]

    def group_of(self, number: int, place: int, group: Problem) -> Group:
        """A group as it is for one input."""
        unknowns = tuple(c.name for c in group.system.unknowns)
        complex_count = product_of_counts([self.complex_count[number, place]])
        statement: Completeness = STATEMENTS[self.statement[number, place]]
        count = int(self.count[number, place])
        return Group(", ".join(unknowns), unknowns, complex_count, statement, count)


def modes_by_groups(
    problem: Problem,
    known: np.ndarray,
    search: Search,
    choose: Sequence[int] = (),
    *,
    least_errors: bool = False,
    certify: bool = False,
    progress: Progress | None = None,
) -> GroupedModes:
    """The modes for known values (n, numbers); `choose` takes one solution of each of the first
    groups, by number. With `least_errors` inputs without a solution are searched for the least
    closure error; with `certify` modes are proved.
    """
    n, groups = len(known), structure_groups(problem)
    begin = np.zeros((n, int(problem.closure.variables.shape[0])))
    # of a structure nothing moves, its geometry is what is given
    begin[:, problem.known_places] = known if known.shape[1] else problem.reference_known
    _check_choices(problem, choose)
    account, parts = _Account.empty(n, len(groups)), []
    certify = certify and can_be_proved(groups)
    for numbers in independent_parts(groups):
        exact, proofs = np.zeros(begin.shape), PartProofs.of_nothing(n)
        tree = _Tree(begin, exact, np.arange(n), np.full(n, np.inf), proofs)
        for number in numbers:
            chosen = choose[number] if number < len(choose) else None
            tree = _extended(
                groups[number],
                number,
                tree,
                account,
                _Ask(search, chosen, least_errors, certify, progress),
            )
        columns = np.concatenate([groups[number].unknown_places for number in numbers])
        parts.append(replace(tree, values=tree.values[:, columns], columns=columns))
    return _checked(problem, known, search, account, _combined(begin, parts), certify=certify)


def independent_parts(groups: Sequence[Problem]) -> list[list[int]]:
    """Numbers of the groups that read each other's values, directly or not: a left leg and a right
    one are two parts.
    """
    label = list(range(len(groups)))
    for k, group in enumerate(groups):
        read = {c.name for c in group.known_coordinates}
        for j in range(k):
            if read & {c.name for c in groups[j].system.unknowns}:
                old, new = label[j], label[k]
                label = [new if mine == old else mine for mine in label]
    return [[k for k, mine in enumerate(label) if mine == part] for part in dict.fromkeys(label)]


def _check_choices(problem: Problem, choose: Sequence[int]) -> None:
    if not isinstance(choose, Sequence):
        raise InputError(f"choose = {shown(choose)} is no list of whole numbers, one a block")
    groups = structure_groups(problem)
    if len(choose) > len(groups):
        raise InputError(
            f"choose: {len(choose)} numbers for {len(groups)} blocks of {problem.mechanism.name}; "
            f"one a block, in order"
        )
    for number in choose:
        if isinstance(number, bool) or not isinstance(number, int) or number < 0:
            raise InputError(f"choose: {number!r}; whole numbers from 0 on are needed, one a block")


def _too_many(problem: Problem, groups: Sequence[Problem], number: int) -> str:
    names = ", ".join(c.name for c in groups[number].system.unknowns)
    return (
        f"{problem.mechanism.name}: the solutions of its blocks combine to more than the "
        f"{MOST_MODES} modes that are listed, at "
        f"block {number} ({names}) of {len(groups)}; take one solution of each of the first blocks "
        f"by choose (--choose 0,1,...), or "
        "solve for one near a start"
    )


# --- the tree of choices --------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Tree:
    """Partial configurations `values` (m, variables), which are within `away` of exact ones (length
    unit), of the inputs `owner` (m,), rising, the `hits` (m,) of the rarest choice of each, and
    what is proved of them; of a part that is done only its own `columns` of the variables.
    """

    values: np.ndarray
    away: np.ndarray
    owner: np.ndarray
    hits: np.ndarray
    proofs: PartProofs
    columns: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))


@dataclass(frozen=True)
class _Ask:
    """How a group is to be solved: the search, the number of the one solution to take, whether
    least errors are needed, and whether solutions are to be proved.
    """

    search: Search
    choice: int | None
    least_errors: bool
    certify: bool
    progress: Progress | None


def _extended(group: Problem, number: int, tree: _Tree, account: _Account, ask: _Ask) -> _Tree:
    """Each partial configuration with every solution of a group beside it, or with the chosen
    one.
    """
    if not len(tree.owner):
        return tree
    known, which = np.unique(tree.values[:, group.known_places], axis=0, return_inverse=True)
    which = which.ravel()
    roots = group_roots(group, known, ask.search, ask.progress)
    lost = _lost(roots, tree.owner, which, len(account.seen))
    if lost.any() and ask.least_errors:
        untold = np.unique(which[lost[tree.owner] & np.isinf(roots.smallest[which])])
        if untold.size:
            roots = with_least_errors(group, roots, known, untold, ask.search, ask.progress)
            lost = _lost(roots, tree.owner, which, len(account.seen))
    roots = roots.in_order()
    proofs = PartProofs.of_nothing(len(roots.owner))
    if ask.certify:
        far = np.zeros(known.shape)
        np.maximum.at(far, which, tree.away[:, group.known_places])
        proofs, complete, theorem = proofs_of_group(group, roots, known, far)
        roots = roots.proved(complete, theorem)
    account.add(number, roots, tree.owner, which)
    empty = lost[tree.owner]
    np.minimum.at(account.smallest, tree.owner[empty], roots.smallest[which[empty]])
    first, counts = np.cumsum(roots.counts) - roots.counts, roots.counts[which]
    if ask.choice is not None:
        first, counts = _chosen(group, ask.choice, first, counts)
    counts = _without_too_many(number, tree.owner, counts, account)
    parent = np.repeat(np.arange(len(which)), counts)
    place = (
        first[which[parent]]
        + np.arange(len(parent))
        - np.repeat(np.cumsum(counts) - counts, counts)
    )
    values = tree.values[parent]
    values[:, group.unknown_places] = roots.points[place]
    proofs, away = proofs.of(place), tree.away[parent]
    away[:, group.unknown_places] = proofs.radius[:, None]
    hits = np.minimum(tree.hits[parent], roots.hits[place])
    return _Tree(values, away, tree.owner[parent], hits, tree.proofs.of(parent).beside(proofs))


def _lost(roots: GroupRoots, owner: np.ndarray, which: np.ndarray, n: int) -> np.ndarray:
    """Inputs (n,) that ask for rows and get no solution of any."""
    asked = np.bincount(owner, minlength=n) > 0
    return np.asarray(asked & (np.bincount(owner, weights=roots.counts[which], minlength=n) == 0))


def _chosen(
    group: Problem, choice: int, first: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where the one solution to take stands of each row, and one for each partial configuration.
    Raises InputError.
    """
    least = int(counts.min())
    if choice >= least:
        names = ", ".join(c.name for c in group.system.unknowns)
        allowed = f"0 to {least - 1}" if least else "none"
        raise InputError(
            f"choose: {choice} for the block {names}, which has {least} solutions here; allowed: "
            f"{allowed}"
        )
    return first + choice, np.ones_like(counts)


def _without_too_many(
    number: int, owner: np.ndarray, counts: np.ndarray, account: _Account
) -> np.ndarray:
    """Counts of choices, 0 for inputs that have more than can be listed: these are marked."""
    each = np.bincount(owner, weights=counts, minlength=len(account.too_many))
    account.too_many[each > MOST_MODES] = number
    return np.where(each[owner] > MOST_MODES, 0, counts)


@dataclass(frozen=True, eq=False)
class _Combined:
    """Configurations (m, variables) of the inputs `owner` (m,), rising, with the hits of each and
    what is proved of it; how many each input has, listed or not.
    """

    values: np.ndarray
    owner: np.ndarray
    hits: np.ndarray
    proofs: PartProofs
    total: tuple[int, ...]


def _combined(begin: np.ndarray, parts: list[_Tree]) -> _Combined:
    """Every combination of the parts' solutions of each input, the last part fastest, or, where
    these are too many, the first of each with every one of one part; and how many they are.
    """
    n = len(begin)
    sizes = np.array([np.bincount(part.owner, minlength=n) for part in parts], dtype=int).reshape(
        len(parts), n
    )
    few = np.prod(sizes.astype(float), axis=0) <= MOST_MODES
    counts = np.where(few, np.prod(np.where(few, sizes, 1), axis=0), 0)
    owner = np.repeat(np.arange(n), counts)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    places = np.zeros((len(parts), len(owner)), dtype=int)
    for k in reversed(range(len(parts))):
        radix = sizes[k][owner]
        places[k] = number % radix
        number = number // radix
    for i in np.flatnonzero(~few).tolist():
        some = _some_combinations(sizes[:, i].tolist())
        before = int(np.searchsorted(owner, i))
        owner = np.insert(owner, before, np.full(some.shape[1], i))
        places = np.concatenate([places[:, :before], some, places[:, before:]], axis=1)
    values, hits = begin[owner], np.full(len(owner), np.inf)
    proofs = PartProofs.of_nothing(len(owner))
    for part, size, place in zip(parts, sizes, places, strict=True):
        row = (np.cumsum(size) - size)[owner] + place
        values[:, part.columns] = part.values[row]
        hits = np.minimum(hits, part.hits[row])
        proofs = proofs.beside(part.proofs.of(row))
    total = tuple(prod(column) for column in sizes.T.tolist())
    return _Combined(values, owner, hits, proofs, total)


def _some_combinations(sizes: list[int]) -> np.ndarray:
    """The first solution of each part with every one of one part, as places (parts,
    combinations).
    """
    first = np.zeros((len(sizes), 1), dtype=int)
    others = [
        first + np.eye(len(sizes), dtype=int)[:, [k]] * np.arange(1, size)
        for k, size in enumerate(sizes)
    ]
    return np.concatenate([first, *others], axis=1)


# --- the result -----------------------------------------------------------------------------------


def _checked(
    problem: Problem,
    known: np.ndarray,
    search: Search,
    account: _Account,
    combined: _Combined,
    *,
    certify: bool,
) -> GroupedModes:
    found = checked_solutions(problem, combined.values)
    order = order_of_modes(problem, found.values, found.position, found.quaternion, combined.owner)
    # what is listed closes: on all rows together, not only on those of its groups
    closed = found.residual[order] <= CLOSURE_TOLERANCE * problem.closure.characteristic_length
    owner = combined.owner[order]
    left_out = np.zeros(len(known), dtype=bool)
    left_out[owner[~closed]] = True
    hits = combined.hits[order[closed]]
    listed, owner = (
        replace(
            found.chosen(order[closed]), hits=np.where(np.isfinite(hits), hits, -1).astype(int)
        ),
        owner[closed],
    )
    if certify and len(listed):
        listed = combined.proofs.of(order[closed]).told(listed)
    statement = np.max(account.statement, axis=1, initial=0)
    statement = np.where(left_out, np.maximum(statement, STATEMENTS.index("incomplete")), statement)
    counts = np.bincount(owner, minlength=len(known))
    total = np.where(account.whole, np.array(combined.total, dtype=object), 0)
    total = np.where(left_out, counts, total)
    return GroupedModes(
        problem, search, listed, owner, tuple(int(count) for count in total), statement, account
    )
