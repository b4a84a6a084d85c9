"""Plan measurements: which configurations, and which wedges under the inclinometer, identify the
geometry best.

Candidates are random configurations of the workspace, for groups at the inclination of each wedge.
Of these N are chosen by D-, A- or I-optimality (see `exchange_algorithm`), then moved a little at a
time while that helps. I-optimality makes the mean pose variance over test poses of the workspace
least, constant base and tool frames taken away ("aligned") or not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from itertools import product
from typing import Any, Unpack

import numpy as np

from symkin.calibration.data.columns import WEDGE
from symkin.calibration.data.files import CsvColumns
from symkin.calibration.data.observables import of_joint
from symkin.calibration.design.exchange_algorithm import Candidates, Criterion, ExchangeSearch
from symkin.calibration.design.simulation import (
    Noise,
    PlannedReadings,
    group_numbers,
    names_beside,
    random_configurations,
    taken_readings,
)
from symkin.calibration.estimate.configurations import ClosedConfigurations
from symkin.calibration.estimate.problem import PRIOR_SHARE, default_parameters
from symkin.calibration.estimate.state import evaluate, unbound
from symkin.calibration.estimate.workspace import Workspace, lever
from symkin.calibration.judge.accuracy import pose_slopes
from symkin.calibration.judge.departure import less_frames
from symkin.calibration.judge.identifiability import told_rank
from symkin.calibration.judge.result import length_and_angle
from symkin.calibration.options import PlanOptions
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import RANK_TOLERANCE
from symkin.result import Result, Summary
from symkin.verb import verb
from symkin.verb_options import check_seed, refuse_ignored

_CANDIDATES_PER_WEDGE, _MAX_CANDIDATES = 150, 3000
"""Candidates for each wedge, and in all."""
_MAX_PLANNED = 1000
"""Most configurations that a plan chooses."""
_THINNED_CANDIDATES = 40
"""Candidates of each wedge while sets of wedges are compared."""
_TEST_POSES, _ERROR_DRAWS = 200, 1000
"""Test poses of the prediction, and draws of parameter errors in it."""
_DRAWN_REACH = 1.5
"""Candidates are drawn from so many times the workspace and brought back to its border, where much
is to be learnt.
"""
_REFINEMENT_NEIGHBOURS = 12
"""Neighbours of each configuration that one round of refinement tries."""
_REFINEMENT_SCALES = (0.5, 0.3, 0.2, 0.1, 0.05, 0.025)
"""How far the neighbours are, over the workspace, round by round."""


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Predicted pose errors at test poses: root mean square, and the largest of all test poses
    (infinity norm) that 95 % of calibrations stay below; length unit and radians. `rank` of
    `parameters` is observable.
    """

    position: float
    angle: float
    worst_position: float
    worst_angle: float
    rank: int
    parameters: int

    def text(self, m: Mechanism) -> str:
        """Write the errors in the mechanism's units."""
        worst = length_and_angle(m, self.worst_position, self.worst_angle)
        return (
            f"rms {length_and_angle(m, self.position, self.angle)}; largest of {_TEST_POSES} test "
            f"poses in 95 % of calibrations {worst}"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Result):
    """Configurations in the order of their groups; `groups` (n,) numbers into `wedges` (G, 2), -1
    without groups; predicted accuracy of the plan, and of as many random configurations in as many
    random groups; `observable` is the rank that these readings would reach at many configurations.
    """

    mechanism: Mechanism
    configurations: ClosedConfigurations
    groups: np.ndarray
    wedges: np.ndarray
    criterion: Criterion
    seed: int
    accuracy: Accuracy
    random: Accuracy
    observable: int

    def summary(self, most_rows: int | None = None) -> Summary:
        """List the joints of each configuration with its group, and the pose errors that are
        expected.
        """
        m = self.mechanism
        groups = ["" if g < 0 else str(g + 1) for g in self.groups.tolist()]
        rows = [
            [str(k), g, *(f"{v:.6g}" for v in q)]
            for k, (g, q) in enumerate(zip(groups, self._joints, strict=True), start=1)
        ]
        titles = [f"{c.name} [{m.unit_of(c)}]" for c in m.actuated]
        shown = rows[:most_rows]
        left = [f"the first {len(shown)} of {len(rows)} configurations"]
        notes = [*left[: len(shown) < len(rows)], *self.expected("configurations")]
        return Summary([self.head("configurations")], ["#", "group", *titles], shown, notes)

    def head(self, what: str) -> str:
        """Say what was planned."""
        return (
            f"plan for {self.mechanism.name}: {len(self.groups)} {what}, "
            f"{self.criterion}-optimal, seed {self.seed}"
        )

    def expected(self, what: str) -> list[str]:
        """Say what errors are expected of the plan, and of as many random postures."""
        return [
            f"expected pose error: {self.accuracy.text(self.mechanism)}",
            f"the same of random {what}: {self.random.text(self.mechanism)}",
        ]

    @property
    def _joints(self) -> list[list[float]]:
        """Convert joint values to the mechanism's units."""
        m = self.mechanism
        one = [m.value_out(c, 1.0) for c in m.actuated]
        return (self.configurations.joints * one).tolist()

    def to_dict(self) -> dict[str, Any]:
        """Return the plan in the mechanism's units: joints of each configuration, groups from 0
        (-1: none), wedges, expected errors.
        """
        m = self.mechanism
        return {
            "mechanism": m.name,
            "length_unit": m.length_unit,
            "angle_unit": m.angle_unit,
            "joints": self._joints,
            "groups": self.groups.tolist(),
            "wedges": [[m.angle_out(float(v)) for v in wedge] for wedge in self.wedges],
            "criterion": self.criterion,
            "seed": self.seed,
            "rank": self.accuracy.rank,
            "parameters": self.accuracy.parameters,
            "observable": self.observable,
            "position": self.accuracy.position,
            "angle": m.angle_out(self.accuracy.angle),
            "random_position": self.random.position,
            "random_angle": m.angle_out(self.random.angle),
        }


