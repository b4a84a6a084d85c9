"""Form the residuals of readings, r = W (h - m), with the unknown inclination of each group
eliminated.

In a group only equality is known. Three forms of it:

  differences          of neighbours in the group, taken as if they were independent
  means                deviations from the group's weighted mean: least squares with the
                       inclination as an unknown
  maximum likelihood   the same with the covariance of each configuration's readings,
                       S = diag(sigma^2) + H_q diag(sigma_q^2) H_q^T, H_q = -h_z F_z^-1 F_q the
                       effect of joint noise (errors in variables, linearised)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configuration_model import ConfigurationModel
from symkin.calibration.options import Form
from symkin.computed_once import cached_property
from symkin.spatial.rotation import wrapped

ROUNDING_RESIDUAL = 1e-9
"""Residuals below this, in radians or of the size, are rounding and not errors of an instrument."""


def only_rounding(values: np.ndarray | float, unit: float) -> bool:
    """Tell whether residuals are no more than what arithmetic leaves; `unit` is 1 for angles
    (radians), the size for lengths.
    """
    return bool(np.all(np.abs(values) < ROUNDING_RESIDUAL * unit))


@dataclass(frozen=True, eq=False)
class Readings:
    """The readings as the residuals need them: values m (n, K) and standard deviations (n, K) of
    each column, NaN and infinite where nothing was read; which columns are angles modulo a turn;
    the group number (n,) from 0, -1 for none, and the first configuration of each group. `known`
    says that every standard deviation was given.
    """

    values: np.ndarray
    sigma: np.ndarray
    turning: np.ndarray
    grouped: np.ndarray
    group: np.ndarray
    first: np.ndarray
    known: bool

    @cached_property
    def taken(self) -> np.ndarray:
        return np.isfinite(self.sigma)

    @property
    def judged(self) -> np.ndarray:
        """Configurations (n,) of which more was read than their group."""
        return np.any(self.taken & ~self.grouped, axis=1)

    @cached_property
    def weight(self) -> np.ndarray:
        """1 / sigma, 0 where nothing was read."""
        return 1.0 / self.sigma

    @cached_property
    def columns(self) -> np.ndarray:
        """The two columns of the groups' inclination."""
        return np.flatnonzero(self.grouped)

    @cached_property
    def pair(self) -> slice:
        """The same as a slice: they stand together."""
        return slice(self.columns[0], self.columns[-1] + 1)

    @cached_property
    def inside(self) -> np.ndarray:
        """Configurations that belong to a group."""
        return np.flatnonzero(self.group >= 0)

    @cached_property
    def order(self) -> np.ndarray:
        """Configurations that belong to a group, group after group."""
        order = np.argsort(self.group, kind="stable")
        return order[len(order) - len(self.inside) :]

    @cached_property
    def places(self) -> np.ndarray:
        """Number of the group of each configuration in `order`."""
        return self.group[self.order]

    @cached_property
    def begins(self) -> np.ndarray:
        """Where each group begins in `order`."""
        return np.searchsorted(self.places, np.arange(self.groups))

    @property
    def groups(self) -> int:
        return len(self.first)

    @property
    def count(self) -> int:
        """Independent readings: those taken less the unknown inclination of each group."""
        return int(self.taken.sum()) - 2 * self.groups


def build_readings(
    model: ConfigurationModel, measurements: Measurements, estimated: Mapping[str, float]
) -> Readings:
    """Gather the readings, each over its standard deviation. One that is not given is that
    `estimated` for its kind; without, as large as those that are given (their median, angles times
    the size), a length unit where none is: otherwise readings without one would count for nothing
    beside those of an instrument that is known.
    """
    channels = measurements.channels(model.mechanism)
    units = [1.0 / model.size if o.angular else 1.0 for o, _ in channels]
    stated = [estimated.get(o.key) if r.sigma is None else r.sigma for o, r in channels]
    given = [
        np.ravel(sigma) / unit
        for unit, sigma in zip(units, stated, strict=True)
        if sigma is not None
    ]
    usual = float(np.nanmedian(np.hstack(given))) if given else 1.0
    table, sigma = [np.zeros((len(measurements), 0))], [np.zeros((len(measurements), 0))]
    for unit, own, (_, reading) in zip(units, stated, channels, strict=True):
        values = 0.0 * reading.values[:, :3] if reading.is_orientation else reading.values
        table.append(values)
        sigma.append(np.full(values.shape, usual * unit if own is None else own))
    group, first = measurements.grouping
    return Readings(
        values=np.hstack(table),
        sigma=np.where(np.isfinite(np.hstack(table)), np.hstack(sigma), np.inf),
        turning=np.array(
            [o.angular and o.kind != "orientation" for o in model.channels for _ in o.components],
            dtype=bool,
        ),
        grouped=model.grouped,
        group=group,
        first=first,
        known=all(reading.sigma is not None for _, reading in channels),
    )


