"""Arithmetic of discs in NumPy: each value is a pair of arrays over points, a middle and a radius.

The bounds are those of `data/discs.h`, where they are derived; a result holds the exact results for
all numbers in its operands.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from symkin.certificate.tape import Code, Op

UNIT = 2.0**-53
"""Largest relative error of an operation in double precision, rounded to nearest."""
TINY = 2.0**-1000
"""Allowance for underflow, whose errors are below 2^-1073."""
UP = 1.0 + 2.0**-48
"""Outweighs 30 roundings of numbers that are not negative."""
_SMALLEST, LARGEST = 2.0**-400, 2.0**400
"""Sizes between which a square neither underflows nor overflows."""
_MOST_RADIANS, _MOST_EXPONENT = 1e5, 300.0
"""Arguments up to which sine, cosine and exponential keep their bounds."""
_ROUND = 6755399441055744.0
"""Adding it rounds a number below 2^51 to an integer."""
_HALF_PI = (1.5707963267341256142, 6.0771005063039659765e-11, 2.0222662487959505738e-21)
_LOG2 = (6.93147180369123816490e-01, 1.90821492927058770002e-10)
_SINE = (
    -7.6471637318198164759e-13,
    1.6059043836821614599e-10,
    -2.5052108385441718775e-08,
    2.7557319223985890653e-06,
    -1.9841269841269841270e-04,
    8.3333333333333333333e-03,
    -1.6666666666666666667e-01,
)
_COSINE = (
    4.7794773323873852974e-14,
    -1.1470745597729724714e-11,
    2.0876756987868098979e-09,
    -2.7557319223985890653e-07,
    2.4801587301587301587e-05,
    -1.3888888888888888889e-03,
    4.1666666666666666667e-02,
    -0.5,
)
_EXPONENTIAL = (
    1.6059043836821614599e-10,
    2.0876756987868098979e-09,
    2.5052108385441718775e-08,
    2.7557319223985890653e-07,
    2.7557319223985890653e-06,
    2.4801587301587301587e-05,
    1.9841269841269841270e-04,
    1.3888888888888888889e-03,
    8.3333333333333333333e-03,
    4.1666666666666666667e-02,
    1.6666666666666666667e-01,
    0.5,
)
Disc = tuple[np.ndarray, np.ndarray]
"""Middle and radius."""


def modulus(x: np.ndarray) -> np.ndarray:
    """A bound of the modulus, at most 1.12 times it."""
    if not np.iscomplexobj(x):
        return np.abs(x)
    a, b = np.abs(x.real), np.abs(x.imag)
    return 0.75 * (a + b) + 0.25 * np.abs(a - b)


def run(code: Code, inputs: Sequence[Disc], count: int, kind: np.dtype[Any]) -> list[Disc]:
    """The outputs of a code over discs of `count` points, with middles of one kind."""
    nothing = (np.full(count, np.nan, dtype=kind), np.full(count, np.inf))
    places, outputs = [nothing] * code.places, [nothing] * code.outputs
    with np.errstate(all="ignore"):
        for op, a, b, out in code.instructions.tolist():
            if op == Op.INPUT:
                places[out] = inputs[a]
            elif op == Op.CONSTANT:
                places[out] = (np.full(count, code.constants[a], dtype=kind), np.zeros(count))
            elif op == Op.OUTPUT:
                outputs[out] = places[a]
            elif op in _BINARY:
                places[out] = _BINARY[op](places[a], places[b])
            else:
                places[out] = _UNARY[op](places[a])
    return outputs


def _add(x: Disc, y: Disc) -> Disc:
    m = x[0] + y[0]
    return m, (x[1] + y[1] + UNIT * modulus(m)) * UP


def _subtract(x: Disc, y: Disc) -> Disc:
    m = x[0] - y[0]
    return m, (x[1] + y[1] + UNIT * modulus(m)) * UP


def _multiply(x: Disc, y: Disc) -> Disc:
    m, a, b = x[0] * y[0], modulus(x[0]), modulus(y[0])
    rounding = 4.0 * UNIT * (a * b) if np.iscomplexobj(m) else UNIT * np.abs(m)
    return m, (a * y[1] + x[1] * (b + y[1]) + rounding + TINY) * UP


def _invert(x: Disc) -> Disc:
    m, r = x
    size = np.maximum(np.abs(m.real), np.abs(m.imag))
    room = size - r
    square = m.real * m.real + m.imag * m.imag
    middle = _joined(m.real / square, -m.imag / square) if np.iscomplexobj(m) else 1.0 / m
    fine = (size > _SMALLEST) & (size < LARGEST) & (room > 0.0)
    return middle, np.where(fine, (r / (size * room) + 8.0 * UNIT / size + TINY) * UP, np.inf)


def _root(x: Disc) -> Disc:
    m, r = x
    if np.iscomplexobj(m):
        a, length = np.abs(m.real), np.sqrt(m.real * m.real + m.imag * m.imag)
        first = np.sqrt(0.5 * (length + a))
        second = 0.5 * m.imag / first
        right = m.real > 0.0
        middle = _joined(
            np.where(right, first, np.abs(second)),
            np.where(right, second, np.copysign(first, m.imag)),
        )
        away = np.where(right, np.maximum(m.real, np.abs(m.imag)), np.abs(m.imag))
        error = 8.0 * UNIT * (first + np.abs(second))
    else:
        middle, away = np.sqrt(m), m
        error = UNIT * middle
    room = away - r
    fine = (away > _SMALLEST) & (modulus(m) < LARGEST) & (room > 0.0)
    return middle, np.where(fine, (0.5 * r / np.sqrt(room) + error + TINY) * UP, np.inf)


def _sine_and_cosine(x: Disc) -> tuple[Disc, Disc]:
    """Sine and cosine."""
    m, r = x
    s, c = sine_and_cosine(m.real)
    fine = (np.abs(m.real) < _MOST_RADIANS) & (r < 1.0)
    if not np.iscomplexobj(m):
        radius = np.where(fine, (8.0 * UNIT + r) * UP, np.inf)
        return (s, radius), (c, radius)
    e = exponential(m.imag)
    d = 1.0 / e
    cosh, sinh = 0.5 * (e + d), 0.5 * (e - d)
    fine &= np.abs(m.imag) < _MOST_EXPONENT
    radius = np.where(fine, cosh * (32.0 * UNIT + r * (1.0 + 2.0 * r)) * UP, np.inf)
    return (_joined(s * cosh, c * sinh), radius), (_joined(c * cosh, -(s * sinh)), radius)


def _exponential(x: Disc) -> Disc:
    m, r = x
    e = exponential(m.real)
    middle, fine = e, (np.abs(m.real) < _MOST_EXPONENT) & (r < 1.0)
    if np.iscomplexobj(m):
        s, c = sine_and_cosine(m.imag)
        middle, fine = _joined(e * c, e * s), fine & (np.abs(m.imag) < _MOST_RADIANS)
    return middle, np.where(fine, e * (32.0 * UNIT + r * (1.0 + 2.0 * r)) * UP, np.inf)


def _angle(y: Disc, x: Disc) -> Disc:
    """Of real numbers only."""
    if np.iscomplexobj(y[0]):
        return x[0], np.full(x[1].shape, np.inf)
    t = np.arctan2(y[0], x[0])
    (s, error), (c, _) = _sine_and_cosine((t, np.zeros(t.shape)))
    across, along = np.abs(y[0] * c - x[0] * s), y[0] * s + x[0] * c
    total, size, spread = (
        np.abs(x[0]) + np.abs(y[0]),
        np.maximum(np.abs(x[0]), np.abs(y[0])),
        x[1] + y[1],
    )
    fine = (size > _SMALLEST) & (total < LARGEST) & (along > 0.25 * size) & (spread < 0.25 * size)
    return t, np.where(
        fine, (2.0 * (across + total * (error + 4.0 * UNIT) + spread) / size + TINY) * UP, np.inf
    )


def _joined(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    m = np.empty(real.shape, dtype=complex)
    m.real, m.imag = real, imaginary
    return m


def sine_and_cosine(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of real numbers below 1e5 in size, within 8 units: no library's own, because theirs promise
    nothing.
    """
    shifted = x * 0.63661977236758134308 + _ROUND
    n = shifted - _ROUND
    r = x - n * _HALF_PI[0]
    r = r - n * _HALF_PI[1]
    r = r - n * _HALF_PI[2]
    y = r * r
    s, c = _polynomial(_SINE, y), _polynomial(_COSINE, y)
    s, c = r + r * (y * s), 1.0 + y * c
    quarter = np.where(np.abs(n) < 2.0**51, n, 0.0).astype(np.int64) & 3
    odd = (quarter & 1) == 1
    sine, cosine = np.where(odd, c, s), np.where(odd, s, c)
    return np.where(quarter >= 2, -sine, sine), np.where(
        (quarter == 1) | (quarter == 2), -cosine, cosine
    )


