"""Coordinates of poses that can be swept: those of the platform's motion.

A pose is that of `base`, with x, y, z replaced. gamma is the angle about z from the reference orientation,
q = Rz(gamma) q_reference; (rx, ry, rz) is a rotation vector of the base frame, q = exp(r) q_base.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from symkin.errors import InputError
from symkin.model.closure import build_closure
from symkin.model.mechanism import Mechanism, Motion
from symkin.position.given import given_from
from symkin.position.pose_conditions import TURNS, condition_sentence, poses_vary
from symkin.singularities.motion_ranks import generic_ranks
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply, quaternion_from_rotation_vector

_AXES: dict[Motion, tuple[str, ...]] = {
    "spatial": ("x", "y", "z", *TURNS),
    "schoenflies": ("x", "y", "z", "gamma", "rz"),
    "planar": ("x", "y", "gamma", "rz"),
    "translation": ("x", "y", "z"),
    "spherical": TURNS,
}
"""What can be swept of each motion; rz turns from the orientation of `base`, gamma from the reference's."""
ALL_POSE_AXES = ("x", "y", "z", "gamma", *TURNS)


def pose_units(mechanism: Mechanism) -> dict[str, str]:
    """Names that can be swept, with their units."""
    return {n: mechanism.length_unit if n in "xyz" else mechanism.angle_unit for n in _AXES[mechanism.motion]}


def pose_at(mechanism: Mechanism, base: Sequence[float], swept: Mapping[str, float]) -> Pose:
    """The pose `base` (x, y, z, qw, qx, qy, qz) with swept coordinates in the mechanism's units."""
    position = [swept.get(name, value) for name, value in zip("xyz", base[:3], strict=True)]
    quaternion = np.asarray(base[3:])
    if "gamma" in swept:
        half = 0.5 * mechanism.angle_in(swept["gamma"])
        about_z = np.array([math.cos(half), 0.0, 0.0, math.sin(half)])
        quaternion = np.asarray(multiply(about_z, mechanism.reference_pose.quaternion))
    turn = [mechanism.angle_in(swept.get(name, 0.0)) for name in TURNS]
    if any(turn):
        quaternion = np.asarray(multiply(quaternion_from_rotation_vector(np.array(turn)), quaternion))
    return Pose(np.array(position), quaternion)


def check_poses(mechanism: Mechanism, base: Sequence[float], values: Mapping[str, np.ndarray]) -> None:
    """Raises InputError where no point, or hardly any, is a pose that the mechanism can take: the angle is given twice, `base`
    lies off the platform's motion, or its joints put a condition on what is swept."""
    if "gamma" in values and "rz" in values:
        raise InputError(
            "grid: gamma and rz are given together; they are the same angle, from the reference's orientation or at's"
        )
    off = given_from(mechanism, None, base).off_motion
    if off > 0.0:
        raise InputError(
            f"at: the pose lies off the {mechanism.motion} motion of {mechanism.name}'s platform by {off:.3g} {mechanism.length_unit}, "
            "so that no point has a solution; allowed: poses of that motion"
        )
    _check_conditions(mechanism, base, values)


def _check_conditions(mechanism: Mechanism, base: Sequence[float], values: Mapping[str, np.ndarray]) -> None:
    swept = [name for name, v in values.items() if v[-1] > v[0]]
    freedoms = generic_ranks(mechanism).outputs
    coordinates = sum(c.freedom for c in build_closure(mechanism).role("pose"))
    if not swept or freedoms >= coordinates:
        return
    held = pose_at(mechanism, base, {name: float(v[0]) for name, v in values.items() if name not in swept})
    box = tuple(_side(mechanism, name, values[name]) for name in swept)
    if poses_vary(mechanism, (*held.position.tolist(), *held.quaternion.tolist()), box) is False:
        instead = "actuated joints (without --poses)"
        raise InputError(f"grid: {condition_sentence(mechanism, _listed(swept), instead, freedoms, coordinates)}")


def _side(mechanism: Mechanism, name: str, values: np.ndarray) -> tuple[str, float, float]:
    """A swept coordinate by the closure's name, its bounds in length units and rad."""
    low, high = float(values[0]), float(values[-1])
    if name in "xyz":
        return name, low, high
    own = "gamma" if mechanism.motion in ("schoenflies", "planar") else name
    return own, mechanism.angle_in(low), mechanism.angle_in(high)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
