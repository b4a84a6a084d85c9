"""Linearise the least-squares problem at parameters and configurations, find the steps that closure
and readings allow, and set the readings beside the prior.

Poses couple to the parameters only (block-arrow structure): dz = -F_z^+ (F + F_p dp) at each
configuration, so that its readings become h - A F + (h_p - A F_p) dp with A = h_z F_z^+, the
implicit derivative, and only p is left. Rows that the unknown coordinates cannot meet
(overconstrained mechanisms) are left over: they constrain p.

One unit of a parameter beside the prior is one standard deviation of it. A singular value of the
Jacobian over the prior's weight w says how many times better than the prior the readings tell a
direction: its standard deviation by the readings is the prior's over that. Above `WELL_TOLD` the
readings decide; below `UNTOLD` they say nothing; between, both do.

What a group's readings cannot tell shows in the null space of their Jacobian only where the group's
inclinations agree: a turn of the platform frame by w moves each deviation r from the group's mean
by w x r, which no rank should count. Ranks are therefore judged at the nearest readings without
error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from symkin.calibration.estimate.configuration_model import Evaluation, solve_systems
from symkin.calibration.estimate.configurations import (
    SOLVED_TOLERANCE,
    Closing,
    determinant_signs,
    newton_configurations,
)
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import Linearised, linearise
from symkin.numeric.linear_algebra import largest_of
from symkin.numeric.tolerances import RANK_TOLERANCE

PREDICTION_TOLERANCE = 1e-4
"""A predicted configuration off its closure by less than this (of the size) is corrected to first
order in the same evaluation.
"""
CONSTRAINT_ROUNDING = 1e-9
"""Singular values of the rows left over (per length unit of scaled parameters) up to this are
rounding: such rows bind nothing.
"""
_RESTORATION_STEPS = 2
"""Steps that bring the rows left over back to zero after a step: they are not linear, and their
penalty would forbid it.
"""

_LONG_COLUMN_RATIO = 30.0
"""Columns up to so many times as long as the median one stay as they are where rank is judged;
longer ones are scaled to that length.
"""
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


@dataclass(frozen=True, eq=False)
class State:
    """Parameters p (free, unscaled), unknown coordinates z (n, width), residuals and dr/dp (per
    scaled parameter), the values at single configurations (None where they are many, and made again
    part by part), the closure's pending correction (n, f), rows left over and their derivative (n,
    m, P), signs of det F_z.
    """

    problem: CalibrationProblem
    p: np.ndarray
    z: np.ndarray
    linearised: Linearised
    values: Evaluation | None
    pending: np.ndarray
    leftover: tuple[np.ndarray, np.ndarray] | None
    determinant_signs: np.ndarray

    def follow(self, step: np.ndarray) -> np.ndarray:
        """Tangent steps (n, f) that keep the configurations closed while the scaled parameters take
        a step.
        """
        moved = -self.pending
        for rows, part in self.problem.parts:
            e = self.values or evaluate_at(part, self.p, self.z[rows])
            moved[rows] -= solve_systems(e.rows_z, e.rows_p @ step[:, None])[:, :, 0]
        return moved

    def is_in_mode_of(self, other: State) -> bool:
        """Whether no configuration lies across a singularity from where it is in another state."""
        return np.array_equal(self.determinant_signs, other.determinant_signs)

    @property
    def cost(self) -> float:
        return float(np.dot(self.linearised.vector, self.linearised.vector))


def evaluate(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> State:
    """Evaluate closure and readings at (p, z), condensed to p."""
    if problem.is_large:
        return _evaluate_parts(problem, p, z)
    e = evaluate_at(problem, p, z)
    pending, readings, slopes, leftover = e.condensed()
    fit = linearise(problem.form, problem.readings, readings, slopes, problem.noise)
    return State(problem, p, z, fit, e, pending, leftover, determinant_signs(e.rows_z))


def evaluate_at(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> Evaluation:
    """Evaluate closure and readings at (p, z), without the condensation; of a large problem only
    part by part.
    """
    return problem.model.evaluate(z, problem.joints, p, problem.quaternions)


def readings_at(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Evaluate the readings (n, K) at (p, z), part by part."""
    made = np.zeros(problem.readings.values.shape)
    for rows, part in problem.parts:
        made[rows] = evaluate_at(part, p, z[rows]).readings
    return made


