"""Instructions per solve of the generated C on two Cortex-M boards and on the host; the table of
README.md.

    python codegen/bench/bench.py [SOLVER ...] [--write]

With names, as "zhao2000_links double", the rows of these alone, and the others stay as they are.
Cold: from home. Warm: within 0.2 mm and 1 mrad of the answer. Bytes, stack and worst cases:
worst.py.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence

from harness import harness_of
from processors import HOST, measure
from readme import README, written
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


def rows_of(chosen: Sequence[str]) -> dict[str, list[str]]:
    """The rows of each solver, of the chosen ones or of all."""
    found: dict[str, list[str]] = {}
    for title, name, options, processors, unit in subjects():
        if chosen and title not in chosen:
            continue
        harness = harness_of(name, options)
        found[title] = [
            f"| {title} | {processor} | {case} | {f.mean:,.0f} | {f.largest:,.0f} | "
            f"{f.error:.2g} {unit} |"
            for processor in processors
            for case, f in measure(harness, processor).items()
        ]
    return found


def report(rows: Mapping[str, Sequence[str]]) -> str:
    """The table, with the rows of README.md for solvers that were not measured."""
    told = README.read_text().partition("<!-- bench -->")[2].partition("<!-- end")[0].splitlines()
    lines = [
        "| solver | processor | case | mean | largest | largest error |",
        "|---|---|---|---|---|---|",
    ]
    for title, *_ in subjects():
        lines += rows.get(title, [line for line in told if line.startswith(f"| {title} |")])
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description="Measure the generated C on QEMU's boards and on the host."
    )
    parser.add_argument("solvers", nargs="*", metavar="SOLVER", help="these rows alone")
    parser.add_argument(
        "--write", action="store_true", help="write the table into codegen/README.md"
    )
    given = parser.parse_args()
    titles = [title for title, *_ in subjects()]
    if unknown := sorted(set(given.solvers) - set(titles)):
        parser.error(f"{', '.join(unknown)}: no such row; there are {', '.join(titles)}")
    measured = rows_of(given.solvers)
    print("\n".join(line for lines in measured.values() for line in lines))
    if given.write:
        written("bench", report(measured))
