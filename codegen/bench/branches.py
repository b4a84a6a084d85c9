"""Does NAME_OK mean the branch? Random goals, against a fine continuation of their lines in C of
its own.

For each goal the known values move along the straight line from the guess's in small steps
(walk.c); a line is regular where none of its steps has to be shorter than 1/25600 of it and no limb
passes a dead centre; what is OK on others must be right as well. The generated C is asked for the
same goals. Guesses: home for the first leg, for each of the next ones (`--legs`) an answer of the
one before, where that was right, and for a last leg configurations beside the folds at which lines
stopped.

Arms are asked for two kinds of goals more: from joints anywhere for poses of joints anywhere, and
for such at which lines graze folds, found by bisection with the walk itself.

    python codegen/bench/branches.py [NAME|FILE ...] [--count 2000] [--range PART,TURN] [--legs 2]
        [--real double] [--seed 0] [--write]

Without `--range`: three of them, small, middle and widest (goals.py). Every line on which OK was
wrong is printed, to be repeated. All lines that are OK are walked, and a fifth of the others, which
tell how many regular lines are OK. `machines/` holds mechanisms that are not shipped.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from asked import STATUSES, Asked
from directions import Direction, Outcome, direction_of
from goals import MIDDLE, SMALL, WIDEST, Reach
from readme import written
from subjects import machine_of
from symkin.codegen.map.options import Options
from symkin.model.mechanism import Mechanism

STUDIED = (
    *("zhang2009", "ren2008", "zhao2000", "zhao2000_links", "delta", "five_bar", "three_rrr"),
    *("three_rpr", "three_rps", "linear_delta", "orthoglide", "six_rss", "hexaglide"),
)
RANGES = {"small": SMALL, "middle": MIDDLE, "widest": WIDEST}
ARMS = {"anywhere": "anywhere", "folds": "towards_folds"}
"""Kinds of goals of arms, by the method that finds them."""
_BATCH = 4096
LETTERS = "OMSNRW"
"""Of the statuses, in the order of STATUSES: OUT_OF_RANGE is R, the others begin with theirs."""


@dataclass
class Found:
    """Counts of one study: goals, answers that are OK, wrong ones; of walked lines the regular
    ones, and their statuses.
    """

    goals: int = 0
    ok: int = 0
    wrong: int = 0
    steps: int = 0
    most_steps: int = 0
    seconds: float = 0.0
    regular: np.ndarray = field(default_factory=lambda: np.zeros(len(STATUSES)))
    """Regular lines by status, refused ones as many as those that were walked stand for."""
    said: list[str] = field(default_factory=list)

    @property
    def ok_of_regular(self) -> float:
        return float(100.0 * self.regular[0] / max(1.0, float(np.sum(self.regular))))

    def row(self, name: str, real: str, reach: str) -> str:
        refused = ", ".join(
            f"{STATUSES[k]} {self.regular[k]:,.0f}"
            for k in range(1, len(STATUSES))
            if self.regular[k] > 0.5
        )
        return (
            f"| {name} {real} | {reach} | {self.goals:,} | {self.ok:,} | {self.wrong} | "
            f"{self.ok_of_regular:.1f} % | {refused} | "
            f"{self.steps / max(1, self.goals):.1f} | {self.most_steps} |"
        )


def study(
    mechanism: Mechanism,
    options: Options,
    count: int,
    reach: Reach = MIDDLE,
    seed: int = 0,
    legs: int = 1,
    folds: bool = True,
) -> Found:
    """Asks the generated C for `count` random goals a leg, and compares what it calls OK with the
    fine continuation.
    """
    return studied(direction_of(Asked(mechanism, options)), count, reach, seed, legs, folds)


def studied(
    lines: Direction, count: int, reach: Reach | str, seed: int, legs: int, folds: bool = True
) -> Found:
    """The same of lines whose code is compiled once; of arms also of a kind of `ARMS`."""
    rng, found, begun = np.random.default_rng(seed), Found(), time.monotonic()
    if isinstance(reach, str):
        for first in range(0, count, _BATCH):
            begins, goals = getattr(lines, reach)(min(_BATCH, count - first), rng)
            _count(found, lines, lines.run(begins, goals, rng))
        found.seconds = time.monotonic() - begun
        return found
    for first in range(0, count, _BATCH):
        number = min(_BATCH, count - first)
        home = lines.home.repeated(number)
        starts, stopped = home, None
        for leg in range(legs + folds):
            if leg == legs and stopped is not None:
                starts = lines.beside_folds(stopped, home, rng)
            outcome = lines.run(starts, lines.goals(number, reach, rng), rng)
            stopped = outcome if leg == 0 else stopped
            _count(found, lines, outcome)
            starts = lines.after(outcome, home)
    found.seconds = time.monotonic() - begun
    return found


def statuses(lines: Direction, count: int, reach: Reach, seed: int, legs: int = 2) -> str:
    """The letter of the status of each goal, without a walk: of `count` from home, then as many
    from what was OK on the leg before.
    """
    rng, home = np.random.default_rng(seed), lines.home.repeated(count).guesses
    guesses, said = home, ""
    for _ in range(legs):
        answers = lines.answers(lines.goals(count, reach, rng), guesses)
        said += "".join(LETTERS[status] for status in answers.status)
        guesses = np.where((answers.status == 0)[:, None], answers.found, home)
    return said


def _count(found: Found, lines: Direction, outcome: Outcome) -> None:
    """Adds one batch to the counts, and says what is wrong in it."""
    ok, status, steps = outcome.ok, outcome.answers.status, outcome.answers.steps
    refused = outcome.regular & ~ok
    reached = lines.stated(outcome.ends.unknowns, outcome.goals)
    refused[refused] = lines.gives_back(reached[refused], outcome.goals[refused])
    stands_for = np.sum(~ok) / max(1, np.sum(outcome.walked & ~ok))
    found.regular[0] += np.sum(outcome.regular & ok)
    found.regular += stands_for * np.bincount(status[refused], minlength=len(STATUSES))
    found.goals, found.ok = found.goals + len(ok), found.ok + int(np.sum(ok))
    found.steps, found.most_steps = (
        found.steps + int(np.sum(steps)),
        max(found.most_steps, int(np.max(steps))),
    )
    for k in np.flatnonzero(ok & ~outcome.right):
        found.wrong += 1
        found.said.append(_said(lines, outcome, int(k), reached[k]))


def _said(lines: Direction, outcome: Outcome, k: int, reached: np.ndarray) -> str:
    """One wrong answer, with all that repeats it."""
    number = lines.asked.number
    guess, goal = (
        ", ".join(repr(float(v)) for v in number(values[k]))
        for values in (outcome.starts.guesses, outcome.goals)
    )
    what = (
        f"{lines.mechanism.name} {lines.real}: OK is wrong, goal [{goal}], guess "
        f"[{guess}], found {outcome.answers.found[k].tolist()}, "
    )
    if outcome.ends.shortest[k] > 0.0:
        return (
            f"{what}the line leads to {reached.tolist()} by steps of {outcome.ends.shortest[k]:.2g}"
        )
    return f"{what}the line ends at {outcome.ends.done[k]:.9f} of it"


def report(
    names: list[str],
    count: int,
    reals: list[str],
    seed: int,
    legs: int,
    ranges: dict[str, Reach | str],
) -> str:
    rows, seconds = [], 0.0
    for name in names:
        for real in reals:
            machine = machine_of(name)
            lines = direction_of(Asked(machine.mechanism, machine.options(real)))
            own = ARMS if machine.mechanism.serial and len(ranges) > 1 else {}
            for words, reach in (ranges | own).items():
                found = studied(lines, count, reach, seed, legs)
                rows.append(found.row(Path(name).stem, real, words))
                seconds += found.seconds
                print("\n".join([rows[-1] + f" {found.seconds:.0f} s", *found.said]), flush=True)
    table = [
        f"Seed {seed}, {count:,} goals a leg, {seconds / 60:.0f} minutes on one core.",
        "",
        "| solver | range | goals | OK | OK wrong | OK of regular lines | refused regular lines | "
        "mean steps | most steps |",
        "|---|---|---|---|---|---|---|---|---|",
        *rows,
    ]
    return "\n".join(table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", default=list(STUDIED))
    parser.add_argument(
        "--range",
        metavar="PART,TURN",
        help="how far goals lie from home: a part of the size, and rad; or a word of "
        + ", ".join(RANGES)
        + "; of arms "
        + ", ".join(ARMS),
    )
    parser.add_argument("--count", type=int, default=2000, help="goals a leg (default: 2000)")
    parser.add_argument(
        "--legs",
        type=int,
        default=2,
        help="lines that follow each other (default: 2); one more begins beside folds",
    )
    parser.add_argument(
        "--real", choices=("float", "double"), action="append", help="default: both"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--write", action="store_true", help="write the table into codegen/README.md"
    )
    chosen = parser.parse_args()
    given: dict[str, Reach | str] = dict(RANGES)
    if chosen.range in RANGES | ARMS:
        given = {chosen.range: (RANGES | ARMS)[chosen.range]}
    elif chosen.range:
        given = {chosen.range: Reach(*(float(number) for number in chosen.range.split(",")))}
    measured = report(
        chosen.names,
        chosen.count,
        chosen.real or ["double", "float"],
        chosen.seed,
        chosen.legs,
        given,
    )
    if chosen.write:
        written("branches", measured)
