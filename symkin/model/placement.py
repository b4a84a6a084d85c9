"""Move the points of joints along their axes to where they belong.

Any point of a joint's axis describes the same joint. A description by common normals puts points of
nearly parallel axes wherever the axes come nearest: axes that are off parallel by 1e-4 rad meet
hundreds of metres away. Such points are moved along their axes to where the limb's points are
nearest to each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from symkin.model.joint import Joint

_NEARLY_PARALLEL = 0.02
"""Sine of the angle below which two axes of neighbouring joints do not say where along them their
points are.
"""


def placed_points(joints: Sequence[Joint], end: np.ndarray) -> dict[str, np.ndarray]:
    """A point of each joint of a limb at the reference: on axes that are nearly parallel to a
    neighbour's those that make the sum of squared distances between neighbours least, the limb's
    `end` included. The point of a P joint, which holds nothing, is the one nearest to the joint
    before it.
    """
    points = {joint.name: np.array(joint.point) for joint in joints}
    loose = _loose(joints)
    held = [joint for joint in joints if joint.type != "P"]
    moved = [joint for joint in held if joint.name in loose]
    if moved:
        shifts = _shifts(held, moved, end)
        points |= {
            j.name: points[j.name] + s * np.array(j.axis)
            for j, s in zip(moved, shifts, strict=True)
        }
    # a P joint's point holds nothing: the foot of the perpendicular from the joint before it will
    # do
    for before, joint in pairwise([*(held or joints)[:1], *joints]):
        if joint.type == "P" and joint.name in loose:
            axis = np.array(joint.axis)
            points[joint.name] += axis * float(axis @ (points[before.name] - points[joint.name]))
    return points


def _loose(joints: Sequence[Joint]) -> set[str]:
    """Joints of one axis that is nearly parallel to that of a neighbour."""
    found: set[str] = set()
    for a, b in pairwise(joints):
        if a.axis is None or b.axis is None or "U" in (a.type, b.type):
            continue
        if float(np.linalg.norm(np.cross(a.axis, b.axis))) < _NEARLY_PARALLEL:
            found |= {a.name, b.name}
    return found


def _shifts(joints: Sequence[Joint], moved: Sequence[Joint], end: np.ndarray) -> np.ndarray:
    """Distances along their axes by which the `moved` joints' points come nearest to their
    neighbours'; the least ones where several do.
    """
    column = {joint.name: k for k, joint in enumerate(moved)}
    # least sum of |p_(i+1) + s_(i+1) a_(i+1) - p_i - s_i a_i|^2: a linear least-squares problem in
    # the shifts s
    points = [*(np.array(joint.point) for joint in joints), end]
    rows = np.zeros((3 * len(joints), len(moved)))
    gaps = np.concatenate([b - a for a, b in pairwise(points)])
    for i, joint in enumerate(joints):
        if joint.name in column:
            rows[3 * i : 3 * i + 3, column[joint.name]] = joint.axis
            if i > 0:
                rows[3 * i - 3 : 3 * i, column[joint.name]] = -np.array(joint.axis)
    return np.linalg.lstsq(rows, gaps, rcond=None)[0]
