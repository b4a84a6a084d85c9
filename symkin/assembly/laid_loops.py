"""The rows of a loop, or of a limb at a pose, as they are where it lies along the frame's axes.

Legs that stand turned about a base are alike but for numbers there, and a planar loop writes no
more rows than its plane has, wherever that stands. The loop is moved as one, with the platform's
pose where that is given: its rows are then others that vanish together with its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symkin.closure.closure import random_points
from symkin.errors import MechanismError
from symkin.model.changed import displaced
from symkin.model.joint import BASE
from symkin.model.mechanism import Mechanism
from symkin.position.groups import structure_groups
from symkin.position.problem import Problem, build_problem
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, quaternion_from_matrix

_ROUNDING = 1e-12
"""Component of a direction, and length over the size, that is rounding of the turn."""
_TELLS = 1e-3
"""Length of a vector across an axis, over the size, that tells a direction."""
_SAMPLES = 8
"""Random points for each row at which two sets of rows are compared."""
_SAME, _LEAST = 1e-9, 1e-6
"""What is left of rows, of the largest, that are combinations of others; the smallest singular
value, of the largest, of combinations that lose none.
"""


@dataclass(frozen=True, eq=False)
class LaidLoop:
    """The `problem` of a group's loop where it is laid, by a displacement of all that it is."""

    problem: Problem
    displacement: Pose

    def known(self, known: np.ndarray) -> np.ndarray:
        """Known values there from those of the group (n, known): joints, or the platform's pose."""
        if all(c.role != "pose" for c in self.problem.known_coordinates):
            return known
        by = self.displacement
        turned = multiply(np.asarray(by.quaternion)[:, None], known[:, 3:].T)
        return np.hstack([np.array([by.apply(x) for x in known[:, :3]]), np.stack(turned, axis=1)])


def laid_loop(group: Problem) -> LaidLoop | None:
    """A group's loop where it is laid; None where that is not known to have the same solutions."""
    loop = _limb_of(group) if group.of_pose else _loop_of(group)
    by = None if loop is None else _displacement(loop)
    if loop is None or by is None:
        return None
    names = tuple(c.name for c in group.known_coordinates)
    laid = build_problem(
        displaced(loop, by, rounding=_ROUNDING), names, None if group.of_pose else ()
    )
    own = {c.name for c in group.system.unknowns}
    parts = (g for g in structure_groups(laid) if own == {c.name for c in g.system.unknowns})
    found = next((LaidLoop(part, by) for part in parts), None)
    return found if found is not None and _is_same(group, found) else None


def _limb_of(group: Problem) -> Mechanism | None:
    """The limb of a group at a pose, as a machine of its own."""
    mechanism, own = group.mechanism, {c.name for c in group.system.unknowns}
    limbs = [
        limb
        for limb in mechanism.limbs
        if not own.isdisjoint(c.name for joint in limb.joints for c in joint.coordinates)
    ]
    if mechanism.motion != "spatial" or len(limbs) != 1:
        return None
    return replace(mechanism, limbs=limbs, dh=None, example=None)


def _loop_of(group: Problem) -> Mechanism | None:
    """The joints of a group of which joints are known, with the joints and rods that close its
    loops, as a machine of their own.
    """
    mechanism, coordinates = group.mechanism, (*group.known_coordinates, *group.system.unknowns)
    if any(
        c.body is not None or c.role == "pose" or c.kind not in ("angle", "length")
        for c in coordinates
    ):
        return None
    own, held = {c.name for c in coordinates}, {c.name for c in group.closure.coordinates}
    touched = {BASE}
    for entry in mechanism.link_joints:
        if not own.isdisjoint(c.name for c in entry.joint.coordinates):
            touched |= set(entry.links)
    joints = [
        entry
        for entry in mechanism.link_joints
        if touched >= set(entry.links) and {c.name for c in entry.joint.coordinates} & held <= own
    ]
    rods = [
        rod
        for rod in mechanism.link_rods
        if touched >= set(rod.links) and (not rod.actuated or rod.name in own)
    ]
    try:
        return Mechanism(
            mechanism.name,
            link_joints=joints,
            link_rods=rods,
            length_unit=mechanism.length_unit,
            angle_unit=mechanism.angle_unit,
        )
    except MechanismError:
        return None


def _displacement(loop: Mechanism) -> Pose | None:
    """The displacement that lays a loop: its first axis along z, what is off that along x, by its
    joints' axes, then by their points.
    """
    joints = list(loop.all_joints)
    axes = [np.array(a) for joint in joints for a in (joint.axis, joint.axis2) if a is not None]
    points = [np.array(joint.point) for joint in joints if joint.point is not None]
    if not axes or not points:
        return None
    z = axes[0] / np.linalg.norm(axes[0])
    ways = [*axes, *((p - points[0]) / loop.characteristic_length for p in points)]
    across = (way - (way @ z) * z for way in ways)
    x = next((a / np.linalg.norm(a) for a in across if np.linalg.norm(a) > _TELLS), None)
    if x is None:
        return None
    turn = np.array([x, np.cross(z, x), z])
    return Pose(-turn @ points[0], quaternion_from_matrix(turn))


def _is_same(group: Problem, laid: LaidLoop) -> bool:
    """Whether two groups have the same unknowns and known values, and the rows of one are
    combinations of those of the other in which none is lost, at random points.
    """
    other = laid.problem
    whole = (*group.system.unknowns, *group.known_coordinates)
    there = (*other.system.unknowns, *other.known_coordinates)
    if [replace(c, reference=()) for c in whole] != [replace(c, reference=()) for c in there]:
        return False
    size = group.system.characteristic_length
    count = _SAMPLES * int(group.system.rows.shape[0] + other.system.rows.shape[0])
    points, known = np.split(random_points(whole, size, count), [group.system.width], axis=1)
    own, _ = group.system.linearise(points, known)
    rows, _ = other.system.linearise(points, laid.known(known))
    combined, _, rank, _ = np.linalg.lstsq(rows, own, rcond=_LEAST)
    singular = np.linalg.svd(combined, compute_uv=False)
    return bool(
        rank == rows.shape[1] <= own.shape[1]
        and singular[-1] > _LEAST * singular[0]
        and np.max(np.abs(rows @ combined - own)) <= _SAME * np.max(np.abs(own))
    )
