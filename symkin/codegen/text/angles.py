"""Write expressions of angles as expressions of their cosines and sines, so that code which knows
these needs no trigonometry.

A coordinate is known by its numbers: an angle by cosine and sine, a length by itself, a quaternion
by its four entries. Sines and cosines of sums of angles follow from the addition theorems.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import casadi as ca
import numpy as np

from symkin.closure.angle_sums import AngleSum, combined, turned
from symkin.closure.expression_graph import walk
from symkin.closure.snapping import snap
from symkin.model.joint import Coordinate
from symkin.spatial.backend import stacked

_MOST_MULTIPLE = 4
"""Largest multiple of an angle that the addition theorems expand."""
_SCALED = (ca.OP_NEG, ca.OP_TWICE, ca.OP_MUL, ca.OP_DIV)
_Value: TypeAlias = "ca.SX | AngleSum"


class NotLiftedError(Exception):
    """An angle that is known by cosine and sine alone stands in an expression in another way than
    by those of sums with whole factors.
    """


@dataclass(frozen=True, eq=False)
class Numbers:
    """The numbers by which one entry of a coordinate is known: its value, and of an angle cosine
    and sine (where it `is_half`, of half of it) too or alone.
    """

    value: ca.SX | None
    cosine: ca.SX | None = None
    sine: ca.SX | None = None
    is_half: bool = False

    @classmethod
    def of(cls, parts: Sequence[ca.SX], *, is_half: bool = False) -> Numbers:
        """Those of a length by itself, or of an angle by cosine and sine alone."""
        return cls(None, parts[0], parts[1], is_half) if len(parts) == 2 else cls(parts[0])

    @property
    def parts(self) -> tuple[ca.SX, ...]:
        """Cosine and sine of an angle, else the value."""
        return (self.value,) if self.cosine is None else self.circle()

    def circle(self) -> tuple[ca.SX, ca.SX]:
        """Cosine and sine as they are known."""
        if self.cosine is not None and self.sine is not None:
            return self.cosine, self.sine
        return ca.cos(self.value), ca.sin(self.value)


def of_circle(cosine: ca.SX, sine: ca.SX) -> Numbers:
    """An angle in (-pi, pi] by its cosine and sine."""
    return Numbers(ca.atan2(sine, cosine), cosine, sine)


def number_counts(coordinates: Sequence[Coordinate]) -> list[int]:
    """How many numbers each coordinate is known by."""
    return [2 if c.is_periodic else c.width for c in coordinates]


def numbers_of(coordinates: Sequence[Coordinate], symbols: ca.SX) -> list[Numbers]:
    """The numbers of each entry of some coordinates, from a vector that holds them one after the
    other.
    """
    found, place = [], 0
    for c in coordinates:
        if c.is_periodic:
            found.append(of_circle(symbols[place], symbols[place + 1]))
            place += 2
        else:
            found += [Numbers(symbols[place + i]) for i in range(c.width)]
            place += c.width
    return found


def numbers_by_name(coordinates: Sequence[Coordinate], symbols: ca.SX) -> dict[str, list[Numbers]]:
    """The same of each coordinate by its name."""
    entries = iter(numbers_of(coordinates, symbols))
    return {c.name: [next(entries) for _ in range(c.width)] for c in coordinates}


def numbers_at(coordinates: Sequence[Coordinate], values: np.ndarray) -> np.ndarray:
    """The numbers of coordinates at their values."""
    found: list[float] = []
    place = 0
    for c in coordinates:
        if c.is_periodic:
            found += [float(np.cos(values[place])), float(np.sin(values[place]))]
        else:
            found += [float(v) for v in values[place : place + c.width]]
        place += c.width
    return np.array(found)


# --- expressions ----------------------------------------------------------------------------------


def by_numbers(
    expression: ca.SX, symbols: Sequence[tuple[ca.SX, Sequence[Numbers]]], scale: float = 0.0
) -> ca.SX:
    """An expression (n,) of symbols, each entry of which has numbers, as an expression of these
    numbers; `scale` as in `snap`, of cosines and sines of known offsets. Raises NotLiftedError
    where an angle's value is needed that is not known.
    """
    function = ca.Function("f", [s for s, _ in symbols], [ca.densify(expression)], {"cse": True})
    reader = _Reader([numbers for _, numbers in symbols], scale)
    walk(function, reader)
    return stacked(reader.found[k] for k in range(expression.numel()))


@dataclass
class _Reader:
    """Evaluator that writes expressions of numbers."""

    numbers: Sequence[Sequence[Numbers]]
    scale: float
    found: dict[int, ca.SX] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> _Value:
        own = self.numbers[number][nonzero]
        return AngleSum.of((number, nonzero)) if own.cosine is not None else _known(own)

    def constant(self, number: float) -> _Value:
        return ca.SX(snap(number))

    def output(self, number: int, nonzero: int, value: _Value) -> None:
        if number == 0:
            self.found[nonzero] = self._plain(value)

    def operation(self, op: int, operands: list[_Value]) -> _Value:
        if any(isinstance(v, AngleSum) for v in operands):
            if op in (ca.OP_SIN, ca.OP_COS) and isinstance(operands[0], AngleSum):
                cosine, sine = self._circle(operands[0])
                return sine if op == ca.OP_SIN else cosine
            found = combined(op, operands)
            if found is not None:
                return found
        plain = [self._plain(v) for v in operands]
        return ca.SX.binary(op, *plain) if len(plain) == 2 else ca.SX.unary(op, *plain)

    def _plain(self, value: _Value) -> ca.SX:
        if not isinstance(value, AngleSum):
            return value
        parts = [_known(self.numbers[i][k]) * f for (i, k), f in value.factors.items()]
        return sum(parts, value.offset)

    def _circle(self, angle: AngleSum) -> tuple[ca.SX, ca.SX]:
        """Cosine and sine by the addition theorems, of the sum's value where a factor is no small
        whole number.
        """
        steps = [_steps(self.numbers[i][k], factor) for (i, k), factor in angle.factors.items()]
        if not angle.offset.is_constant() or any(
            times != round(times) or abs(times) > _MOST_MULTIPLE for _, times in steps
        ):
            value = self._plain(angle)
            return ca.cos(value), ca.sin(value)
        offset = float(angle.offset)
        circle = (
            ca.SX(snap(float(np.cos(offset)), self.scale)),
            ca.SX(snap(float(np.sin(offset)), self.scale)),
        )
        for own, times in steps:
            circle = turned(circle, own, times)
        return circle


def _known(numbers: Numbers) -> ca.SX:
    if numbers.value is None:
        raise NotLiftedError
    return numbers.value


def _steps(numbers: Numbers, factor: float) -> tuple[tuple[ca.SX, ca.SX], float]:
    """Cosine and sine, and how many times their angle is added for a factor of the coordinate."""
    c, s = numbers.circle()
    if not numbers.is_half:
        return (c, s), factor
    return ((c * c - s * s, 2 * c * s), factor) if factor == round(factor) else ((c, s), 2 * factor)


# --- couplings ------------------------------------------------------------------------------------


def sum_of_angles(
    expression: ca.SX, symbols: Sequence[ca.SX], angular: Sequence[Sequence[bool]]
) -> AngleSum | None:
    """The sum of angles, by (input, entry), whose sine a row is up to a constant factor, as the row
    of a coupling is; None for any other row.
    """
    sine = expression
    while sine.op() in _SCALED:
        parts = [sine.dep(k) for k in range(sine.n_dep()) if not sine.dep(k).is_constant()]
        sine = parts[0] if len(parts) == 1 else ca.SX(0)
    inner = sine.dep(0) if sine.op() == ca.OP_SIN else expression
    everything = ca.vertcat(*symbols)
    if not ca.is_linear(inner, everything):
        return None
    factors, offset = ca.linear_coeff(inner, everything)
    places = [(i, k) for i, own in enumerate(angular) for k in range(len(own))]
    held = {place: factors[0, j] for j, place in enumerate(places) if not factors[0, j].is_zero()}
    if not all(angular[i][k] and f.is_constant() for (i, k), f in held.items()):
        return None
    return AngleSum({place: float(f) for place, f in held.items()}, offset) if held else None
