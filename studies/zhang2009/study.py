"""Six-SPS Gough-Stewart platform: direct kinematics by Newton's method on six equations in three
lengths and three angles.

Notation: A_i platform joint centres on a circle of 250 mm at 240, 330, 0, 90, 120, 210 degrees, B_i
base joint centres on 275 mm at 270, 300, 30, 60, 150, 180 degrees (both z = 0), L_i the length of
limb i, X = (x, y, z, alpha, beta, gamma):

    f_i(X) = |B_i - (p + R A_i)|^2 - L_i^2 = 0,   p = (x, y, z),
    R = Rx(alpha) Ry(beta) Rz(gamma)   ('XYZ', moving axes)

    X <- X - C F,   C = D^-1 by Gauss and Jordan,   D = dF/dX.

Units: mm; angles in degrees where printed, in radians inside; the residual max |f_i| is in mm^2.
Source: Zhang Zhaoyin, Practical solution of 6-DOF parallel robot position forward solution,
Computer Engineering and Applications 45(9), 2009, 47-48. The copy at hand ends at table 1: tables 2
(start) and 3 (iterations) and the list of references are missing, so that the start here and the 24
unknowns of references [3], [4] are our choice.

Parts: `model` (printed matrices and lines, equations, also in 24 and three unknowns), `newton` (the
method and its operations), `claims` (unknowns compared, accuracy, real time), `instructions` (the
example in C), `pictures`; `modes_map` (a study of its own).
"""

from __future__ import annotations

import sys
from pathlib import Path

import casadi as ca
import numpy as np

import symkin

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, options_parser
from studies.shared.words import statement, written
from studies.zhang2009.claims import (
    SEED,
    report_claims,
    report_fewest,
    report_guesses,
    report_unknowns,
)
from studies.zhang2009.model import (
    A_PRINTED,
    B_IN_EQUATIONS,
    B_PRINTED,
    EVIDENT_POSE,
    START,
    START_NEARBY,
    TABLE_1,
    A,
    B,
    Equations,
    equations,
    euler_pose,
    inside,
    jacobian_by_axes,
    joints,
    leg_lengths,
    outside,
    printed_joints,
    quadratic_unknowns,
    quaternion_pose,
    rotation_of,
    six_unknowns,
    symbols,
    third_derivative,
)
from studies.zhang2009.newton import (
    Path,
    gauss_jordan,
    newton,
    rootfinder_pose,
)
from studies.zhang2009.pictures import draw, draw_figure_1, draw_guesses, draw_unknowns

# --- introduction (1) -----------------------------------------------------------------------------


def report_introduction(report: Report, platform: symkin.Mechanism, found: symkin.Modes) -> None:
    single = symkin.modes(platform, pose=quaternion_pose(EVIDENT_POSE))
    report.row(
        "'inverse easy, direct very difficult': solutions of inverse (lengths > 0), direct "
        "(complex)",
        None,
        [
            sum(all(length > 0 for length in mode.actuated_values) for mode in single),
            found.complex_count,
        ],
        place="1",
        run=(single, found),
    )
    six, many = third_derivative(six_unknowns()), third_derivative(quadratic_unknowns())
    report.row(
        "third derivatives of 'quadratic equations in six unknowns': largest",
        0.0,
        six,
        place="1",
        run=third_derivative,
        verdict="refuted",
    )
    report.row(
        "third derivatives of the quadratic equations in 24 unknowns: largest",
        0.0,
        many,
        place="1, [3], [4]",
        run=third_derivative,
        tolerance=1e-9,
    )
    text = (
        "equations (2) are called quadratic, but in the six unknowns they hold sines and cosines: "
        "their third derivatives do not vanish."
    )
    report.erratum(text, shown=six > 0.1 and many < 1e-9)
    report.outside(
        "the 24 unknowns of [3], [4]",
        "1",
        "the list of references is missing; the natural ones below are used instead",
    )
    rows = quadratic_unknowns().F
    for title, k in (
        ("limb 1", 0),
        ("joint 1 in the platform's plane, x", 6),
        ("n.n = 1", 21),
        ("n.o = 0", 23),
    ):
        report.row(
            f"24 unknowns, in radii of the base, {title}: 0 =",
            None,
            written(rows[k]),
            place="1, [3], [4]",
            run=quadratic_unknowns,
        )
    report.outside(
        "[1], [2]: direct problem by iterating with velocities",
        "1",
        "their lists of equations are not in the paper",
    )
    report.outside(
        "[5], [6], [7]: direct problem by neural networks", "1", "no figures, no networks are given"
    )


# --- geometry and transformation (2) --------------------------------------------------------------


