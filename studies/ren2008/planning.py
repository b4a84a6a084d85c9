"""XJ-HEXAS: chosen postures, the paper's further work: 24 planned poses, and 40 planned against 40
random ones.

The plan is computed for the nominal geometry by I-optimality (pose variance over the assumed
workspace, constant base and tool frames taken away) over groups at level and at +-20 deg. True
mechanisms are then brought to the planned poses, each group to its inclination as far as the
inclinometer repeats. Random postures: 10 groups of 4 by the generator of `method`. Rod noise
uniform within +-1 um, inclinometer within +-0.0005 deg. Units: m, deg.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import symkin
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.design.planning import Plan, plan_measurements
from symkin.calibration.design.simulation import Noise
from symkin.calibration.estimate.workspace import Workspace
from symkin.calibration.judge.result import Calibration

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.ren2008.errors import PoseErrors, pose_errors
from studies.ren2008.method import (
    BEST,
    Fits,
    centres_of,
    fit,
    measure,
    measure_at,
    posture_of,
    random_truth,
    unused_poses,
)
from studies.ren2008.model import ASIDE, HEIGHTS, TILT, Case, eta_from
from studies.shared.report import Report, new_figure, options_parser

SEED = 8
WANTED = (0.1, 0.01)
PLACE = "3, outlook"
GROUPS = {24: 3, 40: 5}
GEOMETRIES, EACH = 20, 4
MARGIN = 0.02


@dataclass(frozen=True, eq=False)
class Chosen:
    """Planned postures X (n, 6) and their group numbers (n,), as the plan gives them."""

    X: np.ndarray
    groups: np.ndarray

    def evidence(self) -> dict[str, object]:
        return {
            "by": "symkin.plan_measurements",
            "method": "I-optimal",
            "text": f"plan_measurements, {len(self.X)} postures",
        }

    @property
    def inclinations(self) -> list[list[float]]:
        """alpha, beta [deg] and the number of postures of each group."""
        held = [
            np.round(np.degrees(self.X[self.groups == g][0, 3:5])) + 0.0
            for g in np.unique(self.groups)
        ]
        return [
            [*pair.tolist(), int(np.sum(self.groups == g))]
            for pair, g in zip(held, np.unique(self.groups), strict=True)
        ]


def workspace(nominal: symkin.Mechanism) -> Workspace:
    """The assumed workspace; the range of rods with a margin for the unknown geometry."""
    half = np.array([ASIDE, ASIDE, 0.5 * (HEIGHTS[1] - HEIGHTS[0])])
    return Workspace(nominal, half, tilt=np.radians(TILT), spin=np.radians(TILT), margin=MARGIN)


def make_plan(nominal: symkin.Mechanism, postures: int) -> Plan:
    rod, tilt = BEST.sigmas
    noise = Noise(lengths=rod, group=tilt, uniform=True)
    return plan_measurements(
        workspace(nominal), postures, noise, groups=GROUPS[postures], seed=SEED
    )


def chosen(plan: Plan) -> Chosen:
    return Chosen(
        posture_of([symkin.Pose(row[:3], row[3:]) for row in plan.configurations.poses]),
        plan.groups,
    )


@dataclass(frozen=True, eq=False)
class Trials:
    """Repeated experiments: each fit and its errors at the unused poses, aligned frames."""

    fits: list[Calibration]
    errors: list[PoseErrors]

    def evidence(self) -> dict[str, object]:
        return Fits(self.fits).evidence()

    @property
    def worst(self) -> np.ndarray:
        """(n, 2): mm, deg."""
        return np.array([e.worst for e in self.errors])

    def within(self, wanted: tuple[float, float]) -> float:
        """Percent of the experiments with both errors within what is wanted."""
        return 100 * float(np.mean(np.all(self.worst <= wanted, axis=1)))


def planned(
    case: Case,
    truth: np.ndarray,
    at: Chosen,
    tests: np.ndarray,
    rngs: Iterable[np.random.Generator],
) -> Trials:
    """Experiments at planned postures, group means."""
    return trials(
        case, truth, tests, (measure_at(truth, at.X, at.groups, BEST, rng) for rng in rngs)
    )


def random(
    case: Case, truth: np.ndarray, tests: np.ndarray, rngs: Iterable[np.random.Generator]
) -> Trials:
    """Experiments at 40 random postures, 10 groups of 4, group means."""
    return trials(case, truth, tests, (measure(truth, 10, 4, BEST, rng) for rng in rngs))


def trials(
    case: Case, truth: np.ndarray, tests: np.ndarray, measured: Iterable[Measurements]
) -> Trials:
    fits = [fit(case.nominal, readings) for readings in measured]
    errors = [
        pose_errors(eta_from(f.values, case.eta), truth, case.eta, tests)["aligned"] for f in fits
    ]
    return Trials(fits, errors)


def compare(case: Case, at: Chosen) -> np.ndarray:
    """(geometries, 4): root mean square over experiments of the worst errors, planned and random,
    mm and deg.
    """
    rows = []
    for k in range(GEOMETRIES):
        rng = np.random.default_rng([SEED, 20, k])
        truth = random_truth(case.nominal, 0.005, rng)
        tests = unused_poses(truth, SEED + k, 100)
        both = [
            planned(case, truth, at, tests, [rng] * EACH),
            random(case, truth, tests, [rng] * EACH),
        ]
        rows.append(np.sqrt(np.mean([t.worst**2 for t in both], axis=1)).ravel())
    return np.array(rows)


def report_24(report: Report, case: Case, tests: np.ndarray, count: int) -> tuple[Chosen, Trials]:
    """Fewer postures than the paper's 80, chosen: what they reach."""
    begin = time.perf_counter()
    at = chosen(make_plan(case.nominal, 24))
    seconds = time.perf_counter() - begin
    report.row(
        "24 planned postures: alpha, beta [deg] and postures of each group",
        None,
        at.inclinations,
        place=PLACE,
        run=at,
    )
    report.row(
        "time of a plan of 24 postures",
        None,
        round(seconds, 1),
        "s",
        place=PLACE,
        run=at,
        volatile=True,
    )
    trials = planned(case, case.truth, at, tests, [case.rng(24, k) for k in range(count)])
    report.row(
        f"24 planned postures, {BEST}, aligned frames: worst errors, median",
        None,
        np.median(trials.worst, axis=0).tolist(),
        "mm, deg",
        place=PLACE,
        run=(at, trials),
    )
    report.row(
        "24 planned postures, aligned frames: experiments within what the paper reaches with 80, "
        "0.1 mm and 0.01 deg",
        None,
        trials.within(WANTED),
        "%",
        place=PLACE,
        run=(at, trials),
    )
    return at, trials


