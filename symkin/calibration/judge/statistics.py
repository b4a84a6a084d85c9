"""Compute the statistics of a fit: the linear model of its readings, chi-square and F, predictions,
covariance, curvature.

The whitened residuals of all readings (joint noise included, see `residuals`) are e = (1 - Q Q^T) r
with Q an orthonormal basis of what the fit may absorb: the unknown inclination of each group and
the parameters' columns. The part of the groups is block diagonal and is kept as two columns, each
group's own rows of them; the rest, orthogonal to it, is dense and as wide as there are parameters.
In the linear range |e|^2 has the chi-square distribution with as many degrees of freedom as there
are readings left, whichever form of the residuals was minimised.

Readings m at configurations that took no part in a fit differ from its model h by errors of
covariance S + J C J^T: S of their noise (that of joints included), J (n, K, P) their slopes by the
scaled parameters with the configurations following, C (P, P) the covariance of these. The unknown
inclination of a group is the weighted mean of the members that tell it; where another is compared
with it, the mean's own noise counts, too.

Whether the linear model holds within the standard deviations is measured by curvature. A step of
one standard deviation along a combination of parameters that the readings determine least moves the
residuals by (dr/dp) step + d. Least squares takes d for a change of the parameters, (dr/dp)^+ d.
Where that is not small against a parameter's standard deviation, the latter is no measure of its
error (curvature by the parameters, Bates and Watts 1980).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from symkin.calibration.data.measurements import Measurements
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import nearest_rows, solve_configurations
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import (
    build_readings,
    deviations,
    group_sum,
    neighbours,
    noise_of,
    take_means,
    whitening,
)
from symkin.calibration.estimate.state import (
    State,
    Told,
    evaluate,
    evaluate_at,
    joint_covariance,
    state_after,
    told_directions,
)
from symkin.computed_once import cached_property

_BLOCK_ROWS = 20_000
"""Rows that are multiplied at once where there are many."""

_DOUBLE_BITS = 53
"""Bits of tail probabilities."""
SIGNIFICANCE = 1e-3
"""Tail probability on either side of chi-square beyond which the stated noise does not explain the
residuals.
"""
_LEAST_FREEDOM = 1e-12
"""A shift of which the fit leaves no more than this share (of its square) is absorbed whole, and a
column of which others leave no more depends on them.
"""

DOUBTFUL_CURVATURE = 0.5
"""Share of its standard deviation from which a parameter's is called doubtful."""
_WEAKEST_DIRECTIONS = 3
"""Directions that are tried: for better determined ones curvature falls by the square of their
deviation.
"""
_BETTER_SHARE = 0.8
"""Share of the configurations, those that fit better, by which fits are compared: single bad rows
do not count.
"""


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Whitened residuals e (N,) after projection, N = n K; `group_columns` (N, 2), the orthonormal
    columns of each row's group, whose number is `group` (N,), -1 for none; `parameter_columns` (N,
    k), the rest of the basis; how many parameters were `fitted`, those that the prior decides by a
    share; which rows hold a reading (N,), and the transformation W (n, K, K) that whitened them.
    Tolerances that are stated stand in rows after those. `within_reach` is the square that the
    projection to the parameters' columns took away: at a minimum nothing, but for a form of
    residuals that weighs otherwise than joint noise and correlation ask.
    """

    residuals: np.ndarray
    group_columns: np.ndarray
    group: np.ndarray
    parameter_columns: np.ndarray
    fitted: float
    taken: np.ndarray
    whiten: np.ndarray
    within_reach: float = 0.0

    @cached_property
    def degrees(self) -> int:
        groups = int(self.group.max(initial=-1)) + 1
        return round(int(self.taken.sum()) - 2 * groups - self.fitted)

    @property
    def chi_square(self) -> float:
        return float(self.residuals @ self.residuals)

    @property
    def absorbed(self) -> np.ndarray:
        """Share (N,) of a unit shift of each reading that the fit absorbs: the diagonal of Q
        Q^T.
        """
        return np.sum(self.group_columns**2, axis=1) + np.sum(self.parameter_columns**2, axis=1)

    def freedom(self, rows: np.ndarray) -> np.ndarray:
        """Restrict (1 - Q Q^T) to some rows (..., w): what of a shift of these readings the fit
        cannot absorb, (..., w, w).
        """
        own, shared = self.group_columns[rows], self.parameter_columns[rows]
        together = self.group[rows][..., :, None] == self.group[rows][..., None, :]
        absorbed = shared @ np.swapaxes(shared, -1, -2)
        absorbed += np.where(together, own @ np.swapaxes(own, -1, -2), 0.0)
        return self.taken[rows][..., None] * np.eye(rows.shape[-1]) - absorbed

    def without(self, rows: np.ndarray) -> LinearModel:
        """Let the readings of these rows be free: their shift is one more unknown."""
        shift = -self.parameter_columns @ self.parameter_columns[rows].T
        own = self.group_columns @ self.group_columns[rows].T
        shift -= np.where(self.group[:, None] == self.group[rows], own, 0.0)
        shift[rows, np.arange(len(rows))] += self.taken[rows]
        # the columns of a projector are as long as its diagonal block says
        values, vectors = np.linalg.eigh(self.freedom(rows))
        left = values > _LEAST_FREEDOM
        extra = shift @ (vectors[:, left] / np.sqrt(values[left]))
        return replace(
            self,
            residuals=self.residuals - extra @ (extra.T @ self.residuals),
            parameter_columns=np.hstack([self.parameter_columns, extra]),
            fitted=self.fitted + extra.shape[1],
        )


def linear_model(
    problem: CalibrationProblem, state: State, told: Told | None = None
) -> LinearModel:
    """Linearise all readings at a state with closed configurations, over the directions told."""
    readings, told = problem.readings, told or told_directions(problem, state)
    free = told.columns[:, (told.ratios > 1.0) | problem.is_stated]
    # the parameters from nominal over the tolerances stated, which are readings of them
    stated = np.isfinite(problem.prior) & problem.is_stated
    known, by_known = problem.over_prior(state.p)[stated], np.diag(1.0 / problem.prior)[stated]
    shape, count, width = readings.values.shape, readings.values.size, free.shape[1]
    residuals = np.concatenate([np.zeros(count), known])
    columns = np.vstack([np.zeros((count, width)), by_known @ free])
    own, whiten = np.zeros((len(residuals), 2)), np.zeros((*shape, shape[1]))
    for rows, part in problem.parts:
        made = predict_readings(part, state.p, state.z[rows], free)
        w = whiten[rows] = whitening(part.readings, made.noise)
        own[:count].reshape(*shape, 2)[rows] = w @ made.of_mean
        residuals[:count].reshape(shape)[rows] = (w @ made.errors[:, :, None])[:, :, 0]
        columns[:count].reshape(*shape, width)[rows] = w @ made.spread
    columns = _basis_in_place(columns)
    along = columns.T @ residuals
    return LinearModel(
        residuals=residuals - columns @ along,
        group_columns=own,
        group=np.concatenate([np.repeat(readings.group, shape[1]), np.full(len(known), -1)]),
        parameter_columns=columns,
        fitted=float(columns.shape[1] if problem.is_stated else told.shares.sum()),
        taken=np.concatenate([readings.taken.reshape(-1), np.ones(len(known), dtype=bool)]),
        whiten=whiten,
        within_reach=float(along @ along),
    )


def _basis_in_place(columns: np.ndarray) -> np.ndarray:
    """Overwrite columns (N, k), block by block, by an orthonormal basis: with V D V^T their squares
    at unit length, columns V D^-1/2; what rounding leaves of that is taken away by its own.
    Directions that are told have columns nearly at right angles.
    """
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    for _ in range(2):
        values, vectors = np.linalg.eigh(columns.T @ columns)
        kept = values > _LEAST_FREEDOM * values.max(initial=0.0)
        factor, width = vectors[:, kept] / np.sqrt(values[kept]), kept.sum()
        for block in (columns[k : k + _BLOCK_ROWS] for k in range(0, len(columns), _BLOCK_ROWS)):
            block[:, :width] = block @ factor
        columns = columns[:, :width]
    return columns


def chi_square_tail(value: float, degrees: int, left: float | None = None) -> float:
    """Return the probability that chi-square with `degrees` of freedom exceeds `value`: Q(degrees /
    2, value / 2); where the variance is known by `left` degrees of freedom alone, that F(degrees,
    left) exceeds value / degrees: I_x(left / 2, degrees / 2), x = left / (left + value).
    """
    from flint import arb

    from symkin.numeric.balls import precision

    if degrees <= 0 or value <= 0.0 or (left is not None and left <= 0):
        return 1.0
    with precision(_DOUBLE_BITS):
        half = arb(degrees) / 2
        if left is None:
            return float(arb(0.5 * value).gamma_upper(half, 1))
        return float(arb(left / (left + value)).beta_lower(arb(left) / 2, half, 1))


# --- predictions ----------------------------------------------------------------------------------


def close_others(
    problem: CalibrationProblem, state: State, measurements: Measurements, seed: int = 0
) -> tuple[CalibrationProblem, np.ndarray, np.ndarray]:
    """Close other configurations at the parameters of a fit, from their neighbours' solutions: the
    problem of those that are solved (where there are none, of the fit), their unknown coordinates,
    and which they are (n,).
    """
    model = build_model(problem.mechanism, measurements, problem.names)
    near = state.z[nearest_rows(problem.joints, measurements.joints, 1)[:, 0]]
    found = solve_configurations(model, measurements, state.p, z=near, seed=seed)
    if not found.solved.any():
        return problem, found.z[:0], found.solved
    some = measurements.subset(found.solved)
    readings = build_readings(model, some, problem.estimated)
    there = replace(problem, measurements=some, model=model, readings=readings)
    return there, found.z[found.solved], found.solved


def covariance_root(covariance: np.ndarray, problem: CalibrationProblem) -> np.ndarray:
    """Return L (P, k) with L L^T the covariance of the scaled free parameters, which come first."""
    scales = problem.model.scales
    free = covariance[: len(scales), : len(scales)] / np.outer(scales, scales)
    values, vectors = np.linalg.eigh(free)
    return vectors * np.sqrt(np.maximum(values, 0.0))


class Prediction(NamedTuple):
    """The model less the readings at n configurations (n, K), 0 where nothing was read, with the
    noise S (n, K, K) of each, 1 there, how what the fit does not know spreads them, J L (n, K, k),
    and how the noise of the mean inclination of its group does, G (n, K, 2); which members tell
    that mean (n,).
    """

    errors: np.ndarray
    noise: np.ndarray
    spread: np.ndarray
    of_mean: np.ndarray
    telling: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """S + J C J^T of each configuration (n, K, K), with G G^T where it tells no mean."""
        own = np.where(self.telling[:, None, None], 0.0, self.of_mean)
        both = np.concatenate([self.spread, own], axis=2)
        return self.noise + both @ both.transpose(0, 2, 1)

    def chi_square(self, rows: np.ndarray) -> float:
        """Return e^T (S + J C J^T)^-1 e over some configurations together: with e and M = J L
        whitened by S, |e|^2 - e^T M (1 + M^T M)^-1 M^T e.
        """
        root = np.linalg.cholesky(self.noise[rows])
        both = np.linalg.solve(root, np.dstack([self.errors[rows], self.spread[rows]]))
        both = both.reshape(-1, both.shape[2])
        e, m = both[:, 0], both[:, 1:]
        within = np.eye(m.shape[1]) + m.T @ m
        return float(e @ e - (m.T @ e) @ np.linalg.solve(within, m.T @ e))


def predict_readings(
    problem: CalibrationProblem,
    p: np.ndarray,
    z: np.ndarray,
    root: np.ndarray,
    factor: float = 1.0,
    telling: np.ndarray | None = None,
) -> Prediction:
    """Predict the readings of a problem at parameters p and configurations z; `root` is that of the
    parameters' covariance, `factor` scales the variances stated, and `telling` (n,) are the members
    that tell the inclination of their group, all in a group without any.
    """
    readings = problem.readings
    e, taken, width = evaluate_at(problem, p, z), readings.taken, readings.values.shape[1]
    noise = noise_of(readings, joint_covariance(problem, p, z), factor)
    gap = deviations(readings, e.readings)
    values = np.where(taken[:, :, None], np.dstack([gap, e.slopes @ root]), 0.0)
    inside = readings.group >= 0
    told, of_mean = inside if telling is None else inside & telling, np.zeros((*gap.shape, 2))
    if readings.groups:
        told = told | (inside & ~group_sum(readings, told)[readings.group])
        turn = np.eye(width)[:, readings.columns]
        precise = np.where(told[:, None, None], np.linalg.solve(noise, turn), 0.0)
        information = take_means(readings, values, precise)
        own = np.linalg.inv(np.linalg.cholesky(information)).transpose(0, 2, 1)
        of_mean[readings.inside, readings.pair] = own[readings.group[readings.inside]]
    return Prediction(values[:, :, 0], noise, values[:, :, 1:], of_mean, told | ~inside)


# --- covariance -----------------------------------------------------------------------------------


def covariance(problem: CalibrationProblem, state: State, told: Told | None = None) -> np.ndarray:
    """Return the covariance (P, P) of the free parameters (not scaled) for the form of residuals
    that was minimised, in variances of the residuals: A S A^T with dp = A d(readings), S the
    covariance of readings with joint noise, and what the prior leaves open where it decides; along
    directions of which the readings tell nothing 0.
    """
    noise = joint_covariance(problem, state.p, state.z)
    problem = replace(problem, noise=noise)
    told = told or told_directions(problem, evaluate(problem, state.p, state.z))
    scaled = problem.model.scales[:, None] * told.columns
    left = scaled * ((1.0 - told.shares) / told.weight)
    total = left @ left.T
    for rows, part in problem.parts:
        near = evaluate(part, state.p, state.z[rows])
        moved = (scaled * told.gains) @ (near.linearised.matrix @ told.columns).T
        if problem.form == "maximum likelihood":  # residuals of covariance 1
            total += moved @ moved.T
            continue
        taken, sigma = part.readings.taken, part.readings.sigma
        gain = _gain(part, moved.reshape(len(scaled), *taken.shape)).transpose(1, 0, 2)
        variance = np.where(taken, sigma, 0.0)[:, :, None] ** 2
        s = noise[rows] + variance * np.eye(taken.shape[1])
        total += np.sum(gain @ s @ gain.transpose(0, 2, 1), axis=0)
    return total


def _gain(problem: CalibrationProblem, inverse: np.ndarray) -> np.ndarray:
    """dp per reading (P, n, K) from dp per residual: the transpose of how readings make
    residuals.
    """
    readings = problem.readings
    gain = inverse * np.where(readings.taken, 1.0 / readings.sigma, 0.0)
    if problem.form != "differences":
        return gain
    before, after = neighbours(readings)
    for column in readings.columns:
        s = 1.0 / np.hypot(readings.sigma[before, column], readings.sigma[after, column])
        gain[:, :, column] = 0.0
        gain[:, after, column] += s * inverse[:, after, column]
        gain[:, before, column] -= s * inverse[:, after, column]
    return gain


def curvature(
    problem: CalibrationProblem, state: State, told: Told | None = None, spread: float = 1.0
) -> np.ndarray:
    """Return for each free parameter (P,) the largest change that curvature makes of it along the
    weakest directions, as a share of its standard deviation; inf where configurations have no
    solution there, 0 where a closure leaves rows to the parameters. `spread` scales the stated
    variances.
    """
    if state.leftover is not None:
        return np.zeros(len(problem.names))
    told = told or told_directions(problem, state)
    problem = replace(problem, noise=joint_covariance(problem, state.p, state.z))
    free = told.ratios > 1.0
    # along one of them the residuals move by one standard deviation
    units = np.sqrt(spread) / told.weight * told.columns[:, free] / told.ratios[free]
    steps = [sign * step for step in units.T[-_WEAKEST_DIRECTIONS:] for sign in (1.0, -1.0)]
    pulls = np.zeros((len(problem.names), len(steps)))
    for rows, part in problem.parts:
        near = evaluate(part, state.p, state.z[rows])
        here = near.linearised
        for k, step in enumerate(steps):
            with np.errstate(all="ignore"):
                there = state_after(part, near, step)
            # r(p + step) - r(p) - (dr/dp) step, configurations closed again, where they close
            after = np.full_like(here.vector, np.nan) if there is None else there.linearised.vector
            pulls[:, k] += here.matrix.T @ (after - here.vector - here.matrix @ step)
    sigma, change = np.linalg.norm(units, axis=1), np.abs(units @ (units.T @ pulls)) / spread
    largest = np.where(np.isfinite(change), change, np.inf).max(axis=1, initial=0.0)
    return np.divide(largest, sigma, out=np.zeros_like(sigma), where=sigma > 0)


def misfits(off: np.ndarray, kinds: Sequence[str]) -> dict[str, float]:
    """Return by kind how far readings are off: the root mean square of its columns of `off` (n, K),
    NaN where nothing was read, over the better four fifths of the configurations that hold any;
    nothing of a kind that none holds.
    """
    found, own = dict[str, float](), np.array(kinds)
    for kind in dict.fromkeys(kinds):
        part = off[:, own == kind]
        part = part[np.isfinite(part).any(axis=1)]
        if len(part):
            found[kind] = rms_of_better_part(np.nanmean(part**2, axis=1))
    return found


def rms_of_better_part(squares: np.ndarray) -> float:
    """Return the root of the mean of the smaller four fifths of some squares (n,)."""
    kept = np.sort(squares)[: max(1, math.ceil(_BETTER_SHARE * len(squares)))]
    return float(np.sqrt(kept.mean())) if len(kept) else 0.0
