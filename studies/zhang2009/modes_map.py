"""Six-SPS Gough-Stewart platform: number of real assembly modes over a slice of leg lengths, and
the singularities that bound it.

Notation of `study`. Legs 1 and 2 vary, the others are those of its table 1. At each point of a grid
all modes are enumerated by continuation. The loci of type 2 singularities in the slice are found
independently, as curves of F = 0, J v = 0, |v| = 1: crossing one, two modes merge, and by the
mirror z -> -z two more; so the number of real modes changes by 4 at every crossing, and nowhere
else. Along grid lines where the number changes, the place is bisected by complete enumeration and
compared.

The design is singular at gamma = +-90 degrees about the axis (Fichter 1986): all legs have the same
rate by gamma there, L_i L_i' = z z' + r_a r_b cos(30) sin(gamma) gamma', so that the screw about z
of pitch z' / gamma' = -r_a r_b cos(30) sin(gamma) / z (length per radian) keeps all lengths. Units:
mm, degrees. The column `paper` holds closed forms; the paper has no singularity. Source: Zhang
Zhaoyin, Practical solution of 6-DOF parallel robot position forward solution, 2009 (table 1).
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import casadi as ca
import numpy as np

import symkin
from symkin.plots.loci_plot import draw_curves
from symkin.singularities.classification import singularity
from symkin.singularities.loci import Loci
from symkin.singularities.singular_loci import singular_loci
from symkin.spatial.rotation import euler_from_quaternion

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, new_figure, options_parser
from studies.zhang2009.model import TABLE_1, equations

SEED = 7
WINDOW = ((30.0, 400.0), (120.0, 420.0))
"""Leg 1 and leg 2, mm."""


# --- the slice ------------------------------------------------------------------------------------


def number_of_modes(platform: symkin.Mechanism, one: float, two: float) -> int:
    found = symkin.modes(platform, joints=(one, two, *TABLE_1[2:]))
    if found.completeness == "incomplete":
        raise SystemExit(
            f"zhang2009_modes_map: {found.unresolved_paths} unresolved paths at legs {one:g}, "
            f"{two:g}"
        )
    return len(found)


def count_grid(
    platform: symkin.Mechanism, number: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Leg 1 and leg 2 of the grid, counts (leg 2, leg 1)."""
    one, two = (np.linspace(low, high, number) for low, high in WINDOW)
    return one, two, np.array([[number_of_modes(platform, a, b) for a in one] for b in two])


def crossings(loci: Loci, row: float) -> list[tuple[float, np.ndarray]]:
    """Leg 1 where the traced polylines meet the line leg 2 = row, and the pose (x, y, z;
    quaternion) of the point before.
    """
    found = []
    for curve in loci.of("type 2"):
        place = [
            curve.names.index(name) for name in ("pose.x", "pose.y", "pose.z", "pose.quaternion")
        ]
        points = np.vstack([curve.points, curve.points[:1]]) if curve.closed else curve.points
        above = points[:, 1] > row
        for k in np.flatnonzero(above[:-1] != above[1:]):
            (a, b), (c, d) = points[k], points[k + 1]
            z = curve.configurations[k]
            found.append(
                (
                    float(a + (c - a) * (row - b) / (d - b)),
                    np.array([*z[place[:3]], *z[place[3] : place[3] + 4]]),
                )
            )
    return sorted(found, key=lambda pair: pair[0])


