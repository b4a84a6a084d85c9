"""From MuJoCo's compiled model to a robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import MechanismError
from symkin.formats.couplings import CouplingSet, LinearEquation
from symkin.formats.naming import allowed_names, renamed, robot_name
from symkin.formats.parts import KEY, Parts, parts_from
from symkin.formats.robot import Closure, ClosureType, Robot
from symkin.formats.xml_text import Element
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Joint, JointType
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply
from symkin.text import first_of

_COINCIDE = 1e-9
"""Metres and radians: frames of one link that are this near need no constraint."""
_NO_NAME = "MuJoCo Model"
"""What the compiler calls a model without a name."""


@dataclass(frozen=True)
class _Equality:
    """An active equality constraint: its type's name, its number in the model, its two objects (-1: none), and its place."""

    kind: str
    number: int
    objects: tuple[int, int]
    where: str


class Reader:
    """The parts of a robot from a compiled model at qpos0, joints that are held at a value moved there."""

    def __init__(self, mujoco: ModuleType, model: Any, root: Element, path: Path, meshes: dict[str, tuple[str, ...]]) -> None:
        self.mujoco, self.model, self.root, self.path, self.meshes = mujoco, model, root, path, meshes
        self.notes: list[str] = []
        self.equalities = list(self._active_equalities())
        self.held = self._held_values()
        self.data = mujoco.MjData(model)
        for joint, value in self.held.items():
            self.data.qpos[model.jnt_qposadr[joint]] = value
        mujoco.mj_kinematics(model, self.data)
        self.free = {int(model.jnt_bodyid[j]) for j in range(model.njnt) if self._type(j) == "free"}
        self.floating = self._floating()
        self.part_of = self._parts()
        self._name_everything()

    def robot(self) -> Robot:
        model = self.model
        links = {BASE: self._base_frame()}
        merged: dict[str, tuple[str, Pose]] = {}
        for body in range(1, model.nbody):
            name, part = self.link_names[body], self._link(body)
            if self.part_of[body] == body:
                links[name] = self._frame(body)
            elif name != BASE:
                merged[name] = (part, self._frame(body))
        couplings = self._couplings()
        follows = {c.joint for c in couplings.found.values()}
        joints = [entry for body in range(1, model.nbody) for entry in self._joints(body, links, follows)]
        closures = [closure for equality in self.equalities for closure in self._closure(equality)]
        return Robot(
            name=robot_name(None if self._model_name == _NO_NAME else self._model_name, self.path),
            links=links,
            joints=tuple(joints),
            closures=tuple(closures),
            couplings=tuple(couplings.found.values()),
            notes=(*self.notes, *couplings.notes, *self._no_kinematics()),
            source=self.path.name,
            meshes={
                self.link_names[b]: self.meshes[n] for b in range(1, model.nbody) if (n := model.body(b).name) in self.meshes
            },
            floating=tuple(self.link_names[body] for body in self.floating),
            merged=merged,
            parts=self._told_parts(),
        )

    def _told_parts(self) -> Parts:
        """Which joints are parts of one, as the text of this name tells."""
        model, data = self.model, b""
        for name, first, size in zip(model.name_textadr, model.text_adr, model.text_size, strict=True):
            if bytes(model.names)[int(name) :].split(b"\0", 1)[0] == KEY.encode():
                data = bytes(model.text_data)[int(first) : int(first) + int(size)]
        return parts_from(data.rstrip(b"\0").decode("utf-8", "replace"), f"{self.path}: <text name={KEY!r}>")

    # --- bodies --------------------------------------------------------------------------------------------------------

    @property
    def _model_name(self) -> str:
        names = self.model.names
        return bytes(names).split(b"\0", 1)[0].decode("utf-8", "replace")

    def _body_joints(self, body: int) -> list[int]:
        """The joints that carry a body, in their order, but held and free ones."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return [j for j in range(first, first + count) if j not in self.held and self._type(j) != "free"]

    def _type(self, joint: int) -> str:
        return str(self.mujoco.mjtJoint(int(self.model.jnt_type[joint])).name).removeprefix("mjJNT_").lower()

    def _floating(self) -> list[int]:
        """Bodies with a free joint that closures join to the base, or to a body that is held: of bodies that hang together, the first
        with a free joint is held, for a robot stands somewhere."""
        model = self.model
        heads = list(range(model.nbody))

        def head(body: int) -> int:
            while heads[body] != body:
                body = heads[body]
            return body

        for body in range(1, model.nbody):
            if body not in self.free:
                heads[head(body)] = head(int(model.body_parentid[body]))
        for equality in self.equalities:
            if equality.kind in ("connect", "weld"):
                first, second = (self._body_of(equality, end) for end in (0, 1))
                heads[head(first)] = head(second)
        floating, still = [], []
        for body in sorted(self.free):
            if head(body) == head(0):
                floating.append(body)
            else:
                still.append(body)
                heads[head(body)] = head(0)
        if still:
            names = first_of([model.body(body).name or f"body{body}" for body in still])
            self.notes.append(f"free joints are held where the file has them, and their bodies are part of the base: {names}")
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
        bodies = {body: model.body(body).name or f"body{body}" for body in range(1, model.nbody)}
        fixed = [body for body, name in bodies.items() if name == BASE and self.part_of[body] == 0]
        others = {body: name for body, name in bodies.items() if body not in fixed}
        names = allowed_names(others.values(), taken=[BASE])
        self.link_names = {0: BASE, **dict.fromkeys(fixed, BASE), **{body: names[name] for body, name in others.items()}}
        joints = {j: model.joint(j).name or f"{bodies[int(model.jnt_bodyid[j])]}_joint{j}" for j in range(model.njnt)}
        joint_names = allowed_names(joints.values())
        self.joint_names = {j: joint_names[name] for j, name in joints.items()}
        self.notes += [*renamed("links", names), *renamed("joints", joint_names)]
        self.closure_names: dict[int, str] = {}
        used = set(joint_names.values())
        for equality in self.equalities:
            if equality.kind in ("connect", "weld"):
                ends = [self.link_names[self._body_of(equality, end)] for end in (0, 1)]
                own = model.equality(equality.number).name or f"{equality.kind}_{ends[0]}_{ends[1]}"
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

    def positions(self, joints: Mapping[str, float | Sequence[float]], poses: Mapping[str, Pose]) -> np.ndarray:
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
                turn = self._frame(body).quaternion
                found[place : place + 4] = multiply(multiply(conjugate(turn), np.asarray(joints[name])), turn)
            elif name in joints:
                found[place] = joints[name]
        return found

    # --- joints --------------------------------------------------------------------------------------------------------

    def _joints(self, body: int, links: dict[str, Pose], follows: set[str]) -> Iterator[LinkJoint]:
        """The joints of a body, with a link between each two of them."""
        numbers = self._body_joints(body)
        carrier = self._link(int(self.model.body_parentid[body]))
        for joint in numbers[:-1]:
            (between,) = allowed_names([f"{self.link_names[body]}_{self.joint_names[joint]}"], set(links)).values()
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
        )

    def _limits(self, number: int, name: str, scalar: bool) -> tuple[float, float] | None:
        low, high = map(float, self.model.jnt_range[number])
        if not scalar:
            self.notes.append(f"the cone of the ball joint {name!r} is left out: spherical joints have no limits here")
            return None
        return (low, high) if low < high else None

    @cached_property
    def _driven(self) -> set[int]:
        """Joints that actuators drive."""
        return {joint for k in range(self.model.nu) for joint in self._driven_by(k)}

    def _driven_by(self, actuator: int) -> list[int]:
        """Hinges and slides that an actuator drives, directly or through a fixed tendon."""
        model, transmissions = self.model, self.mujoco.mjtTrn
        kind, target = int(model.actuator_trntype[actuator]), int(model.actuator_trnid[actuator][0])
        joints: list[int] = []
        if kind in (int(transmissions.mjTRN_JOINT), int(transmissions.mjTRN_JOINTINPARENT)):
            joints = [target]
        elif kind == int(transmissions.mjTRN_TENDON):
            joints = [joint for joint, _ in self._tendon(target) or ()]
        return [joint for joint in joints if self._type(joint) in ("hinge", "slide")]

    # --- equality constraints --------------------------------------------------------------------------------------------

    def _active_equalities(self) -> Iterator[_Equality]:
        model = self.model
        written = [e for section in self.root.all("equality") for e in section.children]
        for k in range(model.neq):
            kind = str(self.mujoco.mjtEq(int(model.eq_type[k])).name).removeprefix("mjEQ_").lower()
            # of included and of multiplied elements the place is not known
            where = (
                written[k].where
                if len(written) == model.neq
                else f"{self.path}: <{kind}> number {k + 1} of the equality constraints"
            )
            found = _Equality(kind, k, (int(model.eq_obj1id[k]), int(model.eq_obj2id[k])), where)
            if not model.eq_active0[k]:
                self.notes.append(f"{where}: it is not active, and left out")
            elif kind in ("connect", "weld") and any(model.body_mocapid[self._body_of(found, end)] >= 0 for end in (0, 1)):
                self.notes.append(f"{where}: it joins a mocap body, which is moved from outside, and is left out")
            else:
                yield found

    def _held_values(self) -> dict[int, float]:
        """Joints that an equality holds at a value."""
        found: dict[int, float] = {}
        for equality in self.equalities:
            joint, other = equality.objects
            if equality.kind == "joint" and other < 0:
                value = float(self.model.qpos0[self.model.jnt_qposadr[joint]] + self.model.eq_data[equality.number][0])
                name = self.model.joint(joint).name
                if found.get(joint, value) != value:
                    raise MechanismError(f"{equality.where}: the joint {name!r} is held at two values")
                found[joint] = value
                self.notes.append(
                    f"the joint {name!r} is held at {value:g} by an equality: its link is part of the one that carries it"
                )
        return found

    def _body_of(self, equality: _Equality, end: int) -> int:
        number = equality.objects[end]
        if int(self.model.eq_objtype[equality.number]) == int(self.mujoco.mjtObj.mjOBJ_SITE):
            return int(self.model.site_bodyid[number])
        return max(number, 0)

    def _closure(self, equality: _Equality) -> Iterator[Closure]:
        """The closure of a connect or a weld; none of one within a link."""
        if equality.kind in ("joint", "tendon"):
            return
        if equality.kind not in ("connect", "weld"):
            raise MechanismError(
                f"{equality.where}: {equality.kind} constraints are not kinematics of links; take it out, or make it inactive"
            )
        bodies = [self._body_of(equality, end) for end in (0, 1)]
        links = (self._link(bodies[0]), self._link(bodies[1]))
        first, second = self._frames(equality, bodies)
        rigid = equality.kind == "weld" and float(self.model.eq_data[equality.number][10]) != 0.0
        kind: ClosureType = "weld" if rigid else "S"
        name = self.closure_names[equality.number]
        if links[0] != links[1]:
            yield Closure(name, kind, links, first, second, equality.where)
            return
        gap = first.inverse() @ second
        open_by = float(np.linalg.norm(gap.position)) + (float(np.linalg.norm(gap.quaternion[1:])) if rigid else 0.0)
        if open_by > _COINCIDE:
            raise MechanismError(
                f"{equality.where}: both of its bodies are part of the link {links[0]!r}, and {open_by:.3g} apart; nothing closes it"
            )
        self.notes.append(f"{equality.where}: both of its bodies are part of the link {links[0]!r}, and it is left out")

    def _frames(self, equality: _Equality, bodies: list[int]) -> tuple[Pose, Pose]:
        """The frames of a connect or weld on its two bodies, as `mj_instantiateEqual` takes them."""
        numbers = self.model.eq_data[equality.number]
        if int(self.model.eq_objtype[equality.number]) == int(self.mujoco.mjtObj.mjOBJ_SITE):
            return self._site_frame(equality.objects[0]), self._site_frame(equality.objects[1])
        first, second = (self._frame(body) for body in bodies)
        if equality.kind == "connect":
            return tuple(
                f @ Pose(numbers[3 * k : 3 * k + 3].copy(), np.array([1.0, 0, 0, 0])) for k, f in enumerate((first, second))
            )  # type: ignore[return-value]
        turn = numbers[6:10] / np.linalg.norm(numbers[6:10])
        return first @ Pose(numbers[3:6].copy(), turn), second @ Pose(numbers[0:3].copy(), np.array([1.0, 0, 0, 0]))

    def _site_frame(self, site: int) -> Pose:
        model = self.model
        return self._frame(int(model.site_bodyid[site])) @ Pose(model.site_pos[site].copy(), model.site_quat[site].copy())

    # --- couplings -------------------------------------------------------------------------------------------------------

    def _couplings(self) -> CouplingSet:
        found = CouplingSet()
        for equality in self.equalities:
            if equality.kind == "joint" and equality.objects[1] >= 0:
                first, second = ([(joint, 1.0)] for joint in equality.objects)
            elif equality.kind == "tendon":
                first, second = (self._tendon_of(equality, end) for end in (0, 1))
            else:
                continue
            self._couple(found, equality, first, second)
        return found

    def _couple(
        self, found: CouplingSet, equality: _Equality, first: list[tuple[int, float]], second: list[tuple[int, float]]
    ) -> None:
        """first - first0 = c0 + c1 d + c2 d^2 + ..., d = second - second0, both from qpos0."""
        coefficients = [float(c) for c in self.model.eq_data[equality.number][:5]]
        while len(coefficients) > 2 and coefficients[-1] == 0.0:
            coefficients.pop()
        start, other = (sum(f * self._at_qpos0(j) for j, f in terms) for terms in (first, second))
        moving = [(j, f) for j, f in (*first, *second) if j not in self.held]
        if len(coefficients) <= 2:
            slope = coefficients[1] if second else 0.0
            terms = {self.joint_names[j]: 0.0 for j, _ in moving}
            constant = coefficients[0] + start - slope * other
            for j, factor in [*first, *((j, -slope * f) for j, f in second)]:
                if j in self.held:
                    constant -= factor * self.held[j]
                else:
                    terms[self.joint_names[j]] += factor
            if any(terms.values()):
                found.add_linear(LinearEquation(terms, constant, equality.where))
        elif len(first) == len(second) == 1 and len(moving) == 2:
            (joint, own), (of, factor) = first[0], second[0]
            inner = np.polynomial.Polynomial([-other, factor])
            polynomial = (np.polynomial.Polynomial(coefficients)(inner) + start) / own
            found.add_polynomial(
                self.joint_names[joint], self.joint_names[of], [float(c) for c in polynomial.coef], equality.where
            )
        else:
            raise MechanismError(
                f"{equality.where}: a polynomial of more than one joint, or of a held one, is not read; write it linearly"
            )

    def _at_qpos0(self, joint: int) -> float:
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])

    def _tendon_of(self, equality: _Equality, end: int) -> list[tuple[int, float]]:
        """Joints and factors of one of the two tendons; none where there is no second."""
        number = equality.objects[end]
        if number < 0:
            return []
        found = self._tendon(number)
        if found is None:
            raise MechanismError(
                f"{equality.where}: its tendon {self.model.tendon(number).name!r} is a spatial one; only fixed tendons are read"
            )
        return found

    def _tendon(self, number: int) -> list[tuple[int, float]] | None:
        """Joints and factors of a fixed tendon; None of a spatial one."""
        model = self.model
        first, count = int(model.tendon_adr[number]), int(model.tendon_num[number])
        if any(int(model.wrap_type[k]) != int(self.mujoco.mjtWrap.mjWRAP_JOINT) for k in range(first, first + count)):
            return None
        return [(int(model.wrap_objid[k]), float(model.wrap_prm[k])) for k in range(first, first + count)]

    def _no_kinematics(self) -> Iterator[str]:
        """What of the file has no meaning here."""
        model = self.model
        spatial = sum(self._tendon(k) is None for k in range(model.ntendon))
        counts = {"spatial tendon": spatial, "contact pair": model.npair, "flex": model.nflex, "sensor": model.nsensor}
        named = [f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items() if count]
        if named:
            yield f"left out, since it moves no link by itself: {', '.join(named)}"
        idle = [model.actuator(k).name or f"number {k + 1}" for k in range(model.nu) if not self._driven_by(k)]
        if idle:
            yield f"actuators that drive no hinge or slide, directly or by a fixed tendon, are left out: {first_of(idle)}"
        if not model.nu:
            yield "the file has no actuator: no joint is actuated, and values are given by name"
