"""3-TRT + SPS platform of four freedoms: its singular configurations in closed form, and the number
of its real modes.

Notation of `study`: a, c radii of the base and platform triangles, X = (Xp, Yp, Zp, gamma), theta_i
and l_op inputs, the limb directions e_i = C_i - a_i seen from above, n_i = J e_i (J the quarter
turn). The rows of the velocity equations are

    n_i . (Xp', Yp') + gamma' n_i . J (C_i - P) = |e_i|^2 theta_i',   P . P' = l_op l_op',

and for equilateral triangles with corners at the same directions their determinant is

    det A = (3 sqrt(3) / 2) c (a cos gamma - c) (Xp^2 + Yp^2 - a^2 - c^2 + 2 a c cos gamma) Zp

(found here)

so that type 2 singularities are: Zp = 0, the circle Xp^2 + Yp^2 = a^2 + c^2 - 2 a c cos gamma, and
gamma = +-arccos(c / a) at every position. Type 1: |e_i| = 0 or l_op = 0. In the inputs, A
sin(gamma) + B cos(gamma) + C = 0 has a double root, C^2 = A^2 + B^2, for gamma = +-arccos(c / a);
on the circle A = B = C = 0, so that gamma is free: the lines are 120 degrees apart, and the
platform turns while its inputs stand still. Units: mm; degrees where printed, radians inside. The
paper does not treat singularities: the column `paper` holds closed forms.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import symkin
from symkin.plots.loci_plot import draw_curves
from symkin.singularities.classification import singularity
from symkin.singularities.loci import Loci
from symkin.singularities.locus import Locus, picture_distance
from symkin.singularities.named_screw import NamedScrew
from symkin.singularities.singular_loci import singular_loci
from symkin.singularities.singularity_result import Singularity

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, new_figure, of_all_modes, options_parser
from studies.zhao2000.model import BASE, INPUT, PLATFORM, QUARTER, coefficients, corners, inverse

A_RADIUS, C_RADIUS = (float(np.linalg.norm(points[0])) for points in (BASE, PLATFORM))
SEED, GAMMA = 5, 20.0
WINDOW = ((-20.0, 160.0), (-230.0, -50.0))
"""The slice theta_1, theta_2 in degrees, theta_3 and l_op as in the paper's example; lines repeat
after half a turn.
"""


# --- closed forms ---------------------------------------------------------------------------------


def circle_radius(gamma: float) -> float:
    """Radius of the singular circle of P about O (gamma in degrees)."""
    return math.sqrt(
        A_RADIUS**2 + C_RADIUS**2 - 2 * A_RADIUS * C_RADIUS * math.cos(math.radians(gamma))
    )


def determinant(pose) -> float:
    """det A by its rows."""
    directions = corners(pose)[:, :2] - BASE
    normals = directions @ QUARTER.T
    arms = (corners(pose)[:, :2] - np.array(pose[:2])) @ QUARTER.T
    return float(
        np.linalg.det(np.column_stack([normals, np.sum(normals * arms, axis=1)])) * pose[2]
    )


def factors(pose) -> float:
    """det A by its factors."""
    x, y, z, gamma = pose
    turn = A_RADIUS * math.cos(math.radians(gamma)) - C_RADIUS
    return 1.5 * math.sqrt(3) * C_RADIUS * turn * (x * x + y * y - circle_radius(gamma) ** 2) * z


def full(pose) -> symkin.Pose:
    return symkin.Pose.from_euler(np.array(pose[:3]), np.radians([0.0, 0.0, pose[3]]), "xyz")


def at(platform: symkin.Mechanism, pose) -> Singularity:
    """The configuration with all radii positive."""
    return singularity(platform, pose=full(pose), start=inverse(pose))


def pole(pose) -> np.ndarray:
    """Where the normals of the limbs at C_i meet: the axis about which the platform can turn while
    the inputs stand still.
    """
    directions = corners(pose)[:, :2] - BASE
    right = np.sum(directions * corners(pose)[:, :2], axis=1)
    return np.linalg.lstsq(directions, right, rcond=None)[0]


def counts(theta: np.ndarray, length: float) -> np.ndarray:
    """Real poses (n,) of inputs theta (n, 3) in degrees and l_op in mm: two a root of the equation
    in gamma that the sphere
    |P| = l_op reaches.
    """
    n = np.stack([-np.sin(np.radians(theta)), np.cos(np.radians(theta))], axis=2)
    weights = np.stack([np.linalg.det(n[:, rows]) for rows in ([1, 2], [2, 0], [0, 1])], axis=1)
    A, B, C = (
        np.sum(weights * np.sum(n * v, axis=2), axis=1)
        for v in (PLATFORM @ QUARTER.T, PLATFORM, -BASE)
    )
    real = np.hypot(A, B) > np.abs(C)
    spread = np.arccos(np.where(real, -C / np.hypot(A, B), 0.0))
    total = np.zeros(len(theta), dtype=int)
    for gamma in (np.arctan2(A, B) - spread, np.arctan2(A, B) + spread):
        turned = np.cos(gamma)[:, None, None] * PLATFORM + np.sin(gamma)[:, None, None] * (
            PLATFORM @ QUARTER.T
        )
        right = np.sum(n * (BASE - turned), axis=2)
        place = np.linalg.pinv(n) @ right[:, :, None]
        total += 2 * (real & (np.linalg.norm(place[:, :, 0], axis=1) < length))
    return total


# --- report ---------------------------------------------------------------------------------------


def random_poses(number: int) -> np.ndarray:
    return np.random.default_rng(SEED).uniform(-1, 1, (number, 4)) * (150, 150, 150, 180)


def report_determinant(report: Report, number: int) -> Loci:
    poses, loci = random_poses(number), pose_loci()
    gaps = [abs(determinant(pose) / factors(pose) - 1.0) for pose in poses]
    report.row(f"det A over its factors less 1, largest of {number} random poses", 0.0, max(gaps))
    report.row(
        "gamma at which every position is singular, arccos(c / a)",
        60.0,
        math.degrees(math.acos(C_RADIUS / A_RADIUS)),
        "deg",
    )
    report.row(
        f"radius of the singular circle at gamma = {GAMMA:g}",
        circle_radius(GAMMA),
        _locus_radius(report, loci),
        "mm",
    )
    return loci


def _locus_radius(report: Report, loci: Loci) -> float:
    """Mean radius of the locus that symkin traces over x, y; its spread goes into the report."""
    radii = np.concatenate([np.linalg.norm(curve.points, axis=1) for curve in loci.of("type 2")])
    report.row(
        "traced locus over x, y: points, largest distance from the circle",
        [len(radii), 0.0],
        [len(radii), float(np.abs(radii - circle_radius(GAMMA)).max())],
        "mm",
    )
    return float(radii.mean())


def pose_loci() -> Loci:
    platform = symkin.load("zhao2000")
    pose = (5.0, 5.0, 100.0, GAMMA)
    solution = symkin.solve(platform, pose=full(pose), start=inverse(pose)).solution
    return singular_loci(
        solution, ("x", "y"), ranges=((-160, 160), (-160, 160)), starts=30, seed=SEED
    )


def report_configurations(report: Report, platform: symkin.Mechanism) -> None:
    r = circle_radius(GAMMA)
    cases = {
        "on the circle": (r * math.cos(0.7), r * math.sin(0.7), 100.0, GAMMA),
        "gamma = 60": (20.0, -10.0, 100.0, 60.0),
        "gamma = -60": (-15.0, 30.0, 80.0, -60.0),
        "Zp = 0": (20.0, 30.0, 0.0, 10.0),
    }
    for name, pose in cases.items():
        found = at(platform, pose)
        report.row(
            f"{name}: kind and conditions",
            "type 2 (RO, II)",
            f"{', '.join(found.kinds)} ({', '.join(found.conditions)})",
        )
        report.row(f"{name}: distance to type 2", 0.0, found.distances["type 2"])
        (twist,) = found.twists
        if name == "Zp = 0":
            report.row(
                f"{name}: motion with the inputs held", "translation along (0, 0, 1)", str(twist)
            )
            continue
        report.row(
            f"{name}: pole of the motion with the inputs held, seen from above",
            list(pole(pose)),
            list(_pole(twist)),
            "mm",
            tolerance=1e-9,
        )
    above = (*(BASE[0] - PLATFORM[0]), 100.0, 0.0)
    found = singularity(platform, pose=full(above), start=inverse((5.0, 5.0, 105.0, 5.0)))
    report.row(
        "C_1 over a_1: kind, moving input",
        "type 1, theta1",
        f"{', '.join(found.kinds)}, {', '.join(*found.inputs)}",
    )


def _pole(twist: NamedScrew) -> np.ndarray:
    """Where the platform's velocity has no level part, from the twist about O."""
    omega, velocity = twist.vector[2], twist.vector[3:]
    return np.array([-velocity[1], velocity[0]]) / omega


