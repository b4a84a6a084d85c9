"""The claims of the Gough-Stewart paper: few unknowns, accurate, in real time; the modes from
varied guesses by each method.

Six unknowns beside 24 and three, from the same guesses; instructions of the example in C as
committed. Source: see `study`.
"""

from __future__ import annotations

import time

import numpy as np

import symkin
from studies.shared.guesses import Search, Trial, attempt, least_squares, report_trials, rootfinder
from studies.shared.report import Report
from studies.zhang2009.instructions import committed
from studies.zhang2009.model import (
    BASE_RADIUS,
    EVIDENT_POSE,
    START,
    START_NEARBY,
    TABLE_1,
    Equations,
    as_six,
    euler_pose,
    from_angles,
    leg_lengths,
    outside,
    position_from_angles,
    quadratic_unknowns,
    scaled,
    six_unknowns,
    three_unknowns,
    to_same_pose,
    unknowns_of,
)
from studies.zhang2009.newton import (
    PaperNewton,
    evaluation_operations,
    inverse_operations,
    newton,
    paper_newton,
)

SEED = 0
"""Of the random guesses."""
LENGTHS = TABLE_1 / BASE_RADIUS
CONTROL_PERIOD, SPEED = 1.0, 1e5
"""What real time is taken to be, since the paper does not say: 1 ms, at 100 million instructions a
second (1e5 a millisecond).
"""


# --- guesses: six unknowns, 24, three -------------------------------------------------------------


def random_guesses(count: int) -> np.ndarray:
    """Positions within 150 mm and angles within 60 degrees, in the solvers' units."""
    draws = np.random.default_rng(SEED).uniform(-1, 1, (count, 6))
    return np.array([scaled(row * (150.0, 150.0, 150.0, 60.0, 60.0, 60.0)) for row in draws])


def searches() -> dict[str, Search]:
    """All searches take and give poses."""
    six, many, three = six_unknowns(), quadratic_unknowns(), three_unknowns()
    return {
        "the paper's Newton, 6 unknowns": to_same_pose(paper_newton(six, "Newton, 6 unknowns")),
        "the paper's Newton, 24 unknowns": as_six(paper_newton(many, "Newton, 24 unknowns"), six),
        "the paper's Newton, 3 unknowns": from_angles(
            paper_newton(three, "Newton, 3 unknowns"), six
        ),
        "rootfinder, 6 unknowns": to_same_pose(renamed(rootfinder(six), 6)),
        "rootfinder, 24 unknowns": as_six(renamed(rootfinder(many), 24), six),
        "IPOPT, 6 unknowns": to_same_pose(renamed(least_squares(six), 6)),
        "IPOPT, 24 unknowns": as_six(renamed(least_squares(many), 24), six),
    }


def renamed(search: Search, unknowns: int) -> Search:
    return Search(
        f"{search.name}, {unknowns} unknowns", search.closure, search.solver, search.iterations
    )


def report_guesses(
    report: Report, platform: symkin.Mechanism, found: symkin.Modes, count: int
) -> dict[str, Trial]:
    """The four modes from the same guesses, by each method and in each set of unknowns, and by
    symkin's multistart.
    """
    guesses, modes = random_guesses(count), [scaled(euler_pose(mode.pose)) for mode in found]
    trials = {name: attempt(search, guesses, LENGTHS, modes) for name, search in searches().items()}
    report_trials(report, "direct", "4; 1, [3], [4]", list(trials.values()))
    for solver in ("batched", "newton", "ipopt"):
        sampled = symkin.modes(
            platform, joints=TABLE_1, method="multistart", solver=solver, starts=count, seed=SEED
        )
        name = f"direct, symkin.modes by multistart, {solver}"
        own = [euler_pose(mode.pose) for mode in sampled]
        apart = max(min(float(np.abs(p - euler_pose(m.pose)).max()) for m in found) for p in own)
        report.row(
            f"{name}: modes met, missed, of 4",
            None,
            [len(sampled), len(found) - len(sampled)],
            place="4",
            run=sampled,
        )
        report.row(
            f"{name}: hits per mode", None, [mode.hits for mode in sampled], place="4", run=sampled
        )
        report.row(
            f"{name}: largest difference from continuation",
            0,
            apart,
            "mm, deg",
            place="4",
            run=(sampled, found),
            tolerance=1e-7,
        )
    return trials