def exponential(x: np.ndarray) -> np.ndarray:
    """Of real numbers held within 700 of zero, with a relative error of at most 8 units."""
    x = np.clip(x, -700.0, 700.0)
    n = x * 1.4426950408889634074 + _ROUND - _ROUND
    r = x - n * _LOG2[0]
    r = r - n * _LOG2[1]
    result: np.ndarray = np.ldexp(
        1.0 + (r + (r * r) * _polynomial(_EXPONENTIAL, r)), np.nan_to_num(n).astype(np.intc)
    )
    return result


def _polynomial(coefficients: Sequence[float], y: np.ndarray) -> np.ndarray:
    """By Horner's rule, the highest first."""
    total: np.ndarray = coefficients[0] * np.ones_like(y)
    for c in coefficients[1:]:
        total = total * y + c
    return total


_BINARY: dict[int, Callable[[Disc, Disc], Disc]] = {
    Op.ADD: _add,
    Op.SUBTRACT: _subtract,
    Op.MULTIPLY: _multiply,
    Op.ANGLE: _angle,
}
_UNARY: dict[int, Callable[[Disc], Disc]] = {
    Op.SQUARE: lambda x: _multiply(x, x),
    Op.NEGATE: lambda x: (-x[0], x[1]),
    Op.TWICE: lambda x: (2.0 * x[0], 2.0 * x[1]),
    Op.INVERT: _invert,
    Op.SINE: lambda x: _sine_and_cosine(x)[0],
    Op.COSINE: lambda x: _sine_and_cosine(x)[1],
    Op.ROOT: _root,
    Op.EXPONENTIAL: _exponential,
}
