"""All modes of a problem by its structure groups, for one set of given values or for many.

Each group is solved for every choice of those before it that it depends on, for all inputs
together. The modes of an input are the tree of the groups' choices. A group is solved once for each
set of values that it reads, so that the cost grows with the sum of the groups and not with their
product; groups that do not read each other's values are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import prod
from typing import Any

import numpy as np

from symkin.assembly.account import FEW, Account
from symkin.assembly.as_written import Told
from symkin.assembly.group_roots import STATEMENTS
from symkin.assembly.least_modes import with_least_modes
from symkin.assembly.mode_order import order_of_modes
from symkin.assembly.modes_result import Group, Modes, sampling
from symkin.assembly.plan import Plan, plan_of
from symkin.assembly.search import Search
from symkin.assembly.tree import Solving, Step, Tree, grow_together
from symkin.assembly.without_search import known_without_search
from symkin.errors import InputError, TooManyModesError
from symkin.position.given import Given
from symkin.position.platform_motion import motion_notes
from symkin.position.problem import Problem
from symkin.position.roots import MOST_MODES, NOT_KNOWN, of_each, product_of_counts, sum_of_counts
from symkin.position.solution import PartialProof
from symkin.position.solution_list import SolutionList, checked_solutions
from symkin.quiet import collector_at_rest
from symkin.text import shown


@dataclass(frozen=True, eq=False)
class GroupedModes:
    """Modes of n inputs: `listed` (m,) of the inputs `owner` (m,), rising, and of each input how
    many are listed (`counts`) and there are (`total`), the place of what is said of them in
    `STATEMENTS`, and what the groups tell (`account`). `told` is the description whose coordinates
    they are told in, None for those of the problem.
    """

    plan: Plan
    search: Search
    told: Told | None
    listed: SolutionList
    owner: np.ndarray
    counts: np.ndarray
    total: np.ndarray
    statement: np.ndarray
    account: Account

    @property
    def asked(self) -> Problem:
        """The problem in whose coordinates the modes are told."""
        return self.plan.problem if self.told is None else self.told.problem

    @property
    def factors(self) -> np.ndarray:
        """Numbers (n, groups) whose product is the count of an input's complex solutions."""
        return self.account.factors(self.plan.dependent_parts)

    @collector_at_rest()
    def modes(self, givens: Sequence[Given]) -> list[Modes]:
        """The modes of each input. Raises TooManyModesError where the choices of its groups are
        more than can be held.
        """
        account = self.account
        for number in account.too_many[account.too_many != FEW].tolist():
            raise TooManyModesError(_too_many(self.plan, number))
        met, smallest = account.continuum.any(axis=1), account.smallest
        factors = np.where(account.whole[:, None], self.factors, NOT_KNOWN)
        missed = (self.counts == 0) & ~met & np.isfinite(smallest)
        columns = {
            "completeness": [STATEMENTS[said] for said in self.statement.tolist()],
            "complex_count": of_each(product_of_counts, factors),
            "unresolved_paths": of_each(sum_of_counts, account.unresolved),
            "smallest_residual": [
                least if lost else None
                for least, lost in zip(smallest.tolist(), missed.tolist(), strict=True)
            ],
            "positive_dimensional": met.tolist(),
            "count": list(map(int, self.total.tolist())),
            "engine": account.each_engine,
        }
        ends = self.counts.cumsum()
        places = map(slice, (ends - self.counts).tolist(), ends.tolist())
        rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
        told = [] if self.listed.ground is None else self.listed.ground.tolist()
        find = partial(self._modes_of, told if any(told) else [])
        return list(map(find, range(len(givens)), givens, places, rows))

    def _modes_of(
        self,
        grounds: list[PartialProof | None],
        number: int,
        given: Given,
        places: slice,
        told: dict[str, Any],
    ) -> Modes:
        """The modes of an input, with the `grounds` of all modes that are not certified."""
        account, own = self.account, [one for one in grounds[places] if one is not None]
        # for each of many inputs: a frozen record would be given its fields one by one
        found = object.__new__(Modes)
        vars(found).update(
            told,
            problem=self.asked,
            given=given.echo,
            modes=self.listed.chosen(places, notes=given.notes),
            method="closed" if told["engine"] == "closed form" else self.search.name,
            seed=self.search.seed,
            elapsed_s=self.search.elapsed_s,
            **sampling(account.samples.get(number, [])),
            notes=(
                *given.notes,
                *self.plan.notes,
                *account.notes_of(number),
                *account.theorem_notes_of(number),
                *_ground_notes(self.plan.problem, own, int(self.counts[number])),
            ),
            groups=self._groups_of(number) if self.plan.problem.by_name else (),
        )
        found.__post_init__()
        return found

    def _groups_of(self, number: int) -> tuple[Group, ...]:
        """What is known of the groups that an input has reached."""
        account, groups = self.account, self.plan.groups
        reached = account.seen[number].nonzero()[0].tolist()
        return tuple(account.group_of(number, k, groups[k]) for k in reached)