def report_unknowns(report: Report) -> dict[str, list[float]]:
    """Six unknowns beside 24 and three from one start: steps and operations."""
    sets = {
        6: (six_unknowns(), scaled(START)),
        24: (quadratic_unknowns(), unknowns_of(scaled(START))),
        3: (three_unknowns(), scaled(START_NEARBY)[3:]),
    }
    where = {6: "(0, 0, 100; 0, 0, 0)", 24: "(0, 0, 100; 0, 0, 0)", 3: "angles (5, 5, 5)"}
    paths: dict[str, list[float]] = {}
    for n, (closure, start) in sets.items():
        solver = PaperNewton(closure)
        solver(start, LENGTHS)
        paths[f"{n} unknowns, from {where[n]}"] = solver.path
        report.row(
            f"{n} unknowns: Newton steps from {where[n]}",
            None,
            len(solver.path) - 1,
            place="1, [3], [4]",
            run=PaperNewton,
        )
    for n, (closure, _) in sets.items():
        operations = [evaluation_operations(closure), inverse_operations(n)]
        report.row(
            f"{n} unknowns: operations of a step, F and D; inverse and update",
            None,
            operations,
            place="1, [3], [4]",
            run=(evaluation_operations, inverse_operations),
        )
    totals = {
        n: evaluation_operations(closure) + inverse_operations(n)
        for n, (closure, _) in sets.items()
    }
    report.row(
        "operations of a step, 24 over six unknowns: 'few unknowns, fast'",
        None,
        totals[24] / totals[6],
        place="1",
        run=(evaluation_operations, inverse_operations),
        verdict="reproduced",
    )
    return paths


def report_fewest(report: Report, found: symkin.Modes) -> None:
    """The position follows from the angles by linear equations, so that three unknowns are
    enough.
    """
    apart = max(
        float(
            np.abs(
                BASE_RADIUS * position_from_angles(np.radians(euler_pose(m.pose)[3:]), LENGTHS)
                - m.pose.position
            ).max()
        )
        for m in found
    )
    report.row(
        "p of the four modes from their angles alone (f_i - f_1 = 0, linear): largest difference",
        None,
        apart,
        "mm",
        place="1",
        run=(position_from_angles, found),
    )
    end = from_angles(rootfinder(three_unknowns()), six_unknowns()).end(
        scaled(START_NEARBY), LENGTHS
    )
    pose = outside(np.array([*BASE_RADIUS * end.X[:3], *end.X[3:]]))
    report.row(
        "unknowns of 'the method with the fewest unknowns'",
        6,
        3,
        place="1",
        run=three_unknowns,
        verdict="refuted",
    )
    report.row(
        "rootfinder in three unknowns from angles (5, 5, 5)",
        EVIDENT_POSE,
        pose,
        "mm, deg",
        place="1",
        run=(three_unknowns, rootfinder),
        tolerance=0.1,
    )
    text = (
        "the method has not the fewest unknowns: f_i - f_1 = 0 are linear in the position, so that "
        "the three angles are enough."
    )
    report.erratum(text, shown=apart < 1e-6 and end.closed)


# --- accuracy and real time (abstract) ------------------------------------------------------------


def report_claims(report: Report, system: Equations, found: symkin.Modes) -> dict[str, int]:
    path = newton(system, START)
    end = outside(path[-1][0])
    gap = np.abs(end - euler_pose(found[0].pose))
    report.row(
        "'accurate': last step less the certified mode, position; angles",
        None,
        [gap[:3].max(), gap[3:].max()],
        "mm; deg",
        place="abstract",
        run=(newton, found),
    )
    misses = np.abs(leg_lengths(system, end) - TABLE_1).max()
    report.row(
        "'accurate': largest miss of a limb's length",
        None,
        float(misses),
        "mm",
        place="abstract",
        run=(newton, leg_lengths),
    )
    counts = committed()
    titles = {
        "six": "the paper's Newton, 6 unknowns",
        "twenty-four": "the paper's Newton, 24 unknowns",
        "fast_newton": "CasADi's fast_newton in C, 6 unknowns",
        "symkin": "symkin's C, checked branch",
    }
    for name, title in titles.items():
        report.row(
            f"instructions of the example, {title}: Cortex-M7, x86-64",
            None,
            counts.of(name),
            place="abstract, 4",
            run=counts,
        )
    six, many = (counts.of(name)[0] for name in ("six", "twenty-four"))
    report.row(
        "instructions, 24 over six unknowns", None, many / six, place="1, abstract", run=counts
    )
    report.row(
        f"'real time', taken as {CONTROL_PERIOD:g} ms at 100 million instructions a second: 6, 24 "
        f"unknowns",
        "no figure",
        [six / SPEED, many / SPEED],
        "ms",
        place="abstract",
        run=counts,
        verdict=real_time(six),
    )
    begin = time.perf_counter()
    for _ in range(20):
        newton(system, START)
    each = round(50 * (time.perf_counter() - begin), 2)
    report.row(
        "time of one direct solution in Python",
        None,
        each,
        "ms",
        place="abstract",
        run=newton,
        volatile=True,
    )
    return {title: counts.of(name)[0] for name, title in titles.items()}


def real_time(instructions: int) -> str:
    return "reproduced" if instructions / SPEED < CONTROL_PERIOD else "differs"
