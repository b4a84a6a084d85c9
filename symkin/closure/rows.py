"""Write the rows of a closure, branch by branch, by the rules of where a loop is cut.

Each loop is cut at its passive joint of most freedom, and only what that joint constrains is written: two spherical
ends give one distance equation, a spherical end three, a universal or cylindrical end four, a revolute or prismatic
end five, none six. Every row has the dimension of a length: angular rows are multiplied by the mechanism's size.

Orientation rows are components of the vector part of a relative unit quaternion e = q_B* q_P. Its vector part vanishes
only where the two rotations are equal (that of R^T R' also vanishes for half turns), and its part normal to an axis a
only where e is a turn about a, so that these rows have no spurious roots and stay linear in the platform's quaternion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np

from symkin.closure.branches import Bar, Branch, Element, layout_of
from symkin.closure.chain import Chain, JointSymbols, PlatformSide, Side, Step, relative_sides
from symkin.closure.parameters import ParameterTable
from symkin.closure.pose_forms import HomogeneousPose, PlatformPose, StudyPose, UnitPose
from symkin.closure.snapping import snapped_constants
from symkin.closure.tilt_torsion import rotation_conditions, tilt_and_torsion
from symkin.model.dh import reference_frames
from symkin.model.joint import BASE, PLATFORM, Coordinate, Joint
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import cross, dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, rotate

POSE_COORDINATES: dict[str, tuple[tuple[str, str], ...]] = {
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
class Partition:
    """What a closure must hold, for what is given: joint coordinates by name (`kept`), and whether the platform of a graph has
    pose coordinates; `pose_conditions` are coordinates of its pose that are given one by one (see `POSE_CONDITIONS`), as variables
    with rows of their own; with `geometry`, points and lengths are known coordinates too. Any closure holds the actuated joints and those that couplings name."""

    kept: frozenset[str] = frozenset()
    pose: bool = False
    pose_conditions: tuple[str, ...] = ()
    geometry: bool = False


POSE_CONDITIONS = ("x", "y", "z", "azimuth", "tilt", "torsion")
"""Coordinates of the platform's pose that are given one by one: position, and the rotation Rz(azimuth) Ry(tilt) Rz(torsion -
azimuth) from the base frame (Bonev, Zlatanov, Gosselin, ASME J. Mech. Des. 124, 2002)."""
ALL_JOINTS = Partition()
"""No more than any closure holds."""


@dataclass(frozen=True)
class Row:
    """Where a row of the closure comes from: the limb and the relation that its cut joint keeps."""

    limb: str
    relation: str


class RowBuilder:
    """Collects coordinates, parameters, rows and their checks while it walks a mechanism's branches.

    `kept` names joint coordinates that the closure must hold, whichever joint a loop is best cut at; `pose` says whether the
    platform of a graph has coordinates of its own, which that of limbs always has.
    """

    def __init__(
        self, mechanism: Mechanism, form: PoseForm | None = None, *, eliminate: bool = False, replace_universal: bool = True,
        bound: bool | None = None, partition: Partition = ALL_JOINTS, body_forms: Mapping[str, PoseForm] | None = None,
    ) -> None:  # fmt: skip
        self.mechanism = mechanism
        self.form = form if mechanism.motion in ("spatial", "spherical") else None
        self.body_forms = dict(body_forms or {})
        self.body_symbols: dict[str, ca.SX] = {}
        self.eliminate = eliminate
        self.replace_universal = replace_universal
        self.partition = partition
        self.kept = partition.kept | {n for c in mechanism.couplings for n in (c.joint, *c.names)}
        self.layout = layout_of(mechanism, self.kept, pose=partition.pose)
        self.table = ParameterTable(bound=form is not None if bound is None else bound)
        self.kinds = {c.name: c for c in mechanism.coordinates}
        self.coordinates: dict[str, tuple[Coordinate, ca.SX]] = {}
        self.rows: list[ca.SX] = []
        self.sources: list[Row] = []
        self.errors: list[ca.SX] = []
        self.idle: list[str] = []
        self.distances: list[ca.SX] = []
        self.eliminated: list[tuple[Coordinate, ca.SX]] = []
        self.replaced_universal_joints: list[ReplacedUniversalJoint] = []
        self.forward: Pose | None = None
        self.arm: Side = Chain(())
        self.bodies: dict[str, Side] = {BASE: Chain(())}
        self.links: dict[str, Side] = {}

    def build_rows(self) -> None:
        m = self.mechanism
        joints, tool = self._geometry()
        joints = {name: symbols.moved(self._shift(symbols.joint)) for name, symbols in joints.items()}
        if self.table.bound:
            joints = {name: symbols.snapped(m.characteristic_length) for name, symbols in joints.items()}
            tool = Pose(snapped_constants(tool.position, m.characteristic_length), snapped_constants(tool.quaternion))
        self.joints = joints
        self.reference = tool
        self._declare_bodies()
        for branch in self.layout.branches:
            if branch.carries:
                self._carry(branch)
            else:
                self._close(branch)
        self._couple()
        self._place_platform()
        self._condition_pose()

    # --- geometry and pose ---------------------------------------------------------------------------------------

    def _geometry(self) -> tuple[dict[str, JointSymbols], Pose]:
        """Joints by name and the platform's reference pose as expressions of the parameters."""
        m, table = self.mechanism, self.table
        if m.dh is not None:
            rows = []
            for k, row in enumerate(m.dh.rows, start=1):
                rows.append([table.scalar(f"dh.{k}.{key}", getattr(row, key)) for key in ("theta", "d", "a", "alpha")])
            frames, tool = reference_frames(m.dh.convention, rows)
            symbols = {
                joint.name: JointSymbols(joint, ca.SX(point), ca.SX(axis), None, None, ca.SX(0))
                for joint, (point, axis) in zip(m.all_joints, frames, strict=True)
            }
            return symbols, Pose(ca.SX(tool.position), ca.SX(tool.quaternion))
        paths = {element.name: element.path for branch in self.layout.branches for element in branch.elements}
        joints = {j.name: JointSymbols.declare(j, paths[j.name], table) for j in m.all_joints if j.type != "weld"}
        frame = "tool" if m.serial else "platform"
        position = table.vector(f"{frame}.position", m.platform_position)
        quaternion = table.vector(f"{frame}.quaternion", m.platform_quaternion, "wxyz")
        return joints, Pose(position, quaternion / ca.sqrt(ca.dot(quaternion, quaternion)))

    def _shift(self, joint: Joint) -> float:
        """How far along its axis a joint's point is moved from where it is described; the joint is the same for any geometry."""
        away = self.mechanism.places[joint.name] - np.array(joint.point)
        return float(away @ np.array(joint.axis)) if away.any() else 0.0

    def _declare_bodies(self) -> None:
        """Poses of the bodies that float: the platform's first."""
        for body in self.layout.floating:
            if body in self.body_forms:
                self.bodies[body] = self._declare_algebraic_body(body)
            elif body == self._platform:
                self._declare_pose(self.reference)
                self.bodies[body] = PlatformSide(self.platform_pose, self.reference)
            else:
                self.bodies[body] = self._declare_body(body)

    @property
    def _platform(self) -> str | None:
        return self.mechanism.platform_link if self.mechanism.is_graph else PLATFORM

    def _declare_algebraic_body(self, body: str) -> PlatformSide:
        """A floating body in Study coordinates (e; g), or by position and a quaternion of any length."""
        e = ca.SX.sym(f"{body}.e", 4)
        reference = self.reference if body == self._platform else Pose(ca.SX(self._middle(body)), ca.SX([1, 0, 0, 0]))
        if self.body_forms[body] == "study":
            g = ca.SX.sym(f"{body}.g", 4)
            self.body_symbols[body] = ca.vertcat(e, g)
            return PlatformSide(StudyPose(e, g), reference)
        t = ca.SX.sym(f"{body}.t", 3)
        self.body_symbols[body] = ca.vertcat(t, e)
        return PlatformSide(HomogeneousPose(t, e), reference)

    def _middle(self, body: str) -> np.ndarray:
        """The middle of a body's joint points at the reference."""
        ends = [_end_of(branch, body) for branch in self.layout.branches if body in branch.ends]
        return np.asarray(np.mean([self._place(element, first=first) for element, first in ends], axis=0))

    def _declare_body(self, body: str) -> PlatformSide:
        """A floating body by the position of the middle of its joints' points and its turn from the reference."""
        middle = self._middle(body)
        values = {
            f"{body}.{key}": Coordinate(f"{body}.{key}", "length", "body", (float(value),))
            for key, value in zip("xyz", middle, strict=True)
        }
        turn = Coordinate(f"{body}.quaternion", "quaternion", "body", (1.0, 0.0, 0.0, 0.0))
        position = ca.vertcat(*(self._symbol(c) for c in values.values()))
        return PlatformSide(UnitPose(position, self._symbol(turn)), Pose(ca.SX(middle), ca.SX([1, 0, 0, 0])))

    def _place(self, element: Element, *, first: bool) -> np.ndarray:
        """Where a joint or the end of a rod is at the reference, the end that is nearer to the branch's first body or not."""
        if isinstance(element.part, Joint):
            return self.mechanism.places[element.name]
        end = element.part.start if first == element.along else element.part.end
        point = np.array(end.point)
        return np.asarray(self.mechanism.reference_pose.apply(point)) if end.in_platform_frame else point

    def _declare_pose(self, reference: Pose) -> None:
        if self.form is not None:
            self._declare_algebraic_pose(reference)
            return
        m = self.mechanism
        values: dict[str, ca.SX] = {}
        nominal = {"x": 0, "y": 1, "z": 2}
        for name, kind in POSE_COORDINATES[m.motion]:
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

    def _place_platform(self) -> None:
        """The pose of a platform that the joints carry, as an expression of theirs; the base's frame where there is none."""
        platform = self._platform
        if platform in self.layout.floating:
            if platform in self.body_forms:
                self.platform_pose = self.bodies[platform].pose  # type: ignore[union-attr]
            return
        if platform is None:
            self.pose = Pose(ca.SX(3, 1), ca.SX([1, 0, 0, 0]))
            return
        side = self._link(platform)
        self.pose = Pose(side.move(self.reference.position), multiply(side.quaternion, self.reference.quaternion))
        self.platform_pose = UnitPose(ca.SX(self.pose.position), ca.SX(self.pose.quaternion))

    def _condition_pose(self) -> None:
        """Rows for the coordinates of the pose that are given one by one."""
        names = self.partition.pose_conditions
        if not names:
            return
        reference, size = self.mechanism.reference_pose, self.mechanism.characteristic_length
        angles = tilt_and_torsion(np.asarray(reference.quaternion))
        nominal = dict(zip(POSE_CONDITIONS, (*np.asarray(reference.position).tolist(), *angles), strict=True))
        values = {n: self._symbol(Coordinate(n, "length" if n in "xyz" else "angle", "given", (nominal[n],))) for n in names}
        pose = self.platform_pose
        place = pose.point(ca.SX(3, 1))
        rows = [pose.weight * values[n] - place["xyz".index(n)] for n in names if n in "xyz"]
        turns, checks = rotation_conditions(pose.quaternion, values)
        rows, checks = [*rows, *(size * row for row in turns)], [*rows, *(size * check for check in checks)]
        self._add("platform", "given", rows, checks)

    def _link(self, link: str) -> Side:
        """Where a link is; one within a branch is placed from the branch's first body."""
        return self.bodies[link] if link in self.bodies else self.links[link]

    def _symbol(self, coordinate: Coordinate) -> ca.SX:
        symbol = ca.SX.sym(coordinate.name, coordinate.width)
        self.coordinates[coordinate.name] = (coordinate, symbol)
        return symbol

    def _steps(self, elements: Sequence[Element]) -> tuple[Step, ...]:
        """What the joints of a part of a branch do, from its first link to its last."""
        steps: list[Step] = []
        for element in elements:
            if element.name not in self.joints:
                continue
            symbols, values = self.joints[element.name], []
            for name in (c.name for c in symbols.joint.coordinates):
                coordinate, known = self.kinds[name], self.coordinates.get(name)
                values.append(known[1] if known else self._symbol(coordinate))
            moved = symbols.steps(values)
            steps.extend(moved if element.along else (step.inverse() for step in reversed(moved)))
        return tuple(steps)

    def chain_of(self, elements: Sequence[Element]) -> Chain:
        """The joints of a part of a branch, once rows are built, as if they began at the base."""
        return Chain(self._steps(elements))

    def _from_first(self, branch: Branch, count: int) -> Side:
        """Where the link behind the first `count` elements of a branch is, from the branch's first body; all links before it
        are noted."""
        side = self.bodies[branch.ends[0]]
        for k in range(count):
            side = side.extended(self._steps(branch.elements[k : k + 1]))
            if k < len(branch.links):
                self.links[branch.links[k]] = side
        return side

    def _from_last(self, branch: Branch, first: int) -> Side:
        """Where the link before the element `first` is, from the branch's last body; all links behind it are noted."""
        side, elements = self.bodies[branch.ends[1]], branch.elements
        # coordinates are declared from the base outward
        self._steps(elements[first:])
        for k in reversed(range(first, len(elements))):
            side = side.extended(tuple(step.inverse() for step in reversed(self._steps(elements[k : k + 1]))))
            self.links[branch.links[k - 1]] = side
        return side

    def declare_geometry(self) -> None:
        """Make coordinates of the lengths and the components of points on which the rows depend."""
        rows, table = ca.vertcat(*self.rows), self.table
        for name, symbol, value in zip(table.names, table.symbols, table.values, strict=True):
            if name.rsplit(".", 2)[-2:-1] in (["axis"], ["axis2"]) or name.endswith((".zero", ".pitch", ".w")):
                continue
            if "quaternion" not in name and any(ca.which_depends(rows, symbol, 1, True)):
                self.coordinates[name] = (Coordinate(name, "length", "geometry", (value,)), symbol)

    # --- branches ------------------------------------------------------------------------------------------------

    def _carry(self, branch: Branch) -> None:
        self.bodies[branch.ends[1]] = self._from_first(branch, len(branch.elements))

    def _couple(self) -> None:
        """A row for each coupling: angles times the size. Where whole turns leave it as it is, the row vanishes at all of them."""
        size, angles = self.mechanism.characteristic_length, {c.name for c in self.kinds.values() if c.kind == "angle"}
        for coupling in self.mechanism.couplings:
            coordinate, value = self.coordinates[coupling.joint]
            if coupling.polynomial is not None:
                (name,) = coupling.names
                wanted = sum((c * self.coordinates[name][1] ** k for k, c in enumerate(coupling.polynomial)), ca.SX(0))
            else:
                wanted = sum((factor * self.coordinates[name][1] for name, factor in coupling.terms), ca.SX(coupling.offset))
            gap = value - wanted
            if coupling.is_periodic(angles):
                gap = 2 * ca.sin(0.5 * gap)
            gap = gap * (size if coordinate.is_angular else 1.0)
            self._add(f"coupling of {coupling.joint}", "coupling", [gap], [gap])

    def _add(self, limb: str, relation: str, rows: Sequence[ca.SX], errors: Sequence[ca.SX]) -> None:
        self.rows.extend(rows)
        self.sources.extend(Row(limb, relation) for _ in rows)
        self.errors.extend(errors)

    def _distance(
        self, name: str, pose: PlatformPose, ends: tuple[ca.SX, ca.SX], length: ca.SX, length_squared: ca.SX | None = None
    ) -> None:
        """N (d.d - length^2) / (2 size) = 0 for a point of a pose and one of the base frame, checked as |d| - length."""
        squared = pose.squared_distance(*ends)
        self.distances.append(ca.vertcat(length, ends[1], ends[0]))
        target = length * length if length_squared is None else length_squared
        # over 2 size the row is a length, and its derivative by the distance is distance / size, of the order of 1
        row = (squared - pose.weight * target) / (2 * self.mechanism.characteristic_length)
        self._add(name, "distance", [row], [ca.sqrt(squared) - length])

    def _distance_between(
        self, name: str, ends: tuple[_Point, _Point], length: ca.SX, length_squared: ca.SX | None = None
    ) -> None:
        """The distance of two points of links, each in the form that its side takes."""
        first, last = ends
        if isinstance(first.side, PlatformSide) and isinstance(last.side, Chain):
            first, last = last, first
        if isinstance(last.side, PlatformSide) and isinstance(first.side, Chain):
            self._distance(name, last.side.pose, (last.local, first.moved), length, length_squared)
        else:
            still = UnitPose(ca.SX(3, 1), ca.SX([1, 0, 0, 0]))
            self._distance(name, still, (last.unweighted, first.unweighted), length, length_squared)

    def _close(self, branch: Branch) -> None:
        """Write what a branch between two placed bodies holds, cut at its joint of most freedom."""
        elements = branch.elements
        balls = [k for k, element in enumerate(elements) if element.balls]
        if balls and isinstance(elements[balls[0]].part, Bar):
            self._rod(branch, balls[0])
            return
        if len(balls) >= 2:
            self._two_balls(branch, balls[0], balls[-1])
            return
        cut = _cut_index(elements, self.kept)
        hinge = _replaceable_universal_joint(elements, cut) if self.form == "study" and self.replace_universal else None
        if hinge is not None and cut is not None:
            self._universal_as_distance(branch, hinge, cut)
            return
        eliminated = cut is None and self.eliminate
        if eliminated:
            cut = _middle_turn(elements)
        if cut is None:
            self._none_cut(branch)
            return
        base, platform = relative_sides(self._from_first(branch, cut), self._from_last(branch, cut + 1))
        self._cut(branch.name, elements[cut], base, platform)
        if eliminated:
            self.eliminated.append(_angle_of_cut(self.joints[elements[cut].name], base, platform))
            return
        self.idle.extend(f"{branch.name}: {c.name} (cut)" for c in self.joints[elements[cut].name].joint.coordinates)

    def _rod(self, branch: Branch, k: int) -> None:
        element = branch.elements[k]
        bar = element.part
        assert isinstance(bar, Bar)  # noqa: S101 - the caller has asked
        first, last = (bar.start, bar.end) if element.along else (bar.end, bar.start)
        sides = relative_sides(self._from_first(branch, k), self._from_last(branch, k + 1))
        points = tuple(
            _Point(side, self.table.vector(end.path, end.point), end.in_platform_frame, self.reference)
            for side, end in zip(sides, (first, last), strict=True)
        )
        self._distance_between(branch.name, (points[0], points[1]), self._rod_length(bar))
        spin = "the rod" if bar.coordinate is not None and bar.name == branch.name else bar.name
        self.idle.append(f"{branch.name}: spin of {spin}" if bar.spins else "")

    def _rod_length(self, bar: Bar) -> ca.SX:
        if bar.coordinate is not None:
            offset = self.table.scalar(f"{bar.path}.offset", bar.offset)
            return offset + self._symbol(bar.coordinate)
        reference = self.mechanism.reference_pose
        ends = [reference.apply(np.array(e.point)) if e.in_platform_frame else np.array(e.point) for e in (bar.start, bar.end)]
        length = bar.length if bar.length is not None else float(np.linalg.norm(ends[0] - ends[1]))
        return self.table.scalar(f"{bar.path}.length", length)

    def _two_balls(self, branch: Branch, first: int, last: int) -> None:
        symbols = [self.joints[branch.elements[k].name] for k in (first, last)]
        base = self._from_first(branch, first)
        between = Chain(self._steps(branch.elements[first + 1 : last])).move(symbols[1].point) - symbols[0].point
        base, platform = relative_sides(base, self._from_last(branch, last + 1))
        squared = dot(between, between)
        ends = _Point(base, symbols[0].point), _Point(platform, symbols[1].point)
        self._distance_between(branch.name, ends, ca.sqrt(squared), squared)
        self.idle.append(f"{branch.name}: {symbols[0].joint.name}, {symbols[1].joint.name} (cut)")

    def _universal_as_distance(self, branch: Branch, hinge: int, ball: int) -> None:
        """Universal joint, known joints, spherical joint: a distance between the centres."""
        elements = branch.elements
        before, symbols, end = (
            self._from_first(branch, hinge),
            self.joints[elements[hinge].name],
            self.joints[elements[ball].name],
        )
        base = before.move(symbols.point)
        arm = Chain(self._steps(elements[hinge + 1 : ball])).move(end.point) - symbols.point
        platform = self._from_last(branch, ball + 1)
        # the universal joint turns the arm about its centre: only the distance between the centres does not depend on its angles
        squared = dot(arm, arm)
        self._distance_between(
            branch.name, (_Point(before, symbols.point), _Point(platform, end.point)), ca.sqrt(squared), squared
        )
        reach = platform.move(end.point) / platform.weight - base
        assert symbols.axis is not None and symbols.axis2 is not None  # noqa: S101, PT018 - a universal joint has both
        first, second = symbols.joint.coordinates
        target = rotate(conjugate(before.quaternion), reach)
        self.replaced_universal_joints.append(ReplacedUniversalJoint((first, second), symbols.axis, symbols.axis2, arm, target))

    def _none_cut(self, branch: Branch) -> None:
        """A branch that would carry its last body, which is placed already: both say the same frame."""
        base, platform = relative_sides(self._from_first(branch, len(branch.elements)), self.bodies[branch.ends[1]])
        size, origin = self.mechanism.characteristic_length, self.reference.position
        gap = base.weight * platform.move(origin) - platform.weight * base.move(origin)
        e = multiply(conjugate(base.quaternion), platform.quaternion)
        # the check compares whole rotation matrices, which no spurious root of the rows passes
        full = ca.vertcat(*(platform.direction(u) - base.direction(u) for u in _unit_vectors()))
        if branch.ends == (BASE, self._platform) and all(_is_actuated(element) for element in branch.elements):
            self.forward = Pose(base.move(origin), multiply(base.quaternion, self.reference.quaternion))
            self.arm = base
        self._add(
            branch.name, "frame", [*ca.vertsplit(gap), *(2 * size * e[i] for i in (1, 2, 3))],
            [*ca.vertsplit(gap), *ca.vertsplit(size * full)],
        )  # fmt: skip

    def _cut(self, name: str, element: Element, base: Side, platform: Side) -> None:
        symbols = self.joints[element.name]
        size, point, axis = self.mechanism.characteristic_length, symbols.point, symbols.axis
        gap = base.weight * platform.move(point) - platform.weight * base.move(point)
        kind = symbols.joint.type
        if kind in "SRU":
            self._add(name, "point", ca.vertsplit(gap), ca.vertsplit(gap))
        if kind == "S":
            return
        assert axis is not None  # noqa: S101 - every cut joint but S has an axis
        if kind == "U":
            # a universal joint keeps the angle between its two axes; the first is fixed to the link before it
            before, after = (base, platform) if element.along else (platform, base)
            weights = base.weight * platform.weight
            angle = dot(before.direction(axis), after.direction(symbols.axis2)) - weights * dot(axis, symbols.axis2)
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


