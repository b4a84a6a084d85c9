"""Find the formulas of a platform's direct problem, and what must stay above zero along a line for
them to follow the machine.

The closed form has a sign for each choice between two values, which a configuration tells.
Discriminants and divisors of it, made free of divisions, are the guards: while none of them reaches
zero, each point of the line has a real configuration with the same signs, which moves continuously
and is regular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import casadi as ca
import numpy as np

from symkin.codegen.line_bounds import Span
from symkin.codegen.steps.guards import NOISE, SLIDE_PARTS, Guard, Line, by_root
from symkin.codegen.steps.limbwise import (
    Held,
    LimbwiseForm,
    Reach,
    limbwise_form,
    of_twin,
)
from symkin.codegen.steps.samples import Configuration
from symkin.computed_once import cached_property
from symkin.elimination.closed_form import ClosedForm, closed_form
from symkin.model.joint import Coordinate, units_of
from symkin.numeric.system import System
from symkin.position.problem import Problem

_COMPARED = 4
"""Configurations at which the coefficients of rows are compared."""
_MOST_GIVEN = 4
"""Given values of which a guard may be a function: each more makes ten times the samples."""
_POWERS = 3
"""How often a divisor may multiply a discriminant, less one."""
_FREE_RANGE = 2.0
"""How far a slide without limits is looked at, in sizes about the reference."""


@dataclass(frozen=True, eq=False)
class DirectFormulas:
    """The closed form of a direct problem, the limbs' bounds among its conditions, its guards, and
    how large roots are at sampled configurations. `spans` are the ranges of the given values.
    """

    whole: LimbwiseForm
    spans: tuple[Span, ...]
    guards: tuple[Guard, ...]
    usual_roots: np.ndarray

    @property
    def formulas(self) -> ClosedForm:
        return self.whole.form

    def in_unit(self, unit: float, own: Problem, problem: Problem) -> DirectFormulas:
        """The formulas for the `problem` of a machine that is `unit`, a power of two, times as
        large as that of these formulas and their `own` problem: they read lengths over the unit
        and give them times it, so that what stands between does not grow with the size.
        """

        def read(expression: ca.SX) -> ca.SX:
            return of_twin(expression, own, problem, unit)

        form = self.formulas
        made = replace(
            form,
            system=problem.system,
            first=read(form.first) * ca.DM(units_of(problem.system.unknowns, unit)),
            second=read(form.second),
            discriminants=read(form.discriminants),
            divisors=read(form.divisors),
            told=read(form.told),
            samples=form.samples * [1.0 if span.angular else unit for span in self.spans],
        )
        reaches = tuple(
            Reach(reach.name, read(reach.of_configuration), read(reach.of_known))
            for reach in self.whole.reaches
        )
        spans = tuple(
            span
            if span.angular
            else Span(False, unit * span.middle, unit * span.half, unit * span.unit)
            for span in self.spans
        )
        squares = np.array([1.0 if span.angular else unit**2 for span in spans])
        guards = tuple(
            replace(guard, bounds=tuple(bound.over(squares) for bound in guard.bounds))
            for guard in self.guards
        )
        return replace(
            self, whole=replace(self.whole, form=made, reaches=reaches), spans=spans, guards=guards
        )


def direct_formulas(
    problem: Problem,
    limbs: Sequence[System],
    samples: Sequence[Configuration],
    held: Held | None = None,
) -> DirectFormulas | None:
    """The formulas of the direct problem with all its rows, all rows together or else limb by limb,
    which it is where limbs are to be watched holding the motion; None where none are found, or none
    that can be guarded.
    """
    joints = problem.known_coordinates
    if len(samples) < _COMPARED or len(joints) > _MOST_GIVEN or any(c.width != 1 for c in joints):
        return None
    given = np.array([sample.known for sample in samples])
    form = closed_form(problem.system, given[:_COMPARED]) if held is None else None
    whole = (
        limbwise_form(problem, limbs, samples, held)
        if form is None
        else LimbwiseForm(form, form.signs.numel(), ())
    )
    if whole is None:
        return None
    spans = tuple(_span(c, problem.closure.characteristic_length) for c in joints)
    parts = (1.0,) if all(span.angular for span in spans) else SLIDE_PARTS
    whole = replace(
        whole,
        reaches=tuple(
            _Guarding(whole, spans, parts, given).without_root(reach) for reach in whole.reaches
        ),
    )
    guards = _Guarding(whole, spans, parts, given).guards()
    if guards is None:
        return None
    signs = whole.form.signs_at(samples[0].unknown, given[0])
    usual = np.sqrt(np.median(np.abs(whole.form.discriminants_at(given, signs)), axis=0))
    return DirectFormulas(whole, spans, guards, usual)


def _span(coordinate: Coordinate, size: float) -> Span:
    """All angles; a slide's limits, or some sizes about the reference; its changes are told in
    sizes.
    """
    if coordinate.is_angular:
        return Span(True)
    if coordinate.limits is not None:
        low, high = coordinate.limits
        return Span(False, 0.5 * (low + high), 0.5 * (high - low), size)
    return Span(False, float(coordinate.reference[0]), _FREE_RANGE * size, size)


@dataclass(frozen=True, eq=False)
class _Guarding:
    """How guards of a closed form are found."""

    whole: LimbwiseForm
    spans: Sequence[Span]
    parts: Sequence[float]
    given: np.ndarray

    @property
    def found(self) -> ClosedForm:
        return self.whole.form

    @cached_property
    def _line(self) -> Line:
        """The spans about their middles, in each part of the slides' ranges."""
        return Line(
            self.found.system.known,
            [
                [s if s.angular else replace(s, half=part * s.half) for s in self.spans]
                for part in self.parts
            ],
        )

    def guards(self) -> tuple[Guard, ...] | None:
        """A guard for each discriminant of the pose, for each bound of a limb, and for each divisor
        that is no multiple of another; None where one has no bounds.
        """
        found, count = self.found, self.found.divisors.numel()
        discriminants = ca.substitute(
            found.discriminants, found.signs, ca.SX.ones(*found.signs.shape)
        )
        if ca.depends_on(found.divisors, found.roots):
            return None
        guards, choices = list[Guard](), self.whole.pose_choices
        above = [
            (Guard(name, k, None, (), 1.0, "proved", ()), discriminants[k])
            for k, name in enumerate(found.names[:choices])
        ]
        for j, reach in enumerate(self.whole.reaches):
            value = ca.substitute(reach.of_known, found.signs, ca.SX.ones(*found.signs.shape))
            made = Guard(f"reach of {reach.name}", None, j, (), 1.0, "proved", ())
            above.append((made, self._without_squares(value, discriminants[:choices])))
        # the least powers of divisors that make a value a polynomial P, or P + Q root
        sets = sorted(product(range(_POWERS), repeat=count), key=sum)
        roots = {j: (found.roots[j], discriminants[j]) for j in range(discriminants.numel())}
        for made, value in above:
            guard = self._line.proved(made, value, roots, guards, found.divisors, sets)
            if guard is None:
                return None
            guards.append(guard)
        kept: list[ca.SX] = []
        for j in range(count):
            divisor = found.divisors[j]
            if any(self._proportional(divisor, other) for other in kept):
                continue
            bounds = self._line.bounds([divisor])
            if bounds is None:
                return None
            powers = tuple(int(i == j) for i in range(count))
            kept.append(divisor)
            sign = float(np.sign(np.median(self._at_samples(divisor))))
            guards.append(Guard(f"divisor {j + 1}", None, None, powers, sign, "proved", bounds))
        return tuple(guards)

    def _without_squares(self, value: ca.SX, discriminants: ca.SX) -> ca.SX:
        """A value in which roots that it holds by their squares alone are put in."""
        for j in reversed(range(discriminants.numel())):
            root = self.found.roots[j]
            if ca.depends_on(value, root):
                parts = by_root(value, root, discriminants[j])
                if parts is None:
                    continue
                sizes = [self._size(part) for part in parts]
                value = (
                    parts[0]
                    if sizes[1] * np.sqrt(self._size(discriminants[j])) <= NOISE * sizes[0]
                    else value
                )
        return value

    def without_root(self, reach: Reach) -> Reach:
        """A condition Q r with the root r of the pose's first discriminant as Q alone, by the given
        values, with a sign that is above zero: r has a guard of its own.
        """
        ones, count = ca.SX.ones(*self.found.signs.shape), self.whole.pose_choices
        value, discriminants = (
            ca.substitute(e, self.found.signs, ones)
            for e in (reach.of_known, self.found.discriminants)
        )
        value = self._without_squares(value, discriminants[:count])
        roots = self.found.roots
        if not ca.depends_on(value, roots[0]) or (
            count > 1 and ca.depends_on(value, roots[1:count])
        ):
            return reach
        parts = by_root(value, roots[0], discriminants[0])
        if parts is None:
            return reach
        odd, sizes = parts[1], [self._size(part) for part in parts]
        if sizes[0] > NOISE * sizes[1] * np.sqrt(self._size(discriminants[0])):
            return reach
        odd = odd * float(np.sign(np.median(self._at_samples(odd))))
        return Reach(reach.name, odd, odd)

    def _size(self, expression: ca.SX) -> float:
        """The largest value of an expression at the samples, roots as ones."""
        ones = ca.SX.ones(*self.found.roots.shape)
        plain = ca.substitute(expression, self.found.roots, ones)
        return float(np.max(np.abs(self._at_samples(plain))))

    def _proportional(self, first: ca.SX, second: ca.SX) -> bool:
        ratio = self._at_samples(first) / self._at_samples(second)
        return bool(np.ptp(ratio) <= NOISE * np.max(np.abs(ratio)))

    def _at_samples(self, expression: ca.SX) -> np.ndarray:
        return self._line.values(expression)(self.given)
