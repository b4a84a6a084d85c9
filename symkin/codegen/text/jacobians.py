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


def numpy_source(jacobian: Jacobian) -> str:
    """A module that imports numpy only, with one function `jacobian` of the inputs (numbers, or
    arrays of one shape or of shapes that broadcast) which returns an array (..., rows, columns).
    """
    names, printer = _python(jacobian, "np", NUMPY_NAMES, {"matrix", "jacobian", "shape"})
    entries, (rows, columns) = printer.entries(), jacobian.shape
    shapes = ", ".join(f"np.shape({name})" for name in names.values())
    body = [
        '"""The Jacobian of one configuration, or of many where the inputs are arrays (shapes '
        "broadcast):",
        f'an array (..., {rows}, {columns})."""',
        *_wrapped(f"shape = {f'np.broadcast_shapes({shapes})' if names else '()'}"),
        f"matrix = np.zeros((*shape, {rows}, {columns}))",
        *printer.lines,
        *(f"matrix[..., {i}, {j}] = {text}" for (i, j), text in entries.items()),
        "return matrix",
    ]
    head = _wrapped(f"def jacobian({', '.join(names.values())}):")
    return "\n".join(
        [*_docstring(jacobian, names), "", "import numpy as np", "", "", *head, indent(body), ""]
    )


def sympy_source(jacobian: Jacobian) -> str:
    """A module that imports sympy only: `inputs` (symbols), `definitions` (named intermediate
    values, in order), `matrix` over both, and the functions `expanded`, `lambdified`.
    """
    own = {"inputs", "definitions", "matrix", "expanded", "lambdified", "named"}
    names, printer = _python(jacobian, "sp", SYMPY_NAMES, own, '{name} = named("{name}", {text})')
    entries, (rows, columns) = printer.entries(), jacobian.shape
    arguments = list(names.values())
    lines = [*_docstring(jacobian, names), "", "import sympy as sp", ""]
    lines += [f'{name} = sp.Symbol("{name}", real=True)' for name in arguments]
    lines += [
        *_wrapped(f"inputs = ({', '.join(arguments)}{',' if len(arguments) == 1 else ''})"),
        _SYMPY_DEFINITIONS,
    ]
    lines += [*printer.lines, "", "matrix = sp.Matrix(["]
    for i in range(rows):
        row = [f"        {entries.get((i, j), '0')}," for j in range(columns)]
        lines += ["    [", *row, "    ],"]
    return "\n".join([*lines, "])", _SYMPY_FUNCTIONS])


def _python(
    jacobian: Jacobian,
    module: str,
    functions: Mapping[str, str],
    reserved: Collection[str],
    statement: str = "{name} = {text}",
) -> tuple[dict[str, str], Printer]:
    """Names of the inputs beside a module's own ones, and the printer of the matrix over them."""
    names = allowed_names(jacobian, {*keyword.kwlist, module, *reserved})
    language = python_language(module, functions, free_prefix(names.values()), statement)
    return names, Printer(jacobian.function, [[name] for name in names.values()], language)


_SYMPY_DEFINITIONS = '''
definitions = []


def named(name, value):
    """A symbol for a value that holds inputs and symbols named before."""
    symbol = sp.Symbol(name, real=True)
    definitions.append((symbol, sp.sympify(value)))
    return symbol

'''
_SYMPY_FUNCTIONS = '''

def expanded():
    """The matrix over the inputs alone; long where there are many definitions."""
    values = {}
    for name, value in definitions:
        values[name] = value.xreplace(values)
    return matrix.xreplace(values)


def lambdified(modules="math"):
    """A function of the inputs, in their order, that returns the rows."""
    def whole(value):  # lambdify writes 15 digits of numbers that have no more
        return value.xreplace({number: sp.Float(number, 17) for number in value.atoms(sp.Float)})

    steps = [(name, whole(value)) for name, value in definitions]
    rows = matrix.applyfunc(whole).tolist()
    return sp.lambdify(inputs, rows, modules, cse=lambda rows: (steps, rows))
'''


def _docstring(jacobian: Jacobian, names: dict[str, str]) -> list[str]:
    first, *safe = [docstring_line(line) for line in header(jacobian, names)]
    return [f'"""{first}', *safe, '"""']


def _wrapped(line: str) -> list[str]:
    """A long line with brackets over several lines."""
    return textwrap.wrap(
        line, 110, subsequent_indent="        ", break_long_words=False, break_on_hyphens=False
    )


# --- formats --------------------------------------------------------------------------------------

FORMATS: dict[str, Callable[[Jacobian], str]] = {
    "casadi": casadi_source,
    "c": c_source,
    "numpy": numpy_source,
    "sympy": sympy_source,
    "latex": latex_source,
}


def jacobian_text(jacobian: Jacobian, language: str) -> str:
    """The Jacobian in a format of FORMATS; the same bytes for the same model. InputError for an
    unknown format.
    """
    if language not in FORMATS:
        raise InputError(f"format = {not_among(language, FORMATS)}")
    return FORMATS[language](jacobian)
