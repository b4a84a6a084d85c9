"""Write the rows of a closure, limb by limb, by the rules of where a loop is cut.

Each loop is cut at its passive joint of most freedom, and only what that joint constrains is written: two spherical
ends give one distance equation, a spherical end three, a universal or cylindrical end four, a revolute or prismatic
end five, none six. Every row has the dimension of a length: angular rows are multiplied by the mechanism's size.

Orientation rows are components of the vector part of a relative unit quaternion e = q_B* q_P. Its vector part vanishes
only where the two rotations are equal (that of R^T R' also vanishes for half turns), and its part normal to an axis a
only where e is a turn about a, so that these rows have no spurious roots and stay linear in the platform's quaternion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np

from symkin.closure.chain import Chain, JointSymbols, PlatformSide, Step
from symkin.closure.parameters import ParameterTable
from symkin.closure.pose_forms import HomogeneousPose, PlatformPose, StudyPose, UnitPose
from symkin.closure.snapping import snapped_constants
from symkin.model.dh import reference_frames
from symkin.model.joint import Coordinate, Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import cross, dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, rotate

_POSE_COORDINATES: dict[str, tuple[tuple[str, str], ...]] = {
    "spatial": (("x", "length"), ("y", "length"), ("z", "length"), ("quaternion", "quaternion")),
    "schoenflies": (("x", "length"), ("y", "length"), ("z", "length"), ("gamma", "angle")),
    "planar": (("x", "length"), ("y", "length"), ("gamma", "angle")),
    "translation": (("x", "length"), ("y", "length"), ("z", "length")),
    "spherical": (("quaternion", "quaternion"),),
}


PoseForm = Literal["study", "homogeneous"]
"""Algebraic forms of the pose: "study" where it is unknown, "homogeneous" where it is given."""


@dataclass(frozen=True, eq=False)
class ReplacedUniversalJoint:
    """A passive universal joint that one distance, from its centre to that of the spherical joint beyond it, replaces.

    Its angles follow from Turn(axis, first) Turn(axis2, second) arm = target, which has two solutions; `arm` and `target` are
    expressions of the known joints and the pose, in the frame before the universal joint."""

    coordinates: tuple[Coordinate, Coordinate]
    axis: ca.SX
    axis2: ca.SX
    arm: ca.SX
    target: ca.SX


@dataclass(frozen=True)
class Row:
    """Where a row of the closure comes from: the limb and the relation that its cut joint keeps."""

    limb: str
    relation: str


class RowBuilder:
    """Collects coordinates, parameters, rows and their checks while it walks a mechanism's limbs."""

    def __init__(
        self, mechanism: Mechanism, form: PoseForm | None = None, *,
        eliminate: bool = False, replace_universal: bool = True, bound: bool | None = None,
    ) -> None:  # fmt: skip
        self.mechanism = mechanism
        self.form = form if mechanism.motion in ("spatial", "spherical") else None
        self.eliminate = eliminate
        self.replace_universal = replace_universal
        self.table = ParameterTable(bound=form is not None if bound is None else bound)
        self.coordinates: dict[str, tuple[Coordinate, ca.SX]] = {}
        self.rows: list[ca.SX] = []
        self.sources: list[Row] = []
        self.errors: list[ca.SX] = []
        self.idle: list[str] = []
        self.distances: list[ca.SX] = []
        self.eliminated: list[tuple[Coordinate, ca.SX]] = []
        self.replaced_universal_joints: list[ReplacedUniversalJoint] = []
        self.forward: Pose | None = None

    def build_rows(self) -> None:
        m = self.mechanism
        joints, tool = self._geometry()
        joints = {name: [symbols.moved(self._shift(symbols.joint)) for symbols in chain] for name, chain in joints.items()}
        if self.table.bound:
            joints = {name: [symbols.snapped(m.characteristic_length) for symbols in chain] for name, chain in joints.items()}
            tool = Pose(snapped_constants(tool.position, m.characteristic_length), snapped_constants(tool.quaternion))
        self.limb_joints = joints
        self._declare_pose(tool)
        for limb in m.limbs:
            if isinstance(limb, RodLimb):
                self._rod_limb(limb)
            else:
                self._limb(limb, joints[limb.name])

    # --- geometry and pose ---------------------------------------------------------------------------------------

    def _geometry(self) -> tuple[dict[str, list[JointSymbols]], Pose]:
        """Joints of each limb and the platform's reference pose as expressions of the parameters."""
        m, table = self.mechanism, self.table
        if m.dh is not None:
            rows = []
            for k, row in enumerate(m.dh.rows, start=1):
                rows.append([table.scalar(f"dh.{k}.{key}", getattr(row, key)) for key in ("theta", "d", "a", "alpha")])
            frames, tool = reference_frames(m.dh.convention, rows)
            symbols = [
                JointSymbols(joint, ca.SX(point), ca.SX(axis), None, None, ca.SX(0))
                for (_, joint), (point, axis) in zip(m.joints, frames, strict=True)
            ]
            return {m.limbs[0].name: symbols}, Pose(ca.SX(tool.position), ca.SX(tool.quaternion))
        joints: dict[str, list[JointSymbols]] = {}
        for limb, joint in m.joints:
            path = joint.name if m.serial else f"{limb.name}.{joint.name}"
            joints.setdefault(limb.name, []).append(JointSymbols.declare(joint, path, table))
        frame = "tool" if m.serial else "platform"
        position = table.vector(f"{frame}.position", m.platform_position)
        quaternion = table.vector(f"{frame}.quaternion", m.platform_quaternion, "wxyz")
        return joints, Pose(position, quaternion / ca.sqrt(ca.dot(quaternion, quaternion)))

    def _shift(self, joint: Joint) -> float:
        """How far along its axis a joint's point is moved from where it is described; the joint is the same for any geometry."""
        away = self.mechanism.places[joint.name] - np.array(joint.point)
        return float(away @ np.array(joint.axis)) if away.any() else 0.0

    def _declare_pose(self, reference: Pose) -> None:
        self.reference = reference
        if self.form is not None:
            self._declare_algebraic_pose(reference)
            return
        m = self.mechanism
        values: dict[str, ca.SX] = {}
        nominal = {"x": 0, "y": 1, "z": 2}
        for name, kind in _POSE_COORDINATES[m.motion]:
            if name == "quaternion":
                start = m.platform_quaternion
            else:
                start = (m.platform_position[nominal[name]],) if name in nominal else (0.0,)
            coordinate = Coordinate(f"pose.{name}", kind, "pose", tuple(start))  # type: ignore[arg-type]
            values[name] = self._symbol(coordinate)
        position = ca.vertcat(*(values.get(name, reference.position[i]) for name, i in nominal.items()))
        if "quaternion" in values:
            quaternion = values["quaternion"]
        else:
            # a turn about the base frame's z axis, after the reference orientation
            half = 0.5 * values.get("gamma", ca.SX(0))
            quaternion = multiply(ca.vertcat(ca.cos(half), 0, 0, ca.sin(half)), reference.quaternion)
        self.pose = Pose(position, quaternion)
        self.platform_pose: PlatformPose = UnitPose(position, quaternion)

    def _declare_algebraic_pose(self, reference: Pose) -> None:
        e = ca.SX.sym("e", 4)
        if self.mechanism.motion == "spherical":
            self.pose_symbols, self.platform_pose = e, HomogeneousPose(reference.position, e)
        elif self.form == "study":
            g = ca.SX.sym("g", 4)
            self.pose_symbols, self.platform_pose = ca.vertcat(e, g), StudyPose(e, g)
        else:
            t = ca.SX.sym("t", 3)
            self.pose_symbols, self.platform_pose = ca.vertcat(t, e), HomogeneousPose(t, e)

    def _symbol(self, coordinate: Coordinate) -> ca.SX:
        symbol = ca.SX.sym(coordinate.name, coordinate.width)
        self.coordinates[coordinate.name] = (coordinate, symbol)
        return symbol

    def _steps(self, joints: Sequence[JointSymbols]) -> tuple[Step, ...]:
        steps: list[Step] = []
        for symbols in joints:
            values = []
            for coordinate in symbols.joint.coordinates:
                known = self.coordinates.get(coordinate.name)
                values.append(known[1] if known else self._symbol(coordinate))
            steps.extend(symbols.steps(values))
        return tuple(steps)

    # --- limbs ---------------------------------------------------------------------------------------------------

    def _add(self, limb: str, relation: str, rows: Sequence[ca.SX], errors: Sequence[ca.SX]) -> None:
        self.rows.extend(rows)
        self.sources.extend(Row(limb, relation) for _ in rows)
        self.errors.extend(errors)

    def _distance(self, limb: str, ends: tuple[ca.SX, ca.SX], length: ca.SX, length_squared: ca.SX | None = None) -> None:
        """N (d.d - length^2) / (2 size) = 0 for a platform point and a base point, checked as |d| - length."""
        squared = self.platform_pose.squared_distance(*ends)
        self.distances.append(ca.vertcat(length, ends[1], ends[0]))
        target = length * length if length_squared is None else length_squared
        # over 2 size the row is a length, and its derivative by the distance is distance / size, of the order of 1
        row = (squared - self.platform_pose.weight * target) / (2 * self.mechanism.characteristic_length)
        self._add(limb, "distance", [row], [ca.sqrt(squared) - length])

    def _rod_limb(self, limb: RodLimb) -> None:
        table = self.table
        base = table.vector(f"{limb.name}.base", limb.base)
        end = table.vector(f"{limb.name}.platform", limb.platform)
        offset = table.scalar(f"{limb.name}.offset", limb.offset)
        value = self._symbol(limb.coordinate(self.mechanism.reference_rod_value(limb)))
        self._distance(limb.name, (end, base), offset + value)
        self.idle.append(f"{limb.name}: spin of the rod" if limb.type == "SPS" else "")

    def _limb(self, limb: Limb, joints: list[JointSymbols]) -> None:
        if limb.rods:
            self._rods(limb, joints)
            return
        balls = [i for i, symbols in enumerate(joints) if symbols.joint.type == "S"]
        if len(balls) >= 2:
            self._two_balls(limb, joints, balls[0], balls[-1])
            return
        cut = _cut_index(joints)
        hinge = _replaceable_universal_joint(joints, cut) if self.form == "study" and self.replace_universal else None
        if hinge is not None and cut is not None:
            self._universal_as_distance(limb, joints, hinge, cut)
            return
        eliminated = cut is None and self.eliminate
        if eliminated:
            cut = _middle_turn(joints)
        base = Chain(self._steps(joints if cut is None else joints[:cut]))
        after = () if cut is None else self._steps(joints[cut + 1 :])
        platform = self._platform_side(after)
        if cut is None:
            self._none_cut(limb.name, base, platform)
        else:
            self._cut(limb.name, joints[cut], base, platform)
            if eliminated:
                self.eliminated.append(_angle_of_cut(joints[cut], base, platform))
                return
            self.idle.extend(f"{limb.name}: {c.name} (cut)" for c in joints[cut].joint.coordinates)

    def _rods(self, limb: Limb, joints: list[JointSymbols]) -> None:
        chain = Chain(self._steps(joints))
        for k, rod in enumerate(limb.rods, start=1):
            path = f"{limb.name}.rod{k}"
            start = self.table.vector(f"{path}.from", rod.start)
            end = self.table.vector(f"{path}.platform", rod.platform)
            at_reference = np.array(rod.start) - self.mechanism.reference_pose.apply(np.array(rod.platform))
            length = rod.length if rod.length is not None else float(np.linalg.norm(at_reference))
            self._distance(limb.name, (end, chain.move(start)), self.table.scalar(f"{path}.length", length))
            self.idle.append(f"{limb.name}: spin of rod {k}")

    def _two_balls(self, limb: Limb, joints: list[JointSymbols], first: int, last: int) -> None:
        base = Chain(self._steps(joints[:first])).move(joints[first].point)
        between = Chain(self._steps(joints[first + 1 : last])).move(joints[last].point) - joints[first].point
        after = self._steps(joints[last + 1 :])
        platform = self._platform_side(after)
        squared = dot(between, between)
        self._distance(limb.name, (platform.local(joints[last].point), base), ca.sqrt(squared), squared)
        self.idle.append(f"{limb.name}: {joints[first].joint.name}, {joints[last].joint.name} (cut)")

    def _universal_as_distance(self, limb: Limb, joints: list[JointSymbols], hinge: int, ball: int) -> None:
        """Universal joint, known joints, spherical joint: a distance between the centres."""
        before, symbols = Chain(self._steps(joints[:hinge])), joints[hinge]
        base = before.move(symbols.point)
        arm = Chain(self._steps(joints[hinge + 1 : ball])).move(joints[ball].point) - symbols.point
        platform = self._platform_side(self._steps(joints[ball + 1 :]))
        # the universal joint turns the arm about its centre: only the distance between the centres does not depend on its angles
        squared = dot(arm, arm)
        self._distance(limb.name, (platform.local(joints[ball].point), base), ca.sqrt(squared), squared)
        reach = platform.move(joints[ball].point) / platform.weight - base
        assert symbols.axis is not None and symbols.axis2 is not None  # noqa: S101, PT018 - a universal joint has both
        first, second = symbols.joint.coordinates
        target = rotate(conjugate(before.quaternion), reach)
        self.replaced_universal_joints.append(ReplacedUniversalJoint((first, second), symbols.axis, symbols.axis2, arm, target))

    def _platform_side(self, after: Sequence[Step]) -> PlatformSide:
        return PlatformSide(self.platform_pose, self.reference, tuple(step.inverse() for step in reversed(after)))

    def _none_cut(self, name: str, base: Chain, platform: PlatformSide) -> None:
        size, origin = self.mechanism.characteristic_length, self.reference.position
        gap = platform.move(origin) - platform.weight * base.move(origin)
        e = multiply(conjugate(base.quaternion), platform.quaternion)
        # the check compares whole rotation matrices, which no spurious root of the rows passes
        full = ca.vertcat(*(platform.direction(u) - base.direction(u) for u in _unit_vectors()))
        if all(c.role == "actuated" for step in self.limb_joints[name] for c in step.joint.coordinates):
            self.forward = Pose(base.move(origin), multiply(base.quaternion, self.reference.quaternion))
        self._add(
            name, "frame", [*ca.vertsplit(gap), *(2 * size * e[i] for i in (1, 2, 3))],
            [*ca.vertsplit(gap), *ca.vertsplit(size * full)],
        )  # fmt: skip

    def _cut(self, name: str, symbols: JointSymbols, base: Chain, platform: PlatformSide) -> None:
        size, point, axis = self.mechanism.characteristic_length, symbols.point, symbols.axis
        gap = platform.move(point) - platform.weight * base.move(point)
        kind = symbols.joint.type
        if kind in "SRU":
            self._add(name, "point", ca.vertsplit(gap), ca.vertsplit(gap))
        if kind == "S":
            return
        assert axis is not None  # noqa: S101 - every cut joint but S has an axis
        if kind == "U":
            # a universal joint keeps the angle between its two axes
            angle = dot(base.direction(axis), platform.direction(symbols.axis2)) - platform.weight * dot(axis, symbols.axis2)
            self._add(name, "axes' angle", [size * angle], [size * angle])
            return
        # e is parallel to the joint's axis: both components normal to it vanish
        u, v = _normals(axis, symbols.joint.axis)
        if kind in "CP":
            # the joint slides along its axis: only the gap across it is held
            offsets = [dot(base.direction(n), gap) for n in (u, v)]
            self._add(name, "line", offsets, offsets)
        e = multiply(conjugate(base.quaternion), platform.quaternion)
        if kind == "P":
            full = ca.vertcat(*(platform.direction(n) - base.direction(n) for n in _unit_vectors()))
            rows = [2 * size * e[i] for i in (1, 2, 3)]
            self._add(name, "orientation", rows, ca.vertsplit(size * full))
        else:
            parallel = platform.direction(axis) - base.direction(axis)
            rows = [2 * size * dot(e[1:], n) for n in (u, v)]
            self._add(name, "axis", rows, ca.vertsplit(size * parallel))

    # --- assembly ------------------------------------------------------------------------------------------------


