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
from functools import partial
from math import prod

import casadi as ca
import numpy as np

from symkin.certificate.certificate import CertificateBatch
from symkin.certificate.discs import DiscFunction, Knowns
from symkin.certificate.exact import exact_arm
from symkin.certificate.triangular import root_counts
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import universal_system
from symkin.homotopy.six_revolute import is_six_revolute
from symkin.homotopy.structure import Structure
from symkin.numeric.tape import build_tape
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

PLACED_BODY = Theorem(
    1,
    "pose of a body whose rows are linear in its rotation and then in its position",
    "linear algebra",
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
    return _of_placed_body(system) if system.projective else _of_triangular_rows(system)


def _of_placed_body(system: AlgebraicSystem) -> Bound | None:
    """The bound on the poses of a body that known joints carry: three rows are linear in its
    rotation e, the others in its position g. Where a root is regular, the three leave e on one ray
    and the others one g, whatever else they are.
    """
    ray = list(system.projective)
    e, g = system.z[ray[:4]], system.z[ray[4:]]
    if system.unknowns or system.count != system.width - 1:
        return None
    of_turn = [not held for held in ca.which_depends(system.rows, g, 1, True)]
    curved = [ca.which_depends(system.rows, part, 2, True) for part in (e, g)]
    at_zero = ca.substitute(system.rows, e, ca.SX.zeros(4))
    is_linear = all(
        not by_e and at_zero[k].is_zero() if turn else not by_g
        for k, (turn, by_e, by_g) in enumerate(zip(of_turn, *curved, strict=True))
    )
    return Bound(PLACED_BODY, system) if is_linear and sum(of_turn) == 3 else None


def _of_triangular_rows(system: AlgebraicSystem) -> Bound | None:
    """The bound on the roots of rows that hold one unknown more each than those before."""
    counts = root_counts(system)
    if counts is None:
        return None
    rods = {c.name for c in system.unknowns if c.least is not None}
    squares = " in the square of the length" * bool(rods)
    degrees = {name: count * (1 + (name in rods)) for name, count in counts.items()}
    names, numbers = ", ".join(degrees), ", ".join(map(str, degrees.values()))
    alike = len(set(degrees.values())) == 1
    of_degree = f"of degree {next(iter(degrees.values()))}" if alike else f"of degrees {numbers}"
    text = (
        f"{names} alone, by a polynomial {of_degree}{squares}"
        if len(degrees) == 1
        else f"{names} one after another, by polynomials {of_degree}{squares}"
    )
    theorem = Theorem(prod(counts.values()), text, "fundamental theorem of algebra")
    return Bound(theorem, system)


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
    every = np.bincount(found.instance, minlength=n) == count
    if found.system is not bound.system or not every.any():
        return np.zeros(n, dtype=bool)
    whole = found.certified & found.pose & (found.proved_real | found.proved_unreal)
    sure = np.bincount(found.instance[whole], minlength=n)
    return every & (sure == count) & (found.distinct == count)
