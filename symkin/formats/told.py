"""What is told beside a robot's file takes the place of what the file says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions, closure_kind
from symkin.formats.robot import AXES, Robot, RobotJoint, axes_of, frame_along
from symkin.model.joint import BASE
from symkin.model.joint_forms import JointType
from symkin.text import first_of, meant, shown

_DRIVEN = ("R", "P", "H", "C", "U")
"""Joints that may be actuated."""


def as_told(robot: Robot, read: ReadOptions) -> Robot:
    """The robot with the closures' kinds, actuated joints and platform that are told. Raises
    InputError for unknown names.
    """
    if read.loop:
        robot = _with_kinds(robot, read.loop)
    if read.platform is not None:
        robot = _with_platform(robot, read.platform)
    return _with_motors(robot, read.actuated) if read.actuated else robot


def _with_kinds(robot: Robot, told: Mapping[str, str]) -> Robot:
    names = [joint.name for joint in robot.told if joint.closing]
    for name in told:
        if name in names:
            continue
        if any(joint.name == name for joint in robot.told):
            raise InputError(
                f"loop: {name!r} is a joint of the tree and closes no loop; closures: "
                f"{first_of(names) or 'none'}"
            )
        raise InputError(
            f"loop: no closure is named {shown(name)}{meant(name, names)}; closures: "
            f"{first_of(names, 20) or 'none'}"
        )
    joints = [
        _of_kind(j, *closure_kind(j.name, told[j.name])) if j.name in told else j
        for j in robot.told
    ]
    notes = (
        f"the closure {joint.name!r} is of type {joint.type}, as told"
        for joint in joints
        if joint.name in told
    )
    return replace(robot, told=joints, notes=(*robot.notes, *notes))


def _of_kind(joint: RobotJoint, kind: JointType, axis: str) -> RobotJoint:
    """The closure as one of another kind, about or along an axis of its frames; ranges and motors
    were those of the other kind.
    """
    turn = joint.turn
    if kind != joint.type:
        joint = replace(joint, pitch=0.0, limits=None, actuated=False, motor=None)
    return replace(joint, type=kind, **axes_of(kind, turn @ frame_along(AXES[axis])))


def _with_platform(robot: Robot, name: str) -> Robot:
    """The robot whose platform frame is that of a link, or of a body that is part of one."""
    frames = robot.frames
    moved = [body for body, (link, _) in frames.items() if link != BASE]
    if name not in moved:
        if name in frames or any(
            note.startswith(f"the root link {name!r} ") for note in robot.notes
        ):
            raise InputError(
                f"platform: {name!r} is part of the base, which is held; links that move: "
                f"{first_of(moved, 20)}"
            )
        raise InputError(
            f"platform: no link is named {shown(name)}{meant(name, moved)}; links that move: "
            f"{first_of(moved, 20)}"
        )
    return replace(robot, parts=replace(robot.parts, platform=frames[name]))


def _with_motors(robot: Robot, names: Sequence[str]) -> Robot:
    kinds = {entry.joint.name: entry.joint.type for entry in robot.joints}
    able = [name for name, kind in kinds.items() if kind in _DRIVEN]
    for name in names:
        if name not in kinds:
            raise InputError(
                f"actuated: no joint is named {shown(name)}{meant(name, able)}; joints that may "
                f"be: {first_of(able, 20)}"
            )
        if name not in able:
            raise InputError(
                f"actuated: {name!r} is of type {kinds[name]}, which no one motor drives; joints "
                f"that may be: {first_of(able, 20)}"
            )
        if names.count(name) > 1:
            raise InputError(f"actuated: {name!r} is given twice")
    return replace(
        robot,
        told=[replace(joint, actuated=joint.name in names) for joint in robot.told],
        parts=replace(robot.parts, actuated=None),
    )
