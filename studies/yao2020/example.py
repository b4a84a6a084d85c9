"""Rows of sections 2.2.2 and 3.2: the return of the axes, the worked inverse example, all its
solutions by every route.

Units: mm, deg. Source: Yao Haifeng et al. 2020 (see `study`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

import symkin
from studies.shared.guesses import attempt, least_squares, report_trials, rootfinder
from studies.shared.report import Report
from studies.shared.words import statement
from studies.yao2020.inverse import (
    TOLERANCE,
    angle_of_planes,
    axis5_origin,
    distance_function,
    inside,
    inverse,
    plane_closure,
    point_closure,
    returned,
    sequence,
    slides,
    square_closure,
    third_angles,
    three_points,
)
from studies.yao2020.model import (
    A1,
    A2,
    D1,
    FORWARD,
    PRINTED,
    PRINTED_POINTS,
    SEED,
    TIP,
    apart,
    goal_rotation,
    orders_off,
    placed,
    pose_of,
    random_joints,
    same,
    symkin_pose,
    tool_points,
)

FORMULAS = {
    1: "arctan2(-Fy, -Fx)",
    2: "arctan2(Fz, -Fx)",
    3: "arctan2((C - A)z, (C - A)y)",
    4: "arctan2((E - F)z, -(E - F)x)",
}
POSES = 200
"""Poses at which (11) is tried."""
SETS = 25
"""Poses over which sets of solutions are compared."""
GUESSES = 100
"""Guesses of each solver."""


# --- section 2.2.2 --------------------------------------------------------------------------------


def report_return(report: Report) -> None:
    A, R, q = TIP, goal_rotation(), inverse(TIP, goal_rotation())[0]
    for joint, value, points in sequence(A, R, float(q[5])):
        label = "joints 6, 5" + "".join(f", {k}" for k in range(1, joint)) + " at zero"
        for name in "AF":
            report.row(
                f"{label}: {name}",
                None,
                points[name].round(9) + 0.0,
                "mm",
                place="2.2.2, fig. 6",
                run=sequence,
            )
        place = f"2.2.2, ({8 + joint}); 3.2"
        report.row(
            f"theta{joint} = {FORMULAS[joint]}",
            PRINTED[joint - 1],
            value,
            "deg",
            place=place,
            run=sequence,
        )
    report_third_angle(report, q)


def report_third_angle(report: Report, q: np.ndarray) -> None:
    """(11), the only formula of this section that the copy at hand has."""
    third, row = third_angles(q), partial(report.row, place="2.2.2, (11)", run=third_angles)
    printed = [third["(z, y)"], third["(y, z)"]]
    row(
        "(11) as printed, arctan2(D4z, D4y), read as (y, x) and as (x, y)",
        PRINTED[2],
        printed,
        "deg",
        verdict="refuted",
    )
    row("arctan2(-D4y, D4z), read as (y, x)", PRINTED[2], third["(-y, z)"], "deg")
    wrong = [
        sum(apart(third_angles(j)[key], j[2]) > 1e-6 for j in random_joints(POSES))
        for key in ("(-y, z)", "C - A")
    ]
    row(
        f"over {POSES} poses: wrong by arctan2(-D4y, D4z), by arctan2((C - A)z, (C - A)y)",
        None,
        wrong,
    )
    bound = math.degrees(math.atan2(D1, A2))
    text = (
        f"equation (11) as it stands in our copy gives {printed[0]:.3f} or {printed[1]:.3f}, not "
        f"theta3; arctan2(-D4y, D4z) gives "
        f"{third['(-y, z)']:.3f}, but half a turn off where a2 sin(theta4) + d1 cos(theta4) < 0 "
        f"(theta4 outside -{bound:.1f} to "
        f"{180 - bound:.1f}): at {wrong[0]} of {POSES} poses. With C - A in place of D4 the "
        f"printed form is right at all of them."
    )
    right = min(abs(p - q[2]) for p in printed) > 1 and abs(third["(-y, z)"] - q[2]) < 1e-6
    report.erratum(text, shown=right and wrong[0] > 0 == wrong[1])


# --- section 3.2: the printed example -------------------------------------------------------------


def report_printed_points(report: Report) -> None:
    """The pose, D0, E0, F0 as printed and computed, and a2, a3, d1 from them."""
    row, R = partial(report.row, place="3.2"), goal_rotation()
    row("pose matrix Rz(25) Ry(-15) Rx(20), row by row", None, R.ravel(), run=goal_rotation)
    label = (
        "six orders of the turns: largest difference of A0 D0, D0 E0, E0 F0 from the rotation's x, "
        "-z, x"
    )
    row(
        label,
        None,
        "; ".join(f"{order} {off:.1e}" for order, off in orders_off().items()),
        run=orders_off,
    )
    chain = [TIP, *(np.array(PRINTED_POINTS[name]) for name in "DEF")]
    lengths = [math.dist(chain[k], chain[k + 1]) for k in range(3)]
    row("a3, d1, a2 from the printed A, D0, E0, F0", None, lengths, "mm", run=math.dist)
    for name, printed in PRINTED_POINTS.items():
        row(f"{name}0", printed, tool_points(TIP, R)[name], "mm", run=tool_points)


def printed_reach() -> float:
    """a1 from the printed answer, least squares over A."""
    at = placed(PRINTED)
    return A1 + float(at["F"] / A1 @ (TIP - at["A"]))


def rounding_of_slide() -> float:
    """Most that A's four decimals can move the first root L6."""
    R, h = goal_rotation(), 1e-3
    moved = [max(slides(TIP + h * k, R)) - max(slides(TIP - h * k, R)) for k in np.eye(3)]
    return 5e-5 * float(np.abs(np.array(moved) / (2 * h)).sum())


