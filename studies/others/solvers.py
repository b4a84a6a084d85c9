"""Inner solvers of multistart compared: batched Levenberg-Marquardt, Newton, fast Newton and IPOPT.

For each mechanism the same random starts (one seed) are given to `symkin.modes` with each solver. A
start succeeds when it ends in a solution; its success rate is hits / starts. The coverage curve is
the mean number of different modes met by n of the N starts, taken without replacement from the hits
h_i counted (Hurlbert 1971):

    E(n) = sum_i 1 - C(N - h_i, n) / C(N, n).

The modes that there are come from continuation. Times are those of this machine, one process, after
a warm-up call that builds the functions. The examples are the direct problems of zhang2009 and
zhao2000 and the inverse problems of gluon_6l3 (pose of 15 deg at each joint) and yao2020, as their
files state them. There is no paper to compare with.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from math import lgamma
from pathlib import Path

import numpy as np

import symkin

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.report import Report, folder_from_arguments, new_figure

SOLVERS = ("batched", "newton", "fast_newton", "ipopt")
STARTS = {"batched": 200, "newton": 200, "fast_newton": 200, "ipopt": 100}
NAMES = ("zhang2009", "zhao2000", "gluon_6l3", "yao2020")
SEED = 4
COLOURS = dict(zip(SOLVERS, ("#0072b2", "#d55e00", "#e69f00", "#009e73"), strict=True))


@dataclass(frozen=True)
class Trial:
    """One solver on one mechanism: hits of each mode found, number of starts, seconds."""

    hits: tuple[int, ...]
    starts: int
    seconds: float

    @property
    def success(self) -> float:
        return sum(self.hits) / self.starts

    @property
    def rate(self) -> float:
        return self.starts / self.seconds

    def coverage(self, n: int) -> float:
        """E(n), the mean number of modes met by n of the starts."""
        return sum(1 - never(self.starts, h, n) for h in self.hits)


def never(N: int, h: int, n: int) -> float:
    """C(N - h, n) / C(N, n): the chance that n of N starts miss all h hits."""
    if n > N - h:
        return 0.0
    log = lgamma(N - h + 1) - lgamma(N - h - n + 1) - lgamma(N + 1) + lgamma(N - n + 1)
    return float(np.exp(log))


def problem_of(name: str) -> tuple[symkin.Mechanism, dict]:
    """The mechanism and its example; an arm's example of joints becomes the inverse problem of
    their pose.
    """
    mechanism = symkin.load(name)
    example = mechanism.example
    if example.pose is not None:
        return mechanism, {"pose": example.pose}
    if mechanism.serial:
        return mechanism, {"pose": symkin.solve(mechanism, joints=example.joints).solution.pose}
    return mechanism, {"joints": example.joints}


def attempt(name: str, solver: str, starts: int) -> Trial:
    mechanism, given = problem_of(name)
    symkin.modes(mechanism, **given, starts=2, seed=SEED, solver=solver, method="multistart")
    found = symkin.modes(
        mechanism, **given, starts=starts, seed=SEED, solver=solver, method="multistart"
    )
    return Trial(tuple(mode.hits for mode in found), starts, found.elapsed_s)


def known_modes(name: str) -> int:
    mechanism, given = problem_of(name)
    return len(symkin.modes(mechanism, **given))


def run(report: Report) -> tuple[dict[str, int], dict[tuple[str, str], Trial]]:
    known = {name: known_modes(name) for name in NAMES}
    trials = {
        (name, solver): attempt(name, solver, STARTS[solver])
        for name in NAMES
        for solver in SOLVERS
    }
    for (name, solver), trial in trials.items():
        what = f"{name}, {solver}, {trial.starts} starts"
        report.row(f"{what}: modes found, of {known[name]} known", None, len(trial.hits))
        report.row(f"{what}: success rate", None, round(100 * trial.success, 1), "%")
        report.row(f"{what}: starts per second", None, float(f"{trial.rate:.3g}"), "1/s")
    return known, trials


def draw_bars(axes, trials: dict[tuple[str, str], Trial], key: str, label: str) -> None:
    width = 0.8 / len(SOLVERS)
    for k, solver in enumerate(SOLVERS):
        values = [
            getattr(trials[name, solver], key) * (100 if key == "success" else 1) for name in NAMES
        ]
        places = np.arange(len(NAMES)) + (k - (len(SOLVERS) - 1) / 2) * width
        bars = axes.bar(places, values, 0.92 * width, color=COLOURS[solver], label=solver)
        axes.bar_label(bars, fmt="%.0f", fontsize=8, padding=2)
    axes.set_xticks(range(len(NAMES)), NAMES)
    axes.set_ylabel(label)
    axes.spines[["top", "right"]].set_visible(False)


def draw_coverage(axes, name: str, known: int, trials: dict[tuple[str, str], Trial]) -> None:
    axes.axhline(known, color="0.6", lw=1, ls="--")
    styles = dict(zip(SOLVERS, ("-", "-", (0, (4, 2)), "-"), strict=True))
    for solver in SOLVERS:
        trial = trials[name, solver]
        n = np.unique(np.geomspace(1, trial.starts, 60).astype(int))
        axes.semilogx(
            n, [trial.coverage(int(k)) for k in n], color=COLOURS[solver], lw=2, ls=styles[solver]
        )
    axes.set(
        xlabel="starts",
        title=f"{name}: {known} modes",
        ylim=(0, 1.12 * known),
        yticks=range(0, known + 1, 1),
    )
    axes.set_xticks([1, 10, 100], ["1", "10", "100"])
    axes.spines[["top", "right"]].set_visible(False)


def draw(known: dict[str, int], trials: dict[tuple[str, str], Trial]):
    figure = new_figure(14, 8)
    figure.suptitle("Inner solvers of multistart: success, speed, and modes met", fontsize=14)
    figure.get_layout_engine().set(hspace=0.06, wspace=0.04)
    grid = figure.add_gridspec(2, 4)
    left, right = figure.add_subplot(grid[0, :2]), figure.add_subplot(grid[0, 2:])
    draw_bars(left, trials, "success", "starts that reach a solution [%]")
    draw_bars(right, trials, "rate", "starts per second [1/s]")
    right.set_yscale("log")
    left.set(ylim=(0, 122), yticks=range(0, 101, 20), title="Success")
    right.set_title("Speed")
    left.legend(ncols=4, frameon=False, loc="upper center")
    for k, name in enumerate(NAMES):
        axes = figure.add_subplot(grid[1, k])
        draw_coverage(axes, name, known[name], trials)
        if k == 0:
            axes.set_ylabel("modes met (mean over orders)")
    return figure


def main() -> None:
    folder = folder_from_arguments(__doc__.split("\n\n")[0])
    report = Report("solvers", "Multistart with four inner solvers", SEED)
    known, trials = run(report)
    report.finish(draw(known, trials), folder)


if __name__ == "__main__":
    main()
