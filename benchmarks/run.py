"""Run every figure beside its peer in one run and compare the ratios with `ratios.toml`.

    python benchmarks/run.py [--quick] [--parts enumeration,sweep] [--seed 0] [--verbose] [--write]

Parts are enumeration (T, PHCpack), multistart (CasADi's rootfinder), sweep, certificates (balls),
tracking (Newton's method at fixed steps), calibration (scipy), transmission (MJX) and startup (the
libraries alone).
Each has a process of its own with one thread and an empty cache. A ratio is symkin over its peer,
so that less is better; counts of faults stand beside them. `--quick` takes small sizes: at most
three minutes on two idle processors. `--write` puts the ratios of this run into the file, its
meanings and allowed factors left alone. Exit status 1 where a ratio is worse than allowed, a
figure is missing, or a part ends in an error; a peer that is not installed is said and is none.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path

from timing import Figure

HERE = Path(__file__).resolve()
RATIOS = HERE.with_name("ratios.toml")
PARTS = (
    "enumeration",
    "multistart",
    "sweep",
    "certificates",
    "tracking",
    "calibration",
    "transmission",
    "startup",
)
"""Modules of this folder with a function `figures`."""
FACTOR = 2.0
"""Allowed factor of a figure that the file does not know yet."""


@dataclass(frozen=True)
class Known:
    """A figure's ratio in the file, how many times it may be, and what it means."""

    ratio: float
    factor: float
    meaning: str

    @property
    def most(self) -> float:
        return self.ratio * self.factor


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the parts that are asked for and print what is worse than allowed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--verbose", action="store_true", help="print the lines of single parts too"
    )
    parser.add_argument("--write", action="store_true", help="put this run's ratios into the file")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.child:
        return write_figures(options)
    unknown = set(options.parts.split(",")) - set(PARTS)
    if unknown:
        parser.error(
            f"--parts: {', '.join(sorted(unknown))} is unknown; allowed: {', '.join(PARTS)}"
        )
    size = "quick" if options.quick else "full"
    tables = read_ratios()
    known, complaints, found = tables.setdefault(size, {}), [], list[Figure]()
    for part in options.parts.split(","):
        begin = time.monotonic()
        figures = run_part(part, options)
        if figures is None:
            complaints.append(f"{part} ended in an error, which stands above")
        found += figures or []
        complaints += report(figures or [], known)
        print(f"  {part}: {time.monotonic() - begin:.0f} s by the clock", flush=True)
        if figures is not None and not options.write:
            names = {f.name for f in figures}
            complaints += [
                f"{n} was not measured"
                for n in known
                if n.startswith(part + ":") and n not in names
            ]
    if options.write:
        known |= {f.name: updated(f, known.get(f.name)) for f in found if f.ratio is not None}
        RATIOS.write_text(ratios_text(tables), encoding="utf-8")
        return 0
    print("\n".join(complaints) or f"{len(found)} figures, none worse than allowed")
    return int(bool(complaints))


def report(figures: Iterable[Figure], known: dict[str, Known]) -> list[str]:
    """Print figures beside what the file says, and return sentences about those that are worse."""
    complaints = []
    for figure in figures:
        told = known.get(figure.name)
        if figure.ratio is None:
            print(f"{figure.name:75s} {'-':>9s}            no peer: {figure.text}", flush=True)
            continue
        allowed = "not known" if told is None else f"{told.most:.3g}"
        print(f"{figure.name:75s} {figure.ratio:9.3g} <= {allowed:9s} {figure.text}", flush=True)
        if told is not None and figure.ratio > told.most:
            complaints.append(
                f"{figure.name} is {figure.ratio:.3g}, allowed are {told.most:.3g} "
                f"({told.ratio:.3g} times {told.factor:g}): {told.meaning}"
            )
    return complaints


def run_part(part: str, options: argparse.Namespace) -> list[Figure] | None:
    """The figures of one part, measured in a process of its own; None where it ended in an
    error.
    """
    single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "figures.json"
        words = [
            sys.executable,
            str(HERE),
            "--child",
            str(answer),
            "--parts",
            part,
            "--seed",
            str(options.seed),
        ]
        words += ["--quick"] if options.quick else []
        environment = os.environ | single | {"SYMKIN_CACHE": str(Path(folder) / "cache")}
        lines = None if options.verbose else subprocess.DEVNULL
        if subprocess.run(words, env=environment, stdout=lines, check=False).returncode:
            return None
        return [Figure(**figure) for figure in json.loads(answer.read_text(encoding="utf-8"))]


def write_figures(options: argparse.Namespace) -> int:
    """Measure one part in this process."""
    module = import_module(options.parts)
    figures = [asdict(f) for f in module.figures(quick=options.quick, seed=options.seed)]
    Path(options.child).write_text(json.dumps(figures), encoding="utf-8")
    return 0


# --- the file -------------------------------------------------------------------------------------


def read_ratios() -> dict[str, dict[str, Known]]:
    """Figures of quick and of full runs by their names."""
    data = tomllib.loads(RATIOS.read_text(encoding="utf-8")) if RATIOS.exists() else {}
    return {
        size: {row["figure"]: Known(row["ratio"], row["factor"], row["meaning"]) for row in rows}
        for size, rows in data.items()
    }


def updated(figure: Figure, before: Known | None) -> Known:
    """A figure of this run as the file keeps it."""
    meaning = "a count of faults" if float(figure.ratio or 0.0) == 0.0 else figure.text
    ratio = float(f"{figure.ratio:.3g}")
    return (
        Known(ratio, FACTOR, meaning)
        if before is None
        else Known(ratio, before.factor, before.meaning)
    )


def ratios_text(tables: dict[str, dict[str, Known]]) -> str:
    """The file: what it is, then a table a figure."""
    lines = [HEAD]
    for size in sorted(tables):
        for name, known in tables[size].items():
            lines += [f"[[{size}]]", f"figure = {json.dumps(name)}", f"ratio = {known.ratio!r}"]
            lines += [f"factor = {known.factor!r}", f"meaning = {json.dumps(known.meaning)}", ""]
    return "\n".join(lines)


HEAD = """\
# Ratios that `benchmarks/run.py` compares with: symkin over its peer in the same run,
# so that less is
# better. A figure fails where it is more than `factor` times `ratio`. `quick` are those of --quick.
# T is numpy.linalg.solve on 40 complex 8 x 8 systems. Counts of faults are 0, whatever the factor.
"""


if __name__ == "__main__":
    sys.exit(main())
