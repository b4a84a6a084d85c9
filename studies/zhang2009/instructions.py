"""Instructions of the paper's example in C: its Newton's method in six and in 24 unknowns, CasADi's
fast_newton, and symkin's C.

    python studies/zhang2009/instructions.py [--write]

Each solves table 1 from (0, 0, 100; 0, 0, 0) in double precision. F and D are C by CasADi's
generator; the Gauss-Jordan inverse and the update are written out here as `newton` has them.
Counted as codegen/bench counts: under QEMU on a Cortex-M7, by valgrind on the host (x86-64), GCC
-O2. `--write` keeps the counts in instructions.json, which `claims` reads.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

import symkin
from symkin.codegen.folder.folder import write_folder
from symkin.codegen.map.options import Options

if __name__ == "__main__":  # run as a file: modules are named from the folder that holds studies
    sys.path[0] = str(Path(__file__).resolve().parents[2])

from studies.shared.guesses import Closure
from studies.zhang2009.model import (
    BASE_RADIUS,
    START,
    TABLE_1,
    euler_pose,
    quadratic_unknowns,
    quaternion_pose,
    scaled,
    six_unknowns,
    unknowns_of,
)
from studies.zhang2009.newton import CLOSED_SCALED, MOST, PaperNewton

COMMITTED = Path(__file__).with_suffix(".json")
BENCH = Path(__file__).resolve().parents[2] / "codegen" / "bench"
PROCESSORS = ("M7", "host")
HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
"""Home of the committed C of this platform (codegen/generate.py)."""

NEWTON = """
#include <math.h>
#include "written.h"
#define N @n@
static int invert(double work[N][2 * N])
{
    for (int k = 0; k < N; ++k) {
        int best = k;
        for (int i = k + 1; i < N; ++i) { if (fabs(work[i][k]) > fabs(work[best][k])) { best = i;
          } }
        if (!(fabs(work[best][k]) > 0.0)) { return 1; }
        for (int j = 0; j < 2 * N; ++j) { const double t = work[k][j]; work[k][j] = work[best][j];
          work[best][j] = t; }
        const double pivot = work[k][k];
        for (int j = 0; j < 2 * N; ++j) { work[k][j] /= pivot; }
        for (int i = 0; i < N; ++i) {
            const double factor = work[i][k];
            if (i != k) { for (int j = 0; j < 2 * N; ++j) { work[i][j] -= factor * work[k][j]; } }
        }
    }
    return 0;
}
int written(const double *u, double *X)
{
    static double F[N], D[N * N], work[N][2 * N], w[@w@];
    static casadi_int iw[@iw@];
    for (int step = 0; step <= @most@; ++step) {
        const double *arg[@arg@] = { X, u };
        double *res[@res@] = { F, D };
        double largest = 0.0;
        (void)F_D(arg, res, iw, w, 0);
        for (int i = 0; i < N; ++i) { largest = fmax(largest, fabs(F[i])); }
        if (largest < @closed@) { return 0; }
        for (int i = 0; i < N; ++i) {
            for (int j = 0; j < N; ++j) { work[i][j] = D[i + j * N];
              work[i][N + j] = (i == j) ? 1.0 : 0.0; }
        }
        if (invert(work) != 0) { return 1; }
        for (int i = 0; i < N; ++i) { for (int j = 0; j < N; ++j) { X[i] -= work[i][N + j] * F[j];
          } }
    }
    return 1;
}
"""


MAIN = """
#include "board.h"
#include <math.h>
#include <string.h>
@declared@
static const double begin[] = { @begin@ }, known[] = { @known@ }, exact[] = { @exact@ };
int main(void)
{
    double result[sizeof begin / sizeof begin[0]], error = 0.0;
    int status;
    @others@
    memcpy(result, begin, sizeof result);
    board_start_counter();
    const uint32_t at = board_ticks();
    @call@
    const uint32_t ticks = (board_ticks() - at) & 0xFFFFFFu;
    for (int i = 0; i < 3; ++i) { error = fmax(error, fabs(result[i] - exact[i])); }
    board_number(ticks);
    board_text(" ");
    board_number((status == 0) ? (uint32_t)fmin(error * 1e9, 4e9) : 4000000000u);
    board_text("\\n");
    return 0;
}
"""


@dataclass(frozen=True)
class Bench:
    """A folder with bench.c and SOURCE.c, and the function that is counted."""

    folder: Path
    source: str
    function: str

    def counted(self, processor: str) -> tuple[int, float]:
        """Instructions of the call, and the error of its answer."""
        if str(BENCH) not in sys.path:
            sys.path.append(str(BENCH))
        import processors

        words = f"bench.c {self.source}.c"
        program = processors.linked(processor, words, self.folder)
        ticks, error = map(int, processors.said(processor, program).split())
        if processor == processors.HOST:
            return int(processors.counted(program, self.function)[0]), 1e-9 * error
        return ticks * processors.TICK, 1e-9 * error


def _bench(source: str, function: str, call: str, others: str = "", **values: object) -> Bench:
    """A folder with the main file; `others` is declared before the call."""
    declared = f'#include "{source}.h"'
    text = MAIN.replace("@declared@", declared).replace("@call@", call).replace("@others@", others)
    for key, numbers in values.items():
        told = ", ".join(float(v).hex() for v in np.ravel(np.asarray(numbers, dtype=float)))
        text = text.replace(f"@{key}@", told)
    folder = Path(tempfile.mkdtemp())
    (folder / "bench.c").write_text(text)
    return Bench(folder, source, function)


def newton_bench(closure: Closure, start: np.ndarray, expected: np.ndarray) -> Bench:
    """The paper's iteration on a closure, written out in C."""
    function, n = PaperNewton(closure).evaluate, int(closure.X.shape[0])
    rows = {"begin": start, "known": TABLE_1 / BASE_RADIUS, "exact": expected}
    bench = _bench("written", "written", "status = written(known, result);", **rows)
    generator = ca.CodeGenerator("f_d.c", {"with_header": True})
    generator.add(function)
    generator.generate(f"{bench.folder}/")
    sizes = zip(
        ("arg", "res", "iw", "w"),
        (function.sz_arg(), function.sz_res(), function.sz_iw(), function.sz_w()),
        strict=True,
    )
    values = {
        "n": n,
        "most": MOST,
        "closed": CLOSED_SCALED,
        **{key: size + 1 for key, size in sizes},
    }
    text = NEWTON
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    (bench.folder / "written.h").write_text(
        '#include "f_d.h"\nint written(const double *u, double *X);\n'
    )
    (bench.folder / "written.c").write_text(f'#include "f_d.c"\n{text}')
    return bench


