"""Linearise a fit in prior units: what the readings tell of each direction, and the prior beside
it.

One unit of a parameter is one standard deviation of the prior. A singular value of the Jacobian
over the prior's weight w says how many times better than the prior the readings tell a direction:
its standard deviation by the readings is the prior's over that. Above `WELL_TOLD` the readings
decide; below `UNTOLD` they say nothing; between, both do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.state import State, admissible_steps
from symkin.computed_once import cached_property

WELL_TOLD, UNTOLD = 10.0, 0.1
"""Ratios of the prior's standard deviation to that by the readings."""
_LEAST_WEIGHT = 1e-7
"""Least weight of the prior, of the longest column: where the noise is nothing it still says where
what no reading tells stays.
"""
_FREE_WEIGHT = 1e-9
"""Weight of the prior for what has none, beside that of others: it keeps what no reading tells
where it is.
"""
_QUIET = 4.0
"""Noise that is stated counts as it is until its variance is so many times that of the residuals:
of readings without noise nothing is left to the prior.
"""
_ROUNDING_RESIDUAL = 1e-12
"""Residuals below this, over the size, are no more than arithmetic leaves."""
_ROUNDING_VARIANCE = 1e6
"""Variance that counts as one is no less than this many of those of rounding."""


def rounding_residual(problem: CalibrationProblem) -> float:
    """A residual that arithmetic leaves."""
    return (
        _ROUNDING_RESIDUAL
        * problem.model.closure.characteristic_length
        * float(np.max(problem.readings.weight, initial=0.0))
    )


@dataclass(frozen=True, eq=False)
class Linear:
    """The linear model of a state in prior units: normal matrix J^T J and gradient J^T r over
    `basis` (P, k), the directions that are allowed (dp = units * basis @ y), `particular` (P,) what
    meets rows left over; the prior's precision `weak` (k, k) of weight 1, `off` (k,) its gradient.
    """

    basis: np.ndarray
    particular: np.ndarray
    normal: np.ndarray
    gradient: np.ndarray
    weak: np.ndarray
    off: np.ndarray

    @staticmethod
    def of(problem: CalibrationProblem, state: State, prior: np.ndarray) -> Linear:
        """Linearise at a state; `prior` (P,) are standard deviations of scaled parameters."""
        matrix, model = state.linearised.matrix, problem.model
        units = prior_units(matrix, prior, model.closure.characteristic_length)
        weights = np.where(np.isfinite(prior), 1.0, _FREE_WEIGHT) ** 2
        change = (state.p - model.nominal) / model.scales / units * np.isfinite(prior)
        allowed, particular = admissible_steps(state, units)
        scaled = matrix * units
        basis = np.eye(len(units)) if allowed is None else allowed
        if allowed is not None:
            scaled = scaled @ basis
        right = state.linearised.vector + matrix @ particular
        return Linear(
            basis=units[:, None] * basis,
            particular=particular,
            normal=scaled.T @ scaled,
            gradient=scaled.T @ right,
            weak=basis.T @ (weights[:, None] * basis),
            off=basis.T @ (weights * (change + particular / units)),
        )

    @cached_property
    def longest(self) -> float:
        """The longest column."""
        return float(np.sqrt(np.max(np.diag(self.normal), initial=0.0)))

    @cached_property
    def told(self) -> tuple[np.ndarray, np.ndarray]:
        """Singular values (k,) of the Jacobian, how many times better than a prior of weight 1 the
        readings tell each direction, and the directions (k, k) as columns.
        """
        values, vectors = np.linalg.eigh(self.normal)
        return np.sqrt(np.maximum(values, 0.0)), vectors


def prior_units(matrix: np.ndarray, prior: np.ndarray, size: float) -> np.ndarray:
    """The prior's standard deviations (P,); what has none is measured so that its column is as long
    as the others are.
    """
    lengths = np.linalg.norm(matrix, axis=0)
    known = np.isfinite(prior)
    usual = (
        float(np.median((lengths * prior)[known & (lengths > 0)]))
        if np.any(known & (lengths > 0))
        else 1.0
    )
    free = np.where(lengths > 0, usual / np.where(lengths > 0, lengths, 1.0), size)
    return np.where(known, np.where(known, prior, 1.0), free)


def prior_weight(problem: CalibrationProblem, state: State, linear: Linear) -> float:
    """Return the weight w of the prior: 1, or the standard deviation of the residuals where the
    noise is not known or they are far below it; not below what rounding leaves.
    """
    readings = problem.readings
    freedom = readings.count - len(problem.names)
    variance = state.cost / max(freedom, 1)
    if readings.known:
        quiet = freedom > 0 and not problem.is_stated
        variance = min(1.0, _QUIET * variance) if quiet else 1.0
    least = _ROUNDING_VARIANCE * rounding_residual(problem) ** 2
    return max(float(np.sqrt(max(variance, least, 1e-300))), _LEAST_WEIGHT * linear.longest)
