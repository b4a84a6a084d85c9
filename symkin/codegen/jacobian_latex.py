"""Write a Jacobian as a LaTeX document, common subexpressions named."""

from __future__ import annotations

import re

from symkin.codegen.expression import write
from symkin.codegen.jacobian_header import header
from symkin.codegen.latex import Latex, distinct, document, letter_of_values, symbol_name
from symkin.velocity.jacobian import AnyJacobian
from symkin.velocity.jacobian_names import Variable

_LONGEST = 80
"""Printed characters beyond which parts of a value get names: about one line."""
_LINES = 30
"""Lines of one align environment, which TeX sets as a whole."""


def latex_source(jacobian: AnyJacobian) -> str:
    """A document that compiles on its own: numbered definitions in order, then the entries J_{ij} that are not zero."""
    read = (*jacobian.inputs, *jacobian.parameters)
    symbols = distinct([symbol_of(v) for v in read], [v.name for v in read])
    definitions, entries = write(jacobian.function, symbols, Latex(_LONGEST, exact=True, letter=letter_of_values(symbols)))
    rows, columns = jacobian.shape
    lines = [rf"{name} &= {text} \\" for name, text in definitions]
    filled = [(i, j) for i in range(rows) for j in range(columns) if entries[i + rows * j] != "0"]
    lines += [rf"J_{{{i + 1},{j + 1}}} &= {entries[i + rows * j]} \\" for i, j in filled]
    blocks = []
    for begin in range(0, len(lines), _LINES):
        blocks += [r"\begin{align*}", *lines[begin : begin + _LINES], r"\end{align*}"]
    names = {v.name: v.name for v in read}
    head = header(jacobian, names)
    remark = f"Entries that are not listed are zero ({rows * columns - len(filled)} of {rows * columns})."
    return "\n".join([*(f"% {line}".rstrip() for line in head), document("\n".join([*_prose(jacobian), remark, *blocks])), ""])


def symbol_of(v: Variable) -> str:
    """The symbol of a coordinate, of a quaternion's component, or of a parameter by its key path."""
    component = re.fullmatch(r"(.*)\.([wxyz])", v.source) if v.unit == "1" else re.fullmatch(r"(q)([wxyz])", v.source)
    if component is not None and v.unit == "1":
        owner = v.coordinate.removeprefix("pose.")
        return symbol_name(owner, "wxyz".index(component.group(2)))
    return rf"\mathrm{{{_plain(v.source)}}}" if not v.unit else symbol_name(_ascii(v.source))


def _ascii(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]", "_", text)


def _plain(text: str) -> str:
    return _ascii(text.replace(".", "_")).replace("_", r"\_")


def _prose(jacobian: AnyJacobian) -> list[str]:
    mechanism = jacobian.mechanism
    joints = ", ".join(f"${symbol_name(_ascii(name))}$" for name in (c.name for c in jacobian.closure.role("actuated")))
    return [
        rf"\noindent {_plain(mechanism.name)}: {jacobian.kind} Jacobian $J$. Lengths in {mechanism.length_unit}, angles in rad; "
        rf"actuated joints {joints}.",
        rf"Rows: {', '.join(_plain(row) for row in jacobian.rows)}; columns: {', '.join(_plain(c) for c in jacobian.columns)}.",
    ]
