"""Plan measurements: which configurations, and which wedges under the inclinometer, identify the geometry best.

Candidates are random configurations of the workspace, for groups at the inclination of each wedge. Of these N are chosen by D-, A- or
I-optimality (see `exchange_algorithm`), then moved a little at a time while that helps. I-optimality makes the mean pose variance over
test poses of the workspace least, constant base and tool frames taken away ("aligned") or not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symkin.calibration.data.columns import (
    WEDGE,
    measure_of,
)
from symkin.calibration.data.files import CsvColumns
from symkin.calibration.data.measurements import NO_GROUP
from symkin.calibration.design.exchange_algorithm import CRITERIA, Candidates, Criterion, ExchangeSearch
from symkin.calibration.design.simulation import Noise, check_readings, group_numbers, random_configurations, simulate_readings
from symkin.calibration.estimate.configurations import ClosedConfigurations, solve_systems
from symkin.calibration.estimate.model import build_model
from symkin.calibration.estimate.problem import default_parameters
from symkin.calibration.estimate.residuals import build_readings, whitening
from symkin.calibration.estimate.workspace import Workspace, lever
from symkin.calibration.judge.pose_accuracy import less_frames, pose_slopes, unknown_coordinates
from symkin.errors import InputError
from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import RANK_TOLERANCE

_CANDIDATES_PER_WEDGE, _MAX_CANDIDATES = 150, 3000
"""Candidates for each wedge, and in all."""
_MAX_PLANNED = 1000
"""Most postures that a plan chooses."""
_THINNED_CANDIDATES = 40
"""Candidates of each wedge while sets of wedges are compared."""
_TEST_POSES, _ERROR_DRAWS = 200, 1000
"""Test poses of the prediction, and draws of parameter errors in it."""
_DRAWN_REACH = 1.5
"""Candidates are drawn from so many times the workspace and brought back to its border, where much is to be learnt."""
_REFINEMENT_NEIGHBOURS = 12
"""Neighbours of each posture that one round of refinement tries."""
_REFINEMENT_SCALES = (0.5, 0.3, 0.2, 0.1, 0.05, 0.025)
"""How far the neighbours are, over the workspace, round by round."""
_PRIOR_SIGMA = 0.1
"""Standard deviation of parameters before the data, over the size: weak, so that the first covariance exists."""


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Predicted pose errors at test poses: root mean square, and the largest of all test poses (infinity norm) that 95 %
    of calibrations stay below; length unit and radians. `rank` of `parameters` is observable."""

    position: float
    angle: float
    worst_position: float
    worst_angle: float
    rank: int
    parameters: int


@dataclass(frozen=True, eq=False)
class Plan:
    """Postures in the order of their groups; `groups` (n,) numbers into `wedges` (G, 2), -1 without groups; predicted
    accuracy of the plan, and of as many random postures in as many random groups; `observable` is the rank that these readings
    would reach at many postures."""

    mechanism: Mechanism
    postures: ClosedConfigurations
    groups: np.ndarray
    wedges: np.ndarray
    criterion: Criterion
    seed: int
    accuracy: Accuracy
    random: Accuracy
    observable: int


def corner_wedges(tilt: float) -> np.ndarray:
    """Level, then edges and corners of +-tilt in alpha and beta (9, 2)."""
    steps = (0.0, -tilt, tilt)
    pairs = [(a, b) for a in steps for b in steps]
    return np.array(sorted(pairs, key=lambda p: p[0] ** 2 + p[1] ** 2)) if tilt > 0 else np.zeros((1, 2))


