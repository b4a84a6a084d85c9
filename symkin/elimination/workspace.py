"""What is left to solve: rows, unknowns, and the formulas so far.

Coefficients are compared at random known values: an expression that vanishes at all of them is zero, and one that is the same at all
of them is constant, with probability one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.closure.snapping import snap
from symkin.elimination.polynomial import Polynomial, Ring

_ZERO = 1e-10
"""Share of the largest coefficient of a row below which one is rounding."""
_SAME = 1e-12
"""Relative spread over the samples within which a coefficient is a constant."""
_PARALLEL = 1e-10
"""Sine of the angle between vectors of coefficients below which they are parallel."""


class Choice(NamedTuple):
    """A formula with two values: symbols of its `sign`, +1 or -1, and of its `root`, the square root of the `discriminant`, below zero
    where no value is real; `tells` is an expression of a solution's generators (`Workspace.own`) that equals sign times root."""

    name: str
    sign: ca.SX
    root: ca.SX
    discriminant: ca.SX
    tells: ca.SX


class Deferred(NamedTuple):
    """Unknowns that have been taken out of the other rows: `rows` give them once the rest is known."""

    unknowns: tuple[int, ...]
    rows: tuple[Polynomial, ...]


@dataclass
class Workspace:
    """Rows in some unknowns, and what has been found of them.

    `symbols` are the known values and what has been defined from them, with `samples` of both; `definitions` in their order;
    `values` are the symbols of solved generators; `divisors` are what formulas divide by; `own` stand for a solution's generators.
    """

    ring: Ring
    rows: list[Polynomial]
    active: set[int]
    symbols: list[ca.SX]
    samples: np.ndarray
    definitions: list[tuple[ca.SX, ca.SX]] = field(default_factory=list)
    values: dict[int, ca.SX] = field(default_factory=dict)
    choices: list[Choice] = field(default_factory=list)
    divisors: list[ca.SX] = field(default_factory=list)
    deferred: list[Deferred] = field(default_factory=list)
    steps: list[str] = field(default_factory=list)
    own: list[ca.SX] = field(init=False)

    def __post_init__(self) -> None:
        self.own = [ca.SX.sym(f"{part}_{self.name(number)}") for number, part in self.ring.generators]

    def name(self, unknown: int) -> str:
        return self.ring.unknowns[unknown].name

    def names(self, unknowns: Iterable[int]) -> str:
        return ", ".join(self.name(k) for k in unknowns)

    # --- numbers -----------------------------------------------------------------------------------------------------

    def numbers(self, expressions: Sequence[ca.SX]) -> np.ndarray:
        """Expressions (samples, expressions) at the sampled values."""
        if not expressions:
            return np.zeros((len(self.samples), 0))
        function = ca.Function("numbers", [ca.vertcat(*self.symbols)], [ca.vertcat(*expressions)])
        return np.array([np.asarray(function(sample)).ravel() for sample in self.samples])

    def tidied(self, row: Polynomial) -> Polynomial:
        """The same row without coefficients that are zero, and with numbers for those that are constant."""
        values = self.numbers(list(row.terms.values()))
        largest = np.max(np.abs(values), axis=1, initial=0.0)
        terms = {}
        for (monomial, coefficient), column in zip(row.terms.items(), values.T, strict=True):
            if not np.all(np.abs(column) <= _ZERO * largest):
                terms[monomial] = self._plain(coefficient, column)
        return Polynomial(terms)

    def _plain(self, expression: ca.SX, column: np.ndarray) -> ca.SX:
        """The number of an expression that is constant."""
        spread = float(np.ptp(column))
        return ca.SX(snap(float(column[0]))) if spread <= _SAME * float(np.max(np.abs(column))) else expression

    def is_parallel(self, first: Sequence[ca.SX], second: Sequence[ca.SX]) -> bool:
        """Whether two vectors of coefficients are parallel at all samples."""
        a, b = self.numbers(first), self.numbers(second)
        lengths = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
        across = np.linalg.norm(a * np.sum(a * b, axis=1, keepdims=True) - b * np.sum(a * a, axis=1, keepdims=True), axis=1)
        return bool(np.all(across <= _PARALLEL * lengths * np.linalg.norm(a, axis=1)))

    def vanishes(self, expression: ca.SX, beside: ca.SX) -> bool:
        """Whether an expression is zero to rounding of another at all samples."""
        found = np.abs(self.numbers([expression, beside]))
        return bool(np.all(found[:, 0] <= _ZERO * found[:, 1]))

    def multiple(self, expression: ca.SX, of: ca.SX) -> float | None:
        """The constant by which an expression is a multiple of another, if it is one at all samples."""
        values = self.numbers([ca.SX(expression), ca.SX(of)])
        if np.any(values[:, 1] == 0.0):
            return None
        ratio = values[:, 0] / values[:, 1]
        return snap(float(ratio[0])) if float(np.ptp(ratio)) <= _SAME * float(np.max(np.abs(ratio))) else None

    # --- formulas ----------------------------------------------------------------------------------------------------

    def define(self, expression: ca.SX, label: str) -> ca.SX:
        """A symbol for an expression, which later formulas read; constants stay numbers."""
        column = self.numbers([expression])
        plain = self._plain(expression, column[:, 0])
        return plain if plain.is_constant() else self._symbol(expression, label, column)

    def _symbol(self, expression: ca.SX, label: str, column: np.ndarray) -> ca.SX:
        symbol = ca.SX.sym(label)
        self.symbols.append(symbol)
        self.samples = np.hstack([self.samples, column])
        self.definitions.append((symbol, expression))
        return symbol

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
        # a sample without real values takes part as if it had some
        numbers = np.sqrt(np.abs(self.numbers([under])))
        self.symbols += [root, sign]
        self.samples = np.hstack([self.samples, numbers, np.ones_like(numbers)])
        self.choices.append(Choice(name, sign, root, under, tells))
        return sign * root

    def solve(self, unknown: int, values: Sequence[ca.SX]) -> None:
        """Note the values of an unknown's generators, and put them into all rows."""
        for place, value in zip(self.ring.places[unknown], values, strict=True):
            number, part = self.ring.generators[place]
            self.values[place] = self.define(value, f"{self.name(number)}_{part}")
        self.active.discard(unknown)
        self.rows = [row for row in map(self.known_put_in, self.rows) if self.ring.held(row)]

    def known_put_in(self, row: Polynomial) -> Polynomial:
        """A row with the values of what is solved."""
        terms: dict[tuple[int, ...], ca.SX] = {}
        for monomial, coefficient in row.terms.items():
            left = list(monomial)
            for place, value in self.values.items():
                for _ in range(left[place]):
                    coefficient = coefficient * value
                left[place] = 0
            key = tuple(left)
            terms[key] = terms[key] + coefficient if key in terms else coefficient
        return self.tidied(Polynomial(terms))

    def without_repeats(self) -> None:
        """Leave out rows that are multiples of others: of two parts of a turned one, put that together; else keep the later one where the
        first comes nearer to zero by half."""
        kept: list[Polynomial] = []
        for row in self.rows:
            if not self.ring.held(row):
                continue
            alike = next((i for i, other in enumerate(kept) if self._repeats(row, other)), None)
            if alike is None:
                kept.append(row)
            elif (whole := self._put_together(row, kept[alike])) is not None:
                kept[alike] = whole
            elif self._least(row) > 2.0 * self._least(kept[alike]):
                kept[alike] = row
        self.rows = kept

    def _repeats(self, row: Polynomial, other: Polynomial) -> bool:
        """Whether a row is a multiple of another at all samples."""
        monomials = sorted(row.terms)
        return sorted(other.terms) == monomials and self.is_parallel(
            [row.terms[m] for m in monomials], [other.terms[m] for m in monomials]
        )

    def _put_together(self, row: Polynomial, other: Polynomial) -> Polynomial | None:
        """Of rows a F and b F with known a and b, of which a^2 + b^2 = c^2 is constant, and neither a nor b, the row c F, which is there
        wherever F is; None where they are no such rows."""
        held = [m for m in other.terms if m != self.ring.one]
        monomial = held[int(np.argmax(np.max(np.abs(self.numbers([other.terms[m] for m in held])), axis=0)))]
        a, b = row.terms[monomial], other.terms[monomial]
        if a.is_constant() or b.is_constant() or self.multiple(a, b) is not None:
            return None
        (square,) = self.tidied(Polynomial({monomial: a * a + b * b})).terms.values()
        if not square.is_constant():
            return None
        length = snap(float(np.sqrt(float(square))))
        return self.tidied(row.times(a / length).plus(other, b / length))

    def _least(self, row: Polynomial) -> float:
        """The smallest length of a row's coefficients among the samples."""
        return float(np.min(np.linalg.norm(self.numbers(list(row.terms.values())), axis=1)))
