"""Choose and judge the home of a platform on six rods: the pose about which code is tuned and
tested.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from symkin.codegen.map.rod_platform import rod_values
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.given import pose_from
from symkin.position.problem import actuated_names, build_problem
from symkin.position.solve import solve
from symkin.spatial.pose import Pose

SINGULAR_HOME = 1e6
"""Condition of the direct problem above which a pose is no home: cold starts from there fail, and
tests prove nothing.
"""
_REMEDY = (
    "give a regular pose within the limits by --home X,Y,Z,QW,QX,QY,QZ, or by [platform] position "
    "or [example] pose in the file"
)


def home_pose(mechanism: Mechanism, home: Sequence[float] | None) -> Pose:
    """The first of: the given home; the example's start (direct problems), its pose, the pose that
    its joints lead to; the reference. Raises InputError where that pose is singular or its joint
    values are outside their limits.
    """
    source, pose = _first(mechanism, home)
    reason = _refusal(mechanism, pose)
    if reason is not None:
        numbers = ",".join(f"{v + 0.0:.6g}" for v in (*pose.position, *pose.quaternion))
        raise InputError(f"{mechanism.name}: home {numbers} ({source}) {reason}; {_REMEDY}")
    return pose


def _first(mechanism: Mechanism, home: Sequence[float] | None) -> tuple[str, Pose]:
    """Where home comes from, and home."""
    if home is not None:
        return "--home", pose_from(home, "home")
    example = mechanism.example
    if example is not None and example.joints is not None and example.start is not None:
        return "[example] start", pose_from(example.start)
    if example is not None and example.pose is not None:
        return "[example] pose", pose_from(example.pose)
    if example is not None and example.joints is not None:
        result = solve(mechanism, joints=example.joints, check=False)
        if result.status == "ok" and result.solution is not None:
            return "the pose of [example] joints", _rounded(
                result.solution.pose, mechanism.characteristic_length
            )
    return "the reference pose", mechanism.reference_pose


def _rounded(pose: Pose, size: float) -> Pose:
    """To nine digits of the size, so that home is the same number on every machine."""
    position = np.round(np.asarray(pose.position, dtype=float), 9 - math.ceil(math.log10(size)))
    quaternion = np.round(np.asarray(pose.quaternion, dtype=float), 9)
    return Pose(position, quaternion / np.linalg.norm(quaternion))


def _refusal(mechanism: Mechanism, pose: Pose) -> str | None:
    """Why a pose is no home, or None."""
    direct = build_problem(mechanism, actuated_names(mechanism))
    joints = rod_values(mechanism, pose)
    unknown = np.concatenate(
        [np.asarray(pose.position, dtype=float), np.asarray(pose.quaternion, dtype=float)]
    )
    condition = direct.system.condition(unknown, joints)
    if not condition <= SINGULAR_HOME:
        return f"is singular (condition {condition:.2g}; allowed: up to {SINGULAR_HOME:.0e})"
    for c, value in zip(direct.known_coordinates, joints, strict=True):
        slack = 1e-9 * mechanism.characteristic_length
        if c.limits is not None and not c.limits[0] - slack <= value <= c.limits[1] + slack:
            return (
                f"has {c.name} = {value:.6g} {mechanism.length_unit}, outside its limits "
                f"[{c.limits[0]:.6g}, {c.limits[1]:.6g}]"
            )
    return None
