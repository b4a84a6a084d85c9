"""Graphs of CasADi evaluated in ball arithmetic (Arb, by python-flint): every rounding is outward.

A function f(z; k) runs as a tape (see `tape`), in two parts: what depends on k alone, and the rest.

F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Trans.
Comput. 66 (2017) 1281.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from contextlib import ContextDecorator
from dataclasses import dataclass
from typing import Any

import casadi as ca
from flint import acb, acb_mat, arb, arb_mat, ctx

from symkin.computed_once import cached_property, set_waiting
from symkin.locks import Lock
from symkin.numeric.tape import Code, Op, Part, Tape, build_tape

Number = Any
"""A ball: arb or acb."""

UP = 1.0 + 2.0**-50
"""Outward rounding of a few operations on doubles that are not negative."""


@dataclass(frozen=True)
class Ring:
    """Balls of one kind, with their matrices."""

    number: Callable[..., Number]
    matrix: Callable[..., Any]
    is_real: bool

    def around_zero(self, radius: float) -> Number:
        """The ball (a square in the complex plane) of at least that radius."""
        side = arb(0.0, radius)
        return side if self.is_real else acb(side, side)

    def column(self, entries: Sequence[Number]) -> Any:
        return self.matrix(len(entries), 1, list(entries))


REAL = Ring(arb, arb_mat, is_real=True)
COMPLEX = Ring(acb, acb_mat, is_real=False)
RINGS = (REAL, COMPLEX)
"""In the order in which they are tried at a point that looks real."""


_context = Lock()
"""Held by the thread that works with balls: their precision belongs to the process."""


class precision(ContextDecorator):  # noqa: N801  # called as a function
    """Work at that many bits, one thread at a time; the caller's precision comes back."""

    __slots__ = ("_before", "_waited", "bits")

    def __init__(self, bits: int) -> None:
        self.bits = bits

    def _recreate_cm(self) -> precision:
        """A decorated function may be called by threads: each call has its own."""
        return precision(self.bits)

    def __enter__(self) -> None:
        _context.acquire()
        self._waited = set_waiting(waits=False)
        self._before = ctx.prec
        ctx.prec = self.bits

    def __exit__(self, *_: object) -> None:
        ctx.prec = self._before
        set_waiting(waits=self._waited)
        _context.release()


def upper(x: Number) -> float:
    """A double that no |value| in the ball exceeds; infinite for what is not finite."""
    bound = float(x.abs_upper()) * UP
    return bound if bound == bound else float("inf")


@dataclass(frozen=True, eq=False)
class BallFunction:
    """f(z; k) over balls, a column. `parts` says what is evaluated, in order: "value" f, "slope"
    df/dz.
    """

    z: ca.SX
    k: ca.SX
    f: ca.SX
    parts: tuple[Part, ...] = ("value",)

    @cached_property
    def tape(self) -> Tape:
        """Its operations."""
        return build_tape(self.z, self.k, self.f, self.parts)

    def prepare(self, ring: Ring, known: Sequence[Number]) -> Prepared:
        """What k alone determines, at the present precision; k as doubles (exact) or balls."""
        numbers = [ring.number(v) for v in (*known, *self.tape.values.tolist())]
        return ring, run(self.tape.before, numbers, ring)

    def evaluate(self, which: int, z: Sequence[Number], prepared: Prepared) -> list[Number]:
        """Part `which` at balls z, a dense matrix row by row."""
        ring, kept = prepared
        columns = 1 if self.parts[which] == "value" else self.z.shape[0]
        entries = [ring.number(0)] * (self.f.shape[0] * columns)
        found = run(self.tape.parts[which], [*z, *kept], ring)
        for row, column, value in zip(*self.tape.places[which], found, strict=True):
            entries[row * columns + column] = value
        return entries


Prepared = tuple[Ring, list[Number]]
"""What known values alone determine, and the balls that it is told in."""


def run(code: Code, inputs: Sequence[Number], ring: Ring) -> list[Number]:
    """The outputs of a code at balls of a ring."""
    places = [ring.number("nan")] * code.places
    outputs = [ring.number("nan")] * code.outputs
    binary, unary = _BINARY, _UNARY
    for op, a, b, out in code.lines:
        if op in binary:
            places[out] = binary[op](places[a], places[b])
        elif op in unary:
            places[out] = unary[op](places[a])
        elif op == _INPUT:
            places[out] = inputs[a]
        elif op == _OUTPUT:
            outputs[out] = places[a]
        else:
            places[out] = ring.number(code.constants[a])
    return outputs


def root_of(x: Number) -> Number:
    """Square root; not a number where a ball meets the cut, on which the root is not analytic."""
    return x.sqrt() if isinstance(x, arb) else x.sqrt(analytic=True)


def angle_of(y: Number, x: Number) -> Number:
    """atan2(y, x) modulo 2 pi, of real balls alone: the branch that is continuous on the ball."""
    if isinstance(y, acb):
        return acb("nan")
    return arb.pi() + arb.atan2(-y, -x) if x < 0 else arb.atan2(y, x)


# plain integers: each operation of a tape is looked up here
_INPUT, _OUTPUT = Op.INPUT.value, Op.OUTPUT.value
_BINARY: dict[int, Callable[[Number, Number], Number]] = {
    Op.ADD.value: operator.add,
    Op.SUBTRACT.value: operator.sub,
    Op.MULTIPLY.value: operator.mul,
    Op.ANGLE.value: angle_of,
}
_UNARY: dict[int, Callable[[Number], Number]] = {
    Op.SQUARE.value: lambda x: x * x,
    Op.NEGATE.value: operator.neg,
    Op.TWICE.value: lambda x: x + x,
    Op.INVERT.value: lambda x: 1 / x,
    Op.SINE.value: lambda x: x.sin(),
    Op.COSINE.value: lambda x: x.cos(),
    Op.ROOT.value: root_of,
    Op.EXPONENTIAL.value: lambda x: x.exp(),
}
