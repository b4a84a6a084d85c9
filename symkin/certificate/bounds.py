"""Theorems that bound the number of solutions, and what makes a list of them complete.

Each theorem is about a family in which the configuration x and the geometry p move freely and the
known values follow: the pairs (x, known) of the closure form an irreducible variety of the
dimension of the known values and p, and over generic ones there are `count` solutions x. If so many
different regular ones are found for a member of the family, there is no other, isolated or not:
near another, a curve in the variety would lead to generic members with one solution more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import casadi as ca
import numpy as np

from symkin.certificate.certificate import CertificateBatch
from symkin.certificate.discs import DiscFunction
from symkin.certificate.exact import exact_arm
from symkin.certificate.knowns import Knowns
from symkin.certificate.tape import build_tape
from symkin.closure.expression_graph import instructions
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
    if problem.of_joints and system is universal_system():
        return Bound(SIX_DISTANCES, system)
    if is_six_revolute(problem):
        arm, geometry = exact_arm(problem, system)
        return Bound(SIX_REVOLUTE, arm, lambda knowns: knowns.beside(geometry))
    degree = univariate_degree(system)
    if degree is None:
        return None
    least = system.unknowns[0].least is not None
    text = f"{system.unknowns[0].name} alone, by a polynomial of degree {degree}" + (
        " in the square of the length" * least
    )
    return Bound(
        Theorem((degree + 1) // 2 if least else degree, text, "fundamental theorem of algebra"),
        system,
    )


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
    polynomial in z, or, with `turning`, as one in exp(i z) and exp(-i z); `slope`, if it is slope
    z + something that z does not enter.
    """

    degree: int = 0
    turning: bool = False
    slope: Fraction | None = Fraction(0)


def univariate_degree(system: AlgebraicSystem) -> int | None:
    """The degree of a single row as a polynomial in its single unknown z, or, for an angle, twice
    that in exp(i z): a bound on its roots, modulo whole turns. None where the system is no such
    row.
    """
    if system.width != 1 or system.count != 1 or system.projective:
        return None
    function = ca.Function("f", [system.z, system.k], [ca.densify(system.rows)], {"cse": True})
    work: dict[int, tuple[_Degree, float | None]] = {}
    result: _Degree | None = None
    for op, a, o, constant in instructions(function):
        if op == ca.OP_INPUT:
            work[o[0]] = (_Degree(1, slope=Fraction(1)) if a[0] == 0 else _Degree(), None)
        elif op == ca.OP_CONST:
            work[o[0]] = (_Degree(), constant)
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
        or (result.turning and not system.unknowns[0].is_periodic)
    ):
        return None
    return 2 * result.degree if result.turning else result.degree


def _degree_of(op: int, operands: list[tuple[_Degree, float | None]]) -> _Degree | None:
    """The degree of one operation's result; None where it is no polynomial."""
    degrees = [d for d, _ in operands]
    x = degrees[0]
    if all(d.degree == 0 for d in degrees):
        return _Degree()
    if len({d.turning for d in degrees if d.degree}) > 1:
        return None
    turning = any(d.turning for d in degrees)
    slopes = [d.slope for d in degrees]
    if op in (ca.OP_ADD, ca.OP_SUB):
        first, second = slopes
        slope = (
            None
            if first is None or second is None
            else first + second
            if op == ca.OP_ADD
            else first - second
        )
        return _Degree(max(d.degree for d in degrees), turning, None if turning else slope)
    if op in (ca.OP_NEG, ca.OP_TWICE, ca.OP_ASSIGN):
        factor = {ca.OP_NEG: -1, ca.OP_TWICE: 2}.get(op, 1)
        return _Degree(x.degree, turning, None if x.slope is None else factor * x.slope)
    if op == ca.OP_SQ:
        return _Degree(2 * x.degree, turning, None)
    if op == ca.OP_MUL:
        return _Degree(sum(d.degree for d in degrees), turning, _scaled(operands))
    if op == ca.OP_DIV and degrees[1].degree == 0:
        return _Degree(x.degree, turning, None)
    if op in (ca.OP_SIN, ca.OP_COS) and x.slope is not None and x.slope.denominator == 1:
        return _Degree(abs(int(x.slope)), True, None)
    return None


def _scaled(operands: list[tuple[_Degree, float | None]]) -> Fraction | None:
    """Slope of a product with a number."""
    (x, c), (y, d) = operands
    if c is not None and y.slope is not None:
        return Fraction(c) * y.slope
    return Fraction(d) * x.slope if d is not None and x.slope is not None else None