def report_inputs(report: Report) -> None:
    """On the circle A = B = C = 0, so that gamma is free; at gamma = +-60 the equation has a double
    root.
    """
    rng = np.random.default_rng(SEED)
    vanishing, double, spread = [], [], []
    for gamma, angle, x, y, side in rng.uniform(-1, 1, (200, 5)) * (180, math.pi, 100, 100, 1):
        r = circle_radius(gamma)
        theta = inverse((r * math.cos(angle), r * math.sin(angle), 100.0, gamma))[:3]
        vanishing.append(np.abs(coefficients(theta)).max() / A_RADIUS)
        spread.append(
            max(abs(math.remainder(theta[k] - theta[k - 1] + 120.0, 180.0)) for k in range(3))
        )
        A, B, C = coefficients(inverse((x, y, 100.0, math.copysign(60.0, side)))[:3])
        double.append(abs(C * C - A * A - B * B) / (A * A + B * B + C * C))
    report.row("largest of |A|, |B|, |C| over a on 200 random circle poses", 0.0, max(vanishing))
    report.row("theta_2 - theta_1 and so on, plus 120, modulo 180, there", 0.0, max(spread), "deg")
    report.row(
        "(C^2 - A^2 - B^2) / (A^2 + B^2 + C^2) at 200 random positions, gamma = +-60",
        0.0,
        max(double),
    )


