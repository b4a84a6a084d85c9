"""Put the solutions of a problem's parts together: the numbers of every coordinate by those of the
known ones, and what must stay above zero.

A part's formulas read the numbers of the coordinates before it; its signs and roots stay symbols.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.closure.angle_sums import AngleSum, turned
from symkin.closure.closure import Closure
from symkin.closure.snapping import snapped_expression
from symkin.codegen.steps.formula_guards import free_divisors
from symkin.codegen.text.angles import (
    Numbers,
    by_numbers,
    number_counts,
    numbers_by_name,
    of_circle,
)
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import ClosedForm
from symkin.model.joint import places_of
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.groups import implied_parts, structure_groups
from symkin.position.problem import Problem
from symkin.spatial.backend import stacked


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a problem: `form` where it has a closed form, `total` where it couples an angle to
    others, `is_linear` where its rows are linear; none of them where only Newton's method solves
    it.
    """

    problem: Problem
    form: ClosedForm | None = None
    total: AngleSum | None = None
    is_linear: bool = False

    @property
    def is_closed(self) -> bool:
        return self.form is not None or self.total is not None or self.is_linear

    @property
    def names(self) -> str:
        """The names of its unknowns."""
        return ", ".join(c.name for c in self.problem.system.unknowns)


@dataclass(frozen=True, eq=False)
class Condition:
    """What must stay above 0: a discriminant with its root, which has the choice's sign, or a
    divisor; `name` says of which coordinate, `part` of which part.
    """

    name: str
    value: ca.SX
    root: ca.SX | None
    part: Part


@dataclass
class Composed:
    """The `numbers` of a closure's coordinates, the known ones to begin with, and the conditions of
    the `parts` so far.
    """

    closure: Closure
    numbers: dict[str, list[Numbers]]
    parts: list[Part] = field(default_factory=list)
    conditions: list[Condition] = field(default_factory=list)

    @property
    def forms(self) -> list[ClosedForm]:
        """The closed forms of the parts that have one."""
        return [part.form for part in self.parts if part.form is not None]

    def written(self, expression: ca.SX, form: ClosedForm | None = None) -> ca.SX:
        """An expression of the closure's variables over the numbers of coordinates; the roots of a
        form stay, with their signs.
        """
        own = [c for c in self.closure.coordinates if c.name in self.numbers]
        symbols = [(self.closure.symbols(own), [n for c in own for n in self.numbers[c.name]])]
        if form is not None:
            count = form.roots.numel()
            symbols.append((form.signs, [Numbers(ca.SX(1))] * count))
            symbols.append((form.roots, [Numbers(form.roots[i]) for i in range(count)]))
        return by_numbers(expression, symbols, 1.0)

    def add(self, part: Part) -> None:
        """Add the numbers of a part's unknowns and its conditions."""
        if part.form is not None:
            self._add_form(part, part.form)
        elif part.total is not None:
            read = [n for c in part.problem.known_coordinates for n in self.numbers[c.name]]
            self.numbers[part.names] = [_coupled(part.total, read)]
        else:
            self._add_linear(part)
        self.parts.append(part)

    def _add_form(self, part: Part, form: ClosedForm) -> None:
        first, second, discriminants, divisors = (
            self.written(e, form)
            for e in (form.first, form.second, form.discriminants, form.divisors)
        )
        for k, name in enumerate(form.names):
            self.conditions.append(Condition(name, discriminants[k], form.roots[k], part))
        for k in free_divisors(form):
            self.conditions.append(Condition(part.names, divisors[k], None, part))
        for k, c in enumerate(form.system.unknowns):
            self.numbers[c.name] = [
                of_circle(first[k], second[k]) if c.is_periodic else Numbers(first[k])
            ]

    def _add_linear(self, part: Part) -> None:
        system = part.problem.system
        slope = ca.jacobian(system.rows, system.unknown)
        at_zero = ca.substitute(system.rows, system.unknown, 0)
        value = self.written(ca.solve(slope, -at_zero))
        # at its zeros the unknowns are infinite
        determinant = snapped(self.written(ca.det(slope)))
        if not determinant.is_constant():
            self.conditions.append(Condition(part.names, determinant, None, part))
        for k, c in enumerate(system.unknowns):
            circle = (ca.cos(value[k]), ca.sin(value[k])) if c.is_periodic else ()
            self.numbers[c.name] = [Numbers(value[k], *circle)]


