"""Read URDF: a tree of links at the configuration where all joints are 0, and the loops that are
written into it or beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.couplings import CouplingSet
from symkin.formats.gepetto_yaml import loops_beside
from symkin.formats.graph_reader import GraphReader
from symkin.formats.naming import robot_name
from symkin.formats.packages import Packages
from symkin.formats.parts import JOINTS_TAG
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.robot import (
    AXES,
    Direction,
    Mesh,
    Robot,
    RobotJoint,
    frame_along,
    place,
    refuse_too_many,
)
from symkin.formats.spanning import spanned
from symkin.formats.urdf_loops import LOOP_TAGS, gears_within, loops_within
from symkin.formats.urdf_motors import driven_names, mimics, told_motors
from symkin.formats.urdf_parts import (
    direction,
    known_link,
    origin,
    parts_within,
    plain_tag,
    refuse_itself,
)
from symkin.formats.xacro_text import expanded, is_xacro, macros
from symkin.formats.xml_text import Element, read_xml
from symkin.model.joined import joined_to
from symkin.model.joint_forms import JointType
from symkin.spatial.pose import Pose
from symkin.text import first_of, meant, not_among

_TYPES: dict[str, JointType] = {
    "revolute": "R",
    "continuous": "R",
    "prismatic": "P",
    "fixed": "weld",
    "ball": "S",
    "spherical": "S",
    "universal": "U",
    "screw": "H",
}
"""Joints of URDF, and those that Drake adds; floating and planar ones are chains of these."""
_WORLD = "world"
"""The link that Drake and MuJoCo know without a <link>."""

_OF_NO_MEANING = {
    "material": "materials",
    "transmission": "transmissions (but which joints they drive)",
    "ros2_control": "controllers (but which joints they drive)",
    "gazebo": "simulator settings",
    "sensor": "sensors",
    "mujoco": "compiler settings",
    "drake:linear_bushing_rpy": "bushings, which are springs",
    "drake:proximity_properties": "contact settings",
    "drake:collision_filter_group": "contact settings",
    "collision_filter_group": "contact settings",
    "self_collision_checking": "contact settings",
    "disable_collisions": "contact settings",
    "actuator": "motors' data",
    "frame": "frames",
    "force_element": "forces",
    "verbose": "settings",
    "group": "groups of joints",
    "group_state": "groups of joints",
    "end_effector": "groups of joints",
    "camera": "sensors",
}


def read_urdf(path: Path, read: ReadOptions = AS_IT_IS) -> Robot:
    """The robot that a URDF file describes, at the configuration where all joints are 0; macros of
    xacro are expanded.

    Raises InputError and MechanismError with file, line and element for what is not right.
    """
    path = Path(path)
    return spanned(_Reader(_root(path, read), path, read).robot())


def _root(path: Path, read: ReadOptions) -> Element:
    """The root element, of a file in xacro the expanded one."""
    root = read_xml(path, "robot")
    if not is_xacro(root):
        read.refuse_but(
            ("loop", "actuated", "platform", "packages"),
            str(path),
            "the file has no macros of xacro",
        )
        return root
    root = expanded(path, read.arguments, Packages(path, read.folders))
    left = next(macros(root), None)
    if left is not None:
        raise left.error(
            "is xacro that is left as it is; the root element needs "
            'xmlns:xacro="http://www.ros.org/wiki/xacro"'
        )
    return root


class _Reader(GraphReader):
    """The parts of a URDF file."""

    def __init__(self, root: Element, path: Path, read: ReadOptions) -> None:
        super().__init__(path, read)
        self.root, self.parts = root, parts_within(root)
        self.links = self._links()
        self.elements = root.all("joint", "drake:joint")
        count = max(
            len(self.links),
            sum(e.tag in ("joint", "drake:joint", *LOOP_TAGS) for e in root.children),
        )
        refuse_too_many(
            root.where, count, sum(e.attributes.get("type") != "fixed" for e in self.elements)
        )
        self.beside = loops_beside(path)

    def robot(self) -> Robot:
        joints = self._joints()
        root = self._root_link(joints)
        zero = place(joints, {root: Pose.identity()})
        loops, of_loops = loops_within(self.root, zero, self.beside.frames, self.read.loop)
        joints = [*joints, *self._beside(), *loops]
        motors = told_motors(self.root)
        joints = [replace(joint, motor=motors.get(joint.name)) for joint in joints]
        couplings = CouplingSet.of(
            mimics(self.elements, joints), gears_within(self.root, self.links, joints)
        )
        joints, of_motors = self._with_motors(joints)
        self._refuse_lost(root, joints)
        return Robot(
            name=robot_name(self.root.attributes.get("name"), self.path),
            bodies=tuple(self.links),
            root=root,
            told=joints,
            couplings=tuple(couplings.found.values()),
            notes=(
                *self.notes,
                *of_motors,
                *self.beside.notes,
                *of_loops,
                *couplings.notes,
                *self._left_out(),
            ),
            source=str(self.path),
            meshes={name: self.meshes(element, self._mesh) for name, element in self.links.items()},
            parts=self.parts,
        )

    # --- links ------------------------------------------------------------------------------------

    def _links(self) -> dict[str, Element]:
        links = self._named(self.root.all("link"))
        if not links:
            raise self.root.error("no <link> is found; a robot has links and joints")
        parents = {
            parent.attribute("link")
            for joint in self.root.all("joint", "drake:joint")
            for parent in joint.all("parent")
        }
        if _WORLD in parents and _WORLD not in links:
            self.notes.append(
                f"the link {_WORLD!r}, which no <link> writes, is what the robot stands on"
            )
            return {_WORLD: self.root, **links}
        return links

    def _named(self, elements: Sequence[Element]) -> dict[str, Element]:
        """Links or joints by name. Raises MechanismError for a name that two have."""
        found: dict[str, Element] = {}
        for element in elements:
            name = element.attribute("name")
            first = found.setdefault(name, element)
            if first is not element:
                raise element.error(
                    f"two {first.tag.rpartition(':')[2]}s are named {name!r} (the first on line "
                    f"{first.line}); names must be unique"
                )
        return found

    def _root_link(self, joints: Sequence[RobotJoint]) -> str:
        """The link that is no joint's child. Raises MechanismError where two joints carry one link,
        or no link is the root.
        """
        carried: dict[str, RobotJoint] = {}
        for joint in joints:
            child = joint.links[1]
            if child in carried:
                raise MechanismError(
                    f"{joint.where}: the link {child!r} is the child of two joints, of "
                    f"{carried[child].name!r} as well; a URDF is a tree, write the loop "
                    "as a closure, such as <loop_joint>"
                )
            carried[child] = joint
        roots = [link for link in self.links if link not in carried]
        if not roots:
            raise self.root.error(
                "every link is a joint's child; one is needed that is not, the root of the tree"
            )
        return roots[0]

    def _refuse_lost(self, root: str, joints: Sequence[RobotJoint]) -> None:
        reached = joined_to(joints, root)
        lost = [link for link in self.links if link not in reached]
        if lost:
            raise self.links[lost[0]].error(
                f"neither joints nor closures join it to the root link "
                f"{root!r}{f', nor {len(lost) - 1} more' if lost[1:] else ''}; a "
                "URDF is one tree"
            )

    def _mesh(self, visual: Element, mesh: Element) -> Mesh:
        scale = mesh.numbers("scale", 3, (1.0, 1.0, 1.0))
        return self.mesh(mesh, mesh.attribute("filename"), origin(visual), scale)

    # --- joints -----------------------------------------------------------------------------------

    def _joints(self) -> list[RobotJoint]:
        named = self._named(self.elements)
        joints = [made for name, e in named.items() for made in self._joint(e, name)]
        for name in self.beside.retyped:
            if name not in named:
                raise MechanismError(
                    f"{self.beside.file}: joint_name: {name!r} is no joint of {self.path.name}"
                )
        return joints

    def _joint(self, element: Element, name: str) -> list[RobotJoint]:
        kind = element.attribute("type")
        links = tuple(
            known_link(end.attribute("link"), end, self.links)
            for end in map(element.needed, ("parent", "child"))
        )
        refuse_itself(links[0], links[1], element)
        made = RobotJoint(
            name,
            "weld",
            (links[0], links[1]),
            (origin(element), Pose.identity()),
            where=element.where,
        )
        if name in self.beside.retyped:
            word, axes = self.beside.retyped[name]
            axis, axis2 = axes or (None, None)
            return [replace(made, type=word, axis=axis, axis2=axis2)]
        if element is self._held:
            self.notes.append(
                f"the floating joint {name!r} of the root is held, the link {links[1]!r} with it"
            )
            return [made]
        if kind == "floating":
            return _chain(made, [*((word, "P", axis) for word, axis in AXES.items()), _BALL])
        if kind == "planar":
            return _chain(made, _planar(direction(element)))
        if kind not in _TYPES:
            raise element.error(f"type = {not_among(kind, [*_TYPES, 'floating', 'planar'])}")
        return [self._plain(replace(made, type=_TYPES[kind]), element, kind)]

    def _plain(self, made: RobotJoint, element: Element, kind: str) -> RobotJoint:
        """A joint of one type, with axis, range and pitch."""
        if made.type == "weld" or made.type == "S":
            return made
        if made.type == "U":
            return replace(made, axis=AXES["x"], axis2=AXES["y"])
        pitch = 0.0
        if made.type == "H":
            pitch = element.needed("drake:screw_thread_pitch").number("value")
        limits = self._limits(element) if kind in ("revolute", "prismatic") else None
        return replace(made, axis=direction(element), limits=limits, pitch=pitch)

    def _limits(self, element: Element) -> tuple[float, float] | None:
        limit = element.one("limit")
        if limit is None or not {"lower", "upper"} & set(limit.attributes):
            return None
        low, high = (limit.number(key, 0.0, infinite=True) for key in ("lower", "upper"))
        return self.range_of((low, high), element, limit.line)

    @cached_property
    def _held(self) -> Element | None:
        """The floating joint under the root, where the root carries nothing else: the base is
        held.
        """
        ends = {
            e: [e.needed(tag).attribute("link") for tag in ("parent", "child")]
            for e in self.elements
        }
        children = {child for _, child in ends.values()}
        root = next((link for link in self.links if link not in children), None)
        first = [e for e, (parent, _) in ends.items() if parent == root]
        return first[0] if len(first) == 1 and first[0].attribute("type") == "floating" else None

    def _beside(self) -> list[RobotJoint]:
        """The closures of the YAML file beside the URDF."""
        made = []
        for k, (kind, *names) in enumerate(self.beside.closures, start=1):
            where = f"{self.beside.file}: closed_loop[{k - 1}]"
            first, second = (self._frame_beside(name, where) for name in names)
            made.append(RobotJoint(f"loop{k}", kind, (first, second), closing=True, where=where))
        return made

    def _frame_beside(self, name: str, where: str) -> str:
        """The link whose frame is meant: one by its name, or the child of the joint of that
        name.
        """
        children = {e.attribute("name"): e.needed("child").attribute("link") for e in self.elements}
        if name not in self.links and name not in children:
            raise MechanismError(
                f"{where} names the frame {name!r}, which is no link or joint of {self.path.name}"
                + meant(name, [*self.links, *children])
            )
        return name if name in self.links else children[name]

    def _with_motors(self, joints: list[RobotJoint]) -> tuple[list[RobotJoint], list[str]]:
        """The joints, actuated where the YAML file, transmissions or URDF+ say so; and notes."""
        if self.motors_told:
            return joints, []
        named, source = driven_names(self.root, self.beside)
        unknown = named - {joint.name for joint in joints}
        notes = (
            [f"{source} name joints that the file has not: {first_of(sorted(unknown))}"]
            if unknown
            else []
        )
        followers = {e.attribute("name") for e in self.elements if e.one("mimic") is not None}
        tree = {joint.name for joint in joints if not joint.closing}
        return self.driven(joints, named, tree, followers, notes), notes

    # --- what is left out -------------------------------------------------------------------------

    def _left_out(self) -> list[str]:
        """Notes on elements of no meaning here."""
        known = {"link", "joint", "drake:joint", JOINTS_TAG, *LOOP_TAGS}
        names = {*self.links, *(e.attribute("name") for e in self.elements)}
        others = [
            e
            for e in self.root.children
            if e.tag not in known and plain_tag(e.tag) not in LOOP_TAGS
            if e.tag != "gazebo" or {child.tag for child in e.children} != {"joint"}
        ]
        return self.left_out(others, _OF_NO_MEANING, names)


_Part = tuple[str, JointType, Direction | None]
"""What is added to a joint's name, type and axis of one of several joints in its place."""
_BALL: _Part = ("turn", "S", None)


def _planar(normal: Direction) -> list[_Part]:
    """Two slides in the plane and a turn about its normal."""
    first, second = np.asarray(frame_along(normal).rotation).T.tolist()[:2]
    return [("1", "P", tuple(first)), ("2", "P", tuple(second)), ("angle", "R", normal)]


def _chain(joint: RobotJoint, parts: Sequence[_Part]) -> list[RobotJoint]:
    """A joint of many freedoms as joints of one type each, with links of their own between them."""
    middle = [f"{joint.name}.{word}.link" for word, _, _ in parts[:-1]]
    links = [joint.links[0], *middle, joint.links[1]]
    still = Pose.identity()
    return [
        RobotJoint(
            f"{joint.name}.{word}",
            kind,
            (links[k], links[k + 1]),
            (joint.frames[0] if k == 0 else still, still),
            axis,
            where=joint.where,
        )
        for k, (word, kind, axis) in enumerate(parts)
    ]
