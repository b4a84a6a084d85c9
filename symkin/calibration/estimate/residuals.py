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

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configuration_model import ConfigurationModel
from symkin.calibration.options import FORMS as FORMS
from symkin.calibration.options import Form as Form
from symkin.computed_once import cached_property
from symkin.spatial.rotation import wrapped

_ROUNDING_RESIDUAL = 1e-9
"""Residuals below this, in radians or of the size, are rounding and not errors of an instrument."""


def only_rounding(values: np.ndarray | float, unit: float) -> bool:
    """Tell whether residuals are no more than what arithmetic leaves; `unit` is 1 for angles
    (radians), the size for lengths.
    """
    return bool(np.all(np.abs(values) < _ROUNDING_RESIDUAL * unit))


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
        return np.asarray(np.isfinite(self.sigma))

    @cached_property
    def weight(self) -> np.ndarray:
        """1 / sigma, 0 where nothing was read."""
        return np.asarray(1.0 / self.sigma)

    @cached_property
    def targets(self) -> np.ndarray:
        return np.asarray(np.nan_to_num(self.values))

    @cached_property
    def columns(self) -> np.ndarray:
        """The two columns of the groups' inclination."""
        return np.flatnonzero(self.grouped)

    @cached_property
    def inside(self) -> np.ndarray:
        """Configurations that belong to a group."""
        return np.flatnonzero(self.group >= 0)

    @cached_property
    def order(self) -> np.ndarray:
        """Configurations that belong to a group, group after group."""
        return self.inside[np.argsort(self.group[self.inside], kind="stable")]

    @cached_property
    def places(self) -> np.ndarray:
        """Number of the group of each configuration in `order`."""
        return np.asarray(self.group[self.order])

    @cached_property
    def begins(self) -> np.ndarray:
        """Where each group begins in `order`."""
        return np.searchsorted(self.places, np.arange(self.groups))

    @cached_property
    def shares(self) -> np.ndarray:
        """Weights of the configurations in `order` in the means of their groups' alpha and beta (2,
        members), each group's sum 1.
        """
        squares = self.weight[self.order][:, self.columns] ** 2
        return np.asarray((squares / np.add.reduceat(squares, self.begins, axis=0)[self.places]).T)

    @property
    def groups(self) -> int:
        return len(self.first)

    @property
    def count(self) -> int:
        """Independent readings: those taken less the unknown inclination of each group."""
        return int(np.sum(self.taken)) - 2 * self.groups


def build_readings(model: ConfigurationModel, measurements: Measurements) -> Readings:
    count, size = len(measurements), model.closure.characteristic_length
    values, sigma, known = [], [], True
    others = {o.name for o in model.read}
    for kind in dict.fromkeys(k for k, _ in model.columns if k != "distance" and k not in others):
        width = sum(k == kind for k, _ in model.columns)
        if kind == "group":
            read = np.where(_in_group(measurements)[:, None], 0.0, np.nan) * np.ones(2)
        elif kind == "orientation":
            read = 0.0 * getattr(measurements, kind)[:, :3]
        else:
            read = getattr(measurements, kind)
        given = measurements.sigma(kind)
        known = known and given is not None
        unit = np.full((count, width), 1.0 if kind == "position" else 1.0 / size)
        values.append(read)
        sigma.append(unit if given is None else given)
    for d in measurements.distances:
        known = known and d.sigma is not None
        values.append(d.values[:, None])
        sigma.append(
            np.broadcast_to(np.asarray(1.0 if d.sigma is None else d.sigma, dtype=float), (count,))[
                :, None
            ]
        )
    for o, reading in zip(model.read, measurements.readings, strict=True):
        known = known and reading.sigma is not None
        unit = np.full((count, len(o.components)), 1.0 / size if o.angular else 1.0)
        values.append(0.0 * reading.values[:, :3] if o.kind == "orientation" else reading.values)
        sigma.append(unit if reading.sigmas is None else reading.sigmas)
    table = np.hstack(values) if values else np.zeros((count, 0))
    spread = np.where(np.isfinite(table), np.hstack(sigma) if sigma else table, np.inf)
    grouped = np.array([kind == "group" for kind, _ in model.columns], dtype=bool)
    group, first = _groups(measurements)
    return Readings(
        values=table,
        sigma=spread,
        turning=model.turning,
        grouped=grouped,
        group=group,
        first=first,
        known=known,
    )


def _in_group(measurements: Measurements) -> np.ndarray:
    return _groups(measurements)[0] >= 0


def _groups(measurements: Measurements) -> tuple[np.ndarray, np.ndarray]:
    """Number the groups consecutively, and find the first configuration of each; a group of one
    configuration counts as none.
    """
    if measurements.groups is None:
        return np.full(len(measurements), -1), np.zeros(0, dtype=int)
    numbers, counts = np.unique(measurements.groups[measurements.groups >= 0], return_counts=True)
    kept = {int(number): k for k, number in enumerate(numbers[counts > 1])}
    group = np.array([kept.get(int(g), -1) for g in measurements.groups])
    return group, np.array([int(np.argmax(group == k)) for k in range(len(kept))], dtype=int)


@dataclass(frozen=True, eq=False)
class Linearised:
    """Residuals r (n, K) over their standard deviations, 0 where nothing was read, and dr/dp (n, K,
    P).
    """

    residuals: np.ndarray
    jacobian: np.ndarray

    @property
    def vector(self) -> np.ndarray:
        return self.residuals.reshape(-1)

    @property
    def matrix(self) -> np.ndarray:
        return self.jacobian.reshape(-1, self.jacobian.shape[2])


