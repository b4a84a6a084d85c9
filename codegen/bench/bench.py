"""Instructions per solve of the generated C on two Cortex-M boards and on the host; the table of
README.md.

    python codegen/bench/bench.py [--write]

Cold: from home. Warm: within 0.2 mm and 1 mrad of the answer. Bytes, stack and worst cases:
worst.py.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from bench_cases import HOME
from harness import Harness, harness_of
from processors import HOST, measure
from readme import written
from symkin.codegen.options import Options

PARALLEL = (("ren2008", "m"), ("zhao2000", "mm"), ("zhao2000_links", "mm"), ("delta", "mm"))
MAP = ("ankle", ("upper_motor", "lower_motor"), ("ankle.1", "ankle.2"))
"""The two-motor ankle, given and found coordinates, as in generate.py."""
SERIAL = ("gluon_6l3", "yao2020", "ur5e", "scara")


def subjects() -> Iterator[tuple[str, Harness, tuple[str, ...], str]]:
    """(title, what is run, processors, unit of errors), in the order of the table."""
    boards = {"float": "M4F", "double": "M7"}
    for real, board in boards.items():
        yield (
            f"zhang2009 {real}",
            harness_of("zhang2009", Options(real, home=HOME)),
            (board, HOST),
            "mm",
        )  # type: ignore[arg-type]
    relative = Options("float", home_relative=True, home=HOME)
    yield "zhang2009 float, home-relative", harness_of("zhang2009", relative), ("M4F", HOST), "mm"
    struct = Options("double", geometry="struct", home=HOME)
    yield "zhang2009 double, struct geometry", harness_of("zhang2009", struct), ("M7", HOST), "mm"
    for real, board in boards.items():
        for name, unit in PARALLEL:
            yield f"{name} {real}", harness_of(name, Options(real)), (board, HOST), unit  # type: ignore[arg-type]
        for name in SERIAL:
            yield f"{name} {real}", harness_of(name, Options(real)), (board, HOST), "rad or mm"  # type: ignore[arg-type]
        name, given, find = MAP
        yield (
            f"{name} {real}",
            harness_of(name, Options(real, given=given, find=find)),
            (board, HOST),
            "rad",
        )  # type: ignore[arg-type]


def report() -> str:
    lines = [
        "| solver | processor | case | mean | largest | largest error |",
        "|---|---|---|---|---|---|",
    ]
    for title, harness, processors, unit in subjects():
        for processor in processors:
            for case, f in measure(harness, processor).items():
                lines.append(
                    f"| {title} | {processor} | {case} | {f.mean:,.0f} | {f.largest:,.0f} | "
                    f"{f.error:.2g} {unit} |"
                )
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description="Measure the generated C on QEMU's boards and on the host."
    )
    parser.add_argument(
        "--write", action="store_true", help="write the table into codegen/README.md"
    )
    chosen = parser.parse_args()
    measured = report()
    print(measured)
    if chosen.write:
        written("bench", measured)
