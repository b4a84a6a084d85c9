"""Instructions per solve of the generated C on a Cortex-M board and on the host; the table of
README.md.

    python codegen/bench/bench.py [FOLDER ...] [--processor P ...] [--cc gcc] [--write]

FOLDER is a name of generate.py's, all of them without, or a folder that `symkin firmware` wrote.
Cases are those of the folder's own vectors: every other one starts far from its answer (cold), the
others next to it (warm); 64 poses about home each for zhang2009, whose home is chosen, warm within
0.2 mm and 1 mrad of the answer. Bytes, stack and worst cases: worst.py.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np

from calls import manifest_of, program
from generate import FOLDERS, HOMES, folders_of
from processors import BOARD_OF, HOST, TICK, counted, said
from readme import table, told, written
from subjects import machine_of
from symkin.codegen.folder.own_test_text import vectors_text
from symkin.codegen.folder.vectors import Vectors
from symkin.codegen.map.options import Options
from symkin.codegen.map.program import build_program
from symkin.codegen.map.rod_platform import RodPlatform, sample_poses
from symkin.codegen.steps.samples import rounded_to
from symkin.position.problem import actuated_names, build_problem
from symkin.spatial.rotation import multiply

CASES = {
    "platform": {"direct": ("cold", "warm"), "track": ("", "track")},
    "arm": {name: (name, name) for name in ("inverse", "inverse_nearest", "inverse_all", "track")},
    "map": {
        "direct": ("cold", "warm"),
        "inverse": ("back, cold", "back, warm"),
        "track": ("", "track"),
        "track_inverse": ("", "track back"),
        "second": ("", "derivatives"),
    },
}
"""Functions of each kind of folder that are told, and what their even and odd vectors are called;
the last one of a map is the Jacobian and the second derivatives.
"""
HOME = HOMES["zhang2009"]
HEADS = ("folder", "processor", "case", "mean", "largest", "largest error")


def rows_of(folder: Path, processor: str, cc: str = "gcc") -> list[tuple[str, ...]]:
    """Rows of the table: instructions of each case, its error in the vectors' unit."""
    name, kind, manifest = manifest_of(folder)
    found = defaultdict[str, list[tuple[float, float]]](list)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        if manifest["options"]["home"] == list(HOME):
            (place / f"{name}_vectors.h").write_text(_about_home(manifest["options"]))
        for function, cases in CASES[kind].items():
            only = f"""-D'ONLY="{function}"'"""
            made = program(folder, "cases.h", processor, place, only, cc)
            rows = [line.split()[1:] for line in said(processor, made).splitlines()]
            counts = [int(ticks) * TICK for _, ticks, _, _ in rows]
            if rows and processor == HOST:
                counts = counted(made, f"{name}_{function}")
            for (number, _, fine, coarse), count in zip(rows, counts, strict=True):
                off = float(fine) * 1e-12 if float(fine) < 4e9 else float(coarse) * 1e-6
                found[cases[int(number) % 2]].append((count, off))
    found.pop("", None)
    most = {case: (np.mean(rows, axis=0)[0], *np.max(rows, axis=0)) for case, rows in found.items()}
    return [
        (folder.name, processor, case, f"{mean:,.0f}", f"{largest:,.0f}", f"{error:.2g}")
        for case, (mean, largest, error) in most.items()
    ]


def _about_home(chosen: dict[str, object]) -> str:
    """Vectors of zhang2009 about its chosen home: 64 poses within 60 mm and 0.25 rad of it, twice:
    from home, and from within 0.2 mm and 1 mrad of the answer.
    """
    options = Options(chosen["real"], chosen["home_relative"], chosen["geometry"], HOME)  # type: ignore[arg-type]
    program = build_program(machine_of("zhang2009").mechanism, options)
    platform = program.kind
    assert isinstance(platform, RodPlatform)  # noqa: S101 - six rods
    system = build_problem(platform.mechanism, actuated_names(platform.mechanism)).system
    rng, rows = np.random.default_rng(3), defaultdict[str, list[object]](list)
    origin = np.array(platform.home.position) if options.home_relative else np.zeros(3)
    for pose in sample_poses(platform.home, 64, 60.0, 0.25, 7):
        given = rounded_to(platform.real, platform.joint_values(pose))
        z = np.array([*pose.position, *pose.quaternion])
        for _ in range(2):
            z = system.polish(z, given + platform.zero, 8)
        q = multiply(np.array([1.0, *(0.5 * rng.uniform(-1e-3, 1e-3, 3))]), z[3:])
        near = [*(z[:3] + rng.uniform(-0.2, 0.2, 3) - origin), *(q / np.linalg.norm(q))]
        rows["joints"] += [given, given]
        rows["guesses"] += [platform.stated(platform.home), near]
        rows["poses"] += [[*(z[:3] - origin), *z[3:]]] * 2
    answers = {what: np.array(values) for what, values in rows.items()} | {"jacobians": []}
    return vectors_text(
        program, Vectors(bounds=np.ones(128), answers=answers, refused={}, places={}, blamed=[])
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Instructions of the generated C.")
    parser.add_argument("folders", nargs="*", metavar="FOLDER", help="default: all")
    parser.add_argument("--processor", nargs="*", choices=("M4F", "M7", HOST))
    parser.add_argument("--cc", default="gcc", help="the host's compiler")
    parser.add_argument("--write", action="store_true", help="the table of codegen/README.md")
    given, rows = parser.parse_args(), list[tuple[str, ...]]()
    for folder in folders_of(given.folders):
        board = BOARD_OF[manifest_of(folder)[2]["options"]["real"]]
        for processor in given.processor or (board, HOST):
            rows += rows_of(folder, processor, given.cc)
            print("\n".join(" | ".join(row) for row in rows if row[:2] == (folder.name, processor)))
    if given.write:
        kept = [tuple(line.strip("| ").split(" | ")) for line in told("bench").splitlines()[2:]]
        others = set(FOLDERS) - {row[0] for row in rows}
        rows = sorted([*rows, *(row for row in kept if row[0] in others)], key=lambda row: row[0])
        written("bench", table(HEADS, rows))


if __name__ == "__main__":
    main()
