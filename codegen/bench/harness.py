"""A C main file that solves the bench's cases, for any processor with `targets/board.h`.

    python codegen/bench/harness.py FOLDER -o bench.c

writes it for a committed folder, as `targets/host/Makefile` does. Cases are those of the folder's
own vectors that start next to their answers, of arms all of them; 64 poses about home for a
platform whose home is HOME.
"""

from __future__ import annotations

import argparse
import json
import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from subjects import HOME
from symkin.codegen.folder.folder import write_folder
from symkin.codegen.folder.vectors import build_vectors
from symkin.codegen.map.options import Options
from symkin.codegen.map.program import Program, build_program
from symkin.codegen.map.rod_platform import RodPlatform, sample_poses
from symkin.codegen.map.signature import Function
from symkin.codegen.steps.samples import rounded_to
from symkin.codegen.text.c import Real
from symkin.formats.load import load
from symkin.position.problem import actuated_names, build_problem
from symkin.spatial.rotation import multiply

MAIN = """
#include "board.h"
#include <math.h>
#include <string.h>
#include "@{name}.h"
#ifndef REPEATS
#define REPEATS 16 /* solves of one case, at different places within a tick of the counter */
#endif
@{tables}
static uint32_t measured(int kind, int k, double *error)
{
    const @{name}_real *const starts[] = { @{starts} };
    const double *const expected[] = { @{expected} };
    @{name}_real result[@{width}]@{others};
    @{name}_info info;
    int status;
    uint32_t total = 0u;
    (void)info;
    for (int r = 0; r < REPEATS; ++r) {
        for (volatile int shift = 0; shift < r; ++shift) { }
        memcpy(result, starts[kind], sizeof result);
        const uint32_t begin = board_ticks();
        @{call}
        total += (board_ticks() - begin) & 0xFFFFFFu;
        @{after}
        *error = 0.0;
        for (int i = 0; i < @{checked}; ++i) {
            *error = fmax(*error, fabs((double)result[i] - expected[kind][i]));
        }
        if (status != 0) { *error = 4e9; }
    }
    return total * board_tick_instructions() / (uint32_t)REPEATS;
}
int main(void)
{
    board_start_counter();
    for (int kind = 0; kind < @{kinds}; ++kind) {
        for (int k = 0; k < @{count}; ++k) {
            double error;
            const uint32_t instructions = measured(kind, k, &error);
            const uint32_t told[] = { (uint32_t)kind, instructions,
                (uint32_t)fmin(error * 1e12, 4e9), (uint32_t)fmin(error * 1e6, 4e9) };
            for (int i = 0; i < 4; ++i) {
                board_number(told[i]);
                board_text((i < 3) ? " " : "\\n");
            }
        }
    }
    return 0;
}
"""
NEAREST = """double least = 4e9; /* of all branches, the one that is nearest to the answer */
        for (int row = 0; row < found; ++row) {
            double most = 0.0;
            for (int i = 0; i < @{width}; ++i) {
                most = fmax(most, fabs((double)all[row][i] - expected[kind][i]));
            }
            if (most < least) { least = most; memcpy(result, all[row], sizeof result); }
        }"""


class Case(NamedTuple):
    """What is measured: a function and the tables of what it is given, where it starts and what it
    must find.
    """

    name: str
    function: str
    given: tuple[str, ...]
    start: str
    expected: str


CASES = {
    "parallel": (
        Case("cold", "direct", ("joints",), "home", "poses"),
        Case("warm", "direct", ("joints",), "guesses", "poses"),
        Case("track", "track", ("joints",), "guesses", "poses"),
    ),
    "serial": tuple(
        Case(name, name, ("poses",), "guesses", "inverse")
        for name in ("inverse", "inverse_nearest", "inverse_all")
    ),
    "map": (
        Case("cold", "direct", ("joints",), "home_found", "found"),
        Case("warm", "direct", ("joints",), "guesses", "found"),
        Case("back, cold", "inverse", ("found",), "home_joints", "inverse"),
        Case("back, warm", "inverse", ("found",), "joint_guesses", "inverse"),
        Case("track", "track", ("joints",), "guesses", "found"),
        Case("track back", "track_inverse", ("found",), "joint_guesses", "inverse"),
        Case("derivatives", "second", ("joints", "found"), "found", "found"),
    ),
}
"""Of each kind of machine; the last one of a map is the Jacobian and the second derivatives."""


@dataclass(frozen=True)
class Harness:
    """A folder with bench.c and SOURCE.c; `calls` are the functions that are measured, `kinds` the
    names of the cases.
    """

    folder: Path
    source: str
    calls: tuple[str, ...]
    kinds: tuple[str, ...]


def harness_of(source: str, options: Options) -> Harness:
    """The folder of a shipped mechanism or a file, written anew, with its bench."""
    program, folder = build_program(load(source), options), Path(tempfile.mkdtemp())
    write_folder(program.described, folder, options)
    (folder / "bench.c").write_text(main_text(program))
    name, cases = program.mechanism.name, cases_of(program)
    calls = tuple(dict.fromkeys(f"{name}_{case.function}" for case in cases))
    return Harness(folder, name, calls, tuple(case.name for case in cases))


def cases_of(program: Program) -> Sequence[Case]:
    """The cases of a machine: of an arm without a closed form the first one."""
    cases = CASES[program.kind.templates]
    declared = program.header
    name = program.mechanism.name
    return [case for case in cases if f" {name}_{case.function}(" in declared]


