"""Configurations in the variables of another closure of the same mechanism, which may cut its loops
elsewhere.
"""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.closure.link_poses import LinkPoses, link_poses
from symkin.closure.tilt_torsion import tilt_and_torsion
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.position.canonical import poses_of
from symkin.position.given import poses_coordinates
from symkin.position.readings import readings
from symkin.position.solution import Solution


def variables_elsewhere(closure: Closure, solution: Solution) -> np.ndarray:
    """The full vector of a closure's variables at a solution, its own where the closure is the
    solution's.
    """
    own = build_closure(solution.mechanism, solution.partition)
    return np.asarray(many_elsewhere(closure, own, solution.variables[None])[0])


def many_elsewhere(closure: Closure, own: Closure, values: np.ndarray) -> np.ndarray:
    """Full vectors of a closure's variables (m, variables) at configurations (m, own variables) of
    another one; these themselves where both hold the same.
    """
    if closure.partition == own.partition:
        return values
    found = np.tile(closure.reference, (len(values), 1))
    links = link_poses(own, values)
    read = readings(own, links)
    position, quaternion = poses_of(own, values)
    pose, _ = poses_coordinates(closure.mechanism, position.T, quaternion.T)
    place = 0
    for c in closure.coordinates:
        columns = closure.slices[c.name]
        if c.role == "pose":
            found[:, columns] = pose[:, place : place + c.width]
            place += c.width
        elif c.role == "body":
            found[:, columns] = _of_body(closure, links, c)
        elif c.role == "given":
            found[:, columns.start] = _of_pose(position, quaternion, c.name)
        elif c.role != "geometry":
            found[:, columns] = read[c.name] if c.name in read else values[:, own.slices[c.name]]
    return found


def _of_body(closure: Closure, links: LinkPoses, coordinate: Coordinate) -> np.ndarray:
    """A floating body's coordinate (m, width): of its turn, or of where its middle has gone."""
    body, key = coordinate.name.rsplit(".", 1)
    if key == "quaternion":
        return np.asarray(links[body].quaternion.T)
    middle = np.array([closure.reference[closure.slices[f"{body}.{axis}"]] for axis in "xyz"])
    return np.asarray(links[body].apply(middle)[["xyz".index(key)]].T)


def _of_pose(position: np.ndarray, quaternion: np.ndarray, name: str) -> np.ndarray:
    """One of the coordinates of poses (m,) that are given one by one."""
    place = POSE_CONDITIONS.index(name)
    if place < len("xyz"):
        return np.asarray(position[:, place])
    return np.array([tilt_and_torsion(turn)[place - len("xyz")] for turn in quaternion])
