"""The measuring procedure of 1.5 on a simulated machine: wedge, biaxial inclinometer, levelling
loop; and the rows on it.

The machine has the true geometry, its controller the nominal one. A wedge W turns the inclinometer
on the platform; with n = W^T R^T e_z the vertical as the inclinometer sees it, its readings are
(alpha, beta) of n = (-sin beta, cos beta sin alpha, cos beta cos alpha), wrong by as much as it
repeats. One move of a loop:

    command a pose -> the rods of the nominal inverse problem -> the true pose -> readings r (alpha,
    beta) of the command less J^-1 r, J = d readings / d (alpha, beta) by the controller's model

until both readings are within the tolerance; then the rods are read. How the loop begins is the
remark on fast servo adjustment of the paper's outlook:

    plain       at the wedge's nominal inclination
    carried     at that less the correction that the last posture of the group needed
    identified  plain, with the identified geometry in the controller

Rows: what the wedges are for, the loop on the simulated machine, and its speed. Units: m, rad.
Source: Ren, Feng, Su 2008, 1.5 and 3 (see `study`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.ren2008.equations import EACH, GROUPS, by_parameters, group_numbers
from studies.ren2008.errors import pose_errors
from studies.ren2008.identification import jacobian, lifts, spectrum
from studies.ren2008.method import (
    BEST,
    Fits,
    Precision,
    centres_of,
    fit,
    inclinations,
    measure_groups,
    posture_at,
    postures_in_groups,
    random_postures,
    readings,
)
from studies.ren2008.model import TILT, Case, direct, eta_from, inverse, turn
from studies.shared.report import Report
from symkin.calibration.data.measurements import Measurements

MOST = 20
STARTS = ("plain", "carried")
WEDGE_ERROR = np.radians(0.2)
"""How far a wedge is from its drawing, each way: nobody measures it."""


def level_turn(inclination: np.ndarray) -> np.ndarray:
    """The wedge under which a platform at (alpha, beta) holds the inclinometer level: W = (Ry(beta)
    Rx(alpha))^T.
    """
    return turn(np.array([[inclination[0], inclination[1], 0.0]]))[0].T


def read(angles: np.ndarray, wedge: np.ndarray) -> np.ndarray:
    """Readings (alpha, beta) of an inclinometer on a wedge, platform at angles (3,)."""
    n = wedge.T @ turn(angles[None])[0].T[:, 2]
    return np.array([np.arctan2(n[1], n[2]), np.arctan2(-n[0], np.hypot(n[1], n[2]))])


@dataclass(frozen=True, eq=False)
class Loop:
    """One posture: the readings of each move, the last commanded posture and the true one."""

    readings: np.ndarray
    command: np.ndarray
    truth: np.ndarray

    @property
    def moves(self) -> int:
        return len(self.readings)


@dataclass(frozen=True, eq=False)
class Machine:
    """True and controller's parameters, and how far readings repeat [rad]."""

    truth: np.ndarray
    model: np.ndarray
    repeatability: float

    def level(
        self, command: np.ndarray, wedge: np.ndarray, drawn: np.ndarray, rng: np.random.Generator
    ) -> Loop:
        """Move until the inclinometer on `wedge` (its drawing: `drawn`) reads zero as far as it
        repeats.
        """
        command, centre, seen = command.copy(), centres_of(command[None]), []
        half = 0.5 * self.repeatability
        for _ in range(MOST):
            truth = direct(inverse(command[None], self.model), self.truth, command[None])[0]
            seen.append(read(truth[3:], wedge) + rng.uniform(-half, half, 2))
            if np.abs(seen[-1]).max() <= max(self.repeatability, 1e-12):
                return Loop(np.array(seen), command, truth)
            command[3:5] -= np.linalg.solve(by_inclination(command[3:], drawn), seen[-1])
            command = posture_at(centre, command[None, 3:])[0]
        raise SystemExit(f"ren2008: the inclinometer was not levelled in {MOST} moves")


def by_inclination(angles: np.ndarray, wedge: np.ndarray) -> np.ndarray:
    """d readings / d (alpha, beta) (2, 2), by central differences."""
    step = 1e-5
    ends = [read(angles + s * e, wedge) for e in np.eye(3)[:2] for s in (step, -step)]
    return np.column_stack([(ends[0] - ends[1]), (ends[2] - ends[3])]) / (2 * step)