def report_self_motion(report: Report, platform: symkin.Mechanism) -> None:
    """One input on the circle: the platform turns by any gamma while all inputs stand still, up to
    the sphere |P| = l_op.
    """
    start = (circle_radius(GAMMA), 0.0, 100.0, GAMMA)
    given = inverse(start)
    found = symkin.modes(platform, joints=given)
    note = next(
        (n for n in found.notes if "not isolated" in n or "positive-dimensional" in n), "none"
    )
    report.row("symkin.modes there: says that solutions are not isolated", True, note != "none")
    worst = 0.0
    for gamma in (-100.0, -30.0, 0.0, 45.0, 90.0):
        turned = (
            math.cos(math.radians(gamma)) * PLATFORM
            + math.sin(math.radians(gamma)) * PLATFORM @ QUARTER.T
        )
        normals = np.column_stack([-np.sin(np.radians(given[:3])), np.cos(np.radians(given[:3]))])
        right = np.sum(normals * (BASE - turned), axis=1)
        place = np.linalg.lstsq(normals, right, rcond=None)[0]
        worst = max(worst, float(np.abs(normals @ place - right).max()))
    report.row(
        "largest miss of the three lines at gamma = -100, -30, 0, 45, 90 with these inputs",
        0.0,
        worst,
        "mm",
    )


def report_map(
    report: Report, platform: symkin.Mechanism, number: int, starts: int
) -> tuple[Loci, np.ndarray]:
    """Counts over the slice: closed form on a fine grid, complete enumeration on a coarse one, and
    the loci.
    """
    solution = symkin.solve(platform, joints=INPUT).solution
    loci = singular_loci(
        solution, ("theta1", "theta2"), ranges=WINDOW, kinds=("type 2",), starts=starts, seed=SEED
    )
    coarse = [np.linspace(low, high, number + 2)[1:-1] for low, high in WINDOW]
    equal = 0
    for one in coarse[0]:
        for two in coarse[1]:
            modes = symkin.modes(platform, joints=(one, two, *INPUT[2:]))
            equal += len(modes) == counts(np.array([[one, two, INPUT[2]]]), INPUT[3])[0]
    report.row(
        f"inputs of the slice where enumeration = closed form ({number} x {number})",
        number**2,
        equal,
    )
    fine = [np.linspace(low, high, 241) for low, high in WINDOW]
    inputs = np.array([(one, two, INPUT[2]) for two in fine[1] for one in fine[0]])
    number_of_poses = counts(inputs, INPUT[3]).reshape(len(fine[1]), len(fine[0]))
    shares = [100.0 * float(np.mean(number_of_poses == k)) for k in (0, 2, 4)]
    report.row("share of the slice with 0, 2, 4 real poses", None, shares, "%")
    report.row(
        "curves of type 2 over the slice, largest closure row over the size",
        None,
        [
            len(loci.of("type 2")),
            max(c.largest_row for c in loci.curves) / platform.characteristic_length,
        ],
    )
    report.row(
        "places along theta_1 where the closed-form number changes, a traced locus within a cell",
        *_bounded(loci, fine, number_of_poses),
    )
    curves = [c for c in loci.curves if not c.is_point]
    report.row(
        "smallest factor of det A, over its scale, on these curves: largest",
        0.0,
        max(_smallest_factor(c) for c in curves),
    )
    return loci, number_of_poses


