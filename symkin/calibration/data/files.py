"""Read and write measurements as CSV: names and units in the header, one row a configuration, empty
cells for no reading.

group                               configurations of one text have equal inclination; empty: none
leg1[mm], theta1[deg], ...          one column for each actuated joint, by its name, no cell empty
alpha[deg], beta[deg]               inclination, R = Rz(gamma) Ry(beta) Rx(alpha)
x[mm], y[mm], z[mm]                 position of the platform frame in the base frame, any of them
qw, qx, qy, qz                      its orientation, a unit quaternion; or
euler_ZYX_1[deg], ..._2, ..._3      Euler angles, the sequence in the header: capitals about moving
                                    axes, small letters about fixed ones; euler_1[deg], ... where
                                    the sequence is not known; roll[deg], pitch[deg], yaw[deg] are
                                    euler_xyz_1[deg], ...
NAME[deg], NAME[mm]                 an encoder on a passive joint, by its name
point.NAME.x[mm], ...               a named point in the base frame, any of the three
distance.A.B[mm]                    distance between two named points
LINK.x[mm], ..., LINK.qw, ...       displacement of another link than the platform's from the
                                    reference, and its orientation
LINK.alpha[deg], LINK.beta[deg]     its inclination
distance_NAME[mm]                   distance between a point of the platform and one of the base,
                                    which are given beside the file (`DistancePoints`)
sigma_COLUMN                        standard deviations, by column: sigma_leg1[mm],
                                    sigma_alpha[deg], sigma_x[mm]; besides sigma_group[deg] and
                                    sigma_orientation[deg] (each component of a rotation vector)
Where a joint has the name of a reading, the reading is written platform.NAME.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symkin.calibration.data.columns import WEDGE, ColumnReader, DistancePoints, reading_name
from symkin.calibration.data.measurements import NO_GROUP, Measurements
from symkin.calibration.data.observables import (
    PLATFORM,
    ParameterKind,
    of_joint,
    unit_of,
    value_out,
)
from symkin.errors import InputError
from symkin.files.csv_table import read_table, table_text
from symkin.files.euler_columns import SEQUENCES
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.spatial.rotation import euler_from_quaternion, quaternion_from_euler
from symkin.text import first_of, not_among


@dataclass(frozen=True, eq=False)
class DataFile:
    """The content of a file: measurements in radians and the mechanism's length unit, whose
    labels name the lines. `sequence` is the Euler sequence that the
    header names; where it names none, the measurements have no orientation yet. `euler` (n, 3)
    holds the angles (radians) of any sequence, `wedges` (n, 2) a plan's inclinations, `copies` rows
    (from 0) that repeat an earlier one in every cell, with that one.
    """

    path: str
    measurements: Measurements
    sequence: str | None
    wedges: np.ndarray | None
    notes: tuple[str, ...]
    euler: np.ndarray | None = None
    copies: tuple[tuple[int, int], ...] = ()

    def subset(self, rows: np.ndarray) -> DataFile:
        """Keep some of the rows, by number from 0."""

        tables = {k: v[rows] for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        some = self.measurements.subset(rows)
        return replace(self, measurements=some, copies=(), **tables)

    def without_copies(self) -> DataFile:
        """Leave out rows that repeat an earlier one in every cell, with a note that names their
        lines: a copy is no new measurement; it would make degrees of freedom too many and standard
        deviations too small.
        """
        if not self.copies:
            return self
        labels = self.measurements.labels
        kept = np.setdiff1d(np.arange(len(labels)), [row for row, _ in self.copies])
        pairs = [f"{labels[row]} of {labels[first]}" for row, first in self.copies]
        if len(kept) == 1:
            raise InputError(
                f"{self.path}: all rows are copies of {labels[0]}; one posture determines "
                f"no geometry"
            )
        note = (
            f"left out, copies of earlier rows in every cell: {first_of(pairs)}; a copy is no new "
            f"measurement"
        )
        return replace(self.subset(kept), notes=(note, *self.notes))

    @property
    def open_euler(self) -> np.ndarray | None:
        """The angles whose sequence the header does not name."""
        return self.euler if self.sequence is None else None

    def with_sequence(self, sequence: str) -> Measurements:
        """Read the open Euler angles in a sequence, and return the measurements with them."""
        if self.open_euler is None:
            return self.measurements
        return replace(self.measurements, orientation=euler_quaternions(self.open_euler, sequence))


def read_measurements(
    path: str | Path, mechanism: Mechanism, distances: Mapping[str, DistancePoints] | None = None
) -> DataFile:
    """Read a CSV file; `distances` are the points of its columns distance_NAME. Raises InputError
    that names file, line and column.
    """
    require_mechanism(mechanism)
    table = read_table(path)
    reader = ColumnReader(table, mechanism, distances or {})
    if not len(table):
        raise InputError(
            f"{path}: the file has a header and no row; one row for each posture is needed"
        )
    groups = reader.groups()
    readings: dict[str, Any] = {}
    for kind, o in PLATFORM.items():
        if kind != "group" and (reading := reader.read(o)) is not None:
            readings[kind] = reading.values
        readings[f"{kind}_sigma"] = reader.sigmas(o)
    sequence, angles = reader.euler()
    if angles is not None and "orientation" in readings:
        raise InputError(
            f"{path}: the orientation stands twice, as quaternion and as Euler angles; give one of "
            f"them"
        )
    if angles is not None and sequence is not None:
        readings["orientation"] = euler_quaternions(angles, sequence)
    measurements = Measurements(
        reader.joints(),
        groups=groups,
        readings=reader.beside(),
        joint_sigma=reader.joint_sigmas(),
        labels=tuple(f"line {line}" for line in table.lines),
        **readings,
    )
    return DataFile(
        path=str(path),
        measurements=measurements,
        sequence=sequence,
        wedges=reader.together(WEDGE, "angle"),
        notes=tuple(reader.notes),
        euler=angles,
        copies=reader.copies,
    )


def euler_quaternions(angles: np.ndarray, sequence: str) -> np.ndarray:
    """Convert Euler angles (n, 3) in radians to unit quaternions (n, 4); NaN stays NaN."""
    return np.ascontiguousarray(quaternion_from_euler(angles.T, sequence).T)


# --- writing --------------------------------------------------------------------------------------


def measurements_text(
    mechanism: Mechanism,
    measurements: Measurements,
    *,
    sequence: str | None = None,
    hidden: bool = False,
    comments: Sequence[str] = (),
) -> str:
    """Write readings in the mechanism's units as CSV text; orientations as quaternions or, with
    `sequence`, as Euler angles, whose headers leave the sequence out when it is `hidden`.
    """
    if sequence is not None and sequence not in SEQUENCES:
        raise InputError(f"Euler sequence {not_among(sequence, SEQUENCES)}")
    table = CsvColumns(mechanism)
    if measurements.groups is not None:
        table.text("group", *("" if g == NO_GROUP else g + 1 for g in measurements.groups))
    joints = [of_joint(c) for c in mechanism.actuated]
    for o, values in zip(joints, measurements.joints.T, strict=True):
        table.number(o.name, values, o.measure)
    channels = measurements.channels(mechanism)
    for o, r in (channel for channel in channels if channel[0].kind != "group"):
        columns, values = o.columns, r.values
        kind: ParameterKind = "number" if r.is_orientation else o.measure
        if not o.of:
            columns = tuple(reading_name(mechanism, name) for name in columns)
        if o is PLATFORM["orientation"] and sequence is not None:
            begin, kind = "euler_" if hidden else f"euler_{sequence}_", "angle"
            columns = tuple(begin + k for k in "123")
            values = euler_from_quaternion(values.T, sequence).T
        for k, name in enumerate(columns):
            table.number(name, values[:, k], kind)
    sigmas = [(o, r.sigma) for o, r in channels]
    if measurements.joint_sigma is not None:
        of_joints = np.asarray(measurements.joint_sigma)[:, :, None]
        sigmas = [*zip(joints, of_joints.transpose(1, 0, 2), strict=True), *sigmas]
    for o, sigma in sigmas:
        for k, name in enumerate(o.sigmas if sigma is not None else ()):
            table.number(f"sigma_{name}", np.asarray(sigma)[:, k], o.measure)
    return table.csv(comments)


class CsvColumns:
    """Gathers columns for a CSV text: numbers with all their digits, NaN as an empty cell."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.columns: list[tuple[object, ...]] = []

    def text(self, *column: object) -> None:
        """Add a header and the cells below it."""
        self.columns.append(column)

    def number(self, name: str, values: np.ndarray, kind: ParameterKind) -> None:
        unit = unit_of(self.mechanism, kind)
        out = (value_out(self.mechanism, kind, float(v)) for v in values)
        self.text(f"{name}[{unit}]" if unit else name, *("" if np.isnan(v) else v for v in out))

    def csv(self, comments: Sequence[str]) -> str:
        notes = (f"# {comment}\n" for comment in comments)
        headers, *rows = zip(*self.columns, strict=True)
        return "".join((*notes, *table_text(headers, iter(rows))))
