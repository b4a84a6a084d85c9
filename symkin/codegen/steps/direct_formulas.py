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
from symkin.codegen.steps.limbwise import DirectForm, Held, Reach, limbwise_form, whole_form
from symkin.codegen.steps.samples import Configuration
from symkin.computed_once import cached_property
from symkin.model.joint import Coordinate
from symkin.numeric.system import System
from symkin.position.problem import Problem
from symkin.spatial.backend import stacked

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
    """The formulas of a direct problem, their guards, and how large roots are at sampled
    configurations. `spans` are the ranges of the given values. The machine is `unit` times as large
    as that of the formulas: they read lengths over it and give them times it, so that what stands
    between does not grow with the size.
    """

    form: DirectForm
    spans: tuple[Span, ...]
    guards: tuple[Guard, ...]
    usual_roots: np.ndarray
    unit: float = 1.0

    def in_unit(self, unit: float) -> DirectFormulas:
        """Those of a machine that is `unit`, a power of two, times as large."""
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
        return replace(self, spans=spans, guards=guards, unit=unit)


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
    if any(c.is_advancing for c in problem.closure.coordinates):
        return None  # formulas give angles by cosine and sine
    given = np.array([sample.known for sample in samples])
    form = whole_form(problem, given[:_COMPARED]) if held is None else None
    form = form or limbwise_form(problem, limbs, samples, held)
    if form is None:
        return None
    spans = tuple(_span(c, problem.closure.characteristic_length) for c in joints)
    parts = (1.0,) if all(span.angular for span in spans) else SLIDE_PARTS
    first = _Guarding(form, spans, parts, given)
    form = replace(form, reaches=tuple(map(first.without_root, form.reaches)))
    guards = _Guarding(form, spans, parts, given).guards()
    if guards is None:
        return None
    squares = stacked(c.value for c in form.discriminants)
    values = form.at(squares, form.signs_at(samples[0].values), given)
    roots = np.sqrt(np.median(np.abs(values), axis=0))
    return DirectFormulas(form, spans, guards, roots)


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
    """How guards of formulas are found."""

    form: DirectForm
    spans: Sequence[Span]
    parts: Sequence[float]
    given: np.ndarray

    @cached_property
    def _line(self) -> Line:
        """The spans about their middles, in each part of the slides' ranges."""
        return Line(
            self.form.values,
            [
                [s if s.angular else replace(s, half=part * s.half) for s in self.spans]
                for part in self.parts
            ],
        )

    @cached_property
    def _squares(self) -> list[ca.SX]:
        """The discriminants."""
        return [self.form.of_values(c.value) for c in self.form.discriminants]

    def guards(self) -> tuple[Guard, ...] | None:
        """A guard for each discriminant of the pose, for each bound of a limb, and for each divisor
        that is no multiple of another; None where one has no bounds.
        """
        form, count = self.form, self.form.divisors.numel()
        divisors = form.of_values(form.divisors)
        if ca.depends_on(divisors, form.roots):
            return None
        above = [(c.name, v) for c, v in zip(form.discriminants, self._squares, strict=True)]
        above[form.pose_choices :] = [
            (f"reach of {reach.name}", self._reached(reach)) for reach in form.reaches
        ]
        # the least powers of divisors that make a value a polynomial P, or P + Q root
        sets = sorted(product(range(_POWERS), repeat=count), key=sum)
        asked = [
            (Guard(name, k, (), 1.0, "proved", ()), value, sets)
            for k, (name, value) in enumerate(above)
        ]
        for j, divisor in enumerate(divisors.elements()):
            if any(self._proportional(divisor, divisors[i]) for i in range(j)):
                continue
            sign = float(np.sign(np.median(self._at_samples(divisor))))
            made = Guard(f"divisor {j + 1}", None, (), sign, "proved", ())
            asked.append((made, ca.SX(1), [tuple(int(i == j) for i in range(count))]))
        guards, roots = (
            list[Guard](),
            dict(enumerate(zip(form.roots.elements(), self._squares, strict=True))),
        )
        for made, value, powers in asked:
            guard = self._line.proved(made, value, roots, guards, divisors, powers)
            if guard is None:
                return None
            guards.append(guard)
        return tuple(guards)

    def _reached(self, reach: Reach) -> ca.SX:
        """What has to stay above zero for a limb, in which roots that it holds by their squares
        alone are put in.
        """
        value = self.form.of_values(self.form.whole.written(reach.value))
        for j in reversed(range(self.form.pose_choices)):
            parts = self._by_root(value, j)
            if parts is not None and parts[1][1] <= NOISE * parts[0][1]:
                value = parts[0][0]
        return value

    def _by_root(self, value: ca.SX, j: int) -> list[tuple[ca.SX, float]] | None:
        """P and Q of a value P + Q r by a root, with the sizes of both terms; None where it holds
        none of it, or more of it.
        """
        root, square = self.form.roots[j], self._squares[j]
        parts = by_root(value, root, square) if ca.depends_on(value, root) else None
        if parts is None:
            return None
        sizes = self._size(parts[0]), self._size(parts[1]) * np.sqrt(self._size(square))
        return list(zip(parts, sizes, strict=True))

    def without_root(self, reach: Reach) -> Reach:
        """A condition Q r with the root r of the pose's first discriminant as Q alone, by the given
        values, with a sign that is above zero: r has a guard of its own.
        """
        value, count = self._reached(reach), self.form.pose_choices
        alone = count > 0 and not ca.depends_on(value, self.form.roots[1:count])
        parts = self._by_root(value, 0) if alone else None
        if parts is None or parts[0][1] > NOISE * parts[1][1]:
            return reach
        odd = parts[1][0]
        return Reach(reach.name, odd * float(np.sign(np.median(self._at_samples(odd)))))

    def _size(self, expression: ca.SX) -> float:
        """The largest value of an expression at the samples, roots as ones."""
        ones = ca.SX.ones(*self.form.roots.shape)
        plain = ca.substitute(expression, self.form.roots, ones)
        return float(np.max(np.abs(self._at_samples(plain))))

    def _proportional(self, first: ca.SX, second: ca.SX) -> bool:
        ratio = self._at_samples(first) / self._at_samples(second)
        return bool(np.ptp(ratio) <= NOISE * np.max(np.abs(ratio)))

    def _at_samples(self, expression: ca.SX) -> np.ndarray:
        return self._line.values(expression)(self.given)
