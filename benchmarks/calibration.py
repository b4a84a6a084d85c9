"""Calibration of a platform on six rods by an inclinometer: exactness, Monte Carlo, outliers, and
time against scipy; and of an arm with nearly parallel axes by tool positions: the written file's
chi-square against scipy's minimum.

    python benchmarks/calibration.py [--trials 200] [--seed 0]
        [--part exact|noise|designs|outliers|parallel|time|command|size] [--rows 100000]

Each line gives the figure, its limit and whether it holds; the exit status is 1 where one does not.
Time is processor time of the whole fit from nominal, direct problems included, building left out,
against scipy's least_squares(method="lm") with finite differences over a direct solver that treats
all postures at once in NumPy and goes on from its last solution (warm), or begins at the home pose
at every call (cold). scipy is needed for the time and for the arm only. Size is the largest memory
that one run of `symkin calibrate fit` takes, from reading the file to writing the report, of a
hexapod with positions and orientations read, in a process of its own each.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import symkin
from helpers import parallel_arm
from helpers.inclinometer import (
    BASE_LIMBS,
    PLATFORM_LIMBS,
    Geometry,
    geometry,
    measured,
    random_geometry,
    tilted,
)
from helpers.tracker import Hexapod
from posed_hexapod import PosedHexapod, turned
from symkin.calibration.calibrate import calibrate
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.data.parameters import joint_frames
from symkin.calibration.design.simulation import Noise, random_configurations, simulate_readings
from symkin.calibration.estimate.configurations import (
    ROUGHLY_SOLVED_TOLERANCE,
    solve_configurations,
)
from symkin.calibration.estimate.estimator import Estimate, estimate, parameters_at_poses
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.workspace import Workspace
from symkin.calibration.judge.outliers import screen_readings
from symkin.calibration.judge.statistics import covariance, linear_model
from symkin.model.file import parse
from timing import Figure, in_turn, median_ratio

NOMINAL, TRUE = symkin.load("ren2008"), symkin.load("ren2008_true")
HELD = joint_frames(NOMINAL, PLATFORM_LIMBS, BASE_LIMBS)
GAUSS = np.radians(0.001)
"""A harder case than the paper's uniform errors: normal ones with this standard deviation."""


class Lines:
    """Prints figures beside their limits and remembers whether all hold."""

    def __init__(self) -> None:
        self.all_hold = True

    def add(self, text: str, figure: str, limit: str = "", holds: bool | None = None) -> None:
        mark = "" if holds is None else "holds" if holds else "FAILS"
        self.all_hold = self.all_hold and holds is not False
        print(f"{text:78s} {figure:>22s}  {limit:24s} {mark}", flush=True)


def fit(problem: CalibrationProblem) -> Estimate:
    """From nominal to the estimate: direct problems, then least squares."""
    postures = solve_configurations(
        problem.model,
        problem.measurements,
        problem.model.nominal,
        tolerance=ROUGHLY_SOLVED_TOLERANCE,
    )
    return estimate(problem, postures.z)


# --- exactness ------------------------------------------------------------------------------------


def report_exact(lines: Lines, seed: int) -> None:
    for spread, count in ((0.005, 50), (0.05, 20)):
        errors = []
        for k in range(count):
            rng = np.random.default_rng([seed, k])
            truth = random_geometry(geometry(NOMINAL), HELD, spread, rng)
            found = calibrate(
                NOMINAL, measured(truth, rng, rods=False), fixed=HELD, outliers="ignore"
            )
            errors.append(max(abs(p.value - truth.value(p.name)) for p in found.parameters))
        good = sum(e < 1e-12 for e in errors)
        text = (
            f"noise-free, truth within {1e3 * spread:.0f} mm, {count} truths: largest parameter "
            f"error [m]"
        )
        lines.add(text, f"{max(errors):.1e}", "below 1e-12 for all", good == count)


# --- noise ----------------------------------------------------------------------------------------


