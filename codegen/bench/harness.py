"""A C main file that solves the bench's cases, for any processor with `targets/board.h`.

    python codegen/bench/harness.py FOLDER -o bench.c

writes it for a committed folder, as `targets/host/Makefile` does.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench_cases import cases_of
from symkin.codegen.folder import write_folder
from symkin.codegen.joint_map import JointMap
from symkin.codegen.options import Options
from symkin.codegen.program import Program, build_program
from symkin.codegen.text.c import Real
from symkin.formats.load import load

MAIN = """
#include "board.h"
#include <math.h>
@include@
#ifndef REPEATS
#define REPEATS 16 /* solves of one case, at different places within a tick of the counter */
#endif
@tables@
static uint32_t measured(int kind, int k, double *error)
{
    uint32_t total = 0u;
    for (int r = 0; r < REPEATS; ++r) {
        for (volatile int shift = 0; shift < r; ++shift) { }
        @prepare@
        const uint32_t begin = board_ticks();
        @call@
        total += (board_ticks() - begin) & 0xFFFFFFu;
        @after@
        *error = 0.0;
        for (int i = 0; i < @checked@; ++i) {
          *error = fmax(*error, fabs((double)result[i] - expected[k][i])); }
        if (status != 0) { *error = 4e9; }
    }
    return total * board_tick_instructions() / (uint32_t)REPEATS;
}
int main(void)
{
    board_start_counter();
    for (int kind = 0; kind < @kinds@; ++kind) {
        for (int k = 0; k < @count@; ++k) {
            double error;
            const uint32_t instructions = measured(kind, k, &error);
            board_number((uint32_t)kind); board_text(" "); board_number(instructions);
              board_text(" ");
            board_number((uint32_t)fmin(error * 1e12, 4e9)); board_text(" ");
              board_number((uint32_t)fmin(error * 1e6, 4e9)); board_text("\\n");
        }
    }
    return 0;
}
"""


MAP_KINDS = ("cold", "warm", "back, cold", "back, warm", "track", "track back", "derivatives")
"""Cases of a map between joints; the last one is the Jacobian and the second derivatives."""


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
    program = build_program(load(source), options)
    name = program.mechanism.name
    folder = Path(tempfile.mkdtemp())
    write_folder(program.described, folder, options)
    (folder / "bench.c").write_text(main_text(program))
    if isinstance(program.kind, JointMap):
        calls = ("direct", "inverse", "track", "track_inverse", "second")
        return Harness(folder, name, tuple(f"{name}_{call}" for call in calls), MAP_KINDS)
    if program.mechanism.serial:
        closed = program.kind.plan is not None  # type: ignore[union-attr] - of a serial arm
        calls = ("inverse", "inverse_nearest", "inverse_all") if closed else ("inverse",)
        return Harness(folder, name, tuple(f"{name}_{call}" for call in calls), calls)
    return Harness(folder, name, (f"{name}_direct", f"{name}_track"), ("cold", "warm", "track"))


def main_text(program: Program) -> str:
    """bench.c of a mechanism."""
    if isinstance(program.kind, JointMap):
        return _map_text(program)
    return _serial_text(program) if program.mechanism.serial else _platform_text(program)


def table(kind: str, name: str, rows: np.ndarray, real: Real) -> str:
    lines = ", ".join(
        "{ " + ", ".join(real.hexadecimal(float(v)) for v in row) + " }" for row in rows
    )
    return f"static const {kind} {name}[{rows.shape[0]}][{rows.shape[1]}] = {{ {lines} }};"


def filled(
    include: str,
    tables: list[str],
    prepare: str,
    call: str,
    checked: int,
    kinds: int,
    count: int,
    after: str = "",
) -> str:
    """MAIN with its parts filled in; `after` follows the call that is measured."""
    values = {
        "include": include,
        "tables": "\n".join(tables),
        "prepare": prepare,
        "call": call,
        "checked": checked,
        "kinds": kinds,
        "count": count,
        "after": after,
    }
    text = MAIN
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text


def _nominal(program: Program) -> tuple[str, list[str]]:
    """The first argument of each call, and what it points at."""
    name = program.mechanism.name
    if program.options.geometry == "fixed":
        return "", []
    return "&nominal, ", [f"static const {name}_geometry nominal = {name.upper()}_NOMINAL;"]


def _platform_text(program: Program) -> str:
    name, real = program.mechanism.name, program.real
    cases = cases_of(program.kind)
    tables = [table(real.type, key, cases[key], real) for key in ("joints", "cold", "warm")]
    tables.append(table("double", "expected", cases["expected"], Real("double")))
    first, nominal = _nominal(program)
    prepare = f"""const {real.type} *const start = (kind == 0) ? cold[k] : warm[k];
        {name}_pose pose; {name}_info info; int status;
          const {real.type} *const result = pose.position;
        for (int i = 0; i < 3; ++i) {{ pose.position[i] = start[i]; }}
        for (int i = 0; i < 4; ++i) {{ pose.quaternion[i] = start[3 + i]; }}"""
    direct = f"(int){name}_direct({first}0, joints[k], &pose, &pose, &info)"
    call = f"status = (kind < 2) ? {direct} : (int){name}_track({first}joints[k], &pose, &info);"
    return filled(
        f'#include "{name}.h"', tables + nominal, prepare, call, 3, 3, len(cases["joints"])
    )


def _map_text(program: Program) -> str:
    name, real, cases = program.mechanism.name, program.real, cases_of(program.kind)
    n = cases["joints"].shape[1]
    tables = [table(real.type, key, rows, real) for key, rows in cases.items() if key != "inverse"]
    tables += [
        table("double", f"expected_{key}", cases[of], Real("double"))
        for key, of in (("found", "found"), ("joints", "inverse"))
    ]
    prepare = f"""const bool back = (kind == 2) || (kind == 3) || (kind == 5);
        const bool cold = (kind == 0) || (kind == 2);
        const {real.type} *const start = back ? (cold ?
          cold_joint_guesses[0] : joint_guesses[k]) : (cold ? cold_guesses[0] : guesses[k]);
        {real.type} jacobian[{n * n}], second[{n**3}];
        const double (*const expected)[{n}] = back ? expected_joints : expected_found;
        {real.type} result[{n}]; {name}_info info; int status;
        for (int i = 0; i < {n}; ++i) {{ result[i] = start[i]; }}"""
    call = f"""if (kind < 2) {{ status = (int){name}_direct(0, joints[k], start, result, &info); }}
        else if (kind < 4) {{ status = (int){name}_inverse(0, found[k], start, result, &info); }}
        else if (kind == 4) {{ status = (int){name}_track(joints[k], result, &info); }}
        else if (kind == 5) {{
          status = (int){name}_track_inverse(found[k], result, &info); }}
        else {{ status = (int){name}_second(joints[k], found[k], jacobian, second); }}"""
    after = f"""if (kind == 6) {{ for (int i = 0; i < {n}; ++i) {{ result[i] = found[k][i]; }} }}"""
    include = f'#include "{name}.h"\n#include <stdbool.h>'
    return filled(include, tables, prepare, call, n, len(MAP_KINDS), len(cases["joints"]), after)


def _serial_text(program: Program) -> str:
    name, real = program.mechanism.name, program.real
    cases, n = cases_of(program.kind), len(program.mechanism.actuated)
    tables = [table(real.type, key, cases[key], real) for key in ("guesses", "poses")]
    tables.append(table("double", "expected", cases["expected"], Real("double")))
    first, nominal = _nominal(program)
    prepare = f"""{name}_pose pose; {name}_info info; {real.type} result[{n}]; int status;
        (void)kind;
        for (int i = 0; i < 3; ++i) {{ pose.position[i] = poses[k][i]; }}
        for (int i = 0; i < 4; ++i) {{ pose.quaternion[i] = poses[k][3 + i]; }}"""
    call = f"status = (int){name}_inverse({first}0, &pose, guesses[k], result, &info);"
    if program.kind.plan is None:  # type: ignore[union-attr] - of a serial arm
        return filled(
            f'#include "{name}.h"', tables + nominal, prepare, call, n, 1, len(cases["poses"])
        )
    prepare += f" {real.type} all[{name.upper()}_BRANCHES][{n}]; int found = 0;"
    call = f"""if (kind == 0) {{ {call} }}
        else if (kind == 1) {{ status = (int){name}_inverse_nearest(&pose, guesses[k], result); }}
        else {{ found = {name}_inverse_all(&pose, all); status = (found == 0); }}"""
    # of all branches, the one that is nearest to the answer
    after = f"""double least = 4e9;
        for (int row = 0; row < found; ++row) {{
            double most = 0.0;
            for (int i = 0; i < {n}; ++i) {{
              most = fmax(most, fabs((double)all[row][i] - expected[k][i])); }}
            if (most < least) {{ least = most; for (int i = 0; i < {n}; ++i) {{
              result[i] = all[row][i]; }} }}
        }}"""
    return filled(
        f'#include "{name}.h"', tables + nominal, prepare, call, n, 3, len(cases["poses"]), after
    )


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
