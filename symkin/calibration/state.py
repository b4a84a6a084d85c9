"""A trial of the least-squares problem: residuals and their derivative at parameters and postures, every posture condensed.

Poses couple to the parameters only (block-arrow structure): dz = -F_z^+ (F + F_p dp) at each posture, so that its readings
become h - A F + (h_p - A F_p) dp with A = h_z F_z^+, the implicit derivative, and only p is left. Rows that the unknown
coordinates cannot meet (overconstrained mechanisms) are left over: they constrain p.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.direct import CLOSED, newton_postures, signs, solved_steps
from symkin.calibration.ideal import ideal
from symkin.calibration.model import Evaluation
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.residuals import Condensed, Form, Linearised, linearise
from symkin.calibration.steps import admitted, design

PREDICTED = 1e-4
"""A predicted posture off its closure by less than this (of the size) is corrected to first order in the same evaluation."""
CONSTRAINT = 1e6
"""Weight of the rows that overconstrained closures leave to p, over the largest slope of a residual."""
_RESTORED = 2
"""Steps that bring the rows left over back to zero after a step: they are not linear, and their penalty would forbid it."""


@dataclass(frozen=True, eq=False)
class State:
    """Parameters p (free, unscaled), unknown coordinates z (n, width), residuals and dr/dp (per scaled parameter), the
    closure's pending correction (n, f), rows left over and their derivative (n, m, P), signs of det F_z."""

    p: np.ndarray
    z: np.ndarray
    fit: Linearised
    values: Evaluation
    pending: np.ndarray
    leftover: tuple[np.ndarray, np.ndarray] | None
    signs: np.ndarray

    def follow(self, step: np.ndarray) -> np.ndarray:
        """Tangent steps (n, f) that keep the postures closed while the scaled parameters take a step."""
        return np.asarray(-self.pending - solved_steps(self.values.rows_z, self.values.rows_p @ step[:, None])[:, :, 0])

    @property
    def cost(self) -> float:
        return float(np.dot(self.fit.vector, self.fit.vector))


def evaluate(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, form: Form, covariance: np.ndarray | None = None
) -> State:
    """Closure and readings at (p, z), condensed to p."""
    if problem.is_large:
        return _evaluate_parts(problem, p, z, form, covariance)
    e = problem.model.evaluate(z, problem.measurements.joints, p, problem.quaternions)
    pending = solved_steps(e.rows_z, e.rows[:, :, None])[:, :, 0]
    readings, slopes, leftover = _condensed(e, pending)
    fit = linearise(form, problem.readings, readings, slopes, covariance)
    if problem.prior is not None:
        fit = replace(fit, prior=problem.prior_rows(p))
    return State(p, z, fit, e, pending, leftover, signs(e.rows_z))


def _condensed(e: Evaluation, pending: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray] | None]:
    """Readings corrected for the closure (n, K), their derivative (n, K, P), and what an overconstrained closure leaves."""
    if e.rows_z.shape[1] == e.rows_z.shape[2]:
        weights = solved_steps(e.rows_z.transpose(0, 2, 1), e.readings_z.transpose(0, 2, 1)).transpose(0, 2, 1)
        return e.readings - (weights @ e.rows[:, :, None])[:, :, 0], e.readings_p - weights @ e.rows_p, None
    follow = solved_steps(e.rows_z, e.rows_p)
    left = e.rows - (e.rows_z @ pending[:, :, None])[:, :, 0], e.rows_p - e.rows_z @ follow
    return e.readings - (e.readings_z @ pending[:, :, None])[:, :, 0], e.readings_p - e.readings_z @ follow, left


def evaluate_readings(problem: CalibrationProblem, state: State) -> Evaluation:
    """Closure and readings of a state, without the condensation."""
    return evaluate_at(problem, state.p, state.z)


