"""The tree of choices: partial configurations of many inputs, which grow group by group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from symkin.assembly.account import FEW, Account
from symkin.assembly.block_paths import BlockPaths
from symkin.assembly.continuation import least_error
from symkin.assembly.families import Member
from symkin.assembly.group_roots import NO_ENDS, STATEMENTS, GroupRoots, checked_roots
from symkin.assembly.group_search import geared_roots, linear_roots, searched_alone
from symkin.assembly.group_solvers import (
    any_paths,
    group_solver,
    most_roots,
    proofs_of_group,
    proved_roots,
    solved_parts,
)
from symkin.assembly.prover import PartProofs
from symkin.assembly.search import Search
from symkin.errors import InputError
from symkin.position.gear_train import gear_train
from symkin.position.groups import is_linear
from symkin.position.problem import Problem
from symkin.position.readings import canonical
from symkin.position.roots import MOST_MODES, NOT_KNOWN, polished_roots, unite


@dataclass(eq=False)
class Tree:
    """Growing partial configurations `values` (m, variables), which are within `away` of exact ones
    (length unit), of the inputs `owner` (m,), rising, the `hits` (m,) of the rarest choice of each,
    and what is proved of them; of the one group that a problem is what was `judged` (see
    `GroupRoots`); where not all are listed, how many each input has in `total`.
    """

    values: np.ndarray
    owner: np.ndarray
    away: np.ndarray = field(init=False)
    hits: np.ndarray = field(init=False)
    proofs: PartProofs = field(init=False)
    judged: np.ndarray | None = None
    total: np.ndarray | None = None

    def __post_init__(self) -> None:
        count = len(self.owner)
        self.away, self.hits = np.zeros(self.values.shape), np.full(count, np.inf)
        self.proofs = PartProofs.of_nothing(count)

    def grow(
        self,
        group: Problem,
        found: ProvedRoots,
        which: np.ndarray,
        first: np.ndarray,
        counts: np.ndarray,
    ) -> None:
        """Take for each some solutions of a group beside it: `counts` (m,) of them, from the place
        `first` on of those of the row `which` (m,) that it asks for.
        """
        parent = np.arange(len(which)).repeat(counts)
        place = (first[which] - counts.cumsum() + counts)[parent] + np.arange(len(parent))
        proofs, self.owner = found.proofs.of(place), self.owner[parent]
        self.values, self.away = self.values[parent], self.away[parent]
        self.values[:, group.unknown_places] = found.roots.points[place]
        self.away[:, group.unknown_places] = proofs.radius[:, None]
        self.hits = np.minimum(self.hits[parent], found.roots.hits[place])
        self.proofs = self.proofs.of(parent).beside(proofs)
        self.judged = None if found.roots.judged is None else found.roots.judged[place]


@dataclass(frozen=True)
class Solving:
    """How groups are to be solved: the search, whether least errors are needed, whether solutions
    are to be proved, whether inputs with more choices than are listed keep some of them, whether a
    group `judges` its solutions for the whole problem, which it is, and whether it is the `only`
    one and none of its solutions is chosen: given values are exact then, and modes are ordered
    afterwards.
    """

    search: Search
    least_errors: bool = False
    certify: bool = False
    keeps_some: bool = False
    judges: bool = False
    only: bool = False


@dataclass(eq=False)
class Step:
    """A group by which a tree grows, its number in the account, and that of the one solution to
    take. The tree asks the group for `known` values (n, known), each once, which may be `away` from
    exact ones; each configuration for those at `which`.
    """

    group: Problem
    number: int
    tree: Tree
    choice: int | None = None
    known: np.ndarray = field(init=False)
    away: np.ndarray = field(init=False)
    which: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        places = self.group.known_places
        self.known, self.away = self.tree.values[:, places], self.tree.away[:, places]
        self.which = np.arange(len(self.known))
        if len(self.known) > 1:
            away = self.away
            self.known, self.which = _each_once(self.known)
            self.away = np.zeros(self.known.shape)
            if away.any():
                np.maximum.at(self.away, self.which, away)


class ProvedRoots(NamedTuple):
    """The solutions of a group in their order, and what is proved of them."""

    roots: GroupRoots
    proofs: PartProofs


def grow_together(
    steps: Sequence[Step], members: dict[Problem, Member], account: Account, solving: Solving
) -> None:
    """Let trees, none of them empty, grow by every solution of their groups, or the chosen one,
    beside each of their configurations. Groups that are `members` of one family are solved
    together.
    """
    for step, found in zip(steps, _solved(steps, members, solving), strict=True):
        _grow(step, found, account, solving)


def _each_once(known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The different ones of some rows (m, any), in order, and which of them each is."""
    order = np.lexsort(known.T[::-1]) if known.size else np.arange(len(known))
    rows, which = known[order], np.empty(len(known), dtype=int)
    new = np.append(True, (rows[1:] != rows[:-1]).any(axis=1))
    which[order] = new.cumsum() - 1
    return rows[new], which


