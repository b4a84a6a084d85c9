"""Find revolute joints that are a universal joint, two whose axes meet, or a ball, three whose axes
meet at right angles: the links between them hold nothing else.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import casadi as ca
import numpy as np

from symkin.closure.branches import Branch, Element, chains_of, edges_of
from symkin.model.graph import LinkJoint
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.backend import atan2, cross, dot, where
from symkin.spatial.rotation import conjugate, multiply, quaternion_from_axis_angle, rotate

_MEETS = 1e-12
"""Distance of two axes that meet, over the size: rounding of points and directions."""
_PARALLEL = 1e-3
"""Sine of the angle below which two axes are too nearly parallel for a joint of two."""

_PAIR, _BALL = 2, 3
"""Revolute joints that are a universal joint, and a ball."""


@dataclass(frozen=True)
class Reading:
    """A coordinate as it is written, `name`: a coordinate of the machine, and `zero` more."""

    name: str
    of: str
    zero: float

    @property
    def names(self) -> tuple[str, ...]:
        return (self.name,)

    def values(self, value: ca.SX) -> dict[str, ca.SX]:
        """What is read at a value of the machine's coordinate."""
        return {self.name: value + self.zero}

    def value(self, read: Mapping[str, ca.SX]) -> ca.SX:
        """The machine's coordinate where this is read."""
        return read[self.name] - self.zero


@dataclass(frozen=True)
class BallReading:
    """Three revolute `joints` as they are written, from the first link on, of which a ball of the
    machine, `of`, is the turn. Of the two triples of angles of a turn the one is told whose second
    angle is next to the reference.
    """

    joints: tuple[Joint, Joint, Joint]
    of: str

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    @property
    def name(self) -> str:
        return ", ".join(self.names)

    def values(self, turn: ca.SX) -> dict[str, ca.SX]:
        """What is read at a unit quaternion of the ball."""
        a, b, c = (ca.DM(_axis(joint)) for joint in self.joints)
        ahead = cross(b, a)
        # a and c are normal to b: the second angle is that from a to the turned c, less the first
        start = atan2(dot(ahead, c), dot(a, c))
        away = ca.acos(ca.fmax(ca.fmin(dot(a, rotate(turn, c)), 1.0), -1.0))
        one, other = _wrapped(away - start), _wrapped(-away - start)
        second = where(ca.fabs(one) <= ca.fabs(other), one, other)
        middle = quaternion_from_axis_angle(b, second)
        first = _angle_about(a, rotate(middle, c), rotate(turn, c))
        rest = multiply(conjugate(multiply(quaternion_from_axis_angle(a, first), middle)), turn)
        third = 2.0 * atan2(dot(c, rest[1:]), rest[0])
        angles = (first, second, _wrapped(third))
        return {j.name: j.zero + t for j, t in zip(self.joints, angles, strict=True)}

    def value(self, read: Mapping[str, ca.SX]) -> ca.SX:
        """The unit quaternion of the ball where these are read."""
        one, two, three = (
            quaternion_from_axis_angle(ca.DM(_axis(j)), read[j.name] - j.zero) for j in self.joints
        )
        return multiply(multiply(one, two), three)


def _wrapped(angle: ca.SX) -> ca.SX:
    return atan2(ca.sin(angle), ca.cos(angle))


def _angle_about(axis: ca.DM, start: ca.SX, end: ca.SX) -> ca.SX:
    """The angle about an axis from a direction to another; any where these are along it."""
    flat = start - axis * dot(axis, start)
    return atan2(dot(cross(axis, flat), end), dot(flat, end))


def with_universal_joints(
    mechanism: Mechanism, kept: Collection[str]
) -> tuple[Mechanism, tuple[Reading | BallReading, ...]]:
    """The mechanism with a universal joint, or a ball, for each such pair or triple, and what the
    revolutes read. Joints of the names `kept`, actuated and coupled ones stay; so do three axes in
    a row that meet otherwise, of which a pair would be a choice.
    """
    coupled = {n for coupling in mechanism.couplings for n in (coupling.joint, *coupling.names)}
    owner = {joint.name: limb.name for limb in mechanism.limbs for joint in limb.joints}
    named = {point.link for point in mechanism.link_points} | {mechanism.platform_link or ""}
    runs = [
        (ends, joints)
        for chain in chains_of(list(edges_of(mechanism)), named)
        for ends, joints in _runs(chain, {*kept, *coupled}, mechanism.characteristic_length)
        if len({owner.get(joint.name) for joint in joints}) == 1
    ]
    if not runs:
        return mechanism, ()
    taken = {joint.name for joint in mechanism.all_joints}
    taken |= {c.name for c in mechanism.coordinates}
    first: dict[str, Joint] = {}
    links: dict[str, tuple[str, str]] = {}
    gone, readings = set[str](), list[Reading | BallReading]()
    for ends, joints in runs:
        one = _one(joints, taken)
        taken |= {one.name, *(c.name for c in one.coordinates)}
        first[joints[0].name], links[joints[0].name] = one, ends
        gone |= {joint.name for joint in joints[1:]}
        if len(joints) == _BALL:
            readings.append(BallReading((joints[0], joints[1], joints[2]), one.coordinates[0].name))
            continue
        readings += [
            Reading(joint.name, c.name, joint.zero)
            for joint, c in zip(joints, one.coordinates, strict=True)
        ]
    limbs = [
        limb if isinstance(limb, RodLimb) else replace(limb, joints=_merged(limb, first, gone))
        for limb in mechanism.limbs
    ]
    entries = [
        LinkJoint(first[entry.joint.name], links[entry.joint.name])
        if entry.joint.name in first
        else entry
        for entry in mechanism.link_joints
        if entry.joint.name not in gone
    ]
    return replace(mechanism, limbs=limbs, link_joints=entries, dh=None), tuple(readings)