def radii(points: np.ndarray) -> np.ndarray:
    """Distances from the origin."""
    return np.linalg.norm(points, axis=1)


def central_angles(points: np.ndarray) -> np.ndarray:
    """Angles between neighbours on a circle, sorted, degrees."""
    turns = np.sort(np.degrees(np.arctan2(points[:, 1], points[:, 0])) % 360.0)
    return np.sort(np.diff([*turns, turns[0] + 360.0]))


def report_geometry(report: Report, system: Equations) -> None:
    for name, printed, radius, right in (("A", A_PRINTED, 250.0, A), ("B", B_PRINTED, 275.0, B)):
        report.row(
            f"central angles of the {name}_i, sorted",
            [30.0] * 3 + [90.0] * 3,
            central_angles(right),
            "deg",
            place="2.1",
            run=central_angles,
        )
        distances = radii(printed)
        report.row(
            f"printed matrix {name}: |{name}_1| to |{name}_6|",
            [radius] * 6,
            distances,
            "mm",
            place="2.1",
            run=radii,
            verdict="reproduced" if name == "A" else "refuted",
        )
    report.row(
        "B of equations (2): |B_1| to |B_6|",
        [275.0] * 6,
        radii(B_IN_EQUATIONS),
        "mm",
        place="3, (2)",
        run=radii,
    )
    report.row(
        "limb lengths, frames coincident (figure 1)",
        None,
        leg_lengths(system, (0.0,) * 6),
        "mm",
        place="2.1",
        run=leg_lengths,
    )
    D = np.asarray(system.evaluate(np.zeros(6))[1])
    report.row(
        "rank of D there: no place to start from",
        None,
        int(np.linalg.matrix_rank(D, tol=1e-6)),
        place="2.1",
        run=equations,
    )


def report_base_misprint(report: Report, system: Equations) -> None:
    printed = equations(base=B_PRINTED)
    first = leg_lengths(printed, EVIDENT_POSE)[0], leg_lengths(system, EVIDENT_POSE)[0]
    report.row(
        "limb 1 at the pose with B_1 = (0, -125, 0), (0, -275, 0)",
        [144.6, 144.6],
        first,
        "mm",
        place="2.1",
        run=leg_lengths,
        verdict="refuted",
    )
    end = outside(newton(printed, START)[-1][0])
    report.row(
        "Newton with B_1 = (0, -125, 0)",
        EVIDENT_POSE,
        end,
        "mm, deg",
        place="2.1",
        run=newton,
        verdict="refuted",
    )
    shown = (
        abs(first[0] - 144.6) > 1.0
        and abs(first[1] - 144.6) < 0.1
        and abs(np.linalg.norm(B_PRINTED[0]) - 275) > 1
    )
    report.erratum(
        "B_1 = (0, -125, 0) in the matrix B is off its circle; (0, -275, 0) in equation (2) is "
        "right.",
        shown=shown,
    )


def wrong_entries(printed: np.ndarray, right: np.ndarray) -> list[str]:
    """Names (row, column from 1) of the entries that differ."""
    return [f"{i + 1}, {j + 1}" for i, j in np.argwhere(np.abs(printed - right) > 1e-9)]


def report_transformation(report: Report) -> None:
    """T and the 18 lines against the composition of three turns."""
    X = inside(EVIDENT_POSE)
    composed = quaternion_pose(EVIDENT_POSE).rotation
    as_printed = np.asarray(equations(misprint=True).R(X))
    report.row(
        "entries of the printed rotation that are not those of Rx Ry Rz",
        "none",
        ", ".join(wrong_entries(as_printed, composed)),
        place="2.2, T",
        run=(equations, quaternion_pose),
        verdict="refuted",
    )
    report.row(
        "largest difference with row 3, column 1 = s_alpha s_gamma - c_alpha s_beta c_gamma",
        0.0,
        float(np.abs(rotation_of(X[3:]) - composed).max()),
        place="2.2, T",
        run=(rotation_of, quaternion_pose),
        tolerance=1e-12,
    )
    texts = symbols()[0]
    for i in range(6):
        lines = "; ".join(f"{c}_{i + 1} = {written(texts[i, k])}" for k, c in enumerate("xyz"))
        report.row(f"A'_{i + 1}, right", None, lines, "mm", place="2.2", run=symbols)
    P = ca.SX.sym("X", 6)
    lines = np.asarray(ca.Function("lines", [P], [printed_joints(P)])(X))
    right = X[:3] + A @ composed.T
    wrong = [f"{'xyz'[j]}_{i + 1}" for i, j in np.argwhere(np.abs(lines - right) > 1e-9)]
    report.row(
        "lines of x_1 to z_6 that are not T A_i with the right T",
        "none",
        ", ".join(wrong),
        place="2.2",
        run=(printed_joints, joints),
        verdict="refuted",
    )


