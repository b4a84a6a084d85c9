"""Wrist-offset telescopic Pieper robot, 5R1P: the paper line by line, its search for L6, the return of the axes, all roots.

    yao2020_model       sections 1 and 2.1: axes, points, equations (1) to (3), pose by three points
    yao2020_inverse     section 2.2: planes, search, return of the axes, closed form, closures
    yao2020_iterations  steps and times of the ways to L6 over many poses
    yao2020_holes       section 3.3: reach of the wrist, 86 holes by `track`, joint errors; with its rows
    yao2020_frame, yao2020_search, yao2020_example      rows of the other sections
    yao2020_parts, yao2020_sketches, yao2020_pictures   drawings

Units: mm, deg. Source: Yao Haifeng et al., Journal of Mining Science and Technology 5(6), 2020. Its displayed formulas but (11)
are missing in the copy at hand; (1) to (10) and (12) are written from the text around them, and none of its lengths is printed.
"""

from __future__ import annotations

import symkin
from report import Report, options_parser
from yao2020_example import (
    report_guesses,
    report_printed_answer,
    report_printed_points,
    report_random,
    report_return,
    report_solutions,
)
from yao2020_frame import report_forward_example, report_frame
from yao2020_holes import report_application
from yao2020_model import SEED
from yao2020_pictures import draw, draw_guesses, draw_holes
from yao2020_search import report_closed_form, report_search, report_ways
from yao2020_sketches import draw_frames, draw_planes, draw_return

TITLE = "Wrist-offset telescopic Pieper robot (Yao 2020): the global frame and the return of the axes"


def report_outside(report: Report) -> None:
    report.outside("closed inverses exist for Pieper's and Duffy's arms only", "0, [5]", "cited, not shown in the paper")
    report.outside("loads and stiffness of wrists with offsets", "0, 4 (1)", "statics, no figures")
    report.outside("other methods take long and are imprecise", "0, [14]-[19], 4 (5)", "a survey of literature, no figures")
    reason = "computer and language are not named; our times differ from run to run and stand in the JSON only"
    report.outside("times of 8 and 10 ms", "3.2, 4 (4)", reason)


def main() -> None:
    parser = options_parser(__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=41, help="guesses along each side of the picture (default: 41)")
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
        draw(solutions), options.output, frames=draw_frames(), planes=draw_planes(), returns=draw_return(),
        guesses=draw_guesses(solutions, options.points), holes=draw_holes(arm, track),
    )  # fmt: skip


if __name__ == "__main__":
    main()
