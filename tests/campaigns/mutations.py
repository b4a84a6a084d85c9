"""Put single faults into a copy of the code and see that named tests find each of them.

    python tests/campaigns/mutations.py [--only NAME] [--jobs N]

Each row of `mutations.toml` is a fault (a file, a text that stands in it exactly once, what is put
in its place) and the tests that must fail with it. The tracked files are copied to a temporary
folder, one for each job. There the tests pass as the files are; then a fault is put in, its tests
run with a cache of their own, and the file is put back. Tests that compare generated C with the
committed folders, digests and golden figures are left out: they find every change and say of none
that it is wrong. The command ends with 1 where a fault survives or no longer fits the code, or
where a test fails without any.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).resolve().parents[2]
TABLE = Path(__file__).with_suffix(".toml")
BYTE_COMPARISONS = (
    "tests/codegen/test_firmware.py::test_committed_folders_are_what_the_generator_writes",
    "tests/codegen/test_golden_counts.py::test_folders_that_are_not_committed_have_their_digest",
    "tests/codegen/test_golden_counts.py::test_the_code_does_what_it_did",
)
"""Tests that compare generated C with committed C, its digests and its golden figures."""
TIMEOUT_S = 900.0
"""Seconds after which the tests of one fault are ended: one that makes a search endless is found
too."""
FAILED = 1
"""What pytest ends with where tests failed; with more than that nothing was tested."""


@dataclass(frozen=True)
class Fault:
    """A fault by its name: in `file`, `old` becomes `new`; `tests` are files or single tests of
    pytest."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


def read_faults(table: Path) -> list[Fault]:
    """The faults of a table."""
    rows = tomllib.loads(table.read_text(encoding="utf-8"))["fault"]
    return [Fault(**{**row, "tests": tuple(row["tests"])}) for row in rows]


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the faults that are asked for and print what became of each."""
    parser = argparse.ArgumentParser(description="put single faults into a copy of the code")
    parser.add_argument("--only", metavar="NAME", help="faults whose name holds NAME")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="faults at a time (1)")
    options = parser.parse_args(arguments)
    faults = read_faults(TABLE)
    chosen = [fault for fault in faults if options.only is None or options.only in fault.name]
    if not chosen:
        names = ", ".join(fault.name for fault in faults)
        parser.error(f"no fault is named {options.only!r}; names are {names}")
    unfit = list(_unfit(chosen))
    if unfit:
        print(*unfit, sep="\n")
        return 1
    jobs = max(1, min(options.jobs, len(chosen)))
    with tempfile.TemporaryDirectory(prefix="mutations-") as folder:
        copies = [_copy(Path(folder) / str(number)) for number in range(jobs)]
        status, told = _ended(sorted({test for fault in chosen for test in fault.tests}), copies[0])
        if status:
            print(f"tests fail where no fault is put in:{told}")
            return 1
        found = _tried(chosen, copies)
    print(f"caught {found} of {len(chosen)}")
    return int(found < len(chosen))


def _unfit(faults: Sequence[Fault]) -> Iterator[str]:
    """Faults whose text does not stand in its file exactly once, and names that two have."""
    for number, fault in enumerate(faults):
        path = ROOT / fault.file
        count = path.read_text(encoding="utf-8").count(fault.old) if path.is_file() else 0
        if count != 1:
            yield f"{fault.name}: {fault.old!r} stands {count} times in {fault.file}, not once"
        if fault.name in {other.name for other in faults[:number]}:
            yield f"{fault.name}: two faults have this name"


def _tried(faults: Sequence[Fault], folders: Sequence[Path]) -> int:
    """Count of the faults that were caught."""
    copies: SimpleQueue[Path] = SimpleQueue()
    for folder in folders:
        copies.put(folder)

    def judge(fault: Fault) -> bool:
        copy = copies.get()
        try:
            status, told = _run(fault, copy)
        finally:
            copies.put(copy)
        word = {0: "SURVIVED", FAILED: "caught"}.get(status, "NOT TESTED")
        print(f"{word:10}  {fault.name}{'' if status == FAILED else told}", flush=True)
        return status == FAILED

    with ThreadPoolExecutor(len(folders)) as pool:
        return sum(pool.map(judge, faults))


def _copy(folder: Path) -> Path:
    """The tracked files in a folder of their own, with their times, so that what is compiled of
    them stays right."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


def _run(fault: Fault, copy: Path) -> tuple[int, str]:
    """What the tests of a fault end with and say, the fault put in."""
    path = copy / fault.file
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    try:
        return _ended(fault.tests, copy)
    finally:
        shutil.copy2(ROOT / fault.file, path)


def _ended(tests: Sequence[str], copy: Path) -> tuple[int, str]:
    """What pytest ends with, and the end of what it says."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-x",
        "-q",
        "-m",
        "not long",
        "-p",
        "no:cacheprovider",
        *tests,
    ]
    command += [f"--deselect={test}" for test in BYTE_COMPARISONS]
    try:
        with tempfile.TemporaryDirectory(dir=copy.parent) as cache:
            environment = {
                **os.environ,
                "PYTHONPATH": str(copy),
                "SYMKIN_CACHE": cache,
                "OMP_NUM_THREADS": "1",
            }
            ended = subprocess.run(
                command,
                cwd=copy,
                env=environment,
                capture_output=True,
                text=True,
                timeout=TIMEOUT_S,
            )
            return ended.returncode, "\n" + (ended.stdout + ended.stderr)[-1500:]
    except subprocess.TimeoutExpired:
        return FAILED, "\nno end"


if __name__ == "__main__":
    sys.exit(main())