def _unit_vectors() -> list[ca.SX]:
    return [ca.SX([1, 0, 0]), ca.SX([0, 1, 0]), ca.SX([0, 0, 1])]


def _normals(axis: ca.SX, nominal: Sequence[float] | None) -> tuple[ca.SX, ca.SX]:
    """Two unit vectors that make a right-handed frame with the axis, chosen at its nominal direction."""
    helper = [ca.SX(0)] * 3
    helper[int(np.argmin(np.abs(np.array(nominal))))] = ca.SX(1)
    u = cross(ca.vertcat(*helper), axis)
    u = u / ca.sqrt(dot(u, u))
    return u, cross(axis, u)


def _replaceable_universal_joint(joints: Sequence[JointSymbols], cut: int | None) -> int | None:
    """The only passive joint before a spherical cut, if it is universal."""
    if cut is None or joints[cut].joint.type != "S":
        return None
    passive = [i for i, symbols in enumerate(joints) if not symbols.joint.actuated and i != cut]
    return passive[0] if len(passive) == 1 and passive[0] < cut and joints[passive[0]].joint.type == "U" else None


def _angle_of_cut(symbols: JointSymbols, base: Chain, platform: PlatformSide) -> tuple[Coordinate, ca.SX]:
    """Coordinate of a revolute joint that was cut: e = q_B* q_P is a turn about its axis, tan(angle / 2) = a.e / e_0."""
    e = multiply(conjugate(base.quaternion), platform.quaternion)
    return symbols.joint.coordinates[0], 2 * ca.atan2(dot(symbols.axis, e[1:]), e[0]) + symbols.zero


def _middle_turn(joints: Sequence[JointSymbols]) -> int | None:
    """The revolute joint nearest the middle of a limb: cut there, an unknown joint leaves the rows, and both sides are
    short. None where it is the only joint: then nothing would be left to solve for."""
    if len(joints) == 1:
        return None
    turns = [i for i, symbols in enumerate(joints) if symbols.joint.type == "R"]
    return min(turns, key=lambda i: abs(2 * i - len(joints) + 1), default=None)


def _cut_index(joints: Sequence[JointSymbols]) -> int | None:
    """The passive joint of most freedom, the last of equals; helical joints are never cut (their angle stays)."""
    best: int | None = None
    for i, symbols in enumerate(joints):
        joint = symbols.joint
        if joint.actuated or joint.type == "H":
            continue
        # >= takes the last of equals, so that the chain from the base is the longer one
        if best is None or joint.freedom >= joints[best].joint.freedom:
            best = i
    return best
