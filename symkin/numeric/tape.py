"""A CasADi function f(z, k) as a tape: numbered operations that the arithmetic of discs runs for
many points at once.

What k alone determines is a tape of its own, which is run once for each instance. Derivatives are
taken of the graph in which each constant is a symbol, because CasADi folds products of constants in
double precision: a tape stands for the graph with its constants taken as the exact doubles that
they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import instructions, rebuilt
from symkin.computed_once import cached_property
from symkin.spatial.backend import stacked

Part = Literal["value", "slope"]
"""A column f, or its derivatives by z."""
_EXACT = (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0)
"""Constants that stay numbers in a graph: sums and products of a few of them are exact in double
precision.
"""


class Op(IntEnum):
    """Operations, with the numbers that `discs.h` has for them. An instruction holds the operation
    and three places.
    """

    INPUT = 0
    CONSTANT = 1
    OUTPUT = 2
    ADD = 3
    SUBTRACT = 4
    MULTIPLY = 5
    SQUARE = 6
    NEGATE = 7
    TWICE = 8
    INVERT = 9
    SINE = 10
    COSINE = 11
    ROOT = 12
    EXPONENTIAL = 13
    ANGLE = 14


_SAME = {
    ca.OP_ADD: Op.ADD,
    ca.OP_SUB: Op.SUBTRACT,
    ca.OP_MUL: Op.MULTIPLY,
    ca.OP_SQ: Op.SQUARE,
    ca.OP_NEG: Op.NEGATE,
    ca.OP_TWICE: Op.TWICE,
    ca.OP_INV: Op.INVERT,
    ca.OP_SIN: Op.SINE,
    ca.OP_COS: Op.COSINE,
    ca.OP_SQRT: Op.ROOT,
    ca.OP_EXP: Op.EXPONENTIAL,
    ca.OP_ATAN2: Op.ANGLE,
}


@dataclass(frozen=True, eq=False)
class Code:
    """Instructions (length, 4): operation, the places a and b that it reads, and the one that it
    writes. INPUT reads entry a of the inputs, CONSTANT entry a of `constants`, OUTPUT writes entry
    `out` of the outputs.
    """

    instructions: np.ndarray
    constants: np.ndarray
    places: int
    inputs: int
    outputs: int

    @cached_property
    def lines(self) -> list[list[int]]:
        """The instructions as numbers of Python."""
        return self.instructions.tolist()


@dataclass(frozen=True, eq=False)
class Tape:
    """f(z, k): `before` takes k and the constants' values to what z does not enter; each of `parts`
    takes z, followed by that, to the nonzeros of one matrix, of which `patterns` holds rows and
    columns.
    """

    width: int
    before: Code
    parts: tuple[Code, ...]
    patterns: tuple[tuple[np.ndarray, np.ndarray], ...]
    values: np.ndarray

    @cached_property
    def places(self) -> list[tuple[list[int], list[int]]]:
        """The `patterns` as numbers of Python."""
        return [(rows.tolist(), columns.tolist()) for rows, columns in self.patterns]

    @cached_property
    def has_known(self) -> bool:
        """Whether k enters: not constants alone."""
        lines = self.before.instructions
        return bool(
            np.any(
                (lines[:, 0] == Op.INPUT) & (lines[:, 1] < self.before.inputs - len(self.values))
            )
        )


@dataclass(frozen=True)
class _Node:
    """One value: operation, earlier values that it is made of (or the entry of an input), and
    whether z enters it.
    """

    op: Op
    operands: tuple[int, ...]
    moving: bool
    constant: float = 0.0


def build_tape(z: ca.SX, k: ca.SX, f: ca.SX, parts: Sequence[Part]) -> Tape:
    """The tape of a column f(z, k) and of its derivatives. Raises NotImplementedError for an
    operation without a disc.
    """
    raised, constants, values = raise_constants(f, z, k)
    expressions = [derive(raised, z, part) for part in parts]
    function = ca.Function("f", [z, ca.vertcat(k, constants)], expressions, {"cse": True})
    nodes, outputs = _nodes(function)
    wanted = [[outputs[i, j] for j in range(function.nnz_out(i))] for i in range(len(parts))]
    needed = _reached(nodes, [n for part in wanted for n in part])
    moving = [i for i in needed if nodes[i].moving]
    kept = sorted(
        {a for i in moving for a in _operands(nodes[i]) if not nodes[a].moving}
        | {n for part in wanted for n in part if not nodes[n].moving}
    )
    entry = {n: z.shape[0] + i for i, n in enumerate(kept)}
    before = _code(nodes, kept, {}, k.shape[0] + constants.shape[0])
    codes = tuple(_code(nodes, part, entry, z.shape[0] + len(kept)) for part in wanted)
    patterns = tuple(_pattern(function, i) for i in range(len(parts)))
    return Tape(z.shape[0], before, codes, patterns, np.array(values, dtype=float))


def derive(f: ca.SX, z: ca.SX, part: Part) -> ca.SX:
    return f if part == "value" else ca.jacobian(f, z)


def raise_constants(expression: ca.SX, *inputs: ca.SX) -> tuple[ca.SX, ca.SX, tuple[float, ...]]:
    """The same graph with a symbol in place of each constant that is not a small power of two; the
    symbols and values.
    """
    function = ca.Function("f", list(inputs), [ca.densify(expression)], {"cse": True})
    places: dict[float, ca.SX] = {}

    def raised(value: float) -> ca.SX:
        return (
            ca.SX(value)
            if value in _EXACT
            else places.setdefault(value, ca.SX.sym(f"c{len(places)}"))
        )

    result = rebuilt(function, inputs, raised, lambda value: value)
    return result, stacked(places.values()), tuple(places)


def _pattern(function: ca.Function, i: int) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = function.sparsity_out(i).get_triplet()
    return np.array(rows, dtype=np.intc), np.array(columns, dtype=np.intc)


def _operands(node: _Node) -> tuple[int, ...]:
    return () if node.op in (Op.INPUT, Op.CONSTANT) else node.operands


def _nodes(function: ca.Function) -> tuple[list[_Node], dict[tuple[int, int], int]]:
    """Each operation as a value of its own, and the values of the outputs' nonzeros."""
    nodes: list[_Node] = []
    slots: dict[int, int] = {}
    outputs: dict[tuple[int, int], int] = {}

    def add(op: Op, *operands: int) -> int:
        nodes.append(_Node(op, operands, any(nodes[i].moving for i in operands)))
        return len(nodes) - 1

    for op, a, o, constant in instructions(function):
        if op == ca.OP_OUTPUT:
            outputs[o[0], o[1]] = slots[a[0]]
            continue
        if op == ca.OP_INPUT:
            nodes.append(_Node(Op.INPUT, (a[1],), moving=a[0] == 0))
            slots[o[0]] = len(nodes) - 1
        elif op == ca.OP_CONST:
            nodes.append(_Node(Op.CONSTANT, (), moving=False, constant=constant))
            slots[o[0]] = len(nodes) - 1
        elif op == ca.OP_ASSIGN:
            slots[o[0]] = slots[a[0]]
        elif op == ca.OP_DIV:
            slots[o[0]] = add(Op.MULTIPLY, slots[a[0]], add(Op.INVERT, slots[a[1]]))
        elif op == ca.OP_TAN:
            slots[o[0]] = add(
                Op.MULTIPLY, add(Op.SINE, slots[a[0]]), add(Op.INVERT, add(Op.COSINE, slots[a[0]]))
            )
        elif op in _SAME:
            slots[o[0]] = add(_SAME[op], *(slots[i] for i in a))
        else:
            raise NotImplementedError(f"CasADi operation {op} has no form over discs here")
    return nodes, outputs


