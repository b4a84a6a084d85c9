"""Estimate parameters: least squares of the readings with a prior, by Levenberg-Marquardt.

min |r(p)|^2 + w^2 |(p - nominal) / s|^2

with residuals r over their standard deviations, every configuration condensed (see `state`), s the
prior's standard deviations (see `problem`) and w = 1; where the noise is unknown w^2 is the
residual variance. What no reading tells stays where the prior has it, at the least change from
nominal: rigid frames are then a best fit of the joints to nominal (Procrustes). Rows that the
unknown coordinates cannot meet (overconstrained mechanisms) constrain p: every step keeps
C dp = -c.

Steps are taken in prior units, d = dp / s, by the singular values of the columns brought to equal
lengths; damping tightens the prior about where the iteration stands. A trial is refused where a
configuration has no solution or passes a singularity. Where what is hardly told lies along a bent
valley, steps bend with it (geodesic acceleration, Transtrum and Sethna 2012). It ends by the Newton
decrement, what one more step would gain. A geometry that went further than the prior lets expect
widens it. The prior pulls what the readings tell by far towards nominal, too; the last steps are
without it in the directions that they tell ten times better than the prior.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.estimate.configurations import Closing, is_carried, start_points
from symkin.calibration.estimate.problem import CalibrationProblem
from symkin.calibration.estimate.residuals import Linearised
from symkin.calibration.estimate.state import (
    UNTOLD,
    WELL_TOLD,
    Linear,
    State,
    closed_state,
    evaluate,
    evaluate_at,
    joint_covariance,
    restored_after,
    rounding_residual,
    state_after,
)
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.numeric.linear_algebra import largest_of
from symkin.numeric.system import NOTHING

_MINIMUM_DECREMENT = 1e-6
"""The iteration ends when one more step would gain less than this, in variances: next to nothing
beside the chance fluctuation of chi-square.
"""
_STALLED_DECREMENT = 1e-3
"""An iteration that finds no lower cost stands at the minimum where not even this could be gained:
configurations are closed to first order on the way.
"""
_COST_ROUNDING = 1e-12
"""Share of the cost that counts as rounding of it."""
_DAMPING_INCREASE, _DAMPING_DECREASE, _MAX_DAMPING = 10.0, 0.1, 1e12
"""Factors of the damping after a step that fails (it begins with the prior's weight) and one that
does not, and the damping at which no step is left.
"""
_MAX_UNSHRUNK_STEPS, _CONVERGED_STEP = 8, 1e-13
"""Most steps without the prior, and their length, of the size, at which they end."""
_GOOD_GAIN, _POOR_GAIN, _POOR_INCREASE = 0.75, 0.5, 4.0
"""Share of what the linear model promised from which on there is less damping, that below which
there is more, and its factor: steps that go too far go to and fro.
"""
_PROBED, _MAX_BEND = 0.1, 1.5
"""Share of a step by which second derivatives are found, and how many times the step what they ask
for may be.
"""
_WIDENED, _MAX_PRIOR_CHANGE, _MAX_WIDENINGS = 3.0, 3.0, 8
"""The prior is widened by this factor while a parameter is further from nominal than so many of its
standard deviations, so many times at most; a step that goes further than that, beyond where it
begins, is damped.
"""
_MAX_POSES, _MAX_POSE_STEPS = 2000, 40
"""Most configurations and steps at measured poses: a start needs no more."""
_MAX_PASSIVE_STEPS, _PASSIVE_STEPS = 60, 4
"""Most steps of passive joints at a pose from the reference, and from where they were."""
_LEFTOVER_TOLERANCE = 1e-9
"""Rows left over are met to this, of the size."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Where an estimation ended: `state` with closed configurations; status "ok", "max_iterations"
    or "stalled"; the number of steps; by what factor the prior was widened.
    """

    state: State
    status: str
    iterations: int
    widened: float


def estimate(
    problem: CalibrationProblem,
    z: np.ndarray,
    *,
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
            return _minimise(problem, begin, z, max_iterations)
        result = _minimise(problem.by_means, begin, z, max_iterations)
        for _ in range(2):
            noise = joint_covariance(problem, result.state.p, result.state.z)
            wide = replace(problem, widened=result.widened, noise=noise)
            again = _minimise(wide, result.state.p, result.state.z, max_iterations)
            result = replace(again, iterations=result.iterations + again.iterations)
    return result


def is_rounding(problem: CalibrationProblem, state: State) -> bool:
    """Tell whether the residuals are no more than what arithmetic leaves, so that no step means
    anything.
    """
    return state.cost <= problem.readings.count * rounding_residual(problem) ** 2


def parameters_at_poses(problem: CalibrationProblem) -> np.ndarray | None:
    """Estimate the parameters (P,) from nominal at the measured poses, without a direct problem
    (see `_at_poses`); None where too few poses are whole, where frames between mechanism and
    measurement are unknown, and where the joints carry the platform.
    """
    model, m = problem.model, problem.measurements
    given = np.isfinite(m.poses[:, 0])
    rows = given.sum() * model.system.rows.shape[0]
    if is_carried(model.closure) or model.observes_through_frames or rows < len(model.names):
        return None
    chosen = np.flatnonzero(given)
    here = problem.of(chosen[spread_rows(len(chosen), _MAX_POSES)])

    def moved(by_rows: bool, state: State, step: np.ndarray) -> State | None:
        """Take a step of the parameters; None where nothing finite is there."""
        p = state.p + model.scales * step
        found = _at_poses(here, p, state.z, _PASSIVE_STEPS, by_rows=by_rows)
        return found if np.isfinite(found.cost) else None

    near, far = (partial(moved, by_rows) for by_rows in (False, True))
    still, start = np.zeros(len(model.names)), start_points(model, here.measurements, measured=True)
    with np.errstate(all="ignore"):
        first = _at_poses(here, model.nominal, start, _MAX_PASSIVE_STEPS, by_rows=False)
        search = _Search(here, near, first, bends=False)
        if not np.isfinite(first.cost) or is_rounding(here, first):
            return None
        if search.run(_MAX_POSE_STEPS) == "ok":
            return search.state.p
        best, begin = search.state, far(first, still)
        if begin is not None:
            other = _Search(here, far, begin, bends=False)
            other.run(_MAX_POSE_STEPS)
            last = near(other.state, still)
            best = best if last is None or last.cost > best.cost else last
    return best.p


def _minimise(problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, limit: int) -> Estimate:
    state = closed_state(problem, p, z)
    if is_rounding(problem, state):
        return Estimate(state, "ok", 0, 1.0)
    search = _Search(problem, partial(state_after, problem), state)
    status = search.run(limit)
    best = closed_state(problem, search.state.p, search.state.z)
    return Estimate(best, status, search.steps, search.problem.widened)


# --- at measured poses ----------------------------------------------------------------------------


def _at_poses(
    problem: CalibrationProblem, p: np.ndarray, z: np.ndarray, steps: int, *, by_rows: bool
) -> State:
    """The residuals at the poses measured: passive joints at which the closure is met best there,
    and the closure to first order in the pose. No direct problem is solved, so that it leads far.
    `by_rows`: the closure rows over the readings' usual standard deviation in their place, which
    leads further, to where is near the estimate.
    """
    model, joints = problem.model, problem.joints
    closing, points = Closing(model, p, held=("joints", "pose")), np.hstack([joints, z])
    if closing.freedom:
        points = levenberg_marquardt(closing, points, NOTHING, max_iterations=steps).points
        z = closing.split(points)[0]
    # poses that are measured are of one mode, whatever the geometry
    state = replace(evaluate(problem.by_means, p, z), determinant_signs=np.zeros(len(z)))
    if not by_rows:
        return state
    e = evaluate_at(problem, p, z)
    passive = closing.linearise(points)[1]
    project = np.eye(e.rows.shape[1]) - passive @ np.linalg.pinv(passive, rcond=1e-10)
    usual = np.median((problem.readings.sigma * model.lengths)[problem.readings.taken])
    rows = Linearised.of(e.rows / usual, project @ e.rows_p / usual)
    return replace(state, linearised=rows, leftover=None)


# --- iteration ------------------------------------------------------------------------------------


@dataclass(eq=False)
class _Search:
    """The iteration: where it stands, how many steps it took, whether steps may bend with a
    valley, and whether one has gained less than it promised. It widens the prior of its problem.
    """

    problem: CalibrationProblem
    move: Callable[[State, np.ndarray], State | None]
    state: State
    damping: float = 0.0
    steps: int = 0
    bends: bool = True
    is_curved: bool = False

    def run(self, limit: int) -> str:
        """Iterate; return the status."""
        while True:
            status = self._descend(limit)
            near = self._change <= _MAX_PRIOR_CHANGE
            if status != "ok" or self.problem.is_stated or near:
                break
            if self.problem.widened >= _WIDENED**_MAX_WIDENINGS:
                break
            self.problem = replace(self.problem, widened=_WIDENED * self.problem.widened)
        if status == "ok" and not self.problem.is_stated:
            self._unshrink()
        return status

    def _descend(self, limit: int) -> str:
        """Iterate with the prior as wide as it is."""
        while True:
            linear = Linear.of(self.problem, self.state)
            solver, weight = _Damped(linear), linear.weight
            if not solver.is_finite:
                return "stalled"
            met = _unmet(self.state) <= _LEFTOVER_TOLERANCE * self.problem.size
            if met and solver.decrement < _MINIMUM_DECREMENT * weight**2:
                return "ok"
            if self.steps >= limit:
                return "max_iterations"
            if not self._advance(solver, weight):
                # what the linear model promises and no step keeps is rounding
                bound = max(_COST_ROUNDING * self.state.cost, _STALLED_DECREMENT * weight**2)
                return "ok" if solver.decrement < bound else "stalled"

    def _advance(self, solver: _Damped, weight: float) -> bool:
        """Take one step that lowers the cost, with as much damping as it needs; tell whether there
        is one.
        """
        before, unit = self._cost(self.state, weight), max(weight**2, 1e-300)
        furthest = _MAX_PRIOR_CHANGE + self._change
        while self.damping < _MAX_DAMPING:
            step, promised = solver.step(self.damping)
            trial = None
            if largest_of(step / self.problem.spread) < furthest:
                step = self._along_valley(solver, step)
                trial = restored_after(self.move, self.state, step)
                self.steps += 1
            if trial is not None and self._is_better(trial, before, weight):
                gained = (before - self._cost(trial, weight)) / max(promised, 1e-300)
                self.is_curved |= gained < _GOOD_GAIN
                if gained > _GOOD_GAIN:
                    self.damping *= _DAMPING_DECREASE
                elif gained < _POOR_GAIN:
                    self.damping = max(_POOR_INCREASE * self.damping, 0.1 * unit)
                if self.damping < 1e-3 * unit:
                    self.damping = 0.0
                self.state = trial
                return True
            self.is_curved = True
            self.damping = max(_DAMPING_INCREASE * self.damping, unit)
        self.damping = 0.0
        return False

    def _along_valley(self, solver: _Damped, step: np.ndarray) -> np.ndarray:
        """Bend a step as the valley bends that earlier ones have left: the residuals' second
        derivative along it, by a part of it, asks for half a step more.
        """
        here = self.state.linearised
        near = self.move(self.state, _PROBED * step) if self.bends and self.is_curved else None
        if near is None or near.values is None:  # of many configurations only triangles are known
            return step
        rise = (near.linearised.vector - here.vector) / _PROBED - here.matrix @ step
        more = solver.against(here.matrix.T @ (2.0 / _PROBED * rise), self.damping)
        spread = self.problem.spread
        units = np.where(np.isfinite(spread), spread, 1.0)
        most = _MAX_BEND * np.linalg.norm(step / units)
        return step + 0.5 * more if np.linalg.norm(more / units) <= most else step

    def _is_better(self, trial: State, before: float, weight: float) -> bool:
        """Tell whether a trial lowers the cost, or meets rows left over that were not met, in the
        assembly mode of where the iteration stands: det F_z changes its sign only between modes.
        """
        if not trial.is_in_mode_of(self.state):
            return False
        here, there = _unmet(self.state), _unmet(trial)
        least = _LEFTOVER_TOLERANCE * self.problem.size
        if there > max(least, 0.5 * here):
            return False
        return here > least or self._cost(trial, weight) < before

    def _unshrink(self) -> None:
        """Take the last steps: without the prior in the directions that readings tell by far,
        without the readings in those that they do not tell, with both in the others.
        """
        last = np.inf
        for _ in range(_MAX_UNSHRUNK_STEPS):
            linear = Linear.of(self.problem, self.state)
            told = linear.told()
            well, silent = told.ratios > WELL_TOLD, told.inner[:, told.ratios < UNTOLD]
            free, rest = told.inner[:, well], told.inner[:, ~well]
            y = -free @ (told.gains[well] * ((linear.jacobian @ free).T @ linear.residuals))
            solver = _Damped(linear)
            matrix = solver.matrix.copy()
            matrix[: len(silent)] -= linear.jacobian @ silent @ silent.T
            y += rest @ np.linalg.lstsq(matrix @ rest, solver.right, rcond=None)[0]
            step = linear.particular + linear.basis @ y
            length = largest_of(step) / self.problem.size
            if not _CONVERGED_STEP < length < 0.9 * last:
                return
            trial = restored_after(self.move, self.state, step)
            if trial is None or not trial.is_in_mode_of(self.state):
                return
            self.state, last = trial, length
            self.steps += 1

    def _cost(self, state: State, weight: float) -> float:
        return state.cost + float(np.sum((weight * self.problem.over_prior(state.p)) ** 2))

    @property
    def _change(self) -> float:
        """The largest change of a parameter from nominal over its prior standard deviation."""
        return largest_of(self.problem.over_prior(self.state.p))


def _unmet(state: State) -> float:
    """The largest row left over."""
    return 0.0 if state.leftover is None else largest_of(state.leftover[0])


class _Damped:
    """Steps of the linear model with the prior of weight w and damping, of columns brought to equal
    lengths. `decrement` is what the step without damping would gain, by the linear model.
    """

    def __init__(self, linear: Linear) -> None:
        self._linear = linear
        self.matrix = np.vstack([linear.jacobian, linear.weight * linear.tight])
        self.right = -np.concatenate([linear.residuals, linear.weight * linear.change])
        self.is_finite = bool(np.isfinite(self.matrix).all() and np.isfinite(self.right).all())
        self._lengths = np.maximum(np.linalg.norm(self.matrix, axis=0), 1e-300)
        if self.is_finite:
            self._free = self._solved(0.0, self.right)
            self._told = self.matrix @ self._free
            self.decrement = self._told @ self._told

    def _solved(self, damping: float, right: np.ndarray) -> np.ndarray:
        weak = np.sqrt(damping) * np.diag(1.0 / self._lengths)[: None if damping > 0.0 else 0]
        above = np.vstack([self.matrix / self._lengths, weak])
        right = np.append(right, np.zeros(len(weak)))
        return np.linalg.lstsq(above, right, rcond=None)[0] / self._lengths

    def step(self, damping: float) -> tuple[np.ndarray, float]:
        """Return the change (P,) of the scaled parameters, and its gain by the linear model."""
        y = self._solved(damping, self.right) if damping > 0.0 else self._free
        after = self.matrix @ y - self._told
        step = self._linear.particular + self._linear.basis @ y
        return step, self.decrement - float(after @ after)

    def against(self, gradient: np.ndarray, damping: float) -> np.ndarray:
        """Return the change (P,) that makes residuals with this gradient J^T r least."""
        inner, triangle = self._linear.basis.T @ gradient, self._linear.jacobian
        residuals = np.linalg.lstsq(triangle.T, inner, rcond=None)[0]
        right = -np.append(residuals, np.zeros(len(self.right) - len(residuals)))
        return self._linear.basis @ self._solved(damping, right)