def report_noise(lines: Lines, seed: int, trials: int) -> None:
    """chi^2 / 32 in the metric of the Cramer-Rao bound (rods and inclinometer), and variances over
    those of the means.
    """
    truth = geometry(TRUE)
    ratios: dict[str, list[float]] = {"means": [], "differences": [], "maximum likelihood": []}
    predicted, variances = [], []
    for k in range(trials):
        data = measured(truth, np.random.default_rng([seed, k]), noisy=True)
        best = build_calibration(NOMINAL, data, fixed=HELD, residual="maximum likelihood")
        scatter = {}
        for form, found in ratios.items():
            problem = replace(best, form=form)
            state = fit(problem).state
            bound = covariance(best, state)
            error = state.p - truth.values(problem.names)
            found.append(float(error @ np.linalg.solve(bound, error)) / len(error))
            scatter[form] = covariance(problem, state)
        predicted.append(np.trace(np.linalg.solve(bound, scatter["differences"])) / len(error))
        variances.append(np.median(np.diag(scatter["differences"]) / np.diag(scatter["means"])))
    means, worse = np.mean(ratios["means"]), np.mean(ratios["differences"])
    lines.add(
        f"{trials} trials, group means: chi^2 / 32 over the Cramer-Rao bound",
        f"{means:.3f}",
        "0.9 to 1.1",
        0.9 < means < 1.1,
    )
    lines.add("maximum likelihood with rod noise", f"{np.mean(ratios['maximum likelihood']):.3f}")
    lines.add(
        "neighbour differences (the paper): measured, predicted by their covariance",
        f"{worse:.3f}, {np.mean(predicted):.3f}",
        "about 1.31",
        worse > 1.15,
    )
    lines.add(
        "median variance of a parameter, differences over means",
        f"{np.mean(variances):.3f}",
        "about 1.31",
    )


def report_designs(lines: Lines, seed: int) -> None:
    """Neighbour differences over group means, by the covariances at the truth, means over designs:
    in the metric of the Cramer-Rao bound (chi^2 / 32), and by the trace over the 32 parameters.
    """
    truth = geometry(TRUE)
    for groups, each in ((10, 4), (15, 4), (20, 4), (8, 5)):
        found = []
        for k in range(20):
            data = measured(truth, np.random.default_rng([seed, 3, k]), groups, each=each)
            best = build_calibration(TRUE, data, fixed=HELD, residual="maximum likelihood")
            state = fit(replace(best, form="means")).state
            bound, means, worse = (
                covariance(replace(best, form=f), state)
                for f in ("maximum likelihood", "means", "differences")
            )
            found.append(
                [
                    np.trace(np.linalg.solve(bound, worse)) / len(worse),
                    np.trace(worse) / np.trace(means),
                ]
            )
        metric, trace = np.mean(found, axis=0)
        text = (
            f"{groups} groups of {each}: neighbour differences over group means, chi^2 / 32 and "
            f"trace"
        )
        lines.add(text, f"{metric:.3f}, {trace:.3f}", "about 1.31")


# --- outliers -------------------------------------------------------------------------------------


def spoilt(
    data: Measurements, truth: Geometry, rng: np.random.Generator
) -> tuple[Measurements, int]:
    """One inclination of a random posture off by 0.01 deg."""
    problem = build_calibration(TRUE, data, fixed=HELD)
    poses = problem.model.poses(
        solve_configurations(problem.model, data, problem.model.nominal).z,
        data.joints,
        problem.model.nominal,
    )
    posture, shift = int(rng.integers(len(data))), np.zeros(2)
    shift[rng.integers(2)] = np.radians(0.01) * rng.choice([-1, 1])
    return replace(data, joints=tilted(truth, data.joints, poses, posture, shift)), posture


def normal_noise(truth: Geometry, rng: np.random.Generator) -> Measurements:
    """Exact groups whose inclinations are each off by normal errors of 0.001 deg, rods by 2 um /
    sqrt(12).
    """
    data = measured(truth, rng)
    problem = build_calibration(TRUE, data, fixed=HELD)
    poses = problem.model.poses(
        solve_configurations(problem.model, data, problem.model.nominal).z,
        data.joints,
        problem.model.nominal,
    )
    joints = data.joints + 2e-6 / np.sqrt(12) * rng.normal(size=data.joints.shape)
    for k in range(len(data)):
        joints = tilted(truth, joints, poses, k, GAUSS * rng.normal(size=2))
    return replace(data, joints=joints, group_sigma=GAUSS)


def report_outliers(lines: Lines, seed: int, trials: int) -> None:
    truth = geometry(TRUE)
    cases: dict[str, Callable[[np.random.Generator], Measurements]] = {
        "uniform errors of 0.001 deg": lambda rng: measured(truth, rng, noisy=True),
        "normal errors, sigma 0.001 deg": lambda rng: normal_noise(truth, rng),
    }
    for name, draw in cases.items():
        hits = flagged = 0
        for k in range(trials):
            rng = np.random.default_rng([seed, 1, k])
            clean = draw(rng)
            bad, posture = spoilt(clean, truth, rng)
            for data, is_bad in ((bad, True), (clean, False)):
                problem = build_calibration(NOMINAL, data, fixed=HELD)
                found = [
                    o.configuration
                    for o in screen_readings(
                        problem, linear_model(problem, fit(problem).state)
                    ).outliers
                ]
                hits, flagged = (
                    hits + (is_bad and posture in found),
                    flagged + (not is_bad and bool(found)),
                )
        strict = name.startswith("uniform")
        share, false = hits / trials, flagged / trials
        lines.add(
            f"{name}: outliers of 0.01 deg found",
            f"{100 * share:.1f} %",
            "at least 95 %" if strict else "",
            share >= 0.95 if strict else None,
        )
        lines.add(
            f"{name}: clean sets with a reading flagged",
            f"{100 * false:.1f} %",
            "at most 5 %",
            false <= 0.05,
        )


