"""XJ-HEXAS, a 6-UPS platform: 42 parameters, direct and inverse problem, and the pose error before calibration.

Notation: |t + R m_i - b_i| = dl_i + l_i; m_i platform joints, b_i base joints in the paper's joint frames, dl_i the fixed
rod length, l_i the measured extension; R = Rz(gamma) Ry(beta) Rx(alpha), turns about fixed axes ('xyz').
Units: m, deg. Source: Ren, Feng, Su, Journal of Xi'an Jiaotong University 42(12), 2008, tables 1 (nominal) and 2 (true).

Two true values are illegible in our copy and assumed: z of M5 = -0.0030 (negative, at most 5 mm) and z of B2 = 0.0025
(positive, at most 5 mm). The workspace is not printed and is assumed: centre of the platform's joint circle within
0.25 m in x and y of the centre of the base's, z 1.15 to 1.45 m, angles within 20 deg, extensions 0 to 0.55 m.

Before calibration the controller inverts the nominal geometry and the true mechanism takes the pose of these rods. The
error is t and (alpha, beta, gamma) of the true pose less those commanded, each in the infinity norm as in the paper.
Calibration itself: ren2008_calibration and ren2008_planning.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

import symkin
from ren2008_tables import ASSUMED, NOMINAL, PLATFORM_CENTRE, TRUE, circle, extensions, random_poses, table_gap
from report import Report, folder_from_arguments, new_figure
from symkin.model.closure import build_closure
from symkin.spatial.rotation import euler_from_quaternion

PAPER_ERROR = (9.0, 0.8)
SEED = 8
POSES = 200


# --- poses and errors --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Errors:
    """Commanded circle centres (n, 3), their displacement (n, 3), and the infinity norms of the errors: mm, deg."""

    centres: np.ndarray
    shifts: np.ndarray
    position: np.ndarray
    angle: np.ndarray


def angles_deg(pose: symkin.Pose) -> np.ndarray:
    """alpha, beta, gamma about the fixed axes."""
    return np.degrees(euler_from_quaternion(np.asarray(pose.quaternion), "xyz"))


def errors_before(nominal: symkin.Mechanism, true: symkin.Mechanism, poses: list[symkin.Pose]) -> Errors:
    """The true mechanism's pose for the nominal mechanism's extensions, less the pose commanded."""
    rows = []
    for pose in poses:
        taken = symkin.solve(true, joints=extensions(nominal, pose), start=pose).solution.pose
        centre, shift = pose.apply(PLATFORM_CENTRE), taken.apply(PLATFORM_CENTRE) - pose.apply(PLATFORM_CENTRE)
        position = 1e3 * np.abs(taken.position - pose.position).max()
        rows.append([*centre, *shift, position, np.abs(angles_deg(taken) - angles_deg(pose)).max()])
    table = np.array(rows)
    return Errors(table[:, :3], table[:, 3:6], table[:, 6], table[:, 7])


def with_hidden(true: symkin.Mechanism, z_m5: float, z_b2: float) -> symkin.Mechanism:
    """The true geometry with other values of its two illegible entries."""
    limbs = list(true.limbs)
    limbs[4] = replace(limbs[4], platform=(*limbs[4].platform[:2], z_m5))
    limbs[1] = replace(limbs[1], base=(*limbs[1].base[:2], z_b2))
    return replace(true, limbs=limbs)


# --- study -------------------------------------------------------------------------------------------------------


def report_geometry(report: Report, nominal: symkin.Mechanism, true: symkin.Mechanism) -> None:
    names = [n for n in build_closure(nominal).parameter_names if n.startswith("leg")]
    report.row("geometric parameters", 42, len(names))
    report.row("mechanism files less tables 1 and 2", 0.0, max(table_gap(nominal, NOMINAL), table_gap(true, TRUE)), "m")
    report.row("true values illegible in our copy, assumed: z of M5, z of B2", None, list(ASSUMED.values()), "m")
    for name in ("platform", "base"):
        centre, radius, off = circle(NOMINAL[name])
        report.row(f"{name} joint circle: centre x, y, radius, largest departure", None, [*centre[:2], radius, off], "m")
    largest = max(float(np.abs(np.subtract(TRUE[key], NOMINAL[key])).max()) for key in TRUE)
    report.row("largest true less nominal value", 0.005, largest, "m")


def report_round_trips(report: Report, nominal: symkin.Mechanism, poses: list[symkin.Pose]) -> None:
    """Inverse by symkin against the closed form; direct from the home pose back to the pose."""
    inverse, direct, same, begin = 0.0, 0.0, 0, time.perf_counter()
    for pose in poses:
        lengths = np.array(symkin.solve(nominal, pose=pose).solution.actuated)
        inverse = max(inverse, float(np.abs(lengths - extensions(nominal, pose)).max()))
        back = symkin.solve(nominal, joints=lengths, start=nominal.reference_pose).solution
        gap = float(np.abs(back.pose.matrix - pose.matrix).max())
        same, direct = same + (gap < 1e-9), max(direct, gap if gap < 1e-9 else 0.0)
    report.row(f"inverse: symkin less closed form, {len(poses)} poses", None, inverse, "m")
    report.row(f"direct, Newton from home: back at the pose, of {len(poses)}", None, same)
    report.row("largest pose difference of these", None, direct)
    report.row("time of an inverse and a direct solve", None, round(1e3 * (time.perf_counter() - begin) / len(poses), 1), "ms")


def report_home(report: Report, nominal: symkin.Mechanism) -> None:
    home = nominal.reference_pose
    found = symkin.modes(nominal, joints=extensions(nominal, home), starts=10000, seed=SEED)
    report.row("home pose: extensions", None, extensions(nominal, home), "m")
    report.row(
        "direct problem at home, 10000 starts: real modes, above the base",
        None,
        [len(found), sum(s.position[2] > 0 for s in found)],
    )
    report.row("estimated unseen modes (Chao)", None, found.estimated_unseen)


def report_errors(report: Report, errors: Errors, rejected: float) -> None:
    report.row("assumed workspace: share of postures rejected by the rods' range", None, 100 * rejected, "%")
    report.row(f"position error before calibration, {POSES} poses: largest", PAPER_ERROR[0], float(errors.position.max()), "mm")
    report.row("position error: mean, least", None, [float(errors.position.mean()), float(errors.position.min())], "mm")
    report.row("orientation error before calibration: largest", PAPER_ERROR[1], float(errors.angle.max()), "deg")
    report.row("orientation error: mean, least", None, [float(errors.angle.mean()), float(errors.angle.min())], "deg")


def report_hidden(report: Report, nominal: symkin.Mechanism, true: symkin.Mechanism, poses: list[symkin.Pose]) -> None:
    """What the errors become for other values of the illegible entries, over their range of 0 to 5 mm."""
    choices = [(m, b) for m in (-0.005, -0.0025, 0.0) for b in (0.0, 0.0025, 0.005)]
    grid = [errors_before(nominal, with_hidden(true, *choice), poses) for choice in choices]
    largest = [min(float(e.position.max()) for e in grid), min(float(e.angle.max()) for e in grid)]
    means = [(float(e.position.mean()), float(e.angle.mean())) for e in grid]
    near = min(range(len(grid)), key=lambda k: sum(abs(x / paper - 1) for x, paper in zip(means[k], PAPER_ERROR, strict=True)))
    report.row(
        f"largest errors, least over {len(grid)} choices of z of M5 and B2, {len(poses)} poses", PAPER_ERROR, largest, "mm, deg"
    )
    report.row("choice whose mean errors come nearest to the paper's: z of M5, z of B2", None, choices[near], "m")
    report.row("its mean errors", PAPER_ERROR, means[near], "mm, deg")
    text = (
        f"9 mm and 0.8 deg are not the worst errors before calibration, the measure of the paper's figure 2: over the assumed workspace "
        f"tables 1 and 2 give {largest[0]:.1f} mm and {largest[1]:.2f} deg or more for every choice tried of the illegible entries; the means "
        f"come near them (for one choice {means[near][0]:.1f} mm and {means[near][1]:.2f} deg)."
    )
    report.erratum(text, shown=largest[0] > 1.2 * PAPER_ERROR[0] and largest[1] > 1.2 * PAPER_ERROR[1])


# --- picture -----------------------------------------------------------------------------------------------------


def draw_platform(axes, mechanism: symkin.Mechanism) -> None:
    pose = mechanism.reference_pose
    base = np.array([limb.base for limb in mechanism.limbs])
    top = np.array([pose.apply(np.array(limb.platform)) for limb in mechanism.limbs])
    for points, colour in ((base, "#4d4d4d"), (top, "#0072b2")):
        axes.plot_trisurf(*points.T, color=colour, alpha=0.25, triangles=[(0, k, k + 1) for k in range(1, 5)])
        axes.plot(*np.vstack([points, points[:1]]).T, "-o", color=colour, lw=2, ms=5)
    for k, (b, m) in enumerate(zip(base, top, strict=True), start=1):
        axes.plot(*np.array([b, m]).T, color="#d55e00", lw=2.5)
        middle = b + 0.42 * (m - b)
        axes.text(*middle, f" {k}", fontsize=11)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", title="Home pose, nominal geometry")
    axes.set(xlim=(-0.65, 0.8), ylim=(-0.2, 1.25), zlim=(0, 1.45), box_aspect=(1, 1, 1))
    axes.locator_params(nbins=4)
    axes.view_init(18, -62)


def draw_field(figure, axes, errors: Errors) -> None:
    """Where the centre of the platform's joint circle goes wrong, seen from above."""
    x, y = errors.centres[:, 0], errors.centres[:, 1]
    arrows = axes.quiver(
        x, y, *(1e3 * errors.shifts[:, :2]).T, errors.position, cmap="viridis", angles="xy", scale=180, width=0.006
    )
    axes.quiverkey(arrows, 0.84, 1.03, 10, "10 mm", labelpos="E", coordinates="axes")
    figure.colorbar(arrows, ax=axes, label="position error, infinity norm [mm]", shrink=0.8)
    axes.set(xlabel="x of the circle's centre [m]", ylabel="y of the circle's centre [m]", aspect="equal")
    axes.set(xlim=(-0.22, 0.4), ylim=(0.3, 0.92))
    axes.set_title("Error seen from above", loc="left")


