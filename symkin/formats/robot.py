"""A robot as a file of another format describes it: joints of any graph, told by their frames on
both links, of which a tree places all links at the file's own configuration; the others close
loops, which may be open.

Every reader makes a `Robot`, and `spanned` (in `spanning`) chooses its tree. What is derived of it
is in the base frame at the file's configuration, so that a link's displacement is the product of
the exponentials of the joints before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.parts import Parts
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.joined import outward
from symkin.model.joint import Joint
from symkin.model.joint_forms import JOINT_FORMS, JointType
from symkin.model.mechanism import MOST_PARTS
from symkin.model.motor import Motor
from symkin.spatial.pose import Pose

MOST_JOINTS = 3 * MOST_PARTS
"""Joints or bodies of a file at most, fixed ones too, which become part of a link: each takes two
milliseconds.
"""
_SQUARE = 1e-6
"""Cosine of the angle between the axes of a universal joint that is taken for zero."""


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
class Mesh:
    """A mesh by its file (the path where it is found, else as it is written), its pose in the frame
    of the link or merged body that it shows, and the scale of its own numbers.
    """

    file: str
    pose: Pose
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class ClosingJoint(LinkJoint):
    """A joint that closes a loop, with its frames on both links: it stands at the first of them,
    and the coordinate of an R, P or H joint is 0 where they coincide.
    """

    frames: tuple[Pose, Pose]
    where: str

    @property
    def gap(self) -> Pose:
        """The displacement from the first frame to the second."""
        return self.frames[1] @ self.frames[0].inverse()


@dataclass(frozen=True)
class Robot:
    """What a file says of a robot, in radians and metres: its `bodies` in order, the `root` among
    them, joints of any graph (`told`), couplings of joints by name, and what was left out of the
    file, a sentence each (`notes`). Bodies that are `floating` hang on no joint: they have poses in
    the root's frame, as the frame has that is called the root's own (`root_frame`). A root without
    a name is one that no body of the file is. `meshes` show bodies, by name. `parts` tells which
    joints are parts of one.

    Of a robot that is `spanned` the joints of the tree come first, each behind the one that carries
    its first body, and the root is "base".
    """

    name: str
    bodies: Sequence[str]
    root: str
    told: Sequence[RobotJoint]
    couplings: Sequence[Coupling] = ()
    notes: tuple[str, ...] = ()
    source: str = ""
    meshes: Mapping[str, tuple[Mesh, ...]] = field(default_factory=dict)
    parts: Parts = field(default_factory=Parts)
    floating: Mapping[str, Pose] = field(default_factory=dict)
    root_frame: Pose = field(default_factory=Pose.identity)

    @cached_property
    def frames(self) -> dict[str, tuple[str, Pose]]:
        """The frame of each body, and the link that it is, or that fixed joints make it part of."""
        own = self.placed | {self.root: self.root_frame}
        return {body: (self.part_of[body], pose) for body, pose in own.items()}

    @property
    def links(self) -> dict[str, Pose]:
        """The links, with their frames."""
        return {body: pose for body, (link, pose) in self.frames.items() if link == body}

    @property
    def joints(self) -> tuple[LinkJoint, ...]:
        """The joints of the tree, then those that close loops."""
        return (*self.tree, *self.closures)

    @cached_property
    def tree(self) -> tuple[LinkJoint, ...]:
        """The joints that place the links; their `zero` is the value at the file's
        configuration. They lead as the file tells them, or the other way about where its parts say
        so.
        """
        found = []
        for joint in self._inside:
            if joint.type == "weld":
                continue
            frame = self.placed[joint.links[0]] @ joint.frames[0]
            axis, axis2 = (
                None if told is None else tuple(frame.turn(np.asarray(told)))
                for told in (joint.axis, joint.axis2)
            )
            value = self.parts.reference.get(joint.name, joint.value)
            zero = value if JOINT_FORMS[joint.type].freedom == 1 else 0.0
            point, own = tuple(frame.position), self._own(joint)
            made = Joint(joint.name, joint.type, point, axis, axis2, zero=zero, **own)
            entry = LinkJoint(made, self._ends(joint))
            found.append(entry.turned() if joint.name in self.parts.turned else entry)
        return tuple(found)

    @cached_property
    def closures(self) -> tuple[ClosingJoint, ...]:
        """The joints that close loops, as the file tells them."""
        return tuple(self._closure(joint) for joint in self.told if joint.closing)

    def _closure(self, joint: RobotJoint) -> ClosingJoint:
        first, second = self.ends_of(joint)
        made = joint_at(first, joint.name, joint.type, **self._own(joint))
        return ClosingJoint(made, self._ends(joint), (first, second), joint.where)

    def ends_of(self, joint: RobotJoint) -> tuple[Pose, Pose]:
        """The frames of a closing joint on both links, z along the axis, and of a universal joint x
        along the second axis.
        """
        if joint.axis and joint.axis2 and abs(np.dot(joint.axis, joint.axis2)) > _SQUARE:
            raise MechanismError(
                f"{joint.where}: the axes of the universal joint are not square to each other, "
                f"and it closes a loop of such joints; "
                "write it as two revolute joints with a link between them"
            )
        ends = zip(joint.links, joint.frames, strict=True)
        first, second = (self.placed[link] @ frame @ joint.turn for link, frame in ends)
        return first, second

    def _own(self, joint: RobotJoint) -> dict[str, Any]:
        """What is told of a joint beside its place."""
        driven = joint.actuated or self.parts.drives(joint.name, joint.type)
        own: dict[str, Any] = {"pitch": joint.pitch, "actuated": driven}
        if JOINT_FORMS[joint.type].freedom == 1:
            own |= {"limits": joint.limits, "motor": joint.motor}
        return own

    def _ends(self, joint: RobotJoint) -> tuple[str, str]:
        """The links that a joint is between."""
        first, second = (self.part_of[body] for body in joint.links)
        return first, second

    @property
    def _inside(self) -> list[RobotJoint]:
        """The joints of the tree, fixed ones too."""
        return [joint for joint in self.told if not joint.closing]

    @cached_property
    def placed(self) -> dict[str, Pose]:
        """All bodies in the base frame, where the file has the joints of the tree, or at the values
        that `parts` tells.
        """
        return place(
            self._inside, {self.root: Pose.identity(), **self.floating}, self.parts.reference
        )

    @cached_property
    def part_of(self) -> dict[str, str]:
        """The link that each body is, or is part of."""
        found = {body: body for body in (self.root, *self.floating)}
        for joint in self._inside:
            near = joint.links[joint.links[0] not in found]
            far = joint.links[joint.links[0] == near]
            found[far] = found[near] if joint.type == "weld" else far
        return found


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

    @property
    def turn(self) -> Pose:
        """From its first frame to one with its axis as z, and its second axis as x."""
        return _STILL if self.axis is None else frame_along(self.axis, self.axis2)


def joint_at(frame: Pose, name: str, kind: JointType, **told: Any) -> Joint:
    """The joint of a closure at its first frame: R, C, P and H have the z axis of both frames in
    common; U turns about the z axis of the first frame and about the x axis of the second, which
    stay square to each other. `told` is what else it holds.
    """
    return Joint(name, kind, tuple(frame.position), **axes_of(kind, frame), **told)


def axes_of(kind: JointType, frame: Pose) -> dict[str, Any]:
    """The axes of a joint of a closure in its frame, those that its type has: z, and x."""
    axes = np.asarray(frame.rotation).T[[2, 0]].tolist()[: JOINT_FORMS[kind].axes]
    return dict(zip(("axis", "axis2"), (*axes, None, None), strict=False))


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


def frame_along(z: Sequence[float], x: Sequence[float] | np.ndarray | None = None) -> Pose:
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
