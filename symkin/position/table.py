"""Solutions as rows of a table: pose or joints, limits, condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.model.keys import ABOUT_Z
from symkin.model.mechanism import Mechanism
from symkin.position.pose_coordinates import leaves_motion
from symkin.position.problem import Problem
from symkin.position.solution import DOUBLE_NOTE, Solution
from symkin.text import counted

Columns = dict[str, list[str]]
"""Cells by the title of their column."""
_ROUNDING = 1e-13
"""What counts as rounding beside the largest number of a list."""


@dataclass(frozen=True)
class Table:
    """Header and rows of solutions; `left_out` says what the table does not show, empty where it
    shows all.
    """

    header: list[str]
    rows: list[list[str]]
    left_out: str = ""


def solution_table(
    problem: Problem,
    solutions: Sequence[Solution],
    everything: bool = False,
    numbers: Sequence[int] | None = None,
) -> Table:
    """The solutions of one problem, with their `numbers` where they are some of a list: pose and
    actuated joints, or what else tells them apart; `everything`: all coordinates and named points.
    Empty where there is no solution.
    """
    if not solutions:
        return Table([], [])
    shown, points, passive = _coordinate_columns(problem, solutions)
    kept = points | passive if everything else _needed(shown, points, passive)
    left = (
        ""
        if everything
        else _left_out([t for t in points if t not in kept], [t for t in passive if t not in kept])
    )
    columns = {"#": [str(k) for k in numbers or range(1, len(solutions) + 1)], **shown, **kept}
    if any(s.within_limits is not None for s in solutions):
        columns["limits"] = ["in" if s.within_limits else "out" for s in solutions]
    columns["condition"] = [f"{s.condition:.3g}" for s in solutions]
    if any(DOUBLE_NOTE in s.notes for s in solutions):
        columns["multiplicity"] = ["double" if DOUBLE_NOTE in s.notes else "" for s in solutions]
    if all(s.hits is not None for s in solutions):
        columns["hits"] = [str(s.hits) for s in solutions]
    return Table(list(columns), [list(row) for row in zip(*columns.values(), strict=True)], left)


def _coordinate_columns(
    problem: Problem, solutions: Sequence[Solution]
) -> tuple[Columns, Columns, Columns]:
    """What differs between solutions: the pose where there is one that is not given, with actuated
    joints; named points; other joints.
    """
    mechanism = problem.mechanism
    pose = _pose_columns(solutions) if solutions[0].has_platform and not problem.gives_pose else {}
    points: Columns = {}
    for name in solutions[0].points:
        for i, axis in enumerate("xyz"):
            values = [s.points[name][i] for s in solutions]
            points[f"{name}.{axis} [{mechanism.length_unit}]"] = [
                _length(mechanism, v) for v in values
            ]
    actuated, passive = _joint_columns(problem, solutions)
    return pose | actuated, points, passive


def _needed(shown: Columns, points: Columns, passive: Columns) -> Columns:
    """Of points and passive joints those without which nothing would be shown, or two solutions
    would look the same.
    """
    kept = {} if shown else points or passive
    rows = list(zip(*(shown | kept).values(), strict=True))
    for title, cells in {**passive, **points}.items():
        if title not in kept and len(set(rows)) < len(rows):
            longer = [(*row, cell) for row, cell in zip(rows, cells, strict=True)]
            if len(set(longer)) > len(set(rows)):
                kept, rows = kept | {title: cells}, longer
    return kept


def _left_out(points: Sequence[str], passive: Sequence[str]) -> str:
    counts = [
        (len(passive), "passive joint"),
        (len({p.rpartition(".")[0] for p in points}), "named point"),
    ]
    told = " and ".join(counted(count, what) for count, what in counts if count)
    return f"{told} not shown: --all, or summary(everything=True)" if told else ""


def _pose_columns(solutions: Sequence[Solution]) -> Columns:
    mechanism = solutions[0].mechanism
    columns = {
        f"{axis} [{mechanism.length_unit}]": [_length(mechanism, s.position[i]) for s in solutions]
        for i, axis in enumerate("xyz")
    }
    position = np.array([s.position for s in solutions])
    if leaves_motion(mechanism, position, np.array([s.quaternion for s in solutions])):
        return columns | _turn_columns(solutions)
    if mechanism.motion in ABOUT_Z:
        values = [mechanism.angle_out(s.gamma) for s in solutions]
        return columns | {f"gamma [{mechanism.angle_unit}]": [_fixed(v, 3) for v in values]}
    if mechanism.motion == "translation":
        return columns
    return columns | _turn_columns(solutions)


def _turn_columns(solutions: Sequence[Solution]) -> Columns:
    return {
        name: [_fixed(s.quaternion[i], 5) for s in solutions]
        for i, name in enumerate(("qw", "qx", "qy", "qz"))
    }


def _joint_columns(problem: Problem, solutions: Sequence[Solution]) -> tuple[Columns, Columns]:
    """Joint coordinates that are one number and were not given: the actuated ones, and the
    others.
    """
    mechanism = problem.mechanism
    given = {c.name for c in problem.known_coordinates}
    actuated = {c.name for c in mechanism.actuated}
    units = {c.name: mechanism.unit_of(c) for c in mechanism.coordinates}
    digits = 3 if mechanism.characteristic_length > 10 else 5
    rows = [s.printed_joints for s in solutions]
    names = [
        name for name, value in rows[0].items() if name not in given and isinstance(value, float)
    ]
    cells = {name: [_fixed(row[name], digits) for row in rows] for name in names}
    titled = {
        name: (f"{name} [{units[name]}]" if name in units else name, column)
        for name, column in cells.items()
    }
    return tuple(
        dict(titled[name] for name in names if (name in actuated) == which)
        for which in (True, False)
    )  # type: ignore[return-value]


def _length(mechanism: Mechanism, value: float) -> str:
    return _fixed(value, 3 if mechanism.characteristic_length > 10 else 5)


def _fixed(value: float, digits: int) -> str:
    """Fixed digits without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def given_text(given: Mapping[str, Any]) -> str:
    """The given values: `joints 1, 2, 3`, `crank 60`; roundings beside the largest number of a list
    are zeros.
    """
    return (
        "; ".join(
            f"{key} {', '.join(f'{v:.7g}' for v in without_rounding(values))}"
            for key, values in given.items()
        )
        or "nothing given"
    )


def without_rounding(values: Any) -> list[float]:
    """Numbers for a text, with zeros for those that are only rounding beside the largest."""
    numbers = np.ravel(values)
    least = _ROUNDING * np.max(np.abs(numbers), initial=0.0)
    return [0.0 if abs(v) < least else float(v) for v in numbers]