def _grow(step: Step, found: ProvedRoots, account: Account, solving: Solving) -> None:
    """Let one tree grow by the solutions of its group."""
    tree, which, n, roots = step.tree, step.which, len(account.seen), found.roots
    lost = _lost(roots, tree.owner, which, n)
    if lost.any() and solving.least_errors:
        untold = np.unique(which[lost[tree.owner] & np.isinf(roots.smallest[which])])
        if untold.size:
            roots = with_least_errors(step.group, roots, step.known, untold, solving)
            found = _alone(step, solving, roots)
            roots, lost = found.roots, _lost(found.roots, tree.owner, which, n)
    of_rows = roots.counts
    account.add(step.number, roots, tree.owner, which)
    if lost.any():
        empty, least = lost[tree.owner], np.full(n, np.inf)
        np.minimum.at(least, tree.owner[empty], roots.smallest[which[empty]])
        account.smallest = _larger(account.smallest, least)
    first, counts = of_rows.cumsum() - of_rows, of_rows[which]
    if step.choice is not None:
        first, counts = _chosen(step.group, step.choice, first, counts)
    if counts.sum() > MOST_MODES:
        each = np.bincount(tree.owner, weights=counts, minlength=n)
        account.too_many[(each > MOST_MODES) & (account.too_many == FEW)] = step.number
        if solving.keeps_some:
            # no more than show that they are too many
            before = np.cumsum(counts) - counts
            before -= before[np.searchsorted(tree.owner, tree.owner)]
            counts = np.clip(MOST_MODES + 1 - before, 0, counts)
        else:
            counts = np.where(each[tree.owner] > MOST_MODES, 0, counts)
    tree.grow(step.group, found, which, first, counts)


