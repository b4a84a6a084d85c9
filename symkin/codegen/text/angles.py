"""Write expressions over cosines and sines in place of angles, so that code which knows these needs
no trigonometry.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.closure.snapping import snap, snapped_expression


class NotLiftedError(Exception):
    """An angle stands in an expression in another way than by sines and cosines of sums with known
    factors.
    """


@dataclass(frozen=True, eq=False)
class Generators:
    """What stands for a coordinate: `value` of a length; cosine and sine of an angle, or, where
    `is_half`, of half of it.
    """

    parts: tuple[ca.SX, ...]
    is_half: bool = False

    @property
    def is_angle(self) -> bool:
        return len(self.parts) == 2

    @property
    def whole(self) -> tuple[ca.SX, ...]:
        """The value of a length, cosine and sine of an angle."""
        if not self.is_half:
            return self.parts
        c, s = self.parts
        return c * c - s * s, 2 * c * s


@dataclass(frozen=True, eq=False)
class _Angle:
    """A sum of angles (name: factor) and an offset."""

    factors: dict[str, float]
    offset: float


_Value: TypeAlias = "ca.SX | _Angle"


def lifted(
    expression: ca.SX,
    places: Sequence[tuple[ca.SX, str]],
    generators: Mapping[str, Generators],
    others: ca.SX,
) -> ca.SX:
    """An expression of coordinates (symbol, name) and of other symbols over the coordinates'
    generators. Raises NotLiftedError.
    """
    symbols = ca.vertcat(ca.SX(0, 1), *(symbol for symbol, _ in places))
    function = ca.Function("f", [symbols, others], [ca.densify(expression)], {"cse": True})
    reader = _Lift([generators[name] for _, name in places], [name for _, name in places], others)
    walk(function, reader)
    entries = [reader.found.get(k, ca.SX(0)) for k in range(int(expression.shape[0]))]
    every = {id(g): g for g in reader.generators}.values()
    own = ca.vertcat(others, *(part for g in every for part in g.parts if part.is_symbolic()))
    return snapped_expression(
        ca.vertcat(ca.SX(0, 1), *entries), [_symbols_of(ca.vertcat(own, *entries))]
    )


def _symbols_of(expression: ca.SX) -> ca.SX:
    return ca.vertcat(ca.SX(0, 1), *ca.symvar(expression))


@dataclass
class _Lift:
    """Evaluator that puts generators in place of angles."""

    generators: Sequence[Generators]
    names: Sequence[str]
    others: ca.SX
    found: dict[int, ca.SX] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> _Value:
        if number == 1:
            return self.others[nonzero]
        own = self.generators[nonzero]
        return _Angle({self.names[nonzero]: 1.0}, 0.0) if own.is_angle else own.parts[0]

    def constant(self, number: float) -> _Value:
        return ca.SX(snap(number))

    def output(self, number: int, nonzero: int, value: _Value) -> None:  # noqa: ARG002 - the walker's signature
        if isinstance(value, _Angle):
            raise NotLiftedError
        self.found[nonzero] = value

    def operation(self, op: int, operands: list[_Value]) -> _Value:
        if any(isinstance(v, _Angle) for v in operands):
            return self._of_angles(op, operands)
        make = ca.SX.binary if len(operands) == 2 else ca.SX.unary
        return make(op, *operands)

    def _of_angles(self, op: int, operands: list[_Value]) -> _Value:
        first = operands[0]
        if op in (ca.OP_SIN, ca.OP_COS) and isinstance(first, _Angle):
            cosine, sine = self._cosine_and_sine(first)
            return sine if op == ca.OP_SIN else cosine
        if op in (ca.OP_NEG, ca.OP_TWICE) and isinstance(first, _Angle):
            return _scaled(first, -1.0 if op == ca.OP_NEG else 2.0)
        if op == ca.OP_MUL:
            angle, factor = (
                (first, operands[1]) if isinstance(first, _Angle) else (operands[1], first)
            )
            return _scaled(angle, _number(factor)) if isinstance(angle, _Angle) else first
        if op in (ca.OP_ADD, ca.OP_SUB):
            a, b = (v if isinstance(v, _Angle) else _Angle({}, _number(v)) for v in operands)
            b = _scaled(b, 1.0 if op == ca.OP_ADD else -1.0)
            factors = dict(a.factors)
            for name, factor in b.factors.items():
                factors[name] = factors.get(name, 0.0) + factor
            return _Angle(
                {name: factor for name, factor in factors.items() if factor}, a.offset + b.offset
            )
        raise NotLiftedError

    def _cosine_and_sine(self, angle: _Angle) -> tuple[ca.SX, ca.SX]:
        """By the addition theorems."""
        cosine, sine = (
            ca.SX(snap(float(np.cos(angle.offset)), 1.0)),
            ca.SX(snap(float(np.sin(angle.offset)), 1.0)),
        )
        for name, factor in angle.factors.items():
            own = self.generators[self.names.index(name)]
            c, s = own.parts
            times = 2.0 * factor if own.is_half else factor
            if own.is_half and times == 2.0 * round(factor):
                (c, s), times = own.whole, factor
            if times != round(times):
                raise NotLiftedError
            turn = s if times > 0 else -s
            for _ in range(abs(round(times))):
                cosine, sine = cosine * c - sine * turn, sine * c + cosine * turn
        return cosine, sine


def _scaled(angle: _Angle, factor: float) -> _Angle:
    return _Angle({name: factor * f for name, f in angle.factors.items()}, factor * angle.offset)


def _number(value: _Value) -> float:
    if isinstance(value, _Angle) or not value.is_constant():
        raise NotLiftedError
    return float(value)
