"""Scalar CasADi functions as straight-line, single-assignment C.

The SX graph is walked instruction by instruction. Constants are snapped and printed with the suffix of their type,
divisions by constants and repeated divisions by one value become multiplications by a reciprocal, and text is made
only for what is asked for, in the order in which it is asked for, so that few values live at a time.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.caching import cached_property
from symkin.closure.graph import instructions
from symkin.closure.snapping import snap

_INFIX = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_CALLS = {ca.OP_SQRT: "sqrt", ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_ATAN2: "atan2", ca.OP_FABS: "fabs"}


@dataclass(frozen=True)
class Real:
    """The C type of numbers: `name` is float or double, `type` what the generated file calls it."""

    name: str
    type: str = "real"

    @property
    def suffix(self) -> str:
        return "f" if self.name == "float" else ""

    @property
    def epsilon(self) -> float:
        """Half a unit in the last place of 1."""
        return 2.0**-24 if self.name == "float" else 2.0**-53

    def call(self, function: str) -> str:
        return function + self.suffix

    def literal(self, value: float) -> str:
        """The shortest decimal that reads back as the same number of this type."""
        text = str(np.float32(value)) if self.name == "float" else repr(float(value))
        if not any(mark in text for mark in ".e"):
            text += ".0"
        return text + self.suffix

    def hexadecimal(self, value: float) -> str:
        """The exact bits of the rounded value, for test vectors."""
        if math.isnan(value):
            return "NAN"
        if math.isinf(value):
            return "INFINITY" if value > 0 else "-INFINITY"
        rounded = float(np.float32(value)) if self.name == "float" else float(value)
        return rounded.hex() + self.suffix


@dataclass
class _Node:
    """One value of the graph: operation, the nodes that it reads, or a constant or input."""

    op: int
    reads: tuple[int, ...] = ()
    constant: float = 0.0
    source: tuple[int, int] = (0, 0)


@dataclass
class Emitter:
    """C text of a CasADi SX function: `value(o, k)` makes the statements for one output nonzero and names it.

    `inputs[i][k]` is the C text of nonzero k of input i; `prefix` begins the names of temporaries.
    """

    function: ca.Function
    inputs: Sequence[Sequence[str]]
    real: Real
    prefix: str = "t"
    lines: list[str] = field(default_factory=list)
    operations: Counter[str] = field(default_factory=Counter)
    _text: dict[int, str] = field(default_factory=dict)
    _inverse: dict[int, str] = field(default_factory=dict)

    @cached_property
    def _graph(self) -> tuple[list[_Node], dict[tuple[int, int], int], Counter[int]]:
        f = self.function
        nodes: list[_Node] = []
        slots: dict[int, int] = {}
        outputs: dict[tuple[int, int], int] = {}
        divisors: Counter[int] = Counter()
        for op, i, o, constant in instructions(f):
            if op == ca.OP_OUTPUT:
                outputs[o[0], o[1]] = slots[i[0]]
                continue
            node = _Node(op)
            if op == ca.OP_INPUT:
                node.source = (i[0], i[1])
            elif op == ca.OP_CONST:
                node.constant = snap(constant)
            else:
                node.reads = tuple(slots[n] for n in i)
            if op == ca.OP_DIV:
                divisors[node.reads[1]] += 1
            if op == ca.OP_INV:
                divisors[node.reads[0]] += 1
            nodes.append(node)
            slots[o[0]] = len(nodes) - 1
        return nodes, outputs, divisors

    def value(self, output: int, nonzero: int) -> str:
        """Statements up to one output nonzero, and its C text."""
        nodes, outputs, _ = self._graph
        if (output, nonzero) not in outputs:
            return self.real.literal(0.0)
        wanted, stack = set(), [outputs[output, nonzero]]
        while stack:
            k = stack.pop()
            if k not in wanted and k not in self._text:
                wanted.add(k)
                stack.extend(nodes[k].reads)
        for k in sorted(wanted):
            self._text[k] = self._statement(nodes[k])
        return self._text[outputs[output, nonzero]]

    def assign(self, text: str) -> str:
        name = f"{self.prefix}{len(self.lines)}"
        self.lines.append(f"const {self.real.type} {name} = {text};")
        return name

    def _statement(self, node: _Node) -> str:
        if node.op == ca.OP_CONST:
            return self.real.literal(node.constant)
        if node.op == ca.OP_INPUT:
            return self.inputs[node.source[0]][node.source[1]]
        if node.op == ca.OP_ASSIGN:
            return self._text[node.reads[0]]
        return self.assign(self._operation(node))

    def _operation(self, node: _Node) -> str:
        a = [self._text[r] for r in node.reads]
        if node.op == ca.OP_DIV:
            return self._quotient(node, a)
        if node.op == ca.OP_INV:
            return self._reciprocal(node.reads[0])
        if node.op in _INFIX:
            self.operations["multiplications" if node.op == ca.OP_MUL else "additions"] += 1
            right = f"({a[1]})" if a[1].startswith("-") else a[1]
            return f"{a[0]} {_INFIX[node.op]} {right}"
        if node.op in _CALLS:
            self.operations[_CALLS[node.op]] += 1
            return f"{self.real.call(_CALLS[node.op])}({', '.join(a)})"
        if node.op == ca.OP_NEG:
            return f"-{a[0]}"
        if node.op == ca.OP_SQ:
            self.operations["multiplications"] += 1
            return f"{a[0]} * {a[0]}"
        if node.op == ca.OP_TWICE:
            self.operations["additions"] += 1
            return f"{a[0]} + {a[0]}"
        raise NotImplementedError(f"CasADi operation {node.op} has no C form here")

    def _quotient(self, node: _Node, a: Sequence[str]) -> str:
        nodes, _, divisors = self._graph
        below = nodes[node.reads[1]]
        if below.op == ca.OP_CONST:
            self.operations["multiplications"] += 1
            return f"{a[0]} * {self.real.literal(1.0 / below.constant)}"
        if divisors[node.reads[1]] > 1:
            self.operations["multiplications"] += 1
            return f"{a[0]} * {self._reciprocal(node.reads[1])}"
        self.operations["divisions"] += 1
        return f"{a[0]} / {a[1]}"

    def _reciprocal(self, k: int) -> str:
        if k not in self._inverse:
            self.operations["divisions"] += 1
            self._inverse[k] = self.assign(f"{self.real.literal(1.0)} / {self._text[k]}")
        return self._inverse[k]


def indexed(name: str, count: int, first: int = 0) -> list[str]:
    """C text of consecutive array elements."""
    return [f"{name}[{k}]" for k in range(first, first + count)]


def indent(lines: Sequence[str], depth: int = 1) -> str:
    return "\n".join("    " * depth + line if line else "" for line in lines)
