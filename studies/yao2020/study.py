"""Wrist-offset telescopic Pieper robot, 5R1P: the paper line by line, its search for L6, the return
of the axes, all roots.

    model      sections 1 and 2.1: axes, points, equations (1) to (3), pose by three points
    inverse    section 2.2: planes, search, return of the axes, closed form, closures
    search     section 2.2.1 and conclusions: steps and times of the ways to L6 over many poses,
               with their rows
    example    sections 2.2.2 and 3.2: rows of the worked example
    holes      section 3.3: reach of the wrist, 86 holes by `track`, joint errors; with its rows
    pictures, sketches   drawings
    study      rows of sections 1, 2.1 and 3.1

Units: mm, deg. Source: Yao Haifeng et al., Journal of Mining Science and Technology 5(6), 2020. Its
displayed formulas but (11) are missing in the copy at hand; (1) to (10) and (12) are written from
the text around them, and none of its lengths is printed.
"""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path

import numpy as np

import symkin

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, options_parser
from studies.shared.words import written
from studies.yao2020.example import (
    report_guesses,
    report_printed_answer,
    report_printed_points,
    report_random,
    report_return,
    report_solutions,
)
from studies.yao2020.holes import report_application
from studies.yao2020.inverse import inverse
from studies.yao2020.model import (
    A1,
    A2,
    A3,
    D1,
    FORWARD,
    SEED,
    ZERO,
    Line,
    T,
    about,
    along,
    axis_lines,
    concurrency,
    drawn_axes,
    forward,
    forward_steps,
    line_distance,
    placed,
    random_joints,
    rotation_of,
    spherical_wrists,
)
from studies.yao2020.pictures import draw, draw_guesses, draw_holes
from studies.yao2020.search import report_closed_form, report_search, report_ways
from studies.yao2020.sketches import draw_frames, draw_planes, draw_return

TINY = 1e-9
"""Allowed for what is zero by geometry, mm or deg."""


def report_frame(report: Report, arm: symkin.Mechanism) -> None:
    """Sections 1 and 2.1, and the points of 2.2.1."""
    report_concurrency(report)
    report_axes(report, arm)
    report_motions(report)
    report_forward(report, arm)
    report_key_points(report)


def report_concurrency(report: Report) -> None:
    for name, other in spherical_wrists().items():
        gap = concurrency(drawn_axes(other)[3:])
        report.row(
            f"{name}: largest distance of axes 4, 5, 6",
            0,
            gap,
            "m",
            place="1, fig. 1",
            run=spherical_wrists,
            tolerance=1e-12,
        )
    row, here = partial(report.row, unit="mm", run=axis_lines), axis_lines(FORWARD)
    gap = concurrency(here[:3])
    row("axes 1, 2, 3 meet: largest distance", 0, gap, place="1, fig. 2; 4 (2)", tolerance=TINY)
    gaps = [round(line_distance(here[i], here[j]), 9) for i, j in ((3, 4), (3, 5), (4, 5))]
    row(
        "axes 4, 5, 6: distances 4-5, 4-6, 5-6",
        "skew in pairs",
        gaps,
        place="1, fig. 2",
        verdict="differs",
    )
    text = (
        "axes 4, 5 and 6 are not skew in pairs: axes 5 and 6 meet in D, as section 2.2.1 says "
        "itself."
    )
    report.erratum(text, shown=gaps[2] < TINY and min(gaps[:2]) > 1)


def report_axes(report: Report, arm: symkin.Mechanism) -> None:
    row = partial(report.row, unit="mm", place="1.1, fig. 3", tolerance=TINY)
    off = max(
        line_difference(a, b) for a, b in zip(drawn_axes(arm), axis_lines([0] * 6), strict=True)
    )
    row(
        "the six axes from point to point, less the mechanism file's",
        0,
        off,
        run=(axis_lines, symkin.load),
    )
    for label, joints, paper in (
        ("initial position", [0] * 6, [0, 0, 0]),
        ("forward example", FORWARD, None),
    ):
        lines = axis_lines(joints)
        less = [
            round(line_distance(lines[i], lines[j]) - d, 9)
            for i, j, d in ((1, 3, A1), (3, 4, A2), (2, 5, D1))
        ]
        row(
            f"{label}: distances of axes 2-4, 4-5, 3-6 less a1, a2, d1", paper, less, run=axis_lines
        )


def line_difference(one: Line, other: Line) -> float:
    """Distance of two lines, or the difference of their directions where that is larger."""
    return max(line_distance(one, other), float(np.abs(one[1] - other[1]).max()))


def report_motions(report: Report) -> None:
    """(1) and (2) on a point and a line whose answers are read off at once."""
    point, start, end = (
        np.array([1.0, 2.0, 3.0]),
        np.array([1.0, 0.0, 0.0]),
        np.array([1.0, 0.0, 5.0]),
    )
    line = "the line from (1, 0, 0) to (1, 0, 5)"
    report.row(
        f"(1): (1, 2, 3) moved by 4 along {line}",
        None,
        along(point, start, end, 4.0),
        "mm",
        place="1.2, (1)",
        run=along,
    )
    report.row(
        f"(2): (1, 2, 3) turned by 90 deg about {line}",
        None,
        about(point, start, end, 90.0).round(12),
        "mm",
        place="1.2, (2)",
        run=about,
    )


