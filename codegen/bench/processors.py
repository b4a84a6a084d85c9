"""Instructions of each solve: on Cortex-M boards under QEMU by SysTick (-icount shift=0), on the
host by valgrind.

    python codegen/bench/processors.py BENCH NAME.h

counts a host program that `targets/host/Makefile` built (its target `count`).
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from shlex import split

import numpy as np

from harness import Harness

TARGETS = Path(__file__).parent.parent / "targets"
BOARDS = {
    "M4F": ("mps2-an386", "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16"),
    "M7": ("mps2-an500", "-mcpu=cortex-m7 -mfpu=fpv5-d16"),
}
"""QEMU's machine and the compiler's flags of each board."""
HOST = "host"
START = f"-nostartfiles -T {TARGETS / 'mps2.ld'} -I {TARGETS} {TARGETS / 'board.c'}"
"""What a program on a board begins with."""
COMMON = "-O2 -std=c99 -mthumb -mfloat-abi=hard -ffp-contract=off -fno-math-errno"
LIBRARIES = "-lm -lc -lgcc"


def compiled_for(board: str, words: str, folder: Path) -> None:
    """Run the board's compiler in a folder."""
    command = split(f"arm-none-eabi-gcc {COMMON} {BOARDS[board][1]} {words}")
    subprocess.run(command, cwd=folder, check=True)


@dataclass(frozen=True)
class Figures:
    """Mean and largest count of instructions over the cases, largest error of the answers."""

    mean: float
    largest: float
    error: float


def measure(harness: Harness, processor: str) -> dict[str, Figures]:
    """Figures of each kind of case on M4F, M7 or the host."""
    found = on_host(harness) if processor == HOST else on_board(harness, processor)
    parts = {name: found[found[:, 0] == k] for k, name in enumerate(harness.kinds)}
    return {
        name: Figures(float(p[:, 1].mean()), float(p[:, 1].max()), float(p[:, 2].max()))
        for name, p in parts.items()
    }


def on_board(harness: Harness, board: str) -> np.ndarray:
    """Rows (kind, instructions, error)."""
    sources = f"bench.c {harness.source}.c {LIBRARIES} -o {board}.elf"
    compiled_for(board, f"{START} -I. {sources}", harness.folder)
    return _rows(said_on_board(BOARDS[board][0], harness.folder / f"{board}.elf"))


def said_on_board(machine: str, program: Path | str, shift: int = 0) -> str:
    """What a program says on stderr on a machine of QEMU's, an instruction 2^shift ns."""
    qemu = f"qemu-system-arm -M {machine} -nographic -icount shift={shift} -semihosting-config"
    command = split(f"{qemu} enable=on,target=native -kernel {program}")
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=300).stderr


def on_host(harness: Harness, cc: str = "gcc") -> np.ndarray:
    """The same on this machine: built by the host's Makefile, counted by valgrind."""
    place = f"FOLDER={harness.folder} BUILD={harness.folder} NAME={harness.source} CC={cc} bench"
    subprocess.run(split(f"make -s -C {TARGETS / 'host'} {place}"), check=True)
    return counted(harness.folder / "bench", harness.calls)


def counted(program: Path, calls: tuple[str, ...]) -> np.ndarray:
    """Rows (kind, instructions, error): each of `calls` in a run of its own, in the order of the
    program's kinds; callgrind collects within the call only and dumps its counter after each.
    """
    totals: list[float] = []
    for call in calls:
        with tempfile.TemporaryDirectory() as dumps:
            within = f"--toggle-collect={call} --dump-after={call} {program.resolve()}"
            command = split(f"valgrind -q --tool=callgrind --callgrind-out-file=out {within}")
            done = subprocess.run(
                command, cwd=dumps, check=True, capture_output=True, text=True, timeout=300
            )
            numbered = sorted(Path(dumps).glob("out.*"), key=lambda path: int(path.suffix[1:]))
            totals += [
                float(re.findall(r"^totals: (\d+)", path.read_text(), re.M)[0]) for path in numbered
            ]
    rows = _rows(done.stderr)
    if len(totals) != len(rows):
        raise ValueError(
            f"valgrind counted {len(totals)} calls of {', '.join(calls)} in {program}, which made "
            f"{len(rows)}"
        )
    return np.column_stack([rows[:, 0], totals, rows[:, 2]])


def _rows(text: str) -> np.ndarray:
    """Lines (kind, instructions, error in 1e-12, error in 1e-6) of a bench's output."""
    values = [
        [int(v) for v in line.split()]
        for line in text.splitlines()
        if re.fullmatch(r"\d+( \d+){3}", line)
    ]
    found = np.array(values, dtype=float)
    fine = np.where(found[:, 2] < 4e9, found[:, 2] * 1e-12, found[:, 3] * 1e-6)
    return np.column_stack([found[:, :2], fine])


if __name__ == "__main__":
    bench, header = Path(sys.argv[1]), Path(sys.argv[2])
    name = header.stem
    is_arm = re.search(rf"{name}_inverse\([^)]*guess", header.read_text()) is not None
    rows = counted(bench, (f"{name}_inverse",) if is_arm else (f"{name}_direct", f"{name}_track"))
    for kind in sorted(set(rows[:, 0])):
        part = rows[rows[:, 0] == kind, 1]
        print(
            f"kind {int(kind)}: {part.mean():,.0f} instructions a solve, largest "
            f"{part.max():,.0f}, {len(part)} solves"
        )
