"""Write CasADi functions as straight-line, single-assignment C.

Constants are snapped and printed with the suffix of their type, divisions by constants and repeated
divisions by one value become multiplications by a reciprocal, and text is made only for what is
asked for, in the order in which it is asked for, so that few values live at a time.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.closure.snapping import snap
from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.text import c_comment

_INFIX = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_CALLS = {
    ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_ATAN2: "atan2",
    ca.OP_FABS: "fabs",
}


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
        """The shortest decimal that reads back as the same number of this type. Raises InputError
        for a number that the type does not hold: infinity, or what is none.
        """
        with np.errstate(over="ignore"):
            number = np.float32(value) if self.name == "float" else np.float64(value)
        if not np.isfinite(number):
            remedy = "use --real double" if self.name == "float" else "use another length unit"
            raise InputError(
                f"the code would hold the number {value:.3g}, which is no finite {self.name}; "
                f"{remedy}, or another reference configuration"
            )
        text = str(number)
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


_SUMS = (ca.OP_ADD, ca.OP_SUB)
_SINGLE: dict[int, Callable[[float], float]] = {
    ca.OP_NEG: lambda a: -a,
    ca.OP_TWICE: lambda a: 2.0 * a,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_INV: lambda a: 1.0 / a,
}


@dataclass
class _Graph:
    """Evaluator that lists the values of a function, constants folded; `divisors` counts how often
    each is divided by.
    """

    nodes: list[_Node] = field(default_factory=list)
    outputs: dict[tuple[int, int], int] = field(default_factory=dict)
    divisors: Counter[int] = field(default_factory=Counter)

    def input(self, number: int, nonzero: int) -> int:
        return self._add(_Node(ca.OP_INPUT, source=(number, nonzero)))

    def constant(self, number: float) -> int:
        return self._add(_Node(ca.OP_CONST, constant=snap(number)))

    def operation(self, op: int, operands: list[int]) -> int:
        found = self._folded(op, operands)
        if found is not None:
            return found
        if op in (ca.OP_DIV, ca.OP_INV):
            self.divisors[operands[-1]] += 1
        return self._add(_Node(op, tuple(operands)))

    def _folded(self, op: int, operands: list[int]) -> int | None:
        """A value that needs no operation of its own, or a simpler one: what is constant, x + a - b
        as x + (a - b), x - (-a) as x + a.
        """
        numbers = [self._number(k) for k in operands]
        if op in _INFIX and None not in numbers:
            a, b = (float(number) for number in numbers if number is not None)
            with np.errstate(divide="ignore", invalid="ignore"):
                quotient = float(np.divide(a, b))
            return self.constant(
                {ca.OP_ADD: a + b, ca.OP_SUB: a - b, ca.OP_MUL: a * b, ca.OP_DIV: quotient}[op]
            )
        if op in _SINGLE and numbers[0] is not None and (op != ca.OP_INV or numbers[0]):
            return self.constant(_SINGLE[op](numbers[0]))
        if op == ca.OP_MUL and 1.0 in numbers:
            return operands[0] if numbers[1] == 1.0 else operands[1]
        if op == ca.OP_MUL and -1.0 in numbers:
            return self._add(
                _Node(ca.OP_NEG, (operands[0] if numbers[1] == -1.0 else operands[1],))
            )
        if op in _SUMS and numbers[1] is not None:
            return self._with_constant(operands[0], numbers[1] if op == ca.OP_ADD else -numbers[1])
        if op == ca.OP_ADD and numbers[0] is not None:
            return self._with_constant(operands[1], numbers[0])
        return None

    def _number(self, k: int) -> float | None:
        node = self.nodes[k]
        return node.constant if node.op == ca.OP_CONST else None

    def _with_constant(self, k: int, number: float) -> int | None:
        """x + number, where x may end in a constant; None where that is written already."""
        node = self.nodes[k]
        scale = 0.0
        if node.op in _SUMS and (last := self._number(node.reads[1])) is not None:
            k, scale = node.reads[0], max(abs(number), abs(last))
            number += last if node.op == ca.OP_ADD else -last
        number = snap(number, scale)
        if number == 0.0:
            return k
        return self._add(
            _Node(ca.OP_SUB if number < 0.0 else ca.OP_ADD, (k, self.constant(abs(number))))
        )

    def output(self, number: int, nonzero: int, value: int) -> None:
        self.outputs[number, nonzero] = value

    def _add(self, node: _Node) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1


@dataclass
class Emitter:
    """C text of a CasADi SX function: `value(o, k)` makes the statements for one output nonzero and
    names it.

    `inputs[i][k]` is the C text of nonzero k of input i; `prefix` begins the names of temporaries.
    `operations` counts what a controller will spend, `divisions` has the line of each and what it
    divides by.
    """

    function: ca.Function
    inputs: Sequence[Sequence[str]]
    real: Real
    prefix: str = "t"
    lines: list[str] = field(default_factory=list)
    operations: Counter[str] = field(default_factory=Counter)
    divisions: list[tuple[int, str]] = field(default_factory=list)
    _text: dict[int, str] = field(default_factory=dict)
    _inverse: dict[int, str] = field(default_factory=dict)
    _comments: int = 0
    _taken: int = 0

    @cached_property
    def _graph(self) -> _Graph:
        graph = _Graph()
        walk(self.function, graph)
        return graph

    def value(self, output: int, nonzero: int) -> str:
        """Make the statements up to one output nonzero; its C text, 0 where the function has no
        such nonzero.
        """
        nodes, outputs = self._graph.nodes, self._graph.outputs
        if (output, nonzero) not in outputs:
            return self.real.literal(0.0)
        wanted, stack = set(), [outputs[output, nonzero]]
        while stack:
            k = stack.pop()
            if k not in wanted and k not in self._text:
                wanted.add(k)
                stack.extend(nodes[k].reads)
        # operands have lower numbers than what is made of them
        for k in sorted(wanted):
            self._text[k] = self._statement(nodes[k])
        return self._text[outputs[output, nonzero]]

    def entry(self, row: int, column: int) -> str:
        """Make the statements up to one entry of the first output; its C text."""
        nonzero = self._places.get((row, column))
        return self.real.literal(0.0) if nonzero is None else self.value(0, nonzero)

    @cached_property
    def _places(self) -> dict[tuple[int, int], int]:
        """Nonzero number of each structural entry of the first output."""
        triplets = zip(*self.function.sparsity_out(0).get_triplet(), strict=True)
        return {place: k for k, place in enumerate(triplets)}

    def take(self) -> list[str]:
        """The statements that were made since the last time."""
        new, self._taken = self.lines[self._taken :], len(self.lines)
        return new

    def comment(self, text: str) -> None:
        """Add a line of comment, whatever text it is; names of temporaries do not count it."""
        self.lines.append(f"/* {c_comment(text)} */")
        self._comments += 1

    def assign(self, text: str) -> str:
        """Add a statement that names a value; its name."""
        name = f"{self.prefix}{len(self.lines) - self._comments}"
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
        divisors = self._graph.divisors
        below = self._graph.nodes[node.reads[1]]
        if below.op == ca.OP_CONST:
            self.operations["multiplications"] += 1
            # a controller multiplies in one cycle and divides in 14 or more
            return f"{a[0]} * {self.real.literal(1.0 / below.constant)}"
        if divisors[node.reads[1]] > 1:
            self.operations["multiplications"] += 1
            return f"{a[0]} * {self._reciprocal(node.reads[1])}"
        self._count_division(a[1])
        return f"{a[0]} / {a[1]}"

    def _reciprocal(self, k: int) -> str:
        if k not in self._inverse:
            self._count_division(self._text[k])
            self._inverse[k] = self.assign(f"{self.real.literal(1.0)} / {self._text[k]}")
        return self._inverse[k]

    def _count_division(self, divisor: str) -> None:
        self.operations["divisions"] += 1
        self.divisions.append((len(self.lines), divisor))


def indexed(name: str, count: int, first: int = 0) -> list[str]:
    """Name consecutive array elements in C."""
    return [f"{name}[{k}]" for k in range(first, first + count)]


def indent(lines: Sequence[str], depth: int = 1) -> str:
    """Join lines, indented by four spaces a level."""
    return "\n".join("    " * depth + line if line else "" for line in lines)


def indented_by_braces(lines: Sequence[str]) -> list[str]:
    """Indent lines by the braces that are open before them."""
    depth, found = 0, []
    for line in lines:
        depth -= line.startswith("}")
        found.append("    " * depth + line)
        depth += line.endswith("{")
    return found
