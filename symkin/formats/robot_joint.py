"""A joint as a file of another format tells it, by its frames on both links, and where joints place
links.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from symkin.model.joined import outward
from symkin.model.joint import Joint
from symkin.model.joint_forms import JOINT_FORMS, JointType
from symkin.model.motor import Motor
from symkin.spatial.pose import Pose

Direction = tuple[float, float, float]
AXES: dict[str, Direction] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
Z = AXES["z"]
_NO_DIRECTION = 1e-9
"""Sine of the angle to the z axis below which a vector tells no direction across it."""


_STILL = Pose.identity()


@dataclass(frozen=True)
class RobotJoint:
    """A joint as a file tells it: its frame on each of its two `links` (in the links' own frames),
    `axis` and `axis2` in the first of them. The frames coincide at `value`, at which the file has
    the joint; of one that closes a loop (`closing`) as its type says. `where` is its place in the
    file, for messages.
    """

    name: str
    type: JointType
    links: tuple[str, str]
    frames: tuple[Pose, Pose] = (_STILL, _STILL)
    axis: Direction | None = None
    axis2: Direction | None = None
    pitch: float = 0.0
    limits: tuple[float, float] | None = None
    motor: Motor | None = None
    actuated: bool = False
    closing: bool = False
    where: str = ""
    value: float = 0.0


def joint_at(frame: Pose, name: str, kind: JointType, **told: Any) -> Joint:
    """The joint of a closure at its first frame: R, C, P and H have the z axis of both frames in
    common; U turns about the z axis of the first frame and about the x axis of the second, which
    stay square to each other. `told` is what else it holds.
    """
    axes = np.asarray(frame.rotation)
    axis = None if kind in ("S", "weld") else tuple(axes[:, 2])
    axis2 = tuple(axes[:, 0]) if kind == "U" else None
    return Joint(name, kind, tuple(frame.position), axis, axis2, **told)


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