def corner_wedges(tilt: float) -> np.ndarray:
    """Return level, then edges and corners of +-tilt in alpha and beta (9, 2)."""
    pairs = product((0.0, -tilt, tilt) if tilt > 0 else (0.0,), repeat=2)
    return np.array(sorted(pairs, key=lambda p: p[0] ** 2 + p[1] ** 2))


def _check(options: PlanOptions, configurations: int) -> None:
    """Raise InputError for what cannot be, and for wedges that nothing stands on."""
    if configurations > _MAX_PLANNED:
        raise InputError(
            f"a plan of {configurations} postures is asked for; allowed: 1 to {_MAX_PLANNED}"
        )
    check_seed(options["seed"])
    group_numbers(configurations, options["groups"])
    if not options["readings"] and not options["groups"]:
        raise InputError("nothing is read beside the joints; name groups or readings")
    if not options["groups"]:
        refuse_ignored(
            {"wedges": options["wedges"]},
            "there are no groups that stand on them",
            "ask for groups",
        )


@verb(PlanOptions)
def plan_measurements(
    workspace: Workspace | Mechanism,
    configurations: int,
    noise: Noise | Mapping[str, float],
    **options: Unpack[PlanOptions],
) -> Plan:
    """Choose the configurations whose measurement identifies the geometry best, by exchange of
    random candidates.

    `workspace` says where the platform may go: a Mechanism stands for 0.15 of its size and 20
    degrees about its home. `noise` holds standard deviations, those of a `Noise` by name: lengths,
    angles (of joints), group, inclination, position, orientation (length unit, radians). Each
    configuration stands in one of at most `groups` groups of equal inclination (0: none), at one of
    the `wedges` (W, 2), radians, by default level and the edges and corners of the workspace's
    tilt; `readings` are read beside the joints (see `READING_CHOICES` and `data.observables`).
    `parameters` are to be identified, by default all that matter; poses are judged after the best
    alignment of constant base and tool frames unless `aligned` is False; `seed` is that of the
    candidates. By the `criterion` "D", "A" or "I", of the Fisher information M of the observable
    parameters, D-optimality makes det M largest, A-optimality trace M^-1 least, I-optimality the
    mean variance of poses over the workspace least.

    Raises InputError for counts that cannot be, and where readings determine nothing of the
    geometry. Source: Atkinson and Donev, Optimum Experimental Designs, 1992.

    >>> import symkin
    >>> noise = {"angles": 1e-4, "position": 0.05}
    >>> plan = symkin.plan_measurements(
    ...     symkin.load("gluon_6l3"), 6, noise, groups=0, readings=["position"],
    ...     parameters=["dh.1.d", "dh.2.a"]
    ... )
    >>> len(plan.groups), plan.accuracy.rank
    (6, 2)
    """
    workspace = Workspace.about(workspace) if isinstance(workspace, Mechanism) else workspace
    if not isinstance(noise, Noise):
        allowed = [f.name for f in fields(Noise)]
        if unknown := ", ".join(repr(name) for name in noise if name not in allowed):
            raise InputError(f"noise: {unknown} is unknown; allowed: {', '.join(allowed)}")
        noise = Noise(**noise)  # type: ignore[arg-type]
    _check(options, configurations)
    taken_readings(workspace.mechanism, options["readings"], grouped=options["groups"] > 0)
    task = _Task(workspace, configurations, noise, options)
    chosen, wedge = task.chosen_candidates()
    order = np.argsort(wedge, kind="stable")
    used = sorted(set(wedge.tolist()) - {-1})
    numbers = np.array([used.index(w) if w >= 0 else -1 for w in wedge[order].tolist()])
    planned = chosen.take(order)
    groups = group_numbers(configurations, options["groups"])
    drawn = random_configurations(workspace, groups, Noise(), task.rng)
    return Plan(
        mechanism=workspace.mechanism,
        configurations=planned,
        groups=numbers,
        wedges=np.zeros((0, 2)) if task.offered is None else task.offered[used],
        criterion=options["criterion"],
        seed=options["seed"],
        accuracy=task.accuracy(planned, numbers),
        random=task.accuracy(drawn, groups),
        observable=task.observable,
    )