def report_printed_answer(report: Report) -> None:
    A, R, row = TIP, goal_rotation(), partial(report.row, place="3.2")
    a1, root, left = printed_reach(), max(slides(A, R)), distance_function(A, R)(PRINTED[5])
    miss = float(np.linalg.norm(placed(PRINTED)["A"] - A))
    row("a1 from the printed answer and A", None, a1, "mm", run=printed_reach)
    row(
        "return of the axes from the printed L6",
        PRINTED,
        returned(A, R, PRINTED[5], 1),
        "deg, mm",
        run=returned,
    )
    report.row(
        "|OF| - a1 at the printed L6",
        TOLERANCE,
        left,
        "mm",
        place="2.2.1, 4 (4)",
        run=distance_function,
        verdict="refuted",
    )
    row("A missed by the printed answer, 'extremely precise'", None, miss, "mm", run=placed)
    rounding, other = rounding_of_slide(), max(slides(A, R, a1=a1)) - root
    row(
        "L6 moved by A's rounding, by a1 of the printed answer",
        None,
        [rounding, other],
        "mm",
        run=(rounding_of_slide, slides),
    )
    text = (
        f"the claimed 1e-8 was not met: the printed answer leaves |OF| - a1 = {left:.1e} mm and "
        f"misses A by {miss:.3f} mm; its L6 is "
        f"off by {PRINTED[5] - root:.4f} mm, while A's rounding moves L6 by at most {rounding:.0e} "
        f"mm and a1 = {a1:.3f} by {other:.4f} mm."
    )
    report.erratum(
        text,
        shown=left > 1e5 * TOLERANCE
        and miss > 0.01
        and abs(PRINTED[5] - root) > 2 * (rounding + abs(other)),
    )
    text = (
        "the example cites equations (12) and (15) for theta1 to theta4; they are (9) to (12), and "
        "there is no (15)."
    )
    report.erratum(text, shown=[joint for joint, _, _ in sequence(A, R, root)] == [1, 2, 3, 4])


# --- section 3.2: all solutions -------------------------------------------------------------------


def matches(one: Sequence[Sequence[float]], other: Sequence[Sequence[float]]) -> bool:
    """The same sets of joint values."""
    return len(one) == len(other) and all(any(same(a, b) for b in other) for a in one)


def report_solutions(report: Report, arm: symkin.Mechanism) -> list[np.ndarray]:
    row, pose = partial(report.row, place="3.2"), symkin_pose(TIP, goal_rotation())
    solutions = inverse(TIP, goal_rotation())
    for k, q in enumerate(solutions, start=1):
        row(
            f"inverse, solution {k}: theta1..5, L6",
            PRINTED if k == 1 else None,
            q,
            "deg, mm",
            run=inverse,
        )
    found = symkin.modes(arm, pose=pose, method="continuation")
    row(
        "solutions by return of the axes, by continuation",
        None,
        [len(solutions), len(found)],
        run=(inverse, found),
    )
    row("completeness", None, statement(found), run=found)
    row(
        "continuation: the same solutions to 1e-6",
        None,
        str(matches([m.actuated for m in found], solutions)),
        run=(found, inverse),
    )
    near = symkin.solve(arm, pose=pose, start=list(PRINTED))
    row(
        "symkin.solve from the printed answer",
        PRINTED,
        near.solution.actuated_values,
        "deg, mm",
        run=near,
    )
    for solver in ("newton", "ipopt"):
        far = symkin.solve(arm, pose=pose, start=[0.0] * 6, solver=solver)
        reached = [
            k
            for k, q in enumerate(solutions, start=1)
            if far.solution is not None and same(far.solution.actuated_values, q)
        ]
        row(
            f"symkin.solve by {solver} from zero joints: status; solution reached",
            None,
            [far.status, *reached],
            run=far,
        )
    return solutions


