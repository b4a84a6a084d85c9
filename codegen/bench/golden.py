"""Golden figures of generated C: operations of each function, and which goals are accepted and
refused.

    python codegen/bench/golden.py [MACHINE ...] [--write]

tests/data/golden_counts.toml holds them for 25 machines in float and double; each difference is
told. `--write` accepts what is found: of the machines that are named, or of all. Operations are
those that headers state, counted in the text that was written, so that no processor and no library
changes them. Statuses are those of fixed goals (ranges.py), a letter a goal.
"""

from __future__ import annotations

import argparse
import json
import sys
import tomllib
from collections.abc import Mapping
from itertools import product

import numpy as np

from directions import Direction, directions
from generate import REALS
from processors import BENCH
from ranges import RANGES, Reach, goals_about
from subjects import GOLDEN as MACHINES
from subjects import machine_of

GOLDEN = BENCH.parents[1] / "tests" / "data" / "golden_counts.toml"
COLUMNS = ("iterations", "additions", "multiplications", "divisions", "sqrt", "sin", "cos", "atan2")
LETTERS = "OMSNRW"
"""Of the statuses, in the order of STATUSES: OUT_OF_RANGE is R, the others begin with theirs."""
GOALS = 30
"""Goals a leg and range."""
LEGS = 2
_TOLD = 8
"""Changed goals that a sentence names."""
SEED = 42
_HEAD = f"""\
# What `python codegen/bench/golden.py --write` found of the generated C, for comparison.
#
# [operations.MACHINE.TYPE]: of each function the most that a call without a config takes:
#   {", ".join(COLUMNS)}; "-": no bound
# [statuses.MACHINE.TYPE]: of each range of goals a letter a goal,
#   {GOALS} from home and {GOALS} from what was OK of these:
#   O OK, M MAX_ITERATIONS, S SINGULAR, N NONFINITE, R OUT_OF_RANGE, W WRONG_BRANCH
"""

Figures = Mapping[str, Mapping[str, list[int] | str]]
"""Of one machine's C: `operations` of each function, the COLUMNS or "-", and `statuses` of each
range.
"""


def found(machine: str, real: str) -> Figures:
    """The figures of one machine's C as it is written now; maps between joints have no lines to ask
    for.
    """
    asked = machine_of(machine).of(real)
    operations = {
        function: [b.iterations, *(b.operations.get(name, 0) for name in COLUMNS[1:])] if b else "-"
        for function, b in asked.program.worst.usual.items()
    }
    lines = directions(asked)[0]
    ranges = {} if asked.kind == "map" else RANGES
    said = {words: statuses(lines, reach) for words, reach in ranges.items()}
    return {"operations": operations, "statuses": said}


def statuses(lines: Direction, reach: Reach) -> str:
    """The letter of the status of each goal: of GOALS from home, then as many from what was OK on
    the leg before.
    """
    rng, home = np.random.default_rng(SEED), lines.home.repeated(GOALS).guesses
    guesses, said = home, ""
    for _ in range(LEGS):
        answers = lines.answers(goals_about(lines, GOALS, reach, rng), guesses)
        said += "".join(LETTERS[status] for status in answers.status)
        guesses = np.where((answers.status == 0)[:, None], answers.found, home)
    return said


def kept() -> dict[str, dict[str, Figures]]:
    """What the golden file says: machine, type of numbers, figures."""
    text = tomllib.loads(GOLDEN.read_text())
    return {
        machine: {
            real: {key: text[key].get(machine, {}).get(real, {}) for key in text} for real in parts
        }
        for machine, parts in text["operations"].items()
    }


def accepting(machine: str) -> str:
    """How a difference is accepted."""
    return f"`python codegen/bench/golden.py {machine} --write` accepts it"


def differences(machine: str, real: str, old: Figures | None, new: Figures) -> list[str]:
    """A sentence for each figure that is another one now, and how it is accepted."""
    if old is None:
        return [f"{machine} {real} has no golden figures; {accepting(machine)}"]
    told = {
        f"{name}{' goals' if key == 'statuses' else ''}": change(
            old[key].get(name), new[key].get(name)
        )
        for key in new
        for name in dict.fromkeys([*old[key], *new[key]])
    }
    accepts = accepting(machine)
    return [
        f"{machine} {real}, {what}: {words}; {accepts}" for what, words in told.items() if words
    ]


def change(before: list[int] | str | None, now: list[int] | str | None) -> str:
    """What is told of operations of a function, or of letters of a range, that are others now."""
    if before == now:
        return ""
    if before is None or now is None:
        return "is new" if before is None else "is there no more"
    if "-" in (before, now):
        return "has no bound any more" if now == "-" else "is bounded now"
    if len(before) != len(now):
        return f"{len(before)} -> {len(now)} of them"
    changed = [(k, b, n) for k, (b, n) in enumerate(zip(before, now, strict=True)) if b != n]
    if not (isinstance(before, str) and isinstance(now, str)):
        return ", ".join(f"{b} -> {n} {COLUMNS[k]}" for k, b, n in changed)
    told = [f"number {k} {b} -> {n}" for k, b, n in changed[:_TOLD]]
    told += [f"{len(changed) - _TOLD} more"] if len(changed) > _TOLD else []
    counts = ((x, before.count(x), now.count(x)) for x in LETTERS)
    in_all = ", ".join(f"{b} -> {n} {x}" for x, b, n in counts if b != n)
    return f"{', '.join(told)}; in all {in_all or 'as many of each status'}"


def golden_text(figures: Mapping[str, Mapping[str, Figures]]) -> str:
    """The golden file."""
    lines = [_HEAD]
    parts = ((m, real, part) for m in sorted(figures) for real, part in sorted(figures[m].items()))
    for machine, real, part in parts:
        for key, rows in part.items():
            if rows:
                said = [f"{name} = {json.dumps(row)}" for name, row in rows.items()]
                lines += [f"[{key}.{machine}.{real}]", *said, ""]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description="Compare the generated C with its golden figures.")
    parser.add_argument("machines", nargs="*", metavar="MACHINE", help="default: all of them")
    parser.add_argument("--write", action="store_true", help=f"accept what is found: {GOLDEN.name}")
    given, old, told = parser.parse_args(), kept(), 0
    if unknown := sorted(set(given.machines) - set(MACHINES)):
        parser.error(f"{', '.join(unknown)}: no such machine; there are {', '.join(MACHINES)}")
    figures = {machine: dict(parts) for machine, parts in old.items() if machine in MACHINES}
    for machine, real in product(given.machines or MACHINES, REALS):
        new = found(machine, real)
        said = differences(machine, real, old.get(machine, {}).get(real), new)
        print("\n".join(said or [f"{machine} {real}: as it was"]), flush=True)
        figures.setdefault(machine, {})[real], told = new, told + len(said)
        if given.write:
            GOLDEN.write_text(golden_text(figures))
    return 1 if told and not given.write else 0


if __name__ == "__main__":
    sys.exit(main())
