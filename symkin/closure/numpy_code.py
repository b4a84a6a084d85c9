"""Compile a CasADi function into straight-line NumPy code, in which every value is an array over
points.

The code uses the slots of the function's instructions as its variables: each is overwritten as soon
as its value is not read any more, which bounds the memory of large batches.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import instructions

_BINARY = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_UNARY = {
    ca.OP_SIN: "sin({})",
    ca.OP_COS: "cos({})",
    ca.OP_TAN: "tan({})",
    ca.OP_SQRT: "sqrt({})",
    ca.OP_EXP: "exp({})",
    ca.OP_NEG: "-{}",
    ca.OP_SQ: "{0}*{0}",
    ca.OP_TWICE: "2.0*{}",
    ca.OP_INV: "1.0/{}",
    ca.OP_ASSIGN: "{}",
}


def vectorise(function: ca.Function) -> Callable[..., None]:
    """f(inputs..., outputs...): each input an array (length, n), each output a dense array (n,
    rows, columns) that is filled at the function's nonzeros. Raises NotImplementedError for an
    operation without a complex form.
    """
    lines, places = [], []
    for k in range(function.n_out()):
        rows, columns = function.sparsity_out(k).get_triplet()
        places.append(list(zip(rows, columns, strict=True)))
    for op, i, o, constant in instructions(function):
        if op == ca.OP_INPUT:
            lines.append(f"w{o[0]} = i{i[0]}[{i[1]}]")
        elif op == ca.OP_CONST:
            lines.append(f"w{o[0]} = {constant!r}")
        elif op == ca.OP_OUTPUT:
            row, column = places[o[0]][o[1]]
            lines.append(f"o{o[0]}[:, {row}, {column}] = w{i[0]}")
        elif op in _BINARY:
            lines.append(f"w{o[0]} = w{i[0]} {_BINARY[op]} w{i[1]}")
        elif op in _UNARY:
            lines.append(f"w{o[0]} = " + _UNARY[op].format(f"w{i[0]}"))
        else:
            raise NotImplementedError(f"CasADi operation {op} has no complex form here")
    arguments = [f"i{k}" for k in range(function.n_in())] + [
        f"o{k}" for k in range(function.n_out())
    ]
    source = f"def evaluate({', '.join(arguments)}):\n    " + "\n    ".join(lines or ["pass"])
    scope = {"sin": np.sin, "cos": np.cos, "tan": np.tan, "sqrt": np.sqrt, "exp": np.exp}
    exec(compile(source, "<closure>", "exec"), scope)
    evaluate: Callable[..., None] = scope["evaluate"]
    return evaluate