@dataclass(frozen=True, eq=False)
class Campaign:
    """All loops of the procedure in order, the group of each, and the readings for calibration."""

    loops: list[Loop]
    groups: np.ndarray
    measured: Measurements

    def evidence(self) -> dict[str, object]:
        return {
            "by": f"{__name__}.campaign",
            "method": "levelling loop",
            "text": "levelling loop of 1.5",
        }

    @property
    def moves(self) -> np.ndarray:
        return np.array([loop.moves for loop in self.loops])

    @property
    def first(self) -> np.ndarray:
        """Largest first reading of each posture [rad]."""
        return np.array([np.abs(loop.readings[0]).max() for loop in self.loops])

    @property
    def spread(self) -> float:
        """Largest difference of true (alpha, beta) within a group [rad]."""
        angles = np.array([loop.truth[3:5] for loop in self.loops])
        return max(
            float(np.ptp(angles[self.groups == g], axis=0).max()) for g in np.unique(self.groups)
        )


def campaign(
    machine: Machine,
    inclined: np.ndarray,
    each: int,
    precision: Precision,
    rng: np.random.Generator,
    start: str = "plain",
) -> Campaign:
    """The procedure of 1.5: for each wedge `each` postures are levelled, and their rods read;
    `inclined` (groups, 2) are the inclinations for which the wedges are drawn.
    """
    if start not in STARTS:
        raise ValueError(f"start = {start!r}; allowed: {', '.join(STARTS)}")
    loops = []
    for drawn in inclined:
        wedge = level_turn(drawn + rng.uniform(-WEDGE_ERROR, WEDGE_ERROR, 2))
        commands, _ = random_postures(machine.model, np.tile(drawn, (each, 1)), rng)
        shift = np.zeros(2)
        for command in commands:
            begin = posture_at(
                centres_of(command[None]), command[None, 3:] + np.array([*shift, 0.0])
            )[0]
            loops.append(machine.level(begin, wedge, level_turn(drawn), rng))
            if start == "carried":
                shift = loops[-1].command[3:5] - drawn
    groups = np.repeat(np.arange(len(inclined)), each)
    q = inverse(np.array([loop.truth for loop in loops]), machine.truth)
    return Campaign(loops, groups, readings(q, groups, precision, rng))


# --- rows -----------------------------------------------------------------------------------------

