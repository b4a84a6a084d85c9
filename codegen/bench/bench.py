"""Instructions per solve of the generated C on two Cortex-M boards and on the host; the table of
README.md.

    python codegen/bench/bench.py [SOLVER ...] [--write]

With names, as "zhao2000_links double", the rows of these alone, and the others stay as they are.
Cold: from home. Warm: within 0.2 mm and 1 mrad of the answer. Bytes, stack and worst cases:
worst.py.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

from harness import harness_of
from processors import HOST, measure
from readme import table, told, written
from subjects import HOME, machine_of
from symkin.codegen.map.options import Options

PARALLEL = (("ren2008", "m"), ("zhao2000", "mm"), ("zhao2000_links", "mm"), ("delta", "mm"))
SERIAL = ("gluon_6l3", "yao2020", "ur5e", "scara")


def subjects() -> Iterator[tuple[str, str, Options, tuple[str, ...], str]]:
    """(title, mechanism, options, processors, unit of errors), in the order of the table."""
    boards = {"float": "M4F", "double": "M7"}
    for real, board in boards.items():
        yield f"zhang2009 {real}", "zhang2009", Options(real, home=HOME), (board, HOST), "mm"  # type: ignore[arg-type]
    relative = Options("float", home_relative=True, home=HOME)
    yield "zhang2009 float, home-relative", "zhang2009", relative, ("M4F", HOST), "mm"
    struct = Options("double", geometry="struct", home=HOME)
    yield "zhang2009 double, struct geometry", "zhang2009", struct, ("M7", HOST), "mm"
    for real, board in boards.items():
        for name, unit in (*PARALLEL, *((name, "rad or mm") for name in SERIAL)):
            yield f"{name} {real}", name, Options(real), (board, HOST), unit  # type: ignore[arg-type]
        yield f"ankle {real}", "ankle", machine_of("ankle").options(real), (board, HOST), "rad"


def rows_of(chosen: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """The rows of the chosen solvers, or of all."""
    for title, name, options, processors, unit in subjects():
        if chosen and title not in chosen:
            continue
        harness = harness_of(name, options)
        for processor in processors:
            for case, f in measure(harness, processor).items():
                yield (
                    title,
                    processor,
                    case,
                    f"{f.mean:,.0f}",
                    f"{f.largest:,.0f}",
                    f"{f.error:.2g} {unit}",
                )


def report(rows: Sequence[tuple[str, ...]]) -> str:
    """The table, with the rows of README.md for solvers that were not measured."""
    kept = [tuple(line.strip("| ").split(" | ")) for line in told("bench").splitlines()[2:]]
    measured = {row[0] for row in rows}
    every = [*rows, *(row for row in kept if row[0] not in measured)]
    titles = [title for title, *_ in subjects()]
    heads = ("solver", "processor", "case", "mean", "largest", "largest error")
    ordered = sorted(every, key=lambda row: titles.index(row[0]))
    return table([dict(zip(heads, row, strict=True)) for row in ordered])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Instructions of the generated C.")
    parser.add_argument("solvers", nargs="*", metavar="SOLVER", help="these rows alone")
    parser.add_argument("--write", action="store_true", help="the table of codegen/README.md")
    given = parser.parse_args()
    titles = [title for title, *_ in subjects()]
    if unknown := sorted(set(given.solvers) - set(titles)):
        parser.error(f"{', '.join(unknown)}: no such row; there are {', '.join(titles)}")
    measured = list(rows_of(given.solvers))
    print("\n".join(" | ".join(row) for row in measured))
    if given.write:
        written("bench", report(measured))
