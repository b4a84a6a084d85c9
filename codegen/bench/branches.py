"""Does OK of generated C mean the machine, on the branch of the guess, and can it be held?

    python codegen/bench/branches.py [NAME|FILE ...] [--given A,B --find C,D] [--all] [--random 0]
        [--part 1/1] [--range RANGE ...] [--count N] [--legs 2] [--steps 400] [--real double]
        [--seed 0] [--write]

Goals of a range are asked for, and each line from the guess's values to the goal is walked in small
steps by C of its own (walk.c). What is OK must be where the line leads; asked for once more, from
itself, it must be OK too, where the line is regular: none of its steps shorter than 1/25600 of it,
no limb past a dead centre. Ranges:

- small, middle, widest, or PART,TURN (of the size, rad): random goals about home in `--legs`, the
  next from an answer of the one before where that was right, one more from beside the folds at
  which lines stopped. A fifth of what is refused is walked, and tells how many regular lines are.
- anywhere, folds: of arms, from joints anywhere to poses of joints anywhere, and to such at which
  lines graze folds.
- paths: `--count` smooth paths in `--steps`, of maps both ways. Stuck is what is refused on a
  regular line far from singularities, to an answer that tells where it stands, no limb beside a
  dead centre. Anew is a map's answer whose values do not tell where the path stands: it begins at
  home again.
- grazes: lines to where the code refuses, and ever nearer (grazes.py). No OK there may be refused
  as a guess that is not even read.
- closes: values that the machine can take, and others, against the closures of
  tests/oracle/plain_*.py (closes.py); the folder's own test is run first.

Without `--range`: small, middle, widest, of arms anywhere and folds too. Without names: those of
README.md's table; `--all`: machines of all kinds, shipped or not, and maps, by default on paths,
grazes and closes; with `--random` random ones; `--part 1/4` every fourth. Whatever is wrong is
printed with all that repeats it. An interrupted run (Control-C) prints its table. Exit status 1
where anything is wrong, stuck, unread, does not stand still, or fails its own test.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from asked import STATUSES, Asked
from closes import closes
from continuation import LONGEST
from directions import HARD, PLAIN, Direction, Outcome, directions
from grazes import grazed
from ranges import ARMS, MIDDLE, RANGES, Reach, by_legs, goals_about, maker
from readme import table, written
from rows import Row
from subjects import STUDIED, drawn, machine_of, named
from symkin.codegen.folder.folder import write_folder
from symkin.errors import InputError

REALS = ("double", "float")
HELD = ("paths", "grazes", "closes")
"""Ranges of all kinds of machines."""
COUNTS = {"paths": 25, "grazes": 200, "closes": 60}
"""Goals of a leg, 2000 else."""
LETTERS = "OMSNRW"
"""Of the statuses, in the order of STATUSES: OUT_OF_RANGE is R, the others begin with theirs."""
OWN_TEST = "own test fails"
"""What a refusal says of code that was not written because its test fails."""
SECONDS = 150
"""Processor time after which a machine is left out of a range: formulas of random ones may be
long.
"""


def study(
    asked: Asked,
    count: int,
    reach: Reach = MIDDLE,
    seed: int = 0,
    legs: int = 1,
    folds: bool = True,
) -> Row:
    """What random goals about home come to, `count` a leg."""
    lines, rng = directions(asked)[0], np.random.default_rng(seed)
    return judged(lines, by_legs(lines, count, rng, reach, legs, folds))


def judged(lines: Direction, outcomes: Iterable[Outcome]) -> Row:
    """Counts of all outcomes, and what is wrong in them."""
    row = Row()
    for outcome in outcomes:
        row.add(_counted(lines, outcome))
    return row


def _counted(lines: Direction, outcome: Outcome) -> Row:
    ok, ends, goals = outcome.ok, outcome.ends, outcome.goals
    status, found, steps = outcome.answers
    reached = lines.stated(ends.unknowns, goals)
    refused = outcome.regular & ~ok
    refused[refused] = lines.gives_back(reached[refused], goals[refused])
    row = Row(len(ok), int(np.sum(ok)), steps=int(steps.sum()), most_steps=int(steps.max()))
    stands_for = np.sum(~ok) / max(1, np.sum(outcome.walked & ~ok))
    row.regular = stands_for * np.bincount(status[refused], minlength=len(STATUSES))
    row.regular[0] += np.sum(outcome.regular & ok)
    told = lines.tells(np.where(ok[:, None], found, reached), goals)
    row.anew = int(np.sum(outcome.right & ~told))
    again = lines.answers(goals, np.where(ok[:, None], found, outcome.starts.guesses)).status
    wrong = {
        "wrong": ok & ~outcome.right,
        "moved": outcome.right & outcome.regular & told & (again != 0),
        "stuck": _stuck(lines, outcome, reached, refused),
    }
    for what, which in wrong.items():
        setattr(row, what, int(which.sum()))
        row.said += [_said(lines, outcome, what, int(k), reached[k]) for k in np.flatnonzero(which)]
    return row


def _stuck(
    lines: Direction, outcome: Outcome, reached: np.ndarray, refused: np.ndarray
) -> np.ndarray:
    """Refused lines on which a controller would be locked up."""
    ends, goals = outcome.ends, outcome.goals
    stuck = refused & (ends.shortest >= PLAIN)
    if stuck.any():
        stuck &= lines.problem.system.conditions(ends.unknowns, goals) < HARD
        # an answer that could not be left again, because the code does not read it, is rightly
        # refused
        stuck &= lines.is_firm(ends.unknowns, goals) & lines.tells(reached, goals, easily=True)
    return stuck


def _said(lines: Direction, outcome: Outcome, what: str, k: int, reached: np.ndarray) -> str:
    """One wrong answer, with all that repeats it."""
    guess, goal = (
        ", ".join(repr(float(v)) for v in lines.asked.number(values[k]))
        for values in (outcome.starts.guesses, outcome.goals)
    )
    ends, name = outcome.ends, lines.asked.mechanism.name
    told = f"{name} {lines.real}: {what}, goal [{goal}], guess [{guess}], "
    told += f"{STATUSES[outcome.answers.status[k]]} {outcome.answers.found[k].tolist()}"
    if ends.shortest[k] > 0.0:
        return f"{told}, the line leads to {reached.tolist()} by steps of {ends.shortest[k]:.2g}"
    return f"{told}, the line ends at {ends.done[k]:.9f} of it"


def statuses(lines: Direction, count: int, reach: Reach, seed: int, legs: int = 2) -> str:
    """The letter of the status of each goal, without a walk: of `count` from home, then as many
    from what was OK on the leg before.
    """
    rng, home = np.random.default_rng(seed), lines.home.repeated(count).guesses
    guesses, said = home, ""
    for _ in range(legs):
        answers = lines.answers(goals_about(lines, count, reach, rng), guesses)
        said += "".join(LETTERS[status] for status in answers.status)
        guesses = np.where((answers.status == 0)[:, None], answers.found, home)
    return said


# --- the campaign ---------------------------------------------------------------------------------


@dataclass
class Campaign:
    """What the options ask, and the rows that it came to, by machine or way of solving, type and
    range.
    """

    chosen: argparse.Namespace
    rows: dict[tuple[str, str, str], Row] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)

    def ask(self, machine: Asked, label: str) -> None:
        """Ask one machine's code of each type in each range; what is not in time is left out."""
        for asked in map(machine.of, self.chosen.real):
            for word in self._ranges(asked):
                name = f"{asked.mechanism.name} {asked.options.real}"
                signal.setitimer(signal.ITIMER_PROF, 0 if label else SECONDS)
                try:
                    for key, row in self._rows(asked, word):
                        kind = label or key, asked.options.real, word
                        self.rows.setdefault(kind, Row()).add(row)
                        told = (f"{head} {cell}" for head, cell in row.cells().items() if cell)
                        print(f"{name} {word}", *told, sep=", ", flush=True)
                        print("".join(f"    {words}\n" for words in row.said), end="", flush=True)
                except (InputError, TimeoutError) as reason:
                    print(f"{name} {word}: left out: {str(reason)[:200]}", flush=True)
                    self.failed += [name] if OWN_TEST in str(reason) else []
                finally:
                    signal.setitimer(signal.ITIMER_PROF, 0.0)

    def _ranges(self, asked: Asked) -> list[str]:
        if self.chosen.range:
            return [w for w in self.chosen.range if w not in ARMS or asked.kind == "arm"]
        if self.chosen.all or asked.kind == "map":
            return list(HELD)
        return [*RANGES, *(ARMS if asked.kind == "arm" else ())]

    def _rows(self, asked: Asked, word: str) -> Iterator[tuple[str, Row]]:
        """What solves a problem, and what the range came to, of a map both ways."""
        count = self.chosen.count or COUNTS.get(word, 2000)
        rng = np.random.default_rng(self.chosen.seed)
        if word == "closes":
            with tempfile.TemporaryDirectory() as folder:
                write_folder(asked.mechanism, Path(folder), asked.options)
            yield asked.kind, closes(asked, count, rng)
            return
        for lines in directions(asked, PLAIN if word in HELD else LONGEST):
            rng = np.random.default_rng(self.chosen.seed)
            if word == "grazes":
                yield lines.solved_by, grazed(lines, count, rng)
            else:
                outcomes = maker(word, self.chosen.legs, self.chosen.steps)
                yield lines.solved_by, judged(lines, outcomes(lines, count, rng))

    def table(self) -> str:
        """All rows, and their sum."""
        total = Row()
        for row in self.rows.values():
            total.add(row)
        rows = {**dict(sorted(self.rows.items())), ("all", "", ""): total}
        cells = [dict(zip(("", "type", "range"), key, strict=True)) for key in rows]
        return table([a | row.cells() for a, row in zip(cells, rows.values(), strict=True)])

    @property
    def is_good(self) -> bool:
        return not self.failed and all(row.is_good for row in self.rows.values())