def report_40(report: Report, at: Chosen, table: np.ndarray) -> None:
    for k, what in enumerate(("position", "orientation")):
        ratio = table[:, 2 + k] / table[:, k]
        report.row(
            f"{GEOMETRIES} geometries, 40 postures, random over planned {what} error, aligned "
            f"frames: mean, median, least",
            None,
            [
                float(np.mean(table[:, 2 + k]) / np.mean(table[:, k])),
                float(np.median(ratio)),
                float(ratio.min()),
            ],
            place=PLACE,
            run=(at, compare),
        )


def draw(at: Chosen, trials: Trials, table: np.ndarray):
    figure = new_figure(15, 4.8)
    figure.suptitle("XJ-HEXAS: chosen postures", fontsize=14)
    left, centre, right = figure.subplots(1, 3)
    for group, (alpha, beta, count) in enumerate(at.inclinations):
        places = centres_of(at.X[at.groups == group])
        left.scatter(
            *places[:, :2].T, s=60, label=f"{count} at alpha {alpha:+.0f}, beta {beta:+.0f} deg"
        )
    left.set(xlabel="x of the platform's circle [m]", ylabel="y [m]", aspect="equal")
    left.set_title("24 postures from above", loc="left")
    left.legend(fontsize=9, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.16))
    centre.scatter(*trials.worst.T, s=18, color="#0072b2")
    centre.axvline(WANTED[0], color="#d55e00", ls="--", lw=1)
    centre.axhline(WANTED[1], color="#d55e00", ls="--", lw=1)
    limits = 1.1 * np.maximum(WANTED, trials.worst.max(axis=0))
    centre.set(
        xlabel="worst position error, aligned frames [mm]",
        ylabel="worst orientation error, aligned frames [deg]",
        xlim=(0, limits[0]),
        ylim=(0, limits[1]),
    )
    centre.set_title(f"{len(trials.fits)} experiments at 24 postures; dashed: wanted", loc="left")
    places = np.arange(1, len(table) + 1)
    right.semilogy(places, table[:, 2], "s", color="#d55e00", label="40 random (10 x 4)")
    right.semilogy(places, table[:, 0], "o", color="#0072b2", label="40 planned")
    right.set(
        xlabel="geometry",
        ylabel="worst position error, aligned frames [mm]",
        xticks=places[::2] + 1,
    )
    right.set_title(f"{GEOMETRIES} true geometries", loc="left")
    right.set_ylim(top=3 * right.get_ylim()[1])
    right.legend(fontsize=9, frameon=False, loc="upper right", ncols=2)
    for axes in (left, centre, right):
        axes.spines[["top", "right"]].set_visible(False)
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--trials",
        type=int,
        default=100,
        help="experiments at the 24 planned postures (default: 100)",
    )
    arguments = parser.parse_args()
    case = Case(symkin.load("ren2008"), symkin.load("ren2008_true"), SEED)
    report = Report("ren2008_planning", "XJ-HEXAS: chosen postures", SEED)
    at, trials = report_24(report, case, unused_poses(case.truth, SEED), arguments.trials)
    forty = chosen(make_plan(case.nominal, 40))
    report.row(
        "40 planned postures: alpha, beta [deg] and postures of each group",
        None,
        forty.inclinations,
        place=PLACE,
        run=forty,
    )
    table = compare(case, forty)
    report_40(report, forty, table)
    report.finish(draw(at, trials, table), arguments.output)


if __name__ == "__main__":
    main()
