"""Displace points, directions and quaternions symbolically by chains of joints (product of
exponentials).

Matrix products are never formed: a point is carried through the joints one by one, which keeps
expressions short.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca

from symkin.closure.parameters import ParameterTable
from symkin.closure.pose_forms import PlatformPose
from symkin.closure.snapping import snapped_constants
from symkin.model.joint import Joint
from symkin.spatial.backend import cross, dot, one_call
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import (
    conjugate,
    multiply,
    quaternion_from_axis_angle,
    rotate,
)


@one_call
def _turned(v: ca.SX, axis: ca.SX, angle: ca.SX) -> ca.SX:
    # Rodrigues: R v = cos v + sin (a x v) + (1 - cos) (a.v) a
    c, s = ca.cos(angle), ca.sin(angle)
    return c * v + s * cross(axis, v) + (1 - c) * dot(axis, v) * axis


@dataclass(frozen=True)
class Turn:
    """Rotation by `angle` about the unit `axis` through `point`, then a slide along the axis."""

    point: ca.SX
    axis: ca.SX
    angle: ca.SX | None
    slide: ca.SX | None = None

    def direction(self, v: ca.SX) -> ca.SX:
        return v if self.angle is None else _turned(v, self.axis, self.angle)

    def move(self, p: ca.SX) -> ca.SX:
        # screw motion: turn about the axis, then slide along it; the two commute
        moved = p if self.angle is None else self.point + self.direction(p - self.point)
        return moved if self.slide is None else moved + self.slide * self.axis

    @property
    def quaternion(self) -> ca.SX:
        if self.angle is None:
            return ca.SX([1, 0, 0, 0])
        return quaternion_from_axis_angle(self.axis, self.angle)

    def inverse(self) -> Turn:
        return Turn(
            self.point,
            self.axis,
            None if self.angle is None else -self.angle,
            None if self.slide is None else -self.slide,
        )


@dataclass(frozen=True)
class Ball:
    """Rotation by a unit quaternion about `point`."""

    point: ca.SX
    quaternion: ca.SX

    def direction(self, v: ca.SX) -> ca.SX:
        return rotate(self.quaternion, v)

    def move(self, p: ca.SX) -> ca.SX:
        return self.point + self.direction(p - self.point)

    def inverse(self) -> Ball:
        return Ball(self.point, conjugate(self.quaternion))


Step = Turn | Ball


def displacement_steps(pose: Pose) -> tuple[Step, ...]:
    """A displacement by numbers."""
    away, turn = (ca.SX(ca.DM(part)) for part in (pose.position, pose.quaternion))
    return (Turn(away, away, None, ca.SX(1)), Ball(ca.SX(3, 1), turn))


@dataclass(frozen=True)
class Chain:
    """g1 g2 ... gn: the last step acts first."""

    steps: tuple[Step, ...]

    @property
    def weight(self) -> ca.SX:
        """Of a pose of its own (see `pose_forms`): a chain has none."""
        return ca.SX(1)

    def extended(self, steps: Sequence[Step]) -> Chain:
        return Chain(self.steps + tuple(steps))

    def move(self, p: ca.SX) -> ca.SX:
        for step in reversed(self.steps):
            p = step.move(p)
        return p

    def direction(self, v: ca.SX) -> ca.SX:
        for step in reversed(self.steps):
            v = step.direction(v)
        return v

    @property
    def quaternion(self) -> ca.SX:
        total = ca.SX([1, 0, 0, 0])
        for step in self.steps:
            total = multiply(total, step.quaternion)
        return total


@dataclass(frozen=True)
class PlatformSide:
    """What hangs on a body that floats, the platform or another: its pose, then joints from it
    outward. Values are weighted by the pose's weight N.
    """

    pose: PlatformPose
    reference: Pose
    steps: tuple[Step, ...] = ()

    @property
    def weight(self) -> ca.SX:
        return self.pose.weight

    def extended(self, steps: Sequence[Step]) -> PlatformSide:
        return replace(self, steps=self.steps + tuple(steps))

    def local(self, p: ca.SX) -> ca.SX:
        """A point of the reference configuration, moved by the joints, in the platform frame."""
        return rotate(
            conjugate(self.reference.quaternion),
            Chain(self.steps).move(p) - self.reference.position,
        )

    def move(self, p: ca.SX) -> ca.SX:
        """N times the moved point."""
        return self.pose.point(self.local(p))

    def direction(self, v: ca.SX) -> ca.SX:
        """N times the turned direction."""
        return self.pose.direction(
            rotate(conjugate(self.reference.quaternion), Chain(self.steps).direction(v))
        )

    @property
    def quaternion(self) -> ca.SX:
        return multiply(
            multiply(self.pose.quaternion, conjugate(self.reference.quaternion)),
            Chain(self.steps).quaternion,
        )


Side = Chain | PlatformSide
"""Where a link is: joints from the base, or from a body that floats."""


def relative_sides(first: Side, last: Side) -> tuple[Side, Side]:
    """Both sides as seen from the last link that they have in common: what moves that link moves
    both, and no row between them. Sides that do not both begin at the base stay as they are.
    """
    if not (isinstance(first, Chain) and isinstance(last, Chain)):
        return first, last
    shared = 0
    for a, b in zip(first.steps, last.steps, strict=False):
        if a is not b:
            break
        shared += 1
    return Chain(first.steps[shared:]), Chain(last.steps[shared:])


@dataclass(frozen=True)
class JointSymbols:
    """Geometry of one joint as expressions of its parameters."""

    joint: Joint
    point: ca.SX
    axis: ca.SX | None
    axis2: ca.SX | None
    pitch: ca.SX | None
    zero: ca.SX

    @staticmethod
    def declare(joint: Joint, path: str, table: ParameterTable) -> JointSymbols:
        point = table.vector(f"{path}.point", joint.point)
        axis = None if joint.axis is None else table.direction(f"{path}.axis", joint.axis)
        axis2 = None if joint.axis2 is None else table.direction(f"{path}.axis2", joint.axis2)
        pitch = table.scalar(f"{path}.pitch", joint.pitch) if joint.type == "H" else None
        zero = table.scalar(f"{path}.zero", joint.zero) if joint.freedom == 1 else ca.SX(0)
        return JointSymbols(joint, point, axis, axis2, pitch, zero)

    def substituted(self, old: list[ca.SX], new: list[ca.SX]) -> JointSymbols:
        """The same joint over other symbols."""
        parts = {name: getattr(self, name) for name in ("point", "axis", "axis2", "pitch")}
        own = {name: part for name, part in parts.items() if part is not None}
        found = ca.substitute(list(own.values()), old, new)
        return replace(self, **dict(zip(own, found, strict=True)))

    def moved(self, shift: float) -> JointSymbols:
        """The same joint by another point of its axis."""
        return (
            self
            if shift == 0.0 or self.axis is None
            else replace(self, point=self.point + shift * self.axis)
        )

    def snapped(self, size: float) -> JointSymbols:
        """The same joint with constants free of rounding noise."""
        return replace(
            self,
            point=snapped_constants(self.point, size),
            axis=snapped_constants(self.axis),
            axis2=snapped_constants(self.axis2),
        )

    def steps(self, values: Sequence[ca.SX]) -> tuple[Step, ...]:
        """The displacement for coordinate values, one SX per coordinate of the joint."""
        point, axis = self.point, self.axis
        match self.joint.type:
            case "R":
                return (Turn(point, axis, values[0] - self.zero),)
            case "P":
                return (Turn(point, axis, None, values[0] - self.zero),)
            case "H":
                angle = values[0] - self.zero
                return (Turn(point, axis, angle, self.pitch * angle / (2 * ca.pi)),)
            case "C":
                return (Turn(point, axis, values[0], values[1]),)
            case "U":
                return (Turn(point, axis, values[0]), Turn(point, self.axis2, values[1]))
            case "S":
                return (Ball(point, values[0]),)
            case _:
                return ()
