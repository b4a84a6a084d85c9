"""Closed configurations of a mechanism as its files must have them: displacements of all links and
values of all joints, in metres and radians, rods and carriers of the platform included.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import symkin
from helpers.inside import (
    as_graph,
    build_closure,
    closed_configurations,
    joint_readings,
    link_poses,
)
from symkin import Pose

Moved = tuple[dict[str, Pose], dict[str, float], dict[str, np.ndarray]]
"""Displacements of links by name, values of coordinates, quaternions of spherical joints from their
first link to their second.
"""


def configurations(mechanism: symkin.Mechanism, count: int = 2, seed: int = 5) -> Iterator[Moved]:
    """The reference, and closed configurations from random steps off it where any are found."""
    closure = build_closure(mechanism)
    others = [
        values
        for values in closed_configurations(closure, seed)[:count]
        if not np.array_equal(values, closure.reference)
    ]
    for values in [closure.reference, *others]:
        yield _moved(mechanism, closure, np.array([values]))


def _moved(mechanism: symkin.Mechanism, closure, variables: np.ndarray) -> Moved:
    graph, metres = as_graph(mechanism), 1e-3 if mechanism.length_unit == "mm" else 1.0
    placed = link_poses(closure, variables)
    links = {
        name: Pose(metres * np.asarray(p.position), p.quaternion)
        for name, p in placed.at(0).items()
    }
    lengths = {c.name for c in mechanism.coordinates if c.kind == "length"}
    read = {n: np.asarray(v)[..., 0] for n, v in joint_readings(closure, placed).items()}
    values = {
        n: float(v) * (metres if n in lengths else 1.0) for n, v in read.items() if np.size(v) == 1
    }
    balls = {}
    for rod in graph.link_rods:
        start, end = np.array(rod.start), np.array(rod.end)
        now = np.asarray((links[rod.links[0]].inverse() @ links[rod.links[1]]).apply(end)) - start
        turn = _shortest_turn(end - start, now)
        links |= _of_rod(rod, links[rod.links[0]], start, now, turn)
        back = (
            Pose(np.zeros(3), turn).inverse() @ links[rod.links[0]].inverse() @ links[rod.links[1]]
        ).quaternion
        balls |= {f"{rod.name}.from": turn, f"{rod.name}.to": back}
        values[rod.name] = float(np.linalg.norm(now)) - rod.offset
    for entry in graph.link_joints:
        joint = entry.joint
        if joint.type == "H":
            values[f"{joint.name}.slide"] = (
                joint.pitch / (2.0 * np.pi) * (values[joint.name] - joint.zero)
            )
        if joint.type == "S":
            balls[entry.joint.name] = (
                links[entry.links[0]].inverse() @ links[entry.links[1]]
            ).quaternion
    return links, values | _of_platform(graph, links, values), balls


def _of_rod(
    rod: symkin.LinkRod, carrier: Pose, start: np.ndarray, now: np.ndarray, turn: np.ndarray
) -> dict[str, Pose]:
    """The links of a rod, turned about its start by the shortest way, and slid to its end."""
    turned = Pose(np.zeros(3), turn)
    hung = carrier @ Pose(start - np.asarray(turned.apply(start)), turn)
    if not rod.actuated:
        return {rod.name: hung}
    longer = now * (1.0 - rod.reference_length / np.linalg.norm(now))
    slid = carrier @ Pose(start + longer - np.asarray(turned.apply(start)), turn)
    return {f"{rod.name}.cylinder": hung, f"{rod.name}.piston": slid}


def _of_platform(
    graph: symkin.Mechanism, links: dict[str, Pose], values: dict[str, float]
) -> dict[str, float]:
    """The values of the joints that carry a platform of restricted motion."""
    found = {}
    for entry in graph.link_joints:
        name = entry.joint.name
        if name.startswith("platform.") and name not in values and entry.joint.type != "S":
            pose = links[graph.platform_link]
            at = np.asarray(pose.apply(np.array(graph.platform_position)))
            key = name.removeprefix("platform.")
            found[name] = (
                2.0 * np.arctan2(pose.quaternion[3], pose.quaternion[0])
                if key == "gamma"
                else at["xyz".index(key)]
            )
    return found


def _shortest_turn(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    quaternion = np.concatenate([[1.0 + start @ end], np.cross(start, end)])
    return quaternion / np.linalg.norm(quaternion)
