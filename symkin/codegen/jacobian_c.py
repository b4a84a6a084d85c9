"""Write a Jacobian as one C function."""

from __future__ import annotations

import textwrap

import casadi as ca

from symkin.codegen.c_emitter import Emitter, Real, indent, indexed
from symkin.codegen.jacobian_header import header
from symkin.text import c_comment
from symkin.velocity.jacobian import AnyJacobian


def c_source(jacobian: AnyJacobian) -> str:
    """A C99 file with the function `NAME_KIND_jacobian(variables, [geometry,] jacobian)`,
    row-major. It takes plain doubles, so that it compiles beside the firmware of the same
    mechanism, of either type.
    """
    name, real = jacobian.mechanism.name, Real("double", "double")
    sizes = {"variables": len(jacobian.inputs), "geometry": len(jacobian.parameters)}
    function = ca.Function(
        "f", [jacobian.symbols], [ca.densify(jacobian.expression)], {"cse": True}
    )
    inputs = [text for array, count in sizes.items() for text in indexed(array, count)]
    emitter = Emitter(function, [inputs], real)
    rows, columns = jacobian.shape
    entries = [emitter.value(0, i + rows * j) for i in range(rows) for j in range(columns)]
    arrays = [f"const {real.type} variables[{len(jacobian.inputs) or ''}]"]
    arrays += (
        [f"const {real.type} geometry[{len(jacobian.parameters)}]"] if jacobian.parameters else []
    )
    result = f"{real.type} jacobian[{rows * columns}]"
    head = f"void {name}_{jacobian.kind}_jacobian({', '.join([*arrays, result])})"
    body = [*emitter.lines, *(f"jacobian[{k}] = {text};" for k, text in enumerate(entries))]
    passed = ["variables", *(["geometry"] if jacobian.parameters else [])]
    unread = [array for array in passed if not any(f"{array}[" in line for line in body)]
    body = [*(f"(void){array};" for array in unread), *body]
    return "\n".join(
        [
            "/*",
            *(f" * {line}".rstrip() for line in _comment(jacobian)),
            " */",
            "#include <math.h>",
            "",
            f"{head};",
            "",
            head,
            "{",
            indent(body),
            "}",
            "",
        ]
    )


def _comment(jacobian: AnyJacobian) -> list[str]:
    names = {v.name: v.name for v in (*jacobian.inputs, *jacobian.parameters)}
    order = "variables[k] are the inputs, " if jacobian.inputs else "variables are not read, "
    order += (
        "geometry[k] the geometry, " if jacobian.parameters else ""
    ) + "jacobian is row-major."
    return [c_comment(line) for line in [*header(jacobian, names), *textwrap.wrap(order, 110)]]