@dataclass(frozen=True, eq=False)
class Condensed(Linearised):
    """Residuals r (n, K) of many configurations; in place of dr/dp and r the triangle of their QR
    factorisation, so that |r + J d|^2 is the same for all d.
    """

    right: np.ndarray = field(kw_only=True)

    @property
    def vector(self) -> np.ndarray:
        return self.right


def linearise(
    form: Form,
    readings: Readings,
    h: np.ndarray,
    h_p: np.ndarray,
    covariance: np.ndarray | None = None,
) -> Linearised:
    """Form residuals and derivatives; `covariance` (n, K, K) is that of joint noise for maximum
    likelihood.
    """
    gap = deviations(readings, h)
    if form == "differences":
        return _differences(readings, gap, h_p)
    if form == "means" or covariance is None:
        return _means(readings, gap, h_p)
    return _likelihood(readings, gap, h_p, whitening(readings, covariance))


def deviations(readings: Readings, h: np.ndarray) -> np.ndarray:
    """Subtract readings: h - m (n, K), angles by the shorter way; in a group from its first
    configuration. 0 where nothing was read.
    """
    gap = np.where(readings.taken, h - readings.targets, 0.0)
    if readings.groups:
        reference = h[readings.first[readings.group[readings.inside]]]
        for column in readings.columns:
            gap[readings.inside, column] -= reference[:, column]
    return np.where(readings.turning & (np.abs(gap) > np.pi), wrapped(gap), gap)


def group_sum(readings: Readings, values: np.ndarray) -> np.ndarray:
    """Sum over the configurations of each group: (n, ...) to (groups, ...)."""
    return np.asarray(np.add.reduceat(values[readings.order], readings.begins, axis=0))


def _means(readings: Readings, gap: np.ndarray, h_p: np.ndarray) -> Linearised:
    if readings.groups:
        h_p = h_p.copy()
        order, places, begins = readings.order, readings.places, readings.begins
        for column, share in zip(readings.columns, readings.shares, strict=True):
            values, slopes = gap[order, column], h_p[order, column]
            gap[order, column] = values - np.add.reduceat(share * values, begins)[places]
            h_p[order, column] = slopes - np.add.reduceat(share[:, None] * slopes, begins)[places]
    return Linearised(readings.weight * gap, readings.weight[:, :, None] * h_p)


def neighbours(readings: Readings) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs (earlier, later) of neighbours in each group."""
    order = [np.flatnonzero(readings.group == k) for k in range(readings.groups)]
    pairs = [(a, b) for members in order for a, b in pairwise(members)]
    return np.array([a for a, _ in pairs], dtype=int), np.array([b for _, b in pairs], dtype=int)


def _differences(readings: Readings, gap: np.ndarray, h_p: np.ndarray) -> Linearised:
    """Each configuration but the first of its group holds its difference from the one before it."""
    residuals, jacobian = readings.weight * gap, readings.weight[:, :, None] * h_p
    before, after = neighbours(readings)
    for column in np.flatnonzero(readings.grouped):
        s = 1.0 / np.hypot(readings.sigma[before, column], readings.sigma[after, column])
        residuals[:, column], jacobian[:, column] = 0.0, 0.0
        residuals[after, column] = s * (gap[after, column] - gap[before, column])
        jacobian[after, column] = s[:, None] * (h_p[after, column] - h_p[before, column])
    return Linearised(residuals, jacobian)


def whitening(readings: Readings, covariance: np.ndarray) -> np.ndarray:
    """Return L^-1 (n, K, K) with L L^T = S; rows of readings not taken are zero. Not finite where
    the covariance is not.
    """
    taken = readings.taken
    both = taken[:, :, None] & taken[:, None, :]
    spread = np.where(taken, readings.sigma, 1.0) ** 2
    s = np.where(both, covariance, 0.0) + spread[:, :, None] * np.eye(taken.shape[1])
    try:
        return np.asarray(np.linalg.inv(np.linalg.cholesky(s)) * taken[:, :, None])
    except np.linalg.LinAlgError:
        return np.full(s.shape, np.nan)


def _likelihood(
    readings: Readings, gap: np.ndarray, h_p: np.ndarray, whiten: np.ndarray
) -> Linearised:
    """Form W (h - m - G g) with g that minimises its square in each group."""
    residuals = (whiten @ gap[:, :, None])[:, :, 0]
    jacobian = whiten @ h_p
    if not readings.groups:
        return Linearised(residuals, jacobian)
    basis = group_basis(readings, whiten)
    both = np.concatenate([residuals[:, :, None], jacobian], axis=2)
    inside, place = readings.group >= 0, readings.group
    information = group_sum(readings, basis.transpose(0, 2, 1) @ basis)
    means = np.linalg.solve(information, group_sum(readings, basis.transpose(0, 2, 1) @ both))
    both -= np.where(inside[:, None, None], basis @ means[place], 0.0)
    return Linearised(both[:, :, 0], both[:, :, 1:])


def group_basis(readings: Readings, whiten: np.ndarray) -> np.ndarray:
    """Return W G (n, K, 2): how the two unknown inclinations of its group enter a configuration's
    residuals.
    """
    basis = whiten[:, :, np.flatnonzero(readings.grouped)].copy()
    basis[readings.group < 0] = 0.0
    return basis
