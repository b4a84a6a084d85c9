"""Write CasADi functions as straight-line JavaScript, over real or complex numbers.

A function becomes `export function NAME(x, out0, out1, ...)`: `x` holds the numbers of its only
input, each output is filled row by row at its nonzeros, and zeros are left as they are. Over
complex numbers every array holds pairs (real, imaginary).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

import casadi as ca

from symkin.closure.expression_graph import walk

Complex = tuple[str, str]
"""Names or numbers of a real and an imaginary part; "0" where it vanishes."""

_BINARY = {ca.OP_ADD: "{}+{}", ca.OP_SUB: "{}-{}", ca.OP_MUL: "{}*{}", ca.OP_DIV: "{}/{}"}
_UNARY = {
    ca.OP_SIN: "Math.sin({0})",
    ca.OP_COS: "Math.cos({0})",
    ca.OP_TAN: "Math.tan({0})",
    ca.OP_SQRT: "Math.sqrt({0})",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0}*{0}",
    ca.OP_TWICE: "2*{0}",
    ca.OP_INV: "1/{0}",
    ca.OP_FABS: "Math.abs({0})",
    ca.OP_ACOS: "Math.acos({0})",
    ca.OP_ASIN: "Math.asin({0})",
    ca.OP_ATAN: "Math.atan({0})",
}


@dataclass
class _Real:
    """Evaluator that writes a line for every operation on real numbers."""

    places: list[list[int]]
    lines: list[str] = field(default_factory=list)

    def input(self, _number: int, nonzero: int) -> str:
        return f"x[{nonzero}]"

    def constant(self, number: float) -> str:
        return _number(number)

    def operation(self, op: int, operands: list[str]) -> str:
        if op in _BINARY:
            return self._named(_BINARY[op].format(*operands))
        if op == ca.OP_ATAN2:
            return self._named(f"Math.atan2({operands[0]},{operands[1]})")
        if op not in _UNARY:
            raise NotImplementedError(f"CasADi operation {op} has no JavaScript here")
        return self._named(_UNARY[op].format(operands[0]))

    def output(self, number: int, nonzero: int, value: str) -> None:
        self.lines.append(f"out{number}[{self.places[number][nonzero]}]={value};")

    def _named(self, text: str) -> str:
        name = f"v{len(self.lines)}"
        self.lines.append(f"const {name}={text};")
        return name


@dataclass
class _Complex:
    """The same on complex numbers: sums, products and quotients by parts, functions by their
    formulas.
    """

    places: list[list[int]]
    lines: list[str] = field(default_factory=list)

    def input(self, _number: int, nonzero: int) -> Complex:
        return f"x[{2 * nonzero}]", f"x[{2 * nonzero + 1}]"

    def constant(self, number: float) -> Complex:
        return _number(number), "0"

    def operation(self, op: int, operands: list[Complex]) -> Complex:
        if op not in _COMPLEX:
            raise NotImplementedError(f"CasADi operation {op} has no complex form here")
        real, imaginary = _COMPLEX[op](*operands[: 2 if op in _BINARY else 1])
        return self._named(real), self._named(imaginary)

    def output(self, number: int, nonzero: int, value: Complex) -> None:
        place = 2 * self.places[number][nonzero]
        self.lines.append(f"out{number}[{place}]={value[0]};out{number}[{place + 1}]={value[1]};")

    def _named(self, text: str) -> str:
        if _is_name(text):
            return text
        name = f"v{len(self.lines)}"
        self.lines.append(f"const {name}={text};")
        return name


def _number(number: float) -> str:
    """A number as an operand of any operation."""
    text = "0" if number == 0 else repr(float(number)).removesuffix(".0")
    return f"({text})" if text.startswith("-") else text


def _is_name(text: str) -> bool:
    """Whether a text is a number or the name of one, which needs no other name."""
    return re.fullmatch(r"\w+|x\[\d+\]", text) is not None


def _sum(*terms: str) -> str:
    kept = [term for term in terms if term not in ("0", "-0")]
    return "+".join(kept) or "0"


def _times(a: str, b: str) -> str:
    return "0" if "0" in (a, b) else f"{a}*{b}"


def _minus(a: str) -> str:
    return "0" if a == "0" else f"-{a}"


def _product(a: Complex, b: Complex) -> Complex:
    return _sum(_times(a[0], b[0]), _minus(_times(a[1], b[1]))), _sum(
        _times(a[0], b[1]), _times(a[1], b[0])
    )


def _inverse(a: Complex) -> Complex:
    size = f"({_sum(_times(a[0], a[0]), _times(a[1], a[1]))})"
    return f"{a[0]}/{size}", "0" if a[1] == "0" else f"-{a[1]}/{size}"


def _quotient(a: Complex, b: Complex) -> Complex:
    if b[1] == "0":
        return _divided(a[0], b[0]), _divided(a[1], b[0])
    size = f"({_sum(_times(b[0], b[0]), _times(b[1], b[1]))})"
    real = _sum(_times(a[0], b[0]), _times(a[1], b[1]))
    imaginary = _sum(_times(a[1], b[0]), _minus(_times(a[0], b[1])))
    return _divided(f"({real})", size), _divided(
        "0" if imaginary == "0" else f"({imaginary})", size
    )


def _divided(a: str, b: str) -> str:
    return "0" if a in ("0", "(0)") else f"{a}/{b}"


def _root(a: Complex) -> Complex:
    return f"rootReal({a[0]},{a[1]})", f"rootImaginary({a[0]},{a[1]})"


_COMPLEX: dict[int, Callable[..., Complex]] = {
    ca.OP_ADD: lambda a, b: (_sum(a[0], b[0]), _sum(a[1], b[1])),
    ca.OP_SUB: lambda a, b: (_sum(a[0], _minus(b[0])), _sum(a[1], _minus(b[1]))),
    ca.OP_MUL: _product,
    ca.OP_DIV: _quotient,
    ca.OP_NEG: lambda a: (_minus(a[0]), _minus(a[1])),
    ca.OP_SQ: lambda a: _product(a, a),
    ca.OP_TWICE: lambda a: (_times("2", a[0]), _times("2", a[1])),
    ca.OP_INV: _inverse,
    ca.OP_SIN: lambda a: (
        f"Math.sin({a[0]})*Math.cosh({a[1]})",
        f"Math.cos({a[0]})*Math.sinh({a[1]})",
    ),
    ca.OP_COS: lambda a: (
        f"Math.cos({a[0]})*Math.cosh({a[1]})",
        f"-Math.sin({a[0]})*Math.sinh({a[1]})",
    ),
    ca.OP_SQRT: _root,
}

_ROOTS = """function rootReal(a, b) { return Math.sqrt(0.5 * (Math.hypot(a, b) + a)); }
function rootImaginary(a, b) {
  return (b < 0 ? -1 : 1)*Math.sqrt(0.5 * Math.max(0, Math.hypot(a, b) - a)); }
