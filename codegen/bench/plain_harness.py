"""C main files that solve the same cases by CasADi's C and by symkin's: same closure, starts,
tolerance and flags.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import NamedTuple

import casadi as ca
import numpy as np

from bench_cases import cases_of
from harness import Harness, filled, harness_of, table
from plain_casadi import PlainCasadi
from symkin.codegen.folder import write_folder
from symkin.codegen.text.c import Real

EXACT = Real("double")
POSES = 12
"""Poses (an arm's joint values) at which Jacobians are counted."""


def newton_harnesses(plain: PlainCasadi) -> dict[str, Harness]:
    """NAME_direct of a platform, NAME_inverse of an arm, by both."""
    return {
        "symkin": harness_of(plain.name, plain.program.options),
        "CasADi": _casadi_newton(plain),
    }


def matrix_harnesses(plain: PlainCasadi) -> dict[str, Harness]:
    """NAME_jacobian, by both; CasADi's reads the passive joints, symkin's computes them from the
    pose.
    """
    cases = cases_of(plain.program.kind)
    places = cases["expected"][:POSES]
    inputs = np.array([plain.matrix_input(place) for place in places])
    expected = np.array([np.array(plain.matrix(v)).ravel(order="F") for v in inputs])
    return {
        "symkin": _symkin_matrix(plain, places, expected),
        "CasADi": _casadi_matrix(plain, inputs, expected),
    }


def _casadi_newton(plain: PlainCasadi) -> Harness:
    cases, serial = cases_of(plain.program.kind), plain.mechanism.serial
    n = int(plain.newton.size1_out(0))
    if serial:
        starts, known, offset, checked = [cases["guesses"]], cases["poses"], 0, n
    else:
        starts = [
            np.array([plain.unknowns_at(pose) for pose in cases[key]]) for key in ("cold", "warm")
        ]
        known, offset, checked = cases["joints"], plain.places(("pose.x",))[0], 3
    tables = [_given(plain, f"start{k}", rows) for k, rows in enumerate(starts)]
    tables += [_given(plain, "known", known), table("double", "expected", cases["expected"], EXACT)]
    begin = "(kind == 0) ? start0[k] : start1[k]" if len(starts) == 2 else "start0[k]"
    prepare = (
        f"{plain.real} z[{n}]; const {plain.real} *const result = z + {offset}; int status; "
        f"(void)kind;"
    )
    names = ("inverse",) if serial else ("cold", "warm")
    return _casadi(
        plain,
        Call(plain.newton, (begin, "known[k]"), "z"),
        tables,
        prepare,
        checked,
        names,
        len(known),
    )


def _casadi_matrix(plain: PlainCasadi, inputs: np.ndarray, expected: np.ndarray) -> Harness:
    tables = [_given(plain, "input", inputs), table("double", "expected", expected, EXACT)]
    prepare = f"{plain.real} result[{expected.shape[1]}]; int status; (void)kind;"
    called = Call(plain.matrix, ("input[k]",), "result")
    return _casadi(plain, called, tables, prepare, expected.shape[1], ("jacobian",), len(inputs))


def _given(plain: PlainCasadi, name: str, rows: np.ndarray) -> str:
    """A table of inputs in the type of the C."""
    return table(plain.real, name, rows, plain.program.real)


class Call(NamedTuple):
    """A function of CasADi's C with the texts of its arguments and of the array for its result."""

    function: ca.Function
    arguments: tuple[str, ...]
    output: str


def _casadi(
    plain: PlainCasadi,
    called: Call,
    tables: list[str],
    prepare: str,
    checked: int,
    kinds: tuple[str, ...],
    count: int,
) -> Harness:
    """A call of one of CasADi's functions with the work arrays that it asks for."""
    function = called.function
    folder = Path(tempfile.mkdtemp())
    plain.generate(folder)
    work = f"""static {plain.real} w[{function.sz_w() + 1}];
        static casadi_int iw[{function.sz_iw() + 1}];
        const {plain.real} *arg[{function.sz_arg() + 1}] = {{ {", ".join(called.arguments)} }};
          {plain.real} *res[{function.sz_res() + 1}] = {{ {called.output} }};"""
    call = f"status = {function.name()}(arg, res, iw, w, 0);"
    text = filled(
        f'#include "{plain.source}.h"',
        tables,
        f"{prepare} {work}",
        call,
        checked,
        len(kinds),
        count,
    )
    (folder / "bench.c").write_text(text)
    return Harness(folder, plain.source, (function.name(),), kinds)


def _symkin_matrix(plain: PlainCasadi, places: np.ndarray, expected: np.ndarray) -> Harness:
    name, program = plain.name, plain.program
    folder = Path(tempfile.mkdtemp())
    write_folder(program.mechanism, folder, program.options)
    tables = [_given(plain, "place", places), table("double", "expected", expected, EXACT)]
    prepare = f"{plain.real} result[{expected.shape[1]}]; int status; (void)kind;"
    if program.mechanism.serial:
        call = f"status = (int){name}_jacobian(place[k], result);"
    else:
        prepare += f""" {name}_pose pose;
        for (int i = 0; i < 3; ++i) {{ pose.position[i] = place[k][i]; }}
        for (int i = 0; i < 4; ++i) {{ pose.quaternion[i] = place[k][3 + i]; }}"""
        call = f"status = (int){name}_jacobian(&pose, result);"
    text = filled(f'#include "{name}.h"', tables, prepare, call, expected.shape[1], 1, len(places))
    (folder / "bench.c").write_text(text)
    return Harness(folder, name, (f"{name}_jacobian",), ("jacobian",))
