"""Golden figures of generated C: operations of each function, and which goals are accepted and
refused.

    python codegen/bench/golden.py [MACHINE ...] [--write]

tests/data/golden_counts.toml holds them for 25 machines in float and double; each difference is
told. `--write` accepts what is found: of the machines that are named, or of all. Operations are
those that headers state, counted in the text that was written, so that no processor and no library
changes them. Statuses are those of fixed goals (branches.py), a letter a goal.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from asked import Asked
from branches import LETTERS, REALS, statuses
from directions import direction_of
from ranges import RANGES
from subjects import GOLDEN as MACHINES
from subjects import machine_of

BENCH = Path(__file__).parent
GOLDEN = BENCH.parents[1] / "tests" / "data" / "golden_counts.toml"
COLUMNS = ("iterations", "additions", "multiplications", "divisions", "sqrt", "sin", "cos", "atan2")
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


Row = tuple[int, ...] | None
"""Of a function its COLUMNS; None where the text tells no bound."""


@dataclass(frozen=True)
class Figures:
    """Operations of each function, and statuses of each range."""

    operations: Mapping[str, Row]
    statuses: Mapping[str, str]


def found(machine: str, real: str) -> Figures:
    """The figures of one machine's C as it is written now; maps between joints have no lines to ask
    for.
    """
    made = machine_of(machine)
    asked = Asked(made.mechanism, made.options(real))
    operations = {
        function: bound
        and (bound.iterations, *(bound.operations.get(name, 0) for name in COLUMNS[1:]))
        for function, bound in asked.program.worst.usual.items()
    }
    lines = None if made.given else direction_of(asked)
    ranges = RANGES.items() if lines else ()
    said = {words: statuses(lines, GOALS, reach, SEED, LEGS) for words, reach in ranges}
    return Figures(operations, said)


def kept() -> dict[str, dict[str, Figures]]:
    """What the golden file says: machine, type of numbers, figures."""
    text = tomllib.loads(GOLDEN.read_text()) if GOLDEN.exists() else {}
    said = text.get("statuses", {})
    return {
        machine: {
            real: Figures(
                {function: None if row == "-" else tuple(row) for function, row in part.items()},
                said.get(machine, {}).get(real, {}),
            )
            for real, part in parts.items()
        }
        for machine, parts in text.get("operations", {}).items()
    }


def differences(machine: str, real: str, old: Figures | None, new: Figures) -> list[str]:
    """A sentence for each figure that is another one now, and how it is accepted."""
    accepts = f"`python codegen/bench/golden.py {machine} --write` accepts it"
    if old is None:
        return [f"{machine} {real} has no golden figures; {accepts}"]
    functions = dict.fromkeys([*old.operations, *new.operations])
    told = [
        *(
            (f, _operations(old.operations.get(f, ()), new.operations.get(f, ())))
            for f in functions
        ),
        *(
            (f"{w} goals", _goals(old.statuses.get(w, ""), said))
            for w, said in new.statuses.items()
        ),
    ]
    return [f"{machine} {real}, {what}: {words}; {accepts}" for what, words in told if words]


def _operations(before: Row, now: Row) -> str:
    """What is told of a function's operations; () where there is no such function."""
    if before == now:
        return ""
    if before == ():
        return "the function is new"
    if now == ():
        return "there is no such function any more"
    if before is None or now is None:
        return f"its operations {'have no bound any more' if before else 'are bounded now'}"
    return _changes(zip(COLUMNS, before, now, strict=True))


def _changes(counts: Iterable[tuple[str, int, int]]) -> str:
    return ", ".join(f"{b} -> {n} {name}" for name, b, n in counts if b != n)


def _goals(before: str, now: str) -> str:
    """What is told of the statuses of a range's goals."""
    if len(before) != len(now):
        return f"{len(before)} -> {len(now)} of them"
    pairs = enumerate(zip(before, now, strict=True))
    changed = [f"number {k} {b} -> {n}" for k, (b, n) in pairs if b != n]
    if not changed:
        return ""
    counts = _changes((x, before.count(x), now.count(x)) for x in LETTERS)
    more = [f"{len(changed) - _TOLD} more"] if len(changed) > _TOLD else []
    told = ", ".join([*changed[:_TOLD], *more])
    return f"{told}; in all {counts or 'as many of each status'}"


def golden_text(figures: Mapping[str, Mapping[str, Figures]]) -> str:
    """The golden file."""
    lines = [_HEAD]
    parts = ((m, real, part) for m in sorted(figures) for real, part in sorted(figures[m].items()))
    for machine, real, part in parts:
        rows = {f: '"-"' if row is None else str(list(row)) for f, row in part.operations.items()}
        lines += [
            f"[operations.{machine}.{real}]",
            *(f"{f} = {row}" for f, row in rows.items()),
            "",
        ]
        if part.statuses:
            said = (f'{w} = "{letters}"' for w, letters in part.statuses.items())
            lines += [f"[statuses.{machine}.{real}]", *said, ""]
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
