"""Where links are when joints of a tree are 0, and frames as the formats write them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from symkin.formats.robot_joint import frame_along, moved_along
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Joint
from symkin.spatial.pose import Pose


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
