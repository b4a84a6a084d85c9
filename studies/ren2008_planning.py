"""XJ-HEXAS: chosen postures, the paper's further work: 24 planned poses, and 40 planned against 40 random ones.

The plan is made for the nominal geometry by I-optimality (pose variance over the assumed workspace, constant base and tool
frames taken away) over groups at level and at +-20 deg. True mechanisms are then brought to the planned poses, each group to its
inclination as far as the inclinometer repeats. Random postures: 10 groups of 4 by the generator of ren2008_method. Rod noise
uniform within +-1 um, inclinometer within +-0.0005 deg. Units: m, deg.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

import symkin
from ren2008_method import (
    BEST,
    PoseErrors,
    UnusedPoses,
    angles_of,
    fit,
    measure,
    measure_at,
    pose_errors,
    random_truth,
    unused_poses,
)
from ren2008_tables import ASIDE, HEIGHTS, PLATFORM_CENTRE, TILT
from report import Report, new_figure, options_parser
from symkin.calibration.planning import Plan, plan_measurements
from symkin.calibration.simulate import Noise
from symkin.calibration.workspace import Workspace

SEED = 8
WANTED = (0.1, 0.01)
GROUPS = {24: 3, 40: 5}
GEOMETRIES, EACH = 20, 4
MARGIN = 0.02


@dataclass(frozen=True, eq=False)
class Chosen:
    """Planned postures: circle centres (n, 3), angles (n, 3) in degrees, group numbers (n,)."""

    centres: np.ndarray
    angles: np.ndarray
    groups: np.ndarray


def workspace(nominal: symkin.Mechanism) -> Workspace:
    """The assumed workspace; the range of rods with a margin for the unknown geometry."""
    half = np.array([ASIDE, ASIDE, 0.5 * (HEIGHTS[1] - HEIGHTS[0])])
    return Workspace(nominal, half, tilt=np.radians(TILT), spin=np.radians(TILT), margin=MARGIN)


def make_plan(nominal: symkin.Mechanism, postures: int) -> Plan:
    rod, tilt = BEST.sigmas
    noise = Noise(lengths=rod, group=tilt, uniform=True)
    return plan_measurements(workspace(nominal), postures, noise, groups=GROUPS[postures], seed=SEED)


def chosen(plan: Plan) -> Chosen:
    poses = [symkin.Pose(row[:3], row[3:]) for row in plan.postures.poses]
    return Chosen(np.array([p.apply(PLATFORM_CENTRE) for p in poses]), np.array([angles_of(p) for p in poses]), plan.groups)


def planned_errors(
    nominal: symkin.Mechanism, true: symkin.Mechanism, at: Chosen, tests: UnusedPoses, rng: np.random.Generator
) -> PoseErrors:
    """Largest errors in aligned frames after one experiment at planned postures."""
    found = fit(nominal, measure_at(true, at.centres, at.angles, at.groups, BEST, rng))
    return pose_errors(nominal, true, found.values, tests)["aligned"]


def random_errors(nominal: symkin.Mechanism, true: symkin.Mechanism, tests: UnusedPoses, rng: np.random.Generator) -> PoseErrors:
    found = fit(nominal, measure(true, 10, 4, BEST, rng))
    return pose_errors(nominal, true, found.values, tests)["aligned"]


def compare(nominal: symkin.Mechanism, at: Chosen) -> np.ndarray:
    """(geometries, 4): root mean square over experiments of the largest errors, planned and random, mm and deg."""
    rows = []
    for k in range(GEOMETRIES):
        rng = np.random.default_rng([SEED, 20, k])
        true = random_truth(nominal, 0.005, rng)
        tests = unused_poses(true, SEED + k, 100)
        ours = [planned_errors(nominal, true, at, tests, rng) for _ in range(EACH)]
        theirs = [random_errors(nominal, true, tests, rng) for _ in range(EACH)]
        rows.append([_rms([getattr(e, key) for e in made]) for made in (ours, theirs) for key in ("position", "angle")])
    return np.array(rows)


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def report_24(report: Report, trials: list[PoseErrors], seconds: float) -> None:
    position, angle = (np.array([getattr(e, key) for e in trials]) for key in ("position", "angle"))
    report.row("time of a plan of 24 postures", None, round(seconds, 1), "s")
    report.row(
        f"24 planned postures, {len(trials)} experiments: largest errors of 200 poses in 95 % of them; wanted: at most",
        WANTED, [float(np.quantile(position, 0.95)), float(np.quantile(angle, 0.95))], "mm, deg",
    )  # fmt: skip
    inside = np.mean((position <= WANTED[0]) & (angle <= WANTED[1]))
    report.row("experiments that stay below both", None, 100 * float(inside), "%")


def report_40(report: Report, table: np.ndarray) -> None:
    for k, what in enumerate(("position", "orientation")):
        ratio = table[:, 2 + k] / table[:, k]
        report.row(
            f"{GEOMETRIES} geometries, random over planned {what} error: mean, median, least; wanted: at least",
            [4.0, 4.0, 0.0], [float(np.mean(table[:, 2 + k]) / np.mean(table[:, k])), float(np.median(ratio)), float(ratio.min())],
        )  # fmt: skip


def draw(plans: dict[int, Chosen], trials: list[PoseErrors], table: np.ndarray):
    figure = new_figure(15, 4.8)
    figure.suptitle("XJ-HEXAS: chosen postures", fontsize=14)
    left, centre, right = figure.subplots(1, 3)
    at = plans[24]
    for group in np.unique(at.groups):
        inside = at.groups == group
        alpha, beta = np.round(at.angles[inside][0, :2]) + 0.0
        left.scatter(*at.centres[inside][:, :2].T, s=60, label=f"{int(inside.sum())} at alpha {alpha:+.0f}, beta {beta:+.0f} deg")
    left.set(xlabel="x of the platform's circle [m]", ylabel="y [m]", aspect="equal")
    left.set_title("24 postures from above", loc="left")
    left.legend(fontsize=9, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.16))
    centre.scatter([e.position for e in trials], [e.angle for e in trials], s=18, color="#0072b2")
    centre.axvline(WANTED[0], color="#d55e00", ls="--", lw=1)
    centre.axhline(WANTED[1], color="#d55e00", ls="--", lw=1)
    centre.set(
        xlabel="largest position error [mm]",
        ylabel="largest orientation error [deg]",
        xlim=(0, 1.1 * WANTED[0]),
        ylim=(0, 1.1 * WANTED[1]),
    )
    centre.set_title(f"{len(trials)} experiments at 24 postures", loc="left")
    places = np.arange(1, len(table) + 1)
    right.semilogy(places, table[:, 2], "s", color="#d55e00", label="40 random (10 x 4)")
    right.semilogy(places, table[:, 0], "o", color="#0072b2", label="40 planned")
    right.set(xlabel="geometry", ylabel="largest position error [mm]", xticks=places[::2] + 1)
    right.set_title(f"{GEOMETRIES} true geometries", loc="left")
    right.set_ylim(top=3 * right.get_ylim()[1])
    right.legend(fontsize=9, frameon=False, loc="upper right", ncols=2)
    for axes in (left, centre, right):
        axes.spines[["top", "right"]].set_visible(False)
    return figure


def main() -> None:
    parser = options_parser(__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=100, help="experiments at the 24 planned postures (default: 100)")
    arguments = parser.parse_args()
    nominal, true = symkin.load("ren2008"), symkin.load("ren2008_true")
    report = Report("ren2008_planning", "XJ-HEXAS: chosen postures", SEED)
    begin = time.perf_counter()
    plans = {24: chosen(make_plan(nominal, 24))}
    seconds = time.perf_counter() - begin
    plans[40] = chosen(make_plan(nominal, 40))
    for count, at in plans.items():
        held = [[*(np.round(at.angles[at.groups == g][0, :2]) + 0.0), int(np.sum(at.groups == g))] for g in np.unique(at.groups)]
        report.row(f"{count} planned postures: alpha, beta [deg] and postures of each group", None, np.array(held).tolist())
    tests = unused_poses(true, SEED)
    trials = [
        planned_errors(nominal, true, plans[24], tests, np.random.default_rng([SEED, 24, k])) for k in range(arguments.trials)
    ]
    table = compare(nominal, plans[40])
    report_24(report, trials, seconds)
    report_40(report, table)
    report.finish(draw(plans, trials, table), arguments.output)


if __name__ == "__main__":
    main()