def draw_histogram(axes, errors: Errors) -> None:
    axes.hist(errors.position, bins=20, color="#0072b2", edgecolor="white")
    axes.axvline(PAPER_ERROR[0], color="#d55e00", lw=2.5, label="the paper's 9 mm")
    axes.set(xlabel="position error, infinity norm [mm]", ylabel="poses", title=f"Before calibration, {POSES} poses")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="upper right")
    axes.set_ylim(top=1.25 * axes.get_ylim()[1])


def draw(nominal: symkin.Mechanism, errors: Errors):
    figure = new_figure(17, 5.6)
    figure.get_layout_engine().set(wspace=0.06)
    figure.suptitle("XJ-HEXAS: home pose and pose error before calibration", fontsize=14)
    grid = figure.add_gridspec(1, 3, width_ratios=(1.1, 1.25, 1))
    draw_platform(figure.add_subplot(grid[0], projection="3d"), nominal)
    draw_field(figure, figure.add_subplot(grid[1]), errors)
    draw_histogram(figure.add_subplot(grid[2]), errors)
    return figure


def main() -> None:
    folder = folder_from_arguments(__doc__.splitlines()[0])
    nominal, true = symkin.load("ren2008"), symkin.load("ren2008_true")
    report = Report("ren2008", "XJ-HEXAS: geometry, direct and inverse problem, error before calibration", SEED)
    report_geometry(report, nominal, true)
    poses, rejected = random_poses(nominal, POSES, SEED)
    report_round_trips(report, nominal, poses)
    report_home(report, nominal)
    errors = errors_before(nominal, true, poses)
    report_errors(report, errors, rejected)
    report_hidden(report, nominal, true, poses[:60])
    report.finish(draw(nominal, errors), folder)


if __name__ == "__main__":
    main()
