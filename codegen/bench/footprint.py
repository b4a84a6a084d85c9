"""Bytes of code and worst-case stack of a folder's functions, by the ARM compiler's own tools.

Stacks follow callees, those of libm among them: what their code pushes.
"""

from __future__ import annotations

import re
import tempfile
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from processors import BOARDS, LIBRARIES, compiled_for, run

_FRAME = re.compile(r"\t(push|vpush|stmdb|sub(?:\.w|w)?|str(?:\.w|d)?|vstmdb)\s+(.*)")
_JUMP = re.compile(
    r"\t(?:bl|b|b\.w|b\.n|cbz|cbnz|b(?:eq|ne|gt|ge|lt|le|hi|ls|cs|cc|mi|pl|vs|vc)(?:\.[nw])?)\s+.*<([\w.]+)(?:\+0x[0-9a-f]+)?>$"
)


@dataclass(frozen=True)
class Footprint:
    """Of one function with all that it calls: bytes of stack, bytes of code and constants without
    and with libm.
    """

    stack: int
    own_bytes: int
    bytes: int


def footprints(
    folder: Path, name: str, functions: list[str], board: str
) -> tuple[dict[str, Footprint], int, list[str]]:
    """The footprint of each function, bytes of the whole object, and the library's functions that
    it calls.
    """
    with tempfile.TemporaryDirectory() as scratch:
        place, roots = Path(scratch), [f"{name}_{f}" for f in functions]
        sections = "-ffunction-sections -fdata-sections"
        compiled_for(board, f"{sections} -I{folder} -c {folder / name}.c -o z.o", place)
        alone = "-nostdlib -Wl,--unresolved-symbols=ignore-all"
        sizes = [[_linked([f], board, place, o) for o in (alone, LIBRARIES)] for f in roots]
        _linked(roots, board, place, LIBRARIES)
        frames, jumps = disassembled(_tool("objdump -d --no-show-raw-insn z.elf", place))
        found = {
            function: Footprint(depth(root, frames, jumps), *size)
            for function, root, size in zip(functions, roots, sizes, strict=True)
        }
        return found, _size("z.o", place), sorted(_tool("nm -u z.o", place).split()[1::2])


def disassembled(text: str) -> tuple[dict[str, int], dict[str, set[str]]]:
    """Each function's own stack and where it jumps to, of a disassembly: pushes and what is taken
    off the stack pointer; what is not fixed is refused.
    """
    frames: dict[str, int] = {}
    jumps: dict[str, set[str]] = defaultdict(set)
    function = ""
    for line in text.splitlines():
        head = re.match(r"[0-9a-f]+ <([^>]+)>:", line)
        if head:
            function = head[1]
            frames[function] = 0
        elif (move := _FRAME.search(line)) is not None:
            frames[function] += _pushed(move[1], move[2])
        elif (jump := _JUMP.search(line)) is not None and jump[1] != function:
            jumps[function].add(jump[1])
    return frames, dict(jumps)


def _pushed(operation: str, operands: str) -> int:
    """Bytes by which an instruction lowers the stack pointer."""
    if operation in ("push", "vpush") or operands.startswith("sp!"):
        registers = operands[operands.index("{") + 1 : operands.index("}")]
        size = 8 if registers.startswith("d") else 4
        return size * sum(_count(part.strip()) for part in registers.split(","))
    if operation.startswith("sub") and operands.startswith("sp,"):
        taken = re.match(r"sp,(?: sp,)? #(\d+)", operands)
        if taken is None:
            raise ValueError(f"sub {operands}: a stack of no fixed size")
        return int(taken[1])
    stored = re.search(r"\[sp, #-(\d+)\]!", operands)
    return int(stored[1]) if stored else 0


def _count(registers: str) -> int:
    """How many registers r4 or d8-d15 are."""
    ends = re.fullmatch(r"[a-z]+(\d+)-[a-z]+(\d+)", registers)
    return int(ends[2]) - int(ends[1]) + 1 if ends else 1


def depth(
    function: str, frames: dict[str, int], calls: dict[str, set[str]], above: tuple[str, ...] = ()
) -> int:
    """Stack of a function with its callees; raises ValueError where one calls itself, or is not
    known.
    """
    if function in above:
        raise ValueError(f"{' -> '.join([*above, function])}: a recursion has no largest stack")
    if function not in frames:
        raise ValueError(f"{function}: its stack is not known")
    return frames[function] + max(
        (depth(c, frames, calls, (*above, function)) for c in calls.get(function, ())), default=0
    )


def _linked(roots: list[str], board: str, place: Path, others: str) -> int:
    """Bytes of code, constants and data of what some functions need, with other parts of a link."""
    wanted = " ".join(f"-Wl,-u,{root}" for root in roots)
    link = f"-nostartfiles -Wl,--gc-sections -Wl,-e,{roots[0]} {wanted} z.o {others} -o z.elf"
    _tool(f"gcc -mthumb -mfloat-abi=hard {BOARDS[board][1]} {link}", place)
    return _size("z.elf", place)


def _size(file: str, place: Path) -> int:
    """Bytes of code, constants and data of a file."""
    return sum(int(v) for v in _tool(f"size {file}", place).splitlines()[1].split()[:3])


def _tool(words: str, place: Path) -> str:
    return run(f"arm-none-eabi-{words}", place).stdout
