"""Lay the limbs of a machine along axes: describe each where its own joints stand such that most
of its numbers are zero, wherever the machine's reference is.

At the reference a limb's joints have the screws S_k. Where they are moved from there by s_k, what
follows joint k is displaced by D_k = exp(S_1 s_1) ... exp(S_k s_k), and the same limb has the
screws D_k-1 S_k. Joints whose values are told stand at 0; others such that what they move lies
along an axis. What follows the joint at which the loop is cut is laid from the platform inward, in
the platform's frame: a laid limb closes at a platform pose of its own, along the base frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symkin.closure.branches import Branch, cut_index
from symkin.model.bar import Bar
from symkin.model.joint import Joint
from symkin.model.limb import AnyLimb
from symkin.model.machine import is_laid
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import quaternion_from_axis_angle

_ROUNDING = 1e-12
"""Angle, component of a direction, and length over the size that are 0: rounding."""
_TELLS = 1e-3
"""Length, over the size, of a vector that tells a direction."""
_ALONG = (1.0, 0.0, 0.0, 0.0)
"""Quaternion of a frame along another one."""


@dataclass(frozen=True)
class Laid:
    """What is laid of a machine: joints by name, where rods begin by their key paths, the
    platform's poses by limb, and values at the machine's reference by coordinate.
    """

    joints: dict[str, Joint] = field(default_factory=dict)
    starts: dict[str, Sequence[float]] = field(default_factory=dict)
    platforms: dict[str, Pose] = field(default_factory=dict)
    values: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def add(self, joints: Sequence[Joint], values: Sequence[Sequence[float]]) -> None:
        """The joints of a limb, and the values of those that were moved."""
        for joint, own in zip(joints, values, strict=True):
            self.joints[joint.name] = joint
            named = zip(joint.coordinates, own, strict=False)
            self.values.update({c.name: (value,) for c, value in named})

    def links(self, branches: Sequence[Branch]) -> set[str]:
        """The links of the limbs that are laid, but base and platform."""
        return {
            link
            for branch in branches
            if branch.elements[0].name in self.joints
            for link in (*branch.links, *(branch.ends[1:] if branch.carries else ()))
        }


def laid_limbs(mechanism: Mechanism, branches: Sequence[Branch], kept: frozenset[str]) -> Laid:
    """The limbs of a machine that is laid, without those that would need a turned platform frame;
    `kept` are joints at which no loop is cut.
    """
    found = Laid()
    limbs = {limb.name: limb for limb in mechanism.limbs}
    for branch in branches if is_laid(mechanism) else ():
        if branch.name not in limbs or isinstance(branch.elements[0].part, Bar):
            continue
        limb = limbs[branch.name]
        joints = [
            replace(joint, point=mechanism.places[joint.name].tolist()) for joint in limb.joints
        ]
        if branch.carries:
            _lay_carrier(found, mechanism, limb, joints)
        else:
            _lay_loop(found, mechanism, limb, joints, cut_index(branch.elements, kept))
    return found


def _lay_carrier(found: Laid, mechanism: Mechanism, limb: AnyLimb, joints: Sequence[Joint]) -> None:
    """Lay a limb whose last link carries rods."""
    chain = _Chain(mechanism.characteristic_length)
    bars = limb.bars(mechanism.reference_pose)
    chain.lay(joints, [], [bar.start.point for bar in bars])
    found.add(chain.joints, chain.values)
    for bar in bars:
        found.starts[bar.start.path] = chain.point(bar.start.point).tolist()


def _lay_loop(
    found: Laid, mechanism: Mechanism, limb: AnyLimb, joints: Sequence[Joint], cut: int | None
) -> None:
    """Lay a limb that is cut at a joint which has no limits, if its sides meet there with frames
    along each other, and if that is no way to stand of the description.
    """
    others = [joint for k, joint in enumerate(joints) if k != cut]
    if cut is None or joints[cut].limits is not None or any(j.type == "S" for j in others):
        return
    size, home = mechanism.characteristic_length, mechanism.reference_pose.inverse()
    base = _Chain(size)
    base.lay(joints[:cut], [joints[cut]], [])
    # the other side, as it is seen from the platform
    local = _Chain(size, home)
    end, *inner = [local.carried(joint).turned() for joint in joints[cut:]]
    far = _Chain(size)
    far.lay(inner[::-1], [end], [])
    one, other = base.carried(joints[cut]), far.carried(end).turned()
    if not _meet(joints[cut], one, other):
        return
    platform = Pose(np.subtract(one.point, other.point), np.array(_ALONG))
    placed = _Chain(size, platform)
    outer = [placed.carried(joint.turned()) for joint in far.joints[::-1]]
    middle = one if one.axis2 is None else replace(one, axis2=other.axis2)
    laid = [*base.joints, middle, *outer]
    if laid == joints and not np.any(np.asarray(home.quaternion)[1:]):
        return
    found.add(laid, [*base.values, (), *(own[::-1] for own in far.values[::-1])])
    found.platforms[limb.name] = platform


def _meet(joint: Joint, one: Joint, other: Joint) -> bool:
    """Whether a joint, laid from both sides, is one whose sides have frames along each other."""
    match joint.type:
        case "S":
            return True
        case "R" | "C":
            return float(np.linalg.norm(np.subtract(one.axis, other.axis))) <= _ROUNDING  # type: ignore[arg-type]
        case "U":
            angles = np.dot(joint.axis, joint.axis2), np.dot(one.axis, other.axis2)  # type: ignore[arg-type]
            return abs(float(angles[0] - angles[1])) <= _ROUNDING
    return False


@dataclass
class _Chain:
    """Laid joints from a body outward: what follows them is displaced by `at` (None: it is not),
    and `values` are those of their coordinates at the reference.
    """

    size: float
    at: Pose | None = None
    joints: list[Joint] = field(default_factory=list)
    values: list[Sequence[float]] = field(default_factory=list)

    def point(self, p: Sequence[float]) -> np.ndarray:
        """A point of the link that the joints lead to; where it is beside the last joint in a
        direction it is exactly so.
        """
        if self.at is None:
            return np.array(p)
        near = _ROUNDING * self.size
        moved = _without(self.at.apply(np.array(p)), near)
        before = np.array(self.joints[-1].point if self.joints else np.zeros(3))
        return np.where(np.abs(moved - before) <= near, before, moved)

    def direction(self, v: Sequence[float]) -> np.ndarray:
        """A unit vector of the link that the joints lead to."""
        if self.at is None:
            return np.array(v)
        moved = _without(self.at.turn(np.array(v)), _ROUNDING)
        return np.where(np.abs(np.abs(moved) - 1.0) <= _ROUNDING, np.sign(moved), moved)

    def carried(self, joint: Joint) -> Joint:
        """A joint on the link that the joints lead to."""
        axis, axis2 = (
            None if a is None else self.direction(a).tolist() for a in (joint.axis, joint.axis2)
        )
        return replace(joint, point=self.point(joint.point).tolist(), axis=axis, axis2=axis2)

    def lay(
        self, joints: Sequence[Joint], last: Sequence[Joint], ends: Sequence[Sequence[float]]
    ) -> None:
        """Lay joints one after the other, by the next one each, the `last` or points at the end."""
        for k, joint in enumerate(joints):
            own, after, values = self.carried(joint), [*joints[k + 1 :], *last], list[float]()
            told = joint.actuated or joint.limits is not None
            if joint.type == "R":
                ways = [] if told else self._ways(own, after, ends)
                values = [self._turn(own, own.axis, ways, joint.zero if told else None)]
            elif joint.type == "P":
                values = [self._slide(own, joint.zero if told else self._length(own, after))]
            elif joint.type == "U" and not told:
                first = self._turn(own, own.axis, [np.array(own.axis2)])
                own = replace(own, axis2=self.direction(joint.axis2 or ()).tolist())
                values = [first, self._turn(own, own.axis2, self._ways(own, after, ends))]
            self.joints.append(replace(own, zero=0.0) if values and joint.freedom == 1 else own)
            self.values.append(values)

    def _ways(
        self, own: Joint, after: Sequence[Joint], ends: Sequence[Sequence[float]]
    ) -> list[np.ndarray]:
        """Vectors of the link that a joint moves, over the size: to the next joint, along its axis,
        to points at the end.
        """
        following = [self.carried(joint) for joint in after[:1]]
        points = [joint.point for joint in following if joint.type != "P"]
        axes = [np.array(joint.axis) for joint in following if joint.axis is not None]
        to, to_ends = (
            [(np.array(p) - own.point) / self.size for p in part]
            for part in (points, map(self.point, ends))
        )
        return [*to, *axes, *to_ends]

    def _turn(
        self,
        own: Joint,
        axis: Sequence[float] | None,
        ways: Sequence[np.ndarray],
        value: float | None = None,
    ) -> float:
        """Turn what follows about an axis of a joint, from a value to 0, or until the first vector
        that is off the axis lies along the simplest one; the value at the reference.
        """
        a = np.array(axis)
        value = -_angle_to_simplest(a, ways) if value is None else value
        if abs(value) > _ROUNDING:
            turn = Pose(np.zeros(3), quaternion_from_axis_angle(a, -value))
            self._step(own.point - turn.apply(np.array(own.point)), turn.quaternion)
        return value

    def _slide(self, own: Joint, value: float) -> float:
        """Slide what follows along a joint's axis, from a value to 0; the value."""
        if abs(value) > _ROUNDING * self.size:
            self._step(-value * np.array(own.axis), _ALONG)
        return value

    def _length(self, own: Joint, after: Sequence[Joint]) -> float:
        """How far, along the axis of a slide, the next joint that is not one is from the one
        before.
        """
        before = [joint.point for joint in self.joints if joint.type != "P"][-1:] or [(0, 0, 0)]
        found = [self.carried(joint).point for joint in after if joint.type != "P"]
        return float(np.dot(own.axis, np.subtract(found[0], before[0]))) if found else 0.0  # type: ignore[arg-type]

    def _step(self, position: np.ndarray, quaternion: Sequence[float]) -> None:
        step = Pose(position, np.array(quaternion))
        self.at = step if self.at is None else step @ self.at


def _angle_to_simplest(axis: np.ndarray, ways: Sequence[np.ndarray]) -> float:
    """The angle about an axis from the first vector off it to the direction across it of which most
    components are zero.
    """
    for way in ways:
        across = way - (way @ axis) * axis
        if np.linalg.norm(across) > _TELLS:
            target = _simplest(axis)
            return float(np.arctan2(axis @ np.cross(across, target), across @ target))
    return 0.0


def _simplest(axis: np.ndarray) -> np.ndarray:
    """The unit vector across an axis of which most components are zero."""
    found = list[np.ndarray]()
    for unit in np.eye(3):
        across = unit - (unit @ axis) * axis
        length = float(np.linalg.norm(across))
        if length > _TELLS:
            found += [across / length, np.cross(axis, across / length)]
    return max(found, key=lambda v: int(np.count_nonzero(np.abs(v) <= _ROUNDING)))


def _without(numbers: np.ndarray, rounding: float) -> np.ndarray:
    return np.where(np.abs(numbers) <= rounding, 0.0, numbers)
