"""Sends random inputs to folders of generated C under ASan and UBSan, with floating-point traps on
division by zero and overflow, and on invalid operations where every input is finite.

    python codegen/bench/fuzz.py [FOLDER ...] [--count 1000000] [--seed 0]
        [--mode trap|division|count]

Without folders: every one that generate.py writes. `division` traps no overflow, `count` nothing:
it counts.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from calls import program
from generate import folders_of
from processors import HOST, said

FLAGS = """-std=gnu99 -O1 -g -fno-omit-frame-pointer -ftrapping-math
    -fsanitize=address,undefined -fno-sanitize-recover=all"""
MODES = ("count", "division", "trap")


def fuzzed(folder: Path, count: int, seed: int = 0, mode: str = "trap") -> tuple[bool, str]:
    """Whether nothing was found in a folder, and what the program said."""
    words = f"{FLAGS} -DTRAPS={MODES.index(mode)} -DCOUNT={count}L -DSEED={seed}"
    with tempfile.TemporaryDirectory() as place:
        try:
            told = said(HOST, program(folder, "fuzz.h", HOST, Path(place), words), None)
        except RuntimeError as found:
            return False, str(found)
    form = "{}: {} answered; division {}, overflow {}, invalid {}"
    return True, "\n".join(form.format(*line.split()) for line in told.splitlines())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*")
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mode", choices=MODES, default="trap")
    given = parser.parse_args()
    findings = 0
    for folder in folders_of(given.folders):
        clean, told = fuzzed(folder, given.count, given.seed, given.mode)
        findings += not clean
        print(f"{folder.name}: {'no finding' if clean else 'FOUND'}\n{told}", flush=True)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
