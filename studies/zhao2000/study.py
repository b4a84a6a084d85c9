"""3-TRT + SPS platform of four freedoms: mobility by reciprocal screws, inverse and direct problem
in closed form.

Notation: a_i, c_i corners of the base (side 240 mm) and platform (120 mm) triangles at -90, 30, 150
degrees; the platform stays level, X = (Xp, Yp, Zp, gamma); theta_i direction of limb i seen from
above, l_op = |OP|; limb = links 70 + 70 mm.

    inverse:  C_i = P + Rz(gamma) c_i,   theta_i = atan2(Y_Ci - Y_ai, X_Ci - X_ai),   l_op = |P|
    direct:   n_i . (P + Rz(gamma) c_i - a_i) = 0,
              n_i = (-sin theta_i, cos theta_i),   i = 1, 2, 3

With w_1 = n_2 x n_3 and so on in turn, sum w_i n_i = 0, so that P drops out of sum w_i (equation
i):

    A sin(gamma) + B cos(gamma) + C = 0,
    A = sum w_i n_i . J c_i,   B = sum w_i n_i . c_i,   C = -sum w_i n_i . a_i,

J the quarter turn. The paper writes tan(theta_i) in place of n_i. Units: mm; degrees where printed,
radians inside. Source: Zhao Tieshi et al., A novel four-DOF mixed platform mechanism and its
position analysis, Optics and Precision Engineering 8(1), 2000, 42-45. Table 1 has lost its decimal
points in the copy at hand (1000 reads 100.0).

Parts: `model` (geometry, inverse, closed form, closure), `screws` (mobility,
inputs and their rows), `pictures`; `singular` (a study of its own).
"""

from __future__ import annotations

import math
import sys
from itertools import product
from pathlib import Path

import numpy as np

import symkin
from symkin.spatial.rotation import euler_from_quaternion

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.guesses import attempt, least_squares, report_trials, rootfinder
from studies.shared.report import Report, options_parser
from studies.shared.words import statement, written
from studies.zhao2000.model import (
    BASE,
    INPUT,
    PAPER_POSES,
    PLATFORM,
    TABLE_1,
    closed_form,
    closure,
    coefficients,
    inside,
    inverse,
    limb_lengths,
    line_misses,
    position,
    turned,
)
from studies.zhao2000.pictures import draw, draw_guesses
from studies.zhao2000.screws import (
    LINKS_NAME,
    PLATFORM_NAME,
    report_figure_1,
    report_inputs,
    report_mobility,
    report_screws,
)

SEED = 4
ROUNDING = np.array([0.05, 0.05, 0.05, 0.05])
"""Half a unit of the last digit of the inputs in table 1: degrees, degrees, degrees, mm."""


# --- inverse problem (3.1, table 1) ---------------------------------------------------------------


def report_inverse(report: Report, platform: symkin.Mechanism) -> None:
    for pose, given in TABLE_1:
        report.row(
            f"(3), (4): inverse at {pose}",
            given,
            inverse(pose),
            "deg, mm",
            place="table 1",
            run=inverse,
            tolerance=0.05,
        )
        full = symkin.Pose.from_euler(np.array(pose[:3]), np.radians([0.0, 0.0, pose[3]]), "xyz")
        branches = symkin.modes(platform, pose=full)
        ahead = [m for m in branches if all(m.joints[f"radial{i}"] > 0 for i in (1, 2, 3))]
        own = np.array(ahead[0].actuated) % 360.0
        report.row(
            f"the same by symkin: 1 of {len(branches)} branches has all radii > 0",
            given,
            own,
            "deg, mm",
            place="table 1",
            run=branches,
            tolerance=0.05,
        )
        sampled = symkin.modes(platform, pose=full, method="multistart", seed=SEED)
        report.row(
            f"inverse at {pose}: branches by multistart",
            len(branches),
            len(sampled),
            place="table 1",
            run=sampled,
        )
    swapped = inverse(TABLE_1[1][0], BASE / 2, 2.0)
    report.row(
        "inverse with a of side 120, c of 240, as the letters read",
        INPUT,
        swapped,
        "deg, mm",
        place="4",
        run=inverse,
        verdict="refuted",
    )
    text = (
        "the example gives 120 and 240 mm as the sides of the 'upper, lower' triangles 'a, c', but "
        "a is the lower one: only a = "
        "240, c = 120 mm reproduces table 1."
    )
    report.erratum(
        text,
        shown=np.abs(inverse(TABLE_1[1][0]) - INPUT).max() < 0.06
        and np.abs(swapped - INPUT).max() > 10,
    )


