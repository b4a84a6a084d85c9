"""Collect the geometry p: named numbers that stay symbols in the closure until they are bound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca


@dataclass
class ParameterTable:
    """Collects parameters by key path (`leg1.base.x`, `dh.3.a`) while a closure is built. A `bound`
    table gives numbers in place of symbols, so that what follows from them folds.
    """

    names: list[str] = field(default_factory=list)
    symbols: list[ca.SX] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    bound: bool = False

    def scalar(self, path: str, value: float) -> ca.SX:
        symbol = ca.SX(float(value)) if self.bound else ca.SX.sym(path)
        self.names.append(path)
        self.symbols.append(symbol)
        self.values.append(float(value))
        return symbol

    def vector(self, path: str, value: Sequence[float], letters: str = "xyz") -> ca.SX:
        if self.bound:
            return ca.SX(ca.DM([float(v) for v in value]))
        return ca.vertcat(
            *(self.scalar(f"{path}.{k}", v) for k, v in zip(letters, value, strict=True))
        )

    def direction(self, path: str, value: Sequence[float]) -> ca.SX:
        """Three parameters, normalised in the formula, so that calibration may move each of
        them.
        """
        raw = self.vector(path, value)
        return raw / ca.sqrt(ca.dot(raw, raw))