def _bounded(loci: Loci, fine: list[np.ndarray], counts: np.ndarray) -> tuple[int, int]:
    """How many neighbours along theta_1 differ in number, and how many of these have a locus nearer
    than a cell.
    """
    rows, columns = np.nonzero(counts[:, :-1] != counts[:, 1:])
    points = np.column_stack([0.5 * (fine[0][columns] + fine[0][columns + 1]), fine[1][rows]])
    cell = np.array([fine[0][1] - fine[0][0], fine[1][1] - fine[1][0]])
    away = np.min(
        [picture_distance(c.points, c.closed, cell, points)[0] for c in loci.curves], axis=0
    )
    return len(points), int(np.sum(away < 1.0))


def _smallest_factor(curve: Locus) -> float:
    """The largest, over a curve, of the smallest of |cos gamma - c / a|, |Zp| / l_op and the
    circle's |r^2 - R^2| / a^2.
    """
    place = {name: k for k, name in enumerate(curve.names)}
    x, y, z, gamma = (
        curve.configurations[:, place[f"pose.{name}"]] for name in ("x", "y", "z", "gamma")
    )
    circle = x * x + y * y - A_RADIUS**2 - C_RADIUS**2 + 2 * A_RADIUS * C_RADIUS * np.cos(gamma)
    parts = [
        np.abs(np.cos(gamma) - C_RADIUS / A_RADIUS),
        np.abs(z) / INPUT[3],
        np.abs(circle) / A_RADIUS**2,
    ]
    return float(np.min(parts, axis=0).max())


def draw(over_pose: Loci, loci: Loci, counts: np.ndarray):
    figure = new_figure(13.5, 6.6)
    figure.suptitle("3-TRT + SPS platform: type 2 singularities", fontsize=15, weight="bold")
    left, right = figure.subplots(1, 2)
    draw_curves(left, over_pose)
    turn = np.linspace(0, 2 * math.pi, 200)
    left.plot(
        *circle_radius(GAMMA) * np.array([np.cos(turn), np.sin(turn)]),
        ":",
        color="k",
        lw=1,
        label="closed form",
        zorder=6,
    )
    left.fill(*BASE.T, fill=False, ec="0.6", label="base triangle")
    left.set_title(f"positions, gamma = {GAMMA:g}°: the circle")
    handles, labels = left.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    left.legend(list(unique.values()), list(unique), loc="lower left", fontsize=8)
    image = right.imshow(
        counts,
        origin="lower",
        extent=(*WINDOW[0], *WINDOW[1]),
        cmap="Blues",
        vmin=0,
        vmax=6,
        aspect="auto",
    )
    draw_curves(right, of_all_modes(loci))
    right.grid(visible=False)
    bar = figure.colorbar(image, ax=right, ticks=(0, 2, 4), boundaries=(-1, 1, 3, 5), shrink=0.7)
    bar.set_label("real poses, closed form")
    right.set_title(f"inputs, theta3 = {INPUT[2]}°, l_op = {INPUT[3]} mm: modes and loci")
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--grid", type=int, default=20, help="inputs per side that are enumerated (default: 20)"
    )
    parser.add_argument(
        "--starts", type=int, default=200, help="random starts of the loci (default: 200)"
    )
    options = parser.parse_args()
    platform = symkin.load("zhao2000")
    report = Report(
        "zhao2000_singular", "3-TRT + SPS platform: singular configurations and real modes", SEED
    )
    over_pose = report_determinant(report, 1000)
    report_configurations(report, platform)
    report_inputs(report)
    report_self_motion(report, platform)
    loci, counts = report_map(report, platform, options.grid, options.starts)
    report.finish(draw(over_pose, loci, counts), options.output)


if __name__ == "__main__":
    main()