def joint_covariance(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the covariance (n, K, K) that joint noise gives the readings at (p, z): H_q
    diag(sigma_q^2) H_q^T, H_q = h_q - h_z F_z^+ F_q, part by part.
    """
    width, model = len(problem.model.columns), problem.model
    made, sigma = np.zeros((len(z), width, width)), problem.measurements.sigma("joint")
    if sigma is None:
        return made
    for rows, part in problem.parts:
        found = model.values("tangent", z[rows], part.joints, p, part.quaternions)
        _, rows_z, rows_q, _, readings_z, readings_q = found
        slopes = readings_z @ solve_systems(rows_z, rows_q) - readings_q
        by_joint = slopes * sigma[rows, None]
        made[rows] = by_joint @ by_joint.transpose(0, 2, 1)
    return made


def closed_state(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> State:
    """Evaluate the state with the closure met to rounding."""
    state = evaluate(problem, p, z)
    for _ in range(2):
        largest = largest_of(state.pending)
        if not 1e-15 * problem.size < largest < np.inf:
            break
        if largest > PREDICTION_TOLERANCE * problem.size:
            z, _ = newton_configurations(problem.model, z, problem.joints, p)
            state = evaluate(problem, p, z)
        state = evaluate(problem, p, problem.model.system.move(state.z, -state.pending))
    return state


def state_after(problem: CalibrationProblem, state: State, step: np.ndarray) -> State | None:
    """Take a step in p, configurations moved along; None where a direct problem has no solution
    there.
    """
    model = problem.model
    p = state.p + model.scales * step
    z = model.system.move(state.z, state.follow(step))
    trial = evaluate(problem, p, z)
    if not np.isfinite(trial.pending).all():
        return None
    furthest = largest_of(trial.pending)
    if furthest > PREDICTION_TOLERANCE * model.size:
        z, solved = newton_configurations(
            model, z, problem.joints, p, tolerance=1e2 * SOLVED_TOLERANCE
        )
        if not solved.all():
            return None
        trial = evaluate(problem, p, z)
    return trial if np.isfinite(trial.cost) else None


def restored_after(
    move: Callable[[State, np.ndarray], State | None], state: State, step: np.ndarray
) -> State | None:
    """Take a step by `move`, and meet the rows left over again; None where a configuration has no
    solution.
    """
    trial = move(state, step)
    for _ in range(_RESTORATION_STEPS):
        if trial is None or trial.leftover is None or not largest_of(trial.leftover[0]) > 0.0:
            break
        trial = move(trial, admissible_steps(trial, np.ones(len(step)))[1])
    return trial


def error_free_state(problem: CalibrationProblem, state: State) -> State:
    """Evaluate the state where the readings of each group agree: joint readings are moved least
    (with the unknown coordinates, angles times the size), so that the configurations close and
    every group has one inclination; where that is not reached they stay.
    """
    readings, inside, m = problem.readings, problem.readings.inside, problem.measurements
    first = np.arange(len(state.z))
    first[inside] = readings.first[readings.group[inside]]
    closing = Closing(problem.model, state.p, held=(), inclined=first)
    z, joints = state.z, m.joints
    if readings.groups:
        begin = np.hstack([joints, z])
        found, largest = closing.newton(begin, tolerance=SOLVED_TOLERANCE, longest=np.inf)
        # groups that no configuration can have, as under wrong labels, send the steps away
        if np.all(largest <= SOLVED_TOLERANCE):
            z, joints = closing.split(found)
    there = replace(problem.by_means, measurements=replace(m, joints=joints))
    return evaluate(there, state.p, z)


# --- many configurations --------------------------------------------------------------------------


def _evaluate_parts(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> State:
    """The same as `evaluate`, a part at a time: derivatives and residuals of each are joined to the
    triangle of those before.
    """
    width = len(problem.names)
    triangle, residuals = np.zeros((0, width + 1)), np.zeros(problem.readings.values.shape)
    pending, side = np.zeros((len(z), problem.model.system.freedom)), np.zeros(len(z))
    for rows, part in problem.parts:
        state = evaluate(part, p, z[rows])
        fit, pending[rows], side[rows] = state.linearised, state.pending, state.determinant_signs
        residuals[rows] = fit.residuals
        below = np.column_stack([fit.matrix, fit.vector])
        triangle = np.asarray(np.linalg.qr(np.vstack([triangle, below]), mode="r"))
    fit = Linearised(residuals, triangle[:, :width], triangle[:, width])
    return State(problem, p, z, fit, None, pending, None, side)


def admissible_steps(state: State, units: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Return an orthonormal basis of the steps, over `units` (P,), that keep the leftover rows,
    None for all, and the shortest step, not over units, that meets them.
    """
    count = len(units)
    if state.leftover is None:
        return None, np.zeros(count)
    rows = state.leftover[1].reshape(-1, count) * units
    below = np.column_stack([rows, -state.leftover[0].reshape(-1)])
    both = np.asarray(np.linalg.qr(below, mode="r"))
    if not np.isfinite(both).all():
        return None, np.full(count, np.nan)
    left, singular, across, kept = _split(both[:, :count], units.max())
    particular = across[:kept].T @ ((left[:, :kept].T @ both[:, count]) / singular[:kept])
    return across[kept:].T, units * particular


def _split(rows: np.ndarray, unit: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Decompose rows left over (m, P) into singular values, with all directions of parameters, and
    count those that bind: beyond rounding of the largest, and of a step of one `unit`.
    """
    left, values, right = np.linalg.svd(rows, full_matrices=rows.shape[0] < rows.shape[1])
    bound = max(RANK_TOLERANCE * values.max(initial=0.0), CONSTRAINT_ROUNDING * unit)
    return left, values, right, np.sum(values > bound)


def unbound(rows: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis (P, k) of the steps that rows left over (m, P) leave free."""
    *_, right, kept = _split(rows)
    return right[kept:].T


def spectrum(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return the singular values (P,) of dr/dp of the readings, and its null space (P, k),
    orthonormal, judged with very long columns made shorter: what is small beside an angle at a
    lever of kilometres is not rounding. What an overconstrained closure leaves to p stands above
    them as orthonormal rows, times the longest column.
    """
    matrix = state.linearised.matrix
    if state.leftover is not None:
        *_, right, kept = _split(state.leftover[1].reshape(-1, matrix.shape[1]))
        longest = np.max(np.linalg.norm(matrix, axis=0), initial=0.0)
        matrix = np.vstack([longest * right[:kept], matrix])
    if matrix.shape[0] > matrix.shape[1]:
        matrix = np.asarray(np.linalg.qr(matrix, mode="r"))
    norms = np.linalg.norm(matrix, axis=0)
    usual = _LONG_COLUMN_RATIO * np.median(norms[norms > 0.0]) if np.any(norms > 0.0) else 1.0
    lengths = np.maximum(norms, usual)
    values = np.zeros(matrix.shape[1])
    values[: min(matrix.shape)] = np.linalg.svd(matrix, compute_uv=False)
    _, even, across = np.linalg.svd(matrix / lengths)
    rank = np.sum(even > RANK_TOLERANCE * even.max(initial=1e-300))
    return values, np.linalg.qr(across[rank:].T / lengths[:, None])[0]


# --- beside the prior -----------------------------------------------------------------------------


def rounding_residual(problem: CalibrationProblem) -> float:
    """A residual that arithmetic leaves."""
    return _ROUNDING_RESIDUAL * problem.size * float(problem.readings.weight.max(initial=0.0))


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
        if np.isfinite(both).all():
            both = np.vstack([both, np.zeros((width, width + 1))])
            both = np.asarray(np.linalg.qr(both, mode="r"))
        weights = np.where(known, 1.0, _FREE_WEIGHT) / units
        moved = (state.p - model.nominal) / model.scales * known + particular
        jacobian = both[:width, :width]
        longest = np.max(np.linalg.norm(jacobian, axis=0), initial=0.0)
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


class Told(NamedTuple):
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
    usual = np.median(like) if len(like) else 1.0
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