_Pool = tuple[ClosedConfigurations, np.ndarray]
"""Candidates, and the number of the wedge (n,) that each stands on, -1 for none."""


class _Task:
    """What stays the same while configurations are chosen: readings, noise, parameters, test poses,
    the observable directions.
    """

    def __init__(
        self, workspace: Workspace, count: int, noise: Noise, options: PlanOptions
    ) -> None:
        self.workspace, self.count, self.options = workspace, count, options
        self.mechanism, self.rng = workspace.mechanism, np.random.default_rng(options["seed"])
        read = names_beside(self.mechanism, options["readings"])
        self.names = (
            default_parameters(self.mechanism, read)
            if options["parameters"] is None
            else tuple(options["parameters"])
        )
        self.planned = PlannedReadings(self.mechanism, options["readings"], noise, self.names)
        told = options["wedges"]
        wedges = corner_wedges(workspace.lean) if told is None else np.asarray(told, dtype=float)
        self.offered = wedges if options["groups"] else None
        tests = workspace.draw(workspace.inclinations(_TEST_POSES, self.rng), self.rng, held=False)
        slopes, loops = pose_slopes(self.mechanism, tests, self.names)
        # steps with which redundant loops stay closed all over the workspace
        allowed = unbound(loops.reshape(-1, len(self.names)))
        self.allowed = allowed @ allowed.T
        self.length = lever(self.mechanism)
        self.pose = less_frames(slopes, tests.poses, self.length) if options["aligned"] else slopes
        self.prior = 1.0 / (PRIOR_SHARE * self.mechanism.characteristic_length) ** 2
        self.directions = np.eye(len(self.names))
        self.seed = int(self.rng.integers(2**31))

    def chosen_candidates(self) -> _Pool:
        """Choose candidates by exchange, then exchange each for random neighbours, nearer and
        nearer.
        """
        made, wedge = self._drawn()
        slopes = self.candidates(made, wedge)
        # the directions of parameter space that all candidates together determine
        self.directions, _ = _principal_directions(less_inclinations(slopes, self._wedges))
        if not self.directions.size:
            raise InputError(
                f"{self.mechanism.name}: these readings determine nothing of the geometry; name "
                f"other readings"
            )
        self.observable = self.rank(made, wedge)
        reduced = self.reduced(slopes)
        allowed = self._search(reduced.thinned(max(_THINNED_CANDIDATES, self.count))).best_wedges(
            self.count, self.options["groups"]
        )
        first = self._search(reduced)
        kept = np.array(first.improve(first.greedy(self.count, allowed), allowed))
        for scale in _REFINEMENT_SCALES:
            each = np.repeat(kept, _REFINEMENT_NEIGHBOURS)
            wedges = None if self.offered is None else self.offered[wedge[each]]
            near, rows = self.workspace.near(made.take(each), wedges, scale, self.rng)
            made = ClosedConfigurations.joined([made.take(kept), near])
            wedge = np.append(wedge[kept], wedge[each[rows]])
            local = self._search(self.reduced(self.candidates(made, wedge)))
            kept = np.array(local.improve(list(range(self.count)), allowed, passes=2))
        return made.take(kept), wedge[kept]

    def _drawn(self) -> _Pool:
        """Draw random candidates, for each wedge as many."""
        draw, rng = self.workspace.draw, self.rng
        if self.offered is None:
            count = min(_MAX_CANDIDATES, max(10 * _CANDIDATES_PER_WEDGE, 4 * self.count))
            drawn = draw(
                self.workspace.inclinations(count, rng), rng, held=False, edge=_DRAWN_REACH
            )
            return drawn, np.full(count, -1)
        each = max(min(_CANDIDATES_PER_WEDGE, _MAX_CANDIDATES // len(self.offered)), self.count)
        wedge = np.repeat(np.arange(len(self.offered)), each)
        return draw(self.offered[wedge], rng, edge=_DRAWN_REACH), wedge

    def _search(self, candidates: Candidates) -> ExchangeSearch:
        return ExchangeSearch(
            candidates, self._wedges, self.options["criterion"], self.q, self.prior
        )

    @property
    def _wedges(self) -> int:
        return 0 if self.offered is None else len(self.offered)

    def candidates(self, pool: ClosedConfigurations, wedge: np.ndarray) -> Candidates:
        rows, group = self.planned.slopes(pool, grouped=bool(np.all(wedge >= 0)))
        return Candidates(rows @ self.allowed, group, wedge)

    def rank(self, made: ClosedConfigurations, groups: np.ndarray) -> int:
        """Count the combinations of parameters that a fit of readings there determines."""
        problem, z = self.planned.problem(made, groups)
        return told_rank(problem, evaluate(problem, problem.model.nominal, z))

    def reduced(self, slopes: Candidates) -> Candidates:
        return Candidates(slopes.rows @ self.directions, slopes.group, slopes.wedge)

    @property
    def q(self) -> np.ndarray:
        """Average squared pose slopes in the observable directions, angles times the lever."""
        weight = np.array([1.0] * 3 + [self.length] * 3)[:, None]
        flat = (weight * (self.pose @ self.directions)).reshape(-1, self.directions.shape[1])
        return flat.T @ flat / len(self.pose)

    def accuracy(self, planned: ClosedConfigurations, groups: np.ndarray) -> Accuracy:
        """Predict what a fit of readings at these configurations would reach, by linear
        propagation.
        """
        seen, singular = _principal_directions(
            less_inclinations(self.candidates(planned, groups), groups.max() + 1)
        )
        missing = self.directions - seen @ (seen.T @ self.directions)
        left, outside, _ = np.linalg.svd(missing, full_matrices=False)
        unseen = left[:, outside > 1e-6]
        root = np.hstack([seen / np.sqrt(singular**2 + self.prior), unseen / np.sqrt(self.prior)])
        spread = self.pose @ root
        draws = np.random.default_rng(self.seed).normal(size=(root.shape[1], _ERROR_DRAWS))
        errors = np.abs(np.einsum("nkp,pd->nkd", spread, draws))
        position, angle = (
            float(np.sqrt(np.mean(np.sum(part**2, axis=(1, 2)))))
            for part in np.split(spread, 2, axis=1)
        )
        worst_position, worst_angle = (
            float(np.quantile(part.max(axis=(0, 1)), 0.95)) for part in np.split(errors, 2, axis=1)
        )
        rank, count = self.rank(planned, groups), len(self.names)
        return Accuracy(position, angle, worst_position, worst_angle, rank, count)


def less_inclinations(slopes: Candidates, wedges: int) -> np.ndarray:
    """Project the unknown inclination of each group out of the rows of configurations (n K, P)."""
    rows = np.array(slopes.rows)
    for w in range(wedges):
        inside = slopes.wedge == w
        if inside.any():
            basis, _ = np.linalg.qr(slopes.group[inside].reshape(-1, slopes.group.shape[2]))
            flat = rows[inside].reshape(-1, rows.shape[2])
            rows[inside] = (flat - basis @ (basis.T @ flat)).reshape(-1, *rows.shape[1:])
    return rows.reshape(-1, rows.shape[2])


def _principal_directions(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions (P, r) that rows determine, and their singular values."""
    triangle = np.linalg.qr(rows, mode="r")
    _, singular, right = np.linalg.svd(triangle, full_matrices=False)
    seen = singular > RANK_TOLERANCE * max(singular[0], 1e-300)
    return right[seen].T, singular[seen]


def plan_text(plan: Plan) -> str:
    """Write a plan as CSV: group, joint values and the inclination of the group's wedge; what it
    should reach in comments.
    """
    table = CsvColumns(plan.mechanism)
    if len(plan.wedges):
        table.text("group", *(plan.groups + 1))
    for k, c in enumerate(plan.mechanism.actuated):
        table.number(c.name, plan.configurations.joints[:, k], of_joint(c).measure)
    for k, name in enumerate(WEDGE if len(plan.wedges) else ()):
        table.number(name, plan.wedges[plan.groups, k], "angle")
    return table.csv([plan.head("postures"), *plan.expected("postures")])
