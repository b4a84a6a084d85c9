"""Displace a mechanism: the same machine at another place of its base frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symkin.model.graph import LinkJoint
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose


def displaced(mechanism: Mechanism, by: Pose) -> Mechanism:
    """The same machine with every point and axis, and the platform, moved by a displacement of the
    base frame, without its table of DH and its example.

    >>> import symkin
    >>> up = symkin.Pose.from_euler([0.0, 0.0, 50.0], [0.0, 0.0, 0.0])
    >>> displaced(symkin.load("zhang2009"), up).limbs[0].base
    (0.0, -275.0, 50.0)
    """

    def turn(v: Sequence[float] | None) -> tuple[float, ...] | None:
        return None if v is None else tuple(by.turn(np.array(v, dtype=float)).tolist())

    def at(point: Sequence[float]) -> tuple[float, ...]:
        return tuple(by.apply(np.array(point, dtype=float)).tolist())

    def joint(j: Joint) -> Joint:
        return replace(j, point=at(j.point), axis=turn(j.axis), axis2=turn(j.axis2))

    def limb(item: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(item, RodLimb):
            return replace(item, base=at(item.base))
        rods = [replace(rod, start=at(rod.start)) for rod in item.rods]
        return replace(item, joints=[joint(j) for j in item.joints], rods=rods)

    home = by @ mechanism.reference_pose
    # without a platform there is no frame to move
    frame = (
        {}
        if mechanism.platform_link is None and not mechanism.serial
        else {
            "platform_position": tuple(np.asarray(home.position).tolist()),
            "platform_quaternion": tuple(np.asarray(home.quaternion).tolist()),
        }
    )
    return replace(
        mechanism,
        limbs=[limb(item) for item in mechanism.limbs],
        link_joints=[LinkJoint(joint(item.joint), item.links) for item in mechanism.link_joints],
        link_rods=[
            replace(item, start=at(item.start), end=at(item.end)) for item in mechanism.link_rods
        ],
        link_points=[replace(item, point=at(item.point)) for item in mechanism.link_points],
        dh=None,
        example=None,
        **frame,  # type: ignore[arg-type]
    )