def _reached(nodes: list[_Node], ends: Iterable[int], given: Iterable[int] = ()) -> list[int]:
    """The values that `ends` are made of, in order; `given` ones are not taken apart."""
    found, todo, given = set(), list(ends), set(given)
    while todo:
        i = todo.pop()
        if i not in found:
            found.add(i)
            todo += () if i in given else _operands(nodes[i])
    return sorted(found)


def _code(nodes: list[_Node], ends: Sequence[int], entry: dict[int, int], inputs: int) -> Code:
    """Instructions for the values `ends`, in which the values of `entry` are inputs; places are
    used again once free.
    """
    chosen = _reached(nodes, ends, entry)
    last: dict[int, int] = {}
    for i in chosen:
        last |= {} if i in entry else dict.fromkeys(_operands(nodes[i]), i)
    finals: dict[int, list[int]] = {}
    for place, n in enumerate(ends):
        finals.setdefault(n, []).append(place)
    free: list[int] = []
    places: dict[int, int] = {}
    lines: list[tuple[int, int, int, int]] = []
    constants: list[float] = []
    count = 0
    for i in chosen:
        node = nodes[i]
        if i in entry or node.op == Op.INPUT:
            op, a, b = Op.INPUT, entry.get(i, node.operands[0] if node.op == Op.INPUT else 0), 0
        elif node.op == Op.CONSTANT:
            op, a, b = Op.CONSTANT, len(constants), 0
            constants.append(node.constant)
        else:
            op, a, b = node.op, places[node.operands[0]], places[node.operands[-1]]
            free += [places[j] for j in set(node.operands) if last[j] == i]
        if free:
            places[i] = free.pop()
        else:
            places[i], count = count, count + 1
        lines.append((op, a, b, places[i]))
        lines += [(Op.OUTPUT, places[i], 0, place) for place in finals.get(i, ())]
        if i not in last:
            free.append(places[i])
    return Code(
        np.array(lines, dtype=np.intc).reshape(-1, 4),
        np.array(constants, dtype=float),
        max(count, 1),
        inputs,
        len(ends),
    )
