"""Whether a start mode is the path's."""

from __future__ import annotations

import math

import numpy as np

from symkin.errors import InputError
from symkin.following.trajectory import Trajectory
from symkin.position.solution import Solution

_OFF_START = 1e-6
"""A start mode's given values may differ from the path's first sample by this (of the size, or rad)."""


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
