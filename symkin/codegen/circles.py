"""Write expressions of angles as expressions of their cosines and sines, so that no trigonometry is
left in a loop.

A coordinate is known by its numbers: an angle by cosine and sine, a length by itself, a quaternion
by its four entries. Sines and cosines of sums of angles follow from the addition theorems.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.model.joint import Coordinate

_MOST_MULTIPLE = 4
"""Largest multiple of an angle that the addition theorems expand."""


@dataclass(frozen=True, eq=False)
class Numbers:
    """The numbers by which one entry of a coordinate is known: its value, and of an angle cosine
    and sine too.
    """

    value: ca.SX
    cosine: ca.SX | None = None
    sine: ca.SX | None = None


def of_circle(cosine: ca.SX, sine: ca.SX) -> Numbers:
    """An angle in (-pi, pi] by its cosine and sine."""
    return Numbers(ca.atan2(sine, cosine), cosine, sine)


def number_counts(coordinates: Sequence[Coordinate]) -> list[int]:
    """How many numbers each coordinate is known by."""
    return [2 if c.kind == "angle" else c.width for c in coordinates]


def numbers_of(coordinates: Sequence[Coordinate], symbols: ca.SX) -> list[Numbers]:
    """The numbers of each entry of some coordinates, from a vector that holds them one after the
    other.
    """
    found, place = [], 0
    for c in coordinates:
        if c.kind == "angle":
            found.append(of_circle(symbols[place], symbols[place + 1]))
            place += 2
        else:
            found += [Numbers(symbols[place + i]) for i in range(c.width)]
            place += c.width
    return found


def numbers_at(coordinates: Sequence[Coordinate], values: np.ndarray) -> np.ndarray:
    """The numbers of coordinates at their values."""
    found: list[float] = []
    place = 0
    for c in coordinates:
        if c.kind == "angle":
            found += [float(np.cos(values[place])), float(np.sin(values[place]))]
        else:
            found += [float(v) for v in values[place : place + c.width]]
        place += c.width
    return np.array(found)


def by_numbers(expression: ca.SX, symbols: Sequence[tuple[ca.SX, Sequence[Numbers]]]) -> ca.SX:
    """An expression (n,) of symbols, each entry of which has numbers, as an expression of these
    numbers.
    """
    function = ca.Function("f", [s for s, _ in symbols], [ca.densify(expression)], {"cse": True})
    reader = _Reader([numbers for _, numbers in symbols])
    walk(function, reader)
    return ca.vertcat(ca.SX(0, 1), *(reader.found[k] for k in range(int(expression.shape[0]))))


@dataclass(frozen=True, eq=False)
class AngleSum:
    """A sum of angles with factors, by (input, entry), and a known offset."""

    factors: dict[tuple[int, int], float]
    offset: ca.SX


def sum_of_angles(
    expression: ca.SX, symbols: Sequence[ca.SX], angular: Sequence[Sequence[bool]]
) -> AngleSum | None:
    """The sum of angles whose sine a row is up to a constant factor, as the row of a coupling is;
    None for any other row.
    """
    function = ca.Function("f", list(symbols), [ca.densify(expression)])
    reader = _SineReader(angular)
    walk(function, reader)
    found = reader.found
    return (
        found.inner if isinstance(found, _Sine) else found if isinstance(found, AngleSum) else None
    )


@dataclass(frozen=True, eq=False)
class _Sine:
    """A constant times the sine of a sum of angles."""

    inner: AngleSum


@dataclass
class _SineReader:
    """Evaluator that recognises a constant times the sine of a sum of angles; None stands for
    everything else.
    """

    angular: Sequence[Sequence[bool]]
    found: AngleSum | _Sine | float | None = None

    def input(self, number: int, nonzero: int) -> AngleSum | _Sine | float | None:
        return (
            AngleSum({(number, nonzero): 1.0}, ca.SX(0)) if self.angular[number][nonzero] else None
        )

    def constant(self, number: float) -> AngleSum | _Sine | float | None:
        return number

    def operation(
        self, op: int, operands: list[AngleSum | _Sine | float | None]
    ) -> AngleSum | _Sine | float | None:
        if any(v is None for v in operands):
            return None
        if op == ca.OP_SIN and isinstance(operands[0], AngleSum):
            return _Sine(operands[0])
        if any(isinstance(v, _Sine) for v in operands):
            other = [v for v in operands if not isinstance(v, _Sine)]
            sine = next(v for v in operands if isinstance(v, _Sine))
            constant = op in (ca.OP_MUL, ca.OP_DIV) and all(isinstance(v, float) for v in other)
            return sine if constant or op in (ca.OP_NEG, ca.OP_TWICE) else None
        if any(isinstance(v, AngleSum) for v in operands):
            return _combined(op, [v for v in operands if isinstance(v, AngleSum | float)])
        return None

    def output(self, number: int, nonzero: int, value: AngleSum | _Sine | float | None) -> None:
        if (number, nonzero) == (0, 0):
            self.found = value


@dataclass
class _Reader:
    """Evaluator that writes expressions of numbers."""

    numbers: Sequence[Sequence[Numbers]]
    found: dict[int, ca.SX] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> ca.SX | AngleSum:
        own = self.numbers[number][nonzero]
        return own.value if own.cosine is None else AngleSum({(number, nonzero): 1.0}, ca.SX(0))

    def constant(self, number: float) -> ca.SX | AngleSum:
        return ca.SX(number)

    def output(self, number: int, nonzero: int, value: ca.SX | AngleSum) -> None:
        if number == 0:
            self.found[nonzero] = self._plain(value)

    def operation(self, op: int, operands: list[ca.SX | AngleSum]) -> ca.SX | AngleSum:
        if any(isinstance(v, AngleSum) for v in operands):
            if op in (ca.OP_SIN, ca.OP_COS) and isinstance(operands[0], AngleSum):
                cosine, sine = self._circle(operands[0])
                return sine if op == ca.OP_SIN else cosine
            found = _combined(
                op, [v if isinstance(v, AngleSum) else _constant(v) for v in operands]
            )
            if found is not None:
                return found
        plain = [self._plain(v) for v in operands]
        return ca.SX.binary(op, *plain) if len(plain) == 2 else ca.SX.unary(op, *plain)

    def _plain(self, value: ca.SX | AngleSum) -> ca.SX:
        if not isinstance(value, AngleSum):
            return value
        parts = [self.numbers[i][k].value * factor for (i, k), factor in value.factors.items()]
        return sum(parts, value.offset)

    def _circle(self, angle: AngleSum) -> tuple[ca.SX, ca.SX]:
        """Cosine and sine by the addition theorems, of the sum's value where a factor is no small
        whole number.
        """
        if (
            any(f != round(f) or abs(f) > _MOST_MULTIPLE for f in angle.factors.values())
            or not angle.offset.is_constant()
        ):
            value = self._plain(angle)
            return ca.cos(value), ca.sin(value)
        cosine, sine = ca.cos(angle.offset), ca.sin(angle.offset)
        for (i, k), factor in angle.factors.items():
            own = self.numbers[i][k]
            c, s = (
                (ca.cos(own.value), ca.sin(own.value))
                if own.cosine is None or own.sine is None
                else (own.cosine, own.sine)
            )
            s = s if factor > 0 else -s
            for _ in range(abs(round(factor))):
                cosine, sine = cosine * c - sine * s, sine * c + cosine * s
        return cosine, sine


def _constant(value: ca.SX) -> float | ca.SX:
    return float(value) if value.is_constant() else value


def _combined(op: int, operands: Sequence[AngleSum | float | ca.SX]) -> AngleSum | None:
    """The sum of angles that an operation makes of others, None where it makes something else."""
    first, *others = operands
    if not others:
        own = {ca.OP_NEG: -1.0, ca.OP_TWICE: 2.0}.get(op)
        return _scaled(first, own) if own is not None and isinstance(first, AngleSum) else None
    (second,) = others
    if op == ca.OP_MUL:
        angle, factor = (first, second) if isinstance(first, AngleSum) else (second, first)
        return (
            _scaled(angle, factor)
            if isinstance(angle, AngleSum) and isinstance(factor, float)
            else None
        )
    if op == ca.OP_DIV and isinstance(first, AngleSum) and isinstance(second, float):
        return _scaled(first, 1.0 / second)
    if op not in (ca.OP_ADD, ca.OP_SUB):
        return None
    sign = 1.0 if op == ca.OP_ADD else -1.0
    a, b = (v if isinstance(v, AngleSum) else AngleSum({}, ca.SX(v)) for v in (first, second))
    factors = dict(a.factors)
    for place, factor in b.factors.items():
        factors[place] = factors.get(place, 0.0) + sign * factor
    return AngleSum(
        {place: factor for place, factor in factors.items() if factor}, a.offset + sign * b.offset
    )


def _scaled(angle: AngleSum, factor: float) -> AngleSum:
    return AngleSum(
        {place: factor * f for place, f in angle.factors.items()}, factor * angle.offset
    )