class Linearised(NamedTuple):
    """Residuals r (n, K) over their standard deviations, 0 where nothing was read; dr/dp (m, P) and
    r (m,) of all configurations, or, of many, the triangle of their QR factorisation, so that |r +
    J d|^2 is the same for all d.
    """

    residuals: np.ndarray
    matrix: np.ndarray
    vector: np.ndarray

    @staticmethod
    def of(residuals: np.ndarray, jacobian: np.ndarray) -> Linearised:
        """All configurations, with dr/dp (n, K, P)."""
        matrix = jacobian.reshape(-1, jacobian.shape[2])
        return Linearised(residuals, matrix, residuals.reshape(-1))


def linearise(
    form: Form,
    readings: Readings,
    h: np.ndarray,
    h_p: np.ndarray,
    covariance: np.ndarray | None = None,
) -> Linearised:
    """Form residuals and derivatives, W (h - m - G g) with g that minimises its square in each
    group; `covariance` (n, K, K) is that of joint noise for maximum likelihood, else W is 1 /
    sigma.
    """
    gap, whiten = deviations(readings, h), None
    if form == "differences":
        return _differences(readings, gap, h_p)
    if form != "means" and covariance is not None:
        whiten = whitening(readings, noise_of(readings, covariance))
    values = np.concatenate([gap[:, :, None], h_p], axis=2)
    if readings.groups:
        precise = np.zeros((*gap.shape, 2))
        if whiten is None:
            precise[:, readings.columns, [0, 1]] = readings.weight[:, readings.columns] ** 2
        else:
            precise = whiten.transpose(0, 2, 1) @ whiten[:, :, readings.columns]
        take_means(readings, values, precise)
    values = readings.weight[:, :, None] * values if whiten is None else whiten @ values
    return Linearised.of(values[:, :, 0], values[:, :, 1:])


def deviations(readings: Readings, h: np.ndarray) -> np.ndarray:
    """Subtract readings: h - m (n, K), angles by the shorter way; in a group from its first
    configuration. 0 where nothing was read.
    """
    gap = np.where(readings.taken, h - np.nan_to_num(readings.values), 0.0)
    if readings.groups:
        first = readings.first[readings.group[readings.inside]]
        gap[readings.inside, readings.pair] -= h[first, readings.pair]
    return np.where(readings.turning & (np.abs(gap) > np.pi), wrapped(gap), gap)


def group_sum(readings: Readings, values: np.ndarray) -> np.ndarray:
    """Sum over the configurations of each group: (n, ...) to (groups, ...)."""
    return np.add.reduceat(values[readings.order], readings.begins, axis=0)


def neighbours(readings: Readings) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs (earlier, later) of neighbours in each group."""
    pairs = np.flatnonzero(np.diff(readings.places) == 0)
    return readings.order[pairs], readings.order[pairs + 1]


def _differences(readings: Readings, gap: np.ndarray, h_p: np.ndarray) -> Linearised:
    """Each configuration but the first of its group holds its difference from the one before it."""
    residuals, jacobian = readings.weight * gap, readings.weight[:, :, None] * h_p
    earlier, later = (np.ix_(rows, readings.columns) for rows in neighbours(readings))
    s = 1.0 / np.hypot(readings.sigma[earlier], readings.sigma[later])
    residuals[:, readings.columns], jacobian[:, readings.columns] = 0.0, 0.0
    residuals[later] = s * (gap[later] - gap[earlier])
    jacobian[later] = s[:, :, None] * (h_p[later] - h_p[earlier])
    return Linearised.of(residuals, jacobian)


def noise_of(readings: Readings, covariance: np.ndarray, factor: float = 1.0) -> np.ndarray:
    """Return S (n, K, K), the covariance of readings with that of joint noise, 1 for what was not
    read; `factor` scales the variances stated.
    """
    taken = readings.taken
    both = taken[:, :, None] & taken[:, None, :]
    variance = np.where(taken, factor * readings.sigma**2, 1.0)
    return np.where(both, factor * covariance, 0.0) + variance[:, :, None] * np.eye(taken.shape[1])


def whitening(readings: Readings, noise: np.ndarray) -> np.ndarray:
    """Return L^-1 (n, K, K) with L L^T = S; rows of readings not taken are zero. Not finite where
    S is not.
    """
    try:
        root = np.linalg.cholesky(noise)
        return np.linalg.inv(root) * readings.taken[:, :, None]
    except np.linalg.LinAlgError:
        return np.full(noise.shape, np.nan)


def take_means(readings: Readings, values: np.ndarray, precise: np.ndarray) -> np.ndarray:
    """Take from values (n, K, w) the inclination that fits those of each group best; `precise` is
    S^-1 G (n, K, 2), zero for configurations that do not tell it. Return G^T S^-1 G (groups, 2, 2).
    """
    across, inside = precise.transpose(0, 2, 1), readings.inside
    information = group_sum(readings, across[:, :, readings.columns])
    means = np.linalg.solve(information, group_sum(readings, across @ values))
    values[inside, readings.pair] -= means[readings.group[inside]]
    return information
