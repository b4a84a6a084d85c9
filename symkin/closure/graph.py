"""Walking the graph of a CasADi function: one loop for all that read it, whatever they make of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import casadi as ca


class Instruction(NamedTuple):
    """One step of an SX function: the operation, the slots that it reads and writes (for inputs and outputs: their number
    and the entry), and the number of a constant (0 for all others)."""

    op: int
    inputs: list[int]
    outputs: list[int]
    constant: float


def instructions(function: ca.Function) -> Iterator[Instruction]:
    """The instructions of an SX function, in the order of their evaluation."""
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        constant = function.instruction_constant(k) if op == ca.OP_CONST else 0.0
        yield Instruction(op, function.instruction_input(k), function.instruction_output(k), constant)


def rebuilt(
    function: ca.Function, symbols: Sequence[ca.SX], constant: Callable[[float], ca.SX], value: Callable[[ca.SX], ca.SX]
) -> ca.SX:
    """The first output of a function as an expression of `symbols`, with other constants and with `value` of each result;
    what that makes constant folds."""
    slots: dict[int, ca.SX] = {}
    pattern = function.sparsity_out(0)
    result = ca.SX(pattern.size1(), pattern.size2())
    rows, columns = pattern.get_triplet()
    for op, i, o, number in instructions(function):
        if op == ca.OP_INPUT:
            slots[o[0]] = symbols[i[0]].nz[i[1]]
        elif op == ca.OP_CONST:
            slots[o[0]] = constant(number)
        elif op == ca.OP_OUTPUT:
            result[rows[o[1]], columns[o[1]]] = slots[i[0]]
        elif len(i) == 2:
            slots[o[0]] = value(ca.SX.binary(op, slots[i[0]], slots[i[1]]))
        else:
            slots[o[0]] = value(ca.SX.unary(op, slots[i[0]]))
    return result