def plan_measurements(
    workspace: Workspace,
    postures: int,
    noise: Noise,
    *,
    groups: int = 5,
    readings: Sequence[str] = (),
    wedges: np.ndarray | None = None,
    criterion: Criterion = "I",
    parameters: Sequence[str] | None = None,
    aligned: bool = True,
    seed: int = 0,
) -> Plan:
    """Choose `postures` in at most `groups` groups (0: none) of the wedges offered, for the given readings and noise.

    Raises InputError for counts that cannot be, and where readings tell nothing of the geometry."""
    if criterion not in CRITERIA:
        raise InputError(f"criterion = {criterion!r} is unknown; allowed: {', '.join(CRITERIA)}")
    if postures > _MAX_PLANNED:
        raise InputError(f"a plan of {postures} postures is asked for; allowed: 1 to {_MAX_PLANNED}")
    group_numbers(postures, groups)
    check_readings(readings)
    if not readings and not groups:
        raise InputError("nothing is read beside the joints; name groups or readings")
    if not groups:
        refuse_ignored({"wedges": wedges}, "there are no groups that stand on them", "ask for groups")
    rng = np.random.default_rng(seed)
    offered = (corner_wedges(workspace.tilt) if wedges is None else np.asarray(wedges, dtype=float)) if groups else None
    task = _Task(workspace, readings, noise, parameters, aligned, rng)
    pool, wedge = _candidates(workspace, offered, postures, rng)
    slopes = task.candidates(pool, wedge)
    task.observe(slopes, 0 if offered is None else len(offered))
    chosen, pool, wedge = _choose(task, pool, wedge, slopes, offered, postures, groups, criterion, rng)
    order = sorted(chosen, key=lambda k: int(wedge[k]))
    used = sorted({int(wedge[k]) for k in order} - {-1})
    numbers = np.array([used.index(int(wedge[k])) if wedge[k] >= 0 else -1 for k in order])
    made = pool.take(np.array(order))
    held = np.zeros((0, 2)) if offered is None else offered[used]
    return Plan(
        workspace.mechanism, made, numbers, held, criterion, seed, task.accuracy(made, numbers),
        _random_accuracy(task, postures, groups, rng), task.directions.shape[1],
    )  # fmt: skip


def _random_accuracy(task: _Task, postures: int, groups: int, rng: np.random.Generator) -> Accuracy:
    numbers = group_numbers(postures, groups)
    return task.accuracy(random_configurations(task.workspace, numbers, Noise(), rng), numbers)


