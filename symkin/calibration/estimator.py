"""Least squares over parameters and poses: Levenberg-Marquardt with every posture condensed.

Poses couple to the parameters only (block-arrow structure): dz = -F_z^+ (F + F_p dp) at each posture, so that its readings
become h - A F + (h_p - A F_p) dp with A = h_z F_z^+, the implicit derivative, and only p is left. Steps solve the small
problem by QR of columns that count lengths alike (see `model`). "nested" solves the direct problem of every posture
before a step is judged; "lifted" treats the poses as unknowns and lets closure and readings converge together.
Rows that the unknown coordinates cannot meet (overconstrained mechanisms) constrain p: every step keeps C dp = -c.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.direct import CLOSED, newton_postures, signs, solved_steps
from symkin.calibration.ideal import ideal
from symkin.calibration.model import Evaluation
from symkin.calibration.problem import CalibrationProblem
from symkin.calibration.residuals import Form, Linearised, linearise
from symkin.calibration.steps import admitted, damped_step, design, null_directions

_PREDICTED = 1e-4
"""A predicted posture off its closure by less than this (of the size) is corrected to first order in the same evaluation."""
_TAIL = 1e-8
"""Steps below this (of the size) are Gauss-Newton steps near the minimum, where the cost is flat to rounding."""
_SETTLED = 1e-13
"""The iteration ends when steps are below this, or below _TAIL and no longer shrinking."""
_PATIENCE = 4
"""Undamped steps in a row that may raise the cost before the best state so far is taken up again with damping: curved
valleys are crossed faster so than along their floor."""
_LONGEST = 0.5
"""A nested step that moves a parameter by more than this (of the size) is damped: no geometry is so far off."""
_FIRST, _LEAST_DAMPING = 1e-4, 1e-15
"""Damping after the first undamped step that failed, and that below which there is none: directions that readings hardly tell have
squared singular values so much smaller than the columns' lengths."""
_KEPT = 3
"""Steps during which the damping stays after less of it was refused: trying again costs an evaluation each time."""
_NEGLIGIBLE, _SLOW = 1e-7, 4
"""The iteration ends, too, when so many damped steps in a row each lower the cost by less than this share, far below its chance
fluctuation: a parameter that readings tell to second order only lets the linear model promise more for ever."""
_PROBE, _ACCELERATED = 0.1, 0.4
"""Share of a damped step at which its curvature is looked at, and the largest share of it that its acceleration may be."""
_RESTORED = 2
"""Steps that bring the rows left over back to zero after a step: they are not linear, and their penalty would forbid it."""
_CONSTRAINT = 1e6
"""Weight of the rows that overconstrained closures leave to p, over the largest slope of a residual."""


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


@dataclass(frozen=True, eq=False)
class Estimate:
    """Where an estimation ended: `state` with closed postures; status "ok", "max_iterations" or "stalled"."""

    state: State
    status: str
    iterations: int
    null_space: np.ndarray


def evaluate(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, form: Form, covariance: np.ndarray | None = None
) -> State:
    """Closure and readings at (p, z), condensed to p."""
    e = problem.model.evaluate(z, problem.measurements.joints, p, problem.quaternions)
    pending = solved_steps(e.rows_z, e.rows[:, :, None])[:, :, 0]
    readings, slopes, leftover = _condensed(e, pending)
    fit = linearise(form, problem.readings, readings, slopes, covariance)
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
    return problem.model.evaluate(state.z, problem.measurements.joints, state.p, problem.quaternions)


def slopes(e: Evaluation) -> np.ndarray:
    """dh/dp (n, K, P) with the postures following."""
    return _condensed(e, np.zeros((len(e.rows), e.rows_z.shape[2])))[1]