def modes_by_groups(
    problem: Problem,
    known: np.ndarray,
    search: Search,
    choose: Sequence[int] = (),
    *,
    least_errors: bool = False,
    certify: bool = False,
    told: Told | None = None,
) -> GroupedModes:
    """The modes for known values (n, numbers); `choose` takes one solution of each of the first
    groups, by number. With `least_errors` inputs without a solution are searched for the least
    closure error; with `certify` modes are proved. Those of a machine are `told` in the coordinates
    of a description, and held against its rows.
    """
    n, plan = len(known), plan_of(problem, search)
    groups, parts = plan.groups, plan.parts
    begin = np.zeros((n, problem.closure.reference.size))
    problem.put_known(begin, known)
    if choose != ():
        _check_choices(plan, choose)
    account, certify = Account.empty(n, len(groups)), certify and plan.can_be_proved
    # rows of the one group that a problem is need no second look
    judges = told is None and plan.is_one_group
    only = len(groups) == 1 and not choose
    solving = Solving(search, least_errors, certify, judges=judges, only=only)
    trees = [Tree(begin, np.arange(n)) for _ in parts]
    for depth in range(max(map(len, parts), default=0)):
        steps = [
            Step(groups[k], k, tree, choose[k] if k < len(choose) else None)
            for tree, numbers in zip(trees, parts, strict=True)
            for k in numbers[depth : depth + 1]
            if len(tree.owner)
        ]
        grow_together(steps, plan.members, account, solving)
    tree = trees[0] if len(trees) == 1 else _combined(begin, trees, parts, groups)
    return _checked(plan, search, account, tree, told, certify=certify)


def modes_of_inputs(
    problem: Problem,
    givens: Sequence[Given],
    search: Search,
    choose: Sequence[int] = (),
    *,
    least_errors: bool = True,
    told: Told | None = None,
) -> list[Modes]:
    """The modes of each input of a problem by its own rows, without a search where none is needed,
    else as `modes_by_groups` finds them, proved where that can be, with what is said where there
    are none.
    """
    plan, known = plan_of(problem, search), dict[int, Modes]()
    if not plan.is_searched or any(given.off_motion for given in givens):
        known = known_without_search(plan, givens, search, told)
    left = [i for i in range(len(givens)) if i not in known]
    if not left:
        return list(known.values())
    givens = [givens[i] for i in left]
    grouped = modes_by_groups(
        problem,
        np.array([given.values for given in givens]),
        search,
        choose,
        least_errors=least_errors,
        certify=True,
        told=None if told is None else told.of(left),
    )
    found = grouped.modes(givens)
    if not grouped.counts.all():
        found = with_least_modes(problem, givens, search, found)
    if search.method == "continuation" and all(
        modes.starts is None and modes.completeness != "incomplete" for modes in found
    ):
        search.refuse_starts(problem)
    for k, modes in zip(left, found, strict=True):
        notes = motion_notes(problem) if modes.completeness == "sampled" else ()
        known[k] = replace(modes, notes=(*modes.notes, *notes)) if notes else modes
    return [known[k] for k in sorted(known)]


