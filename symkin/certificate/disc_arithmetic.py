"""Discs and the balls that stand for them where no compiler is found; bounds of roundings."""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import acb, arb

from symkin.numeric.balls import Number, upper

UNIT = 2.0**-53
"""Largest relative error of an operation in double precision, rounded to nearest."""
TINY = 2.0**-1000
"""Allowance for underflow, whose errors are below 2^-1073."""
UP = 1.0 + 2.0**-48
"""Outweighs 30 roundings of numbers that are not negative."""
Disc = tuple[Any, float]
"""Middle and radius."""


def modulus(x: np.ndarray) -> np.ndarray:
    """A bound of the modulus, at most 1.12 times it."""
    if not np.iscomplexobj(x):
        return np.abs(x)
    a, b = np.abs(x.real), np.abs(x.imag)
    return 0.75 * (a + b) + 0.25 * np.abs(a - b)


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


def disc_about(ball: Number) -> Disc:
    """A disc that holds a ball."""
    is_real = isinstance(ball, arb)
    middle: Any = float(ball) if is_real else complex(ball)
    rest = ball - (middle if is_real else acb(middle.real, middle.imag))
    radius = 0.0 if rest == 0 else upper(rest) + TINY
    return (middle, radius) if np.isfinite(middle) and np.isfinite(radius) else (np.nan, np.inf)
