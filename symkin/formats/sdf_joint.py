"""What a joint of SDF tells of itself: its type, its axes, its range and its pitch, by the version
of the file.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from symkin.formats.robot import Direction
from symkin.formats.urdf_parts import unit
from symkin.formats.xml_text import Element, is_true
from symkin.model.joint_forms import JointType
from symkin.model.motor import Motor, motor_of
from symkin.spatial.pose import Pose
from symkin.text import not_among

TYPES: dict[str, JointType] = {
    "revolute": "R",
    "continuous": "R",
    "prismatic": "P",
    "screw": "H",
    "universal": "U",
    "ball": "S",
    "fixed": "weld",
}
"""Joints of SDF that are one joint here; a revolute2 is two, a gearbox a coupling."""
_ONE_AXIS = 1e-6
"""Radians between directions that are one."""
UNLIMITED = 1e15
"""Bounds beyond this are none: SDF writes 1e16, infinity and the largest number of doubles."""


def sdf_type(element: Element, allowed: Collection[str] = tuple(TYPES)) -> JointType:
    """The joint's type. Raises MechanismError for one that is not among the allowed."""
    word = element.attribute("type")
    if word not in allowed:
        raise element.error(f"type = {not_among(word, allowed)}")
    return TYPES[word]


def sdf_axis(
    element: Element, tag: str, joint_pose: Pose, version: tuple[int, int] = (1, 6)
) -> Direction:
    """The child <axis> or <axis2> in the joint's frame, which has the pose `joint_pose` in the
    model's frame.

    Before version 1.5 an axis is in the model's frame; from then on in the joint's, unless
    use_parent_model_frame is true.
    """
    axis = element.needed(tag)
    xyz = axis.needed("xyz")
    if version < (1, 5) or _model_frame(axis) is not None:
        return unit_from(xyz, joint_pose.inverse())
    return unit(xyz, xyz.text_numbers(3))


def unit_from(xyz: Element, frame: Pose) -> Direction:
    """The direction that an element tells in a frame, in what the frame is told in."""
    return unit(xyz, tuple(map(float, frame.turn(np.asarray(xyz.text_numbers(3))))))


def refuse_model_frame(axis: Element, vector: tuple[float, ...], joint_pose: Pose) -> None:
    """Raise MechanismError where an axis of version 1.7 or later would be another one by
    use_parent_model_frame of versions before.
    """
    flag = _model_frame(axis)
    away = joint_pose.inverse().turn(np.asarray(vector)) - vector
    if flag is not None and np.linalg.norm(away) > _ONE_AXIS * np.linalg.norm(vector):
        raise flag.error(
            "is of versions before 1.7, and would turn the axis; write <xyz "
            'expressed_in="__model__">'
        )


def _model_frame(axis: Element) -> Element | None:
    """The element use_parent_model_frame where it is true."""
    flag = axis.one("use_parent_model_frame")
    return flag if flag is not None and is_true(flag.text) else None


def sdf_limits(element: Element, tag: str = "axis") -> tuple[float, float] | None:
    """The bounds in <axis><limit>, not always a range; None where there are none, or both are
    infinite.
    """
    low, high = _limit(element, tag, lower=-math.inf, upper=math.inf)
    return None if low <= -UNLIMITED and high >= UNLIMITED else (low, high)


def sdf_motor(element: Element) -> Motor | None:
    """What <axis><limit> tells of the motor."""
    effort, speed = _limit(element, "axis", effort=0.0, velocity=0.0)
    return motor_of((-effort, effort), speed)


def _limit(element: Element, tag: str, **defaults: float) -> list[float]:
    """Numbers in the <limit> of an axis."""
    axis = element.one(tag)
    limit = None if axis is None else axis.one("limit")
    if limit is None:
        return [*defaults.values()]
    return [limit.child_number(word, v, infinite=True) for word, v in defaults.items()]


def sdf_pitch(element: Element) -> float:
    """The length a turn of a screw, right-handed: screw_thread_pitch, or -2 pi / thread_pitch
    (radians a metre, left-handed).
    """
    new, old = element.one("screw_thread_pitch"), element.one("thread_pitch")
    told = new or old
    if told is None:
        raise element.error("<screw_thread_pitch> is missing; a screw needs its length a turn")
    value = told.text_number()
    if value == 0.0:
        raise told.error("is 0; a screw advances when it turns")
    return value if told is new else -2.0 * math.pi / value
