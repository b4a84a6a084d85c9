"""Rows on equations (1) and (2): the inverse problem by formula, the direct problem by every
solver, its modes from varied guesses.

The paper only writes x = F(l, eta); its closure is that of the "usual simplified model" of a
platform on six rods. Source: Ren, Feng, Su 2008, 1.3 (see `study`).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import symkin
from studies.ren2008.method import poses_of, random_postures
from studies.ren2008.model import Case, angles_of, closure, direct, inverse
from studies.shared.guesses import attempt, least_squares, report_trials, rootfinder
from studies.shared.report import Report
from studies.shared.words import statement, written
from symkin import Modes, SolveResult

PLACE = "1.3, (1)"
POSES = 200
GUESSES = 300
FEWER = (25, 50, 100, 200)
"""Starts that are fewer."""
ELSEWHERE = 20
"""Postures of the workspace at which both lists of modes are compared."""
SAME = 1e-7
"""Largest difference (m, entries of R) between a mode of multistart and the same mode of
continuation.
"""


@dataclass(frozen=True, eq=False)
class Solved:
    """Solves of one kind, as a row quotes them."""

    results: Sequence[SolveResult]

    def evidence(self) -> dict[str, object]:
        method = self.results[0].method
        return {
            "by": "symkin.solve",
            "method": method,
            "calls": len(self.results),
            "text": f"solve: {method}",
        }


def postures_of(modes: Modes) -> list[np.ndarray]:
    """X (6,) of each mode."""
    turns = angles_of(np.array([mode.rotation for mode in modes]))
    return [
        np.concatenate([mode.position, angles]) for mode, angles in zip(modes, turns, strict=True)
    ]


@dataclass(frozen=True, eq=False)
class Match:
    """For each known mode how many starts of another list led to it, and the largest difference of
    those that were met.
    """

    hits: list[int]
    gap: float

    @property
    def met(self) -> int:
        return sum(h > 0 for h in self.hits)

    @property
    def missed(self) -> int:
        return len(self.hits) - self.met


def match(found: Modes, known: Modes) -> Match:
    nearest = [min(found, key=lambda other, mode=mode: apart(mode, other)) for mode in known]
    gaps = [apart(mode, other) for mode, other in zip(known, nearest, strict=True)]
    hits = [
        int(other.hits or 0) if gap < SAME else 0 for other, gap in zip(nearest, gaps, strict=True)
    ]
    return Match(hits, max((gap for gap in gaps if gap < SAME), default=np.inf))


def apart(one: symkin.Solution, other: symkin.Solution) -> float:
    return float(
        max(
            np.abs(one.position - other.position).max(), np.abs(one.rotation - other.rotation).max()
        )
    )


# --- rows -----------------------------------------------------------------------------------------


def report_closure(report: Report, case: Case) -> None:
    F = closure(case.eta).F
    for i in range(6):
        report.row(
            f"|t + R m_{i + 1} - b_{i + 1}| - dl_{i + 1} - l_{i + 1}: 0 =",
            None,
            written(F[i]),
            "m",
            place=PLACE,
            run=closure,
        )


def report_inverse(report: Report, case: Case, postures: np.ndarray) -> None:
    """The inverse problem is a formula: one solution, no guesses."""
    eta, home = case.eta, case.home
    report.row(
        "inverse, l_i = |t + R m_i - b_i| - dl_i, at home",
        None,
        inverse(home[None], eta)[0],
        "m",
        place=PLACE,
        run=inverse,
    )
    branches = symkin.modes(case.nominal, pose=case.nominal.reference_pose)
    report.row("inverse at home: solutions", None, len(branches), place=PLACE, run=branches)
    solved = Solved([symkin.solve(case.nominal, pose=pose) for pose in poses_of(postures)])
    lengths = np.array([result.solution.actuated_values for result in solved.results])
    report.row(
        f"inverse at {len(postures)} poses: symkin less the formula, largest",
        0,
        float(np.abs(lengths - inverse(postures, eta)).max()),
        "m",
        place=PLACE,
        run=(solved, inverse),
        tolerance=1e-12,
    )


def report_from_home(report: Report, case: Case, postures: np.ndarray) -> None:
    """(1) and (2) as the paper uses them: Newton from the home pose gives each posture back."""
    eta, home, count = case.eta, case.home, len(postures)
    q = inverse(postures, eta)
    found = direct(q, eta, np.tile(home, (count, 1)))
    gap = np.abs(found - postures).max(axis=1)
    report.row(
        f"direct, CasADi, all at once from home: back at the pose, of {count}",
        count,
        int((gap < 1e-9).sum()),
        place=PLACE,
        run=direct,
    )
    begin = time.perf_counter()
    solved = Solved(
        [symkin.solve(case.nominal, joints=row, start=case.nominal.reference_pose) for row in q]
    )
    seconds = time.perf_counter() - begin
    apart = [
        np.abs(r.solution.pose.matrix - p.matrix).max()
        for r, p in zip(solved.results, poses_of(postures), strict=True)
    ]
    report.row(
        f"direct, one by one from home: back at the pose, of {count}",
        count,
        sum(a < 1e-9 for a in apart),
        place=PLACE,
        run=solved,
    )
    report.row(
        "alpha, beta of (2) by both: largest difference from the posture's",
        0,
        float(np.degrees(gap.max())),
        "deg",
        place="1.3, (2)",
        run=(direct, solved),
        tolerance=1e-9,
    )
    steps = [r.iterations for r in solved.results]
    report.row(
        "Newton steps from home, median and most",
        None,
        [int(np.median(steps)), max(steps)],
        place=PLACE,
        run=solved,
    )
    report.row(
        "time of a direct solve",
        None,
        1e3 * seconds / count,
        "ms",
        place=PLACE,
        run=solved,
        volatile=True,
    )


def random_guesses(home: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Positions within 1 m aside of home, heights of either sign, any turn."""
    rng = np.random.default_rng(seed)
    aside = home[:2] + rng.uniform(-1.0, 1.0, (count, 2))
    return np.column_stack(
        [aside, rng.uniform(-1.5, 1.5, count), rng.uniform(-np.pi, np.pi, (count, 3))]
    )