@dataclass(frozen=True)
class _Point:
    """A point of the link to which a side leads: at the reference in the base frame, or in the platform frame."""

    side: Side
    point: ca.SX
    in_platform_frame: bool = False
    reference: Pose | None = None

    @property
    def local(self) -> ca.SX:
        """In the frame of the body that floats."""
        assert isinstance(self.side, PlatformSide)  # noqa: S101 - only such a body has a frame of its own
        if self.in_platform_frame and not self.side.steps:
            return self.point
        return self.side.local(self._at_reference)

    @property
    def moved(self) -> ca.SX:
        """In the base frame, times the side's weight."""
        return self.side.move(self._at_reference)

    @property
    def unweighted(self) -> ca.SX:
        return self.moved if isinstance(self.side, Chain) else self.moved / self.side.weight

    @property
    def _at_reference(self) -> ca.SX:
        if not self.in_platform_frame or self.reference is None:
            return self.point
        return self.reference.position + rotate(self.reference.quaternion, self.point)


def _is_actuated(element: Element) -> bool:
    return isinstance(element.part, Joint) and element.part.actuated


def _end_of(branch: Branch, body: str) -> tuple[Element, bool]:
    """The element of a branch at a body, and whether it is the first."""
    first = branch.ends[0] == body
    return (branch.elements[0], True) if first else (branch.elements[-1], False)