def evaluate_at(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> Evaluation:
    """Closure and readings at (p, z), without the condensation; of a large problem only part by part."""
    return problem.model.evaluate(z, problem.measurements.joints, p, problem.quaternions)


def readings_at(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Readings (n, K) at (p, z), part by part."""
    made = np.zeros(problem.readings.values.shape)
    for rows, part in problem.parts:
        made[rows] = evaluate_at(part, p, z[rows]).readings
    return made


def slopes(e: Evaluation) -> np.ndarray:
    """dh/dp (n, K, P) with the postures following."""
    return _condensed(e, np.zeros((len(e.rows), e.rows_z.shape[2])))[1]


def joint_covariance(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Covariance (n, K, K) that joint noise gives the readings: H_q diag(sigma_q^2) H_q^T, H_q = -h_z F_z^+ F_q."""
    width = len(problem.model.columns)
    made = np.zeros((len(state.z), width, width))
    for rows, part in problem.parts:
        made[rows] = joint_covariance_at(part, state.p, state.z[rows])
    return made


def joint_covariance_at(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The same at (p, z); of a large problem only part by part."""
    sigma, model, joints = problem.measurements.sigma("joint"), problem.model, problem.measurements.joints
    if sigma is None:
        return np.zeros((len(z), len(model.columns), len(model.columns)))
    e = evaluate_at(problem, p, z)
    by_joint = e.readings_z @ solved_steps(e.rows_z, model.rows_by_joint(z, joints, p)) * sigma[:, None, :]
    return np.asarray(by_joint @ by_joint.transpose(0, 2, 1))


def settled(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, form: Form, covariance: np.ndarray | None) -> State:
    """The state with the closure met to rounding."""
    state = evaluate(problem, p, z, form, covariance)
    for _ in range(2):
        largest = np.max(np.abs(state.pending), initial=0.0)
        if not 1e-15 * problem.model.closure.size < largest < np.inf:
            break
        if largest > PREDICTED * problem.model.closure.size:
            z, _ = newton_postures(problem.model, z, problem.measurements.joints, p)
            state = evaluate(problem, p, z, form, covariance)
        state = evaluate(problem, p, problem.model.system.move(state.z, -state.pending), form, covariance)
    return state


def stepped(
    problem: CalibrationProblem, state: State, step: np.ndarray, form: Form, covariance: np.ndarray | None, *, nested: bool
) -> State | None:
    """The state after a step in p, postures moved along; None where a direct problem has no solution there."""
    model = problem.model
    p = state.p + model.scales * step
    z = model.system.move(state.z, state.follow(step))
    trial = evaluate(problem, p, z, form, covariance)
    if not np.all(np.isfinite(trial.pending)):
        return None
    if nested and np.max(np.abs(trial.pending), initial=0.0) > PREDICTED * model.closure.size:
        z, solved = newton_postures(model, z, problem.measurements.joints, p, tolerance=1e2 * CLOSED)
        if not solved.all():
            return None
        trial = evaluate(problem, p, z, form, covariance)
    return trial if np.isfinite(trial.cost) else None


def restored(
    move: Callable[[State, np.ndarray], State | None], state: State, step: np.ndarray, null_space: np.ndarray
) -> State | None:
    """The state after a step that `move` makes, with the rows left over met again; None where a posture has no solution."""
    trial = move(state, step)
    for _ in range(_RESTORED):
        if trial is None or trial.leftover is None or not np.max(np.abs(trial.leftover[0]), initial=0.0) > 0.0:
            break
        trial = move(trial, admitted(trial, null_space)[1])
    return trial


def merit(state: State) -> float:
    """The cost, with an exact penalty for rows left over."""
    if state.leftover is None:
        return state.cost
    weight = CONSTRAINT * float(np.max(np.abs(state.fit.jacobian), initial=1e-300))
    return state.cost + weight * float(np.sum(np.abs(state.leftover[0])))


def ideal_design(problem: CalibrationProblem, state: State) -> np.ndarray:
    """The design where the readings of each group agree (see `ideal`): its null space is what no reading tells."""
    return design(ideal_state(problem, state))


def ideal_state(problem: CalibrationProblem, state: State) -> State:
    other, z = ideal(problem, state.p, state.z)
    return evaluate(other, state.p, z, "means")


# --- many postures -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LargeState(State):
    """A state of a large problem, without the derivatives of single postures: `values` is empty, and `fit` condensed."""

    problem: CalibrationProblem

    def follow(self, step: np.ndarray) -> np.ndarray:
        moved = np.empty_like(self.pending)
        for rows, part in self.problem.parts:
            e = evaluate_at(part, self.p, self.z[rows])
            moved[rows] = -self.pending[rows] - solved_steps(e.rows_z, e.rows_p @ step[:, None])[:, :, 0]
        return moved


def _evaluate_parts(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, form: Form, covariance: np.ndarray | None
) -> LargeState:
    """The same as `evaluate`, a part at a time: derivatives and residuals of each are joined to the triangle of those before."""
    width = len(problem.names)
    known, by_known = problem.prior_rows(p) or (np.zeros(0), np.zeros((0, width)))
    triangle, residuals = np.column_stack([by_known, known]), np.zeros(problem.readings.values.shape)
    pending, side = np.zeros((len(z), problem.model.system.freedom)), np.zeros(len(z))
    for rows, part in problem.parts:
        state = evaluate(part, p, z[rows], form, None if covariance is None else covariance[rows])
        residuals[rows], pending[rows], side[rows] = state.fit.residuals, state.pending, state.signs
        below = np.column_stack([state.fit.matrix, state.fit.vector])
        triangle = np.asarray(np.linalg.qr(np.vstack([triangle, below]), mode="r"))
    fit = Condensed(residuals, triangle[:, None, :width], right=triangle[:, width])
    nothing = np.zeros(0)
    values = Evaluation(nothing, nothing, nothing, nothing, nothing, nothing)
    return LargeState(p, z, fit, values, pending, None, side, problem)
