"""Rows, Jacobians and checks of a system at many points at once, each with known values of its own.

The same formulas as `System.polish`, `residual` and `condition`, which take one point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.numeric.system import NO_MOTION, System

_LANES = 64
"""Points that one mapped call evaluates."""


@dataclass(frozen=True, eq=False)
class Mapped:
    """A CasADi function of vectors at many points: each argument and each result has the points along its first axis."""

    function: ca.Function

    @staticmethod
    def of(arguments: Sequence[ca.SX], results: Sequence[ca.SX]) -> Mapped:
        return Mapped(ca.Function("mapped", list(arguments), [ca.densify(r) for r in results], {"cse": True}))

    @cached_property
    def _lanes(self) -> ca.Function:
        return self.function.map(_LANES)

    def __call__(self, *arguments: np.ndarray) -> list[np.ndarray]:
        count = len(arguments[0])
        shapes = [self.function.size_out(i) for i in range(self.function.n_out())]
        results = [np.empty((count, columns, rows)) for rows, columns in shapes]
        inside = [np.zeros((_LANES, a.shape[1])) for a in arguments]
        outside = [np.zeros((_LANES, columns, rows)) for rows, columns in shapes]
        buffer, evaluate = self._lanes.buffer()
        for i, array in enumerate(inside):
            buffer.set_arg(i, array.reshape(-1).data)
        for i, array in enumerate(outside):
            buffer.set_res(i, array.reshape(-1).data)
        for begin in range(0, count, _LANES):
            for array, argument in zip(inside, arguments, strict=True):
                part = argument[begin : begin + _LANES]
                array[: len(part)] = part
            evaluate()
            for array, result in zip(outside, results, strict=True):
                result[begin : begin + _LANES] = array[: len(result) - begin]
        return [result.transpose(0, 2, 1) for result in results]


@dataclass(frozen=True, eq=False)
class BatchedSystem:
    """A system at points z (n, width) with known values (n, known)."""

    system: System

    @cached_property
    def _linearised(self) -> Mapped:
        return Mapped.of([self.system.unknown, self.system.known], [self.system.rows, self.system.jacobian])

    @cached_property
    def _checked(self) -> Mapped:
        return Mapped.of([self.system.unknown, self.system.known], [self.system.errors])

    def linearise(self, z: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (n, rows) and dF/dd (n, rows, freedom)."""
        values, jacobian = self._linearised(z, known)
        return values[:, :, 0], jacobian

    def residual(self, z: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Largest closure error (n,) in the length unit, over all constraints and whole rotations."""
        return np.asarray(np.max(np.abs(self._checked(z, known)[0]), axis=(1, 2), initial=0.0))

    def condition(self, z: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Condition (n,) of dF/dd; infinite at a singularity."""
        _, jacobian = self.linearise(z, known)
        if min(jacobian.shape[1:]) == 0:
            return np.full(len(z), 1.0 if jacobian.shape[1] * jacobian.shape[2] == 0 else np.inf)
        finite = np.isfinite(jacobian).all(axis=(1, 2))
        values = np.linalg.svd(np.where(finite[:, None, None], jacobian, 0.0), compute_uv=False)
        regular = finite & (values[:, -1] > np.maximum(1e-15 * values[:, 0], NO_MOTION))
        return np.where(regular, values[:, 0] / np.where(regular, values[:, -1], 1.0), np.inf)

    def polish(self, z: np.ndarray, known: np.ndarray, steps: int = 8) -> np.ndarray:
        """Gauss-Newton on all rows, each point until its step no longer shrinks the rows."""
        z = z.copy()
        values, jacobian = self.linearise(z, known)
        going = np.flatnonzero(np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(values).all(axis=1))
        for _ in range(steps):
            if not going.size:
                break
            trial = self.system.move(z[going], _steps(jacobian[going], values[going]))
            trial_values, trial_jacobian = self.linearise(trial, known[going])
            better = np.linalg.norm(trial_values, axis=1) < np.linalg.norm(values[going], axis=1)
            better &= np.isfinite(trial_jacobian).all(axis=(1, 2))
            going = going[better]
            z[going], values[going], jacobian[going] = trial[better], trial_values[better], trial_jacobian[better]
        return z


def _steps(jacobian: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Least-squares steps (n, freedom) of jacobian d = -values."""
    return np.asarray(-(np.linalg.pinv(jacobian, rcond=1e-13) @ values[:, :, None])[:, :, 0])