# --- direct problem (3.2, 4) ----------------------------------------------------------------------


def pose_numbers(pose: symkin.Pose) -> np.ndarray:
    return np.array(
        [*pose.position, math.degrees(euler_from_quaternion(pose.quaternion, "xyz")[2])]
    )


def furthest(one: list[np.ndarray], other: list[np.ndarray]) -> float:
    """Largest difference of two lists of poses; infinite when their counts differ."""
    if len(one) != len(other):
        return math.inf
    return max(min(float(np.abs(a - b).max()) for b in other) for a in one)


def report_equations(report: Report) -> None:
    """The closure that the solvers are given: equations (6) with (5), each divided so that it is a
    length.
    """
    F = closure().F
    for i in range(3):
        report.row(
            f"(7)-(9) times cos(theta_{i + 1}), limb {i + 1}: 0 =",
            None,
            written(F[i]),
            "mm",
            place="(5)-(9)",
            run=closure,
        )
    report.row(
        "(6), second line, over l_op: 0 =", None, written(F[3]), "mm", place="(6)", run=closure
    )


def report_direct(report: Report, platform: symkin.Mechanism) -> list[np.ndarray]:
    poses = closed_form(INPUT)
    report.row("(10): A, B, C", None, coefficients(INPUT[:3]), "mm", place="(10)", run=coefficients)
    for k, (pose, paper) in enumerate(zip(poses, PAPER_POSES, strict=True), start=1):
        verdict = "reproduced" if k <= 2 else "refuted"
        report.row(
            f"direct, closed form, pose {k}",
            paper,
            pose,
            "mm, deg",
            place="4",
            run=closed_form,
            verdict=verdict,
        )
    found = symkin.modes(platform, joints=INPUT, method="continuation")
    modes = [pose_numbers(m.pose) for m in found]
    report.row("poses by continuation", 4, len(modes), place="4", run=found)
    report.row("completeness, line model", None, statement(found), place="4", run=found)
    report.row(
        "largest difference from the closed form",
        0,
        furthest(poses, modes),
        "mm, deg",
        place="4",
        run=(found, closed_form),
        tolerance=1e-9,
    )
    return poses


def random_guesses(count: int) -> np.ndarray:
    """Positions within 150 mm and any gamma."""
    return np.random.default_rng(SEED).uniform(-1, 1, (count, 4)) * (150.0, 150.0, 150.0, math.pi)


def report_guesses(
    report: Report, platform: symkin.Mechanism, poses: list[np.ndarray], count: int
) -> None:
    """The four modes from varied initial guesses, by CasADi's solvers on equations (6) and by
    symkin's multistart.
    """
    system, guesses = closure(), random_guesses(count)
    modes = [np.array([*p[:3], math.radians(p[3])]) for p in poses]
    trials = [
        attempt(search(system), guesses, inside(INPUT), modes)
        for search in (rootfinder, least_squares)
    ]
    report_trials(report, "direct", "3.2, 4", trials)
    for solver in ("batched", "newton", "ipopt"):
        found = symkin.modes(
            platform, joints=INPUT, method="multistart", solver=solver, starts=count, seed=SEED
        )
        apart = furthest(poses, [pose_numbers(m.pose) for m in found])
        name = f"direct, symkin.modes by multistart, {solver}"
        report.row(f"{name}: modes met, of 4", None, len(found), place="4", run=found)
        report.row(f"{name}: hits per mode", None, [m.hits for m in found], place="4", run=found)
        report.row(
            f"{name}: largest difference from the closed form",
            0,
            apart,
            "mm, deg",
            place="4",
            run=found,
            tolerance=1e-7,
        )


