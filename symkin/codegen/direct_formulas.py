"""Find the formulas of a platform's direct problem, and what must stay above zero along a line for
them to follow the machine.

The closed form has a sign for each choice between two values, which a configuration tells.
Discriminants and divisors of it, made free of divisions, are the guards: while none of them reaches
zero, each point of the line has a real configuration with the same signs, which moves continuously
and is regular.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import factorial, prod

import casadi as ca
import numpy as np

from symkin.codegen.limbwise import (
    Held,
    LimbwiseForm,
    Reach,
    limbwise_form,
    of_twin,
)
from symkin.codegen.line_bounds import Bend, Span, bend_of
from symkin.codegen.samples import Configuration
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
_NOISE = 1e-9
"""Share of the largest weight below which another is rounding."""
_PARTS = (1.0 / 16, 1.0 / 4, 1.0)
"""Parts of a slide's range for which bounds are made: a line takes those of the first that holds
it.
"""
_ROOT_DEGREE = 4
"""Highest degree in a root that is looked for, less one."""
_FREE_RANGE = 2.0
"""How far a slide without limits is looked at, in sizes about the reference."""


@dataclass(frozen=True)
class Weights:
    """Bounds K of half a guard's second derivative along a line by the squares of the given values'
    changes: `plain`, and, of a guard that holds the root of another's value m, what is multiplied
    by m^(-1/2) and m^(-3/2).
    """

    plain: np.ndarray
    by_root: np.ndarray
    by_cube: np.ndarray

    def over(self, squares: np.ndarray) -> Weights:
        """The bounds by changes whose squares are these times as large."""
        return Weights(self.plain / squares, self.by_root / squares, self.by_cube / squares)


@dataclass(frozen=True)
class Guard:
    """A function of the given values that has to stay above zero: discriminant `choice`, or `reach`
    of a limb (both None: a divisor), times divisors to some `powers`, times `sign`. `sizes` bound
    it; they and `weights` are one for each part of the slides' ranges; `root` is the guard whose
    root it holds (None: it is a polynomial).
    """

    name: str
    choice: int | None
    reach: int | None
    powers: tuple[int, ...]
    sign: float
    root: int | None
    sizes: tuple[float, ...]
    weights: tuple[Weights, ...]

    @property
    def is_divisor(self) -> bool:
        """Whether the formulas divide by it."""
        return self.choice is None and self.reach is None

    def of(self, discriminants: ca.SX, reaches: ca.SX, divisors: ca.SX) -> ca.SX:
        """Its expression, by those of discriminants, reaches and divisors."""
        whole = _times(divisors, self.powers) * self.sign
        if self.reach is not None:
            return whole * reaches[self.reach]
        return whole if self.choice is None else whole * discriminants[self.choice]


def _times(divisors: ca.SX, powers: Sequence[int]) -> ca.SX:
    return prod((divisors[j] ** e for j, e in enumerate(powers)), start=ca.SX(1))


@dataclass(frozen=True, eq=False)
class DirectFormulas:
    """The closed form of a direct problem, the limbs' bounds among its conditions, its guards, and
    how large roots are at sampled configurations. `parts` are the parts of the slides' ranges
    `spans` for which guards have weights.
    """

    whole: LimbwiseForm
    spans: tuple[Span, ...]
    parts: tuple[float, ...]
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
            replace(guard, weights=tuple(weights.over(squares) for weights in guard.weights))
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
        else LimbwiseForm(form, int(form.signs.shape[0]), ())
    )
    if whole is None:
        return None
    spans = tuple(_span(c, problem.closure.characteristic_length) for c in joints)
    parts = (1.0,) if all(span.angular for span in spans) else _PARTS
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
    return DirectFormulas(whole, spans, parts, guards, usual)


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

    def guards(self) -> tuple[Guard, ...] | None:
        """A guard for each discriminant of the pose, for each bound of a limb, and for each divisor
        that is no multiple of another; None where one has no bounds.
        """
        found, roots = self.found, self.found.roots
        divisors = [found.divisors[j] for j in range(int(found.divisors.shape[0]))]
        discriminants = ca.substitute(
            found.discriminants, found.signs, ca.SX.ones(*found.signs.shape)
        )
        if ca.depends_on(found.divisors, roots):
            return None
        guards: list[Guard] = []
        for name, place, value in self._values_above_zero(discriminants):
            guard = self._condition(name, place, value, discriminants, guards)
            if guard is None:
                return None
            guards.append(guard)
        kept: list[ca.SX] = []
        for j, divisor in enumerate(divisors):
            if any(self._proportional(divisor, other) for other in kept):
                continue
            bends = self._bends(divisor)
            if bends is None:
                return None
            powers = tuple(int(i == j) for i in range(len(divisors)))
            kept.append(divisor)
            sign = float(np.sign(np.median(self._values(divisor)(self.given))))
            guards.append(
                Guard(
                    f"divisor {j + 1}",
                    None,
                    None,
                    powers,
                    sign,
                    None,
                    tuple(bend.size for bend in bends),
                    self._in_units(map(_plain, bends)),
                )
            )
        return tuple(guards)

    def _values_above_zero(
        self, discriminants: ca.SX
    ) -> list[tuple[str, tuple[int | None, int | None], ca.SX]]:
        """Name, (choice, reach) and value of the pose's discriminants and of the limbs' bounds."""
        found, count = self.found, self.whole.pose_choices
        values: list[tuple[str, tuple[int | None, int | None], ca.SX]] = []
        values += [(found.names[k], (k, None), discriminants[k]) for k in range(count)]
        for j, reach in enumerate(self.whole.reaches):
            value = ca.substitute(reach.of_known, found.signs, ca.SX.ones(*found.signs.shape))
            values.append(
                (
                    f"reach of {reach.name}",
                    (None, j),
                    self._without_squares(value, discriminants[:count]),
                )
            )
        return values

    def _condition(
        self,
        name: str,
        place: tuple[int | None, int | None],
        value: ca.SX,
        discriminants: ca.SX,
        before: Sequence[Guard],
    ) -> Guard | None:
        """The guard of a discriminant or a limb's bound, (choice, reach), by the least powers of
        divisors that make its value a polynomial P, or P + Q root.
        """
        roots, count = self.found.roots, int(self.found.divisors.shape[0])
        read = [j for j in range(int(roots.shape[0])) if ca.depends_on(value, roots[j])]
        if len(read) > 1 or any(any(before[j].powers) or before[j].root is not None for j in read):
            return None
        root = read[0] if read else None
        parts = [value] if root is None else _by_root(value, roots[root], discriminants[root])
        for powers in sorted(product(range(_POWERS), repeat=count), key=sum):
            factor = _times(self.found.divisors, powers)
            bends = [self._bends(part * factor) for part in parts]
            if any(bend is None for bend in bends):
                continue
            plain = [bend for bend in bends if bend is not None]
            if root is None:
                return Guard(
                    name,
                    *place,
                    powers,
                    1.0,
                    None,
                    tuple(bend.size for bend in plain[0]),
                    self._in_units(map(_plain, plain[0])),
                )
            inner = self._bends(discriminants[root])
            if inner is None:
                continue
            by_part = list(zip(plain[0], plain[1], inner, strict=True))
            weights = self._in_units(_with_root(p, q, d) for p, q, d in by_part)
            sizes = tuple(p.size + q.size * float(np.sqrt(d.size)) for p, q, d in by_part)
            return Guard(name, *place, powers, 1.0, root, sizes, weights)
        return None

    def _without_squares(self, value: ca.SX, discriminants: ca.SX) -> ca.SX:
        """A value in which roots that it holds by their squares alone are put in."""
        for j in reversed(range(int(discriminants.shape[0]))):
            root = self.found.roots[j]
            if ca.depends_on(value, root):
                even, odd = _by_root(value, root, discriminants[j])
                ones = ca.SX.ones(*self.found.roots.shape)
                by_one = [ca.substitute(part, self.found.roots, ones) for part in (even, odd)]
                sizes = [float(np.max(np.abs(self._values(part)(self.given)))) for part in by_one]
                value = (
                    even
                    if sizes[1] * float(np.sqrt(self._size(discriminants[j]))) <= _NOISE * sizes[0]
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
        even, odd = _by_root(value, roots[0], discriminants[0])
        sizes = [np.max(np.abs(self._values(part)(self.given))) for part in (even, odd)]
        if sizes[0] > _NOISE * sizes[1] * float(np.sqrt(self._size(discriminants[0]))):
            return reach
        odd = odd * float(np.sign(np.median(self._values(odd)(self.given))))
        return Reach(reach.name, odd, odd)

    def _size(self, discriminant: ca.SX) -> float:
        """The largest value of a discriminant at the samples, roots of others as ones."""
        ones = ca.SX.ones(*self.found.roots.shape)
        return float(
            np.max(
                np.abs(
                    self._values(ca.substitute(discriminant, self.found.roots, ones))(self.given)
                )
            )
        )

    def _in_units(self, weights: Iterable[Weights]) -> tuple[Weights, ...]:
        """Weights of changes as the given values are told, of those of changes in the spans'
        units.
        """
        squares = np.array([span.unit**2 for span in self.spans])
        return tuple(w.over(squares) for w in weights)

    def _bends(self, expression: ca.SX) -> list[Bend] | None:
        """Bounds of an expression over each part of the slides' ranges; None where it is no
        polynomial.
        """
        values, found = self._values(expression), list[Bend]()
        for part in reversed(self.parts):
            spans = [
                span if span.angular else replace(span, half=part * span.half)
                for span in self.spans
            ]
            bend = bend_of(values, spans)
            if bend is None:
                return None
            found.append(bend)
        return found[::-1]

    def _proportional(self, first: ca.SX, second: ca.SX) -> bool:
        ratio = self._values(first)(self.given) / self._values(second)(self.given)
        return bool(np.ptp(ratio) <= _NOISE * np.max(np.abs(ratio)))

    def _values(self, expression: ca.SX) -> Callable[[np.ndarray], np.ndarray]:
        function = ca.Function("guard", [self.found.system.known], [expression], {"cse": True})

        def values(given: np.ndarray) -> np.ndarray:
            return np.asarray(function.map(len(given))(given.T)).ravel()

        return values


def _by_root(expression: ca.SX, root: ca.SX, discriminant: ca.SX) -> list[ca.SX]:
    """P and Q of an expression P + Q root that is a polynomial in a discriminant's root. Raises
    ValueError where its degree is too high.
    """
    parts, derivative, zero = [ca.SX(0), ca.SX(0)], expression, ca.SX(0)
    for k in range(_ROOT_DEGREE + 1):
        at_zero = ca.substitute(derivative, root, zero) / factorial(k)
        parts[k % 2] = parts[k % 2] + at_zero * discriminant ** (k // 2)
        derivative = ca.jacobian(derivative, root)
        if not ca.depends_on(derivative, root):
            k += 1
            parts[k % 2] = parts[k % 2] + derivative / factorial(k) * discriminant ** (k // 2)
            return parts
    raise ValueError(f"a polynomial of a degree above {_ROOT_DEGREE + 1} in a root")


def _plain(bend: Bend) -> Weights:
    zero = np.zeros(len(bend.weights))
    return Weights(0.5 * _cleaned(bend.weights), zero, zero)


def _with_root(p: Bend, q: Bend, d: Bend) -> Weights:
    """Bounds of P + Q r, r^2 = D and D at least m: P'' + Q'' r + 2 Q' r' + Q r'' with r' = D' / (2
    r), r'' = D'' / (2 r) - D'^2 / (4 r^3).
    """
    both = 0.5 * (q.slopes * np.sum(d.slopes) + d.slopes * np.sum(q.slopes))
    return Weights(
        plain=0.5 * _cleaned(p.weights + np.sqrt(d.size) * q.weights),
        by_root=0.5 * _cleaned(both + 0.5 * q.size * d.weights),
        by_cube=0.5 * _cleaned(0.25 * q.size * d.slopes * np.sum(d.slopes)),
    )


def _cleaned(weights: np.ndarray) -> np.ndarray:
    return np.where(weights > _NOISE * np.max(weights, initial=0.0), weights, 0.0)
