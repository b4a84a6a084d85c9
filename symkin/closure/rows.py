"""Write the rows of a closure, branch by branch, by the rules of where a loop is cut.

Each loop is cut at its passive joint of most freedom, and only what that joint constrains is
written: two spherical ends give one distance equation, a spherical end three, a universal or
cylindrical end four, a revolute or prismatic end five, none six. Every row has the dimension of a
length: angular rows are multiplied by the mechanism's size.

Orientation rows are components of the vector part of a relative unit quaternion e = q_B* q_P. Its
vector part vanishes only where the two rotations are equal (that of R^T R' also vanishes for half
turns), and its part normal to an axis a only where e is a turn about a, so that these rows have no
spurious roots and stay linear in the platform's quaternion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.bodies import BodyBuilder, PoseForm
from symkin.closure.branches import Branch, Element, cut_index, middle_turn
from symkin.closure.chain import (
    Chain,
    JointSymbols,
    PlatformSide,
    Side,
    displacement_steps,
    relative_sides,
)
from symkin.closure.partition import ALL_JOINTS, Partition
from symkin.closure.pose_forms import PlatformPose, StudyPose, UnitPose
from symkin.closure.tilt_torsion import rotation_conditions, tilt_and_torsion
from symkin.closure.written_once import Rows, written_once
from symkin.errors import MechanismError
from symkin.model.bar import Bar
from symkin.model.graph import Coupling
from symkin.model.joint import BASE, POSE_CONDITIONS, Coordinate, Joint
from symkin.model.joint_forms import Relation
from symkin.model.machine import as_described, gaps_of
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import cross, dot
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import conjugate, multiply, rotate

_IN_PLANE = 1e-12
"""Sine of the angle off parallel and off normal of axes that are it: rounding."""
MOST_IN_LOOP = 250
"""Joints of a loop at most: derivatives of its rows have the square of that many operations."""


@dataclass(frozen=True)
class Row:
    """Where a row of the closure comes from: the limb and the relation that its cut joint keeps."""

    limb: str
    relation: str


class RowBuilder(BodyBuilder):
    """Collects rows and their checks while it walks a mechanism's branches."""

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        eliminate: bool = False,
        bound: bool = False,
        partition: Partition = ALL_JOINTS,
        body_forms: Mapping[str, PoseForm] | None = None,
    ) -> None:
        super().__init__(mechanism, bound=bound, partition=partition, body_forms=body_forms)
        self.eliminate = eliminate
        self.rows: list[ca.SX] = []
        self.sources: list[Row] = []
        self.errors: list[ca.SX] = []
        self.error_sources: list[Row] = []
        self.idle: list[str] = []
        self.distances: list[ca.SX] = []
        self.eliminated: list[tuple[Coordinate, ca.SX]] = []
        self.forward: Pose | None = None
        self.arm: Side = Chain(())
        self.gaps = gaps_of(mechanism) or {}

    def build_rows(self) -> None:
        self.declare()
        for branch in self.layout.branches:
            if branch.carries:
                self._carry(branch)
            else:
                self._close(branch)
        self._couple()
        if self.partition.pose_conditions or not self.table.bound:
            # rows of numbers alone are not asked where joints carry the platform
            self._place_platform()
        self._condition_pose()

    def _condition_pose(self) -> None:
        """Rows for the coordinates of the pose that are given one by one."""
        names = self.partition.pose_conditions
        if not names:
            return
        m, pose = self.mechanism, self.platform_pose
        size = m.characteristic_length
        home = as_described(m, m.reference_pose)
        numbers = (
            *np.asarray(home.position).tolist(),
            *tilt_and_torsion(np.asarray(home.quaternion)),
        )
        nominal = dict(zip(POSE_CONDITIONS, numbers, strict=True))
        values = {
            n: self._symbol(
                Coordinate(n, "length" if n in "xyz" else "angle", "condition", (nominal[n],))
            )
            for n in names
        }
        there = as_described(m, Pose(pose.point(ca.SX(3, 1)), pose.quaternion))
        place, turn = there.position, there.quaternion
        rows = [pose.weight * values[n] - place["xyz".index(n)] for n in names if n in "xyz"]
        turns, checks = rotation_conditions(turn, values)
        rows, checks = (
            [*rows, *(size * row for row in turns)],
            [*rows, *(size * check for check in checks)],
        )
        self._add("platform", "given", rows, checks)

    def declare_geometry(self) -> None:
        """Make coordinates of the lengths and the components of points on which the rows depend."""
        rows, table = ca.vertcat(*self.rows), self.table
        for name, symbol, value in zip(table.names, table.symbols, table.values, strict=True):
            if name.rsplit(".", 2)[-2:-1] in (["axis"], ["axis2"]) or name.endswith(
                (".zero", ".pitch", ".w")
            ):
                continue
            if "quaternion" not in name and any(ca.which_depends(rows, symbol, 1, True)):
                self.coordinates[name] = (Coordinate(name, "length", "geometry", (value,)), symbol)

    # --- branches ---------------------------------------------------------------------------------

    def _carry(self, branch: Branch) -> None:
        self.bodies[branch.ends[1]] = self._from_first(branch, len(branch.elements))

    def _couple(self) -> None:
        """A row for each coupling: angles times the size. Where whole turns leave it as it is, the
        row vanishes at all of them.
        """
        size, angles = (
            self.mechanism.characteristic_length,
            {c.name for c in self.kinds.values() if c.is_periodic},
        )
        for coupling in self.mechanism.couplings:
            coordinate, value = self.coordinates[coupling.joint]
            gap = (
                self._periodic_gap(coupling)
                if {coupling.joint, *coupling.names} <= angles
                else value - coupling.value({n: self.coordinates[n][1] for n in coupling.names})
            )
            gap = gap * coordinate.lever(size)
            self._add(f"coupling of {coupling.joint}", "coupling", [gap], [gap])

    def _periodic_gap(self, coupling: Coupling) -> ca.SX:
        """What vanishes where n joint = n1 first + n2 second + ... + n offset but for whole turns;
        the gap itself to first order.
        """
        own, numbers = coupling.whole_numbers or (1, ())
        wanted = sum(
            (
                n * self.coordinates[name][1]
                for n, name in zip(numbers, coupling.names, strict=True)
            ),
            ca.SX(own * coupling.constant),
        )
        return 2 / own * ca.sin(0.5 * (own * self.coordinates[coupling.joint][1] - wanted))

    def _add(
        self, limb: str, relation: str, rows: Sequence[ca.SX], errors: Sequence[ca.SX]
    ) -> None:
        self.rows.extend(rows)
        self.sources.extend(Row(limb, relation) for _ in rows)
        self.errors.extend(errors)
        self.error_sources.extend(Row(limb, relation) for _ in errors)

    def _distance(
        self,
        name: str,
        pose: PlatformPose,
        ends: tuple[ca.SX, ca.SX],
        length: ca.SX,
        length_squared: ca.SX | None = None,
    ) -> None:
        """N (d.d - length^2) / (2 size) = 0 for a point of a pose and one of the base frame,
        checked as |d| - length.
        """
        squared = pose.squared_distance(*ends)
        self.distances.append(ca.vertcat(length, ends[1], ends[0]))
        target = length * length if length_squared is None else length_squared
        # over 2 size the row is a length, and its derivative by the distance is distance / size, of
        # the order of 1
        row = (squared - pose.weight * target) / (2 * self.mechanism.characteristic_length)
        self._add(name, "distance", [row], [ca.sqrt(squared) - length])

    def _distance_between(
        self,
        name: str,
        ends: tuple[_Point, _Point],
        length: ca.SX,
        length_squared: ca.SX | None = None,
    ) -> None:
        """The distance of two points of links, each in the form that its side takes; seen from a
        body in Study coordinates, if one of them is, where it is a quadratic form.
        """
        first, last = ends
        if isinstance(first.side, PlatformSide) and not _is_study(last.side):
            first, last = last, first
        if isinstance(last.side, PlatformSide):
            self._distance(
                name, last.side.pose, (last.local, first.unweighted), length, length_squared
            )
        else:
            still = UnitPose(ca.SX(3, 1), ca.SX([1, 0, 0, 0]))
            self._distance(name, still, (last.moved, first.moved), length, length_squared)

    def _close(self, branch: Branch) -> None:
        """Write what a branch between two placed bodies holds, cut at its joint of most freedom."""
        elements = branch.elements
        if len(elements) > MOST_IN_LOOP:
            raise MechanismError(
                f"{self.mechanism.name}: a loop through {elements[0].name} and {elements[-1].name} "
                f"has {len(elements)} joints; allowed: {MOST_IN_LOOP}"
            )
        if branch.name in self.gaps:
            first, last = (self.bodies[link] for link in branch.ends)
            opened = last.extended(displacement_steps(self.gaps[branch.name]))
            self._cut(branch.name, elements[0], *relative_sides(first, opened))
            return
        balls = [k for k, element in enumerate(elements) if element.balls]
        if balls and isinstance(elements[balls[0]].part, Bar):
            self._rod(branch, balls[0])
            return
        if len(balls) >= 2:
            self._two_balls(branch, balls[0], balls[-1])
            return
        cut = cut_index(elements, self.kept)
        eliminated = cut is None and self.eliminate
        if eliminated:
            cut = middle_turn(elements)
        if cut is None:
            self._none_cut(branch)
            return
        base, platform = relative_sides(
            self._from_first(branch, cut), self._from_last(branch, cut + 1)
        )
        oblique = self._is_oblique_plane(elements, elements[cut])
        self._cut(branch.name, elements[cut], base, platform, oblique=oblique)
        if eliminated:
            self.eliminated.append(_angle_of_cut(self.joints[elements[cut].name], base, platform))
            return
        self.idle.extend(
            f"{branch.name}: {c.name} (cut)"
            for c in self.joints[elements[cut].name].joint.coordinates
        )

    def _rod(self, branch: Branch, k: int) -> None:
        element = branch.elements[k]
        bar = element.part
        assert isinstance(bar, Bar)  # noqa: S101 - the caller has asked
        first, last = (bar.start, bar.end) if element.along else (bar.end, bar.start)
        sides = relative_sides(self._from_first(branch, k), self._from_last(branch, k + 1))
        points = tuple(
            _Point(
                side,
                self.table.vector(end.path, self.laid.starts.get(end.path, end.point)),
                end.in_platform_frame,
                self.reference,
            )
            for side, end in zip(sides, (first, last), strict=True)
        )
        self._distance_between(branch.name, (points[0], points[1]), self._rod_length(bar))
        spin = "the rod" if bar.coordinate is not None and bar.name == branch.name else bar.name
        self.idle.append(f"{branch.name}: spin of {spin}" if bar.spins else "")

    def _rod_length(self, bar: Bar) -> ca.SX:
        if bar.coordinate is not None:
            offset = self.table.scalar(f"{bar.path}.offset", bar.offset)
            return offset + self._symbol(bar.coordinate)
        length = bar.reference_length if bar.length is None else bar.length
        return self.table.scalar(f"{bar.path}.length", length)

    def _two_balls(self, branch: Branch, first: int, last: int) -> None:
        symbols = [self.joints[branch.elements[k].name] for k in (first, last)]
        base = self._from_first(branch, first)
        between = (
            Chain(self._steps(branch.elements[first + 1 : last])).move(symbols[1].point)
            - symbols[0].point
        )
        base, platform = relative_sides(base, self._from_last(branch, last + 1))
        squared = dot(between, between)
        ends = _Point(base, symbols[0].point), _Point(platform, symbols[1].point)
        self._distance_between(branch.name, ends, ca.sqrt(squared), squared)
        self.idle.append(f"{branch.name}: {symbols[0].joint.name}, {symbols[1].joint.name} (cut)")

    def _none_cut(self, branch: Branch) -> None:
        """A branch that would carry its last body, which is placed already: both say the same
        frame.
        """
        base, platform = relative_sides(
            self._from_first(branch, len(branch.elements)), self.bodies[branch.ends[1]]
        )
        size, origin = self.mechanism.characteristic_length, self.reference.position
        if branch.ends == (BASE, self.mechanism.platform_link) and all(
            _is_actuated(element) for element in branch.elements
        ):
            self.forward = Pose(
                base.move(origin), multiply(base.quaternion, self.reference.quaternion)
            )
            self.arm = base
        cut = Cut(("frame",), origin)
        for relation, rows, errors in rows_of_joint(cut, base, platform, ca.SX(size)):
            self._add(branch.name, relation, rows, errors)

    def _is_oblique_plane(self, elements: Sequence[Element], cut: Element) -> bool:
        """Whether a revolute joint that is cut is normal to a plane of all joints of its branch,
        which is none of the base frame's.
        """
        joints = [self.joints[e.name].joint for e in elements if e.name in self.joints]
        if self.joints[cut.name].joint.type != "R" or len(joints) < len(elements):
            return False
        normal = np.array(self.joints[cut.name].joint.axis)
        if np.count_nonzero(np.abs(normal) > _IN_PLANE) < 2:
            return False
        return all(
            float(np.linalg.norm(np.cross(np.array(joint.axis), normal))) <= _IN_PLANE
            if joint.type == "R"
            else joint.type == "P" and abs(float(np.array(joint.axis) @ normal)) <= _IN_PLANE
            for joint in joints
        )

    def _cut(
        self, name: str, element: Element, base: Side, platform: Side, *, oblique: bool = False
    ) -> None:
        symbols, size = self.joints[element.name], self.mechanism.characteristic_length
        cut = Cut.of(symbols, along=element.along, oblique=oblique)
        for relation, rows, errors in written_once(rows_of_joint, cut, base, platform, ca.SX(size)):
            self._add(name, relation, rows, errors)


