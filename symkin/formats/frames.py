"""Frames as the formats tell and write them, and where links are by the joints of a tree."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from symkin.model.graph import LinkJoint
from symkin.model.joined import outward
from symkin.model.joint import BASE, Joint
from symkin.model.joint_forms import JOINT_FORMS
from symkin.spatial.pose import Pose

if TYPE_CHECKING:
    from symkin.formats.robot import RobotJoint

_NO_DIRECTION = 1e-9
"""Sine of the angle to the z axis below which a vector tells no direction across it."""


def place(
    tree: Iterable[RobotJoint],
    roots: Mapping[str, Pose],
    values: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, Pose]:
    """Every link that the roots reach, in an order from them: its pose in the frame in which the
    roots have theirs. Joints have these `values`, or else those of the file.
    """
    placed = dict(roots)
    for joint, forward in outward(tree, [*roots]):
        here, other = joint.links if forward else joint.links[::-1]
        moved = moved_along(joint, values.get(joint.name, joint.value) - joint.value)
        near, far = joint.frames if forward else joint.frames[::-1]
        pose = placed[here] @ near @ (moved if forward else moved.inverse()) @ far.inverse()
        turn = pose.quaternion / np.linalg.norm(pose.quaternion)
        placed[other] = Pose(np.asarray(pose.position), np.asarray(turn))
    return placed


def moved_along(joint: RobotJoint | Joint, value: float) -> Pose:
    """How far a joint of one coordinate moves its second frame in its first, by a value."""
    if not value or joint.axis is None or JOINT_FORMS[joint.type].freedom != 1:
        return Pose.identity()
    along = value if joint.type == "P" else value * joint.pitch / (2.0 * math.pi)
    turn = np.zeros(3) if joint.type == "P" else value * np.array(joint.axis)
    return Pose.from_rotation_vector(along * np.array(joint.axis), turn)


def frame_along(z: Sequence[float], x: Sequence[float] | None = None) -> Pose:
    """A turned frame whose z axis has a direction, and whose x axis is nearest to another where one
    is given.
    """
    third = np.asarray(z, dtype=float) / np.linalg.norm(z)
    near = np.eye(3)[int(np.argmin(np.abs(third)))]
    if third[2] == 1.0:
        near = np.array([1.0, 0.0, 0.0])
    if x is not None and np.linalg.norm(np.cross(third, x)) > _NO_DIRECTION:
        near = np.asarray(x, dtype=float)
    first = near - third * (near @ third)
    first = first / np.linalg.norm(first)
    return Pose.from_matrix(np.column_stack([first, np.cross(third, first), third]), np.zeros(3))


def displacement(joint: Joint, value: float) -> Pose:
    """How far a joint of one coordinate moves its second link from the reference to a value."""
    frame = Pose(np.array(joint.point), Pose.identity().quaternion)
    return frame @ moved_along(joint, value - joint.zero) @ frame.inverse()


def zero_displacements(joints: Sequence[LinkJoint]) -> dict[str, Pose]:
    """The displacements of all links of a tree from the reference to the configuration where its
    joints are 0.
    """
    found = {BASE: Pose.identity()}
    for entry in joints:
        carrier, link = entry.links
        moved = found[carrier]
        found[link] = moved @ displacement(entry.joint, 0.0) if entry.joint.zero else moved
    return found


def closing_frames(joint: Joint) -> tuple[Pose, Pose]:
    """The frames of a closing joint on its two links, in the base frame at the reference: z along
    its axis, which coincide at 0.
    """
    turn = Pose.identity() if joint.axis is None else frame_along(joint.axis)
    frame = Pose(np.array(joint.point), turn.quaternion)
    return frame, displacement(joint, 2.0 * joint.zero) @ frame if joint.zero else frame


def xyz_rpy(pose: Pose) -> dict[str, list[float] | None]:
    """The attributes of an origin; angles about the fixed axes x, y, z, and none where it is not
    turned.
    """
    angles = roll_pitch_yaw(pose.rotation)
    return {"xyz": [float(v) + 0.0 for v in pose.position], "rpy": angles if any(angles) else None}


def roll_pitch_yaw(rotation: np.ndarray) -> list[float]:
    """Angles about the fixed axes x, y, z; near a pitch of a right angle too, roll and yaw together
    are right to rounding.
    """
    r: Mapping[tuple[int, int], float] = {
        (i, j): float(rotation[i][j]) for i in range(3) for j in range(3)
    }
    yaw = math.atan2(r[1, 0], r[0, 0])
    pitch = math.atan2(-r[2, 0], math.hypot(r[0, 0], r[1, 0]))
    sine, cosine = math.sin(yaw), math.cos(yaw)
    roll = math.atan2(sine * r[0, 2] - cosine * r[1, 2], cosine * r[1, 1] - sine * r[0, 1])
    return [roll + 0.0, pitch + 0.0, yaw + 0.0]
