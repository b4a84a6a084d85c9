"""Run every study with its default options, several at a time; print the seconds of each, and
whether it ended well.

    python studies/run_all.py [-o out] [--workers 2] [--only zhao2000 yao2020]

The five papers' studies come first. Exit status 1 where one failed; what it printed then follows
the table.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[1])

from studies import SCRIPTS

HERE = Path(__file__).resolve().parent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("out"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", nargs="*", default=[*SCRIPTS], choices=[*SCRIPTS], metavar="NAME")
    options = parser.parse_args()
    begin = time.perf_counter()
    with ThreadPoolExecutor(options.workers) as pool:
        results = list(pool.map(lambda name: run(name, options.output), options.only))
    print(
        f"{len(results)} studies, {time.perf_counter() - begin:.0f} s with {options.workers} at a "
        f"time"
    )
    failed = [(name, text) for name, status, text in results if status]
    for name, text in failed:
        print(f"\n{name} failed:\n{text}")
    return int(bool(failed))


def run(name: str, folder: Path) -> tuple[str, int, str]:
    """Run one study in a process of its own, one thread in its linear algebra; return name, exit
    status, output.
    """
    begin = time.perf_counter()
    command = [sys.executable, "-W", "error", str(HERE / SCRIPTS[name]), "-o", str(folder)]
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | threads
    )
    print(
        f"{name:22} {time.perf_counter() - begin:5.0f} s  "
        f"{'ok' if done.returncode == 0 else 'FAILED'}",
        flush=True,
    )
    return name, done.returncode, done.stdout + done.stderr


if __name__ == "__main__":
    raise SystemExit(main())
