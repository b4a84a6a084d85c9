"""Solve the least squares over parameters and poses: Levenberg-Marquardt with every configuration
condensed.

Steps solve the small problem of the parameters (see `state`) by QR of columns that count lengths
alike (see `model`). "nested" solves the direct problem of every configuration before a step is
judged; "lifted" treats the poses as unknowns and lets closure and readings converge together. Rows
that the unknown coordinates cannot meet (overconstrained mechanisms) constrain p: every step keeps
C dp = -c. Along directions that no reading determines, parameters are moved nearest to nominal
afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.estimate.descent import (
    MINIMUM_TOLERANCE,
    Descent,
    is_rounding,
    undetermined_directions,
)
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import Condensed, Form
from symkin.calibration.estimate.state import (
    State,
    closed_state,
    damped_step,
    error_free_design,
    evaluate,
    joint_covariance,
    merit,
    null_directions,
    restored_after,
    state_after,
)
from symkin.numeric.tolerances import RANK_TOLERANCE

_TAIL_STEP = 1e-8
"""Steps below this (of the size) are Gauss-Newton steps near the minimum, where the cost is flat to
rounding.
"""
_CONVERGED_STEP = 1e-13
"""The iteration ends when steps (of the size) are below this, or below `_TAIL_STEP` and no longer
shrinking.
"""
_MAX_RISING_STEPS = 4
"""Undamped steps in a row that may raise the cost before the best state so far is taken up again
with damping: curved valleys are crossed faster so than along their floor.
"""
_MAX_PARAMETER_STEP = 0.5
"""A nested step that moves a parameter by more than this (of the size) is damped: no geometry is so
far off.
"""
_FIRST_DAMPING, _MIN_DAMPING = 1e-4, 1e-15
"""Damping after the first undamped step that failed, and that below which there is none: directions
that readings hardly tell have squared singular values so much smaller than the columns' lengths.
"""
_STEPS_AFTER_REFUSAL = 3
"""Steps during which the damping stays after less of it was refused: trying again costs an
evaluation each time.
"""
_NEGLIGIBLE_DECREASE, _MAX_SLOW_STEPS = 1e-7, 4
"""The iteration ends, too, when so many damped steps in a row each lower the cost by less than this
share, far below its chance fluctuation: a parameter that readings determine to second order only
lets the linear model promise more at every step.
"""
_MAX_DESCENT_STEPS = 600
"""Most steps of the descent from where the iteration ended."""
_PROBE_SHARE, _MAX_ACCELERATION = 0.1, 0.4
"""Share of a damped step at which its curvature is looked at, and the largest share of it that its
acceleration may be.
"""

_MAX_FRAME_CORRECTIONS = 40
"""Most corrections of the frames; each shrinks the departure by the curvature of the unobservable
set.
"""
_COST_ROUNDING = 1e-9
"""Share of the cost by which a change of frames may raise it, for rounding."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Where an estimation ended: `state` with closed configurations; status "ok", "max_iterations"
    or "stalled".
    """

    state: State
    status: str
    iterations: int
    null_space: np.ndarray


def estimate(
    problem: CalibrationProblem,
    z: np.ndarray,
    *,
    method: str = "nested",
    max_iterations: int = 60,
    p: np.ndarray | None = None,
) -> Estimate:
    """Minimise the squared residuals from p (default: nominal) and configurations z; maximum
    likelihood begins with the means and then takes the covariance of joint noise at the estimate,
    twice.
    """
    begin = problem.model.nominal if p is None else p
    with np.errstate(all="ignore"):
        if problem.form != "maximum likelihood":
            return _minimise(problem, begin, z, problem.form, None, method, max_iterations)
        result = _minimise(problem, begin, z, "means", None, method, max_iterations)
        for _ in range(2):
            covariance = joint_covariance(problem, result.state)
            again = _minimise(
                problem,
                result.state.p,
                result.state.z,
                problem.form,
                covariance,
                method,
                max_iterations,
            )
            result = replace(again, iterations=result.iterations + again.iterations)
    return result


# --- iteration ------------------------------------------------------------------------------------


def _minimise(
    problem: CalibrationProblem,
    p: np.ndarray,
    z: np.ndarray,
    form: Form,
    covariance: np.ndarray | None,
    method: str,
    limit: int,
) -> Estimate:
    state = evaluate(problem, p, z, form, covariance)
    if state.leftover is not None:
        state = closed_state(problem, p, z, form, covariance)
    null_space = null_directions(error_free_design(problem, state))
    if is_rounding(problem, state):
        return Estimate(closed_state(problem, p, z, form, covariance), "ok", 0, null_space)
    search = _Search(
        problem=problem,
        form=form,
        covariance=covariance,
        method=method,
        null_space=null_space,
        state=state,
        best=state,
    )
    status, iterations = search.run(limit)
    best = closed_state(problem, search.best.p, search.best.z, form, covariance)
    result = Estimate(best, status, iterations, null_space)
    # an iteration that finds no lower cost may stand at the minimum all the same
    at_minimum = (
        status == "stalled"
        and Descent(problem=problem, form=form, covariance=covariance, state=best).is_minimum
    )
    there = status == "ok" or at_minimum or is_rounding(problem, best)
    return finish_by_descent(problem, result, form, covariance) if there else result


def finish_by_descent(
    problem: CalibrationProblem, result: Estimate, form: Form, covariance: np.ndarray | None = None
) -> Estimate:
    """Go on from where an iteration ended to a minimum over all that is determined there (see
    `descent`).
    """
    descent = Descent(problem=problem, form=form, covariance=covariance, state=result.state)
    status, steps = descent.run(_MAX_DESCENT_STEPS)
    state = (
        closed_state(problem, descent.state.p, descent.state.z, form, covariance)
        if steps
        else result.state
    )
    return Estimate(state, status, result.iterations + steps, descent.null_space)


def descend_from(
    problem: CalibrationProblem, z: np.ndarray, p: np.ndarray, result: Estimate
) -> Estimate | None:
    """Find the minimum that the descent alone reaches from p and configurations z; None where
    nothing was released on the way to a `result`. Where something was, the first iteration may have
    led into another valley.
    """
    if problem.form == "maximum likelihood":
        return None
    with np.errstate(all="ignore"):
        begin = closed_state(problem, p, z, problem.form, None)
        held = undetermined_directions(problem, begin)
        if begin.leftover is not None or held.shape[1] <= result.null_space.shape[1]:
            return None
        return finish_by_descent(problem, Estimate(begin, "ok", 0, held), problem.form)


@dataclass(eq=False)
class _Search:
    """The iteration: `state` is where it stands, `best` where the cost was least. `rising_steps`
    counts undamped steps without a lower cost, of which `allowed_rising_steps` are allowed;
    `last_length` is the length of the last undamped step, of the size; `slow_steps` counts damped
    steps that gain next to nothing; `last_refused` is the last iteration whose step was taken back.
    """

    problem: CalibrationProblem
    form: Form
    covariance: np.ndarray | None
    method: str
    null_space: np.ndarray
    state: State
    best: State
    damping: float = 0.0
    rising_steps: int = 0
    allowed_rising_steps: int = _MAX_RISING_STEPS
    last_length: float = np.inf
    slow_steps: int = 0
    last_refused: int | None = None

    def run(self, limit: int) -> tuple[str, int]:
        """Iterate; return status and number of iterations."""
        for iteration in range(1, limit + 1):
            status = self._advance(iteration)
            if status is not None:
                return status, iteration
        return "max_iterations", limit

    def _advance(self, iteration: int) -> str | None:
        """Take or refuse one step; return the status where it is the last one."""
        step, length = self._step()
        if not np.isfinite(length):
            return "stalled"
        # near the minimum the cost is flat to rounding: steps are then judged by their length alone
        tail = length < _TAIL_STEP and self.damping == 0.0
        if tail and (length < _CONVERGED_STEP or length > 0.5 * self.last_length):
            self.best = self.state
            return "ok"
        trial = self._trial_state(step, length)
        better = trial is not None and (tail or merit(trial) < merit(self.best))
        lifted = self.method == "lifted"
        # det F_z changes its sign only across a singularity, beyond which lies another assembly
        # mode
        on_branch = trial is not None and (
            lifted or np.array_equal(trial.determinant_signs, self.best.determinant_signs)
        )
        if (
            trial is not None
            and on_branch
            and (
                better
                or lifted
                or (self.damping == 0.0 and self.rising_steps < self.allowed_rising_steps)
            )
        ):
            self._accept(trial, step, length, iteration, better=better)
            return "ok" if self.slow_steps >= _MAX_SLOW_STEPS else None
        if lifted or self.damping > 1e8 or tail:
            return "stalled"
        self._refuse(iteration)
        return None

    def _step(self) -> tuple[np.ndarray, float]:
        """Return the next step and its length, of the size, before its acceleration."""
        step = damped_step(self.state, self.null_space, self.damping)
        length = (
            float(np.max(np.abs(step), initial=0.0))
            / self.problem.model.closure.characteristic_length
        )
        return (
            self._accelerated(step) if self.damping > 0.0 and length < _MAX_PARAMETER_STEP else step
        ), length

    def _accelerated(self, step: np.ndarray) -> np.ndarray:
        """Add half of its geodesic acceleration to a damped step (Transtrum and Sethna 2012), which
        follows a curved valley: the second derivative of the residuals along the step d is 2 ((r(d
        h) - r) / h - J d) / h. The step alone where that is no small correction, and where
        residuals are condensed.
        """
        fit = self.state.linearised
        if isinstance(fit, Condensed):
            return step
        probe = self._moved(self.state, _PROBE_SHARE * step)
        if probe is None:
            return step
        curved = (
            2.0
            * ((probe.linearised.vector - fit.vector) / _PROBE_SHARE - fit.matrix @ step)
            / _PROBE_SHARE
        )
        if not np.all(np.isfinite(curved)):
            return step
        half = 0.5 * damped_step(self.state, self.null_space, self.damping, curved)
        lengths = np.linalg.norm(fit.matrix, axis=0)
        return (
            step + half
            if np.linalg.norm(lengths * half) < _MAX_ACCELERATION * np.linalg.norm(lengths * step)
            else step
        )

    def _trial_state(self, step: np.ndarray, length: float) -> State | None:
        """Evaluate the state after a step, configurations moved along and rows left over met again;
        None where the step is too long, or a direct problem has no solution.
        """
        if self.method == "nested" and length > _MAX_PARAMETER_STEP:
            return None
        return restored_after(
            lambda state, more: self._moved(state, more), self.state, step, self.null_space
        )

    def _moved(self, state: State, step: np.ndarray) -> State | None:
        return state_after(
            self.problem, state, step, self.form, self.covariance, nested=self.method == "nested"
        )

    def _accept(
        self, trial: State, step: np.ndarray, length: float, iteration: int, *, better: bool
    ) -> None:
        self.last_length = length if self.damping == 0.0 else np.inf
        self.rising_steps = 0 if better else self.rising_steps + 1
        if better:
            gained = merit(self.best) - merit(trial)
            is_slow = (
                0.0 < self.damping <= _FIRST_DAMPING
                and gained < _NEGLIGIBLE_DECREASE * merit(trial)
            )
            self.slow_steps = self.slow_steps + 1 if is_slow else 0
            since_refused = None if self.last_refused is None else iteration - self.last_refused
            self.damping = _damping_after(
                self.damping, gained / _predicted_decrease(self.state, step), since_refused
            )
        self.state = trial
        if better or self.method == "lifted":
            self.best = trial

    def _refuse(self, iteration: int) -> None:
        """Go back to the best state, with more damping."""
        self.allowed_rising_steps, self.last_refused = (
            (0 if self.rising_steps else self.allowed_rising_steps),
            iteration,
        )
        self.state, self.rising_steps = self.best, 0
        self.damping = max(10.0 * self.damping, _FIRST_DAMPING if self.damping == 0.0 else 0.0)


def _damping_after(damping: float, ratio: float, since_refused: int | None) -> float:
    """Choose the damping after a step that lowered the cost by `ratio` times what the linear model
    said: not less where less was refused just before, and less by a smaller factor where it was
    refused at all; 0 when it is next to nothing.
    """
    if ratio < 0.25:
        factor = 2.0
    elif since_refused is None:
        factor = 0.01 if ratio > 0.9 else 0.1
    else:
        factor = 1.0 if since_refused < _STEPS_AFTER_REFUSAL else 0.1
    return factor * damping if factor * damping > _MIN_DAMPING else 0.0


def _predicted_decrease(state: State, step: np.ndarray) -> float:
    """Return by how much the linear model lowers the cost in a step."""
    after = state.linearised.vector + state.linearised.matrix @ step
    return max(state.cost - float(after @ after), 1e-300)


def move_by_least_change(problem: CalibrationProblem, result: Estimate, method: str) -> Estimate:
    """Move the parameters of a fit nearest to nominal along the unobservable directions N, until
    N^T (p - nominal) vanishes (scaled parameters), and refit, as far as the cost stays. Rigid
    frames are then a best fit of the joints to nominal (Procrustes); measuring frames, which have
    no nominal place, take all of it.
    """
    result, moved = _move_towards_nominal(
        problem, result, method, lambda state: null_directions(error_free_design(problem, state))
    )
    return (
        result
        if moved
        else _move_towards_nominal(
            problem, result, method, lambda state: undetermined_directions(problem, state)
        )[0]
    )


def _move_towards_nominal(
    problem: CalibrationProblem, result: Estimate, method: str, free: Callable[[State], np.ndarray]
) -> tuple[Estimate, bool]:
    """Move a fit along the directions that are `free` of it until it is nearest to nominal; and
    tell whether it got there.
    """
    model, size = problem.model, problem.model.closure.characteristic_length
    slack = (
        MINIMUM_TOLERANCE if problem.readings.known else 1e-12 * result.state.linearised.vector.size
    )
    for _ in range(_MAX_FRAME_CORRECTIONS):
        directions = free(result.state)
        change = _removable_change(
            directions, (result.state.p - model.nominal) / model.scales, model.names
        )
        if directions.shape[1] == 0 or np.max(np.abs(change), initial=0.0) < 1e-12 * size:
            return result, True
        p = result.state.p - model.scales * (directions @ change)
        z = model.system.move(result.state.z, result.state.follow(-(directions @ change)))
        again = estimate(problem, z, p=p, method=method, max_iterations=8)
        if (
            again.status != "ok"
            or again.state.cost > (1 + _COST_ROUNDING) * result.state.cost + slack
        ):
            return result, False
        result = Estimate(again.state, result.status, result.iterations, directions)
    return result, False


def _removable_change(
    directions: np.ndarray, change: np.ndarray, names: Sequence[str]
) -> np.ndarray:
    """Return how much of each direction (P, k) a change of the parameters (P,) holds: what is taken
    away so that the mechanism's own parameters change least, and then, with the freedom that is
    left, the measuring frames.
    """
    measuring = np.array([name in MEASURING_FRAMES for name in names])
    if not np.any(measuring):
        return np.asarray(directions.T @ change)
    left, singular, right = np.linalg.svd(directions[~measuring], full_matrices=True)
    kept = int(np.sum(singular > RANK_TOLERANCE))
    held = right[:kept].T @ ((left[:, :kept].T @ change[~measuring]) / singular[:kept])
    free = right[kept:].T
    rest = (
        np.linalg.pinv(directions[measuring] @ free, rcond=RANK_TOLERANCE)
        @ (change - directions @ held)[measuring]
    )
    return np.asarray(held + free @ rest)
