"""From MuJoCo's compiled model to a robot: bodies and joints at qpos0, joints that are held at a
value moved there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.mjcf_couplings import (
    couplings_of,
    driven,
    idle_actuators,
    motor_at,
    without_kinematics,
)
from symkin.formats.mjcf_equalities import (
    Equality,
    active_equalities,
    body_of,
    frames_on_bodies,
    held_values,
    is_rigid,
)
from symkin.formats.mjcf_model import CompiledModel
from symkin.formats.naming import allowed_names, renamed, robot_name
from symkin.formats.parts import KEY, Parts, parts_from
from symkin.formats.robot import Closure, Mesh, Robot
from symkin.model.graph import LinkJoint
from symkin.model.joined import Joined
from symkin.model.joint import BASE, Joint
from symkin.model.joint_forms import JointType
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply
from symkin.text import first_of

_COINCIDE = 1e-9
"""Metres and radians: frames of one link that are this near need no constraint."""


class Reader:
    """The parts of a robot from a compiled model; `motors_told`: which joints are actuated is told
    elsewhere.
    """

    def __init__(self, compiled: CompiledModel, *, motors_told: bool = False) -> None:
        self.compiled, self.model, self.motors_told = compiled, compiled.model, motors_told
        self.notes: list[str] = []
        self.equalities = active_equalities(compiled, self.notes)
        self.held = held_values(compiled, self.equalities, self.notes)
        self.data = compiled.placed
        self.free = {
            int(self.model.jnt_bodyid[j]) for j in range(self.model.njnt) if self._type(j) == "free"
        }
        self.floating = self._floating()
        self.part_of = self._parts()
        self._name_everything()

    def robot(self) -> Robot:
        """The robot, with notes on what is left out."""
        model = self.model
        links = {BASE: self._base_frame()}
        merged: dict[str, tuple[str, Pose]] = {}
        for body in range(1, model.nbody):
            name, part = self.link_names[body], self._link(body)
            if self.part_of[body] == body:
                links[name] = self._frame(body)
            elif name != BASE:
                merged[name] = (part, self._frame(body))
        frames = {**links, **{name: frame for name, (_, frame) in merged.items()}}
        couplings = couplings_of(self.compiled, self.equalities, self.held, self.joint_names)
        follows = {c.joint for c in couplings.found.values()}
        joints = [
            entry for body in range(1, model.nbody) for entry in self._joints(body, links, follows)
        ]
        closures = [closure for equality in self.equalities for closure in self._closure(equality)]
        motors = () if self.motors_told else idle_actuators(self.compiled)
        return Robot(
            name=robot_name(self.compiled.name, self.compiled.path),
            links=links,
            joints=tuple(joints),
            closures=tuple(closures),
            couplings=tuple(couplings.found.values()),
            notes=(*self.notes, *couplings.notes, *without_kinematics(self.compiled), *motors),
            source=self.compiled.path.name,
            meshes=self._meshes(frames),
            floating=tuple(self.link_names[body] for body in self.floating),
            merged=merged,
            parts=self._told,
            turned=frozenset(self._told.turned),
        )

    @cached_property
    def _told(self) -> Parts:
        """What the file's text tells of joints."""
        return parts_from(self.compiled.text(KEY), f"{self.compiled.path}: <text name={KEY!r}>")

    # --- bodies -----------------------------------------------------------------------------------

    def _body_joints(self, body: int) -> list[int]:
        """The joints that carry a body, in their order, but held and free ones."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return [
            j for j in range(first, first + count) if j not in self.held and self._type(j) != "free"
        ]

    def _type(self, joint: int) -> str:
        return self.compiled.joint_type(joint)

    def _floating(self) -> list[int]:
        """Bodies with a free joint that closures join to the base, or to a body that is held: of
        bodies that hang together, the first with a free joint is held, for a robot stands
        somewhere.
        """
        model = self.model
        joined = Joined[int]()
        for body in range(1, model.nbody):
            if body not in self.free:
                joined.join(body, int(model.body_parentid[body]))
        for equality in self.equalities:
            if equality.kind in ("connect", "weld"):
                first, second = (body_of(self.compiled, equality, end) for end in (0, 1))
                joined.join(first, second)
        floating, still = list[int](), list[int]()
        for body in sorted(self.free):
            (still if joined.join(body, 0) else floating).append(body)
        if still:
            names = first_of([self.compiled.body_name(body) for body in still])
            self.notes.append(
                f"free joints are held where the file has them, and their bodies are part of the "
                f"base: {names}"
            )
        return floating

    def _parts(self) -> list[int]:
        """The body whose link each body is part of."""
        parts = [0]
        for body in range(1, self.model.nbody):
            moves = bool(self._body_joints(body)) or body in self.floating
            parts.append(body if moves else parts[int(self.model.body_parentid[body])])
        return parts

    def _name_everything(self) -> None:
        model = self.model
        bodies = {body: self.compiled.body_name(body) for body in range(1, model.nbody)}
        fixed = [body for body, name in bodies.items() if name == BASE and self.part_of[body] == 0]
        others = {body: name for body, name in bodies.items() if body not in fixed}
        names = allowed_names(others.values(), taken=[BASE])
        self.link_names = {
            0: BASE,
            **dict.fromkeys(fixed, BASE),
            **{body: names[name] for body, name in others.items()},
        }
        joints = {
            j: self.compiled.joint_name(j) or f"{bodies[int(model.jnt_bodyid[j])]}_joint{j}"
            for j in range(model.njnt)
        }
        joint_names = allowed_names(joints.values())
        self.joint_names = {j: joint_names[name] for j, name in joints.items()}
        self.notes += [*renamed("links", names), *renamed("joints", joint_names)]
        self.closure_names: dict[int, str] = {}
        used = set(joint_names.values())
        for equality in self.equalities:
            if equality.kind in ("connect", "weld"):
                ends = [self.link_names[body_of(self.compiled, equality, end)] for end in (0, 1)]
                own = (
                    self.compiled.names["equality"][equality.number]
                    or f"{equality.kind}_{ends[0]}_{ends[1]}"
                )
                number, name = 2, own
                while name in used:
                    number, name = number + 1, f"{own}_{number}"
                (self.closure_names[equality.number],) = allowed_names([name], used).values()
                used.add(self.closure_names[equality.number])

    def _link(self, body: int) -> str:
        """The link of which a body is part."""
        return self.link_names[self.part_of[body]]

    def _frame(self, body: int) -> Pose:
        return Pose(self.data.xpos[body].copy(), self.data.xquat[body].copy())

    def _base_frame(self) -> Pose:
        """The world's frame, or that of a body named base that stands still in it."""
        named = [body for body, name in self.link_names.items() if name == BASE and body]
        return self._frame(named[0]) if named else Pose.identity()

    def positions(
        self, joints: Mapping[str, float | Sequence[float]], poses: Mapping[str, Pose]
    ) -> np.ndarray:
        """MuJoCo's qpos for values of the robot's joints, and poses of the links that float."""
        model, found = self.model, np.array(self.data.qpos)
        for number, name in self.joint_names.items():
            place, kind = int(model.jnt_qposadr[number]), self._type(number)
            body = int(model.jnt_bodyid[number])
            if kind == "free" and body in self.floating:
                pose = poses[self.link_names[body]]
                found[place : place + 7] = [*pose.position, *pose.quaternion]
            elif kind == "ball" and name in joints:
                # from axes of the base frame, as symkin has them, to the body's own
                turn, value = self._frame(body).quaternion, np.asarray(joints[name])
                value = conjugate(value) if name in self._told.turned else value
                found[place : place + 4] = multiply(multiply(conjugate(turn), value), turn)
            elif name in joints:
                found[place] = joints[name]
        return found

    def _meshes(self, frames: Mapping[str, Pose]) -> dict[str, tuple[Mesh, ...]]:
        """The meshes of bodies, each once, in the frames of links and merged bodies."""
        found: dict[str, list[Mesh]] = {}
        shown: set[tuple[str, str, tuple[float, ...]]] = set()
        for geom, mesh in self.compiled.meshes.items():
            body = int(self.model.geom_bodyid[geom])
            name = self.link_names[body]
            pose = (
                frames[name].inverse()
                @ self._frame(body)
                @ self.compiled.geom_pose(geom)
                @ mesh.pose
            )
            numbers = tuple(
                float(x)
                for part in (pose.position, pose.quaternion, mesh.scale)
                for x in np.round(np.asarray(part), 9)
            )
            if (name, mesh.file, numbers) not in shown:
                shown.add((name, mesh.file, numbers))
                found.setdefault(name, []).append(replace(mesh, pose=pose))
        return {name: tuple(meshes) for name, meshes in found.items()}

    # --- joints -----------------------------------------------------------------------------------

    def _joints(self, body: int, links: dict[str, Pose], follows: set[str]) -> Iterator[LinkJoint]:
        """The joints of a body, with a link between each two of them."""
        numbers = self._body_joints(body)
        carrier = self._link(int(self.model.body_parentid[body]))
        for joint in numbers[:-1]:
            (between,) = allowed_names(
                [f"{self.link_names[body]}_{self.joint_names[joint]}"], set(links)
            ).values()
            links[between] = self._frame(body)
            yield LinkJoint(self._joint(joint, follows), (carrier, between))
            carrier = between
        if numbers:
            yield LinkJoint(self._joint(numbers[-1], follows), (carrier, self.link_names[body]))

    def _joint(self, number: int, follows: set[str]) -> Joint:
        model, name, kind = self.model, self.joint_names[number], self._type(number)
        types: dict[str, JointType] = {"hinge": "R", "slide": "P", "ball": "S"}
        scalar = kind != "ball"
        limits = None
        if model.jnt_limited[number]:
            limits = self._limits(number, name, scalar)
        point = tuple(map(float, self.data.xanchor[number]))
        if not scalar:
            return Joint(name, "S", point)
        return Joint(
            name,
            types[kind],
            point,
            axis=tuple(map(float, self.data.xaxis[number])),
            zero=float(self.data.qpos[model.jnt_qposadr[number]]),
            limits=limits,
            actuated=number in self._driven and name not in follows,
            motor=motor_at(self.compiled, number),
        )

    def _limits(self, number: int, name: str, scalar: bool) -> tuple[float, float] | None:
        low, high = map(float, self.model.jnt_range[number])
        if not scalar:
            self.notes.append(
                f"the cone of the ball joint {name!r} is left out: spherical joints have no limits "
                f"here"
            )
            return None
        return (low, high) if low < high else None

    @cached_property
    def _driven(self) -> set[int]:
        """Joints that actuators drive."""
        return driven(self.compiled)

    # --- closures ---------------------------------------------------------------------------------

    def _closure(self, equality: Equality) -> Iterator[Closure]:
        """The closure of a connect or a weld; none of one within a link."""
        if equality.kind not in ("connect", "weld"):
            return
        bodies = [body_of(self.compiled, equality, end) for end in (0, 1)]
        links = (self._link(bodies[0]), self._link(bodies[1]))
        first, second = (
            self._frame(body) @ frame
            for body, frame in zip(bodies, frames_on_bodies(self.compiled, equality), strict=True)
        )
        rigid = is_rigid(self.compiled, equality)
        if links[0] != links[1]:
            name = self.closure_names[equality.number]
            yield Closure(name, "weld" if rigid else "S", links, first, second, equality.where)
            return
        gap = first.inverse() @ second
        open_by = float(np.linalg.norm(gap.position)) + (
            float(np.linalg.norm(gap.quaternion[1:])) if rigid else 0.0
        )
        if open_by > _COINCIDE:
            raise MechanismError(
                f"{equality.where}: both of its bodies are part of the link {links[0]!r}, and "
                f"{open_by:.3g} apart; nothing closes it"
            )
        self.notes.append(
            f"{equality.where}: both of its bodies are part of the link {links[0]!r}, and it is "
            f"left out"
        )
