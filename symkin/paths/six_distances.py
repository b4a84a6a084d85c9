"""Platforms held by six distances: one algebraic system for all of them.

In Study coordinates x = (e, g) the closure is e.g = 0 and six quadratic forms |2 g + e m - b e|^2 - L^2 |e|^2 = 0
(Husty 1996).
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from symkin.caching import lru_cache
from symkin.model.closure import build_algebraic_closure
from symkin.model.platform import StudyPose
from symkin.paths.algebraic import AlgebraicSystem
from symkin.paths.walk import vectorise
from symkin.position.problem import Problem

DISTANCES = 6
"""Distances that hold a platform of six freedoms."""


@lru_cache(maxsize=1)
def universal_system() -> AlgebraicSystem:
    """Rows over z = (e, g) and k = (L, b, m) of each distance, all lengths in one unit."""
    e, g, k = ca.SX.sym("e", 4), ca.SX.sym("g", 4), ca.SX.sym("k", 42)
    pose = StudyPose(e, g)
    rows = [ca.dot(e, g)]
    for i in range(6):
        length, b, m = k[7 * i], k[7 * i + 1 : 7 * i + 4], k[7 * i + 4 : 7 * i + 7]
        rows.append((pose.squared_distance(m, b) - pose.weight * length**2) / 2)
    return AlgebraicSystem(1.0, (), ca.vertcat(e, g), k, ca.vertcat(*rows), tuple(range(8)))


@lru_cache(maxsize=128)
def distance_function(problem: Problem) -> ca.Function | None:
    """Length, base point and platform point of each distance (42 numbers, length unit) as a function of the known
    joints; None where the direct problem is another one."""
    if problem.kind != "direct" or problem.mechanism.motion != "spatial":
        return None
    algebraic = build_algebraic_closure(problem.mechanism, "study")
    if algebraic.distances is None or algebraic.rows.shape[0] != DISTANCES:
        return None
    return ca.Function("distances", [algebraic.joints], [ca.densify(algebraic.distances)])


@lru_cache(maxsize=128)
def distance_data(problem: Problem) -> Callable[[np.ndarray], np.ndarray] | None:
    """Length, base point and platform point of each distance (42 numbers, in units of the size) from known joints, real
    or complex."""
    function = distance_function(problem)
    if function is None:
        return None
    code, size = vectorise(function), problem.closure.size

    def data(joints: np.ndarray) -> np.ndarray:
        numbers = np.zeros((1, 7 * DISTANCES, 1), dtype=complex)
        code(np.asarray(joints, dtype=complex)[:, None], numbers)
        return np.asarray(numbers[0, :, 0] / size)

    return data


@lru_cache(maxsize=128)
def is_universal(problem: Problem) -> bool:
    """Whether straight lines in the joints are straight lines in the distances' data, so that paths of
    `universal_system` stay within the mechanism: lengths and slides move, turning joints do not."""
    function = distance_function(problem)
    if function is None:
        return False
    joints = ca.SX.sym("q", function.numel_in(0))
    return not any(ca.which_depends(function(joints), joints, 2, False))
