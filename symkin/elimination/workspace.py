"""What is left to solve: rows, unknowns, and the formulas so far.

Coefficients are compared at random known values: an expression that vanishes at all of them is
zero, and one that is the same at all of them is constant, with probability one. It vanishes where
it is rounding beside the terms that it was made of (`term_sizes`), so that neither the unit of
length nor the place of the machine decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.elimination.polynomial import Monomial, Polynomial, Ring, add_term
from symkin.elimination.sums import total
from symkin.elimination.term_sizes import sized_numbers

ROUNDING = 1e-10
"""Share of the terms that a value was made of, and of the largest coefficient of its row, below
which it is rounding.
"""
_SAME = 1e-12
"""Relative spread over the samples within which a coefficient is a constant."""
_FEWEST = 2
"""Samples by which what is constant is told from what is not."""


class Choice(NamedTuple):
    """A formula with two values: symbols of its `sign`, +1 or -1, and of its `root`, the square
    root of the `discriminant`, below zero where no value is real; `tells` is an expression of a
    solution's generators (`Workspace.own`) that equals sign times root.
    """

    name: str
    sign: ca.SX
    root: ca.SX
    discriminant: ca.SX
    tells: ca.SX


class Deferred(NamedTuple):
    """Unknowns that have been taken out of the other rows: `rows` give them once the rest is
    known.
    """

    unknowns: tuple[int, ...]
    rows: tuple[Polynomial, ...]


@dataclass
class Workspace:
    """Rows in some unknowns, and what has been found of them.

    `symbols` are the known values and what has been defined from them, with `samples` of both and
    their `sizes` (see `term_sizes`); lengths are compared in units of `length`; `definitions` in
    their order; `values` are the symbols of solved generators; `divisors` are what formulas divide
    by, `implied` those that a discriminant keeps above zero, `squares` sums of squares, or less
    one; `own` stand for a solution's generators. With `all_rows` rows that are more than an angle
    needs take part in it together, so that its divisor is zero only where none of them decide.
    """

    ring: Ring
    rows: list[Polynomial]
    active: set[int]
    symbols: list[ca.SX]
    samples: np.ndarray
    length: float
    all_rows: bool = False
    definitions: list[tuple[ca.SX, ca.SX]] = field(default_factory=list)
    values: dict[int, ca.SX] = field(default_factory=dict)
    choices: list[Choice] = field(default_factory=list)
    divisors: list[ca.SX] = field(default_factory=list)
    implied: list[ca.SX] = field(default_factory=list)
    squares: list[ca.SX] = field(default_factory=list)
    deferred: list[Deferred] = field(default_factory=list)
    steps: list[str] = field(default_factory=list)
    own: list[ca.SX] = field(init=False)
    sizes: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.sizes = np.abs(self.samples)
        self.own = [
            ca.SX.sym(f"{part}_{self.name(number)}") for number, part in self.ring.generators
        ]

    def name(self, unknown: int) -> str:
        return self.ring.unknowns[unknown].name

    def names(self, unknowns: Iterable[int]) -> str:
        return ", ".join(self.name(k) for k in unknowns)

    # --- numbers ----------------------------------------------------------------------------------

    def numbers(self, expressions: Sequence[ca.SX]) -> np.ndarray:
        """Expressions (samples, expressions) at the sampled values."""
        if not expressions:
            return np.zeros((len(self.samples), 0))
        function = ca.Function("numbers", [ca.vertcat(*self.symbols)], [ca.vertcat(*expressions)])
        return np.array([np.asarray(function(sample)).ravel() for sample in self.samples])

    def _numbers_and_sizes(self, expressions: Sequence[ca.SX]) -> tuple[np.ndarray, np.ndarray]:
        """Expressions (samples, expressions) at the sampled values, and the sizes of their
        terms.
        """
        if not expressions:
            return np.zeros((len(self.samples), 0)), np.zeros((len(self.samples), 0))
        return sized_numbers(
            ca.vertcat(*expressions), ca.vertcat(*self.symbols), self.samples, self.sizes
        )

    def tidied(self, row: Polynomial) -> Polynomial:
        """The same row without coefficients that are zero, and with numbers for those that are
        constant.
        """
        return self.all_tidied([row])[0]

    def all_tidied(self, rows: Sequence[Polynomial], size: float = 0.0) -> list[Polynomial]:
        """Each of some rows as `tidied` makes it; of lengths up to a `size`, that of the machine,
        where constants of the rows have forgotten what they were made of.
        """
        return [
            self._tidied(row, values, sizes, size)
            for row, (values, sizes) in zip(rows, self._of_rows(rows), strict=True)
        ]

    def _of_rows(self, rows: Sequence[Polynomial]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Of each row its coefficients (samples, terms) at the sampled values and the sizes of
        their terms, of all rows together.
        """
        values, sizes = self._numbers_and_sizes([c for row in rows for c in row.terms.values()])
        ends = np.cumsum([len(row.terms) for row in rows])
        return [
            (values[:, end - len(row.terms) : end], sizes[:, end - len(row.terms) : end])
            for row, end in zip(rows, ends, strict=True)
        ]

    def _tidied(
        self, row: Polynomial, values: np.ndarray, sizes: np.ndarray, size: float
    ) -> Polynomial:
        units = np.array([self._unit(monomial) for monomial in row.terms])
        largest = np.max(np.abs(values) * units, axis=1, initial=size, keepdims=True)
        vanishing = np.all(np.abs(values) <= ROUNDING * np.maximum(sizes, largest / units), axis=0)
        terms = {}
        for k, (monomial, coefficient) in enumerate(row.terms.items()):
            if not vanishing[k]:
                terms[monomial] = self._plain(coefficient, values[:, k], sizes[:, k])
        return Polynomial(terms)

    def _unit(self, monomial: Monomial) -> float:
        """What a monomial is where its lengths are as large as the system."""
        parts = (
            self.ring.generators[place][1] for place, e in enumerate(monomial) for _ in range(e)
        )
        return float(self.length ** sum(part == "value" for part in parts))

    def _plain(self, expression: ca.SX, column: np.ndarray, sizes: np.ndarray) -> ca.SX:
        """The number of an expression that is constant."""
        spread = float(np.ptp(column))
        constant = spread <= _SAME * float(np.max(np.abs(column)))
        return ca.SX(snap(float(column[0]), float(sizes[0]))) if constant else expression

    def is_parallel(self, first: Sequence[ca.SX], second: Sequence[ca.SX]) -> bool:
        """Whether two vectors of coefficients are parallel at all samples."""
        values, sizes = self._numbers_and_sizes([*first, *second])
        n = len(first)
        return _parallel(values[:, :n], sizes[:, :n], values[:, n:], sizes[:, n:])

    def agree(self, first: ca.SX, second: ca.SX) -> np.ndarray:
        """Samples at which two expressions differ by rounding only."""
        values, sizes = self._numbers_and_sizes([first, second])
        return np.abs(values[:, 0] - values[:, 1]) <= ROUNDING * np.sum(sizes, axis=1)

    def multiple(self, expression: ca.SX, of: ca.SX) -> float | None:
        """The constant by which an expression is a multiple of another, if it is one at all
        samples.
        """
        values = self.numbers([ca.SX(expression), ca.SX(of)])
        if np.any(values[:, 1] == 0.0):
            return None
        ratio = values[:, 0] / values[:, 1]
        return (
            snap(float(ratio[0]))
            if float(np.ptp(ratio)) <= _SAME * float(np.max(np.abs(ratio)))
            else None
        )

    def table(self) -> tuple[list[Monomial], np.ndarray]:
        """The monomials of the rows and their coefficients (samples, monomials, rows), lengths in
        units of `length`.
        """
        monomials = list(dict.fromkeys(m for row in self.rows for m in row.terms))
        table = np.zeros((len(self.samples), len(monomials), len(self.rows)))
        for k, (row, (values, _)) in enumerate(
            zip(self.rows, self._of_rows(self.rows), strict=True)
        ):
            places = [monomials.index(m) for m in row.terms]
            table[:, places, k] = values * [self._unit(m) for m in row.terms]
        return monomials, table

    def combined(self, factors: Sequence[float]) -> Polynomial:
        """The sum of all rows, each times a factor."""
        found = Polynomial({})
        for row, factor in zip(self.rows, factors, strict=True):
            found = found.plus(row, factor) if factor else found
        return self.tidied(found)

    # --- formulas ---------------------------------------------------------------------------------

    def define(self, expression: ca.SX, label: str) -> ca.SX:
        """A symbol for an expression, which later formulas read; constants stay numbers."""
        column, sizes = self._numbers_and_sizes([expression])
        plain = self._plain(expression, column[:, 0], sizes[:, 0])
        if plain.is_constant():
            return plain
        symbol = ca.SX.sym(label)
        self._add(symbol, column, sizes)
        self.definitions.append((symbol, expression))
        return symbol

    def _add(self, symbol: ca.SX, column: np.ndarray, sizes: np.ndarray) -> None:
        self.symbols.append(symbol)
        self.samples, self.sizes = np.hstack([self.samples, column]), np.hstack([self.sizes, sizes])

    def divisor(self, expression: ca.SX, label: str) -> ca.SX:
        """As `define`, of what a formula divides by."""
        symbol = self.define(expression, label)
        if not symbol.is_constant():
            self.divisors.append(symbol)
        return symbol

    def choose(self, name: str, discriminant: ca.SX, tells: ca.SX) -> ca.SX:
        """The root of a discriminant with its sign: a choice between two values."""
        under = self.define(discriminant, f"D_{name}")
        root, sign = ca.SX.sym(f"root_{name}"), ca.SX.sym(f"sign_{name}")
        self._both_signs(root, sign, under)
        self.choices.append(Choice(name, sign, root, under, tells))
        return sign * root

    def _both_signs(self, root: ca.SX, sign: ca.SX, under: ca.SX) -> None:
        """Each sample with both values of a choice: what holds for one of them need not hold for
        the other. Of samples without real values, which take part as if they had some, none where
        others are left.
        """
        real = self.numbers([under])[:, 0] > 0.0
        kept = real if np.sum(real) >= _FEWEST else np.ones_like(real)
        self.samples, self.sizes = (
            np.tile(part[kept], (2, 1)) for part in (self.samples, self.sizes)
        )
        self._add(root, *self._numbers_and_sizes([ca.sqrt(ca.fabs(under))]))
        both = np.repeat([1.0, -1.0], len(self.samples) // 2)[:, None]
        self._add(sign, both, np.abs(both))

    def solve(self, unknown: int, values: Sequence[ca.SX]) -> None:
        """Note the values of an unknown's generators, and put them into all rows."""
        for place, value in zip(self.ring.places[unknown], values, strict=True):
            number, part = self.ring.generators[place]
            self.values[place] = self.define(value, f"{self.name(number)}_{part}")
        self.active.discard(unknown)
        self.rows = [row for row in self.known_put_in(self.rows) if self.ring.held(row)]

    def known_put_in(self, rows: Sequence[Polynomial]) -> list[Polynomial]:
        """Rows with the values of what is solved."""
        return self.all_tidied([self._put_in(row) for row in rows])

    def _put_in(self, row: Polynomial) -> Polynomial:
        terms: dict[tuple[int, ...], ca.SX] = {}
        for monomial, coefficient in row.terms.items():
            left = list(monomial)
            for place, value in self.values.items():
                for _ in range(left[place]):
                    coefficient = coefficient * value
                left[place] = 0
            add_term(terms, tuple(left), coefficient)
        return Polynomial(terms)

    def without_repeats(self) -> None:
        """Leave out rows that are multiples of others: of parts of a turned one, put that together;
        else keep the later one where the first comes nearer to zero by half.
        """
        kept: list[Polynomial] = []
        alike: list[list[Polynomial]] = []
        rows = [row for row in self.rows if self.ring.held(row)]
        found = dict(zip(rows, self._of_rows(rows), strict=True))
        for row in rows:
            repeats = (_repeats(row, other, found[row], found[other]) for other in kept)
            place = next((i for i, repeated in enumerate(repeats) if repeated), None)
            if place is None:
                kept.append(row)
                alike.append([row])
                continue
            alike[place].append(row)
            whole = self._put_together([row, kept[place]])
            if whole is None and len(alike[place]) > 2:
                whole = self._put_together(alike[place])
            if whole is not None:
                kept[place] = whole
                found[whole] = self._of_rows([whole])[0]
            elif self._least(row) > 2.0 * self._least(kept[place]):
                kept[place] = row
        self.rows = kept

    def _put_together(self, parts: Sequence[Polynomial]) -> Polynomial | None:
        """Of rows a F, b F, ... with known factors, of which a^2 + b^2 + ... = c^2 is constant, and
        none of them nor any ratio, the row c F, which is there wherever F is; None where they are
        no such rows.
        """
        held = [m for m in parts[1].terms if m != self.ring.one]
        monomial = held[
            int(np.argmax(np.max(np.abs(self.numbers([parts[1].terms[m] for m in held])), axis=0)))
        ]
        factors = [part.terms[monomial] for part in parts]
        if any(f.is_constant() for f in factors) or any(
            self.multiple(a, b) is not None for a, b in combinations(factors, 2)
        ):
            return None
        (square,) = self.tidied(
            Polynomial({monomial: total(f * f for f in factors)})
        ).terms.values()
        if not square.is_constant():
            return None
        length = snap(float(np.sqrt(float(square))))
        whole = Polynomial({})
        for part, factor in zip(parts, factors, strict=True):
            whole = whole.plus(part, factor / length)
        return self.tidied(whole)

    def _least(self, row: Polynomial) -> float:
        """The smallest length of a row's coefficients among the samples."""
        return float(np.min(np.linalg.norm(self.numbers(list(row.terms.values())), axis=1)))


def _repeats(
    row: Polynomial,
    other: Polynomial,
    own: tuple[np.ndarray, np.ndarray],
    others: tuple[np.ndarray, np.ndarray],
) -> bool:
    """Whether a row is a multiple of another at all samples, by coefficients and sizes of each."""
    if row.terms.keys() != other.terms.keys():
        return False
    places = {monomial: k for k, monomial in enumerate(other.terms)}
    order = [places[monomial] for monomial in row.terms]
    return _parallel(*own, *(part[:, order] for part in others))


def _parallel(
    first: np.ndarray, first_sizes: np.ndarray, second: np.ndarray, second_sizes: np.ndarray
) -> bool:
    """Whether vectors (samples, n) are parallel at all samples, as far as the sizes of their terms
    tell: a_i b_l = a_l b_i for the place l at which the first is farthest from zero.
    """
    at = int(np.argmax(np.min(np.abs(first), axis=0)))
    a, a_size = first[:, at, None], first_sizes[:, at, None]
    b, b_size = second[:, at, None], second_sizes[:, at, None]
    sizes = (
        np.abs(first) * b_size
        + np.abs(b) * first_sizes
        + np.abs(a) * second_sizes
        + np.abs(second) * a_size
    )
    return bool(np.all(np.abs(first * b - a * second) <= ROUNDING * sizes))
