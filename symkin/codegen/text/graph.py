"""List the values of a CasADi function as a graph of nodes: constants folded, uses and divisors
counted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container
from dataclasses import dataclass, field
from math import prod

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.closure.snapping import snap
from symkin.computed_once import cached_property

KINDS = {
    ca.OP_ADD: "additions",
    ca.OP_SUB: "additions",
    ca.OP_TWICE: "additions",
    ca.OP_MUL: "multiplications",
    ca.OP_SQ: "multiplications",
    ca.OP_DIV: "divisions",
    ca.OP_INV: "divisions",
}
"""What arithmetic is counted as; functions count by their names."""
CALLS = {
    ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_TAN: "tan",
    ca.OP_ASIN: "asin",
    ca.OP_ACOS: "acos",
    ca.OP_ATAN: "atan",
    ca.OP_ATAN2: "atan2",
    ca.OP_SINH: "sinh",
    ca.OP_COSH: "cosh",
    ca.OP_EXP: "exp",
    ca.OP_LOG: "log",
    ca.OP_FABS: "fabs",
}
"""Names of functions in C."""
_SUMS = (ca.OP_ADD, ca.OP_SUB)
_ODD = (ca.OP_TWICE, ca.OP_INV, ca.OP_SIN)
"""What changes its sign with its operand."""
_EVEN = (ca.OP_SQ, ca.OP_COS, ca.OP_FABS)
"""What does not."""
_SINGLE: dict[int, Callable[[float], float]] = {
    ca.OP_NEG: lambda a: -a,
    ca.OP_TWICE: lambda a: 2.0 * a,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_INV: lambda a: 1.0 / a,
}
_PAIRS: dict[int, Callable[[float, float], float]] = {
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: lambda a, b: float(np.divide(a, b)),
}


def kind_of(op: int) -> str | None:
    """What an operation is counted as; None of signs and copies."""
    return KINDS.get(op) or CALLS.get(op)


@dataclass
class Node:
    """One value: its operation and the nodes that it reads, or a constant, or an input's entry."""

    op: int
    reads: tuple[int, ...] = ()
    constant: float = 0.0
    source: tuple[int, int] = (0, 0)