def report_random(report: Report, arm: symkin.Mechanism) -> None:
    """Sets of solutions over random poses: closed form, continuation, multistart; and what (6) as
    told can reach of them.
    """
    row, goals = (
        partial(report.row, place="3.2"),
        [pose_of(joints) for joints in random_joints(SETS)],
    )
    exact = [inverse(A, R) for A, R in goals]
    poses, total = [symkin_pose(A, R) for A, R in goals], sum(len(e) for e in exact)
    sizes = [len(e) for e in exact]
    row(
        "random poses with 4, with 8 solutions", None, [sizes.count(4), sizes.count(8)], run=inverse
    )
    found = [symkin.modes(arm, pose=pose, method="continuation") for pose in poses]
    row(
        f"random poses, of {SETS}: continuation = return of the axes",
        None,
        sets_equal(found, exact),
        run=(found, inverse),
    )
    for starts in (20, 200):
        found = [
            symkin.modes(arm, pose=pose, method="multistart", starts=starts, seed=SEED)
            for pose in poses
        ]
        label = (
            f"random poses, of {SETS}: multistart, {starts} starts = return of the axes; solutions "
            f"missed, of {total}"
        )
        row(
            label,
            None,
            [sets_equal(found, exact), total - sum(len(f) for f in found)],
            run=(found, inverse),
        )
    told = sum(
        abs(angle_of_planes(A, R, q[5]) - q[4]) < 1e-6
        for (A, R), e in zip(goals, exact, strict=True)
        for q in e
    )
    row(
        f"random poses: solutions whose theta5 (6) as told gives, of {total}",
        None,
        told,
        run=(inverse, angle_of_planes),
    )


def sets_equal(found, exact: list[list[np.ndarray]]) -> int:
    """How many lists of modes are the exact ones."""
    return sum(matches([m.actuated for m in f], e) for f, e in zip(found, exact, strict=True))


def report_guesses(report: Report, arm: symkin.Mechanism, solutions: list[np.ndarray]) -> None:
    """The inverse problem from varied guesses: CasADi's solvers on (5) to (8) and on (3), and
    symkin's multistart.
    """
    A, R, rng = TIP, goal_rotation(), np.random.default_rng(SEED)
    slide, turns = rng.uniform(-600, 100, GUESSES), rng.uniform(-math.pi, math.pi, (GUESSES, 5))
    two, modes = plane_closure(), [np.array([q[5], math.radians(q[4])]) for q in solutions[::2]]
    guesses = np.column_stack([slide, turns[:, 4]])
    trials = [
        attempt(search(two), guesses, axis5_origin(A, R), modes)
        for search in (rootfinder, least_squares)
    ]
    report_trials(report, "inverse, (5)-(8) in L6, theta5 (two solutions each)", "2.2.1", trials)
    six, guesses = [inside(q) for q in solutions], np.column_stack([turns, slide])
    searches = (rootfinder(square_closure()), least_squares(point_closure()))
    trials = [attempt(search, guesses, three_points(A, R), six) for search in searches]
    report_trials(report, "inverse, (3) in six joints", "2.1, 3.2", trials)
    for solver in ("batched", "newton", "ipopt"):
        found = symkin.modes(
            arm,
            pose=symkin_pose(A, R),
            method="multistart",
            solver=solver,
            starts=GUESSES,
            seed=SEED,
        )
        name, missed = f"inverse, symkin.modes by multistart, {solver}", len(solutions) - len(found)
        report.row(
            f"{name}: solutions met, missed", None, [len(found), missed], place="3.2", run=found
        )
        report.row(
            f"{name}: hits per solution", None, [m.hits for m in found], place="3.2", run=found
        )
    found = symkin.modes(arm, joints=list(FORWARD))
    report.row(
        "direct problem: poses (a formula, nothing to enumerate)",
        1,
        len(found),
        place="2.1",
        run=found,
    )
