"""Write a symbolic Jacobian in one of the formats: CasADi, C, NumPy, SymPy, LaTeX."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import casadi as ca

from symkin.codegen.jacobian_c import c_source
from symkin.codegen.jacobian_header import header
from symkin.codegen.jacobian_latex import latex_source
from symkin.codegen.jacobian_python import numpy_source, sympy_source
from symkin.errors import InputError
from symkin.files.outputs import write_output
from symkin.text import not_among
from symkin.velocity.jacobian import AnyJacobian


def casadi_source(jacobian: AnyJacobian) -> str:
    """What `casadi.Function.load` reads: a function of one scalar for each input, by name, with the
    output `jacobian`; the lines about it follow after its end, where loading has stopped.
    """
    names = {v.name: v.name for v in (*jacobian.inputs, *jacobian.parameters)}
    packed = ca.StringSerializer()
    packed.pack(jacobian.function)
    return "\n".join(
        [packed.encode(), *(f"# {line}".rstrip() for line in header(jacobian, names)), ""]
    )


FORMATS: dict[str, Callable[[AnyJacobian], str]] = {
    "casadi": casadi_source,
    "c": c_source,
    "numpy": numpy_source,
    "sympy": sympy_source,
    "latex": latex_source,
}


def jacobian_text(jacobian: AnyJacobian, language: str) -> str:
    """The Jacobian in a format of FORMATS; the same bytes for the same model. InputError for an
    unknown format.
    """
    if language not in FORMATS:
        raise InputError(f"format = {not_among(language, FORMATS)}")
    return FORMATS[language](jacobian)


def write_jacobian(jacobian: AnyJacobian, language: str, path: str | Path) -> None:
    """Write the Jacobian into a file, whole or not at all."""
    write_output(path, jacobian_text(jacobian, language))
