"""Sends random inputs to folders of generated C under ASan and UBSan, with floating-point traps on
division by zero and overflow, and on invalid operations where every input is finite.

    python codegen/bench/fuzz.py [FOLDER ...] [--count 1000000] [--seed 0]
        [--mode trap|division|count]

Without folders: every one that generate.py writes. `division` traps no overflow, `count` nothing:
it counts.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from shlex import split

from calls import driver, manifest_of
from folders import chosen

FLAGS = """-std=gnu99 -Wall -Wextra -O1 -g -fno-omit-frame-pointer -ftrapping-math -fno-math-errno
    -ffp-contract=off -fsanitize=address,undefined -fno-sanitize-recover=all"""


def built(folder: Path, output: Path) -> Path:
    """The fuzzing program of a folder."""
    name, _, _ = manifest_of(folder)
    words = f"{driver(folder, 'FUZZ', output.parent)} {folder / name}.c -lm -o {output}"
    subprocess.run(split(f"gcc {FLAGS} {words}"), check=True)
    return output


def fuzzed(folder: Path, count: int, seed: int = 0, mode: str = "trap") -> tuple[bool, str]:
    """Whether nothing was found in a folder, and what the program said."""
    with tempfile.TemporaryDirectory() as scratch:
        program = built(folder, Path(scratch) / "fuzz")
        done = subprocess.run(
            [str(program), str(count), str(seed), mode], capture_output=True, text=True, check=False
        )
    return done.returncode == 0, done.stdout + done.stderr


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*")
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--mode", choices=["trap", "division", "count"], default="trap")
    given = parser.parse_args()
    findings = 0
    for folder in chosen(given.folders):
        clean, said = fuzzed(folder, given.count, given.seed, given.mode)
        findings += not clean
        print(f"{folder.name}: {'no finding' if clean else 'FOUND'}\n{said}", flush=True)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
