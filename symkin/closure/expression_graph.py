"""Walk the instruction graph of a CasADi SX function: one loop for everything that reads it.

CasADi stores an SX function as instructions that read and write numbered slots. `walk` follows them
and hands each operation with its operands to an evaluator, which makes of them what it wants:
expressions, C text, LaTeX, complex arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import casadi as ca

Value = TypeVar("Value")


class Instruction(NamedTuple):
    """One step of an SX function: the operation, the slots that it reads and writes (for inputs and
    outputs: their number and the entry), and the number of a constant (0 for all others).
    """

    op: int
    inputs: list[int]
    outputs: list[int]
    constant: float


class Evaluator(Protocol[Value]):
    """What `walk` asks for: the value of an input's nonzero, of a constant and of an operation; and
    where results go.
    """

    def input(self, number: int, nonzero: int) -> Value: ...
    def constant(self, number: float) -> Value: ...
    def operation(self, op: int, operands: list[Value]) -> Value: ...
    def output(self, number: int, nonzero: int, value: Value) -> None: ...


def instructions(function: ca.Function) -> Iterator[Instruction]:
    """Yield the instructions of an SX function in the order of their evaluation; slots are used
    again once they are free.
    """
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        constant = function.instruction_constant(k) if op == ca.OP_CONST else 0.0
        yield Instruction(
            op, function.instruction_input(k), function.instruction_output(k), constant
        )


def walk(function: ca.Function, evaluator: Evaluator[Value]) -> None:
    """Evaluate an SX function instruction by instruction with an evaluator's own values."""
    slots: dict[int, Value] = {}
    for op, i, o, number in instructions(function):
        if op == ca.OP_INPUT:
            slots[o[0]] = evaluator.input(i[0], i[1])
        elif op == ca.OP_CONST:
            slots[o[0]] = evaluator.constant(number)
        elif op == ca.OP_OUTPUT:
            evaluator.output(o[0], o[1], slots[i[0]])
        else:
            slots[o[0]] = evaluator.operation(op, [slots[n] for n in i])


@dataclass
class _Rebuilt:
    """Evaluator that writes the first output anew as an expression."""

    result: ca.SX
    places: Sequence[tuple[int, int]]
    symbols: Sequence[ca.SX]
    replace_constant: Callable[[float], ca.SX]
    replace_result: Callable[[ca.SX], ca.SX]

    def input(self, number: int, nonzero: int) -> ca.SX:
        return self.symbols[number].nz[nonzero]

    def constant(self, number: float) -> ca.SX:
        return self.replace_constant(number)

    def operation(self, op: int, operands: list[ca.SX]) -> ca.SX:
        make = ca.SX.binary if len(operands) == 2 else ca.SX.unary
        return self.replace_result(make(op, *operands))

    def output(self, number: int, nonzero: int, value: ca.SX) -> None:
        if number == 0:
            self.result[self.places[nonzero]] = value


def rebuilt(
    function: ca.Function,
    symbols: Sequence[ca.SX],
    constant: Callable[[float], ca.SX],
    value: Callable[[ca.SX], ca.SX],
) -> ca.SX:
    """Write the first output of a function as an expression of `symbols`, with other constants and
    with `value` of each result; what that makes constant folds.
    """
    pattern = function.sparsity_out(0)
    places = list(zip(*pattern.get_triplet(), strict=True))
    evaluator = _Rebuilt(ca.SX(*pattern.shape), places, symbols, constant, value)
    walk(function, evaluator)
    return evaluator.result
