"""Graphs of CasADi evaluated in ball arithmetic (Arb, by python-flint): every rounding is outward.

A function f(z; k) is walked once into straight-line code over balls, in two parts: what depends on
k alone, and the rest. Derivatives are taken of the graph in which each constant is a symbol,
because CasADi folds products of constants in double precision: the derivative is then that of the
graph with its constants taken as the exact doubles that they are.

F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Trans.
Comput. 66 (2017) 1281.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ContextDecorator
from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca
from flint import acb, acb_mat, arb, arb_mat, ctx

from symkin.closure.expression_graph import instructions, rebuilt
from symkin.computed_once import cached_property, set_waiting
from symkin.locks import Lock

Number = Any
"""A ball: arb or acb."""
Part = Literal["value", "slope"]

_EXACT = (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0)
"""Constants that stay numbers in a graph: sums and products of a few of them are exact in double
precision.
"""
UP = 1.0 + 2.0**-50
"""Outward rounding of a few operations on doubles that are not negative."""
_BINARY = {
    ca.OP_ADD: "{} + {}",
    ca.OP_SUB: "{} - {}",
    ca.OP_MUL: "{} * {}",
    ca.OP_DIV: "{} / {}",
    ca.OP_ATAN2: "angle_of({}, {})",
}
_UNARY = {
    ca.OP_SIN: "{}.sin()",
    ca.OP_COS: "{}.cos()",
    ca.OP_TAN: "{}.tan()",
    ca.OP_EXP: "{}.exp()",
    ca.OP_SQRT: "root_of({})",
    ca.OP_NEG: "-{}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "1 / {}",
    ca.OP_ASSIGN: "{}",
}


@dataclass(frozen=True)
class Ring:
    """Balls of one kind, with their matrices."""

    number: Callable[..., Number]
    matrix: Callable[..., Any]
    is_real: bool

    def around_zero(self, radius: float) -> Number:
        """The ball (a square in the complex plane) of at least that radius."""
        side = arb(0.0, radius)
        return side if self.is_real else acb(side, side)

    def column(self, entries: Sequence[Number]) -> Any:
        return self.matrix(len(entries), 1, list(entries))


REAL = Ring(arb, arb_mat, is_real=True)
COMPLEX = Ring(acb, acb_mat, is_real=False)
RINGS = (REAL, COMPLEX)
"""In the order in which they are tried at a point that looks real."""


_context = Lock()
"""Held by the thread that works with balls: their precision belongs to the process."""


class precision(ContextDecorator):  # noqa: N801  # called as a function
    """Work at that many bits, one thread at a time; the caller's precision comes back."""

    __slots__ = ("_before", "_waited", "bits")

    def __init__(self, bits: int) -> None:
        self.bits = bits

    def _recreate_cm(self) -> precision:
        """A decorated function may be called by threads: each call has its own."""
        return precision(self.bits)

    def __enter__(self) -> None:
        _context.acquire()
        self._waited = set_waiting(waits=False)
        self._before = ctx.prec
        ctx.prec = self.bits

    def __exit__(self, *_: object) -> None:
        ctx.prec = self._before
        set_waiting(waits=self._waited)
        _context.release()


def upper(x: Number) -> float:
    """A double that no |value| in the ball exceeds; infinite for what is not finite."""
    bound = float(x.abs_upper()) * UP
    return bound if bound == bound else float("inf")


@dataclass(frozen=True, eq=False)
class BallFunction:
    """f(z; k) over balls, a column. `parts` says what is evaluated, in order: "value" f, "slope"
    df/dz.
    """

    z: ca.SX
    k: ca.SX
    f: ca.SX
    parts: tuple[Part, ...] = ("value",)

    @cached_property
    def _code(self) -> tuple[Callable[..., Any], tuple[Callable[..., Any], ...], tuple[float, ...]]:
        f, constants, values = raise_constants(self.f, self.z, self.k)
        expressions = [derive(f, self.z, part) for part in self.parts]
        functions = [
            ca.Function("f", [self.z, ca.vertcat(self.k, constants)], [e], {"cse": True})
            for e in expressions
        ]
        prepare, evaluate = zip(*(straight_line(f) for f in functions), strict=True)
        return lambda known, number: [p(known, number) for p in prepare], evaluate, values

    def prepare(self, ring: Ring, known: Sequence[Number]) -> list[Any]:
        """What k alone determines, at the present precision; k as doubles (exact) or balls."""
        prepare, _, values = self._code
        return prepare([ring.number(v) for v in (*known, *values)], ring.number)

    def evaluate(self, which: int, z: Sequence[Number], prepared: list[Any]) -> list[Number]:
        """Part `which` at balls z, a dense matrix row by row."""
        return self._code[1][which](z, prepared[which])


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
    return result, ca.vertcat(ca.SX(0, 1), *places.values()), tuple(places)


def straight_line(function: ca.Function) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """f(z, k) -> one matrix, as two functions: prepare(k, number), and evaluate(z, prepared) -> its
    entries row by row.

    Raises NotImplementedError for an operation without a form over balls.
    """
    before: list[str] = []
    after: list[str] = []
    names: dict[int, tuple[str, bool]] = {}
    kept: dict[str, None] = {}
    pattern = function.sparsity_out(0)
    entries = ["0"] * pattern.numel()
    places = [r * pattern.size2() + c for r, c in zip(*pattern.get_triplet(), strict=True)]
    for i, (op, a, o, constant) in enumerate(instructions(function)):
        used = [names[j] for j in a] if op not in (ca.OP_INPUT, ca.OP_CONST) else []
        moving = any(m for _, m in used)
        if op == ca.OP_OUTPUT:
            entries[places[o[1]]] = used[0][0]
            kept |= {} if moving else {used[0][0]: None}
            continue
        if op == ca.OP_INPUT:
            moving, text = a[0] == 0, f"{'zk'[a[0]]}[{a[1]}]"
        elif op == ca.OP_CONST:
            text = f"number({constant!r})"
        elif op in _BINARY or op in _UNARY:
            text = (_BINARY.get(op) or _UNARY[op]).format(*(name for name, _ in used))
        else:
            raise NotImplementedError(f"CasADi operation {op} has no form over balls here")
        names[o[0]] = (f"v{i}", moving)
        (after if moving else before).append(f"v{i} = {text}")
        kept |= {name: None for name, m in used if moving and not m}
    return _compiled(before, after, list(kept), entries)


def _compiled(
    before: list[str], after: list[str], kept: list[str], entries: list[str]
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    indent = "\n    "
    tuple_of_kept = f"({', '.join(kept)}{',' if kept else ''})"
    source = [
        f"def prepare(k, number):{indent}{indent.join([*before, f'return {tuple_of_kept}'])}",
        f"def evaluate(z, prepared):{indent}{tuple_of_kept if kept else '_'} = prepared{indent}"
        + indent.join([*after, f"return [{', '.join(entries)}]"]),
    ]
    scope: dict[str, Any] = {"root_of": root_of, "angle_of": angle_of}
    exec(compile("\n".join(source), "<balls>", "exec"), scope)
    return scope["prepare"], scope["evaluate"]


def root_of(x: Number) -> Number:
    """Square root; not a number where a ball meets the cut, on which the root is not analytic."""
    return x.sqrt() if isinstance(x, arb) else x.sqrt(analytic=True)


def angle_of(y: Number, x: Number) -> Number:
    """atan2(y, x) modulo 2 pi, of real balls alone: the branch that is continuous on the ball."""
    if isinstance(y, acb):
        return acb("nan")
    return arb.pi() + arb.atan2(-y, -x) if x < 0 else arb.atan2(y, x)