@dataclass
class Graph:
    """Evaluator that lists the values of a function, operands before what is made of them;
    `divisors` counts how often each is divided by.
    """

    nodes: list[Node] = field(default_factory=list)
    outputs: dict[tuple[int, int], int] = field(default_factory=dict)
    divisors: Counter[int] = field(default_factory=Counter)
    is_read: bool = False
    _constants: dict[str, int] = field(default_factory=dict)
    _made: dict[tuple[int, tuple[int, ...]], int] = field(default_factory=dict)

    @staticmethod
    def of(function: ca.Function, *, is_read: bool = False) -> Graph:
        """The graph of a function of SX; a value and its negative are found once: signs are drawn
        out of what reads them, as far as that goes. Where it `is_read` by people, nested sums have
        one constant, at their end, and b - a stands for -(a - b).
        """
        graph = Graph(is_read=is_read)
        walk(function, graph)
        return graph

    @cached_property
    def uses(self) -> Counter[int]:
        """How often each value is read, of those that an output needs."""
        found = Counter(self.outputs.values())
        for k in reversed(range(len(self.nodes))):
            if found[k]:
                found.update(self.nodes[k].reads)
        return found

    def needed(self, k: int, known: Container[int]) -> list[int]:
        """The values that are to be found for one, in order, beside the known ones."""
        wanted, stack = set[int](), [k]
        while stack:
            k = stack.pop()
            if k not in wanted and k not in known:
                wanted.add(k)
                stack.extend(self.nodes[k].reads)
        return sorted(wanted)

    # --- evaluator --------------------------------------------------------------------------------

    def input(self, number: int, nonzero: int) -> int:
        return self._add(Node(ca.OP_INPUT, source=(number, nonzero)))

    def constant(self, number: float) -> int:
        # what differs by rounding alone is one number, by which products are one too
        number = snap(number)
        told = f"{number + 0.0:.13g}"
        if told not in self._constants:
            self._constants[told] = self._add(Node(ca.OP_CONST, constant=number))
        return self._constants[told]

    def operation(self, op: int, operands: list[int]) -> int:
        found = self._folded(op, operands)
        if found is not None:
            return found
        return self._signed(op, operands)

    def output(self, number: int, nonzero: int, value: int) -> None:
        self.outputs[number, nonzero] = value

    def _folded(self, op: int, operands: list[int]) -> int | None:
        """A value that needs no operation of its own, or a simpler one: what is constant, x + a - b
        as x + (a - b), x - (-a) as x + a.
        """
        numbers = [self._number(k) for k in operands]
        first, last = numbers[0], numbers[-1]
        if op in _PAIRS and first is not None and last is not None:
            with np.errstate(divide="ignore", invalid="ignore"):
                return self.constant(_PAIRS[op](first, last))
        if op in _SINGLE and first is not None and (op != ca.OP_INV or first):
            return self.constant(_SINGLE[op](first))
        if op == ca.OP_MUL and 1.0 in numbers:
            return operands[0] if last == 1.0 else operands[1]
        if op == ca.OP_MUL and -1.0 in numbers:
            return self.operation(ca.OP_NEG, [operands[0] if last == -1.0 else operands[1]])
        if op in _SUMS and last is not None:
            return self._with_constant(operands[0], last if op == ca.OP_ADD else -last)
        if op == ca.OP_ADD and first is not None:
            return self._with_constant(operands[1], first)
        return self._as_read(op, operands) if self.is_read else None

    def _as_read(self, op: int, operands: list[int]) -> int | None:
        """What people would write: one constant of nested sums and of nested products."""
        if op == ca.OP_SUB and (first := self._number(operands[0])) is not None:
            return self._with_constant(self._negated(operands[1], is_negative=True), first)
        if op in _SUMS:
            (a, one), (b, two) = map(self._without_constant, operands)
            if [a, b] != operands:
                two = two if op == ca.OP_ADD else -two
                return self._with_constant(self.operation(op, [a, b]), one + two)
        if op == ca.OP_TWICE:
            return self.operation(ca.OP_MUL, [self.constant(2.0), operands[0]])
        return None

    # --- signs ------------------------------------------------------------------------------------

    def _signed(self, op: int, operands: list[int]) -> int:
        """A value whose operands are without signs, or its negative."""
        parts = [self._unsigned(k) for k in operands]
        bare, signs = [k for k, _ in parts], [is_negative for _, is_negative in parts]
        if op in _SUMS:
            return self._sum(bare, signs[0], signs[1] != (op == ca.OP_SUB))
        if op in (ca.OP_MUL, ca.OP_DIV):
            is_read = self.is_read and op == ca.OP_MUL
            value = self._factored(bare) if is_read else self._once(op, bare)
            return self._negated(value, signs[0] != signs[1])
        if op in _ODD or op == ca.OP_NEG:
            value = bare[0] if op == ca.OP_NEG else self._once(op, bare)
            return self._negated(value, signs[0] != (op == ca.OP_NEG))
        return self._once(op, bare if op in _EVEN else operands)

    def _factored(self, bare: list[int]) -> int:
        """A product with one constant, at its front."""
        factors, rest = list[float](), list[int]()
        for k in bare:
            node = self.nodes[k]
            first, *others = node.reads if node.op == ca.OP_MUL else (k,)
            number = self._number(first)
            factors += [] if number is None else [number]
            rest += [k] if number is None else others
        value = rest[0]
        if len(rest) > 1:
            is_square = rest[0] == rest[1]
            value = self._once(ca.OP_SQ, rest[:1]) if is_square else self._once(ca.OP_MUL, rest)
        if not factors:
            return value
        pair = [self.constant(prod(factors)), value]
        folded = self._folded(ca.OP_MUL, pair)
        return self._once(ca.OP_MUL, pair) if folded is None else folded

    def _sum(self, bare: list[int], first: bool, last: bool) -> int:
        """A sum of two values, of which those that are told are subtracted."""
        if first == last:
            return self._negated(self._once(ca.OP_ADD, bare), first)
        if (ca.OP_SUB, (bare[1], bare[0])) in self._made:
            bare, first = bare[::-1], last
        return self._negated(self._once(ca.OP_SUB, bare), first)

    def _unsigned(self, k: int) -> tuple[int, bool]:
        """A value without its sign, and whether it has one."""
        node = self.nodes[k]
        if node.op == ca.OP_NEG:
            return node.reads[0], True
        if node.op == ca.OP_CONST and node.constant < 0.0:
            return self.constant(-node.constant), True
        return k, False

    def _negated(self, k: int, is_negative: bool) -> int:
        if is_negative and self.is_read and self.nodes[k].op == ca.OP_SUB:
            return self._once(ca.OP_SUB, [*self.nodes[k].reads[::-1]])
        return self._once(ca.OP_NEG, [k]) if is_negative else k

    def _once(self, op: int, operands: list[int]) -> int:
        """The value of an operation, the one that is there already."""
        key = (op, tuple(operands))
        if op in (ca.OP_ADD, ca.OP_MUL) and (op, key[1][::-1]) in self._made:
            key = (op, key[1][::-1])
        if key not in self._made:
            if op in (ca.OP_DIV, ca.OP_INV):
                self.divisors[operands[-1]] += 1
            self._made[key] = self._add(Node(*key))
        return self._made[key]

    def _number(self, k: int) -> float | None:
        node = self.nodes[k]
        return node.constant if node.op == ca.OP_CONST else None

    def _without_constant(self, k: int) -> tuple[int, float]:
        """x and the constant in which it ends, or from which it is taken."""
        node = self.nodes[k]
        if node.op in _SUMS and (last := self._number(node.reads[1])) is not None:
            return node.reads[0], last if node.op == ca.OP_ADD else -last
        if self.is_read and node.op == ca.OP_SUB and (first := self._number(node.reads[0])):
            return self._negated(node.reads[1], is_negative=True), first
        if self.is_read and node.op == ca.OP_NEG:
            rest, number = self._without_constant(node.reads[0])
            return self._negated(rest, is_negative=True) if number else k, -number
        return k, 0.0

    def _with_constant(self, k: int, number: float) -> int:
        """x + number, where x may end in a constant."""
        node = self.nodes[k]
        if node.op == ca.OP_NEG:
            return self._signed(ca.OP_NEG, [self._with_constant(node.reads[0], -number)])
        k, own = self._without_constant(k)
        number = snap(number + own, max(abs(number), abs(own)) if own else 0.0)
        if number == 0.0:
            return k
        op = ca.OP_SUB if number < 0.0 else ca.OP_ADD
        return self._signed(op, [k, self.constant(abs(number))])

    def _add(self, node: Node) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1
