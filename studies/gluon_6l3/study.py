"""Gluon-6L3, a 6R arm with joints 2, 3, 4 parallel: the tutorial page on its forward and inverse
kinematics, line by line.

The page: DH model (of an earlier page), forward kinematics as a product of six matrices with the
example of 15 degrees at each joint, the inverse by equations matched after inverting A_1, and a
check by the Robotics Toolbox, whose inverse iterates with the Jacobian from zero joints. Its
formulas were pictures, are missing in the copy at hand, and are derived anew here; its two listings
are whole. Elements [row, column] count from 1; the page's q_i are DH angles t_i, here q_i are joint
values, t_i = q_i + offset_i; c234 = cos(t2 + t3 + t4).

Units: mm; joint values in degrees where printed, in radians inside. Random joints are uniform in a
turn. Source: "Gluon-6L3 forward and inverse kinematics", tutorial page. Parts: `forward_transform`
(sums of angles of parallel axes), `model` (geometry, closed form), `numeric` (inverse by
iteration), `solutions` (rows on all solutions), `pictures`.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import casadi as ca
import numpy as np

import symkin

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.gluon_6l3.forward_transform import chain_of, forward_transform
from studies.gluon_6l3.model import (
    EXAMPLE,
    OFFSET,
    A,
    closed_form,
    determinant,
    difference_jacobian,
    forward,
    inverse_by_formula,
    link,
    middle,
    pose_error,
    printed_forward,
    printed_links,
    product_expression,
    random_poses,
    shoulders,
    symbolic_jacobian,
    symbolic_transform,
    third_row_errors,
    tool_expression,
    wrap,
    wrist_near_axis,
    wrists,
)
from studies.gluon_6l3.numeric import (
    Equations,
    Iteration,
    continued,
    equations,
    given_numbers,
    rootfinder_of_six,
)
from studies.gluon_6l3.pictures import draw, draw_arm, draw_guesses
from studies.gluon_6l3.solutions import (
    SEED,
    casadi_trials,
    report_enumeration,
    report_random,
    report_speed,
)
from studies.shared.guesses import attempt, least_squares
from studies.shared.report import Report, options_parser
from studies.shared.words import written

THETA = [15.0] * 6
"""Joint values of the listings, degrees."""


# --- forward kinematics ---------------------------------------------------------------------------


def report_model(report: Report, arm: symkin.Mechanism) -> None:
    rng = np.random.default_rng(SEED)
    samples = rng.uniform(-np.pi, np.pi, (50, 6))
    apart = max(
        np.abs(printed - link(i, q[i] + OFFSET[i])).max()
        for q in samples
        for i, printed in enumerate(printed_links(q))
    )
    report.row(
        "A1 ... A6 as printed less those of the table of links, 50 random joints",
        0,
        float(apart),
        "mm",
        place="listings 1, 2",
        run=(printed_links, link),
        tolerance=1e-12,
    )
    axes = np.array([joint.axis for _, joint in arm.joints])
    turns = [float(np.linalg.norm(np.cross(a, b))) for a, b in pairwise(axes[1:4])]
    report.row(
        "joints 2, 3, 4 parallel: |z2 x z3|, |z3 x z4|",
        [0, 0],
        turns,
        place="inverse 2)",
        run=symkin.load,
        tolerance=1e-12,
    )
    upright = float(forward(np.zeros(6))[2, 3] - (105.03 + 2 * 174.42 + 80.09))
    report.row(
        "'the initial posture is vertical': height at zero joints less d1 + |a2| + |a3| + d5",
        0,
        upright,
        "mm",
        place="listing 2",
        run=forward,
        tolerance=1e-9,
    )


def report_symbols(report: Report, arm: symkin.Mechanism) -> None:
    """T in sums of angles, found from the axes."""
    whole = symbolic_transform()
    runs = [[k + 1 for k in run] for run in whole.runs]
    report.row(
        "runs of parallel axes, found from the DH table",
        [[1], [2, 3, 4], [5], [6]],
        runs,
        place="forward",
        run=whole,
    )
    names = [column + axis for axis in "xyz" for column in "noap"]
    for k, name in enumerate(names):
        i, j = divmod(k, 4)
        report.row(
            f"T[{i + 1},{j + 1}] = {name}", None, written(whole.T[i, j]), place="forward", run=whole
        )
    t, rng = ca.SX.sym("t", 6), np.random.default_rng(SEED)
    q = rng.uniform(-np.pi, np.pi, (100, 6))
    numeric = ca.Function("T", [t], [tool_expression(t)])
    apart = max(np.abs(np.asarray(numeric(one)) - printed_forward(one)).max() for one in q)
    report.row(
        "the same less the listing's product, 100 random joints",
        0,
        float(apart),
        "mm",
        place="forward",
        run=(forward_transform, printed_forward),
        tolerance=1e-9,
    )
    counts = [
        ca.Function("T", [t], [make(t)], {"cse": True}).n_instructions()
        for make in (product_expression, tool_expression)
    ]
    report.row(
        "instructions: product of six matrices; in s234, c234",
        None,
        counts,
        place="forward",
        run=(product_expression, whole),
    )
    own = forward_transform(chain_of(arm)).function()
    poses = [(symkin.solve(arm, joints=np.degrees(one)), one) for one in q[:10]]
    gap = max(
        np.abs(result.solution.pose.matrix - np.asarray(own(one))).max() for result, one in poses
    )
    report.row(
        "sums of angles found from the mechanism's axes less symkin's forward, 10 random joints",
        0,
        float(gap),
        "mm",
        place="forward",
        run=(chain_of, poses[0][0]),
        tolerance=1e-9,
    )


def report_example(report: Report, arm: symkin.Mechanism) -> np.ndarray:
    T = forward(EXAMPLE)
    for i in range(3):
        report.row(
            f"T1 at 15 degrees each, row {i + 1} (n, o, a, p)",
            None,
            T[i],
            "-, mm",
            place="listing 1",
            run=forward,
        )
    report.row(
        "T1: listing 1 less the table of links",
        0,
        float(np.abs(printed_forward(EXAMPLE) - T).max()),
        "mm",
        place="listing 1",
        run=(printed_forward, forward),
        tolerance=1e-9,
    )
    own = symkin.solve(arm, joints=THETA)
    report.row(
        "T1: symkin less the table of links",
        0,
        float(np.abs(own.solution.pose.matrix - T).max()),
        "mm",
        place="listing 1",
        run=own,
        tolerance=1e-9,
    )
    found = symkin.modes(arm, joints=THETA)
    report.row("'the model gives one pose only': poses", 1, found.poses, place="forward", run=found)
    report.outside(
        "the printed T1 and the formula pictures",
        "forward",
        "pictures, missing in the copy at hand",
    )
    return T


# --- closed form ----------------------------------------------------------------------------------


def report_equations(
    report: Report, arm: symkin.Mechanism, system: Equations, T: np.ndarray
) -> None:
    """Twelve equations, six unknowns, and the matched elements of A1^-1 T = A2 ... A6."""
    slope = ca.Function(
        "slope", [system.twelve.X, system.twelve.u], [ca.jacobian(system.twelve.F, system.twelve.X)]
    )
    rank = int(np.linalg.matrix_rank(np.asarray(slope(EXAMPLE, given_numbers(T))), tol=1e-6))
    report.row(
        "equations and unknowns of T(q) = T",
        [12, 6],
        list(slope.size_out(0)),
        place="inverse",
        run=equations,
    )
    report.row("rank of the twelve at the example", None, rank, place="inverse", run=equations)
    gap = np.abs(inverse_by_formula(T) - np.linalg.inv(T)).max()
    report.row(
        "(R^T, -R^T p) less the inverse of T",
        0,
        float(gap),
        place="inverse",
        run=inverse_by_formula,
        tolerance=1e-12,
    )
    right = symbolic_transform(2, 6)
    for i, j in ((3, 3), (3, 4), (3, 1), (3, 2), (2, 3), (1, 3)):
        text = f"B[{i},{j}], B = A1^-1 T = A2 ... A6"
        report.row(text, None, written(right.T[i - 1, j - 1]), place="inverse 1)", run=right)
    report.row(
        "B[3,3], B[3,4]: values of q1", 2, len(shoulders(T)), place="inverse 1)", run=shoulders
    )
    pairs = wrists(T)
    report.row(
        "pairs (q1, q5), and (q1, q5, q6) of [3,1] over [3,2]",
        [4, 4],
        [len({p[:2] for p in pairs}), len(pairs)],
        place="inverse 1)",
        run=wrists,
    )
    outside = wrist_near_axis(50.0)
    found = continued(arm, outside)
    report.row(
        "solutions with the wrist 50 mm from axis 1, a sine of 75.66/50 (discarded): closed form, "
        "continuation",
        [0, 0],
        [len(closed_form(outside)), len(found)],
        place="inverse 1)",
        run=(closed_form, found),
    )


def report_wrist_check(report: Report, T: np.ndarray) -> None:
    """The page: 'check with [3,1] and [3,2]; here three of the four q1, q5, q6 are excluded'."""
    full, principal = third_row_errors(T, principal=False), third_row_errors(T, principal=True)
    left = sum(e < 1e-9 for e in full), sum(e < 1e-9 for e in principal)
    reach = len({round(q[0], 6) + 1j * round(q[4], 6) for q in closed_form(T)})
    place = "inverse 1)"
    report.row(
        "(q1, q5, q6) left by the check of [3,1], [3,2]",
        1,
        left[0],
        place=place,
        run=third_row_errors,
        verdict="refuted",
    )
    report.row(
        "the same with q6 by arctan of the quotient",
        1,
        left[1],
        place=place,
        run=third_row_errors,
        verdict="refuted",
    )
    report.row(
        "(q1, q5, q6) left by the reach of the two-link", None, reach, place=place, run=closed_form
    )
    text = (
        f"the check of elements [3,1] and [3,2] does not exclude three of the four (q1, q5, q6): "
        f"{left[0]} pass it with q6 by atan2 "
        f"({left[1]} with q6 by arctan); that {reach} remains follows from the reach of links 2 "
        f"and 3 alone."
    )
    report.erratum(text, shown=left == (4, 2) and reach == 1)


def report_two_link(report: Report, T: np.ndarray) -> None:
    """What the page leaves to the reader: A2 A3 A4, a planar two-link."""
    right, further = symbolic_transform(2, 6), symbolic_transform(3, 6)
    same = all(
        written(a) == written(b)
        for a, b in zip(ca.vertsplit(right.T[2, :].T), ca.vertsplit(further.T[2, :].T), strict=True)
    )
    report.row(
        "'inverting A2, A3 yields nothing useful': third rows of A2 ... A6 and A3 ... A6 are the "
        "same",
        True,
        same,
        place="inverse 2)",
        run=(right, further),
    )
    plane = symbolic_transform(2, 4)
    for i, j in ((1, 4), (2, 4), (1, 1), (2, 1)):
        report.row(
            f"M[{i},{j}], M = B (A5 A6)^-1 = A2 A3 A4",
            None,
            written(plane.T[i - 1, j - 1]),
            place="inverse 2)",
            run=plane,
        )
    M, t234 = middle(
        T, next(w for w in wrists(T) if np.abs(np.array(w) - EXAMPLE[[0, 4, 5]]).max() < 1e-6)
    )
    c3 = (M[0, 3] ** 2 + M[1, 3] ** 2 - A[1] ** 2 - A[2] ** 2) / (2 * A[1] * A[2])
    report.row(
        "c3 = (M[1,4]^2 + M[2,4]^2 - a2^2 - a3^2) / (2 a2 a3) at the example",
        None,
        float(c3),
        place="inverse 2)",
        run=middle,
    )
    first, second = closed_form(T)
    for k, q in enumerate((first, second), start=1):
        values = np.degrees([q[2], wrap(np.array([t234 - q[1] - OFFSET[1]]))[0], q[3], q[1]])
        paper = [15.0, -60.0, 15.0, 15.0] if k == 1 else None
        report.row(
            f"q3, t3 + t4, q4, q2, solution {k}",
            paper,
            values,
            "deg",
            place="inverse 2)",
            run=closed_form,
            tolerance=1e-9,
        )


def report_closed_form(report: Report, T: np.ndarray) -> None:
    solutions = closed_form(T)
    for k, q in enumerate(solutions, start=1):
        report.row(
            f"inverse, closed form, solution {k}",
            THETA if k == 1 else None,
            np.degrees(q),
            "deg",
            place="inverse",
            run=closed_form,
            tolerance=1e-9,
        )
    worst = max(pose_error(q, T) for q in solutions)
    report.row(
        "T of each solution less T (rotations times 400 mm)",
        0,
        worst,
        "mm",
        place="inverse",
        run=forward,
        tolerance=1e-9,
    )


# --- numeric inverse ------------------------------------------------------------------------------


def report_jacobian(report: Report, arm: symkin.Mechanism) -> None:
    jacobian, J = symbolic_jacobian(arm)
    rng = np.random.default_rng(SEED)
    samples = rng.uniform(-np.pi, np.pi, (200, 6))
    away = max(np.abs(np.asarray(jacobian(q)) - difference_jacobian(q)).max() for q in samples)
    ratios = [np.linalg.det(np.asarray(jacobian(q))) / determinant(q) for q in samples]
    place, run = "end", symbolic_jacobian
    report.row(
        "symbolic Jacobian: shape, operations",
        None,
        [*J.shape, jacobian.n_instructions()],
        place=place,
        run=run,
    )
    report.row(
        "symbolic Jacobian less central differences, 200 poses",
        None,
        float(away),
        "mm",
        place=place,
        run=(run, difference_jacobian),
    )
    report.row(
        "det J / (-a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234)): least, most",
        None,
        [min(ratios), max(ratios)],
        place=place,
        run=(run, determinant),
    )
    for name, q in (
        ("q3 = 0 (elbow stretched)", (0.3, 0.4, 0.0, 0.5, 0.6, 0.7)),
        ("zero joints", (0.0,) * 6),
    ):
        rank = int(np.linalg.matrix_rank(np.asarray(jacobian(np.array(q))), tol=1e-9))
        report.row(f"rank of J with {name}", None, rank, place=place, run=run)


def report_from_zero(
    report: Report, arm: symkin.Mechanism, system: Equations, T: np.ndarray
) -> None:
    """The page's ikine begins from zero joints, where the Jacobian has rank 3."""
    zero, place = np.zeros(6), "listing 2"
    for damping in (0.0, 0.1):
        iteration = Iteration(arm, damping)
        q, steps = iteration.solve(T, zero)
        name = f"damping {damping}" if damping else "pseudo-inverse"
        report.row(
            f"ikine, the Jacobian's iteration by {name}, from zero joints",
            THETA,
            np.degrees(q),
            "deg",
            place=place,
            run=iteration,
            tolerance=1e-6,
        )
        report.row(f"ikine by {name}: steps", None, steps, place=place, run=iteration)
    modes = closed_form(T)
    for search in (rootfinder_of_six(system.twelve, system.tangents), least_squares(system.twelve)):
        trial = attempt(search, zero[None], given_numbers(T), modes)
        ended = "no solution" if trial.found[0] is None else f"solution {trial.found[0] + 1}"
        report.row(f"{search.name} from zero joints ends at", None, ended, place=place, run=trial)
    for solver in ("newton", "ipopt"):
        result = symkin.solve(arm, pose=symkin.Pose.from_matrix(T), start=zero, solver=solver)
        report.row(
            f"symkin.solve, {solver}, from zero joints",
            None,
            result.solution.actuated_values,
            "deg",
            place=place,
            run=result,
        )
        noted = next((n for n in result.notes if "singular" in n), "-")
        report.row(
            f"symkin.solve, {solver}, what it says of the start",
            None,
            noted,
            place=place,
            run=result,
        )
    for solver, start in (
        ("newton", [10.0, 10.0, 20.0, 10.0, 20.0, 10.0]),
        ("ipopt", [0.0, 20.0, 0.0, 20.0, 0.0, 0.0]),
    ):
        result = symkin.solve(arm, pose=symkin.Pose.from_matrix(T), solver=solver, start=start)
        report.row(
            f"symkin.solve, {solver}, from {start}",
            None,
            result.solution.actuated_values,
            "deg",
            place=place,
            run=result,
        )
    report.outside(
        "the printed result of ikine", "listing 2", "a picture, missing in the copy at hand"
    )


