"""Read the columns of a measurement file one by one; every mistake names file, line and column
(formats: see `files`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from symkin.calibration.data.column_names import (
    DISTANCE,
    INCLINATION,
    POSITION,
    QUATERNION,
    WEDGE,
    Measure,
    columns_of_platform_link,
    known_readings,
    measure_of,
    reading_name,
    refuse_misspelt,
    unit_of,
)
from symkin.calibration.data.measurements import NO_GROUP, Reading
from symkin.calibration.data.observables import Observable, observables
from symkin.errors import InputError
from symkin.files.csv_dialect import listed
from symkin.files.csv_table import UNITS, Table
from symkin.files.euler_columns import sequenced_columns
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism

_EULER_COLUMN = re.compile(r"(?:platform\.)?euler_(?:([A-Za-z]{3})_)?([123])")
_MAX_LISTED_GROUPS = 5
"""Most groups of one configuration that a message lists."""
_MAX_LISTED_JOINTS = 12
"""Most joint names that a message lists."""


class ColumnReader:
    """Reads one table for one mechanism, column by column."""

    def __init__(self, table: Table, mechanism: Mechanism, distances: Sequence[str] = ()) -> None:
        self.mechanism, self.distances = mechanism, [DISTANCE + name for name in distances]
        self.known = {c.name for c in mechanism.coordinates if c.width == 1}
        self.observables = observables(mechanism)
        self.copies = table.copies()
        self.table = self._matched(table)
        self.notes: list[str] = list(self.table.notes)

    def _matched(self, table: Table) -> Table:
        """Keep the columns that mean something for this mechanism, under their names."""
        joints, sequenced = (
            [c.name for c in self.mechanism.actuated],
            sequenced_columns(table, self.known),
        )
        readings = [*INCLINATION, *POSITION, *QUATERNION, *(f"euler_{k}" for k in "123"), "group"]
        placed = [
            place for r in readings for place in (reading_name(self.mechanism, r), f"platform.{r}")
        ]
        sigmas = [
            f"sigma_{name}"
            for name in (*joints, "group", *INCLINATION, *POSITION, "orientation", *self.distances)
        ]
        others = [column for o in self.observables.values() for column in o.columns]
        sigmas += [f"sigma_{column}" for o in self.observables.values() for column in o.sigmas]
        known = tuple(dict.fromkeys((*joints, *placed, *sigmas, *WEDGE, *self.distances, *others)))
        made = table.matched(
            known,
            text=("group", "platform.group"),
            aliases=sequenced | columns_of_platform_link(self.mechanism, table, known),
        )
        of_platform = [name for name in made.columns if name in (*placed, *sequenced.values())]
        read = [
            *of_platform,
            *(name for name in made.columns if name in (*self.distances, *others)),
        ]
        self._check_left_out(made, anything_read=bool(read))
        if of_platform and self.mechanism.platform_link is None:
            raise InputError(
                f"{made.path}: column {of_platform[0]!r} is of a platform, and "
                f"{self.mechanism.name} has no platform link; name it by "
                "[platform] link, or read named points (point.NAME.x) and other links (LINK.x, "
                "LINK.qw, LINK.alpha)"
            )
        return made

    def _check_left_out(self, made: Table, *, anything_read: bool) -> None:
        """Refuse files that leave out what is needed: points of distances, joints, all readings;
        and columns that look misspelt.
        """
        for name in made.left_out:
            refuse_misspelt(self.mechanism, made.path, name)
            if name.startswith(DISTANCE):
                raise InputError(
                    f"{made.path}: column {name!r}: the points of this distance are not known; "
                    f"give them with "
                    f"--distance {name.partition('[')[0].removeprefix(DISTANCE)}=X,Y,Z:BX,BY,BZ"
                )
        lacking = [c.name for c in self.mechanism.actuated if c.name not in made.columns]
        if lacking or (made.left_out and not anything_read):
            what = (
                f"the actuated joint {lacking[0]!r}" if lacking else "any reading beside the joints"
            )
            names = [c.name for c in self.mechanism.actuated]
            joints = ", ".join(names[:_MAX_LISTED_JOINTS]) + (
                ", ..." if len(names) > _MAX_LISTED_JOINTS else ""
            )
            unknown = f"; unknown: {listed(made.left_out)}" if made.left_out else ""
            raise InputError(
                f"{made.path}: there is no column of {what}{unknown}; known: {joints} (the "
                f"actuated joints), {known_readings(self.mechanism)}, and "
                "sigma_ before a name"
            )

    def groups(self) -> tuple[tuple[str, ...], np.ndarray | None]:
        column = self._column("group")
        if column is None:
            return (), None
        cells = [cell.strip() for cell in self.table.text(column)]
        labels = tuple(dict.fromkeys(cell for cell in cells if cell))
        counts, numbers = Counter(cells), {label: k for k, label in enumerate(labels)}
        alone = [label for label in labels if counts[label] == 1]
        if alone:
            lines = [
                str(self.table.lines[cells.index(label)]) for label in alone[:_MAX_LISTED_GROUPS]
            ]
            more = (
                f" and {len(alone) - _MAX_LISTED_GROUPS} more"
                if len(alone) > _MAX_LISTED_GROUPS
                else ""
            )
            self.notes.append(
                f"a group of one posture says nothing of inclination: "
                f"{', '.join(map(repr, alone[:_MAX_LISTED_GROUPS]))}{more} "
                f"(line {', '.join(lines)}{', ...' if more else ''})"
            )
        if len(alone) == len(labels):
            return labels, None
        return labels, np.array(
            [numbers[cell] if cell and counts[cell] > 1 else NO_GROUP for cell in cells]
        )

    def joints(self) -> np.ndarray:
        columns = [
            self._numbers(c.name, measure_of(c), empty=False) for c in self.mechanism.actuated
        ]
        values = np.array(columns).T.reshape(len(self.table), len(columns))
        for k, c in enumerate(self.mechanism.actuated):
            self._check_range(c, values[:, k])
        self._note_repeats(values)
        return values

    def _note_repeats(self, values: np.ndarray) -> None:
        """Note rows with the joint readings of an earlier one and other cells besides; whole copies
        are left out (`DataFile`).
        """
        whole = {row for row, _ in self.copies}
        _, first, inverse = np.unique(values, axis=0, return_index=True, return_inverse=True)
        earlier = first[inverse.ravel()]
        repeats = [
            int(k) for k in np.flatnonzero(earlier != np.arange(len(values))) if int(k) not in whole
        ]
        if repeats and len(first) > 1:
            lines = self.table.lines
            self.notes.append(
                f"{len(repeats)} rows repeat the joint readings of an earlier one exactly (line "
                f"{lines[repeats[0]]} those of line "
                f"{lines[earlier[repeats[0]]]}, ...): copies are no new measurements, and make "
                f"sigma too small"
            )

    def _check_range(self, c: Coordinate, values: np.ndarray) -> None:
        unit = 1.0 if not c.is_angular else 1 / UNITS[self.mechanism.angle_unit][1]
        if c.least is not None and np.any(values < c.least):
            row = int(np.argmax(values < c.least))
            raise InputError(
                f"{self.table.path}, line {self.table.lines[row]}, column "
                f"{self.table.columns[c.name].header!r}: a rod of negative "
                f"length; {c.least + 0.0:g} {self.mechanism.length_unit} and above is needed"
            )
        outside = (
            np.zeros(len(values), dtype=bool)
            if c.limits is None
            else (values < c.limits[0]) | (values > c.limits[1])
        )
        if c.limits is not None and np.any(outside):
            where = ", ".join(str(self.table.lines[k]) for k in np.flatnonzero(outside)[:3])
            low, high = (f"{limit * unit:g}" for limit in c.limits)
            self.notes.append(
                f"{c.name}: {int(outside.sum())} of {len(values)} readings lie outside its limits "
                f"{low} to {high} "
                f"{unit_of(self.mechanism, measure_of(c))} (line "
                f"{where}{', ...' if outside.sum() > 3 else ''})"
            )
        if len(values) > 2 and np.ptp(values) == 0.0:
            self.notes.append(f"{c.name}: the reading is the same in all rows")

    def together(
        self, names: tuple[str, ...], measure: Measure | None, *, own: bool = False
    ) -> np.ndarray | None:
        """Read columns that stand together, all cells of a row or none; None where nothing is in
        them. Names of observables are their `own`, whatever joints are named.
        """
        present = [self._own_column(name) if own else self._column(name) for name in names]
        if not any(present):
            return None
        for name, column in zip(names, present, strict=True):
            if column is None:
                raise InputError(
                    f"{self.table.path}: column {name!r} is missing, and {', '.join(names)} stand "
                    f"together; {self.table.held()}"
                )
        values = np.array([self._numbers(str(column), measure) for column in present]).T
        partly = np.isnan(values).any(axis=1) & ~np.isnan(values).all(axis=1)
        if np.any(partly):
            row = int(np.argmax(partly))
            name = names[int(np.argmax(np.isnan(values[row])))]
            raise InputError(
                f"{self.table.path}, line {self.table.lines[row]}, column {name!r}: the cell has "
                f"no number, the others of "
                f"{', '.join(names)} have; give all or none"
            )
        return None if np.all(np.isnan(values)) else values

    def some(
        self, names: tuple[str, ...], measure: Measure, *, own: bool = False
    ) -> np.ndarray | None:
        """Read columns any of which may be missing."""
        present = [self._own_column(name) if own else self._column(name) for name in names]
        empty = [float("nan")] * len(self.table)
        values = np.array(
            [empty if column is None else self._numbers(column, measure) for column in present]
        ).T
        return None if np.all(np.isnan(values)) else values

    def orientation(self) -> np.ndarray | None:
        return self._unit_quaternions(QUATERNION)

    def _unit_quaternions(self, names: tuple[str, ...], *, own: bool = False) -> np.ndarray | None:
        values = self.together(names, None, own=own)
        if values is None:
            return None
        norms = np.linalg.norm(values, axis=1)
        bad = np.flatnonzero(np.abs(norms - 1.0) > 1e-2)
        if bad.size:
            raise InputError(
                f"{self.table.path}, line {self.table.lines[bad[0]]}, column {names[0]!r}: the "
                f"quaternion has norm {norms[bad[0]]:.6g}; "
                "allowed: 1 to within 0.01"
            )
        return values

    def euler(self) -> tuple[str | None, np.ndarray | None]:
        """Read Euler angles: the sequence of the header, None where it names none, and the
        angles.
        """
        found = {
            name: match for name in self.table.columns if (match := _EULER_COLUMN.fullmatch(name))
        }
        if not found:
            return None, None
        sequences = {match[1] for match in found.values()}
        if len(sequences) > 1:
            raise InputError(
                f"{self.table.path}: Euler angles of several sequences ({', '.join(found)}); three "
                f"columns of one are needed"
            )
        sequence = next(iter(sequences))
        prefix = "euler_" if sequence is None else f"euler_{sequence}_"
        return sequence, self.together((f"{prefix}1", f"{prefix}2", f"{prefix}3"), "angle")

    def distance(self, name: str) -> tuple[np.ndarray, np.ndarray | None]:
        """Read the values (n,) of a distance and their standard deviations, None without a
        column.
        """
        column = self._column(DISTANCE + name)
        if column is None:
            raise InputError(
                f"{self.table.path}: column {DISTANCE + name!r} is missing or empty; --distance "
                f"{name} names it"
            )
        values = np.array(self._numbers(column, "length"))
        if np.any(values <= 0.0):
            row = int(np.argmax(values <= 0.0))
            raise InputError(
                f"{self.table.path}, line {self.table.lines[row]}, column "
                f"{self.table.columns[column].header!r}: a distance of "
                f"{self.table.text(column)[row].strip()}; a positive number is needed"
            )
        sigma = f"sigma_{DISTANCE}{name}"
        return values, self._sigma(sigma, "length") if sigma in self.table.columns else None

    def observed(self) -> tuple[Reading, ...]:
        """Read what is read of passive joints, named points and other links."""
        found = [
            self._reading(o)
            for o in self.observables.values()
            if any(self._is_read(column) for column in o.columns)
        ]
        for o in self.observables.values():
            stray = [
                s
                for s in o.sigmas
                if f"sigma_{s}" in self.table.columns and not any(map(self._is_read, o.columns))
            ]
            if stray:
                raise InputError(
                    f"{self.table.path}: column 'sigma_{stray[0]}' stands there without "
                    f"{' or '.join(o.columns)}"
                )
        return tuple(found)

    def _is_read(self, column: str) -> bool:
        return column in self.table.columns and any(
            cell.strip() for cell in self.table.text(column)
        )

    def _own_column(self, name: str) -> str | None:
        return name if self._is_read(name) else None

    def _reading(self, o: Observable) -> Reading:
        measure: Measure | None = (
            None if o.kind == "orientation" else "angle" if o.angular else "length"
        )
        if o.kind == "orientation":
            values = self._unit_quaternions(o.columns, own=True)
        elif o.kind == "inclination":
            values = self.together(o.columns, measure, own=True)
        else:
            values = self.some(o.columns, measure or "length", own=True)
        if o.kind == "distance" and np.any(values <= 0.0):  # type: ignore[operator]
            row = int(np.argmax(np.any(values <= 0.0, axis=1)))  # type: ignore[operator]
            raise InputError(
                f"{self.table.path}, line {self.table.lines[row]}, column {o.name!r}: a distance "
                f"of "
                f"{self.table.text(o.name)[row].strip()}; a positive number is needed"
            )
        return Reading(o.name, np.asarray(values), self._sigmas_of(o))

    def _sigmas_of(self, o: Observable) -> np.ndarray | None:
        """Standard deviations (n, w) of an observable: for each of its columns that is there, or
        for none.
        """
        if not any(f"sigma_{s}" in self.table.columns for s in o.sigmas):
            return None
        measure: Measure = "angle" if o.angular else "length"
        empty = np.full(len(self.table), np.nan)
        needed = [
            s
            for s in o.sigmas
            if s not in o.columns or self._is_read(s) or f"sigma_{s}" in self.table.columns
        ]
        return np.array(
            [self._sigma(f"sigma_{s}", measure) if s in needed else empty for s in o.sigmas]
        ).T

    def joint_sigmas(self) -> np.ndarray | None:
        names = [f"sigma_{c.name}" for c in self.mechanism.actuated]
        if not any(name in self.table.columns for name in names):
            return None
        columns = [
            self._sigma(n, measure_of(c))
            for n, c in zip(names, self.mechanism.actuated, strict=True)
        ]
        return np.array(columns).T

    def sigmas(self, names: tuple[str, ...], measure: Measure) -> np.ndarray | None:
        """Read standard deviations of columns: for each reading that there is, or for none."""
        wanted = [f"sigma_{name}" for name in names]
        if not any(name in self.table.columns for name in wanted):
            return None
        empty = np.full(len(self.table), np.nan)
        columns = [
            self._sigma(sigma, measure)
            if self._column(name) or sigma in self.table.columns
            else empty
            for name, sigma in zip(names, wanted, strict=True)
        ]
        return np.array(columns).T

    def sigma(self, name: str, measure: Measure, of: list[str]) -> np.ndarray | None:
        """Read standard deviations of one column for all components of a reading."""
        if f"sigma_{name}" not in self.table.columns:
            return None
        if not any(column.startswith(tuple(of)) for column in self.table.columns):
            raise InputError(
                f"{self.table.path}: column 'sigma_{name}' stands there without {' or '.join(of)}"
            )
        return self._sigma(f"sigma_{name}", measure)

    def _sigma(self, name: str, measure: Measure) -> np.ndarray:
        if name not in self.table.columns:
            raise InputError(
                f"{self.table.path}: column {name!r} is missing; give standard deviations of all "
                f"or of none of its kind; {self.table.held()}"
            )
        values = np.array(self._numbers(name, measure))
        least = (
            0.0
            if name[len("sigma_") :] in {c.name for c in self.mechanism.actuated}
            else np.finfo(float).tiny
        )
        bad = np.flatnonzero(values < least)
        if bad.size:
            row = int(bad[0])
            raise InputError(
                f"{self.table.path}, line {self.table.lines[row]}, column {name!r}: "
                f"{self.table.text(name)[row].strip()} is no "
                "standard deviation; a positive number is needed"
            )
        return values

    def _column(self, name: str) -> str | None:
        """Find the column in which a reading stands, None where there is none or nothing is in
        it.
        """
        candidates = [f"platform.{name}"] if name in self.known else [name, f"platform.{name}"]
        return next(
            (
                c
                for c in candidates
                if c in self.table.columns and any(t.strip() for t in self.table.text(c))
            ),
            None,
        )

    def _numbers(self, name: str, measure: Measure | None, *, empty: bool = True) -> list[float]:
        unit = (
            None
            if measure is None
            else self.mechanism.length_unit
            if measure == "length"
            else "rad"
        )
        return self.table.numbers(name, measure, unit, empty=empty)