DRAWS = 15
"""Sets of postures over which condition numbers are taken; rows give their median."""
WEDGES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Ranges of the inclinations, deg: +- each."""
REPEATABILITY = np.radians(BEST.inclinometer)


def condition(case: Case, inclined: np.ndarray, rng: np.random.Generator) -> tuple[int, float]:
    """Rank and condition number of dC/deta (32 columns) at random postures of inclinations
    `inclined`.
    """
    X = postures_in_groups(case.eta, inclined, rng)
    found = spectrum(
        jacobian(by_parameters(case.eta, X)[:, :, case.free], group_numbers(len(inclined)))
    )
    return found.rank, found.condition


def wedge_conditions(case: Case) -> dict[float, float]:
    """Median condition number of 40 postures against the range of their inclinations [deg]."""
    return {
        wedge: float(
            np.median(
                [
                    condition(
                        case, inclinations(GROUPS, case.rng(41, k)) * wedge / TILT, case.rng(42, k)
                    )[1]
                    for k in range(DRAWS)
                ]
            )
        )
        for wedge in WEDGES
    }


def report_wedges(report: Report, case: Case, trials: int) -> dict[float, float]:
    """Step (3) of 1.5: what the wedges are for."""
    place, level = "1.5, (3)", np.zeros((GROUPS, 2))
    ranks = [condition(case, level, case.rng(40, k))[0] for k in range(DRAWS)]
    report.row(
        "rank of dC/deta, 40 postures at level, no wedge; of 32",
        None,
        max(ranks),
        place=place,
        run=condition,
    )
    one = np.tile(np.radians((10.0, 5.0)), (GROUPS, 1))
    report.row(
        "rank, 40 postures on one wedge of 10 and 5 deg",
        None,
        condition(case, one, case.rng(43))[0],
        place=place,
        run=condition,
    )
    both = np.repeat(np.radians(((0.0, 0.0), (10.0, 5.0))), GROUPS // 2, axis=0)
    report.row(
        "rank, 40 postures at level and on one wedge",
        None,
        condition(case, both, case.rng(44))[0],
        place=place,
        run=condition,
    )
    X = postures_in_groups(case.eta, level, case.rng(45))
    moved = jacobian(by_parameters(case.eta, X), group_numbers(GROUPS)) @ lifts(
        case.eta, np.array([0.0, 0.0, 1.0])
    )
    report.row(
        "at level: z of M_i and of B_i raised together, six directions: what they change in C, "
        "largest",
        0,
        float(np.abs(moved).max()),
        place=place,
        run=(jacobian, lifts),
        tolerance=1e-12,
    )
    conditions = wedge_conditions(case)
    for wedge, value in conditions.items():
        report.row(
            f"condition number of dC/deta, inclinations within {wedge:g} deg, median",
            None,
            value,
            place=place,
            run=wedge_conditions,
        )
    falling = all(
        a > b
        for a, b in zip(list(conditions.values())[:-1], list(conditions.values())[1:], strict=True)
    )
    report.row(
        "'wedges lower the condition number'", True, falling, place=place, run=wedge_conditions
    )
    worst, fits = {}, {}
    for tilt in (2.0, TILT):
        worst[tilt], fits[tilt] = wedge_errors(case, tilt, trials)
        report.row(
            f"80 postures within {tilt:g} deg, {BEST}: worst errors, aligned frames, median",
            None,
            worst[tilt],
            "mm, deg",
            place=place,
            run=(fits[tilt], pose_errors),
        )
    better = bool(np.all(np.array(worst[2.0]) > worst[TILT]))
    report.row(
        "'and so give a better calibration'", True, better, place=place, run=(fits[2.0], fits[TILT])
    )
    return conditions


def wedge_errors(case: Case, tilt: float, trials: int) -> tuple[list[float], Fits]:
    """Median of the worst errors at unused poses after 80 postures within a range of inclinations
    [deg].
    """
    tests, worst, fits = (
        random_postures(case.truth, np.full((100, 2), np.nan), case.rng(46))[0],
        [],
        [],
    )
    for k in range(trials):
        inclined = inclinations(20, case.rng(47, k)) * tilt / TILT
        found = fit(
            case.nominal,
            measure_groups(case.truth, inclined, EACH, BEST, case.rng(48, k)),
            "differences",
        )
        fits.append(found)
        worst.append(
            pose_errors(eta_from(found.values, case.eta), case.truth, case.eta, tests)[
                "aligned"
            ].worst
        )
    return np.median(worst, axis=0).tolist(), Fits(fits)


def report_levelling(report: Report, case: Case, tests: np.ndarray) -> dict[str, Campaign]:
    """Steps (1) to (4): 20 wedges, 4 postures each, levelled by a controller that knows the nominal
    geometry only.
    """
    inclined, place = inclinations(20, case.rng(50)), "1.5"
    nominal = campaign(
        Machine(case.truth, case.eta, REPEATABILITY), inclined, EACH, BEST, case.rng(51), "plain"
    )
    report.row(
        "levelling, 80 postures on 20 wedges: first reading, median and largest",
        None,
        np.degrees([np.median(nominal.first), nominal.first.max()]),
        "deg",
        place=place,
        run=nominal,
    )
    report.row(
        "alpha, beta of levelled postures: largest difference within a group",
        None,
        float(np.degrees(nominal.spread)),
        "deg",
        place=place,
        run=nominal,
    )
    found = fit(case.nominal, nominal.measured, "differences")
    identified = eta_from(found.values, case.eta)
    errors = pose_errors(identified, case.truth, case.eta, tests)
    for frame, error in errors.items():
        report.row(
            f"calibrated by the rods of levelled postures: worst errors, {frame} frames",
            None,
            error.worst,
            "mm, deg",
            place=place,
            run=(nominal, Fits([found])),
        )
    campaigns = {}
    for name, model in (("nominal", case.eta), ("identified", identified)):
        for start in STARTS:
            done = campaign(
                Machine(case.truth, model, REPEATABILITY), inclined, EACH, BEST, case.rng(51), start
            )
            campaigns[f"{name}, {start}"] = done
    return campaigns


def report_servo(report: Report, campaigns: dict[str, Campaign]) -> None:
    """The outlook's fast servo adjustment: moves until the inclinometer reads zero."""
    for name, done in campaigns.items():
        model, start = name.split(", ")
        how = "from the wedge's drawing" if start == "plain" else "carrying the last correction"
        report.row(
            f"levelling with the {model} geometry, {how}: moves for 80 postures, most for one",
            None,
            [int(done.moves.sum()), int(done.moves.max())],
            place="3, outlook",
            run=done,
        )


def report_range(report: Report, campaigns: dict[str, Campaign]) -> None:
    """What range the inclinometer needs: the method's against absolute readings over +-20 deg."""
    nominal = campaigns["nominal, plain"]
    first = float(np.degrees(nominal.first.max()))
    report.row(
        "largest reading in the loop, inclinations within +-20 deg",
        None,
        first,
        "deg",
        place="1.1",
        run=nominal,
    )
    report.row(
        "'not limited by the inclinometer's range': a tenth of the inclinations' range is enough",
        True,
        first < 0.1 * TILT,
        place="1.1, abstract",
        run=nominal,
    )
