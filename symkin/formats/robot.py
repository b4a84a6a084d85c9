"""A robot as a file of another format describes it: a tree of joints at the file's own
configuration, and closures that may be open.

Every reader makes a `Robot`. Points and axes are in the base frame at the file's configuration (all
of it placed by the tree's joints), so that a link's displacement is the product of the exponentials
of the joints before it. A closure holds two frames, one on each of its links, which coincide as its
type says where the loop is closed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symkin.errors import MechanismError
from symkin.formats.parts import Parts
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.joint import Joint
from symkin.model.joint_forms import JointType
from symkin.model.mechanism import MOST_PARTS
from symkin.spatial.pose import Pose

MOST_JOINTS = 3 * MOST_PARTS
"""Joints or bodies of a file at most, fixed ones too, which become part of a link: each takes two
milliseconds.
"""


def refuse_too_many(where: str, joints: int, movable: int) -> None:
    """Raise MechanismError for a robot of more joints than a mechanism may have, before they are
    placed; `joints` counts fixed ones too.
    """
    if movable > MOST_PARTS or joints > MOST_JOINTS:
        told = f"{joints} joints or bodies" + (
            f", {movable} joints of which move" if movable > MOST_PARTS else ""
        )
        raise MechanismError(f"{where}: {told}; allowed: {MOST_JOINTS}, of which {MOST_PARTS} move")


@dataclass(frozen=True)
class RobotJoint(LinkJoint):
    """A joint of the tree; its `zero` is the value at the file's configuration. Or one between
    links that the tree joins in another way, with its `frames` on both, in the base frame at the
    file's configuration: it stands at the first of them, and the coordinate of an R, P or H joint
    is 0 where they coincide. `where` names element and line of the file.
    """

    frames: tuple[Pose, Pose] | None = None
    where: str = ""


def joint_at(frame: Pose, name: str, kind: JointType, **told: Any) -> Joint:
    """The joint of a closure at its first frame: R, C, P and H have the z axis of both frames in
    common; U turns about the z axis of the first frame and about the x axis of the second, which
    stay square to each other. `told` is what else it holds.
    """
    axes = np.asarray(frame.rotation)
    axis = None if kind in ("S", "weld") else tuple(axes[:, 2])
    axis2 = tuple(axes[:, 0]) if kind == "U" else None
    return Joint(name, kind, tuple(frame.position), axis, axis2, **told)


@dataclass(frozen=True)
class Mesh:
    """A mesh by its file (the path where it is found, else as it is written), its pose in the frame
    of the link or merged body that it shows, and the scale of its own numbers.
    """

    file: str
    pose: Pose
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Robot:
    """Links by name with their frames at the file's configuration, joints in radians and
    metres, those of the tree, each behind the one that carries its first link, before those that
    close loops, couplings of joints, and what was left out of the file, a sentence each (`notes`).
    The root link is "base". Links that are `floating` hang on no joint, only on closures. Bodies
    that fixed joints make part of a link are `merged`: by their name in the file, the link and
    their frame. `meshes` show links and merged bodies, by name. `parts` tells which joints are
    parts of one.
    """

    name: str
    links: Mapping[str, Pose]
    joints: tuple[RobotJoint, ...]
    couplings: tuple[Coupling, ...] = ()
    notes: tuple[str, ...] = ()
    source: str = ""
    meshes: Mapping[str, tuple[Mesh, ...]] = field(default_factory=dict)
    floating: tuple[str, ...] = ()
    merged: Mapping[str, tuple[str, Pose]] = field(default_factory=dict)
    parts: Parts = field(default_factory=Parts)

    @property
    def tree(self) -> tuple[RobotJoint, ...]:
        """The joints that place the links."""
        return tuple(joint for joint in self.joints if joint.frames is None)

    @property
    def closures(self) -> tuple[RobotJoint, ...]:
        """The joints that close loops."""
        return tuple(joint for joint in self.joints if joint.frames is not None)
