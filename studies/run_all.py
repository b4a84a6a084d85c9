"""Every study with its default options, several at a time; the seconds of each, and whether it ended well.

    python studies/run_all.py [-o out] [--workers 2] [--only zhao2000 yao2020]

The five papers' studies come first. Exit status 1 where one failed; what it printed then follows the table.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAPERS = ("zhang2009", "zhao2000", "gluon_6l3", "ren2008", "yao2020")
OTHERS = (
    "ren2008_planning", "zhang2009_modes_map", "zhao2000_singular", "gluon_singular", "cusp_3rrr", "solvers",
    "coverage", "near_singular", "dietmaier1998", "general_6r", "hexapod_classes",
)  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("out"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", nargs="*", default=[*PAPERS, *OTHERS], choices=[*PAPERS, *OTHERS], metavar="NAME")
    options = parser.parse_args()
    begin = time.perf_counter()
    with ThreadPoolExecutor(options.workers) as pool:
        results = list(pool.map(lambda name: run(name, options.output), options.only))
    print(f"{len(results)} studies, {time.perf_counter() - begin:.0f} s with {options.workers} at a time")
    failed = [(name, text) for name, status, text in results if status]
    for name, text in failed:
        print(f"\n{name} failed:\n{text}")
    return int(bool(failed))


def run(name: str, folder: Path) -> tuple[str, int, str]:
    """One study in a process of its own, one thread in its linear algebra: name, exit status, output."""
    begin = time.perf_counter()
    command = [sys.executable, "-W", "error", str(HERE / f"{name}.py"), "-o", str(folder)]
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | threads)
    print(f"{name:22} {time.perf_counter() - begin:5.0f} s  {'ok' if done.returncode == 0 else 'FAILED'}", flush=True)
    return name, done.returncode, done.stdout + done.stderr


if __name__ == "__main__":
    raise SystemExit(main())
