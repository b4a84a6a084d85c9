"""Write a Jacobian as Python source: over NumPy arrays, or as SymPy expressions."""

from __future__ import annotations

import keyword
import textwrap

from symkin.codegen.expression import Python, module_functions, write
from symkin.codegen.jacobian_header import allowed_names, free_prefix, header
from symkin.text import docstring_line
from symkin.velocity.jacobian import AnyJacobian

_NUMPY = module_functions(
    "np", {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"}
)
_SYMPY = module_functions("sp", {"abs": "Abs"})


def numpy_source(jacobian: AnyJacobian) -> str:
    """A module that imports numpy only, with one function `jacobian` of the inputs (numbers, or
    arrays of one shape or of shapes that broadcast) which returns an array (..., rows, columns).
    """
    names = allowed_names(jacobian, {*keyword.kwlist, "np", "matrix", "jacobian", "shape"})
    arguments = list(names.values())
    definitions, entries = write(
        jacobian.function, arguments, Python(_NUMPY, free_prefix(arguments))
    )
    rows, columns = jacobian.shape
    shape = (
        f"np.broadcast_shapes({', '.join(f'np.shape({name})' for name in arguments)})"
        if arguments
        else "()"
    )
    listed = ", ".join(arguments)
    body = [
        '"""The Jacobian of one configuration, or of many where the inputs are arrays (shapes '
        "broadcast):",
        f'an array (..., {rows}, {columns})."""',
        *_wrapped(f"shape = {shape}"),
        f"matrix = np.zeros((*shape, {rows}, {columns}))",
        *(f"{name} = {text}" for name, text in definitions),
        *(
            f"matrix[..., {i}, {j}] = {entries[i + rows * j]}"
            for i in range(rows)
            for j in range(columns)
            if entries[i + rows * j] != "0"
        ),
        "return matrix",
    ]
    head = _wrapped(f"def jacobian({listed}):")
    return "\n".join(
        [
            *_docstring(header(jacobian, names)),
            "",
            "import numpy as np",
            "",
            "",
            *head,
            *_indented(body),
            "",
        ]
    )


def sympy_source(jacobian: AnyJacobian) -> str:
    """A module that imports sympy only: `inputs` (symbols), `definitions` (named intermediate
    values, in order), `matrix` over both, and the functions `expanded`, `lambdified`.
    """
    names = allowed_names(
        jacobian,
        {
            *keyword.kwlist,
            "sp",
            "inputs",
            "definitions",
            "matrix",
            "expanded",
            "lambdified",
            "named",
        },
    )
    arguments = list(names.values())
    definitions, entries = write(
        jacobian.function, arguments, Python(_SYMPY, free_prefix(arguments))
    )
    rows, columns = jacobian.shape
    lines = [*_docstring(header(jacobian, names)), "", "import sympy as sp", ""]
    lines += [f'{name} = sp.Symbol("{name}", real=True)' for name in arguments]
    lines += [
        *_wrapped(f"inputs = ({', '.join(arguments)}{',' if len(arguments) == 1 else ''})"),
        _SYMPY_DEFINITIONS,
    ]
    lines += [f'{name} = named("{name}", {text})' for name, text in definitions]
    lines += ["", "matrix = sp.Matrix(["]
    for i in range(rows):
        lines += ["    [", *(f"        {entries[i + rows * j]}," for j in range(columns)), "    ],"]
    return "\n".join([*lines, "])", _SYMPY_FUNCTIONS])


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
    return sp.lambdify(inputs, matrix.tolist(), modules, cse=lambda rows: (definitions, rows))
'''


def _docstring(lines: list[str]) -> list[str]:
    safe = [docstring_line(line) for line in lines]
    return [f'"""{safe[0]}', *safe[1:], '"""']


def _indented(lines: list[str]) -> list[str]:
    return ["    " + line for line in lines]


def _wrapped(line: str) -> list[str]:
    """A long line with brackets over several lines."""
    return textwrap.wrap(
        line, 110, subsequent_indent="        ", break_long_words=False, break_on_hyphens=False
    )