def report_rotation_misprint(report: Report, system: Equations) -> Path:
    printed = equations(misprint=True)
    R = np.asarray(printed.R(inside(EVIDENT_POSE)))
    rank = [
        int(np.linalg.matrix_rank(np.asarray(e.evaluate(inside(START))[1]), tol=1e-6))
        for e in (printed, system)
    ]
    path = newton(printed, START_NEARBY)
    false_pose = outside(path[-1][0])
    miss = leg_lengths(system, false_pose) - TABLE_1
    report.row(
        "rank of D at a start without rotation: T as printed, right",
        None,
        rank,
        place="2.2, T",
        run=equations,
    )
    report.row(
        "largest entry of R^T R - I, T as printed",
        0.0,
        float(np.abs(R.T @ R - np.eye(3)).max()),
        place="2.2, T",
        run=equations,
        verdict="refuted",
    )
    report.row(
        f"Newton, T as printed, {len(path) - 1} steps from {START_NEARBY}",
        EVIDENT_POSE,
        false_pose,
        "mm, deg",
        place="2.2, T",
        run=newton,
        verdict="refuted",
    )
    report.row(
        "limb lengths there under the right rotation, less table 1",
        0.0,
        miss,
        "mm",
        place="2.2, T",
        run=leg_lengths,
        verdict="refuted",
    )
    text = (
        "row 3, column 1 of T, and with it every z_i but z_4, is printed s_alpha s_gamma - c_alpha "
        "s_beta s_gamma; it must be "
        f"s_alpha s_gamma - c_alpha s_beta c_gamma. As printed, R is no rotation, D has rank "
        f"{rank[0]} without rotation, and "
        f"Newton goes to a false pose that misses the limbs by up to {np.abs(miss).max():.1f} mm."
    )
    report.erratum(text, shown=rank == [5, 6] and path[-1][1] < 1e-6 and np.abs(miss).max() > 1.0)
    return path


# --- Newton's method (3) --------------------------------------------------------------------------


def report_equations(report: Report, system: Equations) -> None:
    texts = symbols()[1]
    for i in range(6):
        report.row(f"f_{i + 1} = 0", None, written(texts[i]), "mm^2", place="(1), (2)", run=symbols)
    X = inside(EVIDENT_POSE)
    D = np.asarray(system.evaluate(X)[1])
    report.row(
        "D by CasADi less D by the axes of the three turns: largest over |D|",
        0.0,
        float(np.abs(D - jacobian_by_axes(X)).max() / np.abs(D).max()),
        place="(4), D",
        run=(equations, jacobian_by_axes),
        tolerance=1e-12,
    )


def report_printed_update(report: Report, system: Equations) -> Path:
    _, D = (np.asarray(v) for v in system.evaluate(inside(START)))
    identity = float(np.abs(gauss_jordan(D) @ D - np.eye(6)).max())
    path = newton(system, START, as_printed=True, most=8)
    steps = np.diff([X for X, _ in path], axis=0)
    report.row(
        "C by Gauss and Jordan: largest entry of C D - I",
        0.0,
        identity,
        place="3",
        run=gauss_jordan,
        tolerance=1e-9,
    )
    report.row(
        "printed update X - C D: every step in each unknown",
        None,
        [float(steps.min()), float(steps.max())],
        "mm, rad",
        place="3, after (5)",
        run=newton,
    )
    report.row(
        "residual before, after 8 printed updates",
        None,
        [path[0][1], path[-1][1]],
        "mm^2",
        place="3, after (5)",
        run=newton,
    )
    text = (
        "the update is printed X - C D, but D is the Jacobian and C its inverse, so that C D is "
        "the identity and every "
        "unknown falls by 1 at each step whatever the limbs measure; it must be X - C F, as in (5)."
    )
    report.erratum(
        text, shown=identity < 1e-9 and bool(np.abs(steps + 1).max() < 1e-9) and path[-1][1] > 1e3
    )
    return path


# --- example (4) ----------------------------------------------------------------------------------


def report_table_1(report: Report, platform: symkin.Mechanism, system: Equations) -> None:
    inverse = symkin.solve(platform, pose=quaternion_pose(EVIDENT_POSE))
    own = inverse.solution.actuated_values
    report.row(
        "limb lengths at (119, 88, 72; 10, 21, 15)",
        TABLE_1,
        leg_lengths(system, EVIDENT_POSE),
        "mm",
        place="(1), table 1",
        run=leg_lengths,
    )
    report.row(
        "the same by symkin's inverse", TABLE_1, own, "mm", place="(1), table 1", run=inverse
    )
    tenths = 10 * np.array(own)
    fits = (np.floor(tenths) == np.round(10 * TABLE_1)) | (
        np.round(tenths) == np.round(10 * TABLE_1)
    )
    report.row(
        "of these truncate or round to table 1", 6, int(fits.sum()), place="table 1", run=inverse
    )


