"""Bytes of code and worst-case stack of the platform's functions, by the ARM compiler's own tools."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections import defaultdict
from pathlib import Path

from bench_cases import HOME
from processors import BOARDS, COMMON
from symkin.codegen.folder import write_folder
from symkin.codegen.options import Options
from symkin.formats.load import load

_OTHERS = re.compile("jacobian|rates|twist|feed|speeds|row_scale|column")
"""Sections of functions that are not counted."""


def footprint(board: str, options: Options, optimise: str) -> tuple[int, dict[str, int]]:
    """Bytes of code and constants of direct, inverse and track, and the stack of each by the summed call graph."""
    folder = Path(tempfile.mkdtemp())
    write_folder(load("zhang2009"), folder, options)
    flags = [*COMMON, optimise, "-ffunction-sections", "-fdata-sections", "-fcallgraph-info=su", *BOARDS[board][1]]
    subprocess.run(["arm-none-eabi-gcc", *flags, "-c", "zhang2009.c", "-o", "z.o"], cwd=folder, check=True)
    listed = subprocess.run(["arm-none-eabi-size", "-A", "z.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    lines = [line.split() for line in listed.splitlines() if line.startswith((".text", ".rodata")) and not _OTHERS.search(line)]
    graph = next(folder.glob("*.ci")).read_text()
    own = {m[0]: int(m[1]) for m in re.findall(r'title: "([^"]+)" label: "[^"]*\\n(\d+) bytes', graph)}
    calls: dict[str, set[str]] = defaultdict(set)
    for caller, callee in re.findall(r'sourcename: "([^"]+)" targetname: "([^"]+)"', graph):
        calls[caller].add(callee)

    def depth(function: str) -> int:
        return own.get(function, 0) + max((depth(c) for c in calls[function]), default=0)

    return sum(int(line[1]) for line in lines), {f: depth(f"zhang2009_{f}") for f in ("direct", "track", "inverse", "jacobian")}


def footprint_table() -> list[str]:
    """Lines of the table of sizes and stacks."""
    lines = ["| zhang2009 | bytes of direct, inverse, track | stack of direct / track / inverse / jacobian |", "|---|---|---|"]
    for board, real in (("M4F", "float"), ("M7", "double")):
        for optimise in ("-O2", "-Os"):
            size, stack = footprint(board, Options(real, home=HOME), optimise)  # type: ignore[arg-type]
            lines.append(f"| {real} {board} {optimise} | {size:,} | {' / '.join(str(v) for v in stack.values())} |")
    return lines
