"""How large the terms of an expression are, of which a cancelling sum leaves rounding only.

The size of a value is what its rounding error is a multiple of (a running error bound): |x| for a
number x, and

    size(a + b) = size(a) + size(b)            size(a b) = |a| size(b) + |b| size(a)
    size(f(a)) = |f'(a)| size(a) + |f(a)|      for other functions

so that a value far below its size has cancelled, whatever the units are.

Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd edition, SIAM, 2002,
section 3.3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.spatial.backend import stacked

_LEAST = 1e-300
"""What keeps quotients of zeros finite."""


class _Sized(NamedTuple):
    """A value with its size: arrays over samples, or expressions."""

    value: Any
    size: Any


_VALUES: dict[int, Callable[..., Any]] = {
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: lambda a, b: a / b,
    ca.OP_NEG: lambda a: -a,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: a + a,
    ca.OP_INV: lambda a: 1.0 / a,
    ca.OP_SQRT: np.sqrt,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_FABS: np.abs,
}
"""Operations on arrays; others are left to CasADi."""


@dataclass
class _Sizes:
    """Evaluator that finds values and sizes of a function's first output from those of its first
    input.
    """

    values: Sequence[Any]
    sizes: Sequence[Any]
    found: dict[int, _Sized] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> _Sized:  # noqa: ARG002 - there is one input
        return _Sized(self.values[nonzero], self.sizes[nonzero])

    def constant(self, number: float) -> _Sized:
        return _Sized(number, abs(number))

    def operation(self, op: int, operands: list[_Sized]) -> _Sized:
        value = _value(op, [v.value for v in operands])
        return _Sized(value, _size(op, value, operands))

    def output(self, number: int, nonzero: int, value: _Sized) -> None:  # noqa: ARG002 - there is one output
        self.found[nonzero] = value


def _value(op: int, operands: Sequence[Any]) -> Any:
    """What an operation makes of arrays, numbers or expressions."""
    make = ca.SX.binary if len(operands) == 2 else ca.SX.unary
    if any(isinstance(v, ca.SX) for v in operands):
        return make(op, *operands)
    if op in _VALUES:
        return _VALUES[op](*operands)
    columns = np.broadcast_arrays(*operands)
    return np.asarray(ca.DM(make(op, *(ca.SX(ca.DM(np.atleast_1d(v))) for v in columns)))).reshape(
        columns[0].shape
    )


def _absolute(value: Any) -> Any:
    """|x| of arrays, numbers or expressions, which have no abs() of their own in the lowest
    CasADi.
    """
    return ca.fabs(value) if isinstance(value, ca.SX) else abs(value)


def _size(op: int, value: Any, operands: Sequence[_Sized]) -> Any:
    """The size of an operation's `value`."""
    a, b = operands[0], operands[-1]
    if op in (ca.OP_ADD, ca.OP_SUB, ca.OP_FMAX, ca.OP_FMIN):
        return a.size + b.size
    if op == ca.OP_MUL:
        return _absolute(a.value) * b.size + _absolute(b.value) * a.size
    if op == ca.OP_DIV:
        return (a.size + _absolute(value) * b.size) / _absolute(b.value)
    if op == ca.OP_INV:
        return value * value * (a.size + _absolute(a.value))
    if op in (ca.OP_NEG, ca.OP_FABS, ca.OP_ASSIGN):
        return a.size
    if op == ca.OP_TWICE:
        return 2 * a.size
    if op == ca.OP_SQ:
        return 2 * _absolute(a.value) * a.size
    if op == ca.OP_SQRT:
        # where the radicand is rounding, so is the root of its size
        return a.size / (value + a.size**0.5 + _LEAST)
    if op in (ca.OP_SIN, ca.OP_COS):
        return a.size + _absolute(value)
    if op == ca.OP_ATAN2:
        square = a.value * a.value + b.value * b.value
        return _absolute(value) + (_absolute(b.value) * a.size + _absolute(a.value) * b.size) / (
            square + _LEAST
        )
    return _absolute(value) + sum(v.size for v in operands)


def sized_numbers(
    expressions: ca.SX, symbols: ca.SX, values: np.ndarray, sizes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (samples, n) of some expressions (n,) of symbols (m,), and their sizes, from those
    (samples, m) of the symbols.
    """
    function = _function(expressions, symbols)
    with np.errstate(all="ignore"):
        found = _walked(function, list(values.T), list(sizes.T))
    terms = np.empty((len(values), len(found)))
    for k, (_, size) in enumerate(found):
        terms[:, k] = size
    return np.broadcast_to(np.asarray(function(values.T)).T, terms.shape), terms


def term_sizes(expressions: ca.SX, symbols: ca.SX, sizes: ca.SX) -> ca.SX:
    """Sizes of some expressions (n,) of symbols (m,), as expressions of these and of their own
    sizes.
    """
    found = _walked(_function(expressions, symbols), symbols.elements(), sizes.elements())
    return stacked(size for _, size in found)


def _function(expressions: ca.SX, symbols: ca.SX) -> ca.Function:
    return ca.Function("sized", [symbols], [ca.densify(expressions)])


def _walked(function: ca.Function, values: Sequence[Any], sizes: Sequence[Any]) -> list[_Sized]:
    evaluator = _Sizes(values, sizes)
    walk(function, evaluator)
    return [evaluator.found[k] for k in range(int(function.nnz_out(0)))]
