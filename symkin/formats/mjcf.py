"""Read MJCF, the XML of MuJoCo, as a robot: bodies, joints, equality constraints, fixed tendons,
and which joints actuators drive.

MuJoCo's own compiler resolves defaults, classes, includes, frames and angles, in a process of its
own (`formats/mujoco_worker.py`); what is read is the compiled model at qpos0. Meshes and inertias
are never needed: the first need not be there, the second are replaced. What constraints and tendons
mean is MuJoCo's documentation, "XML reference: equality", and `mj_instantiateEqual` of its source.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import InputError, MechanismError
from symkin.formats.child import ChildError, answer_of
from symkin.formats.mjcf_model import (
    CompiledModel,
    active_equalities,
    compiled_model,
    couplings_of,
    held_values,
    idle_actuators,
    meshes_of,
    motor_at,
    pose_of,
    without_kinematics,
)
from symkin.formats.naming import fresh_name, robot_name
from symkin.formats.parts import KEY, Parts, parts_from
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.robot import Mesh, Robot, RobotJoint, refuse_too_many
from symkin.formats.spanning import names_of, spanned, uniquely_named
from symkin.formats.xml_text import end_of_root, read_text, read_xml
from symkin.model.joined import Joined
from symkin.model.joint import BASE
from symkin.model.joint_forms import JointType
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply
from symkin.text import first_of, printable

_WORKER = Path(__file__).with_name("mujoco_worker.py")
_INSTALL = (
    "reading MJCF takes MuJoCo's compiler, which is not installed; pip install 'symkin[mjcf]' "
    "brings it"
)


def read_mjcf(path: Path, read: ReadOptions = AS_IT_IS) -> Robot:
    """The robot that an MJCF file describes, at the file's own configuration (qpos0).

    Raises InputError for a file that cannot be read or without the package `mujoco`, MechanismError
    for a file that is not right: file, line and element as MuJoCo's compiler tells them.
    """
    told = uniquely_named(_reader(path, read).robot())
    robot, order = spanned(told), [*names_of(told)[1].values()]
    # MuJoCo's order: that of bodies within each other
    joints = sorted(robot.told, key=lambda joint: (joint.closing, order.index(joint.name)))
    return replace(robot, told=joints)


def with_keyframe(
    path: Path, joints: Mapping[str, float | Sequence[float]], poses: Mapping[str, Pose]
) -> bytes:
    """The content of an MJCF file, in its own encoding, with one more keyframe, "closed": the
    values of its joints, and poses of links that hang on no joint.
    """
    reader = _reader(path)
    content = read_text(path)
    end = end_of_root(content, str(path))
    used = {e.attributes.get("name", "") for e in reader.compiled.root.walk() if e.tag == "key"}
    name = fresh_name("closed", used)
    numbers = " ".join(repr(float(value) + 0.0) for value in reader.positions(joints, poses))
    if not numbers:
        raise InputError(f"{path} has no joint whose value a keyframe could hold; give a .json")
    frame = f'  <keyframe>\n    <key name="{name}" qpos="{numbers}"/>\n  </keyframe>\n'
    return content[:end] + frame.encode() + content[end:]


def _reader(path: Path, read: ReadOptions = AS_IT_IS) -> _Reader:
    """The compiled model, ready to be read."""
    root = read_xml(path, "mujoco")
    told = _told(path)
    joints = len(told["joints"])
    refuse_too_many(str(path), max(len(told["bodies"]), joints, len(told["equalities"])), joints)
    compiled = compiled_model(told, root, path)
    _check_finite(compiled)
    return _Reader(compiled, motors_told=bool(read.actuated))


def _told(path: Path) -> dict[str, Any]:
    """What MuJoCo's compiler makes of a file."""
    if find_spec("mujoco") is None:
        raise InputError(_INSTALL)
    if printable(str(path)) != str(path):
        raise InputError(f"{path}: MuJoCo's compiler reads no file whose path is not plain text")
    try:
        told: dict[str, Any] = answer_of(_WORKER, {"path": str(path)})
    except ChildError as error:
        raise MechanismError(f"{path}: MuJoCo's compiler {error}") from None
    if "error" in told:
        raise MechanismError(f"{path}: {_sentence(told['error'])}")
    return told


def _sentence(message: str) -> str:
    """The compiler's message in one line."""
    text = re.sub(r"\s+", " ", message).strip()
    return re.sub(r"^(XML )?(Error: )+", "", text).replace("Element name '', id", "element").strip()