"""


def javascript(name: str, x: ca.SX, outputs: list[ca.SX], *, over_complex: bool = False) -> str:
    """The text of an exported function; raises NotImplementedError for an operation that it cannot
    write.
    """
    outputs = [ca.SX(output) for output in outputs]
    function = ca.Function(name, [x], outputs, {"cse": True})
    places = [_row_major(output) for output in outputs]
    arguments = ", ".join(["x", *(f"out{k}" for k in range(len(outputs)))])
    body = "\n".join((_complex_lines if over_complex else _real_lines)(function, places))
    helpers = _ROOTS if over_complex and "rootReal(" in body else ""
    return f"{helpers}export function {name}({arguments}) {{\n{body}\n}}\n"


def _real_lines(function: ca.Function, places: list[list[int]]) -> list[str]:
    evaluator = _Real(places)
    walk(function, evaluator)
    return evaluator.lines


def _complex_lines(function: ca.Function, places: list[list[int]]) -> list[str]:
    evaluator = _Complex(places)
    walk(function, evaluator)
    return evaluator.lines


def _row_major(output: ca.SX) -> list[int]:
    """Places of the nonzeros of a matrix in its dense row-major writing."""
    rows, columns = output.sparsity().get_triplet()
    width = int(output.shape[1])
    return [row * width + column for row, column in zip(rows, columns, strict=True)]
