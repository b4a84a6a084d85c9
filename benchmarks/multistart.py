"""Starts per second: batched multistart beside a Python loop over CasADi's rootfinder, in one
process, same starts.

    python benchmarks/multistart.py [--repeats 5] [--starts 2000] [--seed 0]

Both solve the direct problem of the mechanism's example from the same random starts. The loop calls
a rootfinder built once on the expanded closure (quaternion norm as a seventh row), which is the
quickest way that CasADi's interface offers for one start. Figures are medians over the repeats,
taken in turn; the ratio is what counts, machines differ.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Iterator

import casadi as ca
import numpy as np

import symkin
from cases import STARTED
from symkin.numeric.levenberg import levenberg_marquardt
from symkin.position.given import read_given
from symkin.position.multistart import distinct
from symkin.position.newton import flat_rows
from symkin.position.problem import build_problem
from symkin.position.starts import random_starts
from timing import Figure, in_turn


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--starts", type=int, default=2000)
    parser.add_argument(
        "--loop-starts", type=int, default=200, help="starts of the slower loop a repeat"
    )
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(
        f"seed {options.seed}, {options.starts} starts batched, {options.loop_starts} looped, "
        f"medians of {options.repeats}"
    )
    print(
        "mechanism   batched starts/s   newton loop starts/s   fast_newton loop starts/s   ratio "
        "to the quicker loop"
    )
    for name in STARTED:
        rates = compare(name, options)
        best = max(rates["newton"], rates["fast_newton"])
        print(
            f"{name:10}  {rates['batched']:16,.0f}   {rates['newton']:20,.0f}   "
            f"{rates['fast_newton']:25,.0f}   {rates['batched'] / best:8.1f}"
        )


def compare(name: str, options: argparse.Namespace) -> dict[str, float]:
    """Median starts per second of the three ways, measured in turn."""
    given = read_given(symkin.load(name), None, None)
    problem = build_problem(symkin.load(name), given.names)
    system = problem.system
    starts = random_starts(
        problem, system, given.values, options.starts, np.random.default_rng(options.seed)
    )
    loops = {method: rootfinder(problem, method) for method in ("newton", "fast_newton")}
    system.linearise(starts[:1], given.values)

    def batched() -> None:
        batch = levenberg_marquardt(system, starts, given.values)
        distinct(system, batch.points[batch.converged], given.values, len(starts))

    def looped(solver: ca.Function) -> None:
        for start in starts[: options.loop_starts]:
            solver(start, given.values)

    times = in_turn(
        {"batched": batched}
        | {name: lambda solver=solver: looped(solver) for name, solver in loops.items()},
        options.repeats,
    )
    counts = {
        name: len(starts) if name == "batched" else min(options.loop_starts, len(starts))
        for name in times
    }
    return {name: counts[name] / statistics.median(seconds) for name, seconds in times.items()}


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:
    """A start of a batch over one of the quicker loop of CasADi's rootfinder."""
    size = (
        {"repeats": 3, "starts": 500, "loop_starts": 60}
        if quick
        else {"repeats": 7, "starts": 2000, "loop_starts": 200}
    )
    for name in STARTED:
        rates = compare(name, argparse.Namespace(seed=seed, **size))
        quicker = max(rate for way, rate in rates.items() if way != "batched")
        yield Figure(
            f"multistart: {name}, a start over CasADi's",
            quicker / rates["batched"],
            f"{rates['batched']:,.0f} starts/s",
        )


def rootfinder(problem: symkin.position.problem.Problem, method: str) -> ca.Function:
    """CasADi's rootfinder on the same rows, silent about failures."""
    system = problem.system
    options = {"error_on_fail": False, "max_iter": 60, "abstol": 1e-10, "show_eval_warnings": False}
    equations = {"x": system.unknown, "p": system.known, "g": flat_rows(system)}
    return ca.rootfinder("loop", method, equations, options)


if __name__ == "__main__":
    main()
