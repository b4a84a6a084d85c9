"""Named coordinates of a pose that vary while the others are held: one meaning in grids, planes and
checks.

    x, y, z       position of the platform origin
    gamma         angle about z from the reference orientation, q = Rz(gamma) q_reference
    rx, ry, rz    components of one rotation vector in the base frame, before the orientation held,
                  q = exp(rx, ry, rz) q_held

rz alone may stand for gamma, from the orientation held on.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.model.mechanism import Mechanism, Motion
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import (
    multiply,
    quaternion_from_axis_angle,
    quaternion_from_rotation_vector,
)

TURNS = ("rx", "ry", "rz")
"""The rotation vector in the base frame before a pose's orientation."""
POSE_AXES: dict[Motion, tuple[str, ...]] = {
    "spatial": ("x", "y", "z", *TURNS),
    "schoenflies": ("x", "y", "z", "gamma", "rz"),
    "planar": ("x", "y", "gamma", "rz"),
    "translation": ("x", "y", "z"),
    "spherical": TURNS,
}
"""What can vary of each motion; rz turns from the orientation held, gamma from the reference's."""
ALL_POSE_AXES = ("x", "y", "z", "gamma", *TURNS)


def varied_pose(
    closure: Closure, held: Mapping[str, Any], varied: Mapping[str, ca.SX]
) -> list[ca.SX]:
    """Values of the closure's pose coordinates, one column each: those of `held` (by the closure's
    names) where the coordinates of `varied` (length unit, radians) leave them.
    """
    found = []
    for c in closure.role("pose"):
        name, value = c.name.removeprefix("pose."), ca.SX(ca.DM(held[c.name]))
        if c.is_rotation:
            turn = ca.vertcat(*(varied.get(n, ca.SX(0)) for n in TURNS))
            found.append(multiply(quaternion_from_rotation_vector(turn), value))
        elif name == "gamma" and "rz" in varied:
            found.append(value + varied["rz"])
        else:
            found.append(varied.get(name, value))
    return found


def pose_at(
    mechanism: Mechanism, base: Sequence[float], varied: Mapping[str, float | np.ndarray]
) -> Pose:
    """The pose `base` (x, y, z, qw, qx, qy, qz) with varied coordinates in the mechanism's units;
    poses (3, n), (4, n) for coordinates (n,).
    """
    shape, angle = np.broadcast_shapes(*map(np.shape, varied.values())), mechanism.angle_in(1.0)

    def column(numbers: Sequence[float]) -> np.ndarray:
        return np.asarray(numbers, dtype=float).reshape(-1, *(1 for _ in shape))

    values = [varied.get(name, value) for name, value in zip("xyz", base[:3], strict=True)]
    quaternion = column(base[3:])
    if "gamma" in varied:
        about_z = quaternion_from_axis_angle((0.0, 0.0, 1.0), varied["gamma"] * angle)
        quaternion = multiply(about_z, column(mechanism.reference_pose.quaternion))
    if set(TURNS) & set(varied):
        turn = [np.broadcast_to(varied.get(name, 0.0), shape) * angle for name in TURNS]
        quaternion = multiply(quaternion_from_rotation_vector(np.stack(turn)), quaternion)
    quaternion = np.asarray(quaternion) / np.linalg.norm(quaternion, axis=0)
    position = np.stack([np.broadcast_to(v, shape) for v in values])
    return Pose(position, np.broadcast_to(quaternion, (4, *shape)))


def given_at(
    mechanism: Mechanism,
    base: Sequence[float] | Mapping[str, Any],
    varied: Mapping[str, float],
    *,
    of_pose: bool,
) -> dict[str, Any]:
    """The arguments of `symkin.solve` where some coordinates are varied and the others are held at
    a base, in the mechanism's units: values by name, a pose, or all actuated joints.
    """
    if isinstance(base, Mapping):
        return {"given": {**base, **varied}}
    if of_pose:
        return {"pose": pose_at(mechanism, base, varied)}
    names = [c.name for c in mechanism.actuated]
    return {"joints": [varied.get(name, v) for name, v in zip(names, base, strict=True)]}


def axis_title(name: str) -> str:
    """A coordinate's name for the axis of a picture, on which an angle says what it means."""
    meaning = "rotation vector " if name in TURNS else "angle about z, " if name == "gamma" else ""
    return f"{meaning}{name}"


def turn_text(names: Collection[str]) -> str:
    """What turns an orientation that is held, to be said after it; empty where nothing does."""
    turned = [name if name in names else "0" for name in TURNS]
    return f" turned by ({', '.join(turned)})" if set(turned) != {"0"} else ""


def angle_meaning(names: Collection[str]) -> str | None:
    """What varied angles mean, as a sentence; None where no angle varies."""
    if set(names) & set(TURNS):
        return (
            "rx, ry, rz: one rotation vector in the base frame, before the orientation that is held"
        )
    return "gamma: angle about z from the reference orientation" if "gamma" in names else None
