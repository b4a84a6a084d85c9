"""Solutions as rows of a table: pose or joints, limits, condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from symkin.position.problem import Problem
from symkin.position.solution import Solution

_MOST_COLUMNS = 16
"""Coordinates of a graph that a table shows; the JSON holds all."""


def solution_columns(problem: Problem, solutions: Sequence[Solution]) -> tuple[list[str], list[list[str]]]:
    """Header and rows for the solutions of one problem; both are empty where there is no solution."""
    if not solutions:
        return [], []
    columns = {"#": [str(k + 1) for k in range(len(solutions))], **_coordinate_columns(problem, solutions)}
    if any(s.within_limits is not None for s in solutions):
        columns["limits"] = ["inside" if s.within_limits else "outside" for s in solutions]
    columns["condition"] = [f"{s.condition:.3g}" for s in solutions]
    if all(s.hits is not None for s in solutions):
        columns["hits"] = [str(s.hits) for s in solutions]
    return list(columns), [list(row) for row in zip(*columns.values(), strict=True)]


def _coordinate_columns(problem: Problem, solutions: Sequence[Solution]) -> dict[str, list[str]]:
    """What differs between the solutions: pose where there is one and it is not given, named points, then joints."""
    columns: dict[str, list[str]] = {}
    if solutions[0].has_platform and problem.name != "inverse":
        columns |= _pose_columns(solutions)
    size = problem.mechanism.characteristic_length
    rows = [s.points for s in solutions]
    for name in rows[0]:
        columns |= {f"{name} {axis}": [_length(size, row[name][i]) for row in rows] for i, axis in enumerate("xyz")}
    columns |= _joint_columns(problem, solutions)
    return dict(list(columns.items())[:_MOST_COLUMNS]) if problem.mechanism.is_graph else columns


def _pose_columns(solutions: Sequence[Solution]) -> dict[str, list[str]]:
    mechanism = solutions[0].mechanism
    unit = mechanism.length_unit
    columns = {
        f"{axis}, {unit}": [_length(mechanism.characteristic_length, s.position[i]) for s in solutions]
        for i, axis in enumerate("xyz")
    }
    if mechanism.motion in ("schoenflies", "planar"):
        values = [mechanism.angle_out(s.values["pose.gamma"]) for s in solutions]
        return columns | {f"gamma, {mechanism.angle_unit}": [_fixed(v, 3) for v in values]}
    if mechanism.motion == "translation":
        return columns
    return columns | {name: [_fixed(s.quaternion[i], 5) for s in solutions] for i, name in enumerate(("qw", "qx", "qy", "qz"))}


def _joint_columns(problem: Problem, solutions: Sequence[Solution]) -> dict[str, list[str]]:
    """Joint coordinates that are one number and were not given."""
    mechanism = problem.mechanism
    given = {c.name for c in problem.known_coordinates}
    digits = 3 if mechanism.characteristic_length > 10 else 5
    rows = [s.printed_joints for s in solutions]
    names = [name for name, value in rows[0].items() if name not in given and isinstance(value, float)]
    return {name: [_fixed(row[name], digits) for row in rows] for name in names}


def _length(size: float, value: float) -> str:
    return _fixed(value, 3 if size > 10 else 6)


def _fixed(value: float, digits: int) -> str:
    """Fixed digits without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def given_text(given: Mapping[str, Any]) -> str:
    """The given values: `joints 1, 2, 3`, `crank 60`."""
    return (
        "; ".join(f"{key} {', '.join(f'{v:.7g}' for v in np.ravel(values))}" for key, values in given.items()) or "nothing given"
    )
