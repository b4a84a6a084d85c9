"""From MuJoCo's compiled model to joints as a graph: bodies and joints at qpos0, joints that are
held at a value moved there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symkin.computed_once import cached_property
from symkin.formats.mjcf_model import (
    CompiledModel,
    active_equalities,
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
from symkin.formats.robot import Mesh, Robot, RobotJoint
from symkin.formats.spanning import names_of, uniquely_named
from symkin.model.joined import Joined
from symkin.model.joint import BASE
from symkin.model.joint_forms import JointType
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply
from symkin.text import first_of

_WORLD = ""
"""The link that is MuJoCo's world: no body has an empty name here."""
_TYPES: dict[str, JointType] = {"hinge": "R", "slide": "P", "ball": "S"}


class Reader:
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

    def _own_frame(self, body: int) -> Pose:
        """The frame of the link which has a body's name."""
        return Pose.identity() if self.links[body] == _WORLD else self._frame(body)

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
        link, carrier, carried = self.links[body], self.links[parent], self._own_frame(parent)
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
        x, y, z = told.axis
        low, high = told.range or (0.0, 0.0)
        return replace(
            made,
            axis=(x, y, z),
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
                frames = [
                    self._on_link(body) @ pose_of(*frame)
                    for body, frame in zip(told.bodies, told.frames, strict=True)
                ]
                yield RobotJoint(
                    told.name or "_".join((told.kind, first or BASE, second or BASE)),
                    "weld" if told.rigid else "S",
                    (first, second),
                    (frames[0], frames[1]),
                    closing=True,
                    where=told.where,
                )