def report_forward(report: Report, arm: symkin.Mechanism) -> None:
    for name, step in forward_steps():
        text = "; ".join(written(step[i]) for i in range(3))
        report.row(f"(3): {name} =", None, text, "mm", place="2.1, (3)", run=forward_steps)
    off, lengths = [], []
    for joints in random_joints(100):
        at, pose = placed(joints), symkin.solve(arm, joints=list(joints)).solution
        R = rotation_of(at["A"], at["B"], at["C"])
        off.append([np.abs(at["A"] - pose.position).max(), np.abs(R - pose.rotation).max()])
        lengths.append([np.linalg.norm(p) for p in (at["F"], at["E"] - at["F"], at["D"] - at["E"])])
    label = "(3) at 100 random joint values, pose by A, B, C, less symkin's: position, rotation"
    report.row(
        label,
        [0, 0],
        np.max(off, axis=0),
        "mm, 1",
        place="2.1, (3)",
        run=(forward, rotation_of, symkin.solve),
        tolerance=TINY,
    )
    most, place = np.abs(np.array(lengths) - [A1, A2, D1]).max(axis=0), "2.2.1, fig. 4; 4 (3)"
    report.row(
        "there: |OF|, |EF|, |DE| less a1, a2, d1, largest",
        [0, 0, 0],
        most,
        "mm",
        place=place,
        run=placed,
        tolerance=TINY,
    )


def report_key_points(report: Report) -> None:
    row, at, lines = (
        partial(report.row, unit="mm", place="2.2.1, fig. 4"),
        placed(FORWARD),
        axis_lines(FORWARD),
    )
    row("|AD| less a3, initial position", 0, math.dist(ZERO["A"], ZERO["D"]) - A3, run=placed)
    for name, pair in (("D", (5, 6)), ("F", (3, 4)), ("E", (3, 5))):
        gaps = [round(point_distance(at[name], lines[k - 1]), 9) for k in pair]
        label = (
            f"forward example: {name}, where axes {pair[0]} and {pair[1]} are said to meet; its "
            f"distances from them"
        )
        row(label, [0, 0], gaps, run=(placed, axis_lines), tolerance=TINY)
    text = (
        f"E lies on axis 3 only where theta4 = 0: in the forward example it is {gaps[0]:.1f} mm = "
        f"a2 |sin(theta4)| off."
    )
    report.erratum(text, shown=abs(gaps[0] - A2 * abs(math.sin(math.radians(FORWARD[3])))) < 1e-6)


def point_distance(point: np.ndarray, line: Line) -> float:
    return float(np.linalg.norm(np.cross(point - line[0], line[1])))


def report_forward_example(report: Report, arm: symkin.Mechanism) -> None:
    """Section 3.1, whose numbers are missing in the copy at hand."""
    at, mode, here = (
        placed(FORWARD),
        symkin.solve(arm, joints=list(FORWARD)),
        "at (5, -10, 15, -20, 25 deg, 30 mm)",
    )
    for name in "ABC":
        report.row(
            f"forward, {name} {here}, t = {T:g}",
            None,
            at[name],
            "mm",
            place="3.1, (3), fig. 7",
            run=forward,
        )
    report.row("A by symkin", None, mode.solution.position, "mm", place="3.1, fig. 7", run=mode)
    R = rotation_of(at["A"], at["B"], at["C"])
    off = np.abs(R - mode.solution.rotation).max()
    report.row(
        "rotation by A, B, C less symkin's",
        0,
        off,
        place="2.1, 3.1",
        run=(rotation_of, mode),
        tolerance=1e-12,
    )
    others = []
    for t in (1.0, 1000.0):
        points = [forward(ZERO["A"] + t * (ZERO[n] - ZERO["A"]) / T, FORWARD) for n in "ABC"]
        others.append(np.abs(rotation_of(*points) - R).max())
    report.row(
        "the same with t = 1, t = 1000 ('any t')",
        [0, 0],
        others,
        place="2.1",
        run=(forward, rotation_of),
        tolerance=1e-12,
    )
    back = min(np.abs(q - FORWARD).max() for q in inverse(at["A"], R))
    label = "the pose by A, B, C taken back: nearest inverse solution less the joint values"
    report.row(label, 0, back, "deg, mm", place="3.1", run=(rotation_of, inverse), tolerance=TINY)


# --- the whole paper ------------------------------------------------------------------------------

TITLE = (
    "Wrist-offset telescopic Pieper robot (Yao 2020): the global frame and the return of the axes"
)


def report_outside(report: Report) -> None:
    report.outside(
        "closed inverses exist for Pieper's and Duffy's arms only",
        "0, [5]",
        "cited, not shown in the paper",
    )
    report.outside("loads and stiffness of wrists with offsets", "0, 4 (1)", "statics, no figures")
    report.outside(
        "other methods take long and are imprecise",
        "0, [14]-[19], 4 (5)",
        "a survey of literature, no figures",
    )
    reason = (
        "computer and language are not named; our times differ from run to run and stand in the "
        "JSON only"
    )
    report.outside("times of 8 and 10 ms", "3.2, 4 (4)", reason)


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--points",
        type=int,
        default=41,
        help="guesses along each side of the picture (default: 41)",
    )
    options = parser.parse_args()
    arm, report = symkin.load("yao2020"), Report("yao2020", TITLE, SEED)
    report_frame(report, arm)
    report_search(report)
    report_return(report)
    report_forward_example(report, arm)
    report_printed_points(report)
    report_printed_answer(report)
    solutions = report_solutions(report, arm)
    report_random(report, arm)
    report_guesses(report, arm, solutions)
    track = report_application(report, arm)
    report_ways(report)
    report_closed_form(report)
    report_outside(report)
    report.finish(
        draw(solutions),
        options.output,
        frames=draw_frames(),
        planes=draw_planes(),
        returns=draw_return(),
        guesses=draw_guesses(solutions, options.points),
        holes=draw_holes(arm, track),
    )


if __name__ == "__main__":
    main()
