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

WELL_TOLD, UNTOLD = 10.0, 0.1
"""Ratios of the prior's standard deviation to that by the readings."""
_LEAST_WEIGHT = 1e-12
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
    return _ROUNDING_RESIDUAL * problem.size * float(np.max(problem.readings.weight, initial=0.0))


@dataclass(frozen=True, eq=False)
class Linear:
    """The linear model of a state in prior units, over `basis` (P, k), the directions that are
    allowed; `particular` (P,) meets rows left over. `jacobian` (k, k) and `residuals` (k,) are the
    triangle of the readings' J and r, `tight` (P, k) and `change` (P,) those of the prior of weight
    1; `weight` is that of the prior.
    """

    basis: np.ndarray
    particular: np.ndarray
    jacobian: np.ndarray
    residuals: np.ndarray
    tight: np.ndarray
    change: np.ndarray
    weight: float

    @staticmethod
    def of(problem: CalibrationProblem, state: State) -> Linear:
        """Linearise at a state, with the prior of a problem."""
        matrix, model, prior = state.linearised.matrix, problem.model, problem.spread
        units = prior_units(matrix, prior, model.size)
        known = np.isfinite(prior)
        allowed, particular = admissible_steps(state, units)
        basis = units[:, None] * (np.eye(len(units)) if allowed is None else allowed)
        width = basis.shape[1]
        both = np.column_stack([matrix @ basis, state.linearised.vector + matrix @ particular])
        if np.all(np.isfinite(both)):
            both = np.vstack([both, np.zeros((width, width + 1))])
            both = np.asarray(np.linalg.qr(both, mode="r"))
        weights = np.where(known, 1.0, _FREE_WEIGHT) / units
        moved = (state.p - model.nominal) / model.scales * known + particular
        jacobian = both[:width, :width]
        longest = float(np.max(np.linalg.norm(jacobian, axis=0), initial=0.0))
        return Linear(
            basis=basis,
            particular=particular,
            jacobian=jacobian,
            residuals=both[:width, width],
            tight=weights[:, None] * basis,
            change=weights * moved,
            weight=max(_prior_weight(problem, state), _LEAST_WEIGHT * longest),
        )

    def told(self, *, stated: bool = False, least: float = 0.0) -> Told:
        """Find what the readings tell beside the prior, better than its `least`; `stated`
        tolerances are taken for readings: no direction is told without them.
        """
        weight = self.weight
        _, lengths, right = np.linalg.svd(self.jacobian)
        some = (lengths >= least * weight) | stated
        lengths, inner = lengths[some], right[some].T
        decided = (lengths > WELL_TOLD * weight) & (not stated)
        gains = 1.0 / (lengths**2 + np.where(decided, 0.0, weight**2))
        ratios, shares = lengths / weight, lengths**2 * gains
        return Told(self.basis @ inner, inner, ratios, shares, gains, weight)


@dataclass(frozen=True, eq=False)
class Told:
    """What the readings tell: directions of the scaled parameters as `columns` (P, k), one prior
    standard deviation long, and as `inner` (k, k) over the basis; `ratios` (k,) of the prior's
    standard deviation to that by the readings, largest first, what `shares` (k,) of each the
    readings decide, and its `gains` (k,), by which a gradient of the squared residuals moves the
    estimate. `weight` is the prior's.
    """

    columns: np.ndarray
    inner: np.ndarray
    ratios: np.ndarray
    shares: np.ndarray
    gains: np.ndarray
    weight: float


def told_directions(problem: CalibrationProblem, state: State) -> Told:
    """Find what the readings tell, in which an overconstrained closure stays consistent; without
    what they do not tell at all, but where tolerances are stated.
    """
    return Linear.of(problem, state).told(stated=problem.is_stated, least=UNTOLD)


def prior_units(matrix: np.ndarray, prior: np.ndarray, size: float) -> np.ndarray:
    """The prior's standard deviations (P,); what has none is measured so that its column is as long
    as the others are.
    """
    lengths, known = np.linalg.norm(matrix, axis=0), np.isfinite(prior)
    seen = lengths > 0
    like = (lengths * np.where(known, prior, 0.0))[known & seen]
    usual = float(np.median(like)) if len(like) else 1.0
    return np.where(known, prior, np.where(seen, usual / np.where(seen, lengths, 1.0), size))


def _prior_weight(problem: CalibrationProblem, state: State) -> float:
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
    return float(np.sqrt(max(variance, least, 1e-300)))