# --- nearly parallel axes -------------------------------------------------------------------------


def report_parallel(lines: Lines, seed: int) -> None:
    """Twelve machines with random DH tables and two of the factory kind, whose tables hold lengths
    that cancel: chi-square of the file that is written, by NumPy, over the least that scipy finds
    from nominal.
    """
    for k in range(14):
        rng = np.random.default_rng([seed, 4, k])
        truth = (
            parallel_arm.random_table(rng) if k < 12 else parallel_arm.moved_lines(1e-4, 0.3, rng)
        )
        data = parallel_arm.measured(truth, rng)
        least = parallel_arm.least_chi_square(data)
        kind = (
            "random" if k < 12 else f"factory, longest d {1e-3 * np.max(np.abs(truth[:, 1])):.0f} m"
        )
        found = calibrate(parallel_arm.arm(), data, outliers="ignore")
        own = parallel_arm.chi_square(parse(found.corrected.to_toml()), data)
        lines.add(
            f"arm {k + 1} ({kind}): chi-square of the file, reported; scipy's; steps",
            f"{own:.2f}, {found.chi_square:.2f}; {least:.2f}; {found.iterations}",
            "within 3 %, as reported",
            found.refused is None
            and own <= 1.03 * least
            and abs(own - found.chi_square) <= 1e-4 * own,
        )


# --- time -----------------------------------------------------------------------------------------


class VectorisedDirect:
    """Newton for all postures in NumPy: unit directions u and moments (R m) x u of the rods as the
    Jacobian.
    """

    def __init__(self, joints: np.ndarray, home: np.ndarray, *, warm: bool) -> None:
        self.joints, self.warm = joints, warm
        self.begin = np.tile(home, (len(joints), 1)), np.tile(np.eye(3), (len(joints), 1, 1))
        self.last = self.begin

    def rotations(self, base: np.ndarray, platform: np.ndarray, offset: np.ndarray) -> np.ndarray:
        t, r = self.last if self.warm else self.begin
        for _ in range(30):
            arms = platform @ r.transpose(0, 2, 1)
            rods = t[:, None] + arms - base
            length = np.sqrt((rods * rods).sum(axis=2))
            gap = length - (self.joints + offset)
            if np.max(np.abs(gap)) < 1e-13:
                break
            u = rods / length[:, :, None]
            step = -np.linalg.solve(
                np.concatenate([u, np.cross(arms, u)], axis=2), gap[:, :, None]
            )[:, :, 0]
            t, r = t + step[:, :3], turned(step[:, 3:]) @ r
        self.last = t, r
        return r


def scipy_fit(data: Measurements, names: tuple[str, ...], *, warm: bool) -> np.ndarray:
    from scipy.optimize import least_squares

    nominal = geometry(NOMINAL)
    direct = VectorisedDirect(data.joints, np.array(NOMINAL.platform_position), warm=warm)
    tables = [nominal.base.copy(), nominal.platform.copy(), nominal.offset.copy()]
    places = [
        (("base", "platform", "offset").index(n.split(".")[1]), int(n[3]) - 1, "xyz".find(n[-1]))
        for n in names
    ]
    average = (data.groups[:, None] == np.arange(data.groups.max() + 1)) / 4.0

    def residuals(p: np.ndarray) -> np.ndarray:
        for value, (table, row, column) in zip(p, places, strict=True):
            if table == 2:
                tables[2][row] = value
            else:
                tables[table][row, column] = value
        r = direct.rotations(*tables)
        angles = np.column_stack(
            [
                np.arctan2(r[:, 2, 1], r[:, 2, 2]),
                np.arctan2(-r[:, 2, 0], np.hypot(r[:, 2, 1], r[:, 2, 2])),
            ]
        )
        return (angles - (average.T @ angles)[data.groups]).ravel()

    return least_squares(
        residuals, nominal.values(names), method="lm", xtol=1e-13, ftol=1e-13, gtol=1e-13
    ).x


