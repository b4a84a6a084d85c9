"""Bound the roots of rows that hold one unknown more each than those before: every root of the
first ones goes on to as many as the next row's degree.

Before that a length that stands in a row once, and an angle that a row of two terms makes a sum of
others, are taken from the other rows, and the angle at which two circles meet from both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import casadi as ca
from flint import fmpq

from symkin.certificate.exact_terms import (
    Factor,
    Term,
    Terms,
    plus,
    product_of_terms,
    terms_of,
    times,
)
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.model.joint import Coordinate

_NEVER_ZERO = ("z turn", "k turn", "turn", "i")
"""Kinds of factors that no value makes zero."""
_ZERO, _ONE, _I = fmpq(0), fmpq(1), Factor("i")
_MOST_PRODUCTS = 2_000
"""Products of two terms at most of two circles' rows, some 10 ms."""


def root_counts(system: AlgebraicSystem) -> dict[str, int] | None:
    """The most values of each unknown for values of those before it, in the order in which the rows
    give them; None where they are no such rows.

    Where a row vanishes for some values of the unknowns before it, no root is isolated there;
    where a leading coefficient does, there are fewer.
    """
    if system.projective or system.count != system.width:
        return None
    rows = terms_of(ca.vertsplit(system.rows), system.z, system.k)
    if rows is None or not all(_is_algebraic(rows, k, c) for k, c in enumerate(system.unknowns)):
        return None
    chain = _Chain(system, rows, set(range(system.width)))
    while chain.rows:
        steps = (
            chain.alone,
            chain.last,
            chain.length_once,
            chain.circles,
            chain.sum_of_angles,
        )
        if not any(step() for step in steps):
            return None
    return chain.first | chain.then


@dataclass
class _Chain:
    """Rows, the unknowns that they are to give, and what has been found: those `first` that stand
    alone, and `then` those that are put in, of which the last one put in is told by the former.
    """

    system: AlgebraicSystem
    rows: list[Terms]
    left: set[int]
    first: dict[str, int] = field(default_factory=dict)
    then: dict[str, int] = field(default_factory=dict)

    def alone(self) -> bool:
        """A row with a single unknown left: its degree."""
        for row in self.rows:
            held = [k for k in self.left if _degree(row, k) != 0]
            if len(held) == 1:
                count = self._root_count(row, held[0])
                if count is not None:
                    self._take(row, held[0])
                    self.first[self._name(held[0])] = count
                return count is not None
        return False

    def last(self) -> bool:
        """An unknown in a single row: so many for each solution of the others."""
        for k in self.left:
            own = [row for row in self.rows if _degree(row, k) != 0]
            if len(own) == 1 and (count := self._root_count(own[0], k)) is not None:
                self._put_in(own[0], k, count)
                return True
        return False

    def length_once(self) -> bool:
        """A length in one term of a row, times what is never zero, is put into the other rows."""
        for row in self.rows:
            for k in self.left:
                length = Factor("z", k)
                own = [term for term in row if length in dict(term)]
                if len(own) == 1 and _is_once(own[0], length):
                    value = _solved(row, own[0], length)
                    self._put_in(row, k, 1)
                    self.rows = [_with_length(other, length, value) for other in self.rows]
                    return True
        return False

    def circles(self) -> bool:
        """Two rows that alone hold an angle's turn t, as those of a point on two circles: sums of
        both are A t + B and C / t + D, so that A C = B D. Of its solutions each gives one t,
        -B / A or -D / C; where it gives none or any, no root is isolated.
        """
        for k in self.left:
            own = [row for row in self.rows if _degree(row, k) != 0]
            parts = _linear_sums(own, k) if len(own) == 2 else None
            if parts is not None:
                (a, b), (c, d) = parts
                self._put_in(own[0], k, 1)
                self.rows = [row for row in self.rows if row is not own[1]]
                self.rows.append(plus(times(a, c), times(b, d), -1))
                return True
        return False

    def sum_of_angles(self) -> bool:
        """A row of two terms whose quotient is a product of turns: one of these, as a product of
        the others, is put into the other rows.
        """
        for row in self.rows:
            for turn, value in _turns_given(row):
                if turn.number in self.left:
                    self._put_in(row, int(turn.number), 1)
                    self.rows = [_with_turn(other, turn, value) for other in self.rows]
                    return True
        return False

    def _root_count(self, row: Terms, unknown: int) -> int | None:
        """How many values of an unknown a row allows at most, of a rod's length but for its
        sign.
        """
        degree, coordinate = _degree(row, unknown), self.system.unknowns[unknown]
        if degree is None or coordinate.least is None:
            return degree
        middle = fmpq(*coordinate.least.as_integer_ratio())
        middle /= fmpq(*self.system.characteristic_length.as_integer_ratio())
        length = Factor("z", unknown)
        other_side: Terms = plus({(): 2 * middle}, {((length, _ONE),): _ONE}, -1)
        mirrored = _with_length(row, length, other_side)
        return (degree + 1) // 2 if not plus(row, mirrored, (-1) ** (degree + 1)) else degree

    def _put_in(self, row: Terms, unknown: int, count: int) -> None:
        """An unknown that its row gives once all those are known that are still left."""
        self._take(row, unknown)
        self.then = {self._name(unknown): count} | self.then

    def _take(self, row: Terms, unknown: int) -> None:
        self.rows = [other for other in self.rows if other is not row]
        self.left.discard(unknown)

    def _name(self, unknown: int) -> str:
        return self.system.unknowns[unknown].name