def report_rounding(report: Report, poses: list[np.ndarray]) -> None:
    """What the inputs' rounding makes of the pose: to first order, and over the corners of the box
    of inputs.
    """
    exact, low, high = np.array(TABLE_1[1][0]), np.full(4, np.inf), np.full(4, -np.inf)
    for corner in product((-1, 1), repeat=4):
        near = closed_form(np.array(INPUT) + ROUNDING * corner)[0]
        low, high = np.minimum(low, near), np.maximum(high, near)
    slopes = np.array(
        [
            (closed_form(np.array(INPUT) + step)[0] - closed_form(np.array(INPUT) - step)[0]) / 2e-4
            for step in 1e-4 * np.eye(4)
        ]
    )
    first = np.abs(slopes.T) @ ROUNDING
    printed = np.array(PAPER_POSES[0])
    report.row(
        "printed direct less table 1's pose",
        None,
        printed - exact,
        "mm, deg",
        place="4",
        run="difference of printed values",
    )
    report.row(
        "most that the inputs' rounding explains, first order",
        None,
        first,
        "mm, deg",
        place="4",
        run=(closed_form, report_rounding),
    )
    report.row(
        "poses over the box of inputs, least", None, low, "mm, deg", place="4", run=closed_form
    )
    report.row(
        "poses over the box of inputs, most", None, high, "mm, deg", place="4", run=closed_form
    )
    inside_box = bool(
        np.all((low - 0.005 <= exact) & (exact <= high + 0.005))
        and np.all(np.abs(poses[0] - exact) <= first * 1.01)
    )
    report.row(
        "'the difference comes from truncated inputs': explained",
        True,
        inside_box,
        place="4",
        run=closed_form,
    )


def report_links(report: Report, poses: list[np.ndarray]) -> None:
    """The real limbs: two links of 70 mm reach 140 mm."""
    for pose in poses[::2]:
        report.row(
            f"limb lengths at gamma = {pose[3]:.3f}, reach 140",
            None,
            limb_lengths(pose),
            "mm",
            place="4",
            run=limb_lengths,
        )
    links = symkin.load(LINKS_NAME)
    found = symkin.modes(links, joints=INPUT)
    report.row(
        "real limbs: configurations, poses", None, [len(found), found.poses], place="4", run=found
    )
    report.row("completeness, real limbs", None, statement(found), place="4", run=found)
    sampled = symkin.modes(links, joints=INPUT, method="multistart", seed=SEED)
    missed = len(found) - len(sampled)
    report.row(
        "real limbs by multistart: configurations met, missed",
        None,
        [len(sampled), missed],
        place="4",
        run=sampled,
    )
    for pose in poses:
        here = [m for m in found if np.abs(pose_numbers(m.pose) - pose).max() < 1e-6]
        elbows = {tuple(round(m.joints[f"elbow{i}"], 3) for i in (1, 2, 3)) for m in here}
        sides = [len({e[i] for e in elbows}) for i in range(3)]
        label = (
            f"configurations at ({', '.join(f'{v:.2f}' for v in pose)}), elbow positions of each "
            f"limb"
        )
        report.row(label, None, [len(elbows), *sides], place="4", run=found)