def report_modes(report: Report, case: Case) -> list[np.ndarray]:
    """The direct problem at home: continuation, and the same modes from varied guesses by each
    solver.
    """
    eta, home = case.eta, case.home
    q = inverse(home[None], eta)[0]
    known = symkin.modes(case.nominal, joints=q)
    above = sum(bool(mode.position[2] > 0) for mode in known)
    report.row(
        "direct at home, continuation: real modes, above the base",
        None,
        [len(known), above],
        place=PLACE,
        run=known,
    )
    report.row("completeness", None, statement(known), place=PLACE, run=known)
    modes = postures_of(known)
    system, guesses = closure(eta), random_guesses(home, GUESSES, case.seed)
    trials = [attempt(search(system), guesses, q, modes) for search in (rootfinder, least_squares)]
    report_trials(report, "direct at home", PLACE, trials)
    for solver in ("batched", "newton", "ipopt"):
        found = symkin.modes(
            case.nominal,
            joints=q,
            method="multistart",
            solver=solver,
            starts=GUESSES,
            seed=case.seed,
        )
        name, same = f"direct at home, multistart, {solver}", match(found, known)
        report.row(
            f"{name}: modes met, missed of those of continuation",
            None,
            [same.met, same.missed],
            place=PLACE,
            run=(found, known),
        )
        report.row(
            f"{name}: modes that continuation has not",
            0,
            len(found) - same.met,
            place=PLACE,
            run=(found, known),
        )
        report.row(f"{name}: hits per mode", None, same.hits, place=PLACE, run=(found, known))
        report.row(
            f"{name}: time",
            None,
            found.elapsed_s,
            "s",
            place=PLACE,
            run=(found, known),
            volatile=True,
        )
        report.row(
            f"{name}: largest difference from continuation",
            0,
            same.gap,
            "m",
            place=PLACE,
            run=(found, known),
            tolerance=SAME,
        )
    report_fewer_starts(report, case, q, known)
    report_true_modes(report, case)
    return modes


def report_fewer_starts(report: Report, case: Case, q: np.ndarray, known: Modes) -> None:
    """What multistart misses where it is given less."""
    found = [
        symkin.modes(case.nominal, joints=q, method="multistart", starts=n, seed=case.seed)
        for n in FEWER
    ]
    missed = [match(one, known).missed for one in found]
    report.row(
        f"direct at home, multistart, batched, {', '.join(map(str, FEWER))} starts: modes missed "
        f"of those of continuation",
        None,
        missed,
        place=PLACE,
        run=(found, known),
    )


def report_true_modes(report: Report, case: Case) -> None:
    """The true geometry, whose joints lie in no plane: no mirror pairs, and all 40 complex
    solutions of six rods.
    """
    q = inverse(case.home[None], case.truth)[0]
    known = symkin.modes(case.true, joints=q)
    above = sum(bool(mode.position[2] > 0) for mode in known)
    report.row(
        "true geometry at home, continuation: real modes, above the base",
        None,
        [len(known), above],
        place=PLACE,
        run=known,
    )
    report.row("true geometry: completeness", None, statement(known), place=PLACE, run=known)
    found = symkin.modes(case.true, joints=q, method="multistart", starts=GUESSES, seed=case.seed)
    same = match(found, known)
    report.row(
        "true geometry, multistart: modes met, missed of those of continuation",
        None,
        [same.met, same.missed],
        place=PLACE,
        run=(found, known),
    )


def report_elsewhere(report: Report, case: Case, postures: np.ndarray) -> None:
    """How often as many starts miss modes at other postures of the workspace."""
    lists = [symkin.modes(case.nominal, joints=q) for q in inverse(postures, case.eta)]
    found = [
        symkin.modes(case.nominal, joints=q, method="multistart", starts=GUESSES, seed=case.seed)
        for q in inverse(postures, case.eta)
    ]
    same = [match(one, known) for one, known in zip(found, lists, strict=True)]
    name = f"direct at {len(postures)} postures"
    report.row(
        f"{name}, continuation: real modes, least and most",
        None,
        [min(map(len, lists)), max(map(len, lists))],
        place=PLACE,
        run=lists,
    )
    report.row(
        f"{name}, multistart: modes met, missed of those of continuation",
        None,
        [sum(m.met for m in same), sum(m.missed for m in same)],
        place=PLACE,
        run=(found, lists),
    )
    new = sum(len(one) - m.met for one, m in zip(found, same, strict=True))
    report.row(
        f"{name}, multistart: modes that continuation has not",
        0,
        new,
        place=PLACE,
        run=(found, lists),
    )


def report_direct(report: Report, case: Case) -> list[np.ndarray]:
    """All rows of (1) and (2); the modes at home, for the picture of the guesses."""
    postures, _ = random_postures(
        case.eta, np.full((POSES, 2), np.nan), np.random.default_rng(case.seed)
    )
    report_closure(report, case)
    report_inverse(report, case, postures)
    report_from_home(report, case, postures)
    modes = report_modes(report, case)
    report_elsewhere(report, case, postures[:ELSEWHERE])
    return modes
