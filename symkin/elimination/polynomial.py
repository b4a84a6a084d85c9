"""Polynomials in unknown coordinates, whose coefficients are CasADi expressions of the known
values.

The generators are the value of a length, and the cosine and the sine of an angle. Squares of sines
are written by cosines, so that equal polynomials have equal terms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from operator import add
from typing import Literal

import casadi as ca

from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate

Monomial = tuple[int, ...]
"""Exponents of the generators."""
Part = Literal["value", "cosine", "sine"]
_CANCELLED = 1e-13
"""Share of two constants below which their sum is rounding."""


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A sum of monomials with their coefficients."""

    terms: dict[Monomial, ca.SX]

    def __getitem__(self, monomial: Monomial) -> ca.SX:
        """The coefficient of a monomial, 0 where there is none."""
        return self.terms.get(monomial, ca.SX(0))

    def those(self, kept: Callable[[Monomial], bool]) -> Polynomial:
        """The terms whose monomials are kept."""
        return Polynomial({m: c for m, c in self.terms.items() if kept(m)})

    def plus(self, other: Polynomial, factor: float | ca.SX = 1.0) -> Polynomial:
        """This and `factor` times the other."""
        terms = dict(self.terms)
        for monomial, coefficient in other.terms.items():
            add_term(terms, monomial, times(factor, coefficient))
        return Polynomial(terms)

    def times(self, factor: float | ca.SX) -> Polynomial:
        return Polynomial(
            {monomial: times(factor, coefficient) for monomial, coefficient in self.terms.items()}
        )

    @property
    def degree(self) -> int:
        return max((sum(monomial) for monomial in self.terms), default=0)