def fold(pose: np.ndarray, one: float, row: float) -> float:
    """Leg 1 of the singularity near a pose with leg 2 = row and the others of the table, by
    Newton's method on the equations of the paper: squares(X) = L^2, D v = 0, (v.v - 1) / 2 = 0 in
    (X, v, L_1), lengths in units of 275 mm.
    """
    system = equations()
    X, v, L = system.X, ca.SX.sym("v", 6), ca.SX.sym("L")
    squares = system.lengths(X) ** 2
    scale = np.array([275.0] * 3 + [1.0] * 3)
    D = ca.jacobian(squares, X) @ ca.diag(ca.DM(scale)) / 275.0**2
    legs = ca.vertcat(L, row, *TABLE_1[2:])
    rows = ca.vertcat((squares - legs**2) / 275.0**2, D @ v, (ca.dot(v, v) - 1) / 2)
    unknown = ca.vertcat(X, v, L)
    step = ca.Function("step", [unknown], [ca.solve(ca.jacobian(rows, unknown), rows)])
    begin = np.array([*pose[:3], *euler_from_quaternion(pose[3:], "XYZ")])
    kernel = np.linalg.svd(np.asarray(ca.Function("D", [X], [D])(begin)))[2][-1]
    z = np.concatenate([begin, kernel, [one]])
    for _ in range(12):
        z = z - np.asarray(step(z)).ravel()
    return float(z[-1])


def bisected(
    platform: symkin.Mechanism, low: float, high: float, row: float, tolerance: float = 1e-5
) -> float:
    """Leg 1 between two values at which the number of modes changes, by complete enumeration."""
    begin = number_of_modes(platform, low, row)
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if number_of_modes(platform, middle, row) == begin else (low, middle)
        )
    return 0.5 * (low + high)


# --- report ---------------------------------------------------------------------------------------


def slice_loci(platform: symkin.Mechanism, starts: int) -> Loci:
    solution = symkin.solve(platform, joints=TABLE_1).solution
    return singular_loci(
        solution, ("leg1", "leg2"), ranges=WINDOW, kinds=("type 2",), starts=starts, seed=SEED
    )


