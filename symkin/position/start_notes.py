"""How far a start lies from what it led to."""

from __future__ import annotations

import math

import numpy as np

from symkin.position.given import Joints, in_file_order, pose_from
from symkin.position.problem import Kind
from symkin.position.solution import Solution
from symkin.spatial.pose import Pose

_FAR = 0.2
"""A start further from the configuration that it led to than this (of the size, or rad) is
noted.
"""


def start_notes(found: Solution, kind: Kind, start: Joints | Pose) -> tuple[str, ...]:
    """A note where the start that the user gives, a pose (direct problem) or joints, is far from
    what it led to.
    """
    mechanism = found.mechanism
    if kind == "direct":
        pose = pose_from(start, "start")
        away = float(np.linalg.norm(np.asarray(pose.position) - np.asarray(found.position)))
        angle = 2 * math.acos(min(1.0, abs(float(np.dot(pose.quaternion, found.quaternion)))))
    else:
        given = list(in_file_order(mechanism, start))  # type: ignore[arg-type]
        pairs = [
            (c, float(a) - float(b))
            for c, a, b in zip(mechanism.actuated, given, found.actuated_values, strict=True)
        ]
        away = max((abs(d) for c, d in pairs if not c.is_angular), default=0.0)
        turns = [
            abs(math.remainder(mechanism.angle_in(d), 2 * math.pi))
            for c, d in pairs
            if c.is_angular
        ]
        angle = max(turns, default=0.0)
    if away <= _FAR * mechanism.characteristic_length and angle <= _FAR:
        return ()
    parts = [f"{away:.3g} {mechanism.length_unit}"] if away > 0.0 else []
    parts += [f"{mechanism.angle_out(angle):.3g} {mechanism.angle_unit}"] if angle > 0.0 else []
    return (f"the start lies {' and '.join(parts)} from the configuration that it led to",)
