"""Joints as a graph: choose the tree that places all links at the file's own configuration; the
other joints close loops.

A reader tells every joint by its frames on both links. The tree takes fixed joints first, then
those that no closure says as well (screws, universal joints, coupled ones), then those with a range
or a motor, then the others in the file's order; joints that the file writes as closures come last,
and join the tree only where nothing else reaches.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.chain import Chain, JointSymbols, steps_of
from symkin.closure.parameters import ParameterTable
from symkin.closure.rows import Cut, rows_of_joint
from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.naming import allowed_names, fresh_name, renamed
from symkin.formats.parts import Parts
from symkin.formats.robot import Mesh, Robot, RobotJoint, joint_at
from symkin.model.graph import Coupling
from symkin.model.joined import Joined
from symkin.model.joint import BASE, Joint
from symkin.model.joint_forms import JOINT_FORMS, JointType
from symkin.model.motor import Motor
from symkin.spatial.pose import Pose
from symkin.text import first_of

Direction = tuple[float, float, float]
AXES: dict[str, Direction] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
Z = AXES["z"]
_COINCIDE = 1e-6
"""Metres and radians: frames that are this near are one to the digits that files hold."""
_NO_DIRECTION = 1e-9
"""Sine of the angle to the z axis below which a vector tells no direction across it."""
_EXCHANGED = {"1": "2", "2": "1"}
"""Coordinates of a universal joint that the mechanism has from its other link."""
_SQUARE = 1e-6
"""Cosine of the angle between the axes of a universal joint that is taken for zero."""


@dataclass(frozen=True)
class GraphJoint:
    """A joint as a file tells it: its frame on each of its two `links` (in the links' own frames),
    `axis` and `axis2` in the first of them. The frames coincide at `value`, at which the file has
    the joint. `closing`: the file writes it as a closure; `where` is its place for messages.
    """

    name: str
    type: JointType
    links: tuple[str, str]
    frames: tuple[Pose, Pose]
    axis: Direction | None = None
    axis2: Direction | None = None
    pitch: float = 0.0
    limits: tuple[float, float] | None = None
    motor: Motor | None = None
    actuated: bool = False
    closing: bool = False
    where: str = ""
    value: float = 0.0


@dataclass(frozen=True)
class JointGraph:
    """What a file says of a robot: its links in order, the `root` among them, joints of any graph,
    couplings of joints by name. Links that are `floating` hang on no joint: they have poses in the
    root's frame, as the frame has that is called the root's own (`root_frame`). A root without a
    name is one that no link of the file is.
    """

    name: str
    links: Sequence[str]
    root: str
    joints: Sequence[GraphJoint]
    couplings: Sequence[Coupling] = ()
    notes: tuple[str, ...] = ()
    source: str = ""
    meshes: Mapping[str, tuple[Mesh, ...]] = field(default_factory=dict)
    parts: Parts = field(default_factory=Parts)
    floating: Mapping[str, Pose] = field(default_factory=dict)
    root_frame: Pose = field(default_factory=Pose.identity)

    @cached_property
    def names(self) -> tuple[Mapping[str, str], Mapping[str, str]]:
        """The names that mechanisms may have for those of links and joints in the file."""
        links = allowed_names((link for link in self.links if link != self.root), taken=[BASE])
        return {self.root: BASE, **links}, allowed_names(joint.name for joint in self.joints)


def robot_of(graph: JointGraph) -> Robot:
    """The robot with its root as "base", placed where the file has the joints of the tree, or at
    the values that `parts` tells; what the root does not reach is left out.
    """
    graph = uniquely_named(graph)
    tree = spanning_tree(graph.joints, graph.couplings, [graph.root, *graph.floating])
    placed = place(tree, graph.root, graph.floating, graph.parts.reference)
    in_tree = {joint.name for joint in tree}
    rest = [
        joint for joint in graph.joints if joint.links[0] in placed and joint.name not in in_tree
    ]
    return _Assembly(graph, placed).robot(rest, _unreached_note(graph, placed))


def spanning_tree(
    joints: Sequence[GraphJoint],
    couplings: Sequence[Coupling] = (),
    together: Collection[str] = (),
) -> list[GraphJoint]:
    """The joints that place every link that they reach, each once (Kruskal's choice in the order of
    preference); links that are `together` are placed already.
    """
    coupled = {name for c in couplings for name in (c.joint, *c.names)}
    coupled |= {name.partition(".")[0] for name in coupled}
    ranked = sorted(joints, key=lambda joint: _preference(joint, joint.name in coupled))
    joined = Joined[str]()
    for first, second in pairwise(together):
        joined.join(first, second)
    return [joint for joint in ranked if joined.join(*joint.links)]


def place(
    tree: Sequence[GraphJoint],
    root: str,
    floating: Mapping[str, Pose] = MappingProxyType({}),
    reference: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, tuple[Pose, GraphJoint | None]]:
    """Every link that the root reaches, in an order from the root: its pose in the root's frame,
    and the joint that carries it. Joints have the values of `reference`, or else of the file.
    """
    at: dict[str, list[GraphJoint]] = {}
    for joint in tree:
        for link in joint.links:
            at.setdefault(link, []).append(joint)
    placed: dict[str, tuple[Pose, GraphJoint | None]] = {root: (Pose.identity(), None)}
    placed |= {link: (pose, None) for link, pose in floating.items()}
    todo = [*placed]
    for link in todo:
        for joint in at.get(link, ()):
            here = joint.links.index(link)
            other = joint.links[1 - here]
            if other not in placed:
                away = reference.get(joint.name, joint.value) - joint.value
                moved = moved_along(joint, away)
                between = moved if here == 0 else moved.inverse()
                pose = (
                    placed[link][0]
                    @ joint.frames[here]
                    @ between
                    @ joint.frames[1 - here].inverse()
                )
                placed[other] = (Pose(np.asarray(pose.position), _unit(pose.quaternion)), joint)
                todo.append(other)
    return placed


def moved_along(joint: GraphJoint | Joint, value: float) -> Pose:
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


class _Assembly:
    """The robot's parts in the base frame, under names that mechanisms may have."""

    def __init__(
        self, graph: JointGraph, placed: Mapping[str, tuple[Pose, GraphJoint | None]]
    ) -> None:
        self.graph, self.placed = graph, placed
        self.part_of: dict[str, str] = {}
        self.carried: list[GraphJoint] = []
        for link, (_, joint) in placed.items():
            self.part_of[link] = link
            if joint is not None:
                carrier = self.part_of[joint.links[joint.links[0] == link]]
                if joint.type == "weld":
                    self.part_of[link] = carrier
                else:
                    self.carried.append(joint)
        self.link_names, self.joint_names = graph.names

    def robot(self, rest: Sequence[GraphJoint], notes: Sequence[str]) -> Robot:
        closures, dropped = self._closures(rest)
        kept = {joint.name for joint in self.carried}
        named = {*kept, *(joint.name for joint in rest)}
        joints = {old: new for old, new in self.joint_names.items() if old in named}
        parts = [link for link in self.placed if self.part_of[link] == link]
        root = (
            ()
            if self.graph.root in ("", BASE)
            else (f"the root link {self.graph.root!r} is held, as the link {BASE!r}",)
        )
        below = {link: self.link_names[link] for link in self.placed if link != self.graph.root}
        return Robot(
            name=self.graph.name,
            links={self.link_names[link]: self.placed[link][0] for link in parts}
            | {BASE: self.graph.root_frame},
            joints=(*(self._tree_joint(joint) for joint in self.carried), *closures),
            couplings=tuple(
                c.renamed({name: self._coordinate(name) for name in (c.joint, *c.names)})
                for c in self.graph.couplings
                if self._is_kept(c, kept)
            ),
            notes=(
                *root,
                *renamed("links", below),
                *renamed("joints", joints),
                *self.graph.notes,
                *notes,
                *dropped,
                *self._lost_couplings(kept),
            ),
            source=self.graph.source,
            meshes=self._meshes(),
            floating=tuple(self.link_names[link] for link in self.graph.floating),
            parts=self.graph.parts,
            merged={
                self.link_names[link]: (self.link_names[self.part_of[link]], self.placed[link][0])
                for link in self.placed
                if self.part_of[link] != link
            },
        )

    def _tree_joint(self, joint: GraphJoint) -> RobotJoint:
        """The joint in the base frame, as the file tells it, or the other way about where the
        file's parts say so.
        """
        frame = self.placed[joint.links[0]][0] @ joint.frames[0]
        axis, axis2 = (
            None if a is None else _numbers(frame.turn(np.asarray(a)))
            for a in (joint.axis, joint.axis2)
        )
        value = self.graph.parts.reference.get(joint.name, joint.value)
        zero = value if JOINT_FORMS[joint.type].freedom == 1 else 0.0
        name, point = self.joint_names[joint.name], _numbers(frame.position)
        made = Joint(name, joint.type, point, axis, axis2, zero=zero, **self._told(joint))
        links = self._links(joint)
        is_turned = joint.name in self.graph.parts.turned
        return RobotJoint(made.turned(), links[::-1]) if is_turned else RobotJoint(made, links)

    def _links(self, joint: GraphJoint) -> tuple[str, str]:
        """The links of the mechanism that a joint is between."""
        first, second = (self.link_names[self.part_of[link]] for link in joint.links)
        return first, second

    def _told(self, joint: GraphJoint) -> dict[str, Any]:
        """What is told of a joint beside its place."""
        driven = joint.actuated or self.graph.parts.drives(joint.name, joint.type)
        told: dict[str, Any] = {"pitch": joint.pitch, "actuated": driven}
        if JOINT_FORMS[joint.type].freedom == 1:
            told |= {"limits": joint.limits, "motor": joint.motor}
        return told

    def _closures(self, rest: Sequence[GraphJoint]) -> tuple[list[RobotJoint], list[str]]:
        """The joints that close loops, their frames with z along the axis, and of a universal joint
        x along the second axis; and notes on those that are left out.
        """
        found, notes = [], []
        for joint in rest:
            if (
                joint.axis is not None
                and joint.axis2 is not None
                and abs(np.dot(joint.axis, joint.axis2)) > _SQUARE
            ):
                raise MechanismError(
                    f"{joint.where}: the axes of the universal joint are not square to each other, "
                    f"and it closes a loop of such joints; "
                    "write it as two revolute joints with a link between them"
                )
            turn = Pose.identity() if joint.axis is None else frame_along(joint.axis, joint.axis2)
            first, second = (
                self.placed[link][0] @ frame @ turn
                for link, frame in zip(joint.links, joint.frames, strict=True)
            )
            made = joint_at(first, self.joint_names[joint.name], joint.type, **self._told(joint))
            links = self._links(joint)
            if links[0] == links[1]:
                notes.append(_within_a_link(made, links[0], second @ first.inverse(), joint.where))
            else:
                found.append(RobotJoint(made, links, (first, second), joint.where))
        return found, notes

    def _coordinate(self, name: str) -> str:
        """The name of a coordinate under its joint's new name."""
        if name in self.joint_names:
            return self.joint_names[name]
        stem, dot, ending = name.rpartition(".")
        if stem in self.graph.parts.turned:
            ending = _EXCHANGED.get(ending, ending)
        return f"{self.joint_names[stem]}{dot}{ending}"

    def _is_kept(self, coupling: Coupling, kept: set[str]) -> bool:
        return all(
            name in kept or name.rpartition(".")[0] in kept
            for name in (coupling.joint, *coupling.names)
        )

    def _lost_couplings(self, kept: set[str]) -> list[str]:
        return [
            f"the coupling of {coupling.joint!r} is left out: not all of its joints move links of "
            f"the robot"
            for coupling in self.graph.couplings
            if not self._is_kept(coupling, kept)
        ]

    def _meshes(self) -> dict[str, tuple[Mesh, ...]]:
        return {
            self.link_names[link]: meshes
            for link, meshes in self.graph.meshes.items()
            if meshes and link in self.placed
        }


def _preference(joint: GraphJoint, coupled: bool) -> int:
    if joint.closing:
        return 4
    if joint.type == "weld":
        return 0
    if coupled or joint.type in ("H", "U"):
        return 1
    return 2 if joint.limits is not None or joint.actuated else 3


def uniquely_named(graph: JointGraph) -> JointGraph:
    """The graph with a number behind the name of a closing joint that another joint has. Raises
    MechanismError for others.
    """
    used = {joint.name for joint in graph.joints if not joint.closing}
    joints, seen = [], set()
    for joint in graph.joints:
        name = joint.name
        if not joint.closing and name in seen:
            raise MechanismError(
                f"{joint.where}: two joints are named {name!r}; names must be unique in the file"
            )
        if joint.closing:
            name = fresh_name(name, used)
        seen.add(name)
        joints.append(joint if name == joint.name else replace(joint, name=name))
    return replace(graph, joints=joints)


def _unreached_note(graph: JointGraph, reached: Collection[str]) -> list[str]:
    lost = [link for link in graph.links if link not in reached]
    return [f"nothing joins to the robot, and left out: {first_of(lost)}"] if lost else []


def _within_a_link(joint: Joint, link: str, gap: Pose, where: str) -> str:
    """A note on a closure between two parts of one link, which moves nothing. Raises MechanismError
    where it cannot close.
    """
    cut = Cut.of(JointSymbols.declare(joint, joint.name, ParameterTable(bound=True)))
    found = rows_of_joint(cut, Chain(()), Chain(steps_of(gap)), ca.SX(1))
    errors = ca.vertcat(*(error for _, _, own in found for error in own))
    open_by = float(ca.norm_2(ca.evalf(errors)))
    if open_by > _COINCIDE:
        raise MechanismError(
            f"{where}: it closes a loop within the one link {link!r}, whose two frames are "
            f"{open_by:.3g} apart (m, rad); no configuration closes it"
        )
    return f"the closure {joint.name!r} is within the one link {link!r}, closed, and left out"


def _unit(quaternion: np.ndarray) -> np.ndarray:
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def _numbers(vector: np.ndarray) -> list[float]:
    return [float(component) for component in np.asarray(vector)]