def machines_of(chosen: argparse.Namespace, scratch: Path) -> Iterator[tuple[Asked, str]]:
    """The named machines with their names; else all kinds, random ones among them, told by what
    solves their problems.
    """
    if not chosen.all and not chosen.random:
        for name in chosen.names or STUDIED:
            yield machine_of(name, chosen.given, chosen.find), Path(name).stem
        return
    number, count = (int(v) for v in chosen.part.split("/"))
    every = [*(named() if chosen.all else ()), *islice(drawn(chosen.seed, scratch), chosen.random)]
    for machine in every[number - 1 :: count]:
        yield machine, ""


def _late(*_: object) -> None:
    raise TimeoutError("not in time")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*")
    parser.add_argument("--given")
    parser.add_argument("--find")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--range", nargs="*", metavar="RANGE")
    for option, usual in (("count", 0), ("legs", 2), ("steps", 400), ("seed", 0)):
        parser.add_argument(f"--{option}", type=int, default=usual)
    parser.add_argument("--real", nargs="*", choices=REALS, default=list(REALS))
    parser.add_argument("--write", action="store_true", help="the table of codegen/README.md")
    chosen = parser.parse_args()
    signal.signal(signal.SIGPROF, _late)
    campaign = Campaign(chosen)
    with tempfile.TemporaryDirectory() as scratch:
        try:
            for machine, label in machines_of(chosen, Path(scratch)):
                campaign.ask(machine, label)
        except KeyboardInterrupt:
            print("interrupted")
    print(campaign.table())
    print(f"own tests that fail: {', '.join(campaign.failed) or 'none'}")
    if chosen.write:
        told = f"Seed {chosen.seed}, {chosen.count or 2000:,} goals a leg."
        written("branches", f"{told}\n\n{campaign.table()}")
    return 0 if campaign.is_good else 1


if __name__ == "__main__":
    sys.exit(main())
