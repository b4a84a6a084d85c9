"""A problem as it is written: known values and geometry as the exact doubles that they are, nothing rounded or folded.

The algebraic systems that paths are tracked in hold rounded numbers: lengths are divided by the size, axes are made unit.
A theorem on a family of mechanisms speaks of members of that family, so that its certificates are built from these.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from flint import arb

from symkin.caching import lru_cache
from symkin.certificate.discs import DiscFunction, Discs
from symkin.certificate.knowns import Knowns
from symkin.certificate.tape import build_tape
from symkin.closure.rows import RowBuilder
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import distance_function, is_universal
from symkin.homotopy.values import coordinate_scale
from symkin.numeric.balls import REAL, BallFunction, Number, precision
from symkin.position.problem import Problem

_BITS = 256


def exact_known(problem: Problem, values: np.ndarray) -> tuple[Number, ...]:
    """Known values (length unit, radians) as the algebraic system of the problem takes them, as thin balls that hold the
    exact quotients by the size."""
    with precision(_BITS):
        size = arb(problem.closure.size)
        distances = _distances(problem)
        if distances is not None:
            joints = [arb(float(v)) for v in values]
            return tuple(d / size for d in distances.evaluate(0, joints, distances.prepare(REAL, ())))
        scale = coordinate_scale(problem, problem.known_coordinates)
        return tuple(arb(float(v)) / arb(float(s)) for v, s in zip(values, scale, strict=True))


def knowns_of(problem: Problem, values: np.ndarray) -> Knowns:
    """Known values (m, known) of m instances, length unit and radians, as `exact_known` has them."""
    size, function = problem.closure.size, _disc_distances(problem)
    if function is not None:
        joints = Discs.exact(np.asarray(values, dtype=float))
        numbers = function.evaluate(0, joints, function.prepare(joints), np.arange(len(values)))
        discs = numbers.divided(np.full(numbers.middle.shape[1], size))
    else:
        scale = coordinate_scale(problem, problem.known_coordinates)
        discs = Discs.exact(np.asarray(values, dtype=float)).divided(scale)
    return Knowns(discs, lambda j: exact_known(problem, values[j]))


@lru_cache(maxsize=128)
def _disc_distances(problem: Problem) -> DiscFunction | None:
    balls = _distances(problem)
    return None if balls is None else DiscFunction(build_tape(balls.z, balls.k, balls.f, ("value",)))


@lru_cache(maxsize=128)
def _distances(problem: Problem) -> BallFunction | None:
    function = distance_function(problem) if is_universal(problem) else None
    if function is None:
        return None
    joints = ca.SX.sym("q", function.size1_in(0))
    return BallFunction(joints, ca.SX(0, 1), function(joints))


@lru_cache(maxsize=64)
def exact_arm(problem: Problem, system: AlgebraicSystem) -> tuple[AlgebraicSystem, tuple[float, ...]]:
    """The rows of a serial arm's inverse problem, over the same unknowns as `system`, with the geometry p behind the pose in
    the known values; the nominal p. Axes are normalised within the rows: for any p the arm is one of the family."""
    mechanism, size = problem.mechanism, system.size
    builder = RowBuilder(mechanism, "homogeneous", eliminate=bool(system.eliminated), bound=False)
    builder.build_rows()
    z = ca.vertcat(*(builder.coordinates[c.name][1] for c in system.unknowns))
    pose = builder.pose_symbols
    scaled = ca.vertcat(z * ca.DM([1.0 if c.is_angular else size for c in system.unknowns]), pose * ca.DM([size] * 3 + [1.0] * 4))
    rows = ca.substitute(ca.vertcat(*builder.rows) / size, ca.vertcat(z, pose), scaled)
    known = ca.vertcat(pose, *builder.table.symbols)
    return AlgebraicSystem(size, system.unknowns, z, known, rows, ()), tuple(builder.table.values)
