"""Constants without rounding noise, for whatever writes expressions as text: C, closure equations."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from symkin.closure.graph import rebuilt

_NOISE = 4e-15
"""Rounding of trigonometry and square roots in double precision, of numbers about 1; relative for others."""


def snap(value: float) -> float:
    """A constant without the rounding noise of trigonometry and square roots that cancel."""
    if abs(value) < _NOISE:
        return 0.0
    near = float(f"{value:.11g}")
    return near if abs(near - value) <= _NOISE * abs(value) else value


def snapped_expression(expression: ca.SX, symbols: Sequence[ca.SX]) -> ca.SX:
    """The same expression with snapped constants, so that what they make zero folds away."""
    function = ca.Function("f", list(symbols), [expression], {"cse": True})

    def folded(value: ca.SX) -> ca.SX:
        return ca.SX(snap(float(value))) if value.is_constant() else value

    return rebuilt(function, symbols, lambda number: ca.SX(snap(number)), folded)
