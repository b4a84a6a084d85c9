"""Run a Jacobian that was written in another language."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi
import numpy as np

from helpers.inside import jacobian_text, symbols_read
from helpers.latex_reader import evaluated

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"]


def run_exported(symbolic: Any, language: str, inputs: Sequence[float], folder: Path) -> np.ndarray:
    """The matrix of a file in one of the formats."""
    match language:
        case "numpy":
            return module_of(jacobian_text(symbolic, "numpy"))["jacobian"](*inputs)
        case "sympy":
            return np.array(
                module_of(jacobian_text(symbolic, "sympy"))["lambdified"]()(*inputs), dtype=float
            )
        case "c":
            return run_c(symbolic, inputs, folder)
        case "latex":
            return run_latex(symbolic, inputs)
    (folder / "j.casadi").write_text(jacobian_text(symbolic, "casadi"))
    return casadi.Function.load(str(folder / "j.casadi")).call(list(inputs))[0].full()


def module_of(text: str) -> dict[str, Any]:
    scope: dict = {}
    exec(compile(text, "exported", "exec"), scope)
    return scope


def run_c(symbolic: Any, inputs: Sequence[float], folder: Path) -> np.ndarray:
    """The matrix of the C file, compiled."""
    (folder / "j.c").write_text(jacobian_text(symbolic, "c"))
    subprocess.run(
        ["gcc", *STRICT, "-shared", "-fPIC", "-o", folder / "j.so", folder / "j.c", "-lm"],
        check=True,
        capture_output=True,
    )
    function = getattr(
        ctypes.CDLL(str(folder / "j.so")), f"{symbolic.mechanism.name}_{symbolic.kind}_jacobian"
    )
    split = len(symbolic.inputs)
    arrays = [
        (ctypes.c_double * len(part))(*part)
        for part in (inputs[:split], *([inputs[split:]] if inputs[split:] else []))
    ]
    matrix = np.zeros(symbolic.shape)
    function(*arrays, matrix.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
    return matrix


def run_latex(symbolic: Any, inputs: Sequence[float]) -> np.ndarray:
    """The document's equations, read back as arithmetic."""
    text = jacobian_text(symbolic, "latex")
    lines = [
        line.removesuffix(r" \\").split(" &= ", 1) for line in text.splitlines() if " &= " in line
    ]
    symbols = symbols_read(symbolic)
    matrix, filled = np.zeros(symbolic.shape), [line for line in lines if line[0].startswith("J_{")]
    defined = [(name, value) for name, value in lines if not name.startswith("J_{")]
    values = evaluated(
        defined, [value for _, value in filled], dict(zip(symbols, inputs, strict=True))
    )
    for (name, _), value in zip(filled, values, strict=True):
        i, j = name[3:-1].split(",")
        matrix[int(i) - 1, int(j) - 1] = value
    return matrix
