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

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.naming import allowed_names, renamed
from symkin.formats.parts import Parts, turned
from symkin.formats.robot import Closure, ClosureType, Mesh, Robot
from symkin.model.graph import Coupling, LinkJoint
from symkin.model.joined import Joined
from symkin.model.joint import BASE, Joint
from symkin.model.joint_forms import JOINT_FORMS, JointType
from symkin.model.motor import Motor
from symkin.spatial.pose import Pose
from symkin.text import first_of

Direction = tuple[float, float, float]
Z: Direction = (0.0, 0.0, 1.0)
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
    `axis` and `axis2` in the first of them. The frames coincide at the value 0. `closing`: the file
    writes it as a closure; `where` is its place for messages.
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


@dataclass(frozen=True)
class JointGraph:
    """What a file says of a robot: its links in order, the `root` among them, joints of any graph,
    couplings of joints by name.
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


def robot_of(graph: JointGraph) -> Robot:
    """The robot with its root as "base", placed where all joints of the tree are 0, or at the
    values that `parts` tells; what the root does not reach is left out.
    """
    graph = _uniquely_named(graph)
    tree = spanning_tree(graph)
    placed, in_tree = place(graph, tree), {joint.name for joint in tree}
    rest = [
        joint for joint in graph.joints if joint.links[0] in placed and joint.name not in in_tree
    ]
    return _Assembly(graph, placed).robot(rest, _unreached_note(graph, placed))


def spanning_tree(graph: JointGraph) -> list[GraphJoint]:
    """The joints that place every link that the root reaches, each once (Kruskal's choice in the
    order of preference).
    """
    coupled = {name.partition(".")[0] for c in graph.couplings for name in (c.joint, *c.names)}
    coupled |= {name for c in graph.couplings for name in (c.joint, *c.names)}
    ranked = sorted(graph.joints, key=lambda joint: _preference(joint, joint.name in coupled))
    joined = Joined[str]()
    return [joint for joint in ranked if joined.join(*joint.links)]


def place(
    graph: JointGraph, tree: Sequence[GraphJoint]
) -> dict[str, tuple[Pose, GraphJoint | None]]:
    """Every link that the root reaches, in an order from the root: its pose in the root's frame,
    and the joint that carries it.
    """
    at: dict[str, list[GraphJoint]] = {link: [] for link in graph.links}
    for joint in tree:
        for link in joint.links:
            at[link].append(joint)
    placed: dict[str, tuple[Pose, GraphJoint | None]] = {graph.root: (Pose.identity(), None)}
    todo = [graph.root]
    for link in todo:
        for joint in at[link]:
            here = joint.links.index(link)
            other = joint.links[1 - here]
            if other not in placed:
                moved = _moved(joint, graph.parts.reference.get(joint.name, 0.0))
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


def _moved(joint: GraphJoint, value: float) -> Pose:
    """How far a joint of one coordinate moves its second frame in its first, from 0 to a value."""
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
        self.carried: list[tuple[str, str, GraphJoint]] = []
        for link, (_, joint) in placed.items():
            carrier = (
                None
                if joint is None
                else self.part_of[next(other for other in joint.links if other != link)]
            )
            if joint is None or carrier is None or joint.type != "weld":
                self.part_of[link] = link
            else:
                self.part_of[link] = carrier
            if joint is not None and carrier is not None and joint.type != "weld":
                self.carried.append((carrier, link, joint))
        names = allowed_names((link for link in placed if link != graph.root), taken=[BASE])
        self.link_names = {graph.root: BASE, **names}
        self.joint_names = allowed_names(joint.name for joint in graph.joints)

    def robot(self, rest: Sequence[GraphJoint], notes: Sequence[str]) -> Robot:
        closures, dropped = self._closures(rest)
        kept = {joint.name for _, _, joint in self.carried}
        parts = [link for link in self.placed if self.part_of[link] == link]
        root = (
            ()
            if self.graph.root == BASE
            else (f"the root link {self.graph.root!r} is held, as the link {BASE!r}",)
        )
        below = {old: new for old, new in self.link_names.items() if old != self.graph.root}
        return Robot(
            name=self.graph.name,
            links={self.link_names[link]: self.placed[link][0] for link in parts},
            joints=tuple(self._link_joint(*entry) for entry in self.carried),
            closures=tuple(closures),
            couplings=tuple(
                self._coupling(c) for c in self.graph.couplings if self._is_kept(c, kept)
            ),
            notes=(
                *root,
                *renamed("links", below),
                *renamed("joints", self.joint_names),
                *self.graph.notes,
                *notes,
                *dropped,
                *self._lost_couplings(kept),
            ),
            source=self.graph.source,
            meshes=self._meshes(),
            parts=self.graph.parts,
            turned=frozenset(self.joint_names[name] for name in self._turned),
            merged={
                self.link_names[link]: (self.link_names[self.part_of[link]], self.placed[link][0])
                for link in self.placed
                if self.part_of[link] != link
            },
        )

    @cached_property
    def _turned(self) -> set[str]:
        """Joints that the mechanism has from the link that the tree carries, by their names in the
        file: a joint leads as the file tells it, or the other way about where the file's parts say
        so.
        """
        backward = {joint.name for _, link, joint in self.carried if joint.links[0] == link}
        return backward ^ (set(self.graph.parts.turned) & self.joint_names.keys())

    def _link_joint(self, carrier: str, link: str, joint: GraphJoint) -> LinkJoint:
        """The joint in the base frame, from the link nearer to the root; turned about where the
        file tells it from the other.
        """
        backward = joint.links[0] == link
        frame = self.placed[joint.links[0]][0] @ joint.frames[0]
        axis = None if joint.axis is None else np.asarray(frame.turn(np.asarray(joint.axis)))
        axis2 = None if joint.axis2 is None else np.asarray(frame.turn(np.asarray(joint.axis2)))
        made = Joint(
            self.joint_names[joint.name],
            joint.type,
            point=_numbers(frame.position),
            axis=None if axis is None else _numbers(axis),
            axis2=None if axis2 is None else _numbers(axis2),
            pitch=joint.pitch,
            actuated=joint.actuated or self.graph.parts.drives(joint.name, joint.type),
            zero=self.graph.parts.reference.get(joint.name, 0.0)
            if JOINT_FORMS[joint.type].freedom == 1
            else 0.0,
            limits=joint.limits if JOINT_FORMS[joint.type].freedom == 1 else None,
            motor=joint.motor if JOINT_FORMS[joint.type].freedom == 1 else None,
        )
        return LinkJoint(
            turned(made) if backward else made, (self.link_names[carrier], self.link_names[link])
        )

    def _closures(self, rest: Sequence[GraphJoint]) -> tuple[list[Closure], list[str]]:
        """The closures, and notes on what of them is left out."""
        found, notes = [], []
        for joint in rest:
            closure = self._closure(joint)
            if closure.links[0] == closure.links[1]:
                notes.append(_within_a_link(closure))
                continue
            found.append(closure)
        return found, notes

    def _closure(self, joint: GraphJoint) -> Closure:
        """The joint's two frames in the base frame, z along its axis, and of a universal joint x
        along the second axis.
        """
        turn = Pose.identity() if joint.axis is None else frame_along(joint.axis, joint.axis2)
        if (
            joint.axis is not None
            and joint.axis2 is not None
            and abs(float(np.dot(joint.axis, joint.axis2))) > _SQUARE
        ):
            raise MechanismError(
                f"{joint.where}: the axes of the universal joint are not square to each other, and "
                f"it closes a loop of such joints; "
                "write it as two revolute joints with a link between them"
            )
        first, second = (
            self.placed[link][0] @ frame @ turn
            for link, frame in zip(joint.links, joint.frames, strict=True)
        )
        parts = (
            self.link_names[self.part_of[joint.links[0]]],
            self.link_names[self.part_of[joint.links[1]]],
        )
        kind: ClosureType = joint.type
        limits = joint.limits if JOINT_FORMS[joint.type].freedom == 1 else None
        driven = joint.actuated or self.graph.parts.drives(joint.name, joint.type)
        return Closure(
            self.joint_names[joint.name],
            kind,
            parts,
            first,
            second,
            joint.where,
            joint.pitch,
            limits,
            driven,
            joint.motor if JOINT_FORMS[joint.type].freedom == 1 else None,
        )

    def _coupling(self, coupling: Coupling) -> Coupling:
        new = self._coordinate
        if isinstance(coupling.of, str):
            return replace(coupling, joint=new(coupling.joint), of=new(coupling.of))
        return replace(
            coupling,
            joint=new(coupling.joint),
            of=tuple((new(name), factor) for name, factor in coupling.terms),
        )

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
            if link in self.placed
        }


def _preference(joint: GraphJoint, coupled: bool) -> int:
    if joint.closing:
        return 4
    if joint.type == "weld":
        return 0
    if coupled or joint.type in ("H", "U"):
        return 1
    return 2 if joint.limits is not None or joint.actuated else 3


def _uniquely_named(graph: JointGraph) -> JointGraph:
    """The graph with a number behind the name of a closing joint that another joint has. Raises
    MechanismError for others.
    """
    used = {joint.name for joint in graph.joints if not joint.closing}
    joints, seen = [], set()
    for joint in graph.joints:
        name, number = joint.name, 2
        if not joint.closing and name in seen:
            raise MechanismError(
                f"{joint.where}: two joints are named {name!r}; names must be unique in the file"
            )
        while joint.closing and name in used:
            name, number = f"{joint.name}_{number}", number + 1
        used.add(name)
        seen.add(name)
        joints.append(joint if name == joint.name else replace(joint, name=name))
    return replace(graph, joints=joints)


def _unreached_note(graph: JointGraph, reached: Collection[str]) -> list[str]:
    lost = [link for link in graph.links if link not in reached]
    return [f"nothing joins to the robot, and left out: {first_of(lost)}"] if lost else []


def _within_a_link(closure: Closure) -> str:
    """A note on a closure between two parts of one link, which moves nothing. Raises MechanismError
    where it cannot close.
    """
    gap = float(
        np.linalg.norm(np.asarray(closure.second.position) - np.asarray(closure.first.position))
    )
    away = closure.first.inverse() @ closure.second
    turn = np.asarray(away.rotation)
    match closure.type:
        case "S":
            open_by = gap
        case "R" | "U":
            open_by = (
                max(gap, float(np.linalg.norm(turn[:, 2] - np.eye(3)[2])))
                if closure.type == "R"
                else gap
            )
        case "C" | "H" | "P":
            open_by = math.hypot(*np.asarray(away.position)[:2]) + float(
                np.linalg.norm(turn[:, 2] - np.eye(3)[2])
            )
        case _:
            open_by = max(gap, float(np.linalg.norm(turn - np.eye(3))))
    if open_by > _COINCIDE:
        raise MechanismError(
            f"{closure.where}: it closes a loop within the one link {closure.links[0]!r}, whose "
            f"two frames are {open_by:.3g} apart (m, "
            "rad); no configuration closes it"
        )
    return (
        f"the closure {closure.name!r} is within the one link {closure.links[0]!r}, closed, and "
        f"left out"
    )


def _unit(quaternion: np.ndarray) -> np.ndarray:
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def _numbers(vector: np.ndarray) -> list[float]:
    return [float(component) for component in np.asarray(vector)]
