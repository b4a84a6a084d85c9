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
from symkin.position.rank import RANK_TOLERANCE

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
    null_space = null_directions(ideal_design(problem, state))
    best, since, damping, last, status = state, 0, 0.0, np.inf, "max_iterations"
    iteration = 0
    for iteration in range(1, limit + 1):  # noqa: B007 - the last value is reported
        step = _step(state, null_space, damping)
        length = float(np.max(np.abs(step), initial=0.0)) / size
        if not np.isfinite(length):
            status = "stalled"
            break
        tail = length < _TAIL and damping == 0.0
        if tail and (length < _SETTLED or length > 0.5 * last):
            status, best = "ok", state
            break
        far = method == "nested" and length > _LONGEST
        trial = None if far else _moved(problem, state, step, form, covariance, nested=method == "nested")
        better = trial is not None and (tail or _merit(trial) < _merit(best))
        if trial is not None and not (method == "lifted" or np.array_equal(trial.signs, best.signs)):
            trial = None
        if trial is not None and (better or method == "lifted" or (damping == 0.0 and since < _PATIENCE)):
            last = length if damping == 0.0 else np.inf
            since = 0 if better else since + 1
            state, damping = trial, (0.1 * damping if damping > 1e-6 else 0.0)
            best = state if better or method == "lifted" else best
        elif method == "lifted" or damping > 1e8 or tail:
            status = "stalled"
            break
        else:
            state, since, damping = best, _PATIENCE if since else 0, max(10.0 * damping, 1e-4)
    state = best
    return Estimate(settled(problem, state.p, state.z, form, covariance), status, iteration, null_space)


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
    problem: CalibrationProblem, state: State, step: np.ndarray, form: Form, covariance: np.ndarray | None, *, nested: bool
) -> State | None:
    """The state after a step, postures moved along; None where a direct problem has no solution there."""
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


def design(state: State) -> np.ndarray:
    """dr/dp of the readings, with the rows that an overconstrained closure leaves to p above them."""
    if state.leftover is None:
        return state.fit.matrix
    rows = state.leftover[1].reshape(-1, state.fit.matrix.shape[1])
    return np.vstack([constraint_rows(rows, state), state.fit.matrix])


def ideal_design(problem: CalibrationProblem, state: State) -> np.ndarray:
    """The design where the readings of each group agree (see `ideal`): its null space is what no reading tells."""
    return design(ideal_state(problem, state))


def ideal_state(problem: CalibrationProblem, state: State) -> State:
    other, z = ideal(problem, state.p, state.z)
    return evaluate(other, state.p, z, "means")


def constraint_rows(rows: np.ndarray, state: State) -> np.ndarray:
    """Orthonormal rows of the space that the leftover rows span, times the largest column of the readings."""
    _, singular, right = np.linalg.svd(rows, full_matrices=False)
    kept = (
        right[singular > RANK_TOLERANCE * max(float(singular[0]), 1e-300)] if len(singular) and singular[0] > 1e-9 else right[:0]
    )
    return np.asarray(np.max(np.linalg.norm(state.fit.matrix, axis=0), initial=0.0) * kept)


def spectrum(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Singular values (P,) of a matrix with P columns, its right singular vectors as rows (P, P), and its rank."""
    if matrix.shape[0] > matrix.shape[1]:
        matrix = np.asarray(np.linalg.qr(matrix, mode="r"))
    _, singular, right = np.linalg.svd(matrix, full_matrices=True)
    singular = np.concatenate([singular, np.zeros(matrix.shape[1] - len(singular))])
    return singular, right, int(np.sum(singular > RANK_TOLERANCE * np.max(singular, initial=1e-300)))


def null_directions(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal columns (P, k) along which no residual changes, to first order."""
    _, right, rank = spectrum(matrix)
    return right[rank:].T


def _step(state: State, null_space: np.ndarray, damping: float) -> np.ndarray:
    """Minimise |r + J d|^2 + damping |D d|^2, D the columns' lengths, with no motion in the null space and the leftover
    rows met."""
    matrix, right = state.fit.matrix, -state.fit.vector
    basis, particular = _admitted(state, null_space)
    if basis is not None:
        matrix, right = matrix @ basis, right - matrix @ particular
    width = matrix.shape[1]
    triangle = np.asarray(np.linalg.qr(np.column_stack([matrix, right]), mode="r"))
    r, b = triangle[:width, :width], triangle[:width, width]
    if not np.all(np.isfinite(triangle)):
        return np.full(state.fit.matrix.shape[1], np.inf)
    if r.shape[0] < width or np.min(np.abs(np.diag(r)), initial=np.inf) == 0.0:
        solution = np.linalg.lstsq(r, b, rcond=None)[0]
    elif damping > 0.0:
        normal = r.T @ r
        diagonal = np.diag(normal)
        solution = np.linalg.solve(normal + damping * np.diag(np.maximum(diagonal, 1e-12 * np.max(diagonal))), r.T @ b)
    else:
        solution = np.linalg.solve(r, b)
    return np.asarray(solution if basis is None else particular + basis @ solution)


def _admitted(state: State, null_space: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Basis of the steps that are allowed and one step that meets the leftover rows: all steps where it is None."""
    count = state.fit.matrix.shape[1]
    zero = np.zeros(count)
    if state.leftover is None and null_space.shape[1] == 0:
        return None, zero
    rows, right = null_space.T, np.zeros(null_space.shape[1])
    if state.leftover is not None:
        rows = np.vstack([rows, state.leftover[1].reshape(-1, count)])
        right = np.concatenate([right, -state.leftover[0].reshape(-1)])
    left, singular, across = np.linalg.svd(rows, full_matrices=True)
    kept = int(np.sum(singular > max(RANK_TOLERANCE * float(singular[0]), 1e-9))) if len(singular) else 0
    particular = across[:kept].T @ ((left[:, :kept].T @ right) / singular[:kept])
    return across[kept:].T, particular
