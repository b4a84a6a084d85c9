"""Estimate the standard deviations of kinds of readings that state none, from what a fit leaves of
them.

Instruments differ in precision: weighed alike, the worse bends the fit and makes readings of the
better look bad. Of each kind the residuals over what of a shift the fit leaves are normal with its
standard deviation; the median tells it, whatever gross errors the larger half holds.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symkin.calibration.estimate.residuals import ROUNDING_RESIDUAL
from symkin.calibration.estimate.robust import SIGMA_OVER_MEDIAN
from symkin.calibration.judge.outliers import Fit
from symkin.calibration.judge.statistics import linear_model

_LEAST_READINGS = 10
"""Residuals of a kind below which they tell no deviation."""
_LEAST_LEFT = 0.1
"""Share of the square of a shift below which a residual tells more of the other readings."""
_LEAST_SHARE = 1e-4
"""Smallest deviation over the largest (angles times the size): beyond, weights only lose digits."""
_SETTLED = 1.05
"""Deviations that change by less than this ratio stand."""


def estimate_deviations(found: Fit) -> Mapping[str, float]:
    """Return the standard deviations (radians, length unit) of kinds that state none, by key; none
    where those that the fit was weighed by stand, or where there are no two kinds to compare. A
    kind of which the fit leaves too little, or mere rounding, tells none.
    """
    problem, made = found.problem, dict[str, float]()
    channels = problem.measurements.channels(problem.mechanism)
    if problem.readings.known or len(channels) < 2:
        return made
    sizes, ratios = _scatter(found)
    begin, compared, settled, largest = 0, 0, True, 0.0
    for o, reading in channels:
        columns = slice(begin, begin + len(o.components))
        begin = columns.stop
        told = np.isfinite(ratios[:, columns])
        if reading.sigma is None and told.sum() < _LEAST_READINGS:
            continue
        ratio = 1.0
        if reading.sigma is None:
            ratio = SIGMA_OVER_MEDIAN * float(np.median(ratios[:, columns][told]))
            made[o.key] = ratio * float(np.median(problem.readings.sigma[:, columns][told]))
            settled &= 1.0 / _SETTLED < ratio < _SETTLED
        compared += 1
        largest = max(largest, ratio * float(np.median(sizes[:, columns])))
    if settled or compared < 2:
        return {}
    least = {
        o.key: _LEAST_SHARE * largest / (problem.size if o.angular else 1.0) for o, _ in channels
    }
    return {key: max(value, least[key]) for key, value in made.items()}


def _scatter(found: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Return the deviations that readings are weighed by (n, K), as lengths, 0 where nothing was
    read, and sizes of residuals over what they let expect, NaN where a fit leaves none.
    """
    problem = found.problem
    readings, model = problem.readings, linear_model(problem, found.state)
    shape, count = readings.values.shape, readings.values.size
    left = (model.taken - model.absorbed)[:count].reshape(shape)
    residuals = np.abs(model.residuals[:count].reshape(shape))
    sizes = np.where(readings.taken, readings.sigma, 0.0) * problem.model.lengths
    seen = (left > _LEAST_LEFT) & (residuals * sizes > ROUNDING_RESIDUAL * problem.size)
    return sizes, np.where(seen, residuals / np.sqrt(np.where(seen, left, 1.0)), np.nan)
