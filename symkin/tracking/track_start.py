"""Whether a start mode is the path's, and how far a start lies from the mode that it led to."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from symkin.errors import InputError
from symkin.position.given import pose_from
from symkin.position.problem import Kind
from symkin.position.solution import Solution
from symkin.spatial.pose import Pose
from symkin.tracking.trajectory import Trajectory

_OFF_START = 1e-6
"""A start mode's given values may differ from the path's first sample by this (of the size, or rad)."""
_FAR = 0.2
"""A start further from the mode that it led to than this (of the size, or rad) is noted."""


def check_start(trajectory: Trajectory, mode: Solution) -> None:
    mechanism = trajectory.mechanism
    if mode.mechanism != mechanism:
        raise InputError(f"start: the solution is one of {mode.mechanism.name}, the path one of {mechanism.name}")
    place = 0
    for c in trajectory.coordinates:
        wanted, own = trajectory.samples[0][place : place + c.width], np.atleast_1d(np.asarray(mode.values[c.name], dtype=float))
        place += c.width
        if c.kind == "quaternion":
            off = min(float(np.max(np.abs(own - wanted))), float(np.max(np.abs(own + wanted))))
        elif c.kind == "angle":
            off = abs(math.remainder(own[0] - wanted[0], 2 * math.pi))
        else:
            off = abs(float(own[0] - wanted[0])) / (1.0 if c.is_angular else mechanism.size)
        if not off <= _OFF_START:
            shown = [mechanism.angle_out(float(v)) if c.is_angular else float(v) for v in (own[0], wanted[0])]
            raise InputError(
                f"start: the solution has {c.name} = {shown[0]:.9g}, the path begins at {shown[1]:.9g}; the start must be a "
                "mode of the path's first sample"
            )


def start_notes(mode: Solution, kind: Kind, start: Solution | Sequence[float] | Pose | None) -> tuple[str, ...]:
    """A note where the start that the user gives, a pose (direct problem) or joints, is far from the mode that it led to."""
    if start is None or isinstance(start, Solution):
        return ()
    mechanism = mode.mechanism
    if kind == "direct":
        pose = pose_from(start, "start")
        away = float(np.linalg.norm(np.asarray(pose.position) - np.asarray(mode.position)))
        angle = 2 * math.acos(min(1.0, abs(float(np.dot(pose.quaternion, mode.quaternion)))))
    else:
        given = list(start)  # type: ignore[arg-type]
        pairs = [(c, float(a) - float(b)) for c, a, b in zip(mechanism.actuated, given, mode.actuated, strict=True)]
        away = max((abs(d) for c, d in pairs if not c.is_angular), default=0.0)
        turns = [abs(math.remainder(mechanism.angle_in(d), 2 * math.pi)) for c, d in pairs if c.is_angular]
        angle = max(turns, default=0.0)
    if away <= _FAR * mechanism.size and angle <= _FAR:
        return ()
    parts = [f"{away:.3g} {mechanism.length_unit}"] if away > 0.0 else []
    parts += [f"{mechanism.angle_out(angle):.3g} {mechanism.angle_unit}"] if angle > 0.0 else []
    return (f"the start lies {' and '.join(parts)} from the mode that it led to, which is the one followed",)
