"""Rows on all solutions of the Gluon-6L3's inverse problem: continuation, varied guesses by each
solver, random poses, and speed.

Source: see `study`.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import symkin
from studies.gluon_6l3.model import (
    closed_form,
    closed_form_function,
    random_poses,
    real_columns,
    wrap,
)
from studies.gluon_6l3.numeric import (
    FEW,
    MANY,
    STARTS,
    Equations,
    compare,
    continued,
    ends_at_half_turns,
    furthest,
    given_numbers,
    has_twin,
    newton_step,
    rootfinder_of_six,
    sampled,
)
from studies.shared.guesses import Trial, attempt, least_squares, report_trials
from studies.shared.report import Report
from studies.shared.words import statement

SEED = 6
GUESSES = 300
"""Random guesses for each of CasADi's solvers."""
SHARES = 2000
"""Random poses whose solutions are counted."""


# --- speed ----------------------------------------------------------------------------------------


def report_speed(
    report: Report, arm: symkin.Mechanism, system: Equations, T: np.ndarray, trial: Trial
) -> None:
    """'The analytic solution is much faster': instructions of CasADi's virtual machine, and times,
    from the same guesses.
    """
    function, step = closed_form_function(), newton_step(system.twelve, system.tangents)
    poses = random_poses(100, SEED)
    lists = [(closed_form(P), real_columns(function(P))) for P in poses]
    apart = max(
        min(np.abs(wrap(a - b)).max() for b in right) for left, right in lists for a in left
    )
    place = "inverse"
    report.row(
        "closed form as one CasADi function less the other, 100 random poses",
        0,
        float(apart),
        "rad",
        place=place,
        run=(closed_form_function, closed_form),
        tolerance=1e-9,
    )
    one, each, steps = function.n_instructions(), step.n_instructions(), trial.iterations[0]
    report.row(
        "instructions: closed form, all solutions", None, one, place=place, run=closed_form_function
    )
    report.row(
        "instructions: Newton, a step; median of steps to one solution",
        None,
        [each, steps],
        place=place,
        run=(newton_step, trial),
    )
    faster = each * steps / one
    report.row(
        "'analytic is much faster than numeric': instructions of one solution by Newton over all "
        "by the closed form",
        "much more than 1",
        float(faster),
        place=place,
        run=(newton_step, trial, closed_form_function),
        verdict="reproduced" if faster > 10 else "refuted",
    )
    timed = {
        "closed form, all solutions": lambda: function(T),
        "closed form in NumPy, all solutions": lambda: closed_form(T),
        "continuation, all solutions": lambda: continued(arm, T),
        f"multistart, {FEW} starts": lambda: sampled(arm, T, "batched", FEW, SEED),
    }
    for name, call in timed.items():
        run = closed_form_function if "form" in name else call()
        report.row(
            f"time: {name}", None, milliseconds(call), "ms", place=place, run=run, volatile=True
        )
    reached = [end.seconds for end, k in zip(trial.ends, trial.found, strict=True) if k is not None]
    report.row(
        "time: rootfinder, one solution",
        None,
        1e3 * float(np.median(reached)),
        "ms",
        place=place,
        run=trial,
        volatile=True,
    )


def milliseconds(call: Callable[[], object]) -> float:
    """Shortest of five calls."""
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times)


# --- all solutions, from varied guesses and by continuation ---------------------------------------


def casadi_trials(system: Equations, T: np.ndarray, seed: int) -> list[Trial]:
    """The rootfinder and IPOPT from the same random guesses, and the rootfinder on rows that vanish
    at half a turn too.
    """
    guesses = np.random.default_rng(seed).uniform(-np.pi, np.pi, (GUESSES, 6))
    sines = rootfinder_of_six(system.twelve, system.sines, "rootfinder of sines")
    searches = (
        rootfinder_of_six(system.twelve, system.tangents),
        least_squares(system.twelve),
        sines,
    )
    return [attempt(search, guesses, given_numbers(T), closed_form(T)) for search in searches]


def report_enumeration(
    report: Report, arm: symkin.Mechanism, T: np.ndarray, name: str, trials: list[Trial]
) -> None:
    """All solutions at one pose: continuation as the proof, CasADi's solvers and symkin's
    multistart from varied guesses.
    """
    exact = closed_form(T)
    proof = continued(arm, T)
    report.row(
        f"{name}: solutions by continuation, by closed form",
        None,
        [len(proof), len(exact)],
        run=(proof, closed_form),
    )
    report.row(f"{name}: completeness", None, statement(proof), run=proof)
    report.row(
        f"{name}: largest difference of the two",
        0,
        furthest(exact, proof),
        "rad",
        run=(proof, closed_form),
        tolerance=1e-9,
    )
    report_trials(report, name, "", trials[:2])
    sines = trials[2]
    values = [sum(sines.hits), ends_at_half_turns(sines, T)]
    report.row(
        f"{name}, rootfinder with the rotation's error as sines: hits, ends half a turn away",
        None,
        values,
        run=sines,
    )
    for solver, starts in STARTS.items():
        found = sampled(arm, T, solver, starts, SEED)
        label = f"{name}, symkin.modes by multistart, {solver}"
        report.row(
            f"{label}: solutions met, of {len(exact)}; missed",
            None,
            [len(found), len(exact) - len(found)],
            run=found,
        )
        report.row(f"{label}: hits per solution", None, [s.hits for s in found], run=found)


def report_random(report: Report, arm: symkin.Mechanism, count: int) -> np.ndarray:
    """At random poses: the closed form's solutions, and what continuation and multistart list of
    them.
    """
    begin, poses = time.perf_counter(), random_poses(count, SEED)
    proof, few = compare(arm, poses, None, SEED), compare(arm, poses, FEW, SEED)
    total = sum(map(len, proof.exact))
    report.row(
        "random poses, and their solutions in closed form", None, [count, total], run=closed_form
    )
    for name, found in (("continuation", proof), ("multistart", few)):
        report.row(f"random poses where closed form = {name}", None, found.equal, run=found)
        report.row(
            f"random poses, {name}: solutions listed, missed",
            None,
            [found.solutions, sum(found.missed)],
            run=found,
        )
    worst = int(np.argmax(few.missed))
    again = compare(
        arm,
        [T for T, gone in zip(poses, few.missed, strict=True) if gone] or poses[worst : worst + 1],
        MANY,
        SEED,
    )
    report.row(
        "of the poses with any missed, multistart with more starts misses",
        None,
        sum(again.missed),
        run=again,
    )
    twins = sum(any(has_twin(q, solutions) for q in solutions) for solutions in proof.exact)
    report.row(
        "random poses with two solutions within 1e-3 rad, where residuals decide",
        None,
        twins,
        run=closed_form,
    )
    report.row(
        "time of the comparison",
        None,
        time.perf_counter() - begin,
        "s",
        run=(proof, few),
        volatile=True,
    )
    counts = np.array([len(closed_form(T)) for T in random_poses(SHARES, SEED)])
    shares = [100 * float(np.mean(counts == n)) for n in (2, 4, 6, 8)]
    report.row(
        f"2, 4, 6, 8 real solutions, {SHARES} random poses", None, shares, "%", run=closed_form
    )
    return counts
