"""CasADi's own C beside symkin's for the five systems: instructions, and what each answers; two
tables of README.md.

python codegen/bench/plain_bench.py [NAME ...] [--real double] [--count 2000] [--seed 43] [--write]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from plain_answers import STATUSES, Both, tally
from plain_casadi import SYSTEMS, PlainCasadi, RealName
from plain_harness import matrix_harnesses, newton_harnesses
from processors import HOST, measure
from readme import written

BOARDS: dict[RealName, str] = {"float": "M4F", "double": "M7"}
SHOWN = ("cold", "warm", "inverse", "jacobian")
"""`track` has no counterpart in CasADi's C."""


def counted(plain: PlainCasadi) -> Iterator[str]:
    """Mean instructions of the same cases by both, on the board of the type and on the host; the
    largest errors on the host.
    """
    processors = (BOARDS[plain.real], HOST)
    for harnesses in (newton_harnesses(plain), matrix_harnesses(plain)):
        found = {
            who: {p: measure(harness, p) for p in processors} for who, harness in harnesses.items()
        }
        for case in (c for c in SHOWN if c in found["symkin"][HOST]):
            means = [
                f"{found[who][p][case].mean:,.0f}"
                for p in processors
                for who in ("symkin", "CasADi")
            ]
            errors = [f"{found[who][HOST][case].error:.1g}" for who in ("symkin", "CasADi")]
            yield f"| {plain.name} | {case} | {' | '.join([*means, *errors])} |"


def answered(both: Both, count: int, seed: int) -> str:
    """Random goals, asked of both."""
    found = tally(both, count, seed)
    numbers = (
        found.goals,
        found.ok,
        found.zeros,
        found.unsolved,
        found.same,
        found.other,
        found.refused,
    )
    return f"| {both.plain.name} | " + " | ".join(f"{n:,}" for n in numbers) + " |"


def unanswered(both: Both) -> Iterator[str]:
    """Inputs without an answer, asked of both."""
    for title, (start, known) in both.without_answer().items():
        own, plain = both.symkin(start, known), both.casadi(both.unknowns(start), known)
        left = "not finite" if np.isnan(plain.row) else f"{plain.row:.1g} of the size"
        yield f"| {both.plain.name} | {title} | {STATUSES[own.code]} | {plain.code} | {left} |"


def report(names: list[str], reals: list[RealName], count: int, seed: int) -> str:
    lines = []
    for real in reals:
        board = BOARDS[real]
        lines.append(
            f"| system | case | {board} symkin | {board} CasADi | host symkin | host CasADi | "
            f"error symkin | error CasADi |"
        )
        lines.append("|---|---|---|---|---|---|---|---|")
        lines += [*(line for name in names for line in counted(PlainCasadi(name, real))), ""]
    lines += [
        f"Seed {seed}.",
        "",
        "| system | goals | symkin OK | CasADi 0 | no solution | symkin's | another, symkin OK | "
        "another, symkin refuses |",
        "|---|---|---|---|---|---|---|---|",
    ]
    both = [Both(PlainCasadi(name)) for name in names]
    lines += [answered(b, count, seed) for b in both]
    lines += [
        "",
        "| system | input | symkin | CasADi | rows at CasADi's answer |",
        "|---|---|---|---|---|",
    ]
    lines += [line for b in both for line in unanswered(b)]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", default=list(SYSTEMS))
    parser.add_argument(
        "--count", type=int, default=2000, help="random goals for each system (default: 2000)"
    )
    parser.add_argument(
        "--real",
        choices=("double", "float"),
        action="append",
        help="types that are counted (default: double)",
    )
    parser.add_argument("--seed", type=int, default=43)
    parser.add_argument(
        "--write", action="store_true", help="write the tables into codegen/README.md"
    )
    chosen = parser.parse_args()
    measured = report(chosen.names, chosen.real or ["double"], chosen.count, chosen.seed)
    print(measured)
    if chosen.write:
        written("casadi", measured)
