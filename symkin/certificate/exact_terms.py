"""Write closure rows as sums of terms, whose numbers are exact, to see which powers they hold.

An angle z is known to rows by t = exp(i z), which is never zero: cos z = (t + 1/t) / 2, sin z =
(t - 1/t) / (2 i). Known angles, and constant ones, have such a t too, so that the addition theorems
cancel what they cancel; other functions of known values are known values of their own. Numbers are
those of the floats in the rows, as fractions, and what cancels but for their rounding is zero: a
term that is not there is zero whatever is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import casadi as ca
from flint import fmpq

from symkin.closure.expression_graph import walk

_MOST_PRODUCTS = 2_000
"""Products of two terms at most for each row, some 10 ms: rows that are counted need 730; those of
turns about general axes in space have millions, and no bound.
"""
_MOST_OF_KNOWN = 500
"""Products of terms of known values at most: a longer one is a known value of its own, of which a
place about general axes in space has many.
"""
_ROUNDING = 1e-13
"""How far a number of the rows may be off, of itself: some hundreds of roundings. Axes that stand
anywhere are unit vectors, at right angles to others, to rounding alone.
"""
_HALF, _ONE = fmpq(1, 2), fmpq(1)


class Factor(NamedTuple):
    """What a term is a power of: an unknown `z` or a known value `k` by its number, the t of one of
    these (`z turn`, `k turn`) or of a constant angle (`turn`), a function of known values
    (`known`), the imaginary unit (`i`).
    """

    kind: str
    number: int | tuple[int, int] = 0


Term = tuple[tuple[Factor, fmpq], ...]
"""Factors, each once and in order, with their exponents."""
Terms = dict[Term, fmpq]
"""A sum: terms with their coefficients, none of which is zero."""
_Sum = dict[Term, tuple[fmpq, float]]
"""A sum that is being made: terms with their coefficients, and how far each may be off by the
rounding of geometry.
"""
_I = Factor("i")


class NotTermsError(Exception):
    """Rows are no such sums, or of too many terms."""


def terms_of(rows: Sequence[ca.SX], unknown: ca.SX, known: ca.SX) -> list[Terms] | None:
    """Each row as a sum of terms; None where some row is none, or has too many."""
    function = ca.Function("rows", [unknown, known], [ca.densify(ca.vertcat(*rows))], {"cse": True})
    reader = _Reader(_MOST_PRODUCTS * len(rows))
    try:
        walk(function, reader)
    except NotTermsError:
        return None
    return [reader.found[k] for k in range(len(rows))]


def plus(first: Terms, second: Terms, factor: int = 1) -> Terms:
    """A sum of terms and `factor` times another."""
    found = dict(first)
    for term, number in second.items():
        _add(found, term, factor * number)
    return found


def times(first: Terms, second: Terms) -> Terms:
    """The product of two sums of terms."""
    found: Terms = {}
    for a, x in first.items():
        for b, y in second.items():
            term, sign = product_of_terms(a, b)
            _add(found, term, sign * x * y)
    return found


def _add(terms: Terms, term: Term, number: fmpq) -> None:
    """Add a term; what a sum leaves of both beyond the rounding of geometry is nothing."""
    before = terms.get(term, fmpq(0))
    total = before + number
    if _size(total) <= _ROUNDING * _size(number):
        terms.pop(term, None)
    else:
        terms[term] = total


def _size(number: fmpq) -> float:
    """The size of a number; python-flint 0.6 makes no float of a fraction."""
    return abs(int(number.p) / int(number.q))


def product_of_terms(first: Term, second: Term) -> tuple[Term, int]:
    """The product of two terms, in which i stands once or not at all, and its sign: i^2 = -1."""
    powers = dict(first)
    for factor, exponent in second:
        powers[factor] = powers.get(factor, fmpq(0)) + exponent
    quarters = int(powers.pop(_I, fmpq(0)).p) % 4
    powers[_I] = fmpq(quarters % 2)
    sign = -1 if quarters > 1 else 1
    return tuple(sorted((f, e) for f, e in powers.items() if e != 0)), sign


@dataclass
class _Reader:
    """Evaluator that makes sums of terms, by so many `products` of two terms at most. What cancels
    is judged by how far the numbers that are left may be off, whatever the way to them.
    """

    products: int
    found: dict[int, Terms] = field(default_factory=dict)
    functions: int = 0

    def input(self, number: int, nonzero: int) -> _Sum:
        return {((Factor("zk"[number], nonzero), _ONE),): (_ONE, 0.0)}

    def constant(self, number: float) -> _Sum:
        return _as_sum({(): fmpq(*number.as_integer_ratio())} if number else {})

    def output(self, number: int, nonzero: int, value: _Sum) -> None:  # noqa: ARG002 - there is one output
        self.found[nonzero] = _numbers(_summed(value))

    def operation(self, op: int, operands: list[_Sum]) -> _Sum:
        if op in (ca.OP_ADD, ca.OP_SUB):
            return _added(operands[0], operands[1], 1 if op == ca.OP_ADD else -1)
        if op in (ca.OP_NEG, ca.OP_TWICE, ca.OP_ASSIGN):
            return _added({}, operands[0], {ca.OP_NEG: -1, ca.OP_TWICE: 2}.get(op, 1))
        return self._other(op, [_summed(operand) for operand in operands])

    def _other(self, op: int, operands: list[_Sum]) -> _Sum:
        first, last = operands[0], operands[-1]
        if op in (ca.OP_MUL, ca.OP_SQ):
            return self._product(first, last)
        if op in (ca.OP_SIN, ca.OP_COS) and (turn := _turn(_numbers(first))) is not None:
            return _as_sum(_sine(turn) if op == ca.OP_SIN else _cosine(turn))
        if op == ca.OP_DIV and not _is_unknown(last):
            return self._product(first, _inverse(last) or self._function())
        if any(map(_is_unknown, operands)):
            raise NotTermsError
        return self._function()

    def _function(self) -> _Sum:
        """A function of known values, of which nothing else is said."""
        self.functions += 1
        return {((Factor("known", self.functions), _ONE),): (_ONE, 0.0)}

    def _product(self, first: _Sum, second: _Sum) -> _Sum:
        count, of_unknowns = len(first) * len(second), _is_unknown(first) or _is_unknown(second)
        if not of_unknowns and count > _MOST_OF_KNOWN:
            return self._function()
        self.products -= count
        if self.products < 0:
            raise NotTermsError
        return _multiplied(first, second)


def _as_sum(terms: Terms) -> _Sum:
    return {term: (number, _ROUNDING * _size(number)) for term, number in terms.items()}


def _added(first: _Sum, second: _Sum, factor: int) -> _Sum:
    """A sum and `factor` times another."""
    found, nothing = dict(first), (fmpq(0), 0.0)
    for term, (number, off) in second.items():
        before, other = found.get(term, nothing)
        found[term] = (before + factor * number, other + abs(factor) * off)
    return found


def _multiplied(first: _Sum, second: _Sum) -> _Sum:
    """The product of two sums."""
    found, nothing = _Sum(), (fmpq(0), 0.0)
    second_sizes = [_size(number) for number, _ in second.values()]
    for a, (x, off) in first.items():
        size = _size(x)
        for (b, (y, other)), of_second in zip(second.items(), second_sizes, strict=True):
            term, sign = product_of_terms(a, b)
            before, least = found.get(term, nothing)
            found[term] = (before + sign * x * y, least + size * other + of_second * off)
    return found


def _inverse(whole: _Sum) -> _Sum | None:
    """One over a number; None of anything else."""
    if whole.keys() != {()}:
        return None
    number, off = whole[()]
    return {(): (1 / number, off / _size(number) / _size(number))}


def _summed(whole: _Sum) -> _Sum:
    """A sum without what the rounding of geometry leaves."""
    return {t: (number, off) for t, (number, off) in whole.items() if _size(number) > off}


def _numbers(whole: _Sum) -> Terms:
    return {term: number for term, (number, _) in whole.items()}


def _is_unknown(terms: Terms | _Sum) -> bool:
    return any(factor.kind.startswith("z") for term in terms for factor, _ in term)


def _turn(angle: Terms) -> Term | None:
    """exp(i angle) of a sum of coordinates, each times a number, and of a constant; None of
    anything else.
    """
    powers: dict[Factor, fmpq] = {}
    for term, number in angle.items():
        if not term:
            factor, exponent = _constant_turn(number)
        elif len(term) == 1 and term[0][0].kind in "zk" and term[0][1] == 1:
            factor, exponent = Factor(f"{term[0][0].kind} turn", term[0][0].number), number
        else:
            return None
        powers[factor] = exponent
    return tuple(sorted(powers.items()))


def _constant_turn(angle: fmpq) -> tuple[Factor, fmpq]:
    """exp(i angle) as a power of that of an odd number, which half and twice the angle share."""
    top, bottom, exponent = int(abs(angle.p)), int(angle.q), _ONE
    while top % 2 == 0:
        top, exponent = top // 2, 2 * exponent
    while bottom % 2 == 0:
        bottom, exponent = bottom // 2, exponent / 2
    return Factor("turn", (top, bottom)), exponent if angle > 0 else -exponent


def _turned_back(turn: Term) -> Term:
    return tuple((factor, -exponent) for factor, exponent in turn)


def _cosine(turn: Term) -> Terms:
    return plus({turn: _HALF}, {_turned_back(turn): _HALF})


def _sine(turn: Term) -> Terms:
    """(t - 1/t) / (2 i) = (1/t - t) i / 2."""
    return times(plus({_turned_back(turn): _HALF}, {turn: _HALF}, -1), {((_I, _ONE),): _ONE})
