"""A problem as it is written: known values and geometry as the exact doubles that they are, nothing
rounded or folded.

The algebraic systems that paths are tracked in hold rounded numbers: lengths are divided by the
size, axes are made unit. A theorem on a family of mechanisms speaks of members of that family, so
that its certificates are built from these.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
from flint import arb

from symkin.certificate.disc_arithmetic import TINY, UNIT, UP
from symkin.certificate.discs import DiscFunction, Discs, Knowns
from symkin.closure.rows import RowBuilder
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.six_distances import distance_function, is_universal
from symkin.homotopy.values import coordinate_scale
from symkin.numeric.balls import REAL, BallFunction, Number, precision
from symkin.numeric.tape import build_tape
from symkin.position.problem import Problem

_BITS = 256


def exact_known(problem: Problem, values: np.ndarray) -> tuple[Number, ...]:
    """Known values (length unit, radians) as the algebraic system of the problem takes them, as
    thin balls that hold the exact quotients by the size.
    """
    with precision(_BITS):
        size = arb(problem.closure.characteristic_length)
        distances = _distances(problem)
        if distances is not None:
            joints = [arb(float(v)) for v in values]
            return tuple(
                d / size for d in distances.evaluate(0, joints, distances.prepare(REAL, ()))
            )
        scale = coordinate_scale(problem, problem.known_coordinates)
        return tuple(arb(float(v)) / arb(float(s)) for v, s in zip(values, scale, strict=True))


def knowns_of(problem: Problem, values: np.ndarray) -> Knowns:
    """Known values (m, known) of m instances, length unit and radians, as `exact_known` has
    them.
    """
    return Knowns(_disc_known(problem)(values), lambda j: exact_known(problem, values[j]))


@lru_cache(maxsize=128)
def _disc_known(problem: Problem) -> Callable[[np.ndarray], Discs]:
    """The algebraic system's known values as a function of the problem's."""
    balls, scale = _distances(problem), coordinate_scale(problem, problem.known_coordinates)
    # by 1.0 nothing is divided, nor rounded
    unit = np.where(scale == 1.0, 0.0, UNIT * UP)

    def quotients(values: np.ndarray) -> Discs:
        found = values / scale
        return Discs(found, np.abs(found) * unit + TINY * (unit > 0.0))

    if balls is None:
        return quotients
    size = ca.SX.sym("s")
    function = DiscFunction(build_tape(balls.z, size, balls.f / size, ("value",)))
    prepared = function.prepare(Discs.exact(np.array([[problem.closure.characteristic_length]])))
    return lambda values: function.evaluate(
        0, Discs.exact(values), prepared, np.zeros(len(values), dtype=np.intc)
    )


@lru_cache(maxsize=128)
def _distances(problem: Problem) -> BallFunction | None:
    function = distance_function(problem) if is_universal(problem) else None
    if function is None:
        return None
    joints = ca.SX.sym("q", function.size1_in(0))
    return BallFunction(joints, ca.SX(0, 1), function(joints))


@lru_cache(maxsize=64)
def exact_arm(
    problem: Problem, system: AlgebraicSystem
) -> tuple[AlgebraicSystem, tuple[float, ...]]:
    """The rows of a serial arm's inverse problem, over the same unknowns as `system`, with the
    geometry p behind the pose in the known values; the nominal p. Axes are normalised within the
    rows: for any p the arm is one of the family.
    """
    mechanism, size = problem.mechanism, system.characteristic_length
    tool = mechanism.platform_link or ""
    builder = RowBuilder(
        mechanism, body_forms={tool: "homogeneous"}, eliminate=bool(system.eliminated)
    )
    builder.build_rows()
    z = ca.vertcat(*(builder.coordinates[c.name][1] for c in system.unknowns))
    pose = builder.body_symbols[tool]
    scaled = ca.vertcat(
        z * ca.DM([c.unit(size) for c in system.unknowns]),
        pose * ca.DM([size] * 3 + [1.0] * 4),
    )
    rows = ca.substitute(ca.vertcat(*builder.rows) / size, ca.vertcat(z, pose), scaled)
    known = ca.vertcat(pose, *builder.table.symbols)
    return AlgebraicSystem(size, system.unknowns, z, known, rows, ()), tuple(builder.table.values)
