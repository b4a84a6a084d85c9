"""Add angles, whose sums expressions hold under sines and cosines: one algebra for all who expand
them.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

_FACTORS = {ca.OP_NEG: -1.0, ca.OP_TWICE: 2.0}
"""Operations that multiply an angle."""


@dataclass(frozen=True, eq=False)
class AngleSum:
    """A sum of angles with factors, by what names them, and a known offset."""

    factors: Mapping[Any, float]
    offset: ca.SX

    @staticmethod
    def of(name: Hashable) -> AngleSum:
        """One angle."""
        return AngleSum({name: 1.0}, ca.SX(0))

    def times(self, factor: float) -> AngleSum:
        return AngleSum(
            {name: factor * f for name, f in self.factors.items()}, factor * self.offset
        )

    def plus(self, other: AngleSum) -> AngleSum:
        """The sum of both, without angles that cancel."""
        factors = dict(self.factors)
        for name, factor in other.factors.items():
            factors[name] = factors.get(name, 0.0) + factor
        kept = {name: factor for name, factor in factors.items() if factor}
        return AngleSum(kept, self.offset + other.offset)


def combined(op: int, operands: Sequence[AngleSum | ca.SX | float]) -> AngleSum | None:
    """The sum of angles that an operation makes of others and of known values; None where it makes
    something else.
    """
    first, last = operands[0], operands[-1]
    if op in _FACTORS and isinstance(first, AngleSum):
        return first.times(_FACTORS[op])
    if op in (ca.OP_ADD, ca.OP_SUB):
        a, b = (v if isinstance(v, AngleSum) else AngleSum({}, ca.SX(v)) for v in operands)
        return a.plus(b if op == ca.OP_ADD else b.times(-1.0))
    if op == ca.OP_MUL and not isinstance(first, AngleSum):
        first, last = last, first
    if op not in (ca.OP_MUL, ca.OP_DIV) or not isinstance(first, AngleSum):
        return None
    if isinstance(last, AngleSum) or not ca.SX(last).is_constant():
        return None
    return first.times(float(last) if op == ca.OP_MUL else 1.0 / float(last))


def turned(
    circle: tuple[ca.SX, ca.SX], own: tuple[ca.SX, ca.SX], times: float
) -> tuple[ca.SX, ca.SX]:
    """Cosine and sine of an angle plus a whole number of times another, by the addition
    theorems.
    """
    cosine, sine = circle
    c, s = own[0], own[1] if times > 0 else -own[1]
    for _ in range(abs(round(times))):
        cosine, sine = cosine * c - sine * s, sine * c + cosine * s
    return cosine, sine
