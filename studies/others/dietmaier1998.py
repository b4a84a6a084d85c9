"""A Stewart-Gough platform all of whose 40 assembly modes are real, in one picture.

Notation: b_i base points, a_i platform points in the platform frame, L_i leg lengths; a mode is a
pose (p, R) with

    |p + R a_i - b_i| = L_i,   i = 1..6,   R in SO(3).

Six such equations have at most 40 isolated solutions, complex ones counted (Ronga and Vust 1992;
Lazard 1993; Mourrain 1993). Lengths are multiples of L_1. The study finds all, checks them by NumPy
alone, and asks to how many decimals the printed legs are needed for the 40 to stay real. Source of
the numbers: P. Dietmaier, The Stewart-Gough platform of general geometry can have 40 real postures,
Advances in Robot Kinematics: Analysis and Control, Kluwer 1998, 1-10.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import symkin
from symkin import Modes

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, options_parser
from studies.shared.small_multiples import draw_small_multiples
from studies.shared.words import certified, distances, largest_radius, largest_residual, statement

BASE = (
    (0.0, 0.0, 0.0),
    (1.107915, 0.0, 0.0),
    (0.549094, 0.756063, 0.0),
    (0.735077, -0.223935, 0.525991),
    (0.514188, -0.526063, -0.368418),
    (0.590473, 0.094733, -0.205018),
)
PLATFORM = (
    (0.0, 0.0, 0.0),
    (0.542805, 0.0, 0.0),
    (0.956919, -0.528915, 0.0),
    (0.665885, -0.353482, 1.402538),
    (0.478359, 1.158742, 0.107672),
    (-0.137087, -0.235121, 0.353913),
)
LEGS = (1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071)
BOUND = 40


def platform() -> symkin.Mechanism:
    pairs = zip(BASE, PLATFORM, strict=True)
    return symkin.Mechanism(
        "dietmaier1998",
        [symkin.RodLimb(f"leg{i}", b, a) for i, (b, a) in enumerate(pairs, start=1)],
    )


def leg_errors(mode: symkin.Pose) -> np.ndarray:
    """|p + R a_i - b_i| - L_i by NumPy alone."""
    ends = np.asarray(mode.position) + np.array(PLATFORM) @ np.asarray(mode.rotation).T
    return np.asarray(np.linalg.norm(ends - np.array(BASE), axis=1) - LEGS)


def report_modes(report: Report, machine: symkin.Mechanism) -> Modes:
    found = symkin.modes(machine, joints=LEGS)
    report.row("complex solutions", BOUND, found.complex_count)
    report.row("real modes", BOUND, len(found))
    report.row("completeness", None, statement(found))
    report.row("certified modes", None, certified(found))
    report.row("largest radius of a certificate", None, largest_radius(found), "L1")
    report.row("largest residual, of the closure", None, largest_residual(found), "L1")
    report.row(
        "largest leg error, plain arithmetic",
        None,
        max(np.abs(leg_errors(mode.pose)).max() for mode in found),
        "L1",
    )
    size = found.problem.closure.characteristic_length
    report.row(
        "two nearest modes: distance over the size", None, distances(found, size).min() / size
    )
    conditions = [mode.condition for mode in found]
    report.row("condition: best, worst mode", None, [min(conditions), max(conditions)])
    begin = time.perf_counter()
    symkin.modes(machine, joints=LEGS)
    report.row(
        "time of all modes, start kept", None, round(1e3 * (time.perf_counter() - begin), 1), "ms"
    )
    return found


def report_rounded(report: Report, machine: symkin.Mechanism) -> None:
    """The same platform with its legs rounded."""
    for decimals in (5, 4, 3, 2):
        found = symkin.modes(machine, joints=np.round(LEGS, decimals))
        report.row(f"legs rounded to {decimals} decimals: real modes", None, len(found))


def main() -> None:
    options = options_parser(__doc__.split("\n\n")[0]).parse_args()
    machine = platform()
    report = Report("dietmaier1998", "Stewart-Gough platform with 40 real modes (Dietmaier 1998)")
    found = report_modes(report, machine)
    report_rounded(report, machine)
    title = f"Dietmaier's platform: all {len(found)} assembly modes of one set of leg lengths"
    report.finish(draw_small_multiples(found, title, statement(found), columns=8), options.output)


if __name__ == "__main__":
    main()
