"""How far a start lies from what it led to."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from symkin.position.given import pose_from
from symkin.position.problem import Problem
from symkin.position.solution import Solution

_FAR = 0.2
"""A start further from the configuration that it led to than this (of the size, or rad) is
noted.
"""


def start_notes(found: Solution, problem: Problem, start: Any) -> tuple[str, ...]:
    """A note where the start that the user gives is far from what it led to: values by name, else a
    pose of the direct problem, joints in file order of the inverse one.
    """
    mechanism = found.mechanism
    if not isinstance(start, Mapping):
        if problem.by_name:
            return ()
        names = [c.name for c in mechanism.actuated]
        start = {"pose": start} if problem.of_joints else dict(zip(names, start, strict=True))
    far = [
        f"{name} by {mechanism.angle_out(gap):.3g} {mechanism.angle_unit}"
        if angular
        else f"{name} by {gap:.3g} {mechanism.length_unit}"
        for name, gap, angular in _gaps(found, start)
        if gap > _FAR * (1.0 if angular else mechanism.characteristic_length)
    ]
    return (
        (f"the start lies far from the configuration that it led to: {', '.join(far)}",)
        if far
        else ()
    )


def _gaps(found: Solution, start: Mapping[str, Any]) -> Iterator[tuple[str, float, bool]]:
    """How far each value lies from the start's (rad, or length unit), and whether it is an
    angle.
    """
    kinds = {c.name: c for c in found.mechanism.coordinates}
    for name, value in start.items():
        there = found.joints.get(name)
        if isinstance(there, float):
            gap = found.mechanism.value_in(kinds[name], there - float(value))
            angular = kinds[name].is_angular
            yield name, abs(math.remainder(gap, 2 * math.pi) if angular else gap), angular
        elif name == "pose":
            pose = pose_from(value, "start")
            away = np.asarray(pose.position) - found.position
            turn = 2 * math.acos(min(1.0, abs(float(np.dot(pose.quaternion, found.quaternion)))))
            yield "position", float(np.linalg.norm(away)), False
            yield "orientation", turn, True
