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
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asked import Asked
from branches import LETTERS, REALS, statuses
from directions import direction_of
from ranges import RANGES
from subjects import machine_of
from symkin.codegen.operation_bound import Bound

BENCH = Path(__file__).parent
GOLDEN = BENCH.parents[1] / "tests" / "data" / "golden_counts.toml"
COLUMNS = ("iterations", "additions", "multiplications", "divisions", "sqrt", "sin", "cos", "atan2")
GOALS = 30
"""Goals a leg and range."""
LEGS = 2
_TOLD = 8
"""Changed goals that a sentence names."""
SEED = 42
MACHINES = (
    *("delta", "gluon_6l3", "ren2008", "scara", "ur5e", "yao2020"),
    *("zhang2009", "zhao2000", "zhao2000_links", "five_bar", "hexaglide", "linear_delta"),
    *("orthoglide", "six_rss", "three_rpr", "three_rps", "three_rrr", "tricept"),
    *("ankle", "excavator_bucket", "four_bar", "slider_crank", "spherical_wrist"),
    *("stephenson_six_bar", "watt_six_bar"),
)
_HEAD = f"""\
# What `python codegen/bench/golden.py --write` found of the generated C, for comparison.
#
# [operations.MACHINE.TYPE]: of each function the most that a call without a config takes:
#   {", ".join(COLUMNS)}; "-": no bound
# [statuses.MACHINE.TYPE]: of each range of goals a letter a goal,
#   {GOALS} from home and {GOALS} from what was OK of these:
#   O OK, M MAX_ITERATIONS, S SINGULAR, N NONFINITE, R OUT_OF_RANGE, W WRONG_BRANCH
"""


@dataclass(frozen=True)
class Figures:
    """Operations of each function (COLUMNS; None where the text tells no bound), and statuses of
    each range.
    """

    operations: Mapping[str, tuple[int, ...] | None]
    statuses: Mapping[str, str]


def found(machine: str, real: str) -> Figures:
    """The figures of one machine's C as it is written now; maps between joints have no lines to ask
    for.
    """
    made = machine_of(machine)
    asked = Asked(made.mechanism, made.options(real))
    operations = {function: _row(bound) for function, bound in asked.program.worst.usual.items()}
    if made.given:
        return Figures(operations, {})
    lines = direction_of(asked)
    said = {words: statuses(lines, GOALS, reach, SEED, LEGS) for words, reach in RANGES.items()}
    return Figures(operations, said)


def _row(bound: Bound | None) -> tuple[int, ...] | None:
    return (
        None
        if bound is None
        else (bound.iterations, *(bound.operations.get(name, 0) for name in COLUMNS[1:]))
    )


def kept() -> dict[str, dict[str, Figures]]:
    """What the golden file says: machine, type of numbers, figures."""
    text = tomllib.loads(GOLDEN.read_text()) if GOLDEN.exists() else {}
    return {
        machine: {
            real: Figures(_rows(part), text.get("statuses", {}).get(machine, {}).get(real, {}))
            for real, part in parts.items()
        }
        for machine, parts in text.get("operations", {}).items()
    }


def _rows(part: Mapping[str, Any]) -> dict[str, tuple[int, ...] | None]:
    return {function: None if row == "-" else tuple(row) for function, row in part.items()}


def differences(machine: str, real: str, old: Figures | None, new: Figures) -> list[str]:
    """A sentence for each figure that is another one now."""
    if old is None:
        return [f"{machine} {real} has no golden figures; {accepting(machine)}"]
    told = [*_operation_differences(old, new), *_status_differences(old, new)]
    return [f"{machine} {real}, {words}; {accepting(machine)}" for words in told]


def accepting(machine: str) -> str:
    """How a difference is accepted."""
    return f"`python codegen/bench/golden.py {machine} --write` accepts it"


def _operation_differences(old: Figures, new: Figures) -> Iterator[str]:
    for function in dict.fromkeys([*old.operations, *new.operations]):
        before, now = (figures.operations.get(function, ()) for figures in (old, new))
        if before == ():
            yield f"{function}: the function is new"
        elif now == ():
            yield f"{function}: there is no such function any more"
        elif before is None or now is None:
            if before != now:
                yield (
                    f"{function}: its operations "
                    f"{'are bounded now' if before is None else 'have no bound any more'}"
                )
        else:
            changed = [
                f"{b} -> {n} {name}"
                for name, b, n in zip(COLUMNS, before, now, strict=True)
                if b != n
            ]
            if changed:
                yield f"{function}: {', '.join(changed)}"


def _status_differences(old: Figures, new: Figures) -> Iterator[str]:
    for words in dict.fromkeys([*old.statuses, *new.statuses]):
        before, now = old.statuses.get(words, ""), new.statuses.get(words, "")
        if len(before) != len(now):
            yield f"{words} goals: {len(before)} -> {len(now)} of them"
            continue
        changed = [
            f"number {k} {before[k]} -> {now[k]}" for k in range(len(now)) if before[k] != now[k]
        ]
        counts = [
            f"{before.count(x)} -> {now.count(x)} {x}"
            for x in LETTERS
            if before.count(x) != now.count(x)
        ]
        if changed:
            more = [f"{len(changed) - _TOLD} more"] if len(changed) > _TOLD else []
            yield (
                f"{words} goals: {', '.join([*changed[:_TOLD], *more])}; in all "
                f"{', '.join(counts) or 'as many of each status'}"
            )


def golden_text(figures: Mapping[str, Mapping[str, Figures]]) -> str:
    """The golden file."""
    lines = [_HEAD]
    for machine in sorted(figures):
        for real, part in sorted(figures[machine].items()):
            rows = {
                f: '"-"' if row is None else f"[{', '.join(map(str, row))}]"
                for f, row in part.operations.items()
            }
            lines += [
                f"[operations.{machine}.{real}]",
                *(f"{f} = {row}" for f, row in rows.items()),
                "",
            ]
            if part.statuses:
                lines += [
                    f"[statuses.{machine}.{real}]",
                    *(f'{w} = "{said}"' for w, said in part.statuses.items()),
                    "",
                ]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description="Compare the generated C with its golden figures.")
    parser.add_argument("machines", nargs="*", metavar="MACHINE", help="default: all of them")
    parser.add_argument(
        "--write",
        action="store_true",
        help="accept what is found: write tests/data/golden_counts.toml",
    )
    given = parser.parse_args()
    unknown = sorted(set(given.machines) - set(MACHINES))
    if unknown:
        parser.error(f"{', '.join(unknown)}: no such machine; there are {', '.join(MACHINES)}")
    old = kept()
    figures, told = (
        {machine: dict(parts) for machine, parts in old.items() if machine in MACHINES},
        0,
    )
    for machine in given.machines or MACHINES:
        for real in REALS:
            new = found(machine, real)
            said = differences(machine, real, old.get(machine, {}).get(real), new)
            print("\n".join(said or [f"{machine} {real}: as it was"]), flush=True)
            figures.setdefault(machine, {})[real], told = new, told + len(said)
        if given.write:
            GOLDEN.write_text(golden_text(figures))
    return 1 if told and not given.write else 0


if __name__ == "__main__":
    sys.exit(main())
