"""Remove rounding noise from constants, so that what they make zero or one folds away."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import rebuilt

_NOISE = 4e-15
"""Rounding of trigonometry and square roots in double precision, of numbers about 1; relative for
others. cos(pi / 2) is 6e-17; some products of such numbers gather a little more.
"""


def snap(value: float, scale: float = 0.0) -> float:
    """Round a constant to 0 or to 11 digits where it differs from that by rounding noise only.

    `scale` is the size of the numbers that have made it, in its own unit. Without it no constant is
    nothing: the square of a length of a tiny machine, or one over that of a huge one, is as small
    as rounding is elsewhere.
    """
    if abs(value) < _NOISE * scale:
        return 0.0
    near = float(f"{value:.11g}")
    return near if abs(near - value) <= _NOISE * abs(value) else value


def snapped_expression(expression: ca.SX, symbols: Sequence[ca.SX], scale: float = 0.0) -> ca.SX:
    """Write the same expression with snapped constants, `scale` as in `snap`."""
    function = ca.Function("f", list(symbols), [expression], {"cse": True})

    def folded(value: ca.SX) -> ca.SX:
        return ca.SX(snap(float(value), scale)) if value.is_constant() else value

    return rebuilt(function, symbols, lambda number: ca.SX(snap(number, scale)), folded)


def snapped_constants(numbers: ca.SX | None, scale: float = 1.0) -> ca.SX | None:
    """Set constants within rounding noise of 0, 1 or -1 times the scale to that; symbols stay as
    they are.
    """
    if numbers is None or not numbers.is_constant():
        return numbers
    values = np.asarray(ca.DM(numbers)) / scale
    nearest = np.clip(np.round(values), -1.0, 1.0)
    return ca.SX(ca.DM(scale * np.where(np.abs(values - nearest) < _NOISE, nearest, values)))
