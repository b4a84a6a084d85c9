"""Rows on the measuring procedure (1.5): what the wedges are for, the levelling loop on the simulated machine, and its speed.

Source: Ren, Feng, Su 2008, 1.5 and 3 (see `ren2008`); the loop itself is in `ren2008_levelling`.
"""

from __future__ import annotations

import numpy as np

from ren2008_equations import EACH, GROUPS, by_parameters, group_numbers
from ren2008_errors import pose_errors
from ren2008_identification import jacobian, lifts, spectrum
from ren2008_levelling import STARTS, Campaign, Machine, campaign
from ren2008_method import BEST, Fits, fit, inclinations, measure_groups, postures_in_groups, random_postures
from ren2008_model import Case, eta_from
from ren2008_tables import TILT
from report import Report

DRAWS = 15
"""Sets of postures over which condition numbers are taken: their median is told."""
WEDGES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Ranges of the inclinations, deg: +- each."""
REPEATABILITY = np.radians(BEST.inclinometer)


# --- 1.5 ---------------------------------------------------------------------------------------------------------


def condition(case: Case, held: np.ndarray, rng: np.random.Generator) -> tuple[int, float]:
    """Rank and condition number of dC/deta (32 columns) at random postures of inclinations `held`."""
    X = postures_in_groups(case.eta, held, rng)
    found = spectrum(jacobian(by_parameters(case.eta, X)[:, :, case.free], group_numbers(len(held))))
    return found.rank, found.condition


def wedge_conditions(case: Case) -> dict[float, float]:
    """Median condition number of 40 postures against the range of their inclinations [deg]."""
    return {
        wedge: float(
            np.median([condition(case, inclinations(GROUPS, case.rng(41, k)) * wedge / TILT, case.rng(42, k))[1] for k in range(DRAWS)])
        )
        for wedge in WEDGES
    }  # fmt: skip


def report_wedges(report: Report, case: Case, trials: int) -> dict[float, float]:
    """Step (3) of 1.5: what the wedges are for."""
    place, level = "1.5, (3)", np.zeros((GROUPS, 2))
    ranks = [condition(case, level, case.rng(40, k))[0] for k in range(DRAWS)]
    report.row("rank of dC/deta, 40 postures at level, no wedge; of 32", None, max(ranks), place=place, run=condition)
    one = np.tile(np.radians((10.0, 5.0)), (GROUPS, 1))
    report.row(
        "rank, 40 postures on one wedge of 10 and 5 deg", None, condition(case, one, case.rng(43))[0], place=place, run=condition
    )
    both = np.repeat(np.radians(((0.0, 0.0), (10.0, 5.0))), GROUPS // 2, axis=0)
    report.row(
        "rank, 40 postures at level and on one wedge", None, condition(case, both, case.rng(44))[0], place=place, run=condition
    )
    X = postures_in_groups(case.eta, level, case.rng(45))
    moved = jacobian(by_parameters(case.eta, X), group_numbers(GROUPS)) @ lifts(case.eta, np.array([0.0, 0.0, 1.0]))
    report.row("at level: z of M_i and of B_i raised together, six directions: what they change in C, largest", 0,
               float(np.abs(moved).max()), place=place, run=(jacobian, lifts), tolerance=1e-12)  # fmt: skip
    conditions = wedge_conditions(case)
    for wedge, value in conditions.items():
        report.row(
            f"condition number of dC/deta, inclinations within {wedge:g} deg, median",
            None,
            value,
            place=place,
            run=wedge_conditions,
        )
    falling = all(a > b for a, b in zip(list(conditions.values())[:-1], list(conditions.values())[1:], strict=True))
    report.row("'wedges lower the condition number'", True, falling, place=place, run=wedge_conditions)
    worst, fits = {}, {}
    for tilt in (2.0, TILT):
        worst[tilt], fits[tilt] = wedge_errors(case, tilt, trials)
        report.row(f"80 postures within {tilt:g} deg, {BEST}: worst errors, aligned frames, median", None, worst[tilt], "mm, deg",
                   place=place, run=(fits[tilt], pose_errors))  # fmt: skip
    better = bool(np.all(np.array(worst[2.0]) > worst[TILT]))
    report.row("'and so give a better calibration'", True, better, place=place, run=(fits[2.0], fits[TILT]))
    return conditions


def wedge_errors(case: Case, tilt: float, trials: int) -> tuple[list[float], Fits]:
    """Median of the worst errors at unused poses after 80 postures within a range of inclinations [deg]."""
    tests, made, fits = random_postures(case.truth, np.full((100, 2), np.nan), case.rng(46))[0], [], []
    for k in range(trials):
        held = inclinations(20, case.rng(47, k)) * tilt / TILT
        found = fit(case.nominal, measure_groups(case.truth, held, EACH, BEST, case.rng(48, k)), "differences")
        fits.append(found)
        made.append(pose_errors(eta_from(found.values, case.eta), case.truth, case.eta, tests)["aligned"].worst)
    return np.median(made, axis=0).tolist(), Fits(fits)


def report_levelling(report: Report, case: Case, tests: np.ndarray) -> dict[str, Campaign]:
    """Steps (1) to (4): 20 wedges, 4 postures each, levelled by a controller that knows the nominal geometry only."""
    held, place = inclinations(20, case.rng(50)), "1.5"
    plain = campaign(Machine(case.truth, case.eta, REPEATABILITY), held, EACH, BEST, case.rng(51), "plain")
    report.row("levelling, 80 postures on 20 wedges: first reading, median and largest", None,
               np.degrees([np.median(plain.first), plain.first.max()]), "deg", place=place, run=plain)  # fmt: skip
    report.row("alpha, beta of levelled postures: largest difference within a group", None, float(np.degrees(plain.spread)), "deg",
               place=place, run=plain)  # fmt: skip
    found = fit(case.nominal, plain.measured, "differences")
    identified = eta_from(found.values, case.eta)
    errors = pose_errors(identified, case.truth, case.eta, tests)
    for frame, error in errors.items():
        report.row(f"calibrated by the rods of levelled postures: worst errors, {frame} frames", None, error.worst, "mm, deg",
                   place=place, run=(plain, Fits([found])))  # fmt: skip
    campaigns = {}
    for name, model in (("nominal", case.eta), ("identified", identified)):
        for start in STARTS:
            made = campaign(Machine(case.truth, model, REPEATABILITY), held, EACH, BEST, case.rng(51), start)
            campaigns[f"{name}, {start}"] = made
    return campaigns


def report_servo(report: Report, campaigns: dict[str, Campaign]) -> None:
    """The outlook's fast servo adjustment: moves until the inclinometer reads zero."""
    for name, made in campaigns.items():
        model, start = name.split(", ")
        how = "from the wedge's drawing" if start == "plain" else "carrying the last correction"
        report.row(f"levelling with the {model} geometry, {how}: moves for 80 postures, most for one", None,
                   [int(made.moves.sum()), int(made.moves.max())], place="3, outlook", run=made)  # fmt: skip


def report_range(report: Report, campaigns: dict[str, Campaign]) -> None:
    """What range the inclinometer needs: the method's against absolute readings over +-20 deg."""
    plain = campaigns["nominal, plain"]
    first = float(np.degrees(plain.first.max()))
    report.row("largest reading in the loop, inclinations within +-20 deg", None, first, "deg", place="1.1", run=plain)
    report.row("'not limited by the inclinometer's range': a tenth of the inclinations' range is enough", True, first < 0.1 * TILT,
               place="1.1, abstract", run=plain)  # fmt: skip