def _is_algebraic(rows: list[Terms], unknown: int, coordinate: Coordinate) -> bool:
    """Whether rows hold an angle by its exp(i z) alone, and any other unknown by its powers: one
    whose whole turns count would have more values than these.
    """
    other = Factor("z" if coordinate.is_periodic else "z turn", unknown)
    return all(
        not any(_exponents(row, other)) and _degree(row, unknown) is not None for row in rows
    )


def _is_once(term: Term, length: Factor) -> bool:
    """Whether a term is a length times what is never zero."""
    return all(e == 1 if f == length else f.kind in _NEVER_ZERO for f, e in term)


def _solved(row: Terms, own: Term, length: Factor) -> Terms:
    """The value of a length that a row holds in its `own` term alone."""
    others = {term: number / -row[own] for term, number in row.items() if term != own}
    divisor, sign = product_of_terms(tuple((f, -e) for f, e in own), ((length, _ONE),))
    return times(others, {divisor: fmpq(sign)})


def _with_length(row: Terms, length: Factor, value: Terms) -> Terms:
    found: Terms = {}
    for term, number in row.items():
        powers = dict(term)
        count = int(powers.pop(length, _ZERO).p)
        part: Terms = {tuple(sorted(powers.items())): number}
        for _ in range(count):
            part = times(part, value)
        found = plus(found, part)
    return found


def _turns_given(row: Terms) -> Iterator[tuple[Factor, tuple[Term, fmpq]]]:
    """The turns that a row of two terms gives, as a term and its number."""
    if len(row) != 2 or any(factor.kind == "z" for term in row for factor, _ in term):
        return
    (first, x), (second, y) = row.items()
    ratio, sign = product_of_terms(first, tuple((factor, -e) for factor, e in second))
    if all(factor.kind in _NEVER_ZERO for factor, _ in ratio):
        for turn, exponent in ratio:
            if turn.kind == "z turn" and abs(exponent) == 1:
                others = tuple((f, -e / exponent) for f, e in ratio if f != turn)
                yield turn, (others, (-sign * y / x) ** int(exponent.p))


def _with_turn(row: Terms, turn: Factor, value: tuple[Term, fmpq]) -> Terms:
    """A row with a turn put in, times its root where that makes exponents whole: it is never
    zero.
    """
    (others, number), found = value, Terms()
    by_turn = _by_turn(row, turn)
    part_of_one = (least := min(by_turn)) - least.p // least.q
    for exponent, part in by_turn.items():
        count = int((exponent - part_of_one).p)
        power = tuple((f, e * count) for f, e in others)
        found = plus(found, times(part, {power: number**count}))
    return found


def _linear_sums(
    rows: Sequence[Terms], unknown: int
) -> tuple[tuple[Terms, Terms], tuple[Terms, Terms]] | None:
    """A and B, and C and D, of sums A t + B and C / t + D of two rows, each times a number, where t
    is an unknown's turn; None where there are none.
    """
    (first, second), turn, found = rows, Factor("z turn", unknown), []
    for exponent in (-_ONE, _ONE):
        own, other = (_by_turn(row, turn).get(exponent, {}) for row in rows)
        place = next(iter(other), None)
        if place is None:
            return None
        plain = tuple((f, e) for f, e in place if f != _I)
        (x, y), (u, v) = (
            [part.get(term, _ZERO) for term in _with_i(plain)] for part in (own, other)
        )
        square = -(u * u + v * v)
        factor = {(): (x * u + y * v) / square, ((_I, _ONE),): (y * u - x * v) / square}
        whole = plus(first, times(second, {term: n for term, n in factor.items() if n}))
        parts = _by_turn(whole, turn)
        rest, turned = parts.pop(_ZERO, {}), parts.pop(-exponent, {})
        if parts or not turned:
            return None
        found.append((turned, rest))
    (a, b), (c, d) = found
    few = len(a) * len(c) + len(b) * len(d) <= _MOST_PRODUCTS
    return ((a, b), (c, d)) if few else None


def _with_i(term: Term) -> tuple[Term, Term]:
    """A term, and that times i."""
    return term, tuple(sorted((*term, (_I, _ONE))))


def _by_turn(row: Terms, turn: Factor) -> dict[fmpq, Terms]:
    """What a row has in front of each power of a turn."""
    parts = dict[fmpq, Terms]()
    for term, number in row.items():
        powers = dict(term)
        part = parts.setdefault(powers.pop(turn, _ZERO), {})
        part[tuple(sorted(powers.items()))] = number
    return parts


def _exponents(row: Terms, factor: Factor) -> list[fmpq]:
    return [dict(term).get(factor, _ZERO) for term in row]


def _degree(row: Terms, unknown: int) -> int | None:
    """The degree of a row in an unknown, or in its exp(i z), the others known: a bound on its
    roots, modulo whole turns. None where it is no polynomial in one of these, or changes not its
    sign alone where z moves by a whole turn.
    """
    values, turns = (_exponents(row, Factor(kind, unknown)) for kind in ("z", "z turn"))
    if not any(turns):
        return int(max(values, default=_ZERO).p)
    span = max(turns) - min(turns)
    whole = all((e - min(turns)).q == 1 for e in turns)
    return int(span.p) if whole and not any(values) else None
