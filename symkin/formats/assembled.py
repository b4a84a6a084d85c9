"""Make a mechanism of a robot at a closed configuration: every joint of the tree and every closure
becomes a joint between two links.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from symkin.closure.link_poses import joint_coordinates
from symkin.errors import MechanismError
from symkin.formats.closing import Closed, nearest_closed
from symkin.formats.robot import ClosingJoint, Robot
from symkin.formats.whole_joints import whole_again
from symkin.model.graph import LinkJoint
from symkin.model.joint import Joint
from symkin.model.mechanism import Mechanism
from symkin.model.mesh import LinkMesh
from symkin.model.names import identifier
from symkin.spatial.pose import Pose
from symkin.text import printable


def mechanism_of(robot: Robot) -> Mechanism:
    """Close a robot's loops and make the mechanism. Raises MechanismError where no configuration
    closes them.
    """
    return assembled(robot, require_closed(robot))


def require_closed(robot: Robot) -> Closed:
    """The closed configuration nearest to the file's own. Raises MechanismError, with the loop that
    resists, where there is none.
    """
    closed = nearest_closed(robot)
    if not closed.to_digits:
        raise MechanismError(f"{robot.source or robot.name}: {open_sentence(closed)}")
    return closed


def open_sentence(closed: Closed) -> str:
    """What is said of loops that no configuration found closes."""
    return (
        f"no configuration was found that closes the loops: the best one leaves "
        f"{closed.residual:.3g} m, most of it in the loop of "
        f"{_with_place(closed)}; check its frames and the types of the joints along it"
    )


def _with_place(closed: Closed) -> str:
    """The closure that resists, with its place in the file."""
    where = next(
        (c.where for c in closed.tree.robot.closures if c.joint.name == closed.resists and c.where),
        "",
    )
    return f"{closed.resists} ({where})" if where else closed.resists


def assembled(robot: Robot, closed: Closed) -> Mechanism:
    """The graph of links at a closed configuration, which is its reference; joints of one
    coordinate keep their values, those of two count from there, also in couplings.
    """
    if not robot.joints:
        raise MechanismError(
            f"{robot.source or robot.name}: no joint moves; a mechanism needs one at least"
        )
    joints = (LinkJoint(_moved(entry, closed), entry.links) for entry in robot.joints)
    several = [entry.joint for entry in robot.tree if entry.joint.type in ("C", "U")]
    away = {c.name: closed.values[c.name][0] for joint in several for c in joint.coordinates}
    found = Mechanism(
        identifier(robot.name),
        link_joints=[
            joint.turned()
            if isinstance(entry, ClosingJoint) and entry.joint.name in robot.parts.turned
            else joint
            for entry, joint in zip(robot.joints, joints, strict=True)
        ],
        couplings=[coupling.counted_from(away) for coupling in robot.couplings],
        length_unit="m",
        angle_unit="rad",
        source=printable(robot.source),
        link_meshes=list(_link_meshes(robot, closed)),
    )
    return whole_again(found, robot.parts.moved(closed.displacements))


def _link_meshes(robot: Robot, closed: Closed) -> Iterator[LinkMesh]:
    """The meshes of links, and of bodies that are part of them, where the links are."""
    for name, meshes in robot.meshes.items():
        link, frame = robot.frames[name]
        for mesh in meshes:
            pose = closed.displacements[link] @ frame @ mesh.pose
            yield LinkMesh(
                link, mesh.file, tuple(pose.position), tuple(pose.quaternion), mesh.scale
            )


def _moved(entry: LinkJoint, closed: Closed) -> Joint:
    """A joint where its links are, a closure half of what is left open away from its first frame;
    `zero` is its value there, for joints of one coordinate.
    """
    joint = entry.joint
    first, second = (closed.displacements[link] for link in entry.links)
    point = first.apply(np.array(joint.point))
    if isinstance(entry, ClosingJoint):
        second = second @ entry.gap
        point = 0.5 * (point + second.apply(np.array(joint.point)))
    changes: dict[str, Any] = {"point": tuple(point)}
    for key, pose in (("axis", first), ("axis2", second)):
        own = getattr(joint, key)
        changes[key] = None if own is None else tuple(pose.turn(np.array(own)))
    if joint.freedom == 1:
        changes["zero"] = (
            _reading(replace(joint, zero=0.0), first.inverse() @ second)
            if isinstance(entry, ClosingJoint)
            else closed.values[joint.name][0]
        )
    return replace(joint, **changes)


def _reading(joint: Joint, between: Pose) -> float:
    """The coordinate of a joint where its second link is displaced in its first."""
    columns = Pose(*(np.asarray(part)[:, None] for part in (between.position, between.quaternion)))
    (value,) = joint_coordinates(joint, columns)
    return float(value[0])
