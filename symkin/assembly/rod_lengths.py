"""Lengths of rods whose ends are known: a square root each.

A rod's row is a (l - l0)^2 + b(known) = 0 with a number a; l and 2 l0 - l are one length (see
`System.fold`), so that there is one solution, over the complex numbers too.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property
from symkin.elimination.closed_form import Solutions
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System

_DOUBLE = 1e-8
"""Squared distance, over the size's square, below which rounding decides a length."""


@dataclass(frozen=True, eq=False)
class RodLengths:
    """A block of rods, with the square of each (l - l0) as an expression of the known values."""

    block: System
    squares: ca.SX
    count: int = 1

    @property
    def steps(self) -> tuple[str, ...]:
        """The derivation, a sentence each."""
        return tuple(f"{c.name} is the distance of its ends" for c in self.block.unknowns)

    def solutions(self, known: np.ndarray) -> Solutions:
        """The lengths for known values (n, known)."""
        squares = self._formulas(known)[0][:, :, 0]
        with np.errstate(invalid="ignore"):
            values = self._least + np.sqrt(squares)
        clear = np.abs(squares) > _DOUBLE * self.block.characteristic_length**2
        real = np.asarray((squares >= 0.0).all(axis=1))
        return Solutions(values[:, None], real[:, None], np.asarray(clear.all(axis=1)))

    @cached_property
    def _formulas(self) -> Mapped:
        return Mapped.of([self.block.known], [self.squares])

    @cached_property
    def _least(self) -> np.ndarray:
        return np.array([c.least for c in self.block.unknowns], dtype=float)


def rod_lengths(block: System) -> RodLengths | None:
    """The lengths of a block's rods; None where it holds anything else."""
    lengths = [c.least for c in block.unknowns if c.least is not None]
    if len(lengths) != len(block.unknowns) or block.rows.shape[0] != len(lengths):
        return None
    at, slopes = ca.SX(ca.DM(lengths)), ca.jacobian(block.rows, block.unknown)
    second = ca.diag(slopes) if slopes.sparsity().is_diag() else ca.SX(0, 1)
    curvatures = ca.diag(ca.jacobian(second, block.unknown))
    even = ca.substitute(second, block.unknown, at)
    if curvatures.numel() != len(lengths) or not (curvatures.is_constant() and even.is_zero()):
        return None
    rest = ca.substitute(block.rows, block.unknown, at)
    return RodLengths(block, -2.0 * rest / curvatures)
