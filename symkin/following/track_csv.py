"""Read trajectories from CSV files and write tracks into them: headers are names with units,
`leg1[mm]`, `x[mm]`, `qw`, `euler_ZYX_1[deg]`, `roll[deg]`, `t[s]`.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.files.csv_table import Table, read_table, write_table
from symkin.files.euler_columns import sequenced_columns
from symkin.following.sample import Sample, listed_joints
from symkin.following.track_result import Track
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.position.given import given_coordinates, unknown_name
from symkin.spatial.rotation import quaternion_from_euler

_POSITION, _QUATERNION = ("x", "y", "z"), ("qw", "qx", "qy", "qz")
_TILT = ("azimuth", "tilt", "torsion")
_CHECKS = ("path", "residual", "sigma", "radius")
"""Columns that a track adds; they are left out in reading."""


def read_trajectory(
    mechanism: Mechanism,
    path: str | Path,
    *,
    poses: bool = False,
    given: Mapping[str, float | None] | None = None,
) -> dict[str, Any]:
    """Keyword arguments of `track`: rows of all actuated joints (direct problem); with `poses`, or
    where the joints' columns are missing, poses; columns of the coordinates that `given` names, of
    those without a value. Times where there is a column t; and notes on how the file was read.
    Poses have a quaternion, three angles (`euler_columns`), or, of a platform that keeps its
    orientation, a position alone. Columns of other joints, of checks and of what means nothing are
    left out. Raises InputError.
    """
    known = given_coordinates(mechanism)
    for name in given or ():
        if name not in known:
            raise InputError(unknown_name(mechanism, name, list(known)))
    names = [n for c in mechanism.coordinates for n in _names(c)] + [
        n for n in known if n in (given or ())
    ]
    table = read_table(path)
    angles = sequenced_columns(table, names)
    known_names = [
        "t",
        *names,
        *_POSITION,
        *_QUATERNION,
        *angles.values(),
        *_TILT,
        *_point_names(mechanism),
        *_CHECKS,
    ]
    table = table.matched(list(dict.fromkeys(known_names)), aliases=angles)
    if not len(table):
        raise InputError(
            f"{path}: there are no rows below the header; at least one sample is needed"
        )
    times = table.numbers("t", "time", "s") if "t" in table.columns else None
    back = next((k for k, (a, b) in enumerate(pairwise(times or []), start=1) if b < a), None)
    if back is not None:
        raise InputError(
            f"{path}, line {table.lines[back]}, column 't': the time goes back; times must rise or "
            f"stay"
        )
    if given is not None:
        columns = {
            n: _joint(table, mechanism, known[n]) if value is None else value
            for n, value in given.items()
        }
        return {"given": columns, "times": times, "notes": table.notes}
    if poses or (
        not any(c.name in table.columns for c in mechanism.actuated) and "x" in table.columns
    ):
        positions = _rows(
            [table.numbers(name, "length", mechanism.length_unit) for name in _POSITION]
        )
        quaternions = _quaternions(mechanism, table, list(angles.values()))
        rows = [
            [*position, *quaternion]
            for position, quaternion in zip(positions, quaternions, strict=True)
        ]
        return {"poses": rows, "times": times, "notes": table.notes}
    return {
        "joints": _rows([_joint(table, mechanism, c) for c in mechanism.actuated]),
        "times": times,
        "notes": table.notes,
    }


def _quaternions(mechanism: Mechanism, table: Table, angles: list[str]) -> list[list[float]]:
    """The orientation of each row. Raises InputError for columns of several kinds, and for missing
    ones.
    """
    written = [name for name in (*_QUATERNION, *angles) if name in table.columns]
    sequences = {name.split("_")[1] for name in angles}
    if len(sequences) > 1 or (angles and any(name in table.columns for name in _QUATERNION)):
        raise InputError(
            f"{table.path}: the orientation stands twice, in {', '.join(written)}; leave one out"
        )
    if sequences:
        (sequence,) = sequences
        columns = [table.numbers(f"euler_{sequence}_{k}", "angle", "rad") for k in (1, 2, 3)]
        return list(np.array(quaternion_from_euler(np.array(columns), sequence)).T.tolist())
    if not written and mechanism.motion == "translation":
        return [list(map(float, mechanism.reference_pose.quaternion))] * len(table)
    if not written:
        raise InputError(
            f"{table.path}: there are no columns of the orientation; allowed: qw, qx, qy, qz, or "
            f"roll[deg], pitch[deg], yaw[deg], or "
            f"euler_ZYX_1[deg] to euler_ZYX_3[deg] (any sequence); {table.held()}"
        )
    return _rows([table.numbers(name) for name in _QUATERNION])


def _rows(columns: list[list[float]]) -> list[list[float]]:
    return [list(row) for row in zip(*columns, strict=True)]


def _joint(table: Table, mechanism: Mechanism, c: Coordinate) -> list[float]:
    kind = "angle" if c.is_angular else "length"
    return table.numbers(c.name, kind, mechanism.unit_of(c))


def _names(c: Coordinate) -> list[str]:
    """Column names of a coordinate: of a quaternion its four numbers."""
    return [f"{c.name}.{part}" for part in _QUATERNION] if c.is_rotation else [c.name]


def _point_names(mechanism: Mechanism) -> list[str]:
    return [f"{point.name}.{axis}" for point in mechanism.link_points for axis in _POSITION]


def write_track(track: Track, path: str | Path) -> None:
    """The samples of a track with all joints, pose, points and checks; a file that exists is
    replaced only when all is written.
    """
    mechanism = track.trajectory.mechanism
    length, angle = mechanism.length_unit, mechanism.angle_unit
    timed = track.trajectory.times is not None
    headers = ["t[s]"] if timed else []
    for c in listed_joints(track.problem):
        unit = "" if c.is_rotation else f"[{mechanism.unit_of(c)}]"
        headers += [name + unit for name in _names(c)]
    if mechanism.platform_link is not None:
        headers += [*(f"{name}[{length}]" for name in _POSITION), *_QUATERNION]
    headers += [f"{c.name}[{angle}]" for c in _told_angles(track)] + [
        f"{name}[{length}]" for name in _point_names(mechanism)
    ]
    headers += ["path", f"residual[{length}]", "sigma", f"radius[{length}]"]
    write_table(path, headers, [_row(track, sample, timed) for sample in track.samples])


def _told_angles(track: Track) -> list[Coordinate]:
    """Angles of the platform's pose along which the path is told."""
    return [c for c in track.problem.known_coordinates if c.role == "condition" and c.is_angular]


def _row(track: Track, sample: Sample, timed: bool) -> list[object]:
    row: list[object] = [sample.time] if timed else []
    for value in sample.joints.values():
        row += value if isinstance(value, list) else [value]
    written = sample.to_dict()
    if written["pose"] is not None:
        row += [*written["pose"]["position"], *written["pose"]["quaternion"]]
    slices, mechanism = track.problem.closure.slices, track.trajectory.mechanism
    row += [
        mechanism.angle_out(float(sample.values[slices[c.name].start])) for c in _told_angles(track)
    ]
    row += [number for point in sample.points.values() for number in point]
    radius = "" if sample.radius is None else sample.radius
    return [*row, sample.parameter, sample.residual, sample.smallest_singular_value, radius]