def report_verdict(report: Report, poses: list[np.ndarray]) -> None:
    """Each pose of the paper against its own equations, and where the wrong pair came from."""
    for pose in PAPER_POSES:
        right = np.abs(line_misses(pose)).max() < 0.02 and abs(inverse(pose)[3] - INPUT[3]) < 0.02
        report.row(
            f"{pose}: {'right' if right else 'wrong'}; distances from the three lines",
            [0, 0, 0],
            line_misses(pose),
            "mm",
            place="4",
            run=line_misses,
            verdict="reproduced" if right else "refuted",
        )
    wrong, A, B, C = PAPER_POSES[2], *coefficients(INPUT[:3])
    report.row(
        f"inverse of the paper's {wrong}",
        INPUT,
        inverse(wrong),
        "deg, mm",
        place="4",
        run=inverse,
        verdict="refuted",
    )
    sines = np.sort(np.roots([A * A + B * B, 2 * A * C, C * C - B * B]))
    arcsines = np.degrees(np.arcsin(sines))
    report.row(
        "arcsin of the two roots sin(gamma)",
        [5.02, 14.99],
        arcsines,
        "deg",
        place="(10)",
        run=coefficients,
    )
    left = A * sines + B * np.sqrt(1 - sines**2) + C
    report.row(
        "A sin + B cos + C there", [0, 0], left, place="(10)", run=coefficients, verdict="refuted"
    )
    pairs = {
        lines: position(INPUT[:3], math.radians(arcsines[1]), lines)
        for lines in ((0, 1), (0, 2), (1, 2))
    }
    for lines, xy in pairs.items():
        used = lines == (0, 2)
        report.row(
            f"Xp, Yp there from lines {lines[0] + 1} and {lines[1] + 1} alone",
            wrong[:2],
            xy,
            "mm",
            place="(7)-(9)",
            run=position,
            verdict="reproduced" if used else "differs",
        )
    miss, second = abs(line_misses(wrong)[1]), poses[2]
    text = (
        f"the poses (-3.85, 23.60, +-102.45, 14.99) are wrong; they are "
        f"{tuple(np.round(second[:2], 3).tolist())}, "
        f"+-{second[2]:.3f}, {second[3]:.3f}. arcsin gave {arcsines[1]:.2f} for {second[3]:.2f}, "
        f"and two of the three lines the "
        f"position: it misses the line of limb 2 by {miss:.0f} mm, its own inverse has theta_2 = "
        f"{inverse(wrong)[1]:.1f}."
    )
    from_arcsine = abs(arcsines[1] - 14.99) < 0.01 and np.abs(pairs[0, 2] - wrong[:2]).max() < 0.01
    shown = (
        miss > 1.0
        and from_arcsine
        and abs(second[3] + arcsines[1] - 180.0) < 1e-6
        and np.abs(line_misses(second)).max() < 1e-9
    )
    report.erratum(text, shown=shown)
    lengths = limb_lengths(second)
    text = (
        "the input has two platform poses with the real limbs, not four assembly modes: the true "
        "second pair needs limbs of "
        f"{', '.join(f'{v:.1f}' for v in lengths)} mm, and two links of 70 mm reach 140."
    )
    report.erratum(text, shown=lengths.min() > 140.0 and limb_lengths(poses[0]).max() < 140.0)
    text = (
        "equations (6) to (9) divide by cos(theta_1), which is zero at the first row of table 1 "
        "(theta_1 = 90)."
    )
    report.erratum(text, shown=abs(math.cos(math.radians(TABLE_1[0][1][0]))) < 1e-12)


def report_upside_down(report: Report) -> None:
    """The platform turned over, c_i -> (x, -y): what a declared level motion leaves out."""
    over = PLATFORM * (1.0, -1.0)
    A, B, C = coefficients(INPUT[:3], over)
    report.row(
        "upside down, table 1 row 2: |C| / sqrt(A^2 + B^2), above 1 no real pose",
        None,
        abs(C) / math.hypot(A, B),
        run=coefficients,
    )
    theta, length = TABLE_1[0][1][:3], TABLE_1[0][1][3]
    report.row(
        "upside down, row 1: A, B, C (all zero: a self-motion)",
        None,
        coefficients(theta, over),
        run=coefficients,
    )
    least = math.inf
    for gamma in np.radians(np.arange(0.0, 360.0, 0.5)):
        xy = position(theta, gamma, platform=over)
        reach = np.linalg.norm(xy + turned(over, gamma) - BASE, axis=1)
        height = length**2 - xy @ xy
        least = min(least, math.sqrt(reach.max() ** 2 + height)) if height >= 0 else least
    report.row(
        "longest limb on that self-motion, least value (reach 140)", None, least, "mm", run=position
    )


def report_outside(report: Report) -> None:
    report.outside(
        "other mechanisms of few freedoms (3-RPS, Delta, Tsai, 3-RRC)",
        "1",
        "a survey of literature, no figures",
    )
    report.outside("uses (assembly of square holes)", "1", "an application, no figures")


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--guesses", type=int, default=300, help="random guesses for each solver (default: 300)"
    )
    parser.add_argument(
        "--points",
        type=int,
        default=41,
        help="guesses along each side of the picture (default: 41)",
    )
    options = parser.parse_args()
    platform = symkin.load(PLATFORM_NAME)
    report = Report(
        "zhao2000", "3-TRT + SPS platform (Zhao 2000): mobility, inverse and direct problem", SEED
    )
    figure_1 = report_figure_1(report)
    report_screws(report)
    report_mobility(report)
    report_inputs(report)
    report_inverse(report, platform)
    report_equations(report)
    poses = report_direct(report, platform)
    report_guesses(report, platform, poses, options.guesses)
    report_rounding(report, poses)
    report_links(report, poses)
    report_verdict(report, poses)
    report_upside_down(report)
    report_outside(report)
    guesses = draw_guesses(closure(), poses, options.points)
    report.finish(draw(poses), options.output, figure1=figure_1, guesses=guesses)


if __name__ == "__main__":
    main()
