"""Discs by balls, where no compiler is found: a code runs over Arb's balls, point by point, and its
results are told as discs, rounded outward. Bounds of roundings that all engines share.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from flint import acb, arb

from symkin.certificate.tape import Code, Op
from symkin.numeric.balls import Number, Ring, angle_of, precision, root_of, upper

UNIT = 2.0**-53
"""Largest relative error of an operation in double precision, rounded to nearest."""
TINY = 2.0**-1000
"""Allowance for underflow, whose errors are below 2^-1073."""
UP = 1.0 + 2.0**-48
"""Outweighs 30 roundings of numbers that are not negative."""
_BITS = 64
"""Precision of the balls: more than a double has."""
Disc = tuple[Any, float]
"""Middle and radius."""

_BINARY: dict[int, Callable[[Number, Number], Number]] = {
    Op.ADD: operator.add,
    Op.SUBTRACT: operator.sub,
    Op.MULTIPLY: operator.mul,
    Op.ANGLE: angle_of,
}
_UNARY: dict[int, Callable[[Number], Number]] = {
    Op.SQUARE: lambda x: x * x,
    Op.NEGATE: operator.neg,
    Op.TWICE: lambda x: x + x,
    Op.INVERT: lambda x: 1 / x,
    Op.SINE: lambda x: x.sin(),
    Op.COSINE: lambda x: x.cos(),
    Op.ROOT: root_of,
    Op.EXPONENTIAL: lambda x: x.exp(),
}


def modulus(x: np.ndarray) -> np.ndarray:
    """A bound of the modulus, at most 1.12 times it."""
    if not np.iscomplexobj(x):
        return np.abs(x)
    a, b = np.abs(x.real), np.abs(x.imag)
    return 0.75 * (a + b) + 0.25 * np.abs(a - b)


@precision(_BITS)
def run(code: Code, inputs: Sequence[Number], ring: Ring) -> list[Disc]:
    """The outputs of a code at balls of a ring."""
    places = [ring.number("nan")] * code.places
    outputs: list[Disc] = [(np.nan, np.inf)] * code.outputs
    for op, a, b, out in code.lines:
        if op == Op.INPUT:
            places[out] = inputs[a]
        elif op == Op.CONSTANT:
            places[out] = ring.number(code.constants[a])
        elif op == Op.OUTPUT:
            outputs[out] = _disc(places[a])
        elif op in _BINARY:
            places[out] = _BINARY[op](places[a], places[b])
        else:
            places[out] = _UNARY[op](places[a])
    return outputs


def balls_about(middles: np.ndarray, radii: np.ndarray) -> list[Number]:
    """Balls that hold discs (n,)."""
    return [*map(_ball, middles.tolist(), radii.tolist())]


def _ball(middle: Any, radius: float) -> Number:
    """The square about a disc, or its interval; no number about what is not finite."""
    ball: Number
    if isinstance(middle, complex):
        ball = acb(arb(middle.real, radius), arb(middle.imag, radius))
    else:
        ball = arb(middle, radius)
    return ball if ball.is_finite() else type(ball)("nan")


def _disc(ball: Number) -> Disc:
    """A disc that holds a ball."""
    is_real = isinstance(ball, arb)
    middle: Any = float(ball) if is_real else complex(ball)
    rest = ball - (middle if is_real else acb(middle.real, middle.imag))
    radius = 0.0 if rest == 0 else upper(rest) + TINY
    return (middle, radius) if np.isfinite(middle) and np.isfinite(radius) else (np.nan, np.inf)