def table(kind: str, name: str, rows: np.ndarray, real: Real) -> str:
    lines = (", ".join(real.hexadecimal(float(v)) for v in row) for row in rows)
    held = ", ".join(f"{{ {line} }}" for line in lines)
    return f"static const {kind} {name}[{rows.shape[0]}][{rows.shape[1]}] = {{ {held} }};"


def tables_of(program: Program) -> dict[str, np.ndarray]:
    """The rows that are solved, by the name of their table."""
    kind = program.kind
    if isinstance(kind, RodPlatform) and kind.options.home == HOME:
        return platform_tables(kind)
    vectors = build_vectors(kind)
    rows = {k: v for k, v in vectors.answers.items() if k not in ("jacobians", "seconds")}
    if kind.templates != "serial":
        rows = {name: table[1::2] for name, table in rows.items()}
    count = len(rows["joints"])
    return rows | {name: np.tile(row, (count, 1)) for name, row in vectors.places.items()}


def platform_tables(platform: RodPlatform) -> dict[str, np.ndarray]:
    """64 poses within 60 mm and 0.25 rad of home; warm starts lie within 0.2 mm and 1 mrad of the
    answer.
    """
    system = build_problem(platform.mechanism, actuated_names(platform.mechanism)).system
    rng, relative = np.random.default_rng(3), platform.options.home_relative
    origin = np.array(platform.home.position) if relative else np.zeros(3)
    joints, warm, answers = [], [], []
    for pose in sample_poses(platform.home, 64, 60.0, 0.25, 7):
        given = rounded_to(platform.real, platform.joint_values(pose))
        z = np.array([*pose.position, *pose.quaternion])
        for _ in range(2):
            z = system.polish(z, given + platform.zero, 8)
        q = multiply(np.array([1.0, *(0.5 * rng.uniform(-1e-3, 1e-3, 3))]), z[3:])
        joints.append(given)
        warm.append([*(z[:3] + rng.uniform(-0.2, 0.2, 3) - origin), *(q / np.linalg.norm(q))])
        answers.append([*(z[:3] - origin), *z[3:]])
    home = np.tile(platform.stated(platform.home), (64, 1))
    tables = {"joints": joints, "home": home, "guesses": warm, "poses": answers}
    return {name: np.array(rows) for name, rows in tables.items()}


def main_text(program: Program) -> str:
    """bench.c of a mechanism."""
    name, real, cases = program.mechanism.name, program.real, cases_of(program)
    rows, poses = tables_of(program), program.kind.templates == "parallel"
    n, count = rows["joints"].shape[1], len(rows["joints"])
    read = dict.fromkeys(part for case in cases for part in (*case.given, case.start))
    tables = [table(real.type, key, rows[key], real) for key in read]
    exact = dict.fromkeys(case.expected for case in cases)
    tables += [table("double", f"exact_{key}", rows[key], Real("double")) for key in exact]
    struct = program.options.geometry == "struct"
    if struct:
        tables.append(f"static const {name}_geometry nominal = {name.upper()}_NOMINAL;")
    others = f", jacobian[{n * n}], second[{n**3}]" if program.kind.templates == "map" else ""
    after = ""
    if any(case.function == "inverse_all" for case in cases):
        others += f", all[{name.upper()}_BRANCHES][{n}]; int found = 0"
        after = NEAREST.replace("@{width}", str(n))
    functions = {f.name: f for f in program.functions}
    calls = (_call(functions.get(case.function), name, case, struct=struct) for case in cases)
    values = {
        "name": name,
        "tables": "\n".join(tables),
        "starts": ", ".join(f"{case.start}[k]" for case in cases),
        "expected": ", ".join(f"exact_{case.expected}[k]" for case in cases),
        "width": 7 if poses else n,
        "others": others,
        "call": " else ".join(f"if (kind == {k}) {{ {call} }}" for k, call in enumerate(calls))
        + " else { status = 1; }",
        "after": after,
        "checked": 3 if poses else n,
        "kinds": len(cases),
        "count": count,
    }
    return filled(values)


def filled(values: Mapping[str, object]) -> str:
    """MAIN with its holes filled."""
    return re.sub(r"@\{(\w+)\}", lambda hole: str(values[hole[1]]), MAIN)


def _call(function: Function | None, name: str, case: Case, *, struct: bool) -> str:
    """The call of a case: what it gives begins as its start."""
    if function is None:
        pose = f"(const {name}_pose *){case.given[0]}[k]"
        return f"found = {name}_inverse_all({pose}, all); status = (found == 0);"
    given = iter(case.given)
    arguments = (["&nominal"] if struct else []) + (["0"] if function.config else [])
    for value in (*function.takes, *function.gives):
        read = value in function.takes
        told = (
            "starts[kind]" if value.name == "guess" else f"{next(given)}[k]" if read else "result"
        )
        told = value.name if value.type == "matrix" else told
        as_pose = "" if value.count else f"({'const ' if read else ''}{name}_pose *)"
        arguments.append(as_pose + told)
    arguments += ["&info"] if function.info else []
    return f"status = (int){name}_{function.name}({', '.join(arguments)});"


def from_folder(folder: Path) -> str:
    """bench.c for a folder, by the options that its manifest names."""
    manifest = json.loads((folder / "manifest.json").read_text())
    chosen = manifest["options"]
    home = tuple(chosen["home"]) if chosen["home"] else None
    between = {key: tuple(chosen.get(key, ())) for key in ("given", "find")}
    options = Options(chosen["real"], chosen["home_relative"], chosen["geometry"], home, **between)
    return main_text(build_program(load(manifest["mechanism"]), options))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the bench of a folder of generated C.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", type=Path, required=True, metavar="FILE")
    given = parser.parse_args()
    given.o.write_text(from_folder(given.folder))
