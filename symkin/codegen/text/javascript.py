"""Print CasADi functions as straight-line JavaScript, and write those of complex numbers by the
numbers' parts.

A function becomes `export function NAME(x, out0, out1, ...)`: `x` holds the numbers of its only
input, each output is filled row by row at its nonzeros, and zeros are left as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import casadi as ca

from symkin.closure.expression_graph import walk
from symkin.codegen.text.languages import JAVASCRIPT
from symkin.codegen.text.printer import Printer
from symkin.spatial.backend import stacked

_Pair: TypeAlias = tuple[ca.SX, ca.SX]
"""Real and imaginary part."""


def javascript(name: str, x: ca.SX, outputs: list[ca.SX]) -> str:
    """The text of an exported function; raises NotImplementedError for an operation that it cannot
    write.
    """
    printer = Printer(
        ca.Function(name, [x], outputs, {"cse": True}),
        [[f"x[{k}]" for k in range(x.numel())]],
        JAVASCRIPT,
    )
    for o, output in enumerate(outputs):
        rows, columns = output.sparsity().get_triplet()
        for k, (row, column) in enumerate(zip(rows, columns, strict=True)):
            text = printer.value(o, k)
            printer.lines.append(f"out{o}[{row * output.shape[1] + column}]={text};")
    arguments = ", ".join(["x", *(f"out{k}" for k in range(len(outputs)))])
    body = "\n".join(printer.lines)
    return f"export function {name}({arguments}) {{\n{body}\n}}\n"


def complex_parts(x: ca.SX, outputs: Sequence[ca.SX]) -> tuple[ca.SX, list[_Pair]]:
    """Parts of complex variables, real and imaginary in turns, and those of expressions of them.
    Raises NotImplementedError for an operation without a complex form.
    """
    parts = ca.SX.sym("x", 2 * x.numel())
    reader = _Parts(parts)
    walk(ca.Function("f", [x], outputs, {"cse": True}), reader)
    found = [
        [reader.found[number, k] for k in range(output.nnz())]
        for number, output in enumerate(outputs)
    ]
    return parts, [
        tuple(ca.SX(output.sparsity(), stacked(pair[i] for pair in pairs)) for i in (0, 1))
        for output, pairs in zip(outputs, found, strict=True)
    ]


@dataclass
class _Parts:
    """Evaluator that makes of complex values the expressions of their parts."""

    x: ca.SX
    found: dict[tuple[int, int], _Pair] = field(default_factory=dict)

    def input(self, number: int, nonzero: int) -> _Pair:  # noqa: ARG002 - the walker's signature
        return self.x[2 * nonzero], self.x[2 * nonzero + 1]

    def constant(self, number: float) -> _Pair:
        return ca.SX(number), ca.SX(0)

    def operation(self, op: int, operands: list[_Pair]) -> _Pair:
        if op not in _COMPLEX:
            raise NotImplementedError(f"CasADi operation {op} has no complex form here")
        return _COMPLEX[op](*operands)

    def output(self, number: int, nonzero: int, value: _Pair) -> None:
        self.found[number, nonzero] = value


def _product(a: _Pair, b: _Pair) -> _Pair:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _inverse(a: _Pair) -> _Pair:
    if a[1].is_zero():
        return 1 / a[0], a[1]
    size = a[0] * a[0] + a[1] * a[1]
    return a[0] / size, -a[1] / size


def _root(a: _Pair) -> _Pair:
    """The root with a real part that is not negative."""
    size = ca.sqrt(a[0] * a[0] + a[1] * a[1])
    real, imaginary = (ca.sqrt(0.5 * ca.fmax(0, part)) for part in (size + a[0], size - a[0]))
    return real, (1 - 2 * (a[1] < 0)) * imaginary


_COMPLEX: dict[int, Callable[..., _Pair]] = {
    ca.OP_ADD: lambda a, b: (a[0] + b[0], a[1] + b[1]),
    ca.OP_SUB: lambda a, b: (a[0] - b[0], a[1] - b[1]),
    ca.OP_MUL: _product,
    ca.OP_DIV: lambda a, b: _product(a, _inverse(b)),
    ca.OP_NEG: lambda a: (-a[0], -a[1]),
    ca.OP_SQ: lambda a: _product(a, a),
    ca.OP_TWICE: lambda a: (2 * a[0], 2 * a[1]),
    ca.OP_INV: _inverse,
    ca.OP_SIN: lambda a: (ca.sin(a[0]) * ca.cosh(a[1]), ca.cos(a[0]) * ca.sinh(a[1])),
    ca.OP_COS: lambda a: (ca.cos(a[0]) * ca.cosh(a[1]), -ca.sin(a[0]) * ca.sinh(a[1])),
    ca.OP_SQRT: _root,
}