def _ground_notes(problem: Problem, grounds: Sequence[PartialProof], count: int) -> list[str]:
    """What is proved of those of `count` modes whose rows are redundant."""
    if not grounds:
        return []
    one, unit = grounds[0], problem.mechanism.length_unit
    every = "each mode" if len(grounds) == count else f"{len(grounds)} of the modes"
    return [
        f"proved of {every}: {one.independent} independent rows of {one.rows} vanish at one exact "
        f"point within {max(g.radius for g in grounds):.1e} {unit}, and no other row is more than "
        f"{max(g.remaining for g in grounds):.1e} {unit} there"
    ]


def _check_choices(plan: Plan, choose: Sequence[int]) -> None:
    if not isinstance(choose, Sequence):
        raise InputError(f"choose = {shown(choose)} is no list of whole numbers, one a block")
    if len(choose) > len(plan.groups):
        raise InputError(
            f"choose: {len(choose)} numbers for {len(plan.groups)} blocks of "
            f"{plan.problem.mechanism.name}; one a block, in order"
        )
    for number in choose:
        if isinstance(number, bool) or not isinstance(number, int) or number < 0:
            raise InputError(f"choose: {number!r}; whole numbers from 0 on are needed, one a block")


def _too_many(plan: Plan, number: int) -> str:
    names = ", ".join(c.name for c in plan.groups[number].system.unknowns)
    return (
        f"{plan.problem.mechanism.name}: the solutions of its blocks combine to more than the "
        f"{MOST_MODES} modes that are listed, at block {number} ({names}) of {len(plan.groups)}; "
        f"take one solution of each of the first blocks by choose (--choose 0,1,...), or solve for "
        f"one near a start"
    )


def _combined(
    begin: np.ndarray,
    trees: Sequence[Tree],
    parts: Sequence[Sequence[int]],
    groups: Sequence[Problem],
) -> Tree:
    """Every combination of the solutions of parts, which are some of the `groups`, of each input,
    the last part fastest, or, where these are too many, the first of each with every one of one
    part.
    """
    n = len(begin)
    each = [np.bincount(tree.owner, minlength=n) for tree in trees]
    sizes = np.array(each, dtype=int).reshape(len(parts), n)
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
    whole = Tree(begin[owner], owner)
    for part, own, size, place in zip(trees, parts, sizes, places, strict=True):
        row = (np.cumsum(size) - size)[owner] + place
        columns = np.concatenate([groups[k].unknown_places for k in own])
        whole.values[:, columns] = part.values[row[:, None], columns]
        whole.hits = np.minimum(whole.hits, part.hits[row])
        whole.proofs = whole.proofs.beside(part.proofs.of(row))
    whole.total = np.array([prod(column) for column in sizes.T.tolist()], dtype=object)
    return whole


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
    plan: Plan,
    search: Search,
    account: Account,
    tree: Tree,
    told: Told | None,
    *,
    certify: bool,
) -> GroupedModes:
    n, problem = len(account.seen), plan.problem
    asked = problem if told is None else told.problem
    if told is None:
        found = checked_solutions(problem, tree.values, judged=tree.judged)
    else:
        found = told.listed(problem.closure, tree.values, tree.owner)
    order = order_of_modes(asked, found, tree.owner)
    # what is listed closes: on all rows together, not only on those of its groups
    closed = found.closed[order]
    left_out = np.zeros(n, dtype=bool)
    left_out[tree.owner[order[~closed]]] = True
    order = order[closed]
    owner, hits = tree.owner[order], tree.hits[order]
    proved = tree.proofs.of(order).told() if certify and order.size else {}
    hits = np.where(np.isfinite(hits), hits, -1).astype(int)
    listed = found.chosen(order, hits=hits, **proved)
    statement = account.statement.max(axis=1, initial=0)
    statement = np.where(left_out, np.maximum(statement, STATEMENTS.index("incomplete")), statement)
    counts = np.bincount(owner, minlength=n)
    every = np.bincount(tree.owner, minlength=n) if tree.total is None else tree.total
    total = np.where(left_out, counts, np.where(account.whole, every, 0))
    return GroupedModes(plan, search, told, listed, owner, counts, total, statement, account)