def _unit_vectors() -> list[ca.SX]:
    return [ca.SX([1, 0, 0]), ca.SX([0, 1, 0]), ca.SX([0, 0, 1])]


def _normals(axis: ca.SX, nominal: Sequence[float] | None) -> tuple[ca.SX, ca.SX]:
    """Two unit vectors that make a right-handed frame with the axis, chosen at its nominal direction."""
    helper = [ca.SX(0)] * 3
    helper[int(np.argmin(np.abs(np.array(nominal))))] = ca.SX(1)
    u = cross(ca.vertcat(*helper), axis)
    u = u / ca.sqrt(dot(u, u))
    return u, cross(axis, u)


def _replaceable_universal_joint(elements: Sequence[Element], cut: int | None) -> int | None:
    """The only passive joint before a spherical cut, if it is universal."""
    joints = [element.part for element in elements]
    if cut is None or joints[cut].type != "S":  # type: ignore[union-attr]
        return None
    passive = [i for i, joint in enumerate(joints) if not joint.actuated and i != cut]  # type: ignore[union-attr]
    return passive[0] if len(passive) == 1 and passive[0] < cut and joints[passive[0]].type == "U" else None  # type: ignore[union-attr]


def _angle_of_cut(symbols: JointSymbols, base: Side, platform: Side) -> tuple[Coordinate, ca.SX]:
    """Coordinate of a revolute joint that was cut: e = q_B* q_P is a turn about its axis, tan(angle / 2) = a.e / e_0."""
    e = multiply(conjugate(base.quaternion), platform.quaternion)
    return symbols.joint.coordinates[0], 2 * ca.atan2(dot(symbols.axis, e[1:]), e[0]) + symbols.zero


def _middle_turn(elements: Sequence[Element]) -> int | None:
    """The revolute joint nearest the middle of a limb: cut there, an unknown joint leaves the rows, and both sides are
    short. None where it is the only joint: then nothing would be left to solve for."""
    if len(elements) == 1:
        return None
    turns = [i for i, element in enumerate(elements) if isinstance(element.part, Joint) and element.part.type == "R"]
    return min(turns, key=lambda i: abs(2 * i - len(elements) + 1), default=None)


def _cut_index(elements: Sequence[Element], kept: frozenset[str]) -> int | None:
    """The passive joint of most freedom, the last of equals; helical joints are never cut (their angle stays), nor those that
    are kept."""
    best: int | None = None
    most = 0
    for i, element in enumerate(elements):
        joint = element.part
        if not isinstance(joint, Joint) or joint.actuated or joint.type in ("H", "weld"):
            continue
        if any(c.name in kept for c in joint.coordinates):
            continue
        # >= takes the last of equals, so that the chain from the base is the longer one
        if joint.freedom >= most:
            best, most = i, joint.freedom
    return best
