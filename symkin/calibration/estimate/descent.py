"""Descend from where the solver ended to a minimum over all directions that the readings determine
there.

The solver holds what no reading determines where it begins. Some of it is determined later: the
offset between axes that are parallel at nominal and not at the fit, of which a hundred metres may
be needed. From where the solver ends the descent goes on with the directions that are null where it
stands, judged anew at every step: Levenberg-Marquardt with geodesic acceleration (Transtrum and
Sethna 2012), damped in the metric of the columns' lengths, along valleys as curved as these.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import Form
from symkin.calibration.estimate.state import (
    State,
    admissible_steps,
    error_free_design,
    merit,
    null_directions,
    restored_after,
    spectrum,
    state_after,
)
from symkin.numeric.tolerances import RANK_TOLERANCE

MINIMUM_TOLERANCE = 1e-6
"""A state is a minimum when one more linear step would lower chi-square by less than this."""
FAINT_SINGULAR_RATIO = 1e-13
"""Singular values of the equilibrated design below this, of the largest, are rounding. Directions
between it and RANK_TOLERANCE are too faint for a rank and a standard deviation, and still lower the
cost.
"""
_ROUNDING_RESIDUAL = 1e-12
"""Residuals below this, over the size, are no more than arithmetic leaves."""
_FIRST_DAMPING, _DAMPING_INCREASE, _DAMPING_DECREASE, _MIN_DAMPING, _MAX_DAMPING = (
    1e-3,
    2.0,
    10.0,
    1e-20,
    1e4,
)
"""Damping at the start, its factors after a step that failed and one that did not, and its
bounds.
"""
_COST_ROUNDING = 1e-9
"""Share of the cost that counts as rounding of it."""
_FAILURES_BEFORE_DOUBLING = 6
"""Steps that may fail in a row before the factor itself is doubled each time."""
_MIN_COLUMN_LENGTH = 1e-3
"""Columns count as so long, of the longest, in the metric: a direction that is hardly told may take
steps that much longer.
"""
_PROBE_SHARE, _MAX_ACCELERATION = 0.1, 0.1875
"""Share of a step at which its curvature is looked at, and the largest share of it that its
acceleration may be.
"""
_NEGLIGIBLE_DECREASE, _MAX_SLOW_STEPS = 1e-8, 20
"""The iteration ends, too, after so many steps in a row that each lower chi-square by less than
this share: a parameter that readings determine to second order only lets the linear model promise
more at every step.
"""


def undetermined_directions(problem: CalibrationProblem, state: State) -> np.ndarray:
    """Return orthonormal columns (P, k) along which nothing changes the cost, not even faintly. In
    groups, and with rows left over, only RANK_TOLERANCE separates rounding from that.
    """
    exact = not problem.readings.groups and state.leftover is None
    return null_directions(
        error_free_design(problem, state), FAINT_SINGULAR_RATIO if exact else RANK_TOLERANCE
    )


def remaining_decrease(problem: CalibrationProblem, state: State, null_space: np.ndarray) -> float:
    """Return by how much one more linear step would lower chi-square: the squared projection of the
    residuals, over their standard deviations, to the columns of all that readings determine. Where
    no standard deviation is known, the scatter is taken for it.
    """
    basis, _ = admissible_steps(state, null_space)
    matrix = state.linearised.matrix if basis is None else state.linearised.matrix @ basis
    matrix = matrix @ spectrum(matrix, FAINT_SINGULAR_RATIO).determined
    lengths = np.linalg.norm(matrix, axis=0)
    along = (matrix / np.where(lengths > 0.0, lengths, 1.0)).T @ state.linearised.vector
    return float(along @ along) / _unit_variance(problem, state)


def is_rounding(problem: CalibrationProblem, state: State) -> bool:
    """Tell whether the residuals are no more than what arithmetic leaves, so that no step means
    anything.
    """
    return state.cost <= problem.readings.count * _rounding_residual(problem) ** 2


def _unit_variance(problem: CalibrationProblem, state: State) -> float:
    """Variance that counts as one, not below what rounding leaves."""
    scatter = 1.0 if problem.readings.known else state.cost / max(problem.readings.count, 1)
    return max(scatter, _rounding_residual(problem) ** 2 / MINIMUM_TOLERANCE, 1e-300)


def _rounding_residual(problem: CalibrationProblem) -> float:
    """A residual that arithmetic leaves."""
    return (
        _ROUNDING_RESIDUAL
        * problem.model.closure.characteristic_length
        * float(np.max(problem.readings.weight, initial=0.0))
    )


@dataclass(eq=False)
class Descent:
    """The iteration: `state` where it stands, `null_space` what is not determined there."""

    problem: CalibrationProblem
    form: Form
    covariance: np.ndarray | None
    state: State
    damping: float = _FIRST_DAMPING
    slow_steps: int = 0
    null_space: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.null_space = undetermined_directions(self.problem, self.state)

    def run(self, limit: int) -> tuple[str, int]:
        """Iterate; return status and number of steps."""
        for count in range(limit):
            if self.slow_steps >= _MAX_SLOW_STEPS or self.is_minimum:
                return "ok", count
            if not self._advance():
                return "ok" if self._promises_nothing else "stalled", count
        return "max_iterations", limit

    @property
    def is_minimum(self) -> bool:
        return remaining_decrease(self.problem, self.state, self.null_space) < MINIMUM_TOLERANCE

    @property
    def _promises_nothing(self) -> bool:
        """Tell whether even the shortest step is expected to gain no more than rounding: what the
        linear model promises of longer ones is then of second order, and not kept.
        """
        fit = self.state.linearised
        step = _DampedSteps(self.state, self.null_space, _MAX_DAMPING).step(fit.vector)
        after = fit.vector + fit.matrix @ step
        return (
            self.state.cost - float(after @ after)
            <= _COST_ROUNDING * self.state.cost
            + MINIMUM_TOLERANCE * _unit_variance(self.problem, self.state) / _MAX_DAMPING
        )

    def _advance(self) -> bool:
        """Take one step that lowers the cost, with as much damping as it needs; tell whether there
        is one.
        """
        failed = 0
        while self.damping < _MAX_DAMPING:
            trial = self._trial_state()
            if trial is not None and merit(trial) < merit(self.state):
                gained = merit(self.state) - merit(trial)
                self.slow_steps = (
                    self.slow_steps + 1 if gained < _NEGLIGIBLE_DECREASE * merit(trial) else 0
                )
                self.damping = (
                    max(self.damping / _DAMPING_DECREASE, _MIN_DAMPING)
                    if failed == 0
                    else self.damping
                )
                self.state = trial
                self.null_space = undetermined_directions(self.problem, trial)
                return True
            failed += 1
            self.damping *= _DAMPING_INCREASE ** max(1, failed - _FAILURES_BEFORE_DOUBLING)
        return False

    def _trial_state(self) -> State | None:
        """Evaluate the state after an accelerated step; None where it bends too much, a
        configuration has no solution, or one passes a singularity.
        """
        step = self._accelerated()
        trial = (
            None if step is None else restored_after(self._moved, self.state, step, self.null_space)
        )
        return (
            trial
            if trial is not None
            and np.array_equal(trial.determinant_signs, self.state.determinant_signs)
            else None
        )

    def _accelerated(self) -> np.ndarray | None:
        """Return a damped step d with half of its acceleration, from the residuals' second
        derivative 2 ((r(d h) - r) / h - J
        d) / h.
        """
        fit, solver = self.state.linearised, _DampedSteps(self.state, self.null_space, self.damping)
        step = solver.step(fit.vector, whole=True)
        probe = self._moved(self.state, _PROBE_SHARE * step) if np.all(np.isfinite(step)) else None
        if probe is None:
            return None
        half = 0.5 * solver.step(
            2.0
            * ((probe.linearised.vector - fit.vector) / _PROBE_SHARE - fit.matrix @ step)
            / _PROBE_SHARE
        )
        lengths = solver.lengths
        return (
            step + half
            if np.linalg.norm(lengths * half) <= _MAX_ACCELERATION * np.linalg.norm(lengths * step)
            else None
        )

    def _moved(self, state: State, step: np.ndarray) -> State | None:
        return state_after(self.problem, state, step, self.form, self.covariance, nested=True)


class _DampedSteps:
    """Minimisers of |r + J d|^2 + damping |D d|^2 over the allowed steps d = particular + B y, D
    the columns' lengths.
    """

    def __init__(self, state: State, null_space: np.ndarray, damping: float) -> None:
        matrix = state.linearised.matrix
        lengths = np.linalg.norm(matrix, axis=0)
        self.lengths = np.maximum(lengths, _MIN_COLUMN_LENGTH * float(np.max(lengths, initial=0.0)))
        basis, self._particular = admissible_steps(state, null_space)
        self._basis = np.eye(matrix.shape[1]) if basis is None else basis
        self._matrix = matrix
        self._q, self._r = np.linalg.qr(matrix @ self._basis)
        self._weights = np.sqrt(damping) * self.lengths[:, None] * self._basis

    def step(self, residuals: np.ndarray, *, whole: bool = False) -> np.ndarray:
        """Return the step for residuals; `whole` with the part that meets the rows left over."""
        begin = self._particular if whole else np.zeros_like(self._particular)
        right = -(self._q.T @ (residuals + self._matrix @ begin))
        above = np.concatenate([right, np.zeros(len(self._weights))])
        return np.asarray(
            begin
            + self._basis
            @ np.linalg.lstsq(np.vstack([self._r, self._weights]), above, rcond=1e-15)[0]
        )
