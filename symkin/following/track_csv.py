"""Read trajectories from CSV files and write tracks into them: headers are names with units, `leg1[mm]`, `x[mm]`, `qw`,
`t[s]`."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.files.csv_table import Table, read_table, write_table
from symkin.following.sample import Sample
from symkin.following.track_result import Track
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_POSITION, _QUATERNION = ("x", "y", "z"), ("qw", "qx", "qy", "qz")
_CHECKS = ("path", "residual", "sigma", "radius")
"""Columns that a track adds; they are left out in reading."""


def read_trajectory(mechanism: Mechanism, path: str | Path, *, poses: bool = False) -> dict[str, Any]:
    """Keyword arguments of `track`: rows of all actuated joints (direct problem) or, with `poses` or where the joints' columns
    are missing, poses; times where there is a column t; and notes on how the file was read. Columns of other joints, of checks
    and of what means nothing are left out. Raises InputError."""
    coordinates = build_closure(mechanism).role("actuated", "passive")
    table = read_table(path).matched(["t", *(n for c in coordinates for n in _names(c)), *_POSITION, *_QUATERNION, *_CHECKS])
    if not len(table):
        raise InputError(f"{path}: there are no rows below the header; at least one sample is needed")
    times = table.numbers("t", "time", "s") if "t" in table.columns else None
    back = next((k for k, (a, b) in enumerate(pairwise(times or []), start=1) if b < a), None)
    if back is not None:
        raise InputError(f"{path}, line {table.lines[back]}, column 't': the time goes back; times must rise or stay")
    if poses or (not any(c.name in table.columns for c in mechanism.actuated) and "x" in table.columns):
        columns = [table.numbers(name, "length", mechanism.length_unit) for name in _POSITION]
        columns += [table.numbers(name) for name in _QUATERNION]
        return {"poses": _rows(columns), "times": times, "notes": table.notes}
    return {"joints": _rows([_joint(table, mechanism, c) for c in mechanism.actuated]), "times": times, "notes": table.notes}


def _rows(columns: list[list[float]]) -> list[list[float]]:
    return [list(row) for row in zip(*columns, strict=True)]


def _joint(table: Table, mechanism: Mechanism, c: Coordinate) -> list[float]:
    if c.is_angular:
        return table.numbers(c.name, "angle", mechanism.angle_unit)
    return table.numbers(c.name, "length", mechanism.length_unit)


def _names(c: Coordinate) -> list[str]:
    """Column names of a coordinate: of a quaternion its four numbers."""
    return [f"{c.name}.{part}" for part in _QUATERNION] if c.kind == "quaternion" else [c.name]


def write_track(track: Track, path: str | Path) -> None:
    """The samples of a track with all joints, pose and checks; a file that exists is replaced only when all is written."""
    mechanism = track.trajectory.mechanism
    length, angle = mechanism.length_unit, mechanism.angle_unit
    timed = track.trajectory.times is not None
    headers = ["t[s]"] if timed else []
    for c in build_closure(mechanism).role("actuated", "passive"):
        unit = "" if c.kind == "quaternion" else f"[{angle}]" if c.is_angular else f"[{length}]"
        headers += [name + unit for name in _names(c)]
    headers += [f"{name}[{length}]" for name in _POSITION] + [
        *_QUATERNION,
        "path",
        f"residual[{length}]",
        "sigma",
        f"radius[{length}]",
    ]
    write_table(path, headers, [_row(sample, timed) for sample in track.samples])


def _row(sample: Sample, timed: bool) -> list[object]:
    row: list[object] = [sample.time] if timed else []
    for value in sample.joints.values():
        row += value if isinstance(value, list) else [value]
    pose = sample.to_dict()["pose"]
    radius = "" if sample.radius is None else sample.radius
    return [
        *row,
        *pose["position"],
        *pose["quaternion"],
        sample.parameter,
        sample.residual,
        sample.smallest_singular_value,
        radius,
    ]