@dataclass(frozen=True, eq=False)
class Formulas:
    """The formulas of a `problem`, put together as one `whole` by the `known` numbers, which stand
    one after the other: of angles cosine and sine.
    """

    problem: Problem
    known: ca.SX
    whole: Composed

    @classmethod
    def of(cls, problem: Problem, parts: Sequence[Part] = ()) -> Formulas:
        """Those of all `parts`, in the order of their solution."""
        given = problem.known_coordinates
        known = ca.SX.sym("k", sum(number_counts(given)))
        whole = Composed(problem.closure, numbers_by_name(given, known))
        for part in parts:
            whole.add(part)
        return cls(problem, known, whole)

    @property
    def discriminants(self) -> list[Condition]:
        """What stands under the roots."""
        return [c for c in self.whole.conditions if c.root is not None]

    @cached_property
    def roots(self) -> ca.SX:
        """Symbols of the roots with their signs."""
        return stacked(form.roots for form in self.whole.forms)

    @property
    def turns(self) -> list[tuple[ca.SX, ca.SX]]:
        """The known numbers that are cosine and sine of one angle."""
        given = self.problem.known_coordinates
        places = places_of(given, number_counts(given)).values()
        return [(self.known[p[0]], self.known[p[1]]) for p in places if len(p) == 2]

    @cached_property
    def values(self) -> ca.SX:
        """Symbols of the known values, angles as they are."""
        return self.problem.closure.symbols(self.problem.known_coordinates)

    def signs_at(self, values: np.ndarray) -> np.ndarray:
        """The signs (choices,) of a configuration, all variables of the closure."""
        found = [np.zeros(0)]
        for part in self.whole.parts:
            if part.form is not None:
                unknown, known = part.form.system.unknowns, part.problem.known_coordinates
                at = (part.problem.select_values(values, c) for c in (unknown, known))
                found.append(part.form.signs_at(*at))
        return np.concatenate(found)

    def of_values(self, expression: ca.SX, values: ca.SX | None = None) -> ca.SX:
        """An expression of the known numbers by the known `values`; roots stay."""
        values, numbers = self.values if values is None else values, list[ca.SX]()
        for k, c in enumerate(self.problem.known_coordinates):
            numbers += [ca.cos(values[k]), ca.sin(values[k])] if c.is_periodic else [values[k]]
        return ca.substitute(expression, self.known, stacked(numbers))

    def with_roots(
        self,
        expression: ca.SX,
        signs: ca.SX | np.ndarray,
        root: Callable[[ca.SX], ca.SX] = lambda d: ca.sqrt(ca.fmax(d, 0)),
    ) -> ca.SX:
        """An expression of the known numbers with roots put in: 0 where there are none."""
        for k, one in reversed(list(enumerate(self.discriminants))):
            expression = ca.substitute(expression, one.root, signs[k] * root(one.value))
        return expression

    def put_in(self, expression: ca.SX, signs: np.ndarray) -> ca.SX:
        """The same by the known values."""
        return self.of_values(self.with_roots(expression, signs))

    def at(self, expression: ca.SX, signs: np.ndarray, known: np.ndarray) -> np.ndarray:
        """The numbers (n, entries) of an expression at known values (n, known)."""
        function = ca.Function("f", [self.values], [self.put_in(expression, signs)])
        return np.asarray(function.map(len(known))(known.T)).T

    def closes(self, values: np.ndarray) -> bool:
        """Whether the formulas satisfy the problem's rows at configurations (n, variables) of the
        same signs.
        """
        system, known = self.problem.system, values[:, self.problem.known_places]
        found = stacked(self.whole.numbers[c.name][0].value for c in system.unknowns)
        residuals = system.residuals(self.at(found, self.signs_at(values[0]), known), known)
        return bool(np.all(residuals <= CLOSURE_TOLERANCE * system.characteristic_length))


def snapped(expression: ca.SX) -> ca.SX:
    """An expression of numbers without the rounding of its constants."""
    return snapped_expression(expression, [stacked(ca.symvar(expression))])


def parts_of(problem: Problem) -> tuple[Problem, ...]:
    """The parts of a problem in the order of their solution, those that implied rows make
    included.
    """
    return tuple(
        part for group in structure_groups(problem) for part in implied_parts(group) or (group,)
    )


def _coupled(total: AngleSum, read: Sequence[Numbers]) -> Numbers:
    """The angle that a sum of angles gives, which vanishes."""
    own = total.factors[0, 0]
    factors = {place: -factor / own for place, factor in total.factors.items() if place != (0, 0)}
    shift = -total.offset / own
    value = sum((factor * read[k].value for (_, k), factor in factors.items()), shift)
    circle = ca.cos(shift), ca.sin(shift)
    for (_, k), factor in factors.items():
        if read[k].cosine is None or factor != round(factor):
            return Numbers(value, ca.cos(value), ca.sin(value))
        circle = turned(circle, read[k].circle(), factor)
    return Numbers(value, *circle)
