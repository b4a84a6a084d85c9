"""Read SDF: joints between any links of a model, placed by the poses of the file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from symkin.formats.couplings import CouplingSet, LinearEquation
from symkin.formats.graph_reader import ONE_COORDINATE, GraphReader
from symkin.formats.naming import robot_name
from symkin.formats.parts import JOINTS_TAG
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.robot import Direction, Mesh, Robot, RobotJoint, refuse_too_many
from symkin.formats.sdf_frames import FIRST_WITH_FRAMES, WORLD, Scope, SdfFrames, sdf_version
from symkin.formats.sdf_joint import (
    TYPES,
    refuse_model_frame,
    sdf_axis,
    sdf_limits,
    sdf_motor,
    sdf_pitch,
    sdf_type,
    unit_from,
)
from symkin.formats.sdf_world import robot_model
from symkin.formats.spanning import spanned, spanning_tree
from symkin.formats.urdf_parts import parts_within, refuse_itself, unit
from symkin.formats.xml_text import Element, read_xml
from symkin.model.graph import Coupling
from symkin.model.joined import along, joined_to, way
from symkin.spatial.pose import Pose
from symkin.text import first_of

_PARALLEL = 1e-6
"""Sine of the angle between axes that are taken for one direction."""
_APART = 1e-6
"""Metres beyond which a joint and the frame that is its parent are two places."""


def read_sdf(path: Path, read: ReadOptions = AS_IT_IS) -> Robot:
    """The robot that the one model of an SDF file describes, at the poses of the file.

    Raises InputError and MechanismError with file, line and element for what is not right.
    """
    path = Path(path)
    root = read_xml(path, "sdf")
    return spanned(_Reader(root, path, read).robot())


class _Reader(GraphReader):
    """The parts of an SDF file."""

    def __init__(self, root: Element, path: Path, read: ReadOptions) -> None:
        super().__init__(path, read)
        self.unlimited: list[str] = []
        self.model = robot_model(root, read.model, self.notes)
        self.parts = parts_within(self.model)
        self.frames = SdfFrames(self.packages)
        scope = Scope("", "__model__", sdf_version(root), self.model, (path,))
        self.frames.add_model(self.model, scope)
        elements = [element for element, _ in self.frames.joints]
        refuse_too_many(
            self.model.where,
            len(elements),
            sum(e.attributes.get("type") != "fixed" for e in elements),
        )
        self.poses = {_plain(link): self.frames.pose(link) for link in self.frames.links}
        self.poses[WORLD] = Pose.identity()

    def robot(self) -> Robot:
        joints = [
            self._joint(*entry)
            for entry in self.frames.joints
            if entry[0].attributes.get("type") != "gearbox"
        ]
        couplings = CouplingSet.of(self._mimics(joints), self._gears(joints))
        self.notes += couplings.notes
        on_world = any(WORLD in joint.links for joint in joints)
        links = [WORLD] * on_world + [_plain(link) for link in self.frames.links]
        if not links:
            raise self.model.error("no <link> is found; a robot has links and joints")
        root = WORLD if on_world else self._root(links, joints)
        robot = Robot(
            name=robot_name(self.model.attributes.get("name"), self.path),
            bodies=links,
            root=root,
            told=joints,
            couplings=tuple(couplings.found.values()),
            source=str(self.path),
            meshes={
                _plain(link): self.meshes(element, partial(self._mesh, link, scope))
                for link, (element, scope) in self.frames.links.items()
            },
            parts=self.parts,
        )
        robot = self._with_motors(robot)
        if self.unlimited:
            self.notes.append(
                f"ranges of joints of two coordinates are left out: {first_of(self.unlimited)}"
            )
        left_out = self._left_out()
        return replace(robot, notes=(*self.frames.notes, *self.notes, *left_out))

    def _root(self, links: Sequence[str], joints: Sequence[RobotJoint]) -> str:
        """The model's canonical link, or the first link of the part that has most joints where
        nothing joins to that one.
        """
        canonical = _plain(self.frames.link_of(self.frames.frames["__model__"].attached))
        canonical = links[0] if canonical == WORLD else canonical
        if not joints or any(canonical in joint.links for joint in joints):
            return canonical
        return max(links, key=lambda link: len(joined_to(joints, link)))

    # --- joints -----------------------------------------------------------------------------------

    def _joint(self, element: Element, scope: Scope) -> RobotJoint:
        name = _plain(scope.prefix + element.attribute("name"))
        parent, child = (self._body(element, tag, scope) for tag in ("parent", "child"))
        if child == WORLD:
            raise element.error("the child is the world, which does not move; make it the parent")
        refuse_itself(parent, child, element)
        at = self._joint_pose(element, scope)
        self._note_parent_frame(element, scope, at)
        frames = (self.poses[parent].inverse() @ at, self.poses[child].inverse() @ at)
        word = element.attributes.get("type", "")
        is_universal = word in ("revolute2", "universal")
        kind = "U" if is_universal else sdf_type(element, (*TYPES, "revolute2", "gearbox"))
        has_axis = kind not in ("weld", "S")
        has_one = has_axis and not is_universal
        bounds = sdf_limits(element) if has_one and word != "continuous" else None
        return RobotJoint(
            name,
            kind,
            (parent, child),
            frames,
            axis=self._axis(element, "axis", scope, at) if has_axis else None,
            axis2=self._second(element, scope, at) if is_universal else None,
            pitch=sdf_pitch(element) if kind == "H" else 0.0,
            limits=self.range_of(bounds, element, element.line),
            motor=sdf_motor(element) if has_one else None,
            closing=name in self.parts.welds,
            where=element.where,
        )

    def _note_parent_frame(self, element: Element, scope: Scope, at: Pose) -> None:
        """Say where the parent is a frame away from the joint: it only names the link, and the
        poses of the file hold.
        """
        name = element.needed("parent").text.strip()
        full = WORLD if name == WORLD else self.frames.find(name, scope, element)
        if full == WORLD or full in self.frames.links:
            return
        away = float(np.linalg.norm(np.asarray((self.frames.pose(full).inverse() @ at).position)))
        if away > _APART:
            self.notes.append(
                f"line {element.line}: the parent frame {name!r} of {element.label} is {away:.3g} "
                f"m from the joint, which stands at its child; "
                "the frame names a link, and the poses of the file hold"
            )

    def _body(self, element: Element, tag: str, scope: Scope) -> str:
        """The link that a joint's parent or child is, or carries the frame that it names."""
        end = element.needed(tag)
        name = end.text.strip()
        if not name:
            raise end.error("is empty; the name of a link is needed")
        link = _plain(self.frames.link_of(self.frames.find(name, scope, end)))
        if link not in self.poses:
            raise end.error(f"the frame {name!r} is carried by no link")
        return link

    def _joint_pose(self, element: Element, scope: Scope) -> Pose:
        """The joint's frame in the world: told in the frame that is its child unless it says
        otherwise.
        """
        child = self.frames.find(element.needed("child").text.strip(), scope, element)
        pose, told_in = self.frames.relative(element, scope, child)
        return self.frames.pose(told_in) @ pose

    def _axis(self, element: Element, tag: str, scope: Scope, at: Pose) -> Direction:
        """An axis in the joint's frame, by the version of the file."""
        model = self.frames.pose(scope.model)
        if scope.version < FIRST_WITH_FRAMES:
            return sdf_axis(element, tag, model.inverse() @ at, scope.version)
        axis = element.needed(tag)
        xyz = axis.needed("xyz")
        name = xyz.attributes.get("expressed_in", "").strip()
        if not name:
            vector = xyz.text_numbers(3)
            refuse_model_frame(axis, vector, model.inverse() @ at)
            return unit(xyz, vector)
        told_in = self.frames.pose(self.frames.find(name, scope, xyz))
        return unit_from(xyz, at.inverse() @ told_in)

    def _second(self, element: Element, scope: Scope, at: Pose) -> Direction:
        first, second = (self._axis(element, tag, scope, at) for tag in ("axis", "axis2"))
        if np.linalg.norm(np.cross(first, second)) < _PARALLEL:
            raise element.error("axis and axis2 are parallel; two directions are needed")
        if any(sdf_limits(element, tag) is not None for tag in ("axis", "axis2")):
            self.unlimited.append(scope.prefix + element.attribute("name"))
        return second

    # --- couplings --------------------------------------------------------------------------------

    def _mimics(self, joints: Sequence[RobotJoint]) -> Iterator[tuple[Coupling, str]]:
        """follower = multiplier x (leader - reference) + offset."""
        made = {joint.name: joint for joint in joints}
        for element, scope in self.frames.joints:
            for own, tag in enumerate(("axis", "axis2"), start=1):
                axis = element.one(tag)
                mimic = None if axis is None else axis.one("mimic")
                if mimic is None:
                    continue
                number = 2 if mimic.attributes.get("axis", "axis").strip() == "axis2" else 1
                ends = ((element.attribute("name"), own), (mimic.attribute("joint"), number))
                follower, leader = (
                    self._coordinate(made, scope.prefix + name, k, mimic) for name, k in ends
                )
                if leader == follower:
                    raise mimic.error("the joint mimics itself; name another joint")
                factor, offset, reference = (
                    mimic.child_number(word, default)
                    for word, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0))
                )
                yield Coupling(follower, {leader: factor}, offset - factor * reference), mimic.where

    def _coordinate(
        self, made: dict[str, RobotJoint], name: str, axis: int, element: Element
    ) -> str:
        name = _plain(name)
        if name not in made or made[name].type not in (*ONE_COORDINATE, "U"):
            raise element.error(
                f"the joint {name!r} is {'unknown' if name not in made else 'without an axis'}"
            )
        return name + (f".{axis}" if made[name].type == "U" else "")

    def _gears(self, joints: Sequence[RobotJoint]) -> Iterator[LinearEquation]:
        """theta_2 = -ratio theta_1: the angles of parent and child against the reference body,
        about axis and axis2.
        """
        for element, scope in self.frames.joints:
            if element.attributes.get("type") != "gearbox":
                continue
            at = self._joint_pose(element, scope)
            reference = self._body(element, "gearbox_reference_body", scope)
            factors: dict[str, float] = {}
            ratio = element.needed("gearbox_ratio").text_number()
            for tag, axis, weight in (("parent", "axis", ratio), ("child", "axis2", 1.0)):
                about = at.turn(np.asarray(self._axis(element, axis, scope, at)))
                turns = self._turns(
                    element, joints, reference, self._body(element, tag, scope), about
                )
                for name, sign in turns.items():
                    factors[name] = factors.get(name, 0.0) + weight * sign
            if sum(factor != 0.0 for factor in factors.values()) < 2:
                raise element.error("the gearbox couples no two joints")
            # what follows is the joint before the child
            yield LinearEquation(dict(reversed(factors.items())), 0.0, element.where)

    def _turns(
        self,
        element: Element,
        joints: Sequence[RobotJoint],
        start: str,
        end: str,
        about: np.ndarray,
    ) -> dict[str, float]:
        """The revolute joints from one link to another about a direction, with the sense in which
        each turns the second link.
        """
        senses = {joint.name: self._sense(joint, about) for joint in joints}
        path = way([joint for joint in joints if senses[joint.name] is not None], start, end)
        if path is None:
            raise element.error(
                f"no revolute joints about its axis lead from the reference body to {end!r}"
            )
        turns = ((j.name, senses[j.name] or 0.0, forward) for j, forward in along(path, start))
        return {name: sense if forward else -sense for name, sense, forward in turns if sense}

    def _sense(self, joint: RobotJoint, about: np.ndarray) -> float | None:
        """1 or -1 for a joint that turns about a direction, 0 for a weld; None for others."""
        if joint.type == "weld":
            return 0.0
        if joint.type != "R" or joint.axis is None:
            return None
        frame = self.poses[joint.links[0]] @ joint.frames[0]
        turn = float(frame.turn(np.asarray(joint.axis)) @ about)
        return float(round(turn)) if abs(abs(turn) - 1.0) <= _PARALLEL else None

    # --- the rest ---------------------------------------------------------------------------------

    def _with_motors(self, robot: Robot) -> Robot:
        """The joints that plugins name actuated, but those that only tell their states, else all of
        the tree that move.
        """
        if self.motors_told:
            return robot
        named = {
            e.text.strip()
            for p in self.model.walk()
            if p.tag == "plugin" and not _is_publisher(p)
            for e in p.walk()
            if e.tag == "joint_name"
        }
        followers = {coupling.joint for coupling in robot.couplings}
        tree = {joint.name for joint in spanning_tree(robot.told, robot.couplings)}
        return replace(robot, told=self.driven(robot.told, named, tree, followers, self.notes))

    def _mesh(self, link: str, scope: Scope, visual: Element, mesh: Element) -> Mesh:
        """A mesh of a visual, which is told in the link's frame unless it says otherwise."""
        pose, told_in = self.frames.relative(visual, scope, link)
        scale = mesh.one("scale")
        numbers = (1.0, 1.0, 1.0) if scale is None else scale.text_numbers(3)
        at = self.poses[_plain(link)].inverse() @ self.frames.pose(told_in) @ pose
        return self.mesh(mesh, mesh.needed("uri").text.strip(), at, numbers)

    def _left_out(self) -> list[str]:
        """Notes on elements of models that have no meaning here."""
        names = {*self.frames.links, *(e.attribute("name") for e, _ in self.frames.joints)}
        others = [
            child
            for scope in self.frames.scopes
            for child in scope.element.children
            if child.tag not in _KNOWN
        ]
        for e in others:
            if e.tag == "plugin" and "DetachableJoint" in e.attributes.get("name", ""):
                ends = [
                    end.text.strip() for tag in ("parent_link", "child_link") for end in e.all(tag)
                ]
                self.notes.append(
                    f"line {e.line}: a plugin joins {' and '.join(ends)} when the simulation runs; "
                    f"write a joint to have the loop"
                )
        return self.left_out(others, _OF_NO_MEANING, names, " in a model")


_OF_NO_MEANING = {"plugin": "<plugin>", "gripper": "<gripper>"}
"""Elements that name links and joints, and are no constraints."""
_KNOWN = frozenset(
    [
        JOINTS_TAG,
        "allow_auto_disable",
        "enable_wind",
        "frame",
        "include",
        "joint",
        "link",
        "model",
        "pose",
        "self_collide",
        "static",
    ]
)


def _is_publisher(plugin: Element) -> bool:
    """Whether a plugin publishes the states of the joints that it names, and drives none."""
    names = "".join(plugin.attributes.get(key, "") for key in ("name", "filename"))
    return "jointstatepublisher" in names.lower().replace("-", "").replace("_", "")


def _plain(name: str) -> str:
    """A full name with / between model and part, which names here may hold."""
    return name.replace("::", "/")