def _merged(limb: Limb, first: dict[str, Joint], gone: set[str]) -> list[Joint]:
    """The joints of a limb, in their order from its first link."""
    return [first.get(joint.name, joint) for joint in limb.joints if joint.name not in gone]


def _runs(
    chain: Branch, stay: Collection[str], size: float
) -> Iterator[tuple[tuple[str, str], list[Joint]]]:
    """Two joints in a row that make one, where no third one beside them does, and three that are a
    ball: the links on both sides, and the joints as they move the last of these.
    """
    joints = [_outward(element) for element in chain.elements]
    links = (chain.ends[0], *chain.links, chain.ends[1])
    meets = [False, *(_meet(a, b, stay, size) for a, b in pairwise(joints)), False]
    for k in range(len(joints)):
        count = next(n for n in range(1, len(joints) + 1) if not meets[k + n])
        own = [joint for joint in joints[k : k + count] if joint is not None]
        first, last = links[k], links[k + count]
        if meets[k] or first == last or not (count == _PAIR or _is_ball(own, size)):
            continue
        elements = chain.elements[k : k + count]
        if any(element.along for element in elements):
            yield (first, last), own
        else:
            yield (last, first), [element.part for element in reversed(elements)]  # type: ignore[misc]


def _is_ball(joints: Sequence[Joint], size: float) -> bool:
    """Whether three joints turn the last link in every way about one point: in each by two triples
    of angles.
    """
    if len(joints) != _BALL or any(joint.limits is not None for joint in joints):
        return False
    (a, b, c), near = joints, _MEETS * size
    square = all(abs(_axis(b) @ _axis(other)) <= _MEETS for other in (a, c))
    return square and float(np.linalg.norm(_crossing(a, b) - _crossing(c, b))) <= near


def _crossing(a: Joint, b: Joint) -> np.ndarray:
    """The point of an axis where it meets another one."""
    away, normal = np.subtract(b.point, a.point), np.cross(_axis(a), _axis(b))
    along = float(np.cross(away, _axis(b)) @ normal) / float(normal @ normal)
    return np.array(a.point) + along * _axis(a)


def _outward(element: Element) -> Joint | None:
    """A revolute joint as it moves its second link on the way; None of anything else."""
    joint = element.part
    if not isinstance(joint, Joint) or joint.type != "R":
        return None
    return joint if element.along else joint.turned()


def _meet(a: Joint | None, b: Joint | None, stay: Collection[str], size: float) -> bool:
    """Whether two joints may be one: passive, free, their axes at an angle through one point."""
    if a is None or b is None or any(j.actuated or j.name in stay for j in (a, b)):
        return False
    normal, away = np.cross(_axis(a), _axis(b)), np.subtract(b.point, a.point)
    sine = float(np.linalg.norm(normal))
    return sine > _PARALLEL and float(abs(normal @ away)) <= _MEETS * sine * size


def _axis(joint: Joint) -> np.ndarray:
    return np.array(joint.axis, dtype=float)


def _one(joints: Sequence[Joint], taken: Collection[str]) -> Joint:
    """The joint that two or three revolutes are, under a name of its own."""
    name = "_".join(joint.name for joint in joints)
    while {name, f"{name}.1", f"{name}.2"} & set(taken):
        name += "_"
    meeting = _crossing(joints[0], joints[1])
    written = [joint.point for joint in joints if _is_at(joint.point, meeting, joints[0])]
    at: Sequence[float] = written[0] if written else meeting.tolist()
    if len(joints) == _BALL:
        return Joint(name, "S", at)
    return Joint(name, "U", at, joints[0].axis, axis2=joints[1].axis)


def _is_at(point: Sequence[float], meeting: np.ndarray, first: Joint) -> bool:
    """Whether a written point is where the axes meet, to rounding."""
    along = float(np.linalg.norm(meeting - first.point))
    scale = max(along, float(np.max(np.abs(meeting))), float(np.max(np.abs(point))))
    return float(np.linalg.norm(meeting - point)) <= _MEETS * scale
