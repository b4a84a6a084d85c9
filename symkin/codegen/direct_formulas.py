"""Find the formulas of a platform's direct problem, and what must stay above zero along a line for them to follow the machine.

The closed form has a sign for each choice between two values, which a configuration tells. Discriminants and divisors of it, made free
of divisions, are the guards: while none of them reaches zero, each point of the line has a real configuration with the same signs, which
moves continuously and is regular.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

import casadi as ca
import numpy as np

from symkin.codegen.line_bounds import Bend, Span, bend_of
from symkin.codegen.samples import Configuration
from symkin.elimination.closed_form import ClosedForm, closed_form
from symkin.model.joint import Coordinate
from symkin.position.problem import Problem

_COMPARED = 4
"""Configurations at which the coefficients of rows are compared."""
_MOST_GIVEN = 4
"""Given values of which a guard may be a function: each more makes ten times the samples."""
_POWERS = 3
"""How often a divisor may multiply a discriminant, less one."""
_NOISE = 1e-9
"""Share of the largest weight below which another is rounding."""


@dataclass(frozen=True)
class Guard:
    """A function of the given values that has to stay above zero: discriminant `choice` (None: no discriminant) times divisors to some
    `powers`, times `sign`."""

    name: str
    choice: int | None
    powers: tuple[int, ...]
    sign: float
    bend: Bend

    def of(self, discriminants: ca.SX, divisors: ca.SX) -> ca.SX:
        """Its expression, by those of discriminants and divisors."""
        whole = prod((divisors[j] ** e for j, e in enumerate(self.powers)), start=ca.SX(self.sign))
        return whole if self.choice is None else whole * discriminants[self.choice]


@dataclass(frozen=True, eq=False)
class DirectFormulas:
    """The closed form of a direct problem with its guards, and how large roots are at sampled configurations."""

    formulas: ClosedForm
    spans: tuple[Span, ...]
    guards: tuple[Guard, ...]
    usual_roots: np.ndarray


def direct_formulas(problem: Problem, samples: Sequence[Configuration]) -> DirectFormulas | None:
    """The formulas of the direct problem with all its rows; None where none are found, or none that can be guarded."""
    joints = problem.known_coordinates
    if len(samples) < _COMPARED or len(joints) > _MOST_GIVEN or any(c.width != 1 for c in joints):
        return None
    given = np.array([sample.known for sample in samples])
    found = closed_form(problem.system, given[:_COMPARED])
    if found is None or ca.depends_on(ca.vertcat(found.discriminants, found.divisors), found.roots):
        return None
    spans = tuple(_span(c, problem.closure.characteristic_length) for c in joints)
    guards = _guards(found, spans, given)
    if guards is None:
        return None
    usual = np.sqrt(np.median(np.abs(found.discriminants_at(given, found.choices[0])), axis=0))
    return DirectFormulas(found, spans, guards, usual)


def _span(coordinate: Coordinate, size: float) -> Span:
    """All angles; a slide's limits, or the machine's size about the reference."""
    if coordinate.is_angular:
        return Span(True)
    if coordinate.limits is not None:
        low, high = coordinate.limits
        return Span(False, 0.5 * (low + high), 0.5 * (high - low))
    return Span(False, float(coordinate.reference[0]), size)


def _guards(found: ClosedForm, spans: Sequence[Span], given: np.ndarray) -> tuple[Guard, ...] | None:
    """A guard for each discriminant and each divisor that no other one implies."""
    divisors = [found.divisors[j] for j in range(int(found.divisors.shape[0]))]
    guards: list[Guard] = []
    for k, name in enumerate(found.names):
        for powers in sorted(product(range(_POWERS), repeat=len(divisors)), key=sum):
            guard = _guard(found, name, k, powers, spans, given)
            if guard is not None:
                guards.append(guard)
                break
        else:
            return None
    kept: list[ca.SX] = []
    for j, divisor in enumerate(divisors):
        powers = tuple(int(i == j) for i in range(len(divisors)))
        guard = _guard(found, f"divisor {j + 1}", None, powers, spans, given)
        if guard is None:
            return None
        if not any(_proportional(found, divisor, other, given) for other in kept):
            kept.append(divisor)
            guards.append(guard)
    return tuple(guards)


def _guard(
    found: ClosedForm, name: str, choice: int | None, powers: tuple[int, ...], spans: Sequence[Span], given: np.ndarray
) -> Guard | None:
    """The guard of these powers, None where it is no polynomial or has no sign of its own."""
    bare = Guard(name, choice, powers, 1.0, Bend(0.0, np.zeros(0), np.zeros(0), 0.0, 0.0))
    values = _evaluated(bare.of(found.discriminants, found.divisors), found.system.known)
    bend = bend_of(values, spans)
    if bend is None:
        return None
    sign = float(np.sign(np.median(values(given))))
    weights = np.where(bend.weights > _NOISE * np.max(bend.weights), bend.weights, 0.0)
    return Guard(name, choice, powers, sign, Bend(bend.size, bend.slopes, weights, bend.least, bend.most))


def _proportional(found: ClosedForm, first: ca.SX, second: ca.SX, given: np.ndarray) -> bool:
    known = found.system.known
    ratio = _evaluated(first, known)(given) / _evaluated(second, known)(given)
    return bool(np.ptp(ratio) <= _NOISE * np.max(np.abs(ratio)))


def _evaluated(expression: ca.SX, known: ca.SX) -> Callable[[np.ndarray], np.ndarray]:
    function = ca.Function("guard", [known], [expression], {"cse": True})

    def values(given: np.ndarray) -> np.ndarray:
        return np.asarray(function.map(len(given))(given.T)).ravel()

    return values
