"""Write a symbolic Jacobian in one of the formats: CasADi, C, NumPy, SymPy, LaTeX."""

from __future__ import annotations

import keyword
import textwrap
from collections.abc import Callable, Collection, Mapping

import casadi as ca

from symkin.codegen.text.c import Emitter, Real, indent, indexed
from symkin.codegen.text.jacobian_header import allowed_names, free_prefix, header
from symkin.codegen.text.jacobian_latex import latex_source
from symkin.codegen.text.languages import NUMPY_NAMES, SYMPY_NAMES, python_language
from symkin.codegen.text.printer import Printer
from symkin.codegen.text.templates import rendered
from symkin.errors import InputError
from symkin.text import c_comment, docstring_line, not_among
from symkin.velocity.jacobian import Jacobian


def casadi_source(jacobian: Jacobian) -> str:
    """What `casadi.Function.load` reads: a function of one scalar for each input, by name, with the
    output `jacobian`; the lines about it follow after its end, where loading has stopped.
    """
    names = {v.name: v.name for v in (*jacobian.inputs, *jacobian.parameters)}
    packed = ca.StringSerializer()
    packed.pack(jacobian.function)
    return "\n".join(
        [packed.encode(), *(f"# {line}".rstrip() for line in header(jacobian, names)), ""]
    )


def c_source(jacobian: Jacobian) -> str:
    """A C99 file with the function `NAME_KIND_jacobian(variables, [geometry,] jacobian)`,
    row-major. It takes plain doubles, so that it compiles beside the firmware of the same
    mechanism, of either type.
    """
    sizes = {"variables": len(jacobian.inputs), "geometry": len(jacobian.parameters)}
    function = ca.Function(
        "f", [jacobian.symbols], [ca.densify(jacobian.expression)], {"cse": True}
    )
    inputs = [text for array, count in sizes.items() for text in indexed(array, count)]
    emitter = Emitter(function, [inputs], Real("double", "double"))
    rows, columns = jacobian.shape
    entries = [emitter.entry(i, j) for i in range(rows) for j in range(columns)]
    passed = {array: count for array, count in sizes.items() if count or array == "variables"}
    arrays = [f"const double {array}[{count or ''}]" for array, count in passed.items()]
    head = (
        f"void {jacobian.mechanism.name}_{jacobian.kind}_jacobian("
        f"{', '.join([*arrays, f'double jacobian[{rows * columns}]'])})"
    )
    body = [*emitter.lines, *(f"jacobian[{k}] = {text};" for k, text in enumerate(entries))]
    unread = [array for array in passed if not any(f"{array}[" in line for line in body)]
    body = [*(f"(void){array};" for array in unread), *body]
    about = "\n".join(f" * {c_comment(line)}".rstrip() for line in _about_arrays(jacobian))
    return f"/*\n{about}\n */\n#include <math.h>\n\n{head};\n\n{head}\n{{\n{indent(body)}\n}}\n"


def _about_arrays(jacobian: Jacobian) -> list[str]:
    names = {v.name: v.name for v in (*jacobian.inputs, *jacobian.parameters)}
    order = "variables[k] are the inputs, " if jacobian.inputs else "variables are not read, "
    order += (
        "geometry[k] the geometry, " if jacobian.parameters else ""
    ) + "jacobian is row-major."
    return [*header(jacobian, names), *textwrap.wrap(order, 110)]


# --- Python ---------------------------------------------------------------------------------------


def _module(
    template: str,
    module: str,
    functions: Mapping[str, str],
    reserved: Collection[str],
    statement: str = "{name} = {text}",
) -> Callable[[Jacobian], str]:
    """What writes a Python module that imports one other: by its template, beside whose own names
    those of the inputs stand.
    """

    def source(jacobian: Jacobian) -> str:
        names = allowed_names(jacobian, {*keyword.kwlist, module, *reserved})
        language = python_language(module, functions, free_prefix(names.values()), statement)
        printer = Printer(jacobian.function, [[name] for name in names.values()], language)
        entries, (rows, columns) = printer.entries(), jacobian.shape
        return rendered(
            template,
            about="\n".join(map(docstring_line, header(jacobian, names))),
            names=list(names.values()),
            lines=printer.lines,
            entries=entries,
            rows=rows,
            columns=columns,
            wrapped=_wrapped,
        )

    return source


def _wrapped(line: str, indent: str = "") -> str:
    """A long line with brackets over several lines."""
    return textwrap.indent(
        textwrap.fill(
            line, 110, subsequent_indent="        ", break_long_words=False, break_on_hyphens=False
        ),
        indent,
    )


# --- formats --------------------------------------------------------------------------------------

FORMATS: dict[str, Callable[[Jacobian], str]] = {
    "casadi": casadi_source,
    "c": c_source,
    "numpy": _module("numpy.txt", "np", NUMPY_NAMES, {"matrix", "jacobian", "shape"}),
    "sympy": _module(
        "sympy.txt",
        "sp",
        SYMPY_NAMES,
        {"inputs", "definitions", "matrix", "expanded", "lambdified", "named"},
        '{name} = named("{name}", {text})',
    ),
    "latex": latex_source,
}


def jacobian_text(jacobian: Jacobian, language: str) -> str:
    """The Jacobian in a format of FORMATS; the same bytes for the same model. InputError for an
    unknown format.
    """
    if language not in FORMATS:
        raise InputError(f"format = {not_among(language, FORMATS)}")
    return FORMATS[language](jacobian)