def report_map(
    report: Report, platform: symkin.Mechanism, number: int, starts: int, edges: int
) -> tuple[Loci, np.ndarray]:
    loci = slice_loci(platform, starts)
    one, two, counts = count_grid(platform, number)
    values, shares = np.unique(counts, return_counts=True)
    report.row(f"numbers of real modes on the grid of {number} x {number}", None, values.tolist())
    report.row(
        "share of the grid with each", None, (100.0 * shares / counts.size).round(2).tolist(), "%"
    )
    report.row(
        "curves of type 2, largest row of their equations over the size",
        None,
        [
            len(loci.of("type 2")),
            max(c.largest_row for c in loci.curves) / platform.characteristic_length,
        ],
    )
    for curve in loci.curves:
        for cusp in curve.cusps:
            report.row("cusp of the locus, where three modes meet", None, cusp.tolist(), "mm")
    agree, changing = 0, []
    for j, row in enumerate(two):
        meets = crossings(loci, row)
        for i in range(number - 1):
            between = [pair for pair in meets if one[i] < pair[0] < one[i + 1]]
            change = abs(int(counts[j, i + 1]) - int(counts[j, i])) // 4
            agree += change <= len(between) and (len(between) - change) % 2 == 0
            changing += (
                [(one[i], one[i + 1], row, between[0])] if len(between) == change == 1 else []
            )
    report.row(
        "grid edges along leg 1 where change of number / 4 = crossings of the loci, but for pairs",
        number * (number - 1),
        agree,
    )
    chosen = changing[:: max(1, len(changing) // edges)][:edges]
    polyline, newton = [], []
    for low, high, row, (place, pose) in chosen:
        change = bisected(platform, low, high, row)
        polyline.append(abs(change - place))
        newton.append(abs(change - fold(pose, place, row)))
    report.row(
        f"change of number bisected on {len(chosen)} edges, less the traced polyline: largest",
        0.0,
        max(polyline),
        "mm",
    )
    report.row(
        "the same less Newton's method on the paper's equations with D v = 0: largest",
        0.0,
        max(newton),
        "mm",
    )
    return loci, counts


def pose_at(z: float, gamma: float) -> symkin.Pose:
    return symkin.Pose.from_euler(np.array([0.0, 0.0, z]), np.radians([0.0, 0.0, gamma]), "xyz")


def report_right_angle(report: Report, platform: symkin.Mechanism) -> None:
    for z in (50.0, 100.0, 200.0):
        for gamma in (90.0, -90.0):
            found = singularity(platform, pose=pose_at(z, gamma))
            (twist,) = found.twists
            report.row(
                f"z = {z:g}, gamma = {gamma:g}: distance to type 2", 0.0, found.distances["type 2"]
            )
            pitch = (
                -250.0 * 275.0 * math.cos(math.radians(30.0)) * math.sin(math.radians(gamma)) / z
            )
            report.row(
                f"z = {z:g}, gamma = {gamma:g}: pitch of the screw about z per radian",
                pitch,
                twist.pitch,
                "mm",
                tolerance=1e-9,
            )
    rng = np.random.default_rng(SEED)
    worst = 0.0
    for x, y, z in rng.uniform(-1, 1, (20, 3)) * (60, 60, 60) + (0, 0, 150):
        pose = symkin.Pose(np.array([x, y, z]), pose_at(z, 90.0).quaternion)
        worst = max(worst, singularity(platform, pose=pose).distances["type 2"])
    report.row("level, gamma = 90, 20 random positions: largest distance to type 2", 0.0, worst)


def draw(platform: symkin.Mechanism, loci: Loci, counts: np.ndarray):
    figure = new_figure(13.5, 6.2)
    figure.suptitle(
        "6-SPS platform: real assembly modes and type 2 singularities", fontsize=15, weight="bold"
    )
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    levels = np.unique(counts)
    cells = [(high - low) / (2 * (counts.shape[0] - 1)) for low, high in WINDOW]
    extent = (
        WINDOW[0][0] - cells[0],
        WINDOW[0][1] + cells[0],
        WINDOW[1][0] - cells[1],
        WINDOW[1][1] + cells[1],
    )
    image = left.imshow(
        counts,
        origin="lower",
        extent=extent,
        cmap="YlGnBu",
        vmin=0,
        vmax=max(12, levels.max()),
        aspect="auto",
    )
    draw_curves(left, loci)
    left.grid(visible=False)
    left.set_aspect("auto")
    left.set_title("number of real modes (cells: enumerated), loci (traced)")
    bar = figure.colorbar(image, ax=left, ticks=levels.tolist(), shrink=0.8)
    bar.set_label("real modes")
    gammas = np.linspace(-180, 180, 73)
    for z, colour in ((50.0, "#009e73"), (100.0, "#0072b2"), (200.0, "#d55e00")):
        values = [singularity(platform, pose=pose_at(z, g)).distances["type 2"] for g in gammas]
        right.plot(gammas, values, color=colour, lw=1.8, label=f"z = {z:g} mm")
    right.set(
        xlabel="gamma [deg]",
        ylabel="distance to type 2",
        xlim=(-180, 180),
        ylim=(0, None),
        xticks=range(-180, 181, 90),
    )
    right.set_title("on the axis: singular at gamma = ±90°")
    right.legend(frameon=False)
    right.grid(color="0.9")
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--grid", type=int, default=40, help="points per side of the grid (default: 40)"
    )
    parser.add_argument(
        "--starts", type=int, default=200, help="random starts of the loci (default: 200)"
    )
    parser.add_argument(
        "--bisected",
        type=int,
        default=6,
        help="grid edges on which the number's change is bisected (default: 6)",
    )
    options = parser.parse_args()
    platform = symkin.load("zhang2009")
    report = Report(
        "zhang2009_modes_map", "6-SPS platform: real modes over a slice of leg lengths", SEED
    )
    loci, counts = report_map(report, platform, options.grid, options.starts, options.bisected)
    report_right_angle(report, platform)
    report.finish(draw(platform, loci, counts), options.output)


if __name__ == "__main__":
    main()
