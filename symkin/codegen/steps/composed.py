"""Put the solutions of a problem's parts together: the numbers of every coordinate by those of the
known ones, and what must stay above zero.

A part's formulas read the numbers of the coordinates before it; its signs and roots stay symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca

from symkin.closure.angle_sums import AngleSum, turned
from symkin.closure.snapping import snapped_expression
from symkin.codegen.steps.formula_guards import free_divisors
from symkin.codegen.text.angles import Numbers, by_numbers, numbers_by_name, of_circle
from symkin.elimination.closed_form import ClosedForm
from symkin.model.joint import Coordinate
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
    """What must stay above 0: a discriminant with its root, or a divisor; `name` says of which
    coordinate, `part` of which part.
    """

    name: str
    value: ca.SX
    root: ca.SX | None
    part: Part


@dataclass
class Composed:
    """The `numbers` of coordinates, the known ones to begin with, and the conditions of the `parts`
    so far.
    """

    numbers: dict[str, list[Numbers]]
    parts: list[Part] = field(default_factory=list)
    conditions: list[Condition] = field(default_factory=list)

    @classmethod
    def of(cls, known: Sequence[Coordinate], symbols: ca.SX, parts: Sequence[Part]) -> Composed:
        """All parts by the numbers of known coordinates, which stand in `symbols` one after the
        other.
        """
        whole = cls(numbers_by_name(known, symbols))
        for part in parts:
            whole.add(part)
        return whole

    @property
    def forms(self) -> list[ClosedForm]:
        """The closed forms of the parts that have one."""
        return [part.form for part in self.parts if part.form is not None]

    @property
    def signs(self) -> ca.SX:
        """Symbols of all choices."""
        return stacked(form.signs for form in self.forms)

    @property
    def roots(self) -> ca.SX:
        return stacked(form.roots for form in self.forms)

    def written(
        self,
        expression: ca.SX,
        inputs: Sequence[tuple[ca.SX, Sequence[Coordinate]]],
        form: ClosedForm | None = None,
    ) -> ca.SX:
        """An expression of coordinates, each vector of symbols with them, over their numbers; the
        signs and roots of a form stay.
        """
        symbols = [(s, [n for c in own for n in self.numbers[c.name]]) for s, own in inputs]
        for s in (form.signs, form.roots) if form is not None else ():
            symbols.append((s, [Numbers(s[i]) for i in range(s.numel())]))
        return by_numbers(expression, symbols)

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
        known = [(form.system.known, part.problem.known_coordinates)]
        first, second, discriminants, divisors = (
            self.written(e, known, form)
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
        known = [(system.known, part.problem.known_coordinates)]
        slope = ca.jacobian(system.rows, system.unknown)
        at_zero = ca.substitute(system.rows, system.unknown, 0)
        value = self.written(ca.solve(slope, -at_zero), known)
        # at its zeros the unknowns are infinite
        determinant = self.written(ca.det(slope), known)
        determinant = snapped_expression(determinant, [stacked(ca.symvar(determinant))])
        if not determinant.is_constant():
            self.conditions.append(Condition(part.names, determinant, None, part))
        for k, c in enumerate(system.unknowns):
            circle = (ca.cos(value[k]), ca.sin(value[k])) if c.is_periodic else ()
            self.numbers[c.name] = [Numbers(value[k], *circle)]


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
