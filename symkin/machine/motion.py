"""Find the motion that joints leave a platform in all configurations: in a plane, which is turned
into that of x and y, or about a point.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from symkin.closure.branches import chains_of, edges_of
from symkin.model.displaced import displaced
from symkin.model.graph import LinkJoint
from symkin.model.joint import BASE, Joint
from symkin.model.limb import RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose

_ALIGNED = 1e-12
"""Sine of the angle off parallel and off normal of axes that are it, and distance, over the size,
of an axis from a point of it: rounding.
"""
_Z = np.array([0.0, 0.0, 1.0])


def with_own_motion(mechanism: Mechanism, *, declare: bool) -> tuple[Mechanism, Pose | None]:
    """The machine with z normal to the plane in which its joints leave the platform to move, or all
    links; and the turn of the base frame, None where there is none. With `declare` the platform's
    motion is declared.
    """
    if mechanism.motion != "spatial" or mechanism.serial:
        return mechanism, None
    chains = list(_chains_to_platform(mechanism))
    of_platform = _first(_normal, chains)
    normal = _normal(_all_joints(mechanism)) if of_platform is None else of_platform
    if normal is None:
        about = declare and any(_is_about(mechanism, chain) for chain in chains)
        return replace(mechanism, motion="spherical") if about else mechanism, None
    turn = _turn_to_z(normal)
    placed = mechanism if turn is None else _aligned(displaced(mechanism, turn))
    known = declare and of_platform is not None
    return replace(placed, motion="planar") if known else placed, turn


def _chains_to_platform(mechanism: Mechanism) -> Iterator[list[Joint] | None]:
    """The joints of each chain from the base to the platform; None of one with a rod."""
    platform = mechanism.platform_link
    if platform is None:
        return
    for chain in chains_of(list(edges_of(mechanism)), {platform}):
        if set(chain.ends) == {BASE, platform}:
            parts = [element.part for element in chain.elements]
            yield parts if all(isinstance(part, Joint) for part in parts) else None  # type: ignore[misc]


def _all_joints(mechanism: Mechanism) -> list[Joint] | None:
    """The joints of a machine without rods."""
    rods = any(isinstance(limb, RodLimb) or limb.rods for limb in mechanism.limbs)
    return None if rods or mechanism.link_rods else list(mechanism.all_joints)


def _normal(joints: Sequence[Joint] | None) -> np.ndarray | None:
    """The axis to which revolute joints are parallel, and slides normal; None where there is none,
    and without a revolute joint.
    """
    parts = [joint for joint in joints or () if joint.type != "weld"]
    axes = [np.array(joint.axis) for joint in parts if joint.type == "R"]
    slides = [np.array(joint.axis) for joint in parts if joint.type == "P"]
    if not axes or len(axes) + len(slides) < len(parts):
        return None
    normal = axes[0]
    fits = all(np.linalg.norm(np.cross(axis, normal)) <= _ALIGNED for axis in axes)
    return normal if fits and all(abs(slide @ normal) <= _ALIGNED for slide in slides) else None


def _first(
    found: Callable[[Sequence[Joint] | None], np.ndarray | None],
    chains: Iterable[Sequence[Joint] | None],
) -> np.ndarray | None:
    return next((axis for axis in map(found, chains) if axis is not None), None)


def _is_about(mechanism: Mechanism, joints: Sequence[Joint] | None) -> bool:
    """Whether revolute joints and balls alone, all at the origin of the platform's frame, carry
    it.
    """
    parts = [joint for joint in joints or () if joint.type != "weld"]
    centre = np.array(mechanism.platform_position)
    near = _ALIGNED * mechanism.characteristic_length
    return bool(parts) and all(_passes(joint, centre, near) for joint in parts)


def _passes(joint: Joint, centre: np.ndarray, near: float) -> bool:
    """Whether a joint turns about a point alone."""
    away = np.subtract(joint.point, centre)
    if joint.type in ("S", "U"):
        return float(np.linalg.norm(away)) <= near
    return joint.type == "R" and float(np.linalg.norm(np.cross(joint.axis, away))) <= near  # type: ignore[arg-type]


def _turn_to_z(normal: np.ndarray) -> Pose | None:
    """The shortest turn that makes an axis that of z; None where it is that."""
    up = normal if normal[2] >= 0.0 else -normal
    if float(np.linalg.norm(np.cross(up, _Z))) <= _ALIGNED:
        return None
    # w = cos, v = sin of half the angle times the axis, both times 2 cos of half the angle
    quaternion = np.array([1.0 + up[2], *np.cross(up, _Z)])
    return Pose(np.zeros(3), quaternion / np.linalg.norm(quaternion))


def _aligned(mechanism: Mechanism) -> Mechanism:
    """The machine with axes that are along z, or slides normal to it, to rounding so to the last
    digit.
    """
    limbs = [
        limb
        if isinstance(limb, RodLimb)
        else replace(limb, joints=[_exact(joint) for joint in limb.joints])
        for limb in mechanism.limbs
    ]
    entries = [LinkJoint(_exact(entry.joint), entry.links) for entry in mechanism.link_joints]
    return replace(mechanism, limbs=limbs, link_joints=entries)


def _exact(joint: Joint) -> Joint:
    if joint.axis is None or joint.type not in ("R", "P"):
        return joint
    x, y, z = joint.axis
    if np.hypot(x, y) <= _ALIGNED:
        return replace(joint, axis=(0.0, 0.0, np.sign(z)))
    return replace(joint, axis=(x, y, 0.0)) if abs(z) <= _ALIGNED else joint
