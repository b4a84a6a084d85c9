"""One configuration in the variables of another closure of the same mechanism, which may cut its loops elsewhere."""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.tilt_torsion import tilt_and_torsion
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.position.given import pose_coordinates
from symkin.position.solution import Solution


def variables_at(closure: Closure, solution: Solution) -> np.ndarray:
    """The full vector of a closure's variables at a solution, its own where the closure is the solution's."""
    return solution.variables if solution.partition == closure.partition else variables_elsewhere(closure, solution)


def variables_elsewhere(closure: Closure, solution: Solution) -> np.ndarray:
    """The full vector of a closure's variables at a solution."""
    values = closure.reference.copy()
    read = solution.all_values
    pose, _ = pose_coordinates(solution.mechanism, solution.pose)
    place = 0
    for c in closure.coordinates:
        if c.role == "pose":
            values[closure.slices[c.name]] = pose[place : place + c.width]
            place += c.width
        elif c.role == "body":
            values[closure.slices[c.name]] = _of_body(closure, solution, c)
        elif c.role == "given":
            values[closure.slices[c.name]] = _of_pose(solution, c.name)
        elif c.role != "geometry":
            values[closure.slices[c.name]] = read[c.name]
    return values


def _of_body(closure: Closure, solution: Solution, coordinate: Coordinate) -> np.ndarray:
    """A floating body's coordinate: of its turn, or of where its middle has gone."""
    body, key = coordinate.name.rsplit(".", 1)
    displacement = solution.link_poses[body]
    if key == "quaternion":
        return np.asarray(displacement.quaternion)
    middle = np.array([closure.reference[closure.slices[f"{body}.{axis}"]][0] for axis in "xyz"])
    return np.asarray(displacement.apply(middle))["xyz".index(key)]  # type: ignore[no-any-return]


def _of_pose(solution: Solution, name: str) -> float:
    """One of the pose's coordinates that are given one by one."""
    numbers = (*solution.position.tolist(), *tilt_and_torsion(solution.quaternion))
    return float(numbers[POSE_CONDITIONS.index(name)])