def fast_newton_bench(closure: Closure, start: np.ndarray, expected: np.ndarray) -> Bench:
    """CasADi's own C of a fast_newton rootfinder on a closure."""
    problem = {"x": closure.X, "p": closure.u, "g": closure.F}
    solver = ca.rootfinder(
        "solver",
        "fast_newton",
        problem,
        {"abstol": CLOSED_SCALED, "abstolStep": CLOSED_SCALED, "max_iter": MOST},
    )
    sizes = [solver.sz_arg(), solver.sz_res(), solver.sz_iw(), solver.sz_w()]
    others = f"""static double w[{sizes[3] + 1}]; static casadi_int iw[{sizes[2] + 1}];
    const double *arg[{sizes[0] + 1}] = {{ begin, known }};
    double *res[{sizes[1] + 1}] = {{ result }};"""
    rows = {"begin": start, "known": TABLE_1 / BASE_RADIUS, "exact": expected}
    call = "status = solver(arg, res, iw, w, 0);"
    bench = _bench("solver_c", "solver", call, others, **rows)
    generator = ca.CodeGenerator("solver_c.c", {"with_header": True})
    generator.add(solver)
    generator.generate(f"{bench.folder}/")
    return bench


def symkin_bench(expected: np.ndarray) -> Bench:
    """symkin's C of this platform, its branch check included, from the same start."""
    first = quaternion_pose(START)
    rows = {"begin": [*first.position, *first.quaternion], "known": TABLE_1, "exact": expected}
    others = "zhang2009_info info; zhang2009_pose *const pose = (zhang2009_pose *)result;"
    call = "status = (int)zhang2009_direct(0, known, pose, pose, &info);"
    bench = _bench("zhang2009", "zhang2009_direct", call, others, **rows)
    write_folder(symkin.load("zhang2009"), bench.folder, Options("double", home=HOME))
    return bench


def contenders() -> dict[str, tuple[Callable[[], Bench], float]]:
    """What is counted, and the factor that makes its error mm."""
    mode = symkin.modes(symkin.load("zhang2009"), joints=TABLE_1)[0].pose
    X, begin = scaled(euler_pose(mode)), scaled(START)
    six, more = six_unknowns(), quadratic_unknowns()
    return {
        "six": (lambda: newton_bench(six, begin, X[:3]), BASE_RADIUS),
        "twenty-four": (
            lambda: newton_bench(more, unknowns_of(begin), unknowns_of(X)[:3]),
            BASE_RADIUS,
        ),
        "fast_newton": (lambda: fast_newton_bench(six, begin, X[:3]), BASE_RADIUS),
        "symkin": (lambda: symkin_bench(np.array(mode.position)), 1.0),
    }


def counts(
    names: tuple[str, ...] | None = None, processors: tuple[str, ...] = PROCESSORS
) -> dict[str, dict[str, Any]]:
    """Instructions and error in mm of each contender on each processor."""
    found: dict[str, dict[str, Any]] = {}
    for name, (build, millimetres) in contenders().items():
        if names is None or name in names:
            figures = {p: build().counted(p) for p in processors}
            found[name] = {
                p: {"instructions": count, "error": error * millimetres}
                for p, (count, error) in figures.items()
            }
    return found


@dataclass(frozen=True)
class Counts:
    """Counts as they were measured and committed."""

    content: dict[str, dict[str, Any]]

    def of(self, name: str) -> list[int]:
        """Instructions on each of PROCESSORS."""
        return [int(self.content[name][processor]["instructions"]) for processor in PROCESSORS]

    def evidence(self) -> dict[str, object]:
        """What was run, for a row of a report."""
        text = f"studies/zhang2009/{Path(__file__).name} --write, committed: QEMU, valgrind"
        return {"by": __name__, "method": "counted", "text": text}


def committed() -> Counts:
    """Read the counts of instructions.json."""
    return Counts(json.loads(COMMITTED.read_text()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--write", action="store_true", help=f"keep the counts in {COMMITTED.name}")
    measured = counts()
    print(json.dumps(measured, indent=1))
    if parser.parse_args().write:
        COMMITTED.write_text(json.dumps(measured, indent=1) + "\n")