@dataclass(frozen=True, eq=False)
class Ring:
    """The polynomials in some unknowns."""

    unknowns: tuple[Coordinate, ...]

    @cached_property
    def generators(self) -> tuple[tuple[int, Part], ...]:
        """The number of the unknown and its part, for each generator."""
        found: list[tuple[int, Part]] = []
        for number, coordinate in enumerate(self.unknowns):
            found += (
                [(number, "cosine"), (number, "sine")]
                if coordinate.is_angular
                else [(number, "value")]
            )
        return tuple(found)

    @cached_property
    def places(self) -> tuple[tuple[int, ...], ...]:
        """The generators of each unknown."""
        found: list[list[int]] = [[] for _ in self.unknowns]
        for place, (number, _) in enumerate(self.generators):
            found[number].append(place)
        return tuple(tuple(part) for part in found)

    @property
    def one(self) -> Monomial:
        return (0,) * len(self.generators)

    def power(self, *places: int) -> Monomial:
        """The product of some generators."""
        exponents = [0] * len(self.generators)
        for place in places:
            exponents[place] += 1
        return tuple(exponents)

    def constant(self, value: float | ca.SX) -> Polynomial:
        return Polynomial({self.one: ca.SX(value)})

    def generator(self, place: int) -> Polynomial:
        return Polynomial({self.power(place): ca.SX(1)})

    def product(self, first: Polynomial, second: Polynomial) -> Polynomial:
        terms: dict[Monomial, ca.SX] = {}
        for a, x in first.terms.items():
            for b, y in second.terms.items():
                monomial = tuple(map(add, a, b))
                add_term(terms, monomial, times(x, y))
        return self._reduced(terms)

    def _reduced(self, terms: dict[Monomial, ca.SX]) -> Polynomial:
        """Write sin^2 as 1 - cos^2."""
        for places in self.places:
            if len(places) == 1:
                continue
            cosine, sine = places
            while any(monomial[sine] >= 2 for monomial in terms):
                found: dict[Monomial, ca.SX] = {}
                for monomial, coefficient in terms.items():
                    if monomial[sine] < 2:
                        add_term(found, monomial, coefficient)
                        continue
                    for lower, sign in (
                        (_moved(monomial, {sine: -2}), 1.0),
                        (_moved(monomial, {sine: -2, cosine: 2}), -1.0),
                    ):
                        add_term(found, lower, times(sign, coefficient))
                terms = found
        return Polynomial(terms)

    # --- one unknown, or some of them, among the others -------------------------------------------

    def held(self, polynomial: Polynomial) -> set[int]:
        """The unknowns that a polynomial has."""
        return {unknown for monomial in polynomial.terms for unknown in self.held_by(monomial)}

    def held_by(self, monomial: Monomial) -> set[int]:
        """The unknowns that a monomial has."""
        return {self.generators[place][0] for place, e in enumerate(monomial) if e}

    def degree_in(self, polynomial: Polynomial, unknown: int) -> int:
        return max(
            (sum(m[place] for place in self.places[unknown]) for m in polynomial.terms), default=0
        )

    def split(self, polynomial: Polynomial, unknowns: Sequence[int]) -> dict[Monomial, Polynomial]:
        """The polynomial by monomials in some unknowns, whose coefficients are polynomials in the
        others.
        """
        own = {place for unknown in unknowns for place in self.places[unknown]}
        found: dict[Monomial, dict[Monomial, ca.SX]] = {}
        for monomial, coefficient in polynomial.terms.items():
            inner = tuple(e if place in own else 0 for place, e in enumerate(monomial))
            outer = tuple(0 if place in own else e for place, e in enumerate(monomial))
            found.setdefault(inner, {})[outer] = coefficient
        return {inner: Polynomial(terms) for inner, terms in found.items()}

    def free_of(self, polynomial: Polynomial, unknowns: Sequence[int]) -> Polynomial:
        """The terms without some unknowns."""
        return polynomial.those(lambda m: not self.held_by(m) & {*unknowns})

    def linear_in(self, polynomial: Polynomial, unknown: int) -> Iterator[Polynomial]:
        """The coefficients of an unknown's generators, and then what is free of it, of a polynomial
        that is linear in it.
        """
        parts = self.split(polynomial, [unknown])
        for monomial in (*(self.power(place) for place in self.places[unknown]), self.one):
            yield parts.get(monomial, Polynomial({}))

    def scalar(self, polynomial: Polynomial) -> ca.SX | None:
        """The value of a polynomial without unknowns, None for others."""
        if any(monomial != self.one for monomial in polynomial.terms):
            return None
        return polynomial[self.one]


def times(first: float | ca.SX, second: float | ca.SX) -> float | ca.SX:
    """A product of coefficients, of constants as numbers, which takes a fraction of the time; that
    of two floats is one.
    """
    if isinstance(first, float) and first == 1.0:
        return second
    a, b = _number(first), _number(second)
    if a is None or b is None:
        return (first if a is None else a) * second
    both = isinstance(first, float) and isinstance(second, float)
    return a * b if both else ca.SX(a * b)


def add_term(terms: dict[Monomial, ca.SX], monomial: Monomial, coefficient: float | ca.SX) -> None:
    """Add to a coefficient. Constants that cancel to rounding leave nothing, since a sum of
    constants forgets its terms.
    """
    before = terms.get(monomial)
    if before is None:
        terms[monomial] = coefficient
        return
    a, b = _number(before), _number(coefficient)
    if a is None or b is None:
        whole = before + coefficient
        terms[monomial] = ca.SX(0) if whole.is_zero() else whole
        return
    total = 0.0 if abs(a + b) <= _CANCELLED * (abs(a) + abs(b)) else a + b
    both = isinstance(before, float) and isinstance(coefficient, float)
    terms[monomial] = total if both else ca.SX(total)


def _number(value: float | ca.SX) -> float | None:
    """The number that a constant is, None for what is none."""
    if isinstance(value, float):
        return value
    return float(value) if value.is_constant() else None


def _moved(monomial: Monomial, changes: dict[int, int]) -> Monomial:
    return tuple(e + changes.get(place, 0) for place, e in enumerate(monomial))
