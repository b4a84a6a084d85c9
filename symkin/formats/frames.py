"""Where links are when joints of a tree are 0, and frames as the formats write them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.formats.robot_joint import frame_along, moved_along
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Joint
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import euler_from_quaternion


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
    angles = [float(v) + 0.0 for v in euler_from_quaternion(pose.quaternion, "xyz")]
    return {"xyz": [float(v) + 0.0 for v in pose.position], "rpy": angles if any(angles) else None}
