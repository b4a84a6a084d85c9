"""What multistart misses: the modes that random starts meet, against the complete set found by
continuation.

Notation: N starts, h_i of them reach mode i. The mean number of different modes met by n of the N
starts, taken without replacement, is (Hurlbert 1971)

    E(n) = sum_i 1 - C(N - h_i, n) / C(N, n).

Four inner solvers from the same kind of random starts: plain Newton (CasADi's rootfinder
fast_newton), Newton with line search (its newton), damped batched Levenberg-Marquardt on all rows,
and least squares by IPOPT. Beside the true number of unseen modes stands what multistart itself
estimates of it, Chao's f1^2 / (2 f2) from the modes hit once and twice (Chao 1984), for growing
numbers of batched starts. Every mode that multistart finds must be one of the complete set: none
more is a check of the latter.

Examples: the direct problems of zhang2009 and of dietmaier1998 (40 real modes), the inverse problem
of yao2020. There is no paper to compare with.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

import symkin
from symkin import Modes, Solution

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.others.dietmaier1998 import LEGS, platform
from studies.others.solvers import never
from studies.shared.report import Report, new_figure, options_parser
from studies.shared.words import statement

SOLVERS = {
    "batched": ("damped, batched (Levenberg-Marquardt)", 3000, "#0072b2"),
    "fast_newton": ("plain Newton (rootfinder fast_newton)", 150, "#d55e00"),
    "newton": ("Newton with line search (rootfinder newton)", 150, "#e69f00"),
    "ipopt": ("least squares (IPOPT)", 100, "#009e73"),
}
"""Label, starts (times --scale) and colour."""
SIZES = (30, 100, 300, 1000, 3000)
"""Numbers of batched starts (times --scale) at which the estimate of unseen modes is taken."""
RUNS = 5
SEED = 6
SAME = 1e-6
"""Two modes are one where positions, rotations and joints differ by less than this, lengths over
the size.
"""


@dataclass(frozen=True, eq=False)
class Problem:
    """A mechanism, what is given, and its complete set of modes."""

    name: str
    mechanism: symkin.Mechanism
    given: dict[str, object]
    complete: Modes

    @staticmethod
    def of(name: str, mechanism: symkin.Mechanism, given: dict[str, object]) -> Problem:
        return Problem(name, mechanism, given, symkin.modes(mechanism, **given))

    def multistart(self, solver: str, starts: int, seed: int) -> Modes:
        return symkin.modes(
            self.mechanism,
            **self.given,
            method="multistart",
            solver=solver,
            starts=starts,
            seed=seed,
        )

    @cached_property
    def known(self) -> np.ndarray:
        return np.array([self.features(mode) for mode in self.complete])

    def features(self, mode: Solution) -> np.ndarray:
        """Position over the size, rotation matrix, and of each joint cosine and sine of its angle
        or its length over the size.
        """
        closure = self.complete.problem.closure
        parts = [mode.position / closure.characteristic_length, mode.rotation.ravel()]
        for c in closure.role("actuated", "passive"):
            value = np.atleast_1d(mode.values[c.name])
            parts += (
                [np.cos(value), np.sin(value)]
                if c.is_angular
                else [value / closure.characteristic_length]
            )
        return np.concatenate(parts)

    def strangers(self, found: Modes) -> int:
        """Modes that the complete set does not hold."""
        apart = [
            np.abs(self.known - self.features(mode)).max(axis=1).min(initial=np.inf)
            for mode in found
        ]
        return sum(distance > SAME for distance in apart)


@dataclass(frozen=True)
class Trial:
    """One solver on one problem: hits of each mode that it met, its starts and their time."""

    hits: tuple[int, ...]
    starts: int
    seconds: float
    strangers: int

    @staticmethod
    def of(problem: Problem, solver: str, starts: int, seed: int) -> Trial:
        problem.multistart(solver, 2, seed)
        found = problem.multistart(solver, starts, seed)
        return Trial(
            tuple(m.hits or 0 for m in found), starts, found.elapsed_s, problem.strangers(found)
        )

    @property
    def facts(self) -> list[float]:
        """Modes met, starts that reach one in percent, hits of the rarest, seconds."""
        reached = round(100 * sum(self.hits) / self.starts, 1)
        return [len(self.hits), reached, min(self.hits, default=0), round(self.seconds, 2)]

    def coverage(self, n: int) -> float:
        """E(n)."""
        return sum(1 - never(self.starts, h, n) for h in self.hits)


@dataclass(frozen=True)
class Guess:
    """At a number of batched starts, means over `RUNS` runs: modes unseen in truth, and as
    multistart estimates it; and the share of runs that estimate less than one while some are
    unseen.
    """

    starts: int
    unseen: float
    estimated: float
    wrong: float

    @staticmethod
    def of(problem: Problem, starts: int, seed: int) -> Guess:
        runs = [problem.multistart("batched", starts, seed + 100 + k) for k in range(RUNS)]
        unseen = np.array([len(problem.complete) - len(f) for f in runs])
        estimated = np.array([f.estimated_unseen or 0.0 for f in runs])
        return Guess(
            starts,
            float(unseen.mean()),
            float(estimated.mean()),
            float(np.mean((estimated < 1.0) & (unseen >= 1))),
        )


# --- report ---------------------------------------------------------------------------------------


def problems() -> list[Problem]:
    zhang, yao = symkin.load("zhang2009"), symkin.load("yao2020")
    return [
        Problem.of("zhang2009", zhang, {"joints": zhang.example.joints}),
        Problem.of("dietmaier1998", platform(), {"joints": LEGS}),
        Problem.of("yao2020", yao, {"pose": yao.example.pose}),
    ]


def report_trials(report: Report, problem: Problem, scale: float, seed: int) -> dict[str, Trial]:
    total = len(problem.complete)
    report.row(f"{problem.name}: complete set", None, statement(problem.complete))
    trials = {}
    for solver, (label, starts, _) in SOLVERS.items():
        trials[solver] = trial = Trial.of(problem, solver, max(2, round(scale * starts)), seed)
        what = f"{problem.name}, {label}, {trial.starts} starts"
        report.row(
            f"{what}: modes met of {total}; starts that reach one [%]; hits of the rarest mode "
            f"met; seconds",
            None,
            trial.facts,
        )
    report.row(
        f"{problem.name}: modes that only multistart found",
        0,
        sum(t.strangers for t in trials.values()),
    )
    return trials


def report_guesses(report: Report, problem: Problem, scale: float, seed: int) -> list[Guess]:
    guesses = [Guess.of(problem, max(2, round(scale * n)), seed) for n in SIZES]
    report.row(f"{problem.name}, batched starts", None, [g.starts for g in guesses])
    report.row(
        f"{problem.name}: unseen modes, in truth (mean of {RUNS} runs)",
        None,
        [g.unseen for g in guesses],
    )
    report.row(
        f"{problem.name}: unseen modes, multistart's own estimate",
        None,
        [round(g.estimated, 2) for g in guesses],
    )
    report.row(
        f"{problem.name}: runs that estimate less than one while some are unseen [%]",
        None,
        [100 * g.wrong for g in guesses],
    )
    return guesses


# --- picture --------------------------------------------------------------------------------------


def draw_coverage(axes, problem: Problem, trials: dict[str, Trial]) -> None:
    total = len(problem.complete)
    for solver, (label, _, colour) in SOLVERS.items():
        trial = trials[solver]
        n = np.unique(np.geomspace(1, trial.starts, 80).astype(int))
        share = [100 * trial.coverage(int(k)) / total for k in n]
        axes.semilogx(n, share, color=colour, lw=2.2, label=label)
        axes.plot(n[-1], share[-1], "o", color=colour, ms=5)
    axes.axhline(100, color="0.6", lw=1, ls="--")
    axes.set(xlabel="starts", ylim=(0, 108), title=f"{problem.name}: {total} modes")
    tidy(axes)


def draw_guesses(axes, guesses: list[Guess]) -> None:
    starts = [g.starts for g in guesses]
    axes.semilogx(
        starts,
        [g.unseen for g in guesses],
        "o-",
        color="0.15",
        lw=2.2,
        label="unseen modes, in truth",
    )
    axes.semilogx(
        starts,
        [g.estimated for g in guesses],
        "s--",
        color="#cc79a7",
        lw=2.2,
        label="multistart's estimate (Chao)",
    )
    highest = max([g.unseen for g in guesses] + [g.estimated for g in guesses] + [1.0])
    axes.set(xlabel="starts (batched)", ylim=(-0.04 * highest, 1.12 * highest))
    tidy(axes)


def tidy(axes) -> None:
    places = [n for n in (1, 10, 100, 1000) if axes.get_xlim()[0] <= n <= axes.get_xlim()[1]]
    axes.set_xticks(places, [str(n) for n in places])
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25)


def draw(found: list[tuple[Problem, dict[str, Trial], list[Guess]]]):
    figure = new_figure(15, 8.6)
    figure.suptitle(
        "What multistart misses: modes met, against the complete set", fontsize=15, weight="bold"
    )
    figure.get_layout_engine().set(hspace=0.06, wspace=0.05)
    upper, lower = figure.subplots(2, len(found))
    for k, (problem, trials, guesses) in enumerate(found):
        draw_coverage(upper[k], problem, trials)
        draw_guesses(lower[k], guesses)
    upper[0].set_ylabel("share of modes met [%]\n(mean over orders of the starts)")
    lower[0].set_ylabel(f"unseen modes\n(mean of {RUNS} runs)")
    figure.legend(
        *upper[0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=4,
        frameon=False,
        fontsize=10.5,
    )
    lower[1].legend(frameon=False, fontsize=10)
    return figure


def main() -> None:
    parser = options_parser(__doc__.split("\n\n")[0], SEED)
    parser.add_argument(
        "--scale", type=float, default=1.0, help="multiplies all numbers of starts (default: 1)"
    )
    options = parser.parse_args()
    report, found = Report("coverage", "What multistart misses", options.seed), []
    for problem in problems():
        trials = report_trials(report, problem, options.scale, options.seed)
        found.append(
            (problem, trials, report_guesses(report, problem, options.scale, options.seed))
        )
    report.finish(draw(found), options.output)


if __name__ == "__main__":
    main()
