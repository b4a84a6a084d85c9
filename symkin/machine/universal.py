"""Find pairs of revolute joints that are a universal joint: their axes meet, and the link between
them holds nothing else.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from symkin.closure.branches import Branch, Element, chains_of, edges_of
from symkin.model.graph import LinkJoint
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism

_MEETS = 1e-12
"""Distance of two axes that meet, over the size: rounding of points and directions."""
_PARALLEL = 1e-3
"""Sine of the angle below which two axes are too nearly parallel for a joint of two."""


@dataclass(frozen=True)
class Reading:
    """A coordinate as it is written, `name`: a coordinate of the machine, and `zero` more."""

    name: str
    of: str
    zero: float


def with_universal_joints(
    mechanism: Mechanism, kept: Collection[str]
) -> tuple[Mechanism, tuple[Reading, ...]]:
    """The mechanism with a universal joint for each such pair, and what the revolutes read. Joints
    of the names `kept`, actuated and coupled ones stay; so do three axes in a row that meet, which
    are a ball.
    """
    coupled = {n for coupling in mechanism.couplings for n in (coupling.joint, *coupling.names)}
    owner = {joint.name: limb.name for limb in mechanism.limbs for joint in limb.joints}
    named = {point.link for point in mechanism.link_points} | {mechanism.platform_link or ""}
    pairs = [
        (ends, a, b)
        for chain in chains_of(list(edges_of(mechanism)), named)
        for ends, a, b in _pairs(chain, {*kept, *coupled}, mechanism.characteristic_length)
        if owner.get(a.name) == owner.get(b.name)
    ]
    if not pairs:
        return mechanism, ()
    taken = {joint.name for joint in mechanism.all_joints}
    taken |= {c.name for c in mechanism.coordinates}
    first: dict[str, Joint] = {}
    links: dict[str, tuple[str, str]] = {}
    gone, readings = set[str](), list[Reading]()
    for ends, a, b in pairs:
        one = _one(a, b, taken)
        taken |= {one.name, *(c.name for c in one.coordinates)}
        first[a.name], links[a.name] = one, ends
        gone.add(b.name)
        readings += [
            Reading(joint.name, c.name, joint.zero)
            for joint, c in zip((a, b), one.coordinates, strict=True)
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


def _pairs(
    chain: Branch, stay: Collection[str], size: float
) -> Iterator[tuple[tuple[str, str], Joint, Joint]]:
    """Two joints in a row that make one, where no third one beside them does: the links on both
    sides, and the joints as they move the second of these.
    """
    joints = [_outward(element) for element in chain.elements]
    links = (chain.ends[0], *chain.links, chain.ends[1])
    meets = [False, *(_meet(a, b, stay, size) for a, b in pairwise(joints)), False]
    for k, (a, b) in enumerate(pairwise(joints)):
        first, last = links[k], links[k + 2]
        if a is None or b is None or first == last or not meets[k + 1] or meets[k] or meets[k + 2]:
            continue
        if chain.elements[k].along or chain.elements[k + 1].along:
            yield (first, last), a, b
        else:
            backward = [element.part for element in chain.elements[k : k + 2]]
            yield (last, first), backward[1], backward[0]  # type: ignore[misc]


def _outward(element: Element) -> Joint | None:
    """A revolute joint as it moves its second link on the way; None of anything else."""
    joint = element.part
    if not isinstance(joint, Joint) or joint.type != "R" or joint.axis is None:
        return None
    return joint if element.along else replace(joint, axis=tuple(-c for c in joint.axis))


def _meet(a: Joint | None, b: Joint | None, stay: Collection[str], size: float) -> bool:
    """Whether two joints may be one: passive, free, their axes at an angle through one point."""
    if a is None or b is None or any(j.actuated or j.name in stay for j in (a, b)):
        return False
    normal, away = np.cross(_axis(a), _axis(b)), np.subtract(b.point, a.point)
    sine = float(np.linalg.norm(normal))
    return sine > _PARALLEL and float(abs(normal @ away)) <= _MEETS * sine * size


def _axis(joint: Joint) -> np.ndarray:
    return np.array(joint.axis, dtype=float)


def _one(a: Joint, b: Joint, taken: Collection[str]) -> Joint:
    """The universal joint of two revolutes, under a name of its own."""
    name = f"{a.name}_{b.name}"
    while {name, f"{name}.1", f"{name}.2"} & set(taken):
        name += "_"
    away, normal = np.subtract(b.point, a.point), np.cross(_axis(a), _axis(b))
    along = float(np.cross(away, _axis(b)) @ normal) / float(normal @ normal)
    meeting = np.array(a.point) + along * _axis(a)
    written = [p for p in (a.point, b.point) if _is_at(p, meeting, along)]
    at: Sequence[float] = written[0] if written else meeting.tolist()
    return Joint(name, "U", at, a.axis, axis2=b.axis)


def _is_at(point: Sequence[float], meeting: np.ndarray, along: float) -> bool:
    """Whether a written point is where the axes meet, to rounding."""
    scale = max(abs(along), float(np.max(np.abs(meeting))), float(np.max(np.abs(point))))
    return float(np.linalg.norm(meeting - point)) <= _MEETS * scale