def report_newton(report: Report, system: Equations) -> Path:
    report.outside(
        "table 2: the start",
        "table 2",
        "missing from the copy at hand; (0, 0, 100; 0, 0, 0) is used instead",
    )
    path = newton(system, START)
    for k, (X, residual) in enumerate(path):
        values = [*outside(X), residual]
        report.row(
            f"Newton, step {k}: x, y, z, alpha, beta, gamma; max |f|",
            None,
            values,
            "mm, deg; mm^2",
            place="(5)",
            run=newton,
        )
    report.row(
        "Newton steps from (0, 0, 100; 0, 0, 0)", None, len(path) - 1, place="(5)", run=newton
    )
    report.outside(
        "table 3: the iterations", "table 3", "missing from the copy at hand; not comparable"
    )
    for method in ("newton", "fast_newton"):
        pose = rootfinder_pose(system, method)
        report.row(
            f"CasADi rootfinder {method}",
            EVIDENT_POSE,
            pose,
            "mm, deg",
            place="4",
            run=rootfinder_pose,
            tolerance=0.1,
        )
    return path


def report_modes(report: Report, platform: symkin.Mechanism, found: symkin.Modes) -> None:
    poses = [euler_pose(mode.pose) for mode in found]
    report.row("real modes by continuation", None, len(found), place="4", run=found)
    report.row(
        "complex solutions of the six equations", None, found.complex_count, place="4", run=found
    )
    report.row("completeness", None, statement(found), place="4", run=found)
    for k, pose in enumerate(poses, start=1):
        paper = EVIDENT_POSE if k == 1 else None
        report.row(f"mode {k}", paper, pose, "mm, deg", place="4", run=found, tolerance=0.1)
    mirrored = [pose * (1, 1, -1, -1, -1, 1) for pose in poses]
    pairs = sum(any(np.abs(m - p).max() < 1e-8 for p in poses) for m in mirrored) // 2
    report.row("mirror pairs (z, alpha, beta change sign)", None, pairs, place="4", run=found)
    for solver in ("newton", "fast_newton", "ipopt"):
        ends = [
            symkin.solve(
                platform, joints=TABLE_1, start=quaternion_pose(np.round(pose, -1)), solver=solver
            )
            for pose in poses
        ]
        near = sum(
            bool(np.abs(euler_pose(e.solution.pose) - p).max() < 1e-8)
            for e, p in zip(ends, poses, strict=True)
        )
        report.row(
            f"modes reached by symkin.solve, {solver}, from their poses rounded to 10 mm and 10 "
            f"degrees",
            None,
            near,
            place="4",
            run=ends,
        )


# --- all ------------------------------------------------------------------------------------------


def report_outside(report: Report) -> None:
    report.outside("conclusions and references", "after table 1", "missing from the copy at hand")
    report.outside("'the usability is strong'", "abstract", "an opinion, without figures")


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--guesses", type=int, default=200, help="random guesses for each search (default: 200)"
    )
    parser.add_argument(
        "--points",
        type=int,
        default=31,
        help="guesses along each side of the picture (default: 31)",
    )
    options = parser.parse_args()
    platform, system = symkin.load("zhang2009"), equations()
    found = symkin.modes(platform, joints=TABLE_1)
    poses = [mode.pose for mode in found]
    report = Report(
        "zhang2009",
        "Gough-Stewart platform (Zhang 2009): direct kinematics by Newton's method",
        SEED,
    )
    report_introduction(report, platform, found)
    report_fewest(report, found)
    report_geometry(report, system)
    report_base_misprint(report, system)
    report_transformation(report)
    misprint = report_rotation_misprint(report, system)
    report_equations(report, system)
    printed = report_printed_update(report, system)
    report_table_1(report, platform, system)
    right = report_newton(report, system)
    report_modes(report, platform, found)
    trials = report_guesses(report, platform, found, options.guesses)
    paths = report_unknowns(report)
    counts = report_claims(report, system, found)
    report_outside(report)
    report.finish(
        draw(poses, right, misprint, printed),
        options.output,
        figure1=draw_figure_1(poses[0]),
        guesses=draw_guesses(six_unknowns(), poses, options.points),
        unknowns=draw_unknowns(paths, trials, counts),
    )


if __name__ == "__main__":
    main()
