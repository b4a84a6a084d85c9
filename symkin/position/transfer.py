"""Configurations in the variables of another closure of the same mechanism, which may cut its loops
elsewhere, or of the machine that it means.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.closure.link_poses import LinkPoses, link_poses
from symkin.closure.tilt_torsion import tilt_and_torsion
from symkin.machine.lower import Lowered
from symkin.machine.motion import Frames
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.position.canonical import poses_of
from symkin.position.given import poses_coordinates
from symkin.position.readings import readings
from symkin.position.solution import Solution
from symkin.spatial.pose import Pose


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
    position, quaternion = poses_of(own, values)
    links = link_poses(own, values) if _needs_links(closure, own) else LinkPoses({}, values)
    return _filled(closure, links, _read(own, links, values), (position.T, quaternion.T))


def many_as_written(
    closure: Closure, own: Closure, values: np.ndarray, lowered: Lowered
) -> np.ndarray:
    """Full vectors of the variables of a closure of the description (m, variables) at
    configurations (m, own variables) of its machine.
    """
    guided = [joint.name for guide in lowered.guides for joint in guide.joints]
    needed = _needs_links(
        closure, own, {n: r.of for r in lowered.readings for n in r.names}, guided
    )
    links = link_poses(own, values) if needed else LinkPoses({}, values)
    read = _read(own, links, values)
    for reading in lowered.readings:
        read |= reading.values(read[reading.of]) if reading.of in read else {}
    pose = Pose(*(part.T for part in poses_of(own, values)))
    if lowered.frames is not None:
        base, platform = map(_of_many, (lowered.frames.base, lowered.frames.platform))
        told = Frames(base, base)
        links = LinkPoses({link: told.told(at) for link, at in links.poses.items()}, values)
        pose = Frames(base, platform).told(pose)
    moved = pose @ _of_many(lowered.written.reference_pose.inverse())
    for guide in lowered.guides:
        read |= guide.readings(moved)
    poses = {name: links[own] for name, own in lowered.links.items() if own in links.poses}
    links = LinkPoses(links.poses | poses, values)
    return _filled(closure, links, read, (pose.position, pose.quaternion))


def _of_many(pose: Pose) -> Pose:
    """A pose as that of any number of configurations."""
    return Pose(pose.position[:, None], pose.quaternion[:, None])


def _needs_links(
    closure: Closure,
    own: Closure,
    names: Mapping[str, str] | None = None,
    told: Collection[str] = (),
) -> bool:
    """Whether a closure holds coordinates that another one leaves out (`names`: what some are
    called there; not those that are `told` otherwise), or bodies.
    """
    held = {c.name for c in own.coordinates} | set(told)
    return any(
        c.role == "body"
        or (
            c.role not in ("pose", "given", "geometry")
            and (names or {}).get(c.name, c.name) not in held
        )
        for c in closure.coordinates
    )


def _read(own: Closure, links: LinkPoses, values: np.ndarray) -> dict[str, np.ndarray]:
    """Values (m, width) of the coordinates that a closure holds, and where its links are told also
    of those that it leaves out.
    """
    held = {c.name: values[:, own.slices[c.name]] for c in own.coordinates}
    return held | (readings(own, links) if links.poses else {})


def _filled(
    closure: Closure,
    links: LinkPoses,
    read: Mapping[str, np.ndarray],
    pose: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Full vectors of a closure's variables (m, variables) where its links, its joints and its
    platform, of `pose` (3, m) and (4, m), are.
    """
    position, quaternion = pose
    found = np.tile(closure.reference, (position.shape[1], 1))
    numbers, _ = poses_coordinates(closure.mechanism, position, quaternion)
    place = 0
    for c in closure.coordinates:
        columns = closure.slices[c.name]
        if c.role == "pose":
            found[:, columns] = numbers[:, place : place + c.width]
            place += c.width
        elif c.role == "body":
            found[:, columns] = _of_body(closure, links, c)
        elif c.role == "given":
            found[:, columns.start] = _of_pose(position.T, quaternion.T, c.name)
        elif c.role != "geometry":
            found[:, columns] = read[c.name]
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