@dataclass(frozen=True)
class Cut:
    """The joint at which a loop is closed, what it keeps, the axis of the base frame that its axis
    is furthest from (`helper`), and whether it is normal to an `oblique` plane of all joints of its
    branch: rows of a gap along the axis vanish there, and the two others are as those at home.
    """

    kept: tuple[Relation, ...]
    point: ca.SX
    axis: ca.SX | None = None
    axis2: ca.SX | None = None
    pitch: ca.SX | None = None
    helper: int = 0
    along: bool = True
    oblique: bool = False

    @staticmethod
    def of(symbols: JointSymbols, *, along: bool = True, oblique: bool = False) -> Cut:
        """A joint, which the branch passes `along` its description or the other way."""
        joint = symbols.joint
        helper = 0 if joint.axis is None else int(np.argmin(np.abs(joint.axis)))
        own = (symbols.point, symbols.axis, symbols.axis2, symbols.pitch)
        return Cut(joint.form.kept, *own, helper, along, oblique)


def rows_of_joint(cut: Cut, base: Side, platform: Side, size: ca.SX) -> Rows:
    """What a joint between two sides constrains."""
    gap = base.weight * platform.move(cut.point) - platform.weight * base.move(cut.point)
    normals = () if cut.axis is None else _normals(cut.axis, cut.helper)
    found: Rows = []
    for relation in cut.kept:
        match relation:
            case "point":
                errors = ca.vertsplit(gap)
                rows = [dot(n, gap) for n in (*normals, cut.axis)] if cut.oblique else errors
            case "line":
                # the joint slides along its axis: only the gap across it is held
                rows = errors = [dot(base.direction(n), gap) for n in normals]
            case "axes' angle":
                # the first axis is fixed to the link before the joint
                before, after = (base, platform) if cut.along else (platform, base)
                weights = base.weight * platform.weight
                angle = dot(before.direction(cut.axis), after.direction(cut.axis2)) - weights * dot(
                    cut.axis, cut.axis2
                )
                rows = errors = [size * angle]
            case "axis":
                # e is parallel to the joint's axis: both components normal to it vanish
                e = multiply(conjugate(base.quaternion), platform.quaternion)
                rows = [2 * size * dot(e[1:], n) for n in normals]
                errors = ca.vertsplit(
                    size * (platform.direction(cut.axis) - base.direction(cut.axis))
                )
            case "advance":
                # the angle 2 atan2(a.e, e_0) within half a turn either way
                e = multiply(conjugate(base.quaternion), platform.quaternion)
                sine = dot(cut.axis, e[1:])
                turn = ca.atan2(2 * e[0] * sine, e[0] * e[0] - sine * sine)
                along = dot(base.direction(cut.axis), gap)
                rows = errors = [along - cut.pitch * turn / (2 * ca.pi)]
            case "orientation" | "frame":
                # the check compares whole rotation matrices, which no spurious root passes
                e = multiply(conjugate(base.quaternion), platform.quaternion)
                held = ca.vertsplit(gap) if relation == "frame" else []
                full = (platform.direction(n) - base.direction(n) for n in _unit_vectors())
                rows = [*held, *(2 * size * e[i] for i in (1, 2, 3))]
                errors = [*held, *ca.vertsplit(size * ca.vertcat(*full))]
        found.append((relation, rows, errors))
    return found


