"""Bytes and instructions of `--compact` beside those of the plain code, on a Cortex-M4F in float; a
table of README.md.

python codegen/bench/compactness.py [--write]
"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from bench_cases import HOMES
from harness import Harness, harness_of
from processors import BOARDS, COMMON, measure
from readme import written
from symkin.codegen.options import Options
from symkin.errors import InputError

MACHINES = (
    "zhang2009",
    "ren2008",
    str(Path(__file__).parent / "machines" / "three_rrr.toml"),
    "delta",
    "ur5e",
)
BOARD = "M4F"


def code_bytes(harness: Harness, optimise: str) -> int:
    """Bytes of code and constants of all functions."""
    flags = [*COMMON, optimise, *BOARDS[BOARD][1]]
    subprocess.run(
        ["arm-none-eabi-gcc", *flags, "-c", f"{harness.source}.c", "-o", "all.o"],
        cwd=harness.folder,
        check=True,
    )
    listed = subprocess.run(
        ["arm-none-eabi-size", "all.o"],
        cwd=harness.folder,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    return int(listed.splitlines()[1].split()[0])


def report() -> str:
    """Lines of the table."""
    lines = [
        "| float, M4F | bytes of all functions, -O2 | -Os | instructions at -O2, mean |",
        "|---|---|---|---|",
    ]
    for source in MACHINES:
        home = HOMES.get(source)
        for compact in (False, True):
            title = Path(source).stem + (", `--compact`" if compact else "")
            try:
                harness = harness_of(source, Options("float", home=home, compact=compact))
            except InputError:
                lines.append(f"| {title} | refused: nothing to shorten | | |")
                continue
            sizes = " | ".join(f"{code_bytes(harness, optimise):,}" for optimise in ("-O2", "-Os"))
            counts = ", ".join(
                f"{case} {f.mean:,.0f}" for case, f in measure(harness, BOARD).items()
            )
            lines.append(f"| {title} | {sizes} | {counts} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Measure --compact beside the plain code.")
    parser.add_argument(
        "--write", action="store_true", help="write the table into codegen/README.md"
    )
    chosen = parser.parse_args()
    measured = report()
    print(measured)
    if chosen.write:
        written("compact", measured)
