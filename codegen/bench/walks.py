"""Do controllers that call the generated C a thousand times a second get stuck, or lost? Smooth
random walks, standing still, and grazing.

    python codegen/bench/walks.py [NAME|FILE ...] [--given A,B --find C,D] [--paths 25]
        [--steps 400] [--lines 200] [--random 10] [--seed 0] [--real float] [--part 1/4]

Without names: machines of all kinds (closes.py), maps both ways; `--part 1/4`: every fourth of
them. Goals move on smooth random paths within limits. Each goal is asked for from the last answer
that was OK, then once more from its own answer: standing still must be OK. Beside it the same lines
are walked finely (walk.c) from the last configuration that was OK. The guess of a map holds one
side's values only: where these do not lead from home to where a path stands, it begins anew. Wrong
is an OK on a line that is not regular, or that leads elsewhere; stuck is a regular line, far from
singularities, to an answer that tells where it stands, no limb beside a dead centre, and of a map
by a line that is far from them too, that is refused. Then `--lines` lines go to where the code
refuses, and ever nearer (grazes.py): no OK there may be refused as a guess. An
interrupted run (Control-C) prints its table. Exit status 1 where anything is wrong, stuck, does not
stand still or is not read.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from asked import Machine
from closes import drawn, late, named
from directions import (
    HARD,
    OUT_OF_RANGE,
    PLAIN,
    REGULAR,
    Direction,
    Starts,
    directions,
    paths_of,
)
from grazes import Grazes, grazed
from symkin.errors import InputError
from symkin.formats.load import load

_SHOWN = 4
"""Examples of a machine that are printed."""
_SECONDS = 150
"""Time after which a machine is left out: formulas of random ones may be long."""


@dataclass
class Tally:
    """What came of walks: steps, OK, paths that begin anew at home because a guess does not tell
    where they stand, wrong OKs, refused ones that are regular, and OKs that do not stand still.
    """

    steps: int = 0
    ok: int = 0
    anew: int = 0
    wrong: int = 0
    stuck: int = 0
    moved: int = 0
    examples: list[str] = field(default_factory=list)


def walked(direction: Direction, paths: int, steps: int, rng: np.random.Generator) -> Tally:
    """Follow random paths."""
    tally, at = Tally(), direction.home.repeated(paths)
    goals = direction.asked.rounded(paths_of(direction, paths, steps, rng))
    for goal in goals:
        at = _step(direction, at, goal, tally)
    return tally


def _step(direction: Direction, at: Starts, goal: np.ndarray, tally: Tally) -> Starts:
    """Ask for the next goal of each path, judge the answers, and go on from those that are
    right.
    """
    status, found, _ = direction.answers(goal, at.guesses)
    begin, end = direction.line(at.known, goal)
    ends = direction.walker.reached(at.unknowns, begin, end)
    ok, regular, reached = (
        status == 0,
        ends.shortest >= REGULAR,
        direction.stated(ends.unknowns, end),
    )
    away = np.where(ok, direction.off(found, reached), 0.0)
    conditions = direction.problem.system.conditions(ends.unknowns, end)
    rounding = 64 * direction.epsilon * np.minimum(conditions, 1e6)
    allowed = 2e-7 + rounding + 2e-3 * (direction.real == "float")
    wrong = ok & ((ends.shortest <= 0.0) | (away > allowed))
    easy = regular & (conditions < HARD) & (ends.shortest >= PLAIN)
    stuck = ~ok & (status != OUT_OF_RANGE) & easy
    told = direction.tells(np.where(ok[:, None], found, reached), end)
    stuck &= direction.gives_back(reached, end) & direction.is_firm(ends.unknowns, end)
    # an answer that could not be left again, because the code does not read it, is rightly refused
    stuck &= direction.tells(reached, end, easily=True)
    again = direction.answers(goal, np.where(ok[:, None], found, at.guesses)).status
    moved = ok & ~wrong & (again != 0) & regular & told
    tally.steps, tally.ok = tally.steps + len(goal), tally.ok + int(ok.sum())
    for what, which in (("wrong", wrong), ("stuck", stuck), ("moved", moved)):
        setattr(tally, what, getattr(tally, what) + int(which.sum()))
        tally.examples += [
            f"{what}: from {at.guesses[k].tolist()} ({begin[k].tolist()}) to {end[k].tolist()}: "
            f"status {status[k]}, again {again[k]}, "
            f"{found[k].tolist()}; walked {reached[k].tolist()}, shortest {ends.shortest[k]:.2g}, "
            f"condition {conditions[k]:.2g}"
            for k in np.flatnonzero(which)[:1]
        ]
    new = Starts(ends.unknowns, end, found).where(ok & ~wrong, at)
    untold = ok & ~wrong & ~told
    tally.anew += int(untold.sum())
    return direction.home.where(untold, new)


@dataclass
class Row:
    """Sums of what solves problems in one way, in one type of numbers."""

    machines: set[str] = field(default_factory=set)
    walks: Tally = field(default_factory=Tally)
    grazes: Grazes = field(default_factory=Grazes)

    def add(self, name: str, walks: Tally, grazes: Grazes) -> None:
        self.machines.add(name)
        for whole, part in ((self.walks, walks), (self.grazes, grazes)):
            for key, value in vars(part).items():
                if isinstance(value, int):
                    setattr(whole, key, getattr(whole, key) + value)

    @property
    def failures(self) -> int:
        return self.walks.wrong + self.walks.stuck + self.walks.moved + self.grazes.unread

    def cells(self) -> list[str]:
        w, g = self.walks, self.grazes
        numbers = (
            len(self.machines),
            w.steps,
            w.ok,
            w.anew,
            w.wrong,
            w.stuck,
            w.moved,
            g.ok,
            g.moved,
            g.unread,
            g.lost,
        )
        return [f"{n:,}" for n in numbers]


_HEAD = (
    "| solved by | type | machines | steps | OK | anew | wrong | stuck | moved | "
    "beside refusals OK | moved | not read | lost |"
)


def table(rows: dict[tuple[str, str], Row]) -> str:
    """The summary, one line a way of solving and type, and all together."""
    total = Row()
    for row in rows.values():
        for name in row.machines:
            total.machines.add(name)
        total.add(next(iter(row.machines)), row.walks, row.grazes)
    lines = [
        f"| {' | '.join([*key, *row.cells()])} |"
        for key, row in (*sorted(rows.items()), (("all", ""), total))
    ]
    return "\n".join([_HEAD, "|" + "---|" * _HEAD[1:].count("|"), *lines])


def machines_of(chosen: argparse.Namespace, scratch: Path) -> Iterator[Machine]:
    """The named machines, else all that closes.py knows, and random ones, of which a part may be
    chosen.
    """
    if chosen.names:
        given, find = (tuple(v.split(",")) if v else () for v in (chosen.given, chosen.find))
        yield from (Machine(load(n), given, find) for n in chosen.names)
        return
    number, count = (int(v) for v in chosen.part.split("/"))
    machines = [
        *named(),
        *(m for m, _ in zip(drawn(chosen.seed, scratch), range(chosen.random), strict=False)),
    ]
    yield from machines[number - 1 :: count]


def run(
    machine: Machine, real: str, chosen: argparse.Namespace, rows: dict[tuple[str, str], Row]
) -> None:
    """Walk one machine's code in one type, and print what comes of it."""
    name = machine.mechanism.name
    signal.alarm(_SECONDS)
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = directions(machine, real, Path(folder))
        for way, direction in zip(("direct", "inverse"), found, strict=False):
            rng = np.random.default_rng(chosen.seed)
            walks, grazes = (
                walked(direction, chosen.paths, chosen.steps, rng),
                grazed(direction, chosen.lines, rng),
            )
            rows.setdefault((direction.solved_by, real), Row()).add(name, walks, grazes)
            one = Row()
            one.add(name, walks, grazes)
            said = [f"\n    {e}" for e in (*walks.examples[:_SHOWN], *grazes.examples[:_SHOWN])]
            print(
                f"| {name} {way if len(found) > 1 else ''} | {real} | {' | '.join(one.cells())} |",
                *said,
                flush=True,
            )
    except (InputError, TimeoutError) as reason:
        print(f"{name} {real}: left out: {str(reason)[:120]}", flush=True)
    finally:
        signal.alarm(0)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*")
    parser.add_argument("--given")
    parser.add_argument("--find")
    parser.add_argument("--paths", type=int, default=25)
    parser.add_argument("--steps", type=int, default=400)
    parser.add_argument("--lines", type=int, default=200)
    parser.add_argument("--random", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--real", choices=("float", "double"))
    parser.add_argument("--part", default="1/1")
    chosen = parser.parse_args()
    signal.signal(signal.SIGALRM, late)
    rows: dict[tuple[str, str], Row] = {}
    with tempfile.TemporaryDirectory() as scratch:
        try:
            for machine in machines_of(chosen, Path(scratch)):
                for real in (chosen.real,) if chosen.real else ("float", "double"):
                    run(machine, real, chosen, rows)
        except KeyboardInterrupt:
            print("interrupted")
    print(table(rows))
    return 1 if any(row.failures for row in rows.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
