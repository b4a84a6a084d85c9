"""Make a mechanism of a robot at a closed configuration: every joint of the tree and every closure
becomes a joint between two links.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.closing import Closed, nearest_closed
from symkin.formats.parts import turned
from symkin.formats.robot import Closure, Robot
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
        (c.where for c in closed.tree.robot.closures if c.name == closed.resists and c.where), ""
    )
    return f"{closed.resists} ({where})" if where else closed.resists


def assembled(robot: Robot, closed: Closed) -> Mechanism:
    """The graph of links at a closed configuration, which is its reference; joints of one
    coordinate keep their values from there.
    """
    joints = [_moved_joint(entry, closed) for entry in robot.joints]
    joints += [_closing_joint(closure, closed) for closure in robot.closures]
    joints = [
        (turned(joint), links[::-1]) if joint.name in robot.turned else (joint, links)
        for joint, links in joints
    ]
    if not joints:
        raise MechanismError(
            f"{robot.source or robot.name}: no joint moves; a mechanism needs one at least"
        )
    found = Mechanism(
        identifier(robot.name),
        link_joints=[LinkJoint(joint, links) for joint, links in joints],
        couplings=robot.couplings,
        length_unit="m",
        angle_unit="rad",
        source=printable(robot.source),
        link_meshes=list(_link_meshes(robot, closed)),
    )
    return whole_again(found, robot.parts.moved(closed.displacements))


def _link_meshes(robot: Robot, closed: Closed) -> Iterator[LinkMesh]:
    """The meshes of links, and of bodies that are part of them, where the links are."""
    for name, meshes in robot.meshes.items():
        link, frame = robot.merged[name] if name in robot.merged else (name, robot.links[name])
        for mesh in meshes:
            pose = closed.placed.displacement(link) @ frame @ mesh.pose
            yield LinkMesh(
                link, mesh.file, tuple(pose.position), tuple(pose.quaternion), mesh.scale
            )


def _moved_joint(entry: LinkJoint, closed: Closed) -> tuple[Joint, Sequence[str]]:
    """A joint of the tree where its links are; `zero` is its value there, for joints of one
    coordinate.
    """
    joint, (carrier, link), placed = entry.joint, entry.links, closed.placed
    changes: dict[str, Any] = {"point": tuple(placed.point(carrier, np.array(joint.point)))}
    if joint.axis is not None:
        changes["axis"] = tuple(placed.rotations[carrier] @ np.array(joint.axis))
    if joint.axis2 is not None:
        changes["axis2"] = tuple(placed.rotations[link] @ np.array(joint.axis2))
    if joint.type in ("R", "P", "H"):
        changes["zero"] = closed.values[joint.coordinates[0].name][0]
    return replace(joint, **changes), entry.links


def _closing_joint(closure: Closure, closed: Closed) -> tuple[Joint, Sequence[str]]:
    """A closure as a joint at its first frame, half of what is left open away from it."""
    first, second = (
        closed.placed.displacement(link) @ frame
        for link, frame in zip(closure.links, (closure.first, closure.second), strict=True)
    )
    axis, axis2 = None, None
    if closure.type not in ("S", "weld"):
        axis = tuple(first.rotation[:, 2])
    if closure.type == "U":
        axis2 = tuple(second.rotation[:, 0])
    point = tuple(0.5 * (np.asarray(first.position) + np.asarray(second.position)))
    joint = Joint(
        closure.name,
        closure.type,
        point,
        axis,
        axis2,
        pitch=closure.pitch,
        actuated=closure.actuated,
    )
    if closure.type in ("R", "P", "H"):
        joint = replace(
            joint,
            zero=_closing_value(closure, first, second),
            limits=closure.limits,
            motor=closure.motor,
        )
    return joint, closure.links


def _closing_value(closure: Closure, first: Pose, second: Pose) -> float:
    """How far the second frame is turned about, or slid along, the first one's z axis."""
    between = first.inverse() @ second
    slide, turn = float(between.position[2]), between.rotation
    if closure.type == "P":
        return slide
    return (
        slide * 2.0 * np.pi / closure.pitch
        if closure.type == "H"
        else float(np.arctan2(turn[1, 0], turn[0, 0]))
    )