@dataclass(frozen=True)
class _Point:
    """A point of the link to which a side leads: at the reference in the base frame, or in the
    platform frame.
    """

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


def _is_study(side: Side) -> bool:
    return isinstance(side, PlatformSide) and isinstance(side.pose, StudyPose)


def _is_actuated(element: Element) -> bool:
    return isinstance(element.part, Joint) and element.part.actuated


def _unit_vectors() -> list[ca.SX]:
    return [ca.SX([1, 0, 0]), ca.SX([0, 1, 0]), ca.SX([0, 0, 1])]


def _normals(axis: ca.SX, number: int) -> tuple[ca.SX, ca.SX]:
    """Two unit vectors that make a right-handed frame with the axis, by an axis of the base frame,
    which should be far from it.
    """
    helper = [ca.SX(0)] * 3
    helper[number] = ca.SX(1)
    u = cross(ca.vertcat(*helper), axis)
    u = u / ca.sqrt(dot(u, u))
    return u, cross(axis, u)


def _angle_of_cut(symbols: JointSymbols, base: Side, platform: Side) -> tuple[Coordinate, ca.SX]:
    """Coordinate of a revolute joint that was cut: e = q_B* q_P is a turn about its axis,
    tan(angle / 2) = a.e / e_0.
    """
    e = multiply(conjugate(base.quaternion), platform.quaternion)
    return symbols.joint.coordinates[0], 2 * ca.atan2(dot(symbols.axis, e[1:]), e[0]) + symbols.zero