@dataclass(frozen=True)
class Times:
    """Processor times of fits of the same data, taken in turn, and scipy's largest parameter error
    in metres.
    """

    postures: int
    times: dict[str, list[float]]
    scipys_error: float


def timed_fits(groups: int, seed: int, repeats: int) -> Times:
    """The fit and scipy on the same data; scipy's are left out where it is not installed."""
    rng = np.random.default_rng([seed, 2])
    truth = random_geometry(geometry(NOMINAL), HELD, 0.005, rng)
    data = measured(truth, rng, groups, rods=False)
    problem = build_calibration(NOMINAL, data, fixed=HELD)
    runs: dict[str, Callable[[], object]] = {
        "nested": lambda: fit(problem),
    }
    error = float("nan")
    if find_spec("scipy"):
        runs["scipy, warm"] = lambda: scipy_fit(data, problem.names, warm=True)
        runs["scipy, cold"] = lambda: scipy_fit(data, problem.names, warm=False)
        values = truth.values(problem.names)
        error = max(
            float(np.abs(scipy_fit(data, problem.names, warm=w) - values).max())
            for w in (True, False)
        )
    return Times(4 * groups, in_turn(runs, repeats), error)


def report_time(lines: Lines, seed: int) -> None:
    for groups, limit in ((10, 20.0), (100, 10.0)):
        found = timed_fits(groups, seed, 9)
        times, of = found.times, f"{found.postures} postures"
        for name, t in times.items():
            lines.add(f"{of}, {name}", f"{1e3 * np.median(t):.1f} ms")
        lines.add(f"{of}, scipy's largest parameter error [m]", f"{found.scipys_error:.1e}")
        for other in (o for o in times if o.startswith("scipy")):
            ratio = median_ratio(times[other], times["nested"])
            holds = ratio >= limit if other == "scipy, cold" else None
            told = f"at least {limit:.0f}" if holds is not None else ""
            lines.add(f"{of}, {other} over nested", f"{ratio:.1f}", told, holds)
    for figure in posed_figures(seed, 9):
        holds = None if figure.ratio is None else figure.ratio <= 4.0
        lines.add(
            figure.name, "" if figure.ratio is None else f"{figure.ratio:.1f}", "at most 4", holds
        )


def posed_data(seed: int) -> tuple[Measurements, float]:
    """600 whole poses with noise of a standard deviation."""
    rng, alone, sigma = np.random.default_rng([seed, 5]), np.full(600, -1), 1e-5
    made = random_configurations(Workspace.about(TRUE), alone, Noise(), rng)
    noise = Noise(position=sigma, orientation=sigma)
    return simulate_readings(TRUE, made, alone, ("pose",), noise, rng), sigma


def posed_figures(seed: int, repeats: int) -> Iterator[Figure]:
    """A whole estimate from 600 whole poses over scipy's with an analytic Jacobian."""
    figure = "calibration: 600 poses, 42 parameters over scipy, analytic Jacobian"
    if not find_spec("scipy"):
        yield Figure(figure, None, "scipy is not installed (pip install scipy)")
        return
    data, sigma = posed_data(seed)
    problem, peer = build_calibration(NOMINAL, data), PosedHexapod(NOMINAL, data, sigma)

    def ours() -> float:
        p = parameters_at_poses(problem)
        z = solve_configurations(problem.model, data, p, tolerance=ROUGHLY_SOLVED_TOLERANCE).z
        return estimate(problem, z, p=p).state.cost

    assert abs(ours() - peer.fit()) < 1e-3
    times = in_turn({"ours": ours, "scipy": peer.fit}, repeats)
    told = f"{1e3 * np.median(times['ours']):.1f} ms"
    yield Figure(figure, median_ratio(times["ours"], times["scipy"]), told)


def report_command(lines: Lines, seed: int) -> None:
    """Processor time of `symkin calibrate fit` on 600 whole poses, start, pictures and report
    included, over scipy's estimate from as many with an analytic Jacobian.
    """
    if find_spec("scipy"):
        peer = PosedHexapod(NOMINAL, *posed_data(seed))
        with tempfile.TemporaryDirectory() as folder:
            own = [peak_of_fit(Path(folder), 600, seed)[1] for _ in range(6)][1:]
        scipys = in_turn({"scipy": peer.fit}, 9)["scipy"]
        ratio = float(np.median(own) / np.median(scipys))
        lines.add("600 poses, the command [s]", f"{np.median(own):.2f}")
        lines.add("600 poses, the command over scipy", f"{ratio:.0f}", "at most 15", ratio <= 15.0)


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:
    """A whole fit over scipy's least squares, which goes on from its last solutions (warm) or not
    (cold).
    """
    for groups in (10,) if quick else (10, 100):
        found = timed_fits(groups, seed, 3 if quick else 9)
        for other in ("scipy, warm", "scipy, cold"):
            figure, own = f"calibration: {found.postures} postures, nested over {other}", "nested"
            if other in found.times:
                told = f"{1e3 * np.median(found.times[own]):.1f} ms"
                yield Figure(figure, median_ratio(found.times[own], found.times[other]), told)
            else:
                yield Figure(figure, None, "scipy is not installed (pip install scipy)")
    yield from posed_figures(seed, 3 if quick else 9)


