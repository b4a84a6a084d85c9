"""Write a Jacobian as a LaTeX document, common subexpressions named."""

from __future__ import annotations

import re
from collections.abc import Sequence

from symkin.codegen.text.jacobian_header import header
from symkin.codegen.text.languages import latex_language
from symkin.codegen.text.latex import (
    coordinate_symbols,
    distinct,
    document,
    letter_of_values,
    renamed,
    upright,
    variable_names,
)
from symkin.codegen.text.printer import Printer
from symkin.text import code_point, latex_text, printable
from symkin.velocity.jacobian import Jacobian
from symkin.velocity.jacobian_names import names_of

_LONGEST = 80
"""Printed characters beyond which parts of a value get names: about one line."""
_LINES = 30
"""Lines of one align environment, which TeX sets as a whole."""


def latex_source(jacobian: Jacobian) -> str:
    """A document that compiles on its own: numbered definitions in order, then the entries J_{ij}
    that are not zero.
    """
    symbols = symbols_read(jacobian)
    printer = Printer(
        jacobian.function,
        [[symbol] for symbol in symbols],
        latex_language(letter_of_values(symbols), _LONGEST, exact=True),
    )
    entries, (rows, columns) = printer.entries(), jacobian.shape
    filled = [rf"J_{{{i + 1},{j + 1}}} &= {text} \\" for (i, j), text in entries.items()]
    lines = [*printer.lines, *filled]
    blocks = []
    for begin in range(0, len(lines), _LINES):
        blocks += [r"\begin{align*}", *lines[begin : begin + _LINES], r"\end{align*}"]
    head = header(jacobian, {v.name: v.source for v in (*jacobian.inputs, *jacobian.parameters)})
    legend = renamed(coordinate_symbols(jacobian.closure), variable_names(jacobian.closure))
    head += [f"{symbol} is {printable(name)}" for symbol, name in legend]
    remark = (
        f"Entries that are not listed are zero ({rows * columns - len(filled)} of "
        f"{rows * columns})."
    )
    prose = [*_prose(jacobian), remark, *_legend(legend)]
    return "\n".join(
        [*(f"% {line}".rstrip() for line in head), document("\n".join([*prose, *blocks])), ""]
    )


def symbols_read(jacobian: Jacobian) -> list[str]:
    """A symbol for each input and parameter, no two alike: those of the closure's equations, and
    key paths of parameters."""
    symbols = coordinate_symbols(jacobian.closure)
    keys = [v.source for v in jacobian.parameters]
    both = distinct([*symbols, *(rf"\mathrm{{{_plain(key)}}}" for key in keys)], [*symbols, *keys])
    return [*(both[v.index] for v in jacobian.inputs), *both[len(symbols) :]]


def _plain(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]", r"\_", text)


def _prose(jacobian: Jacobian) -> list[str]:
    mechanism = jacobian.mechanism
    joints = ", ".join(_labels(jacobian, [c.name for c in jacobian.closure.role("actuated")]))
    rows = ", ".join(_labels(jacobian, jacobian.rows, pose=jacobian.kind == "analytic"))
    columns = ", ".join(_labels(jacobian, jacobian.columns))
    return [
        rf"\noindent {_plain(mechanism.name)}: {jacobian.kind} Jacobian $J$. Lengths in "
        rf"{mechanism.length_unit}, angles in rad"
        + (f"; actuated joints {joints}." if joints else "."),
        f"Rows: {rows}; columns: {columns}.",
    ]


def _labels(jacobian: Jacobian, names: Sequence[str], *, pose: bool = False) -> list[str]:
    """What stands for names of rows, columns and joints in the text: the symbols of coordinates,
    other names upright, no two alike. Of a joint and a coordinate of the pose with one name
    it is the joint, or the `pose`."""
    closure = jacobian.closure
    symbols = coordinate_symbols(closure)
    of_pose = sorted(closure.coordinates, key=lambda c: (c.role == "pose") == pose)
    own = {
        source: symbols[closure.slices[c.name].start + k]
        for c in of_pose
        for k, source in enumerate(names_of(c.name, c.width))
    }
    others = [
        name for name in dict.fromkeys((*jacobian.rows, *jacobian.columns)) if name not in own
    ]
    made = distinct(
        [*symbols, *(rf"\mathrm{{{upright(name)}}}" for name in others)], [*symbols, *others]
    )
    found = own | dict(zip(others, made[len(symbols) :], strict=True))
    return [f"${found[name]}$" for name in names]


def _legend(renamed_symbols: list[tuple[str, str]]) -> list[str]:
    """Which coordinates have symbols that do not tell their names; letters beyond ASCII by their
    numbers too."""
    told = [
        (symbol, latex_text(name), [code_point(c) for c in name if not c.isascii()])
        for symbol, name in renamed_symbols
    ]
    listed = ", ".join(
        rf"${symbol}$ is \texttt{{{name}}}" + (f" ({', '.join(points)})" if points else "")
        for symbol, name, points in told
    )
    return [f"Of the symbols, {listed}."] if listed else []
