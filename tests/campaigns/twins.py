"""Write what symkin answers to fixed questions, and compare two checkouts by what they answered.

    python tests/campaigns/twins.py write -o FILE [--count 200] [--seed 0] [--jobs 2] [--resume]
    python tests/campaigns/twins.py compare OLD NEW [--only NAME ...]
    python tests/campaigns/twins.py against REVISION [-o FOLDER] [--jobs 2]

`write` asks all shipped mechanisms and `--count` random ones for mobility, modes in both directions
(with counts, completeness, certificates, ground), kinds of singularities and Jacobians at some of
the modes, and the identified rank of a calibration; one JSON file, the same bytes for the same
code. `--like FILE` asks the questions of that file. Each machine has a process of its own with a
limit of processor time; one that hangs, crashes or is refused is an entry. `compare` prints what
differs, and who is right by a third method, independent closures and searches: the older file is
not the judge. `against` writes at this checkout and at a revision (in a temporary work tree, same
questions, same Python) and compares. Exit status 1 where anything differs.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

FORMAT = 1
HERE = Path(__file__).resolve()
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE.parents[1]))
PRINTED = 2
"""Differences of one machine that are printed of each kind and verdict; of more, their number."""
LIMIT_S = 40.0
"""Seconds of processor time that one machine may take."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one of the three commands."""
    parser = argparse.ArgumentParser(description="compare the answers of two checkouts")
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("write", "compare", "against"):
        command = commands.add_parser(name)
        if name == "compare":
            command.add_argument("old", type=Path)
            command.add_argument("new", type=Path)
        command.add_argument("--only", nargs="*", default=[], help="parts of names of machines")
        if name == "compare":
            continue
        if name == "against":
            command.add_argument("revision")
        command.add_argument("-o", "--output", type=Path, required=name == "write")
        command.add_argument("--count", type=int, default=200, help="random machines")
        command.add_argument("--seed", type=int, default=0)
        command.add_argument("--jobs", type=int, default=1)
        command.add_argument("--limit", type=float, default=LIMIT_S, help="seconds a machine")
        command.add_argument("--resume", action="store_true", help="keep machines that are done")
        command.add_argument("--like", type=Path, help="ask the questions of this file")
        if name == "write":
            command.add_argument("--package", type=Path, default=ROOT, help="checkout that answers")
    options = parser.parse_args(arguments)
    if options.command == "write":
        return write(options)
    if options.command == "against":
        return against(options)
    return compare(options.old, options.new, options.only)


# --- writing --------------------------------------------------------------------------------------


def write(options: argparse.Namespace) -> int:
    """Ask all machines and write the file, sorted by name."""
    from campaigns.children import run_each
    from campaigns.twin_answers import answers

    begin = time.monotonic()
    preload(options.package)
    kept = Journal(options.output, resume=options.resume)
    names = [n for n in machine_names(options) if n not in kept.machines]
    work = _asked_like(options.like) if options.like else _asked_of(options.seed)

    def ask(name: str, send: Any) -> None:
        case = work(name)
        send(("case", case))
        answers(case, send)

    for ended in run_each(names, ask, options.jobs, options.limit):
        sent = dict(ended.sent)
        entry = {"case": sent.pop("case", None), "answers": sent, "fault": ended.fault}
        kept.add(ended.task, entry)
        if ended.fault:
            print(f"{ended.task}: {ended.fault}", flush=True)
    kept.finish({"format": FORMAT, "seed": options.seed, "limit": options.limit})
    faults = sum(e["fault"] is not None for e in kept.machines.values())
    asked = sum(len(e["answers"]) for e in kept.machines.values())
    print(
        f"{len(kept.machines)} machines, {asked} answers, {faults} without an end; "
        f"{time.monotonic() - begin:.0f} s by the clock; {options.output}"
    )
    return 0