# --- size -----------------------------------------------------------------------------------------


def write_poses(path: Path, rows: int, seed: int) -> None:
    """A file of leg readings and measured poses of a hexapod near `Hexapod.nominal`."""
    rng = np.random.default_rng(seed)
    posed = Hexapod.nominal().spoilt(rng).postures(rows, rng)
    angles = np.array(
        [
            [np.arctan2(r[1, 0], r[0, 0]), -np.arcsin(r[2, 0]), np.arctan2(r[2, 1], r[2, 2])]
            for r in posed.rotations
        ]
    )
    table = np.column_stack(
        [
            posed.joints,
            posed.positions + 0.02 * rng.normal(size=(rows, 3)),
            angles + 1e-4 * rng.normal(size=(rows, 3)),
        ]
    )
    header = [
        *(f"leg{k}[mm]" for k in range(1, 7)),
        "x[mm]",
        "y[mm]",
        "z[mm]",
        *(f"euler_ZYX_{k}[rad]" for k in (1, 2, 3)),
    ]
    with path.open("w") as file:
        file.write(",".join(header) + "\n")
        file.writelines(",".join(map(repr, map(float, row))) + "\n" for row in table)


FIT_AND_MEASURE = """
import resource, sys, time
from symkin.cli.app import main
try:
    main(sys.argv[1:])
except SystemExit as ended:
    print("peak", ended.code or 0, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
      time.process_time())
"""


def peak_of_fit(folder: Path, rows: int, seed: int) -> tuple[float, float]:
    """Megabytes and seconds of processor time of one fit in a process of its own."""
    (folder / "hexapod.toml").write_text(Hexapod.nominal().mechanism().to_toml())
    write_poses(folder / f"{rows}.csv", rows, seed)
    arguments = [
        "calibrate",
        "fit",
        str(folder / "hexapod.toml"),
        str(folder / f"{rows}.csv"),
        "-o",
        str(folder / f"out{rows}"),
    ]
    arguments += [
        "--sigma-position",
        "0.02mm",
        "--sigma-orientation",
        "1e-4rad",
        "--outliers",
        "ignore",
    ]
    ran = subprocess.run(
        [sys.executable, "-c", FIT_AND_MEASURE, *arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    _, status, megabytes, seconds_taken = ran.stdout.splitlines()[-1].split()
    if status != "0":
        raise SystemExit(f"the fit of {rows} rows ended with status {status}: {ran.stdout[:300]}")
    return float(megabytes), float(seconds_taken)


def report_size(lines: Lines, seed: int, rows: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        (small, _), (large, taken) = (peak_of_fit(Path(folder), n, seed) for n in (rows // 5, rows))
    lines.add(
        f"{rows} postures with poses: largest memory of the fit [MB]",
        f"{large:.0f}",
        "below 1000",
        large < 1000.0,
    )
    lines.add(
        f"{rows} over {rows // 5} postures: memory",
        f"{large / small:.2f}",
        "at most 5",
        large <= 5.0 * small,
    )
    lines.add(f"{rows} postures: processor time [s]", f"{taken:.0f}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--part",
        choices=["exact", "noise", "designs", "outliers", "parallel", "time", "command", "size"],
    )
    parser.add_argument("--rows", type=int, default=100_000)
    options = parser.parse_args()
    print(f"seed {options.seed}, {options.trials} trials")
    lines = Lines()
    parts: dict[str, Callable[[], None]] = {
        "exact": lambda: report_exact(lines, options.seed),
        "noise": lambda: report_noise(lines, options.seed, options.trials),
        "designs": lambda: report_designs(lines, options.seed),
        "outliers": lambda: report_outliers(lines, options.seed, options.trials),
        "parallel": lambda: report_parallel(lines, options.seed),
        "time": lambda: report_time(lines, options.seed),
        "command": lambda: report_command(lines, options.seed),
        "size": lambda: report_size(lines, options.seed, options.rows),
    }
    for name, part in parts.items():
        if options.part in (None, name):
            part()
    return 0 if lines.all_hold else 1


if __name__ == "__main__":
    sys.exit(main())