def estimate(
    problem: CalibrationProblem, z: np.ndarray, *, method: str = "nested", max_iterations: int = 60, p: np.ndarray | None = None
) -> Estimate:
    """Least squares from p (default: nominal) and postures z; maximum likelihood begins with the means and then takes
    the covariance of joint noise at the estimate, twice."""
    begin = problem.model.nominal if p is None else p
    with np.errstate(all="ignore"):
        if problem.form != "maximum likelihood":
            return _minimise(problem, begin, z, problem.form, None, method, max_iterations)
        result = _minimise(problem, begin, z, "means", None, method, max_iterations)
        for _ in range(2):
            covariance = joint_covariance(problem, result.state)
            again = _minimise(problem, result.state.p, result.state.z, problem.form, covariance, method, max_iterations)
            result = replace(again, iterations=result.iterations + again.iterations)
    return result


def joint_covariance(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Covariance (n, K, K) that joint noise gives the readings: H_q diag(sigma_q^2) H_q^T, H_q = -h_z F_z^+ F_q."""
    sigma = problem.measurements.sigma("joint")
    model, joints = problem.model, problem.measurements.joints
    width = len(model.columns)
    if sigma is None:
        return np.zeros((len(joints), width, width))
    e = evaluate_readings(problem, state)
    by_joint = e.readings_z @ solved_steps(e.rows_z, model.rows_by_joint(state.z, joints, state.p)) * sigma[:, None, :]
    return np.asarray(by_joint @ by_joint.transpose(0, 2, 1))


# --- iteration -----------------------------------------------------------------------------------------------------


def _minimise(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, form: Form, covariance: np.ndarray | None, method: str, limit: int
) -> Estimate:
    size = problem.model.closure.size
    state = evaluate(problem, p, z, form, covariance)
    if state.leftover is not None:
        state = settled(problem, p, z, form, covariance)
    null_space = null_directions(ideal_design(problem, state))
    best, since, patience, damping, last, status = state, 0, _PATIENCE, 0.0, np.inf, "max_iterations"
    slow, refused, iteration = 0, 0, 0
    for iteration in range(1, limit + 1):
        step = damped_step(state, null_space, damping)
        length = float(np.max(np.abs(step), initial=0.0)) / size
        if not np.isfinite(length):
            status = "stalled"
            break
        if damping > 0.0 and length < _LONGEST:
            step = _bent(problem, state, step, null_space, damping, form, covariance, nested=method == "nested")
        tail = length < _TAIL and damping == 0.0
        if tail and (length < _SETTLED or length > 0.5 * last):
            status, best = "ok", state
            break
        far = method == "nested" and length > _LONGEST
        trial = None if far else _moved(problem, state, step, null_space, form, covariance, nested=method == "nested")
        better = trial is not None and (tail or _merit(trial) < _merit(best))
        if trial is not None and not (method == "lifted" or np.array_equal(trial.signs, best.signs)):
            trial = None
        if trial is not None and (better or method == "lifted" or (damping == 0.0 and since < patience)):
            last = length if damping == 0.0 else np.inf
            since = 0 if better else since + 1
            gained = _merit(best) - _merit(trial)
            if better:
                slow = slow + 1 if 0.0 < damping <= _FIRST and gained < _NEGLIGIBLE * _merit(trial) else 0
                damping = _eased(damping, gained / _predicted(state, step), iteration - refused if refused else None)
            state = trial
            best = state if better or method == "lifted" else best
            if slow >= _SLOW:
                status = "ok"
                break
        elif method == "lifted" or damping > 1e8 or tail:
            status = "stalled"
            break
        else:
            patience, refused = (0 if since else patience), iteration
            state, since, damping = best, 0, max(10.0 * damping, _FIRST if damping == 0.0 else 0.0)
    state = best
    return Estimate(settled(problem, state.p, state.z, form, covariance), status, iteration, null_space)


def _eased(damping: float, ratio: float, since_refused: int | None) -> float:
    """The damping after a step that lowered the cost by `ratio` times what the linear model said: not less where less was refused
    just before, and less by a smaller factor where it was refused at all; 0 when it is next to nothing."""
    if ratio < 0.25:
        factor = 2.0
    elif since_refused is None:
        factor = 0.01 if ratio > 0.9 else 0.1
    else:
        factor = 1.0 if since_refused < _KEPT else 0.1
    return factor * damping if factor * damping > _LEAST_DAMPING else 0.0


def _predicted(state: State, step: np.ndarray) -> float:
    """By how much the linear model lowers the cost in a step."""
    after = state.fit.vector + state.fit.matrix @ step
    return max(state.cost - float(after @ after), 1e-300)


def settled(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, form: Form, covariance: np.ndarray | None) -> State:
    """The state with the closure met to rounding."""
    state = evaluate(problem, p, z, form, covariance)
    for _ in range(2):
        largest = np.max(np.abs(state.pending), initial=0.0)
        if not 1e-15 * problem.model.closure.size < largest < np.inf:
            break
        if largest > _PREDICTED * problem.model.closure.size:
            z, _ = newton_postures(problem.model, z, problem.measurements.joints, p)
            state = evaluate(problem, p, z, form, covariance)
        state = evaluate(problem, p, problem.model.system.move(state.z, -state.pending), form, covariance)
    return state


def _moved(
    problem: CalibrationProblem, state: State, step: np.ndarray, null_space: np.ndarray, form: Form,
    covariance: np.ndarray | None, *, nested: bool,
) -> State | None:  # fmt: skip
    """The state after a step, postures moved along and rows left over met again; None where a direct problem has no solution."""
    trial = _stepped(problem, state, step, form, covariance, nested=nested)
    for _ in range(_RESTORED):
        if trial is None or trial.leftover is None or not np.max(np.abs(trial.leftover[0]), initial=0.0) > 0.0:
            break
        trial = _stepped(problem, trial, admitted(trial, null_space)[1], form, covariance, nested=nested)
    return trial


def _stepped(
    problem: CalibrationProblem, state: State, step: np.ndarray, form: Form, covariance: np.ndarray | None, *, nested: bool
) -> State | None:
    """The state after a step in p, postures moved along; None where a direct problem has no solution there."""
    model = problem.model
    p = state.p + model.scales * step
    z = model.system.move(state.z, state.follow(step))
    trial = evaluate(problem, p, z, form, covariance)
    if not np.all(np.isfinite(trial.pending)):
        return None
    if nested and np.max(np.abs(trial.pending), initial=0.0) > _PREDICTED * model.closure.size:
        z, solved = newton_postures(model, z, problem.measurements.joints, p, tolerance=1e2 * CLOSED)
        if not solved.all():
            return None
        trial = evaluate(problem, p, z, form, covariance)
    return trial if np.isfinite(trial.cost) else None


def _merit(state: State) -> float:
    """The cost, with an exact penalty for rows left over."""
    if state.leftover is None:
        return state.cost
    weight = _CONSTRAINT * float(np.max(np.abs(state.fit.jacobian), initial=1e-300))
    return state.cost + weight * float(np.sum(np.abs(state.leftover[0])))


def ideal_design(problem: CalibrationProblem, state: State) -> np.ndarray:
    """The design where the readings of each group agree (see `ideal`): its null space is what no reading tells."""
    return design(ideal_state(problem, state))


def ideal_state(problem: CalibrationProblem, state: State) -> State:
    other, z = ideal(problem, state.p, state.z)
    return evaluate(other, state.p, z, "means")


def _bent(
    problem: CalibrationProblem, state: State, step: np.ndarray, null_space: np.ndarray, damping: float, form: Form,
    covariance: np.ndarray | None, *, nested: bool,
) -> np.ndarray:  # fmt: skip
    """A damped step with half of its geodesic acceleration (Transtrum and Sethna 2012), which follows a curved valley: the second
    derivative of the residuals along the step d is 2 ((r(d h) - r) / h - J d) / h. The step alone where that is no small correction."""
    probe = _stepped(problem, state, _PROBE * step, form, covariance, nested=nested)
    if probe is None:
        return step
    curved = 2.0 * ((probe.fit.vector - state.fit.vector) / _PROBE - state.fit.matrix @ step) / _PROBE
    if not np.all(np.isfinite(curved)):
        return step
    half = 0.5 * damped_step(state, null_space, damping, curved)
    lengths = np.linalg.norm(state.fit.matrix, axis=0)
    return step + half if np.linalg.norm(lengths * half) < _ACCELERATED * np.linalg.norm(lengths * step) else step
