"""The few array operations whose spelling differs between NumPy and CasADi.

Every formula of `symkin.spatial` is written once on components. A vector is anything indexed by its
first axis: a NumPy array of shape (3,), a stack of shape (3, N), or a CasADi column. Matrices are
indexed [row, column] and may carry further axes the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from typing import Any

import casadi as ca
import numpy as np

Array = Any
"""A float, a NumPy array or a CasADi SX/MX/DM: whatever a formula is given, it gives back."""

_SYMBOLIC = (ca.SX, ca.MX, ca.DM)


def is_casadi(*values: Array) -> bool:
    # no generator: this is asked several times for each product
    return True in [isinstance(value, _SYMBOLIC) for value in values]


def one_call(formula: Callable[..., Array]) -> Callable[..., Array]:
    """Write a formula of CasADi columns once for each shape and put the arguments into it: one call
    takes a tenth of the time of its operations one by one, and makes the same nodes.
    """
    functions: dict[tuple[int, ...], ca.Function] = {}

    @wraps(formula)
    def called(*arguments: Array) -> Array:
        if False in [type(argument) is ca.SX and argument.is_dense() for argument in arguments]:
            return formula(*arguments)
        shape = tuple([argument.numel() for argument in arguments])
        if shape not in functions:
            symbols = [ca.SX.sym("x", *argument.shape) for argument in arguments]
            functions[shape] = ca.Function("formula", symbols, [formula(*symbols)])
        return functions[shape](*arguments)

    return called


def vector(*components: Array) -> Array:
    """Stack components along the first axis."""
    if is_casadi(*components):
        return ca.vertcat(*components)
    alike = len({getattr(component, "shape", ()) for component in components}) == 1
    return np.array(components if alike else np.broadcast_arrays(*components))


def stacked(columns: Iterable[ca.SX]) -> ca.SX:
    """Stack columns of expressions, of which there may be none, one below the other."""
    return ca.vertcat(ca.SX(0, 1), *columns)


def matrix(rows: Sequence[Sequence[Array]]) -> Array:
    """Stack components along the first two axes."""
    if any(is_casadi(*row) for row in rows):
        return ca.vertcat(*(ca.horzcat(*row) for row in rows))
    return np.stack([vector(*row) for row in rows])


def sin(x: Array) -> Array:
    return ca.sin(x) if is_casadi(x) else np.sin(x)


def cos(x: Array) -> Array:
    return ca.cos(x) if is_casadi(x) else np.cos(x)


def sqrt(x: Array) -> Array:
    return ca.sqrt(x) if is_casadi(x) else np.sqrt(x)


def atan2(y: Array, x: Array) -> Array:
    return ca.atan2(y, x) if is_casadi(y, x) else np.arctan2(y, x)


def where(condition: Array, then: Array, otherwise: Array) -> Array:
    if is_casadi(condition, then, otherwise):
        return ca.if_else(condition, then, otherwise)
    return np.where(condition, then, otherwise)


def dot(a: Array, b: Array) -> Array:
    """Sum of a_i b_i over the first axis."""
    total = a[0] * b[0]
    for i in range(1, a.shape[0] if hasattr(a, "shape") else len(a)):
        total = total + a[i] * b[i]
    return total


def norm(a: Array) -> Array:
    return sqrt(dot(a, a))


@one_call
def cross(a: Array, b: Array) -> Array:
    # indexed once: an index into an expression of CasADi costs as much as a product
    (a0, a1, a2), (b0, b1, b2) = (a[0], a[1], a[2]), (b[0], b[1], b[2])
    return vector(a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0)


def scale(factor: Array, a: Array) -> Array:
    """factor * a, where factor is a scalar per element of the trailing axes."""
    return vector(*(factor * a[i] for i in range(a.shape[0])))