def report_outside(report: Report) -> None:
    report.outside(
        "what forward and inverse kinematics are used for",
        "introduction",
        "applications, no figures",
    )
    report.outside(
        "algebraic against geometric derivation",
        "inverse",
        "a distinction of words; the algebraic one is computed here",
    )
    report.outside(
        "'numeric iteration may be more convenient'",
        "end",
        "an opinion on effort, not on kinematics",
    )


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--poses", type=int, default=200, help="random poses compared (default: 200)"
    )
    parser.add_argument(
        "--points",
        type=int,
        default=25,
        help="guesses along each side of the picture (default: 25)",
    )
    options = parser.parse_args()
    arm, system = symkin.load("gluon_6l3"), equations()
    report = Report(
        "gluon_6l3", "Gluon-6L3 (tutorial page): forward and inverse kinematics of a 6R arm", SEED
    )
    report_model(report, arm)
    report_symbols(report, arm)
    T = report_example(report, arm)
    trials = casadi_trials(system, T, SEED)
    report_speed(report, arm, system, T, trials[0])
    report_equations(report, arm, system, T)
    report_wrist_check(report, T)
    report_two_link(report, T)
    report_closed_form(report, T)
    report_jacobian(report, arm)
    report_from_zero(report, arm, system, T)
    report_enumeration(report, arm, T, "example", trials)
    eight = next(P for P in random_poses(50, SEED) if len(closed_form(P)) == 8)
    report_enumeration(report, arm, eight, "random pose", casadi_trials(system, eight, SEED))
    counts = report_random(report, arm, options.poses)
    report_outside(report)
    report.finish(
        draw(counts, eight),
        options.output,
        arm=draw_arm(),
        guesses=draw_guesses(system, eight, options.points),
    )


if __name__ == "__main__":
    main()