def preload(package: Path) -> None:
    """Import what children share, from the checkout that is meant."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    sys.path.insert(0, str(package.resolve()))
    os.environ["PYTHONPATH"] = str(package.resolve())
    import symkin

    if not Path(symkin.__file__).resolve().is_relative_to(package.resolve()):
        raise SystemExit(f"symkin is imported from {symkin.__file__}, not from {package}")
    for name in ("modes", "mobility", "singularity", "jacobian", "calibrate"):
        getattr(symkin, name)


def machine_names(options: argparse.Namespace) -> list[str]:
    """Names of all machines that are asked, in order."""
    if options.like:
        names = list(json.loads(options.like.read_text(encoding="utf-8"))["machines"])
    else:
        from campaigns.twin_cases import random_name, shipped

        names = [*shipped(), *(random_name(options.seed, k) for k in range(options.count))]
    return chosen(names, options.only)


def chosen(names: Sequence[str], only: Sequence[str]) -> list[str]:
    """Names of which a part was asked for; all where none was."""
    return [n for n in names if not only or any(part in n for part in only)]


def _asked_of(seed: int) -> Any:
    from campaigns.twin_cases import make_case, text_of

    return lambda name: make_case(name, text_of(name), seed)


def _asked_like(path: Path) -> Any:
    machines = json.loads(path.read_text(encoding="utf-8"))["machines"]
    return lambda name: machines[name]["case"]


class Journal:
    """Machines that are done, kept line by line beside the file, so that a run can be resumed."""

    def __init__(self, output: Path, *, resume: bool) -> None:
        self.output, self.path = output, output.with_suffix(output.suffix + ".part")
        self.machines: dict[str, Any] = {}
        output.parent.mkdir(parents=True, exist_ok=True)
        if resume and self.path.exists():
            lines = self.path.read_text(encoding="utf-8").splitlines()
            self.machines = dict(json.loads(line) for line in lines if line.endswith("]"))
        self.path.write_text("".join(f"{json.dumps(item)}\n" for item in self.machines.items()))

    def add(self, name: str, entry: dict[str, Any]) -> None:
        self.machines[name] = entry
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps([name, entry]) + "\n")

    def finish(self, head: dict[str, Any]) -> None:
        """Write the file, one line a machine."""
        lines = [
            f"{json.dumps(name)}: {json.dumps(self.machines[name], sort_keys=True)}"
            for name in sorted(self.machines)
        ]
        opening = json.dumps(head)[:-1]
        self.output.write_text(
            opening + ', "machines": {\n' + ",\n".join(lines) + "\n}}\n", encoding="utf-8"
        )
        self.path.unlink()


# --- comparing ------------------------------------------------------------------------------------


def compare(old: Path, new: Path, only: Sequence[str] = ()) -> int:
    """Print the differences of two files, each with who is right; 1 where there are some."""
    from campaigns.twin_compare import differences
    from campaigns.twin_judge import judged

    files = [json.loads(path.read_text(encoding="utf-8"))["machines"] for path in (old, new)]
    verdicts: Counter[str] = Counter()
    asked = 0
    names = chosen(sorted(set(files[0]) | set(files[1])), only)
    for name in names:
        pair = [file.get(name) for file in files]
        asked += len((pair[0] or pair[1])["answers"])
        alike: Counter[tuple[str, str]] = Counter()
        for difference in differences(name, *pair):
            verdict = judged(difference)
            verdicts[verdict.who] += 1
            alike[difference.kind, verdict.who] += 1
            if alike[difference.kind, verdict.who] <= PRINTED:
                print(f"{name}: {difference.what}: {verdict.who}: {verdict.why}", flush=True)
        for (kind, who), count in alike.items():
            if count > PRINTED:
                print(f"{name}: {count - PRINTED} more like this: {kind}: {who}", flush=True)
    told = ", ".join(f"{count} {who}" for who, count in sorted(verdicts.items())) or "none"
    print(f"{len(names)} machines, {asked} answers; differences: {told}")
    return int(bool(verdicts))


def against(options: argparse.Namespace) -> int:
    """Write at both checkouts and compare."""
    folder = options.output or Path(tempfile.mkdtemp(prefix="twins_"))
    folder.mkdir(parents=True, exist_ok=True)
    new, old = folder / "new.json", folder / "old.json"
    shared = ["--jobs", str(options.jobs), "--limit", str(options.limit)]
    shared += ["--resume"] if options.resume else []
    asked = ["--count", str(options.count), "--seed", str(options.seed)]
    asked += ["--like", str(options.like)] if options.like else []
    asked += ["--only", *options.only] if options.only else []
    _write([str(new), *shared, *asked])
    tree = Path(tempfile.mkdtemp(prefix="twins_tree_")) / "tree"
    git = ["git", "-C", str(ROOT), "worktree"]
    subprocess.run([*git, "add", "--detach", "--quiet", str(tree), options.revision], check=True)
    try:
        _write([str(old), *shared, "--like", str(new), "--package", str(tree)])
    finally:
        subprocess.run([*git, "remove", "--force", str(tree)], check=True)
    return compare(old, new, options.only)


def _write(arguments: list[str]) -> None:
    """Run `write` in a process of its own, which has imported no package yet."""
    subprocess.run([sys.executable, str(HERE), "write", "-o", *arguments], check=True)


if __name__ == "__main__":
    sys.exit(main())
