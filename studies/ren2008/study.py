"""XJ-HEXAS, a 6-UPS platform: calibration by equal inclination, the whole paper in its order.

Notation: |t + R m_i - b_i| = dl_i + l_i; m_i platform joints, b_i base joints in the paper's joint
frames, dl_i the fixed rod length, l_i the measured extension; R = Rz(gamma) Ry(beta) Rx(alpha),
turns about fixed axes ('xyz'). Units: m, deg. Source: Ren, Feng, Su, Journal of Xi'an Jiaotong
University 42(12), 2008, 1445-1449; tables 1 (nominal), 2 (true), 3.

Two true values are illegible in our copy and assumed; the workspace is not printed and is assumed
(`model`). Errors stand in named frames (`errors`): the paper does not say which are its own.

Parts: `model` (printed data, closure, direct and inverse problem), `identification` ((4) to (6),
(8)), `method` (experiments), `errors` (frames, errors before calibration), `procedure` (1.5); rows:
`equations`, `direct`, `noise`; `pictures`; `planning` (chosen postures, a study of its own too).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import symkin
from symkin.calibration.data.measurements import Measurements
from symkin.calibration.judge.identifiability import identifiability

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.ren2008.direct import report_direct
from studies.ren2008.equations import (
    report_causes,
    report_estimator,
    report_identifiable,
    report_machine,
    report_tables,
)
from studies.ren2008.errors import report_assumed, report_before
from studies.ren2008.identification import spectrum
from studies.ren2008.method import unused_poses
from studies.ren2008.model import Case
from studies.ren2008.noise import (
    ACCURACIES,
    FIGURE_3,
    PRECISIONS,
    absolute_series,
    noisy_series,
    report_estimators,
    report_exact,
    report_figure_2,
    report_figure_3,
    report_frames,
)
from studies.ren2008.pictures import (
    draw_before,
    draw_calibration,
    draw_figure_1,
    draw_guesses,
    draw_procedure,
)
from studies.ren2008.planning import report_24
from studies.ren2008.procedure import (
    condition,
    report_levelling,
    report_range,
    report_servo,
    report_wedges,
)
from studies.shared.report import Report, options_parser

SEED = 8
SUITS_GROUPS, SUITS_EACH = 10, 4


def report_introduction(report: Report) -> None:
    report.outside(
        "external calibration and self-calibration, references [1] to [9]",
        "introduction",
        "a survey of literature, no figures",
    )
    report.outside(
        "commercial inclinometers: the finer, the smaller their range",
        "1.1",
        "a statement about instruments; no data are given",
    )


def report_drawn(report: Report) -> None:
    report.row(
        "figure 1, drawn with {M1} and {B1}",
        None,
        "ren2008_figure1.png",
        place="figure 1",
        run=draw_figure_1,
    )
    report.row(
        "figures 2 and 3, drawn",
        None,
        "ren2008_calibration.png",
        place="figures 2, 3",
        run=draw_calibration,
    )
    report.outside(
        "the curves of figures 2 and 3",
        "figures 2, 3",
        "not in our copy; what the text says of them is compared above",
    )


# --- "suits every parallel machine" (3) -----------------------------------------------------------


def another_platform(name: str, rng: np.random.Generator) -> Measurements:
    """Readings of groups of equal inclination on another platform on six rods, in its own
    workspace.
    """
    machine = symkin.load(name)
    inclined = np.repeat(np.radians(rng.uniform(-15, 15, (SUITS_GROUPS, 2))), SUITS_EACH, axis=0)
    places = (
        machine.reference_pose.position
        + rng.uniform(-0.15, 0.15, (len(inclined), 3)) * machine.characteristic_length
    )
    poses = [
        symkin.Pose.from_euler(place, np.array([*pair, rng.uniform(-0.3, 0.3)]), "xyz")
        for place, pair in zip(
            places + [0, 0, 0.5 * machine.characteristic_length], inclined, strict=True
        )
    ]
    lengths = np.array(
        [symkin.solve(machine, pose=pose).solution.actuated_values for pose in poses]
    )
    starts = np.array([[*pose.position, *pose.quaternion] for pose in poses])
    return Measurements(
        lengths, groups=np.repeat(np.arange(SUITS_GROUPS), SUITS_EACH), starts=starts
    )


def report_suits(report: Report, case: Case) -> None:
    """The method needs a platform that can tilt: one inclination alone does not tell all
    parameters.
    """
    place, name = "3", "zhang2009"
    found = identifiability(symkin.load(name), another_platform(name, case.rng(80)))
    report.row(
        "another platform on six rods (zhang2009): rank",
        32,
        found.rank,
        place=place,
        run=(another_platform, identifiability),
    )
    twists = symkin.mobility(symkin.load("zhao2000")).platform_twists
    tilts = spectrum(twists[:, :2]).rank if np.abs(twists[:, :2]).max() > 1e-9 else 0
    report.row(
        "'suits every parallel machine': freedoms that tilt the platform of zhao2000",
        None,
        tilts,
        place=place,
        run=symkin.mobility,
        verdict="refuted",
    )
    level, _ = condition(case, np.zeros((10, 2)), case.rng(40, 0))
    text = (
        "the method does not suit every parallel machine, and wedges do more than lower the "
        "condition number: with one inclination "
        f"alone the identification Jacobian has rank {level} of 32, because M_i and B_i may be "
        f"raised together, and a platform that "
        f"keeps its inclination (zhao2000: {tilts} of its freedoms tilt it) has no second one."
    )
    report.erratum(text, shown=level == 27 and tilts == 0)


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0])
    parser.add_argument(
        "--trials", type=int, default=9, help="experiments of each kind (default: 9)"
    )
    parser.add_argument(
        "--points",
        type=int,
        default=31,
        help="guesses along each side of the picture (default: 31)",
    )
    options = parser.parse_args()
    trials, case = options.trials, Case(symkin.load("ren2008"), symkin.load("ren2008_true"), SEED)
    tests = unused_poses(case.truth, SEED)
    report = Report(
        "ren2008",
        "XJ-HEXAS (Ren 2008): calibration of a Stewart platform by equal inclination",
        SEED,
    )
    report_introduction(report)
    report_machine(report, case)
    report_identifiable(report, case)
    modes = report_direct(report, case)
    paper_way = report_estimator(report, case)
    report_estimators(report, case)
    sizes = report_causes(report, case)
    conditions = report_wedges(report, case, trials)
    campaigns = report_levelling(report, case, tests)
    report_range(report, campaigns)
    report_tables(report, case)
    report_assumed(report, case)
    errors, before = report_before(report, case, tests)
    report_exact(report, case, paper_way, trials)
    noisy = {precision: noisy_series(case, precision, tests, trials) for precision in PRECISIONS}
    report_figure_2(report, noisy)
    absolute = {
        premise: absolute_series(case, accuracy, tests, trials)
        for premise, accuracy in ACCURACIES.items()
    }
    report_figure_3(report, noisy[FIGURE_3], absolute)
    report_drawn(report)
    report_24(report, case, tests, trials)
    report_servo(report, campaigns)
    report_suits(report, case)
    report_frames(report, before, noisy)
    report.finish(
        draw_before(errors, tests),
        options.output,
        figure1=draw_figure_1(case),
        guesses=draw_guesses(case, modes, options.points),
        calibration=draw_calibration(noisy, absolute),
        procedure=draw_procedure(campaigns, conditions, sizes),
    )


if __name__ == "__main__":
    main()
