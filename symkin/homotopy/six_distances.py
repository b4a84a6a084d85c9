"""Platforms held by six distances, or by more of them: one algebraic system for all of them.

In Study coordinates x = (e, g) the closure is e.g = 0 and six quadratic forms |2 g + e m - b e|^2 -
L^2 |e|^2 = 0 (Husty 1996). Of more than six distances six are chosen, whose solutions are then
compared with the others.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from symkin.closure.numpy_code import vectorise
from symkin.closure.pose_forms import StudyPose
from symkin.closure.rows import RowBuilder
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.rank import independent_rows
from symkin.position.closed_configurations import closed_configurations
from symkin.position.problem import Problem
from symkin.position.solution import pose_of
from symkin.spatial.rotation import matrix_from_quaternion

DISTANCES = 6
"""Distances that hold a platform of six freedoms."""
_EQUAL = 1e-7
"""Difference of squared lengths, in units of the size, of a root that has a distance, whose
rounding is far smaller.
"""


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
def all_distances(problem: Problem) -> ca.Function | None:
    """Length, base point and platform point of each distance (7 numbers, length unit) as a function
    of the known joints; None where the direct problem is another one.
    """
    mechanism, joints = problem.mechanism, problem.known_coordinates
    if not problem.of_joints or mechanism.motion != "spatial":
        return None
    form = {mechanism.platform_link or "": "study"}
    builder = RowBuilder(mechanism, bound=True, body_forms=form)  # type: ignore[arg-type]
    builder.build_rows()
    of_joints_alone = len(builder.coordinates) == len(joints)
    if not of_joints_alone or not DISTANCES <= len(builder.distances) == len(builder.rows):
        return None
    symbols = ca.vertcat(*(builder.coordinates[c.name][1] for c in joints))
    return ca.Function("distances", [symbols], [ca.densify(ca.vertcat(*builder.distances))])


@lru_cache(maxsize=128)
def chosen_distances(problem: Problem) -> tuple[int, ...]:
    """Six of a problem's distances, those that hold the platform best at the first closed
    configuration, in order: the wrenches (d; m x d / size) of their lines are taken one by one,
    each time the one farthest from those before.
    """
    function = all_distances(problem)
    count = 0 if function is None else function.numel_out(0) // 7
    if function is None or count == DISTANCES:
        return tuple(range(count))
    values = closed_configurations(problem.closure, 0)[0]
    pose = pose_of(problem.closure, values)
    numbers = np.asarray(
        function(problem.select_values(values, problem.known_coordinates))
    ).reshape(count, 7)
    arms = numbers[:, 4:] @ np.asarray(matrix_from_quaternion(pose.quaternion)).T
    lines = arms + np.asarray(pose.position) - numbers[:, 1:4]
    lines = lines / np.linalg.norm(lines, axis=1, keepdims=True)
    wrenches = np.hstack([lines, np.cross(arms, lines) / problem.closure.characteristic_length])
    # six of them, however near to others' span
    return tuple(sorted(independent_rows(wrenches, -np.inf, most=DISTANCES)))


@lru_cache(maxsize=128)
def distance_function(problem: Problem) -> ca.Function | None:
    """The chosen six of `all_distances` (42 numbers)."""
    function = all_distances(problem)
    if function is None or function.numel_out(0) == 7 * DISTANCES:
        return function
    joints = ca.SX.sym("q", function.size1_in(0))
    rows = [7 * i + j for i in chosen_distances(problem) for j in range(7)]
    return ca.Function("distances", [joints], [function(joints)[rows]])


def redundant_distances(problem: Problem) -> int:
    """How many distances a problem has beyond six; 0 also where it is another problem."""
    function = all_distances(problem)
    return 0 if function is None else function.numel_out(0) // 7 - DISTANCES


def meet_all_distances(problem: Problem, z: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Which roots z (8, n) of the chosen six distances have all of them at these known joints."""
    function = all_distances(problem)
    if function is None or function.numel_out(0) == 7 * DISTANCES:
        return np.ones(z.shape[1], dtype=bool)
    numbers = np.asarray(function(known)).reshape(-1, 7) / problem.closure.characteristic_length
    system = universal_system()
    fine = np.ones(z.shape[1], dtype=bool)
    ray = z / np.linalg.norm(z[:4], axis=0)
    for i in range(len(numbers) - DISTANCES + 1):
        k = np.repeat(numbers[i : i + DISTANCES].reshape(-1, 1), z.shape[1], axis=1)
        fine &= (
            np.max(np.abs(system.linearise(ray, k.astype(complex))[0]), axis=1, initial=0.0)
            < _EQUAL
        )
    return fine


@lru_cache(maxsize=128)
def distance_data(problem: Problem) -> Callable[[np.ndarray], np.ndarray] | None:
    """Length, base point and platform point of each distance (42 numbers, in units of the size)
    from known joints (known,) or (known, n), real or complex.
    """
    function = distance_function(problem)
    if function is None:
        return None
    code, size = vectorise(function), problem.closure.characteristic_length

    def data(joints: np.ndarray) -> np.ndarray:
        columns = np.asarray(joints, dtype=complex).reshape(len(joints), -1)
        numbers = np.zeros((columns.shape[1], 7 * DISTANCES, 1), dtype=complex)
        code(columns, numbers)
        return numbers[:, :, 0].T.reshape(7 * DISTANCES, *joints.shape[1:]) / size

    return data


@lru_cache(maxsize=128)
def is_universal(problem: Problem) -> bool:
    """Whether straight lines in the joints are straight lines in the distances' data, so that paths
    of `universal_system` stay within the mechanism: lengths and slides move, turning joints do not.
    """
    function = distance_function(problem)
    if function is None:
        return False
    joints = ca.SX.sym("q", function.numel_in(0))
    return not any(ca.which_depends(function(joints), joints, 2, False))