def _larger(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The larger of two errors each (n,); infinite ones were not found."""
    return np.where(
        np.isinf(some), others, np.where(np.isinf(others), some, np.maximum(some, others))
    )


def _lost(roots: GroupRoots, owner: np.ndarray, which: np.ndarray, n: int) -> np.ndarray:
    """Inputs (n,) that ask for rows and get no solution of any."""
    asked = np.bincount(owner, minlength=n) > 0
    return asked & (np.bincount(owner, weights=roots.counts[which], minlength=n) == 0)


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


# --- solutions of groups --------------------------------------------------------------------------


def _solved(
    steps: Sequence[Step], members: dict[Problem, Member], solving: Solving
) -> list[ProvedRoots]:
    """The solutions of each group at the rows that are asked for, those of a family together."""
    found: dict[int, ProvedRoots] = {}
    families: dict[Problem, list[int]] = {}
    for place, step in enumerate(steps):
        member = members.get(step.group)
        if member is not None and solving.search.method == "continuation":
            families.setdefault(member.family, []).append(place)
            continue
        found[place] = _alone(step, solving)
    for family, places in families.items():
        together = _of_family(family, [steps[k] for k in places], members, solving)
        found |= dict(zip(places, together, strict=True))
    return [found[place] for place in range(len(steps))]


def _of_family(
    family: Problem, steps: Sequence[Step], members: dict[Problem, Member], solving: Solving
) -> list[ProvedRoots]:
    """The solutions of a family's members; rows in doubt are left to the member's own rows."""
    own = [members[step.group] for step in steps]
    known = np.vstack([one.known(step.known) for one, step in zip(own, steps, strict=True)])
    numbers = np.zeros((len(known), len(own[0].numbers)))
    away = np.hstack([np.vstack([step.away for step in steps]), numbers])
    ends = np.cumsum([len(step.known) for step in steps]).tolist()
    places = [slice(end - len(step.known), end) for end, step in zip(ends, steps, strict=True)]
    solved, doubtful = _by_solver(family, known, solving)
    if solved is None:
        return [_alone(step, solving) for step in steps]
    for place, step in zip(places, steps, strict=True):
        mine = doubtful[(doubtful >= place.start) & (doubtful < place.stop)]
        if mine.size:
            left = step.known[mine - place.start]
            alone = group_roots(step.group, left, solving)
            solved = solved.with_rows(mine, alone)
    if any(one.laid is not None for one in own):
        # complex roots are those of the family's system
        plain = replace(solved, ends=NO_ENDS, ends_of=solved.ends_of[:0], origin=None)
        return [
            _alone(step, solving, plain.at(np.arange(place.start, place.stop)), one)
            for place, step, one in zip(places, steps, own, strict=True)
        ]
    found = _proved(family, solved, known, away, solving)
    owner = found.roots.owner
    return [
        ProvedRoots(
            found.roots.at(np.arange(place.start, place.stop)),
            found.proofs.of(slice(*np.searchsorted(owner, [place.start, place.stop]).tolist())),
        )
        for place in places
    ]


def _alone(
    step: Step, solving: Solving, roots: GroupRoots | None = None, member: Member | None = None
) -> ProvedRoots:
    """The solutions of one group at what is asked of it, proved by its own rows."""
    roots = group_roots(step.group, step.known, solving) if roots is None else roots
    return _proved(step.group, roots, step.known, step.away, solving, member)


def _proved(
    group: Problem,
    roots: GroupRoots,
    known: np.ndarray,
    away: np.ndarray,
    solving: Solving,
    member: Member | None = None,
) -> ProvedRoots:
    """The solutions in their order, with what is proved of them if it is asked for."""
    roots = roots if solving.only else roots.in_order()
    if not solving.certify:
        return ProvedRoots(roots, PartProofs.of_nothing(len(roots.owner)))
    proofs, roots = proofs_of_group(group, roots, known, away, member)
    return ProvedRoots(roots, proofs)


def group_roots(group: Problem, known: np.ndarray, solving: Solving) -> GroupRoots:
    """The solutions of a group at known values (n, known)."""
    search = solving.search
    if is_linear(group):
        return linear_roots(group, known)
    train = gear_train(group)
    if train is not None:
        return geared_roots(group, train, known)
    if search.method != "continuation":
        return searched_alone(group, known, search)
    parts = solved_parts(group)
    if parts:
        return roots_of_parts(group, parts, known, search)
    found, doubtful = _by_solver(group, known, solving)
    if found is None:
        return searched_alone(group, known, search)
    if doubtful.size:
        proved, left = proved_roots(group, known[doubtful])
        if proved is not None:
            found, doubtful = found.with_rows(doubtful, proved), doubtful[left]
    if not doubtful.size:
        return found
    return found.with_rows(doubtful, searched_alone(group, known[doubtful], search))


def _by_solver(
    group: Problem, known: np.ndarray, solving: Solving
) -> tuple[GroupRoots | None, np.ndarray]:
    """The solutions of a group by its formulas or paths, None where it has neither, and the rows
    that both leave in doubt.
    """
    solver = group_solver(group, formulas=solving.search.formulas)
    if solver is None:
        return None, np.arange(len(known))
    if isinstance(solver, BlockPaths):
        certifies = solving.certify and solving.only
        return solver.roots(known, judges=solving.judges, certifies=certifies)
    found, doubtful = solver.roots(known, judges=solving.judges)
    if doubtful.size and (paths := any_paths(group)) is not None:
        tracked, left = paths.roots(known[doubtful], judges=solving.judges)
        found, doubtful = found.with_rows(doubtful, tracked), doubtful[left]
    return found, doubtful


def with_least_errors(
    group: Problem, roots: GroupRoots, known: np.ndarray, places: np.ndarray, solving: Solving
) -> GroupRoots:
    """The same with the least closure errors that are found at rows, by their `places`, of known
    values (n, known), which have no solution.
    """
    if not (solving.search.method == "continuation" and solved_parts(group)):
        return roots.with_rows(places, searched_alone(group, known[places], solving.search))
    smallest = roots.smallest.copy()
    for place in places.tolist():
        smallest[place] = least_error(group, known[place])
    return replace(roots, smallest=smallest)


# --- groups that implied rows take apart ----------------------------------------------------------


def roots_of_parts(
    group: Problem,
    parts: Sequence[Problem],
    known: np.ndarray,
    search: Search,
) -> GroupRoots:
    """The solutions of a group from those of its parts, each for every choice of those before it,
    held against all rows of the group. Passive joints whose rows known values must agree with are
    left to formulas in any case.
    """
    begin = np.zeros((len(known), group.closure.variables.shape[0]))
    begin[:, group.known_places] = known
    n = len(known)
    tree, account = Tree(begin, np.arange(n)), Account.empty(n, len(parts))
    solving = Solving(replace(search, formulas=True), keeps_some=True)
    for number, part in enumerate(parts):
        if len(tree.owner):
            grow_together([Step(part, number, tree)], {}, account, solving)
    generic = [most_roots(part) for part in parts]
    most = np.array([NOT_KNOWN if count is None else count for count in generic], dtype=float)
    points, owner, hits, met = _held_against(group, tree, known)
    statement = np.max(account.statement, axis=1, initial=0)
    many = account.too_many != FEW
    statement[many] = np.maximum(statement[many], STATEMENTS.index("incomplete"))
    told = {i: tuple(dict.fromkeys(account.notes_of(i))) for i in range(n)}
    counts = account.factors([([*range(len(parts))], False)])
    return GroupRoots(
        points,
        owner,
        hits,
        statement=statement,
        complex_count=np.prod(np.where(account.seen, counts, most), axis=1),
        unresolved=np.sum(account.unresolved, axis=1),
        smallest=np.full(n, np.inf),
        continuum=account.continuum.any(axis=1) | met,
        notes={i: texts for i, texts in told.items() if texts},
        engine=np.array(account.each_engine, dtype=object),
    )


def _held_against(
    group: Problem, tree: Tree, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Distinct solutions (m, width) of all rows of a group among whole configurations, with their
    inputs, rising, and hits; and the inputs (n,) at which a set that is not isolated was met.
    """
    system = group.system
    points, n = tree.values[:, group.unknown_places], len(known)
    plain = np.ones(n, dtype=bool)
    found, origin, _ = checked_roots(system, points, tree.owner, known, plain)
    parts = [
        (found[kept], tree.owner[origin[kept]], tree.hits[origin[kept]])
        for kept in [plain[tree.owner[origin]]]
    ]
    met = np.zeros(n, dtype=bool)
    for i in np.flatnonzero(~plain).tolist():
        mine = np.flatnonzero(tree.owner == i)
        polished = polished_roots(system, points[mine], known[i])
        met[i] = polished.continuum is not None
        first, _ = unite(system, polished.points, known[i], continuum_met=bool(met[i]))
        own = canonical(system, polished.points[first])
        least = np.full(len(own), np.min(tree.hits[mine], initial=np.inf))
        parts.append((own, np.full(len(own), i), least))
    points, owner, hits = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(owner, kind="stable")
    return points[order], owner[order], hits[order], met
