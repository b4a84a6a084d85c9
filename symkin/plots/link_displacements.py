"""Displacements of a limb's links from the reference: NumPy only, base frame, length unit, radians.

A limb of n joints has n + 1 links; link 0 is the base, link n the platform. Each link's
displacement is a product of joint displacements M, taken from the base up to the limb's cut joint
and from the platform back to it, so that no coordinate of a cut joint is needed: D_i = D_(i-1) M_i
before the cut, D_(i-1) = D_i M_i^-1 behind it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symkin.model.joint import Joint
from symkin.model.limb import AnyLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import rotate
from symkin.spatial.screw import turn_about


def joint_displacement(joint: Joint, values: Sequence[Any]) -> Pose:
    """The joint's displacement from the reference at its coordinate values (radians, length unit,
    unit quaternion).
    """
    at = np.array(joint.point)
    if joint.type == "S":
        q = np.asarray(values[0], dtype=float)
        return Pose(at - rotate(q, at), q)
    axis = np.array(joint.axis)
    match joint.type:
        case "P":
            return _slide(axis, values[0] - joint.zero)
        case "H":
            angle = values[0] - joint.zero
            return _slide(axis, joint.pitch * angle / (2 * np.pi)) @ turn_about(at, axis, angle)
        case "C":
            return _slide(axis, values[1]) @ turn_about(at, axis, values[0])
        case "U":
            return turn_about(at, axis, values[0]) @ turn_about(
                at, np.array(joint.axis2), values[1]
            )
        case _:
            return turn_about(at, axis, values[0] - joint.zero)


def link_displacements(
    mechanism: Mechanism, limb: AnyLimb, values: Mapping[str, Any], pose: Pose
) -> list[Pose]:
    """Displacements of the limb's n + 1 links from the reference, base first.

    Joints whose coordinates are not among `values` are the cut ones. Between two cut joints
    (spherical both) the links' spin about the line through them is free: they are turned the
    shortest way from where the joints before leave them.
    """
    joints, n = limb.joints, len(limb.joints)
    cut = [
        i for i, joint in enumerate(joints) if any(c.name not in values for c in joint.coordinates)
    ]
    first, last = (cut[0], cut[-1]) if cut else (n, n)
    moves = {
        i: joint_displacement(joint, [values[c.name] for c in joint.coordinates])
        for i, joint in enumerate(joints)
        if i not in cut
    }
    before = [Pose.identity()]
    for i in range(first):
        before.append(before[-1] @ moves[i])
    if not cut:
        return before
    behind = [pose @ mechanism.reference_pose.inverse()]
    for i in range(n - 1, last, -1):
        behind.insert(0, behind[0] @ moves[i].inverse())
    inner = [moves[i] for i in range(first + 1, last)]
    return [
        *before,
        *(
            _between(before[-1], behind[0], joints[first], joints[last], inner)
            if last > first
            else []
        ),
        *behind,
    ]


def _slide(axis: np.ndarray, distance: float) -> Pose:
    return Pose(distance * axis, np.array([1.0, 0.0, 0.0, 0.0]))


def _between(
    before: Pose, behind: Pose, first: Joint, last: Joint, moves: Sequence[Pose]
) -> list[Pose]:
    """Displacements of the links between two cut spherical joints, whose centres the links before
    and behind hold.
    """
    chain = [Pose.identity()]
    for move in moves:
        chain.append(chain[-1] @ move)
    start, end = before.apply(np.array(first.point)), behind.apply(np.array(last.point))
    turn = _shortest_turn(before.apply(chain[-1].apply(np.array(last.point))) - start, end - start)
    placed = Pose(start - rotate(turn, start), turn) @ before
    return [placed @ step for step in chain]


def _shortest_turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Unit quaternion of the smallest rotation that takes the direction of a to that of b."""
    lengths = float(np.linalg.norm(a) * np.linalg.norm(b))
    if lengths == 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    q = np.array([lengths + float(a @ b), *np.cross(a, b)])
    if np.linalg.norm(q) < 1e-8 * lengths:
        normal = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        q = np.array([0.0, *normal])
    return np.asarray(q / np.linalg.norm(q))
