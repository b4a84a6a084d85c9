"""Declare the coordinates of a closure, and where its bodies and links are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import casadi as ca
import numpy as np

from symkin.closure.branches import Branch, Element, layout_of
from symkin.closure.chain import Chain, JointSymbols, PlatformSide, Side, Step
from symkin.closure.laid import laid_limbs
from symkin.closure.parameters import ParameterTable
from symkin.closure.partition import ALL_JOINTS, POSE_COORDINATES, Partition
from symkin.closure.pose_forms import HomogeneousPose, PlatformPose, StudyPose, UnitPose
from symkin.closure.snapping import snapped_constants
from symkin.model.dh import reference_frames
from symkin.model.joint import BASE, Coordinate, Joint
from symkin.model.machine import turn_about_z, untwisted
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply

PoseForm = Literal["study", "homogeneous"]
"""Algebraic forms of the pose: "study" where it is unknown, "homogeneous" where it is given."""


class BodyBuilder:
    """Declares coordinates, parameters, and where bodies and links are: joints from a body outward,
    and the poses of those that float.

    `kept` names joint coordinates that the closure must hold, whichever joint a loop is best cut
    at.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        bound: bool = False,
        partition: Partition = ALL_JOINTS,
        body_forms: Mapping[str, PoseForm] | None = None,
    ) -> None:
        self.mechanism = mechanism
        self.body_forms = dict(body_forms or {})
        self.body_symbols: dict[str, ca.SX] = {}
        self.partition = partition
        self.kept = partition.kept | {n for c in mechanism.couplings for n in (c.joint, *c.names)}
        self.layout = layout_of(mechanism, self.kept, pose=partition.pose)
        self.table = ParameterTable(bound=bound)
        self.laid = laid_limbs(mechanism, self.layout.branches, self.kept)
        self.kinds = {
            c.name: replace(c, reference=self.laid.values.get(c.name, c.reference))
            for c in mechanism.coordinates
        }
        self.coordinates: dict[str, tuple[Coordinate, ca.SX]] = {}
        self.bodies: dict[str, Side] = {BASE: Chain(())}
        self.links: dict[str, Side] = {}

    def declare(self) -> None:
        """Declare the geometry of all joints, and the poses of the bodies that float."""
        m = self.mechanism
        joints, tool = self._geometry()
        joints = {
            name: symbols.moved(self._shift(symbols.joint)) for name, symbols in joints.items()
        }
        if self.table.bound:
            joints = {
                name: symbols.snapped(m.characteristic_length) for name, symbols in joints.items()
            }
            tool = Pose(
                snapped_constants(tool.position, m.characteristic_length),
                snapped_constants(tool.quaternion),
            )
        self.joints = joints
        self.reference = tool
        self._declare_bodies()

    # --- geometry and poses -----------------------------------------------------------------------

    def _geometry(self) -> tuple[dict[str, JointSymbols], Pose]:
        """Joints by name and the platform's reference pose as expressions of the parameters."""
        m, table = self.mechanism, self.table
        if m.dh is not None:
            rows = []
            for k, row in enumerate(m.dh.rows, start=1):
                rows.append(
                    [
                        table.scalar(f"dh.{k}.{key}", getattr(row, key))
                        for key in ("theta", "d", "a", "alpha")
                    ]
                )
            frames, tool = reference_frames(m.dh.convention, rows)
            symbols = {
                joint.name: JointSymbols(joint, ca.SX(point), ca.SX(axis), None, None, ca.SX(0))
                for joint, (point, axis) in zip(m.all_joints, frames, strict=True)
            }
            return symbols, Pose(ca.SX(tool.position), ca.SX(tool.quaternion))
        paths = {
            element.name: element.path
            for branch in self.layout.branches
            for element in branch.elements
        }
        joints = {
            j.name: JointSymbols.declare(self.laid.joints.get(j.name, j), paths[j.name], table)
            for j in m.all_joints
            if j.type != "weld" or table.bound
        }
        position = table.vector(f"{m.frame_name}.position", m.platform_position)
        quaternion = table.vector(f"{m.frame_name}.quaternion", m.platform_quaternion, "wxyz")
        return joints, Pose(position, quaternion / ca.sqrt(ca.dot(quaternion, quaternion)))

    def _shift(self, joint: Joint) -> float:
        """How far along its axis a joint's point is moved from where it is described; the joint is
        the same for any geometry.
        """
        if joint.name in self.laid.joints:
            return 0.0
        away = self.mechanism.places[joint.name] - np.array(joint.point)
        return float(away @ np.array(joint.axis)) if away.any() else 0.0

    def _declare_bodies(self) -> None:
        """Poses of the bodies that float: the platform's first."""
        for body in self.layout.floating:
            if body in self.body_forms:
                self.bodies[body] = self._declare_algebraic_body(body)
            elif body == self.mechanism.platform_link:
                self._declare_pose(self.reference)
                self.bodies[body] = PlatformSide(self.platform_pose, self.reference)
            else:
                self.bodies[body] = self._declare_body(body)

    def _declare_algebraic_body(self, body: str) -> PlatformSide:
        """A floating body in Study coordinates (e; g), or by position and a quaternion of any
        length; a platform whose motion is spherical by its quaternion alone.
        """
        e = ca.SX.sym(f"{body}.e", 4)
        is_platform = body == self.mechanism.platform_link
        reference = (
            self.reference if is_platform else Pose(ca.SX(self._middle(body)), ca.SX([1, 0, 0, 0]))
        )
        if is_platform and self.mechanism.motion == "spherical":
            self.body_symbols[body] = e
            return PlatformSide(HomogeneousPose(reference.position, e), reference)
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
        return np.mean([self._place(element, first=first) for element, first in ends], axis=0)

    def _declare_body(self, body: str) -> PlatformSide:
        """A floating body by the position of the middle of its joints' points and its turn from the
        reference.
        """
        middle = self._middle(body)
        values = {
            f"{body}.{key}": Coordinate(f"{body}.{key}", "length", "body", (float(value),))
            for key, value in zip("xyz", middle, strict=True)
        }
        turn = Coordinate(f"{body}.quaternion", "quaternion", "body", (1.0, 0.0, 0.0, 0.0))
        position = ca.vertcat(*(self._symbol(c) for c in values.values()))
        return PlatformSide(
            UnitPose(position, self._symbol(turn)), Pose(ca.SX(middle), ca.SX([1, 0, 0, 0]))
        )

    def _place(self, element: Element, *, first: bool) -> np.ndarray:
        """Where a joint or the end of a rod is at the reference, the end that is nearer to the
        branch's first body or not.
        """
        if isinstance(element.part, Joint):
            return self.mechanism.places[element.name]
        return element.part.places[first != element.along]

    def _declare_pose(self, reference: Pose) -> None:
        m = self.mechanism
        values: dict[str, ca.SX] = {}
        nominal = {"x": 0, "y": 1, "z": 2}
        for name, kind in POSE_COORDINATES[m.motion]:
            if name == "quaternion":
                start = m.platform_quaternion
            elif name in nominal:
                start = (m.platform_position[nominal[name]],)
            else:
                start = (turn_about_z(m),)
            coordinate = Coordinate(f"pose.{name}", kind, "pose", tuple(start))  # type: ignore[arg-type]
            values[name] = self._symbol(coordinate)
        position = ca.vertcat(
            *(values.get(name, reference.position[i]) for name, i in nominal.items())
        )
        if "quaternion" in values:
            quaternion = values["quaternion"]
        else:
            # a turn about the base frame's z axis, after the orientation from which it is told
            half = 0.5 * values.get("gamma", ca.SX(0))
            home = ca.SX(ca.DM(untwisted(m))) if turn_about_z(m) else reference.quaternion
            quaternion = multiply(ca.vertcat(ca.cos(half), 0, 0, ca.sin(half)), home)
        self.pose = Pose(position, quaternion)
        self.platform_pose: PlatformPose = UnitPose(position, quaternion)

    def _place_platform(self) -> None:
        """The pose of a platform that the joints carry, as an expression of theirs; the base's
        frame where there is none.
        """
        platform = self.mechanism.platform_link
        if platform in self.layout.floating:
            if platform in self.body_forms:
                self.platform_pose = self.bodies[platform].pose  # type: ignore[union-attr]
            return
        if platform is None:
            self.pose = Pose(ca.SX(3, 1), ca.SX([1, 0, 0, 0]))
            return
        side = self._link(platform)
        self.pose = Pose(
            side.move(self.reference.position), multiply(side.quaternion, self.reference.quaternion)
        )
        self.platform_pose = UnitPose(ca.SX(self.pose.position), ca.SX(self.pose.quaternion))

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
        """Where the link behind the first `count` elements of a branch is, from the branch's first
        body; all links before it are noted.
        """
        side = self.bodies[branch.ends[0]]
        for k in range(count):
            side = side.extended(self._steps(branch.elements[k : k + 1]))
            if k < len(branch.links):
                self.links[branch.links[k]] = side
        return side

    def _last_body(self, branch: Branch) -> Side:
        """Where a branch's last body is, seen from where the branch is laid."""
        side, laid = self.bodies[branch.ends[1]], self.laid.platforms.get(branch.name)
        if laid is None or not isinstance(side, PlatformSide):
            return side
        place, turn = (ca.SX(ca.DM(part)) for part in (laid.position, laid.quaternion))
        return replace(side, reference=Pose(place, turn))

    def _from_last(self, branch: Branch, first: int) -> Side:
        """Where the link before the element `first` is, from the branch's last body; all links
        behind it are noted.
        """
        side, elements = self._last_body(branch), branch.elements
        # coordinates are declared from the base outward
        self._steps(elements[first:])
        for k in reversed(range(first, len(elements))):
            side = side.extended(
                tuple(step.inverse() for step in reversed(self._steps(elements[k : k + 1])))
            )
            self.links[branch.links[k - 1]] = side
        return side


def _end_of(branch: Branch, body: str) -> tuple[Element, bool]:
    """The element of a branch at a body, and whether it is the first."""
    first = branch.ends[0] == body
    return (branch.elements[0], True) if first else (branch.elements[-1], False)