def _check_finite(compiled: CompiledModel) -> None:
    """Raises MechanismError for numbers that are none, which the compiler lets through."""
    if compiled.finite:
        return
    guilty = (
        e.where
        for e in compiled.root.walk()
        for v in e.attributes.values()
        if {"nan", "inf", "-inf"} & set(v.lower().split())
    )
    place = next(guilty, compiled.path)
    raise MechanismError(f"{place}: a number is not finite; allowed: numbers such as 0.25 or 1e-3")


# --- from the compiled model to joints as a graph -------------------------------------------------

_WORLD = ""
"""The link that is MuJoCo's world: no body has an empty name here."""
_TYPES: dict[str, JointType] = {"hinge": "R", "slide": "P", "ball": "S"}


class _Reader:
    """The parts of a robot from a compiled model; `motors_told`: which joints are actuated is told
    elsewhere.
    """

    def __init__(self, compiled: CompiledModel, *, motors_told: bool = False) -> None:
        self.compiled, self.motors_told = compiled, motors_told
        self.bodies, self.joints = compiled.bodies, compiled.joints
        self.notes: list[str] = []
        self.equalities = active_equalities(compiled, self.notes)
        self.held = held_values(compiled, self.equalities, self.notes)
        self.free = {joint.body for joint in self.joints if joint.kind == "free"}
        self.floating = self._floating()
        self.joint_names = {
            j: joint.name or f"{self.bodies[joint.body].name}_joint{j}"
            for j, joint in enumerate(self.joints)
        }

    def robot(self) -> Robot:
        """The joints and closures, with notes on what is left out."""
        couplings = couplings_of(self.compiled, self.equalities, self.held, self.joint_names)
        follows = {c.joint for c in couplings.found.values()}
        bodies = range(1, len(self.bodies))
        joints = [joint for body in bodies for joint in self._joints(body, follows)]
        joints += self._closures()
        motors = () if self.motors_told else idle_actuators(self.compiled)
        return Robot(
            name=robot_name(self.compiled.name, self.compiled.path),
            bodies=tuple(self.links.values()),
            root=_WORLD,
            told=joints,
            couplings=tuple(couplings.found.values()),
            notes=(*self.notes, *couplings.notes, *without_kinematics(self.compiled), *motors),
            source=self.compiled.path.name,
            meshes=self._meshes(),
            parts=self._told,
            floating={self.links[body]: self._frame(body) for body in self.floating},
            root_frame=self._frame(self._base),
        )

    @cached_property
    def _told(self) -> Parts:
        """What the file's text tells of joints."""
        return parts_from(
            self.compiled.texts.get(KEY, ""), f"{self.compiled.path}: <text name={KEY!r}>"
        )

    # --- bodies -----------------------------------------------------------------------------------

    @cached_property
    def links(self) -> dict[int, str]:
        """The name of each body; the world and a body named base that stands still in it are
        one link.
        """
        names = {body: told.name for body, told in enumerate(self.bodies)}
        return {**names, 0: _WORLD, self._base: _WORLD}

    @cached_property
    def _base(self) -> int:
        """A body named base that stands still in the world, or that one."""
        still = {0}
        for body, told in enumerate(self.bodies):
            moves = bool(self._body_joints(body)) or body in self.floating
            if not moves and told.parent in still:
                still.add(body)
        named = (body for body in sorted(still - {0}) if self.bodies[body].name == BASE)
        return next(named, 0)

    def _body_joints(self, body: int) -> list[int]:
        """The joints that carry a body, in their order, but held and free ones."""
        own = self.bodies[body].joints
        return [j for j in own if j not in self.held and self.joints[j].kind != "free"]

    def _floating(self) -> list[int]:
        """Bodies with a free joint that closures join to the base, or to a body that is held: of
        bodies that hang together, the first with a free joint is held, for a robot stands
        somewhere.
        """
        joined = Joined[int]()
        for body, told in enumerate(self.bodies):
            if body not in self.free:
                joined.join(body, told.parent)
        for equality in self.equalities:
            if equality.closes:
                joined.join(*equality.bodies)
        floating, still = list[int](), list[int]()
        for body in sorted(self.free):
            (still if joined.join(body, 0) else floating).append(body)
        if still:
            names = first_of([self.bodies[body].name for body in still])
            self.notes.append(
                f"free joints are held where the file has them, and their bodies are part of the "
                f"base: {names}"
            )
        return floating

    def _frame(self, body: int) -> Pose:
        told = self.bodies[body]
        return pose_of(told.position, told.quaternion)

    def _on_link(self, body: int) -> Pose:
        """A body's frame in that of the link which has its name: the world's has no other."""
        return self._frame(body) if self.links[body] == _WORLD else Pose.identity()

    def positions(
        self, joints: Mapping[str, float | Sequence[float]], poses: Mapping[str, Pose]
    ) -> np.ndarray:
        """MuJoCo's qpos for values of the robot's joints, and poses of the links that float."""
        found = np.array(self.compiled.qpos)
        links, names = names_of(uniquely_named(self.robot()))
        for number, told in self.joint_names.items():
            joint, name = self.joints[number], names.get(told, "")
            place, body = joint.place, joint.body
            if joint.kind == "free" and body in self.floating:
                pose = poses[links[self.links[body]]]
                found[place : place + 7] = [*pose.position, *pose.quaternion]
            elif name not in joints:
                continue
            elif joint.kind == "ball":
                # from axes of the base frame, as symkin has them, to the body's own
                turn, value = self._frame(body).quaternion, np.asarray(joints[name])
                value = conjugate(value) if told in self._told.turned else value
                found[place : place + 4] = multiply(multiply(conjugate(turn), value), turn)
            else:
                found[place] = joints[name]
        return found

    def _meshes(self) -> dict[str, tuple[Mesh, ...]]:
        """The meshes of bodies, each once, in the frames of their links."""
        found: dict[str, dict[tuple[str, tuple[float, ...]], Mesh]] = {}
        for body, mesh in meshes_of(self.compiled):
            pose = self._on_link(body) @ mesh.pose
            numbers = np.round([*pose.position, *pose.quaternion, *mesh.scale], 9)
            found.setdefault(self.links[body], {}).setdefault(
                (mesh.file, tuple(map(float, numbers))), replace(mesh, pose=pose)
            )
        return {name: tuple(meshes.values()) for name, meshes in found.items()}

    # --- joints -----------------------------------------------------------------------------------

    def _joints(self, body: int, follows: set[str]) -> Iterator[RobotJoint]:
        """The joints of a body, with a link between each two of them; a weld where it has none."""
        if self.links[body] == _WORLD or body in self.floating:
            return
        numbers, parent = self._body_joints(body), self.bodies[body].parent
        link, carrier = self.links[body], self.links[parent]
        carried = Pose.identity() if carrier == _WORLD else self._frame(parent)
        for joint in numbers:
            at = Pose(np.array(self.joints[joint].anchor), Pose.identity().quaternion)
            own = self.joint_names[joint]
            to = link if joint == numbers[-1] else fresh_name(f"{link}_{own}", self._taken)
            frames = (carried.inverse() @ at, self._frame(body).inverse() @ at)
            yield self._joint(joint, (carrier, to), frames, follows)
            carrier, carried = to, self._frame(body)
        if not numbers:
            name = fresh_name(f"{link}_weld", self._taken)
            frames = (carried.inverse() @ self._frame(body), Pose.identity())
            yield RobotJoint(name, "weld", (carrier, link), frames)

    @cached_property
    def _taken(self) -> set[str]:
        """Names that links between joints, and welds, have not."""
        return {*self.links.values(), *self.joint_names.values()}

    def _joint(
        self, number: int, links: tuple[str, str], frames: tuple[Pose, Pose], follows: set[str]
    ) -> RobotJoint:
        told, name = self.joints[number], self.joint_names[number]
        made = RobotJoint(name, _TYPES[told.kind], links, frames)
        if told.kind == "ball":
            if told.range is not None:
                self.notes.append(
                    f"the cone of the ball joint {name!r} is left out: spherical joints have no "
                    f"limits here"
                )
            return made
        low, high = told.range or (0.0, 0.0)
        return replace(
            made,
            axis=tuple(told.axis),
            value=told.value,
            limits=(low, high) if low < high else None,
            actuated=number in self._driven and name not in follows,
            motor=motor_at(self.compiled, number),
        )

    @cached_property
    def _driven(self) -> set[int]:
        """Joints that actuators drive."""
        return {joint for actuator in self.compiled.actuators for joint in actuator.joints}

    def _closures(self) -> Iterator[RobotJoint]:
        """The closures of connects and welds."""
        for told in self.equalities:
            if told.closes:
                first, second = (self.links[body] for body in told.bodies)
                frames = zip(told.bodies, told.frames, strict=True)
                one, other = (self._on_link(body) @ pose_of(*frame) for body, frame in frames)
                yield RobotJoint(
                    told.name or "_".join((told.kind, first or BASE, second or BASE)),
                    "weld" if told.rigid else "S",
                    (first, second),
                    (one, other),
                    closing=True,
                    where=told.where,
                )
