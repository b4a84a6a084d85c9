"""C text of an algebraic system: rows, their derivatives and their change along a line, for lanes
of paths.

The SX graph is walked once into straight-line code in which every complex value is a pair of
vectors over the lanes. Where rows are more than unknowns, they are squared: each row that is kept
takes random multiples of those that are too many. The roots of the whole are among those of the
square system and, with probability one, regular there if they were; what the further rows leave is
returned beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import walk
from symkin.computed_once import cached_property
from symkin.homotopy.algebraic import AlgebraicSystem


class NoLaneCodeError(NotImplementedError):
    """The system has no form that lanes can evaluate; the text says why."""


def closure_source(system: AlgebraicSystem) -> str:
    """closure.h of a system: its sizes, the places of the ray, and `evaluate`. Raises
    NoLaneCodeError.
    """
    rows, further = squared_rows(system)
    direction = ca.SX.sym("dk", system.k.shape[0])
    outputs = [rows, ca.jacobian(rows, system.z), ca.jtimes(rows, system.k, direction), further]
    function = ca.Function("f", [system.z, system.k, direction], outputs, {"cse": True})
    in_ray, angles = (
        ", ".join("1" if i in places else "0" for i in range(system.width))
        for places in (system.projective, system.angles)
    )
    return "\n".join(
        [
            f"#define UNKNOWNS {system.width}",
            f"#define KNOWN {system.k.shape[0]}",
            f"#define PROJECTIVE {int(bool(system.projective))}",
            f"static const char in_ray[UNKNOWNS] = {{{in_ray}}};",
            f"static const char is_angle[UNKNOWNS] = {{{angles}}};",
            "static void evaluate(const v *restrict z, v s, const v *restrict begin, const v "
            "*restrict along, v *restrict a,",
            "                     v *restrict further)",
            "{",
            *_Walk(function, system.width).statements(),
            "}",
            "",
        ]
    )


def squared_rows(system: AlgebraicSystem) -> tuple[ca.SX, ca.SX]:
    """As many rows as unknowns (one fewer where there is a ray), each with random multiples of the
    further ones; and the further ones. Raises NoLaneCodeError where rows are too few.
    """
    need = system.width - int(bool(system.projective))
    if system.count < need:
        raise NoLaneCodeError(f"{system.count} rows do not determine {need} unknowns")
    order = _pivot_order(system, need)
    chosen, further = system.rows[order[:need], 0], system.rows[order[need:], 0]
    if system.count > need:
        mixing = np.random.default_rng(0).normal(size=(need, system.count - need))
        chosen = chosen + ca.mtimes(ca.DM(mixing), further)
    return chosen, further


def _pivot_order(system: AlgebraicSystem, need: int) -> list[int]:
    """Rows in the order in which elimination takes them at a random real point, so that it seldom
    has to exchange any.
    """
    rng = np.random.default_rng(0)
    jacobian = ca.Function("j", [system.z, system.k], [ca.jacobian(system.rows, system.z)])
    a = np.nan_to_num(
        np.asarray(
            ca.densify(jacobian(rng.normal(size=system.width), rng.normal(size=system.k.shape[0])))
        )
    )
    a /= np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-300)
    order: list[int] = []
    for column in range(need):
        pivot = max(
            (i for i in range(system.count) if i not in order), key=lambda i: abs(a[i, column])
        )
        order.append(pivot)
        factors = a[:, column] / (a[pivot, column] or 1.0)
        factors[order] = 0.0
        a -= np.outer(factors, a[pivot])
    return order + [i for i in range(system.count) if i not in order]


@dataclass(frozen=True)
class _Value:
    """Names of the two parts over the lanes; for a real constant its `number` and no imaginary
    part.
    """

    real: str
    imaginary: str = ""
    number: float | None = None


@dataclass
class _Walk:
    """Statements of a function f(z, k, dk) with the outputs rows, dF/dz, dF/dk dk and further
    rows.
    """

    function: ca.Function
    width: int
    lines: list[str] = field(default_factory=list)
    opposite: dict[_Value, _Value] = field(default_factory=dict)
    sines: dict[_Value, tuple[_Value, _Value]] = field(default_factory=dict)

    def statements(self) -> list[str]:
        f = self.function
        filled = {place for output in self._places for place in output}
        for row in range(f.size1_out(0)):
            for column in range(self.width + 2):
                if (row, column) not in filled:
                    self.lines.append(
                        f"a[{self._at(row, column)}] = a[{self._at(row, column)} + 1] = all(0.0);"
                    )
        walk(f, self)
        return self.lines

    @cached_property
    def _places(self) -> list[list[tuple[int, int]]]:
        """Row and column in the matrix of each nonzero of the first three outputs."""
        triplets = [
            list(zip(*self.function.sparsity_out(o).get_triplet(), strict=True)) for o in range(3)
        ]
        rows, jacobian, along = triplets
        return [
            [(r, self.width) for r, _ in rows],
            jacobian,
            [(r, self.width + 1) for r, _ in along],
        ]

    def _at(self, row: int, column: int) -> int:
        return 2 * (row * (self.width + 2) + column)

    def input(self, number: int, nonzero: int) -> _Value:
        i = nonzero
        if number == 0:
            return self._name(f"z[{2 * i}]", f"z[{2 * i + 1}]")
        if number == 1:
            return self._name(
                f"begin[{2 * i}] + s * along[{2 * i}]",
                f"begin[{2 * i + 1}] + s * along[{2 * i + 1}]",
            )
        return self._name(f"along[{2 * i}]", f"along[{2 * i + 1}]")

    def constant(self, number: float) -> _Value:
        return _constant(number)

    def output(self, number: int, nonzero: int, value: _Value) -> None:
        real, imaginary = _parts(value)
        if number >= len(self._places):
            self.lines.append(
                f"*further = larger(*further, {real} * {real} + {imaginary} * {imaginary});"
            )
        else:
            at = self._at(*self._places[number][nonzero])
            self.lines.append(f"a[{at}] = {real}, a[{at + 1}] = {imaginary};")

    def _name(self, real: str, imaginary: str) -> _Value:
        """A value of its own for two expressions."""
        n = len(self.lines)
        self.lines.append(f"v x{n} = {real}, y{n} = {imaginary};")
        return _Value(f"x{n}", f"y{n}")

    def operation(self, op: int, operands: list[_Value]) -> _Value:
        x = operands
        match op:
            case ca.OP_ADD:
                return self._sum(x[0], x[1], "+")
            case ca.OP_SUB:
                return self._sum(x[0], x[1], "-")
            case ca.OP_MUL:
                return self._product(x[0], x[1])
            case ca.OP_SQ:
                return self._product(x[0], x[0])
            case ca.OP_TWICE:
                return self._sum(x[0], x[0], "+")
            case ca.OP_NEG:
                return self._negative(x[0])
            case ca.OP_DIV:
                return self._product(x[0], self._inverse(x[1]))
            case ca.OP_INV:
                return self._inverse(x[0])
            case ca.OP_ASSIGN:
                return x[0]
            case ca.OP_SIN:
                return self._sine_and_cosine(x[0])[0]
            case ca.OP_COS:
                return self._sine_and_cosine(x[0])[1]
            case ca.OP_TAN:
                sine, cosine = self._sine_and_cosine(x[0])
                return self._product(sine, self._inverse(cosine))
            case ca.OP_SQRT:
                return self._call("square_root", x[0])
            case ca.OP_EXP:
                return self._call("exponential", x[0])
        raise NoLaneCodeError(f"CasADi operation {op} has no complex form here")

    def _sum(self, x: _Value, y: _Value, sign: str) -> _Value:
        if x.number is not None and y.number is not None:
            return _constant(x.number + y.number if sign == "+" else x.number - y.number)
        if x.imaginary and y.imaginary:
            return self._name(f"{x.real} {sign} {y.real}", f"{x.imaginary} {sign} {y.imaginary}")
        return self._name(f"{x.real} {sign} {y.real}", x.imaginary or f"{sign}{y.imaginary}")

    def _product(self, x: _Value, y: _Value) -> _Value:
        if x.number is not None and y.number is not None:
            return _constant(x.number * y.number)
        if x.imaginary and y.imaginary:
            return self._name(
                f"{x.real} * {y.real} - {x.imaginary} * {y.imaginary}",
                f"{x.real} * {y.imaginary} + {x.imaginary} * {y.real}",
            )
        factor, z = (y, x) if x.imaginary else (x, y)
        return self._name(f"{factor.real} * {z.real}", f"{factor.real} * {z.imaginary}")

    def _negative(self, x: _Value) -> _Value:
        if x.number is not None:
            return _constant(-x.number)
        y = self._name(f"-{x.real}", f"-{x.imaginary}")
        self.opposite[y] = x
        return y

    def _inverse(self, x: _Value) -> _Value:
        if x.number is not None:
            return _constant(1.0 / x.number if x.number else float("inf"))
        n = len(self.lines)
        self.lines.append(f"v q{n} = 1.0 / ({x.real} * {x.real} + {x.imaginary} * {x.imaginary});")
        return self._name(f"{x.real} * q{n}", f"-{x.imaginary} * q{n}")

    def _sine_and_cosine(self, x: _Value) -> tuple[_Value, _Value]:
        """Both at once; of -x from those of x."""
        if x not in self.sines and x in self.opposite:
            sine, cosine = self._sine_and_cosine(self.opposite[x])
            self.sines[x] = (self._negative(sine), cosine)
        elif x not in self.sines:
            n = len(self.lines)
            names = [f"sx{n}", f"sy{n}", f"cx{n}", f"cy{n}"]
            self.lines.append(f"v {', '.join(names)};")
            self.lines.append(
                f"sin_cos({', '.join(_parts(x))}, {', '.join('&' + name for name in names)});"
            )
            self.sines[x] = (_Value(names[0], names[1]), _Value(names[2], names[3]))
        return self.sines[x]

    def _call(self, function: str, x: _Value) -> _Value:
        n = len(self.lines)
        self.lines.append(f"v x{n}, y{n};")
        self.lines.append(f"{function}({', '.join(_parts(x))}, &x{n}, &y{n});")
        return _Value(f"x{n}", f"y{n}")


def _parts(x: _Value) -> tuple[str, str]:
    """The two parts as vectors."""
    return (x.real, x.imaginary) if x.number is None else (f"all({x.real})", "all(0.0)")


def _constant(number: float) -> _Value:
    if not isfinite(number):
        raise NoLaneCodeError("the closure has a constant that is not finite")
    return _Value(f"({number!r})", number=number)
