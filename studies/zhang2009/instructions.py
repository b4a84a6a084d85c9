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


def bench_tools() -> tuple[Any, Any]:
    """The modules `harness` and `processors` of codegen/bench."""
    if str(BENCH) not in sys.path:
        sys.path.append(str(BENCH))
    import harness
    import processors

    return harness, processors


def _tables(start: np.ndarray, known: np.ndarray, expected: np.ndarray) -> list[str]:
    harness, _ = bench_tools()
    exact = harness.Real("double")
    return [
        harness.table("double", n, v[None], exact)
        for n, v in (("begin", start), ("known", known), ("exact", expected))
    ]


def _folder(
    source: str, include: str, tables: list[str], width: int, others: str, call: str, measured: str
) -> Any:
    """A folder with the main file; `others` are declared behind the result's `width` numbers."""
    harness, _ = bench_tools()
    values = {
        "name": include,
        "tables": "\n".join(tables),
        "starts": "begin[k]",
        "expected": "exact[k]",
        "width": width,
        "others": others,
        "call": call,
        "after": "",
        "checked": 3,
        "kinds": 1,
        "count": 1,
    }
    folder = Path(tempfile.mkdtemp())
    (folder / "bench.c").write_text(harness.filled(values))
    return harness.Harness(folder, source, (measured,), ("example",))


def _types(name: str) -> str:
    """The types that the main file knows of symkin's C, for C that has none."""
    return f"typedef double {name}_real; typedef int {name}_info;"


def newton_harness(closure: Closure, start: np.ndarray, expected: np.ndarray) -> Any:
    """The paper's iteration on a closure, written out in C."""
    function, n = PaperNewton(closure).evaluate, int(closure.X.shape[0])
    tables = [_types("written"), *_tables(start, TABLE_1 / BASE_RADIUS, expected)]
    call = "status = written(known[k], result);"
    bench = _folder("newton", "written", tables, n, "", call, "written")
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
    (bench.folder / "newton.c").write_text(f'#include "f_d.c"\n{text}')
    return bench


def fast_newton_harness(closure: Closure, start: np.ndarray, expected: np.ndarray) -> Any:
    """CasADi's own C of a fast_newton rootfinder on a closure."""
    problem = {"x": closure.X, "p": closure.u, "g": closure.F}
    solver = ca.rootfinder(
        "solver",
        "fast_newton",
        problem,
        {"abstol": CLOSED_SCALED, "abstolStep": CLOSED_SCALED, "max_iter": MOST},
    )
    n, sizes = (
        int(closure.X.shape[0]),
        [solver.sz_arg(), solver.sz_res(), solver.sz_iw(), solver.sz_w()],
    )
    others = f"""; static double w[{sizes[3] + 1}]; static casadi_int iw[{sizes[2] + 1}];
    const double *arg[{sizes[0] + 1}] = {{ begin[k], known[k] }};
    double *res[{sizes[1] + 1}] = {{ result }}"""
    tables = [_types("solver_c"), *_tables(start, TABLE_1 / BASE_RADIUS, expected)]
    call = "status = solver(arg, res, iw, w, 0);"
    bench = _folder("solver_c", "solver_c", tables, n, others, call, "solver")
    generator = ca.CodeGenerator("solver_c.c", {"with_header": True})
    generator.add(solver)
    generator.generate(f"{bench.folder}/")
    return bench


def symkin_harness(expected: np.ndarray) -> Any:
    """symkin's C of this platform, its branch check included, from the same start."""
    first = quaternion_pose(START)
    tables = _tables(np.array([*first.position, *first.quaternion]), TABLE_1, expected)
    others = "; zhang2009_pose *const pose = (zhang2009_pose *)result"
    call = "status = (int)zhang2009_direct(0, known[k], pose, pose, &info);"
    bench = _folder("zhang2009", "zhang2009", tables, 7, others, call, "zhang2009_direct")
    write_folder(symkin.load("zhang2009"), bench.folder, Options("double", home=HOME))
    return bench


def contenders() -> dict[str, tuple[Callable[[], Any], float]]:
    """What is counted, and the factor that makes its error mm."""
    mode = symkin.modes(symkin.load("zhang2009"), joints=TABLE_1)[0].pose
    X, begin = scaled(euler_pose(mode)), scaled(START)
    six, more = six_unknowns(), quadratic_unknowns()
    return {
        "six": (lambda: newton_harness(six, begin, X[:3]), BASE_RADIUS),
        "twenty-four": (
            lambda: newton_harness(more, unknowns_of(begin), unknowns_of(X)[:3]),
            BASE_RADIUS,
        ),
        "fast_newton": (lambda: fast_newton_harness(six, begin, X[:3]), BASE_RADIUS),
        "symkin": (lambda: symkin_harness(np.array(mode.position)), 1.0),
    }


def counts(
    names: tuple[str, ...] | None = None, processors: tuple[str, ...] = PROCESSORS
) -> dict[str, dict[str, Any]]:
    """Instructions and error in mm of each contender on each processor."""
    _, tools = bench_tools()
    found: dict[str, dict[str, Any]] = {}
    for name, (build, millimetres) in contenders().items():
        if names is None or name in names:
            figures = {p: tools.measure(build(), p)["example"] for p in processors}
            found[name] = {
                p: {"instructions": int(f.mean), "error": f.error * millimetres}
                for p, f in figures.items()
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
