"""The worst case of each function of generated folders: instructions searched under QEMU, stack
with callees, bytes.

    python codegen/bench/worst.py [FOLDER ...] [--write] [--seed 1]

float folders run on the Cortex-M4F, double ones on the M7, at -O2. Instructions are the most of any
call without a config over random inputs of all kinds (drive.c: own vectors, goals up to the widest
range, lines beyond it, NaN and numbers of any size) and over changes of the dearest ones. With
--write the figures are kept in codegen/measured.json, from which generate.py writes them into the
folders, and the table of codegen/README.md. The search is a matter of luck: one tick more or less
sends it elsewhere, and an input of the same code that took more once is not forgotten.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from calls import manifest_of, program
from footprint import footprints
from generate import FOLDERS, folders_of
from processors import BENCH, BOARD_OF, TICK, run, said
from readme import table, written

MEASURED = BENCH.parent / "measured.json"
MOST_INPUTS = 40_000
MOST_TICKS = 120_000_000
"""Of all calls of a folder: 600 million instructions, some seconds."""


def measured(
    folder: Path, seed: int, most_inputs: int = MOST_INPUTS, most_ticks: int = MOST_TICKS
) -> dict[str, Any]:
    """The figures of a folder, as the manifest has them."""
    name, _, manifest = manifest_of(folder)
    board = BOARD_OF[manifest["options"]["real"]]
    limits = f"-DSEED={seed} -DCOUNT={most_inputs}L -DMOST_TICKS={most_ticks}ULL"
    with tempfile.TemporaryDirectory() as place:
        told = said(board, program(folder, "worst.h", board, Path(place), limits))
    rows = {f: list(map(int, numbers)) for f, *numbers in map(str.split, told.splitlines())}
    count, _ = rows.pop("inputs")
    feet, whole, library = footprints(folder, name, list(rows), board)
    version = run("arm-none-eabi-gcc -dumpfullversion", folder).stdout.strip()
    return {
        "code": manifest["files"][f"{name}.c"],
        "processor": f"Cortex-{board}",
        "compiler": f"GCC {version} -O2",
        "inputs": count,
        "seed": seed,
        "object_bytes": whole,
        "library": library,
        "functions": {
            f: {
                # a call that ends within a tick may have taken all of the next
                "instructions": (ticks + 1) * TICK,
                "stack": feet[f].stack,
                "stack_touched": touched,
                "bytes": feet[f].own_bytes,
                "bytes_with_library": feet[f].bytes,
            }
            for f, (ticks, touched) in rows.items()
        },
    }


def remembered(old: dict[str, Any] | None, new: dict[str, Any]) -> dict[str, Any]:
    """New figures, of each function the most instructions that a call of this code, so compiled,
    was ever found to take.
    """
    of = ("code", "compiler", "processor")
    if old is None or any(old[key] != new[key] for key in of):
        return new
    functions = {
        name: f | {"instructions": max(f["instructions"], old["functions"][name]["instructions"])}
        for name, f in new["functions"].items()
    }
    return new | {"functions": functions}


def figures_table(figures: dict[str, dict[str, Any]]) -> str:
    """The table of codegen/README.md."""
    keys = ("instructions", "stack", "bytes", "bytes_with_library")
    rows: list[tuple[str, ...]] = []
    for folder, found in sorted(figures.items()):
        for name, f in found["functions"].items():
            rows.append((folder, name, *(f"{f[key]:,}" for key in keys)))
        called = f"calls {', '.join(found['library']) or 'none'}"
        rows.append(
            (folder, "all", f"{found['inputs']:,} inputs", "", f"{found['object_bytes']:,}", called)
        )
    return table(("folder", "function", "instructions", "stack", "bytes", "with libm"), rows)


def main() -> None:
    parser = argparse.ArgumentParser(description="Search the worst cases of generated folders.")
    parser.add_argument("folders", nargs="*", metavar="FOLDER", help="default: all")
    parser.add_argument("--write", action="store_true", help="keep the figures")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    found = {}
    for folder in folders_of(given.folders):
        found[folder.name] = measured(folder, given.seed)
        print(figures_table({folder.name: found[folder.name]}), flush=True)
    if given.write:
        kept = json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
        kept |= {name: remembered(kept.get(name), new) for name, new in found.items()}
        kept = {name: figures for name, figures in kept.items() if name in FOLDERS}
        MEASURED.write_text(json.dumps(dict(sorted(kept.items())), indent=1) + "\n")
        written("worst", figures_table(kept))


if __name__ == "__main__":
    main()
