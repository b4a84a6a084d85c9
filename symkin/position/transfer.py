"""Configurations in the variables of another closure of the same mechanism, which may cut its loops
elsewhere or declare no motion, or of the machine that it means.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.closure.link_poses import joint_expressions, link_expressions
from symkin.closure.tilt_torsion import tilt_and_torsion_of
from symkin.computed_once import lru_cache
from symkin.machine.frame import Frames
from symkin.machine.lower import Lowered
from symkin.model.joint import POSE_CONDITIONS, Coordinate
from symkin.numeric.mapped import Mapped
from symkin.position.pose_coordinates import motion_coordinates
from symkin.position.readings import Writing
from symkin.position.solution import Solution
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import normalized


def variables_elsewhere(closure: Closure, solution: Solution) -> np.ndarray:
    """The full vector of a closure's variables at a solution, its own where the closure is the
    solution's.
    """
    return many_elsewhere(closure, own_closure(solution), solution.variables[None])[0]


def own_closure(solution: Solution) -> Closure:
    """The closure whose variables a solution has."""
    return build_closure(solution.mechanism, solution.partition)


def many_elsewhere(closure: Closure, own: Closure, values: np.ndarray) -> np.ndarray:
    """Full vectors of a closure's variables (m, variables) at configurations (m, own variables) of
    another one, those that this one leaves out in their standard writing; these themselves where
    both hold the same.
    """
    if (closure.mechanism, closure.partition) == (own.mechanism, own.partition):
        return values
    return in_standard_writing(closure, own, _transfer(closure, own)(values)[0][:, :, 0])


def many_as_written(
    closure: Closure, own: Closure, values: np.ndarray, lowered: Lowered
) -> np.ndarray:
    """Full vectors of the variables of a closure of the description (m, variables) at
    configurations (m, own variables) of its machine, as these are written there.
    """
    return _transfer(closure, own, lowered)(values)[0][:, :, 0]


def many_of_machine(
    closure: Closure, own: Closure, values: np.ndarray, lowered: Lowered | None
) -> np.ndarray:
    """Full vectors of the variables of a closure of the machine (m, variables) at configurations
    (m, own variables) of its description, which may be the machine itself.
    """
    if lowered is None or lowered.is_written:
        return many_elsewhere(closure, own, values)
    found = _transfer(closure, own, lowered, to_machine=True)(values)[0][:, :, 0]
    return in_standard_writing(closure, own, found)


def in_standard_writing(closure: Closure, own: Closure, values: np.ndarray) -> np.ndarray:
    """A closure's variables (m, variables), those that `own` leaves out in their standard
    writing.
    """
    held = {c.name for c in own.coordinates}
    read = [c for c in closure.coordinates if c.role == "pose" or c.name not in held]
    return Writing.of(read, closure.slices).standard(values)


@lru_cache(maxsize=64)
def _transfer(
    closure: Closure, own: Closure, lowered: Lowered | None = None, *, to_machine: bool = False
) -> Mapped:
    """The variables of a closure over those of another one."""
    read = {c.name: own.variables[own.slices[c.name]] for c in own.coordinates}
    pose = Pose(*(own.bound(part) for part in (own.pose.position, own.pose.quaternion)))
    pose = Pose(pose.position, normalized(pose.quaternion))
    links: dict[str, Pose] = {}
    if _needs_links(closure, own, lowered):
        links = link_expressions(own)
        told = joint_expressions(own, links)
        read |= {name: value for name, value in told.items() if name not in read}
    described = pose
    if lowered is not None and not to_machine:
        pose, links, read = _as_described(lowered, pose, links, read)
        described = pose
    elif lowered is not None:
        pose, links, read = _as_machine(lowered, pose, links, read)
    numbers = iter(
        ca.vertsplit(motion_coordinates(closure.mechanism, pose.position, pose.quaternion))
    )
    found = [
        ca.vertcat(*islice(numbers, c.width))
        if c.role == "pose"
        else _value(closure, c, described, links, read)
        for c in closure.coordinates
    ]
    return Mapped.of([own.variables], [ca.vertcat(*found)])


def _as_described(
    lowered: Lowered, pose: Pose, links: Mapping[str, Pose], read: Mapping[str, ca.SX]
) -> tuple[Pose, dict[str, Pose], dict[str, ca.SX]]:
    """The platform, links and joints of a machine as those of the description."""
    links, read = dict(links), dict(read)
    for reading in lowered.readings:
        read |= reading.values(read[reading.of]) if reading.of in read else {}
    if lowered.frames is not None:
        base, platform = map(_constant, (lowered.frames.base, lowered.frames.platform))
        links = {link: Frames(base, base).told(at) for link, at in links.items()}
        pose = Frames(base, platform).told(pose)
    moved = pose @ _constant(lowered.written.reference_pose.inverse())
    for guide in lowered.guides:
        read |= guide.readings(moved)
    called = {name: links[own] for name, own in lowered.links.items() if own in links}
    return pose, links | called, read


def _as_machine(
    lowered: Lowered, pose: Pose, links: Mapping[str, Pose], read: Mapping[str, ca.SX]
) -> tuple[Pose, dict[str, Pose], dict[str, ca.SX]]:
    """The platform, links and joints of a description as those of its machine."""
    links, read = dict(links), dict(read)
    for reading in lowered.readings:
        read |= {reading.of: reading.value(read)} if {*reading.names} <= {*read} else {}
    links |= {own: links[name] for name, own in lowered.links.items() if name in links}
    if lowered.frames is not None:
        base, platform = map(_constant, (lowered.frames.base, lowered.frames.platform))
        links = {link: Frames(base, base).taken(at) for link, at in links.items()}
        pose = Frames(base, platform).taken(pose)
    return pose, links, read


def _constant(pose: Pose) -> Pose:
    """A pose among expressions."""
    return Pose(ca.SX(ca.DM(pose.position)), ca.SX(ca.DM(pose.quaternion)))


def _needs_links(closure: Closure, own: Closure, lowered: Lowered | None) -> bool:
    """Whether a closure holds coordinates that another one leaves out, or bodies."""
    held = {c.name for c in own.coordinates}
    for reading in () if lowered is None else lowered.readings:
        one, several = {reading.of}, {*reading.names}
        held |= (several if one <= held else set()) | (one if several <= held else set())
    if lowered is not None:
        held |= {joint.name for guide in lowered.guides for joint in guide.joints}
    return any(
        c.role == "body" or (c.role not in ("pose", "condition", "geometry") and c.name not in held)
        for c in closure.coordinates
    )


def _value(
    closure: Closure,
    c: Coordinate,
    pose: Pose,
    links: Mapping[str, Pose],
    read: Mapping[str, ca.SX],
) -> ca.SX:
    """A coordinate of a closure, but of the pose as a whole, where its links, its joints and its
    platform are.
    """
    if c.role == "body":
        return _of_body(closure, links, c)
    if c.role == "condition":
        return _of_pose(pose, c.name)
    return ca.SX(ca.DM(c.reference)) if c.role == "geometry" else read[c.name]


def _of_body(closure: Closure, links: Mapping[str, Pose], coordinate: Coordinate) -> ca.SX:
    """A floating body's coordinate: of its turn, or of where its middle has gone."""
    body, key = coordinate.name.rsplit(".", 1)
    if key == "quaternion":
        return links[body].quaternion
    middle = np.array([closure.reference[closure.slices[f"{body}.{axis}"]] for axis in "xyz"])
    return links[body].apply(ca.DM(middle))["xyz".index(key)]


def _of_pose(pose: Pose, name: str) -> ca.SX:
    """One of the coordinates of a pose that are given one by one."""
    place = POSE_CONDITIONS.index(name)
    if place < len("xyz"):
        return pose.position[place]
    return tilt_and_torsion_of(pose.quaternion)[place - len("xyz")]
