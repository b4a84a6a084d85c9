"""Programs on Cortex-M boards under QEMU, which counts by SysTick, and on the host, where valgrind
counts.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from shlex import split

BENCH = Path(__file__).resolve().parent
# the scripts of this folder import generate.py and the tests' campaigns
sys.path += [str(BENCH.parent), str(BENCH.parents[1] / "tests")]
TARGETS = BENCH.parent / "targets"
BOARDS = {
    "M4F": ("mps2-an386", "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16"),
    "M7": ("mps2-an500", "-mcpu=cortex-m7 -mfpu=fpv5-d16"),
}
"""QEMU's machine and the compiler's flags of each board."""
BOARD_OF = {"float": "M4F", "double": "M7"}
"""The board that folders of a type of numbers run on."""
HOST = "host"
COMMON = "-O2 -std=c99 -ffp-contract=off -fno-math-errno"
LIBRARIES = "-lm -lc -lgcc"
SHIFT = 3
"""An instruction takes 2^SHIFT ns of QEMU's time, a tick of its counter 40 ns: counts are told to 5
instructions.
"""
TICK = 40 // 2**SHIFT


def compiled_for(processor: str, words: str, folder: Path, cc: str = "gcc") -> None:
    """Run the processor's compiler in a folder."""
    arm = "" if processor == HOST else "arm-none-eabi-"
    flags = "" if processor == HOST else f"-mthumb -mfloat-abi=hard {BOARDS[processor][1]}"
    run(f"{arm}{cc} {COMMON} {flags} {words}", folder)


def linked(processor: str, words: str, folder: Path, cc: str = "gcc") -> Path:
    """A program of sources with what a program begins with on a processor."""
    start = f"-I{TARGETS} {TARGETS / 'host' / 'board.c'}"
    if processor != HOST:
        start = f"-nostartfiles -T {TARGETS / 'mps2.ld'} -I{TARGETS} {TARGETS / 'board.c'}"
    compiled_for(processor, f"{start} -I. {words} {LIBRARIES} -o program", folder, cc)
    return folder / "program"


def said(processor: str, program: Path, seconds: float | None = 300.0) -> str:
    """What a program says on stderr."""
    command = str(program)
    if processor != HOST:
        machine = f"-M {BOARDS[processor][0]} -nographic -icount shift={SHIFT}"
        semihosting = "-semihosting-config enable=on,target=native"
        command = f"qemu-system-arm {machine} {semihosting} -kernel {program}"
    return run(command, program.parent, seconds).stderr


def counted(program: Path, call: str) -> list[int]:
    """Instructions of each call of a function in a program of the host: callgrind collects within
    it only and dumps its counter after each.
    """
    with tempfile.TemporaryDirectory() as dumps:
        within = f"--toggle-collect={call} --dump-after={call} {program.resolve()}"
        run(f"valgrind -q --tool=callgrind --callgrind-out-file=out {within}", Path(dumps))
        numbered = sorted(Path(dumps).glob("out.*"), key=lambda path: int(path.suffix[1:]))
        totals = (re.search(r"^totals: (\d+)", path.read_text(), re.M) for path in numbered)
        return [int(total[1]) for total in totals if total]


def run(
    words: str, folder: Path, seconds: float | None = 300.0
) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder; raises RuntimeError with all that it says where it fails."""
    done = subprocess.run(
        split(words), cwd=folder, check=False, capture_output=True, text=True, timeout=seconds
    )
    if done.returncode != 0:
        raise RuntimeError(f"{words}: {done.stdout}{done.stderr}, exit {done.returncode}")
    return done