def _candidates(
    workspace: Workspace, offered: np.ndarray | None, postures: int, rng: np.random.Generator
) -> tuple[ClosedConfigurations, np.ndarray]:
    if offered is None:
        count = min(_MAX_CANDIDATES, max(10 * _CANDIDATES_PER_WEDGE, 4 * postures))
        return workspace.draw(workspace.inclinations(count, rng), rng, held=False, edge=_DRAWN_REACH), np.full(count, -1)
    each = max(min(_CANDIDATES_PER_WEDGE, _MAX_CANDIDATES // len(offered)), postures)
    wedge = np.repeat(np.arange(len(offered)), each)
    return workspace.draw(offered[wedge], rng, edge=_DRAWN_REACH), wedge


def _choose(
    task: _Task, pool: ClosedConfigurations, wedge: np.ndarray, slopes: Candidates, offered: np.ndarray | None, postures: int, groups: int,
    criterion: Criterion, rng: np.random.Generator,
) -> tuple[list[int], ClosedConfigurations, np.ndarray]:  # fmt: skip
    """Numbers of the chosen candidates, and the candidates with the neighbours that refinement added."""
    count = 0 if offered is None else len(offered)
    reduced = task.reduced(slopes)
    thin = ExchangeSearch(reduced.thinned(max(_THINNED_CANDIDATES, postures)), count, criterion, task.q, task.prior)
    allowed = thin.best_wedges(postures, groups)
    first = ExchangeSearch(reduced, count, criterion, task.q, task.prior)
    chosen = first.improve(first.greedy(postures, allowed), allowed)
    for scale in _REFINEMENT_SCALES:
        around = np.repeat(chosen, _REFINEMENT_NEIGHBOURS)
        near, kept = task.workspace.near(pool.take(around), None if offered is None else offered[wedge[around]], scale, rng)
        pool = ClosedConfigurations.joined([pool.take(np.array(chosen)), near])
        wedge = np.concatenate([wedge[chosen], wedge[around][kept]])
        local = ExchangeSearch(task.reduced(task.candidates(pool, wedge)), count, criterion, task.q, task.prior)
        chosen = local.improve(list(range(postures)), allowed)
    return chosen, pool, wedge


class _Task:
    """What stays the same while postures are chosen: readings, noise, parameters, test poses, the observable directions."""

    def __init__(
        self, workspace: Workspace, readings: Sequence[str], noise: Noise, parameters: Sequence[str] | None, aligned: bool,
        rng: np.random.Generator,
    ) -> None:  # fmt: skip
        self.workspace, self.readings, self.noise = workspace, tuple(readings), noise
        self.mechanism = workspace.mechanism
        self.names = default_parameters(self.mechanism) if parameters is None else tuple(parameters)
        tests = workspace.draw(workspace.inclinations(_TEST_POSES, rng), rng, held=False)
        slopes, frames = pose_slopes(self.mechanism, tests, self.names)
        self.length = lever(self.mechanism)
        self.pose = less_frames(slopes, frames, self.length) if aligned else slopes
        self.prior = 1.0 / (_PRIOR_SIGMA * self.mechanism.size) ** 2
        self.directions = np.eye(len(self.names))
        self.seed = int(rng.integers(2**31))

    def candidates(self, pool: ClosedConfigurations, wedge: np.ndarray) -> Candidates:
        made = reading_slopes(self.mechanism, pool, self.readings, self.noise, self.names, grouped=bool(np.all(wedge >= 0)))
        return Candidates(made.parameters, made.group, wedge)

    def observe(self, slopes: Candidates, wedges: int) -> None:
        """Keep the directions of parameter space that all candidates together tell."""
        self.directions, _ = _principal_directions(less_inclinations(slopes, wedges))
        if self.directions.shape[1] == 0:
            raise InputError(f"{self.mechanism.name}: these readings tell nothing of the geometry; name other readings")

    def reduced(self, slopes: Candidates) -> Candidates:
        return Candidates(slopes.rows @ self.directions, slopes.group, slopes.wedge)

    @property
    def q(self) -> np.ndarray:
        """Mean of squared pose slopes in the observable directions, angles times the lever."""
        weight = np.array([1.0] * 3 + [self.length] * 3)[:, None]
        flat = (weight * (self.pose @ self.directions)).reshape(-1, self.directions.shape[1])
        return np.asarray(flat.T @ flat / len(self.pose))

    def accuracy(self, made: ClosedConfigurations, groups: np.ndarray) -> Accuracy:
        """What a fit of readings at these postures would reach, by linear propagation."""
        seen, singular = _principal_directions(less_inclinations(self.candidates(made, groups), int(groups.max()) + 1))
        missing = self.directions - seen @ (seen.T @ self.directions)
        left, outside, _ = np.linalg.svd(missing, full_matrices=False)
        unseen = left[:, outside > 1e-6]
        root = np.hstack([seen / np.sqrt(singular**2 + self.prior), unseen / np.sqrt(self.prior)])
        spread = self.pose @ root
        draws = np.random.default_rng(self.seed).normal(size=(root.shape[1], _ERROR_DRAWS))
        errors = np.abs(np.einsum("nkp,pd->nkd", spread, draws))
        worst = [float(np.quantile(errors[:, part].max(axis=(0, 1)), 0.95)) for part in (slice(0, 3), slice(3, 6))]
        variance = np.sum(spread**2, axis=2)
        mean = [float(np.sqrt(variance[:, part].sum(axis=1).mean())) for part in (slice(0, 3), slice(3, 6))]
        return Accuracy(mean[0], mean[1], worst[0], worst[1], seen.shape[1], len(self.names))


def less_inclinations(slopes: Candidates, wedges: int) -> np.ndarray:
    """Rows (n K, P) of postures, the unknown inclination of each group projected out."""
    rows = np.array(slopes.rows)
    for w in range(wedges):
        inside = slopes.wedge == w
        if np.any(inside):
            basis, _ = np.linalg.qr(slopes.group[inside].reshape(-1, slopes.group.shape[2]))
            flat = rows[inside].reshape(-1, rows.shape[2])
            rows[inside] = (flat - basis @ (basis.T @ flat)).reshape(-1, *rows.shape[1:])
    return np.asarray(rows.reshape(-1, rows.shape[2]))


def _principal_directions(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (P, r) that rows tell, and their singular values."""
    triangle = np.linalg.qr(rows, mode="r")
    _, singular, right = np.linalg.svd(triangle, full_matrices=False)
    seen = singular > RANK_TOLERANCE * max(float(singular[0]), 1e-300)
    return right[seen].T, singular[seen]


@dataclass(frozen=True, eq=False)
class ReadingSlopes:
    """Readings over their standard deviations, joint noise included: A (n, K, P) by scaled parameters, and B (n, K, 2) by
    the unknown inclination of the posture's group, zero where it has none."""

    parameters: np.ndarray
    group: np.ndarray


def reading_slopes(
    mechanism: Mechanism,
    made: ClosedConfigurations,
    readings: Sequence[str],
    noise: Noise,
    names: Sequence[str],
    *,
    grouped: bool,
) -> ReadingSlopes:
    """Slopes of the readings that would be taken at closed configurations. Raises InputError where a
    reading is without a standard deviation."""
    quiet = np.random.default_rng(0)
    groups = np.zeros(len(made), dtype=int) if grouped else np.full(len(made), NO_GROUP)
    taken = simulate_readings(mechanism, made, groups, readings, noise, quiet)
    for kind in ("group", "inclination", "position", "orientation"):
        present = grouped if kind == "group" else getattr(taken, kind) is not None
        if present and taken.sigma(kind) is None:
            raise InputError(f"the standard deviation of {kind} readings is zero or not given; a plan needs it")
    model = build_model(mechanism, taken, names)
    values, weights = build_readings(model, taken), noise.joints(mechanism)
    z = unknown_coordinates(mechanism, made)
    e = model.evaluate(z, made.joints, model.nominal, made.poses[:, 3:])
    slopes = e.readings_p - e.readings_z @ solve_systems(e.rows_z, e.rows_p)
    by_joint = e.readings_z @ solve_systems(e.rows_z, model.rows_by_joint(z, made.joints, model.nominal)) * weights
    whiten = whitening(values, by_joint @ by_joint.transpose(0, 2, 1))
    basis = whiten[:, :, values.grouped] if grouped else np.zeros((*whiten.shape[:2], 0))
    return ReadingSlopes(whiten @ slopes, basis)


def plan_text(plan: Plan) -> str:
    """A plan as CSV: group, joint values and the inclination of the group's wedge; what it should reach in comments."""
    table = CsvColumns(plan.mechanism)
    if len(plan.wedges):
        table.text("group", [str(g + 1) for g in plan.groups])
    for k, c in enumerate(plan.mechanism.actuated):
        table.number(c.name, plan.postures.joints[:, k], measure_of(c))
    for k, name in enumerate(WEDGE if len(plan.wedges) else ()):
        table.number(name, plan.wedges[plan.groups, k], "angle")
    comments = [
        f"plan for {plan.mechanism.name}: {len(plan.groups)} postures, {plan.criterion}-optimal, seed {plan.seed}",
        f"expected pose error: {accuracy_text(plan.mechanism, plan.accuracy)}",
        f"the same of random postures: {accuracy_text(plan.mechanism, plan.random)}",
    ]
    return table.csv(comments)


def accuracy_text(mechanism: Mechanism, accuracy: Accuracy) -> str:
    """Predicted errors in the mechanism's units."""
    length, angle = mechanism.length_unit, mechanism.angle_unit
    return (
        f"rms {accuracy.position:.3g} {length} and {mechanism.angle_out(accuracy.angle):.3g} {angle}; largest of 200 test poses in "
        f"95 % of calibrations {accuracy.worst_position:.3g} {length} and {mechanism.angle_out(accuracy.worst_angle):.3g} {angle}"
    )
