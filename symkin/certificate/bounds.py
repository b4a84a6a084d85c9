"""Theorems that bound the number of solutions, and what makes a list of them complete.

Each theorem is about a family in which the configuration x and the geometry p move freely and the
known values follow: the pairs (x, known) of the closure form an irreducible variety of the
dimension of the known values and p, and over generic ones there are `count` solutions x. If so many
different regular ones are found for a member of the family, there is no other, isolated or not:
near another, a curve in the variety would lead to generic members with one solution more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import prod
from typing import NamedTuple

import casadi as ca
import numpy as np

from symkin.certificate.certificate import CertificateBatch
from symkin.certificate.discs import DiscFunction, Knowns
from symkin.certificate.exact import exact_arm
from symkin.certificate.tape import build_tape
from symkin.closure.expression_graph import Instruction, instructions
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import universal_system
from symkin.homotopy.six_revolute import is_six_revolute
from symkin.homotopy.structure import Structure
from symkin.position.problem import Problem

_GEOMETRY_ROUNDING = 1e-13
"""How far numbers that are read from a block's rows are from the geometry's, of the size and of
themselves: some hundreds of roundings.
"""


@dataclass(frozen=True)
class Theorem:
    """At most `count` solutions over the complex numbers."""

    count: int
    about: str
    reference: str


SIX_DISTANCES = Theorem(
    40,
    "poses of a body with six points at given distances from six points, in SE(3) over the "
    "complex numbers",
    "F. Ronga, T. Vust, Stewart platforms without computer?, Trento 1992 (de Gruyter 1995, "
    "197-212); "
    "B. Mourrain, The 40 generic positions of a parallel robot, ISSAC 1993, 173-182",
)
SIX_REVOLUTE = Theorem(
    16,
    "joint angles of an arm of six revolute joints with a given tool pose, over the complex "
    "numbers modulo whole turns",
    "E. J. F. Primrose, Mech. Mach. Theory 21 (1986) 509-510; H.-Y. Lee, C.-G. Liang, Mech. Mach. "
    "Theory 23 (1988) 219-226; "
    "M. Raghavan, B. Roth, J. Mech. Des. 115 (1993) 502-508",
)


@dataclass(frozen=True, eq=False)
class Bound:
    """A theorem, the system to certify for it, and its known values from those of the problem."""

    theorem: Theorem
    system: AlgebraicSystem
    knowns: Callable[[Knowns], Knowns] = lambda knowns: knowns


def bound_of(
    problem: Problem, system: AlgebraicSystem, structure: Structure | None = None
) -> Bound | None:
    """The bound on the roots of one of a problem's algebraic systems, or of the system of its
    structure, where a theorem is known.
    """
    if structure is not None and structure.system.projective:
        return Bound(SIX_DISTANCES, structure.system, partial(_of_structure, structure))
    if system is universal_system():
        return Bound(SIX_DISTANCES, system)
    if is_six_revolute(problem):
        arm, geometry = exact_arm(problem, system)
        return Bound(SIX_REVOLUTE, arm, lambda knowns: knowns.beside(geometry))
    return _of_triangular_rows(system)


def _of_triangular_rows(system: AlgebraicSystem) -> Bound | None:
    """The bound on the roots of rows that hold one unknown more each than those before: every root
    of the first ones goes on to as many as the next row's degree. A row that vanishes at some of
    these has no isolated root there, and the count is not reached. An unknown that enters rows
    times numbers is taken from all of them but one, which gives it.
    """
    if system.projective or system.count != system.width:
        return None
    slopes = ca.jacobian(system.rows, system.z)
    rows = [_unknowns_in(system, slopes, i) for i in range(system.count)]
    degrees: dict[str, int] = {}
    while rows:
        taken = _next_row(rows)
        degree = None if taken is None else rows[taken[0]][taken[1]].degree
        if taken is None or degree is None:
            return None
        giving, k = rows.pop(taken[0]), taken[1]
        rows = [_without(row, k, giving) if k in row else row for row in rows]
        degrees[system.unknowns[k].name] = degree
    counts = [
        (degrees[c.name] + 1) // 2 if c.least is not None else degrees[c.name]
        for c in system.unknowns
    ]
    squares = " in the square of the length" * any(c.least is not None for c in system.unknowns)
    names, numbers = ", ".join(degrees), ", ".join(str(v) for v in degrees.values())
    if len(set(degrees.values())) == 1:
        of_degree = f"of degree {next(iter(degrees.values()))}"
    else:
        of_degree = f"of degrees {numbers}"
    text = (
        f"{names} alone, by a polynomial {of_degree}{squares}"
        if len(degrees) == 1
        else f"{names} one after another, by polynomials {of_degree}{squares}"
    )
    return Bound(Theorem(prod(counts), text, "fundamental theorem of algebra"), system)


class _Unknown(NamedTuple):
    """How a row holds an unknown: by a polynomial of a `degree`, None where it is none; whether
    that is the unknown times a number.
    """

    degree: int | None
    is_linear: bool


def _unknowns_in(system: AlgebraicSystem, slopes: ca.SX, row: int) -> dict[int, _Unknown]:
    """The unknowns of a row, by their places."""
    steps = row_steps(system, row)
    return {
        k: _Unknown(univariate_degree(system, steps, k), slopes[row, k].is_constant())
        for k in range(system.width)
        if slopes.sparsity().has_nz(row, k)
    }


def _next_row(rows: list[dict[int, _Unknown]]) -> tuple[int, int] | None:
    """A row, and the unknown that it gives: its only one, or one that enters all rows that hold it
    times a number.
    """
    for i, row in enumerate(rows):
        if len(row) == 1:
            return i, next(iter(row))
    for i, row in enumerate(rows):
        for k in row:
            if all(other[k].is_linear for other in rows if k in other):
                return i, k
    return None


def _without(
    row: dict[int, _Unknown], gone: int, giving: dict[int, _Unknown]
) -> dict[int, _Unknown]:
    """A row without the unknown that another one gives, which is known then, or is put in."""
    left = {k: held for k, held in row.items() if k != gone}
    if len(giving) == 1:
        return left
    for k, other in giving.items():
        own = left.get(k, other)
        degrees = [own.degree, other.degree]
        degree = None if None in degrees else max(d for d in degrees if d is not None)
        if k != gone:
            left[k] = _Unknown(degree, own.is_linear and other.is_linear)
    return left


def _of_structure(structure: Structure, knowns: Knowns) -> Knowns:
    """The distances and points of six rods from the known values of a block, in units of the size.
    The rows that they are read from hold the geometry to rounding.
    """
    function, here = _distances(structure), np.zeros(knowns.count, dtype=np.intc)
    found = function.evaluate(0, knowns.discs, function.prepare(knowns.discs), here)
    rounding = _GEOMETRY_ROUNDING * (1.0 + np.abs(found.middle))
    return Knowns.exact(found.middle).widened(found.radius + rounding)


@lru_cache(maxsize=64)
def _distances(structure: Structure) -> DiscFunction:
    known = ca.SX.sym("k", structure.data.size1_in(0))
    return DiscFunction(build_tape(known, ca.SX(0, 1), structure.data(known), ("value",)))


def proves(found: CertificateBatch, bound: Bound) -> np.ndarray:
    """Instances (n,) whose certified roots are all solutions that there are, each known to be real
    or not: they are as many as the theorem allows, proved to be different from each other, and
    poses.
    """
    n, count = found.knowns.count, bound.theorem.count
    if found.system is not bound.system:
        return np.zeros(n, dtype=bool)
    whole = found.certified & found.pose & (found.real != "unknown")
    every, sure = (np.bincount(found.instance[some], minlength=n) for some in (slice(None), whole))
    return np.asarray((every == count) & (sure == count) & (found.distinct == count))


# --- one row in one unknown -----------------------------------------------------------------------


@dataclass(frozen=True)
class _Degree:
    """What is known of an intermediate value as a function of the unknown z: its degree as a
    polynomial in z, or, with `turning`, as one in exp(i z) and exp(-i z), of half angles by halves;
    `flips` where a whole turn of z changes its sign; `slope`, if it is slope z + something that z
    does not enter.
    """

    degree: Fraction = Fraction(0)
    turning: bool = False
    slope: Fraction | None = Fraction(0)
    flips: bool = False


_KNOWN = _Degree()


def row_steps(system: AlgebraicSystem, row: int) -> list[Instruction]:
    """How a row is computed from unknowns and known values."""
    rows = [ca.densify(system.rows[row])]
    return list(instructions(ca.Function("row", [system.z, system.k], rows, {"cse": True})))


def univariate_degree(
    system: AlgebraicSystem, steps: Sequence[Instruction], unknown: int
) -> int | None:
    """The degree of a row, by its steps, as a polynomial in the unknown z of this number, the
    others known, or, for an angle, twice that in exp(i z): a bound on its roots, modulo whole
    turns. None where it is no such row.
    """
    work: dict[int, tuple[_Degree, float | None]] = {}
    result: _Degree | None = None
    for op, a, o, constant in steps:
        if op == ca.OP_INPUT:
            own = _Degree(Fraction(1), slope=Fraction(1))
            work[o[0]] = (own if a == [0, unknown] else _KNOWN, None)
        elif op == ca.OP_CONST:
            work[o[0]] = (_KNOWN, constant)
        elif op == ca.OP_OUTPUT:
            result = work[a[0]][0]
        else:
            degree = _degree_of(op, [work[j] for j in a])
            if degree is None:
                return None
            work[o[0]] = (degree, None)
    if (
        result is None
        or result.degree == 0
        or result.flips
        or (result.turning and not system.unknowns[unknown].is_periodic)
    ):
        return None
    return int(2 * result.degree if result.turning else result.degree)


def _degree_of(op: int, operands: list[tuple[_Degree, float | None]]) -> _Degree | None:
    """The degree of one operation's result; None where it is no polynomial."""
    degrees = [d for d, _ in operands]
    x = degrees[0]
    if all(d is _KNOWN or d.degree == 0 for d in degrees):
        return _KNOWN
    if len({d.turning for d in degrees if d.degree}) > 1:
        return None
    turning = any(d.turning for d in degrees)
    slopes = [d.slope for d in degrees]
    if op in (ca.OP_ADD, ca.OP_SUB):
        if degrees[0].flips != degrees[1].flips:
            return None
        first, second = slopes
        slope = (
            None
            if first is None or second is None
            else first + second
            if op == ca.OP_ADD
            else first - second
        )
        highest = max(d.degree for d in degrees)
        return _Degree(highest, turning, None if turning else slope, degrees[0].flips)
    if op in (ca.OP_NEG, ca.OP_TWICE, ca.OP_ASSIGN):
        factor = {ca.OP_NEG: -1, ca.OP_TWICE: 2}.get(op, 1)
        return _Degree(x.degree, turning, None if x.slope is None else factor * x.slope, x.flips)
    if op == ca.OP_SQ:
        return _Degree(2 * x.degree, turning, None)
    if op == ca.OP_MUL:
        product = sum((d.degree for d in degrees), Fraction(0))
        return _Degree(product, turning, _scaled(operands), degrees[0].flips != degrees[1].flips)
    if op == ca.OP_DIV and degrees[1].degree == 0:
        return _Degree(x.degree, turning, None, x.flips)
    if op in (ca.OP_SIN, ca.OP_COS) and x.slope is not None and x.slope.denominator <= 2:
        return _Degree(abs(x.slope), True, None, x.slope.denominator == 2)
    return None


def _scaled(operands: list[tuple[_Degree, float | None]]) -> Fraction | None:
    """Slope of a product with a number."""
    (x, c), (y, d) = operands
    if c is not None and y.slope is not None:
        return Fraction(c) * y.slope
    return Fraction(d) * x.slope if d is not None and x.slope is not None else None
