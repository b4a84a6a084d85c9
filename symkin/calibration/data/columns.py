"""Read the columns of a measurement file one by one; every mistake names file, line and column
(formats: see `files`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Reading
from symkin.calibration.data.observables import (
    PLATFORM,
    POSE_COLUMNS,
    Measure,
    Observable,
    distance_to_base,
    observables,
    of_joint,
)
from symkin.errors import InputError
from symkin.files.csv_dialect import listed
from symkin.files.csv_table import Table
from symkin.files.euler_columns import sequenced_columns
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.text import first_of, meant, nearest

_EULER_COLUMN = re.compile(r"(?:platform\.)?euler_(?:([A-Za-z]{3})_)?([123])")
_ROUNDED_NORM = 1e-4
"""Norms of quaternions further than this from 1 tell of rounded components: as many radians are
lost.
"""
_MAX_LISTED_JOINTS = 12
"""Most joint names that a message lists."""


class ColumnReader:
    """Reads one table for one mechanism, column by column."""

    def __init__(
        self, table: Table, mechanism: Mechanism, points: Mapping[str, DistancePoints]
    ) -> None:
        self.mechanism = mechanism
        self.distances = [distance_to_base(DISTANCE + name, ends) for name, ends in points.items()]
        self.known = {c.name for c in mechanism.coordinates if c.width == 1}
        self.observables = observables(mechanism)
        self.copies = table.copies()
        self.table = self._matched(table)
        self.notes: list[str] = list(self.table.notes)

    def _matched(self, table: Table) -> Table:
        """Keep the columns that mean something for this mechanism, under their names."""
        joints = [of_joint(c) for c in self.mechanism.actuated]
        beside = [*self.distances, *self.observables.values()]
        sequenced = sequenced_columns(table, self.known)
        bare = [c for o in PLATFORM.values() for c in o.columns] + [f"euler_{k}" for k in "123"]
        placed = [name for r in bare for name in (reading_name(self.mechanism, r), f"platform.{r}")]
        read = [c for o in beside for c in o.columns]
        sigmas = [f"sigma_{s}" for o in (*joints, *PLATFORM.values(), *beside) for s in o.sigmas]
        own = (*(o.name for o in joints), *placed, *sigmas, *WEDGE, *read)
        known = tuple(dict.fromkeys(own))
        made = table.matched(
            known,
            text=("group", "platform.group"),
            aliases=sequenced | columns_of_platform_link(self.mechanism, table, known),
        )
        of_platform = [name for name in made.columns if name in (*placed, *sequenced.values())]
        read = [name for name in made.columns if name in (*of_platform, *read)]
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
            what = "any reading beside the joints"
            if lacking:
                what = f"the actuated joint {lacking[0]!r}"
            joints = first_of([c.name for c in self.mechanism.actuated], _MAX_LISTED_JOINTS)
            slips = [meant(name.partition("[")[0], lacking) for name in made.left_out]
            unknown = f"; unknown: {listed(made.left_out)}" if made.left_out else ""
            unknown += next(filter(None, slips), "")
            raise InputError(
                f"{made.path}: there is no column of {what}{unknown}; known: {joints} (the "
                f"actuated joints), {known_readings(self.mechanism)}, and "
                "sigma_ before a name"
            )

    def groups(self) -> np.ndarray | None:
        column = self._column("group")
        if column is None:
            return None
        cells = [cell.strip() for cell in self.table.text(column)]
        numbers = {label: k for k, label in enumerate(dict.fromkeys(filter(None, cells)))}
        counts = Counter(cells)
        alone = [label for label in numbers if counts[label] == 1]
        if alone:
            self.notes.append(
                f"a group of one posture says nothing of inclination: "
                f"{first_of(list(map(repr, alone)))} (line {self._lines(map(cells.index, alone))})"
            )
        if len(alone) == len(numbers):
            return None
        return np.array(
            [numbers[cell] if cell and counts[cell] > 1 else NO_GROUP for cell in cells]
        )

    def joints(self) -> np.ndarray:
        values = np.zeros((len(self.table), len(self.mechanism.actuated)))
        for k, c in enumerate(self.mechanism.actuated):
            values[:, k] = self._numbers([c.name], of_joint(c).measure, empty=False)[:, 0]
            self._check_range(c, values[:, k])
        # rows that are whole copies of earlier ones are left out (`DataFile`)
        whole = [row for row, _ in self.copies]
        _, first, inverse = np.unique(values, axis=0, return_index=True, return_inverse=True)
        earlier = first[inverse.ravel()]
        repeats = np.setdiff1d(np.flatnonzero(earlier != np.arange(len(values))), whole)
        if len(repeats) and len(first) > 1:
            self.notes.append(
                f"{len(repeats)} rows repeat the joint readings of an earlier one exactly (line "
                f"{self._lines(repeats[:1])} those of line {self._lines(earlier[repeats[:1]])}, "
                f"...): copies are no new measurements, and make sigma too small"
            )
        return values

    def _check_range(self, c: Coordinate, values: np.ndarray) -> None:
        if c.least is not None and np.any(values < c.least):
            raise self._error(
                np.argmax(values < c.least),
                self.table.columns[c.name].header,
                f"a rod of negative length; {c.least + 0.0:g} {self.mechanism.length_unit} and "
                f"above is needed",
            )
        low, high = c.limits or (-np.inf, np.inf)
        unit = self.mechanism.value_out(c, 1.0)
        outside = (values < low) | (values > high)
        if outside.any():
            self.notes.append(
                f"{c.name}: {outside.sum()} of {len(values)} readings lie outside its limits "
                f"{low * unit:g} to {high * unit:g} "
                f"{self.mechanism.unit_of(c)} (line "
                f"{self._lines(np.flatnonzero(outside))})"
            )
        if len(values) > 2 and np.ptp(values) == 0.0:
            self.notes.append(f"{c.name}: the reading is the same in all rows")

    def _lines(self, rows: Iterable[int]) -> str:
        return first_of([str(self.table.lines[k]) for k in rows])

    def _error(self, row: Any, column: str, text: str) -> InputError:
        return InputError(
            f"{self.table.path}, line {self.table.lines[row]}, column {column!r}: {text}"
        )

    def together(
        self, names: Sequence[str], measure: Measure | None, *, own: bool = False
    ) -> np.ndarray | None:
        """Read columns that stand together, all cells of a row or none; None where nothing is in
        them. Names of observables are their `own`, whatever joints are named.
        """
        present = [self._column(name, own=own) for name in names]
        if not any(present):
            return None
        if None in present:
            raise InputError(
                f"{self.table.path}: column {names[present.index(None)]!r} is missing, and "
                f"{', '.join(names)} stand together; {self.table.held()}"
            )
        values = self._numbers(present, measure)
        empty = np.isnan(values)
        partly = np.flatnonzero(empty.any(axis=1) & ~empty.all(axis=1))
        if partly.size:
            raise self._error(
                partly[0],
                names[int(empty[partly[0]].argmax())],
                f"the cell has no number, the others of {', '.join(names)} have; give all or none",
            )
        return None if empty.all() else values

    def read(self, o: Observable) -> Reading | None:
        """Read an observable and its standard deviations, None where nothing is in its columns."""
        own, oriented = o.by_name, o.kind == "orientation"
        if oriented or o.kind == "inclination":
            values = self.together(o.columns, None if oriented else "angle", own=own)
        else:
            values = self._numbers([self._column(c, own=own) for c in o.columns], o.measure)
        sigma = self.sigmas(o)
        if values is None or np.isnan(values).all():
            return None
        if oriented or o.kind == "distance":
            norms = np.linalg.norm(values, axis=1) if oriented else values[:, 0]
            bad = np.abs(norms - 1.0) > 1e-2 if oriented else norms <= 0.0
            text = "a distance of {:g}; a positive number is needed"
            if oriented:
                text = "the quaternion has norm {:.6g}; allowed: 1 to within 0.01"
            for row in np.flatnonzero(bad):
                raise self._error(row, o.columns[0], text.format(norms[row]))
            if oriented and (off := np.nanmax(np.abs(norms - 1.0))) > _ROUNDED_NORM:
                self.notes.append(
                    f"{', '.join(o.columns)} are rounded, norms are 1 to within {off:.1g}: they "
                    f"tell the orientation to some {np.degrees(off):.1g} deg only"
                )
        return Reading(o.key, values, sigma, o.ends)

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
        return sequence, self.together([prefix + k for k in "123"], "angle")

    def beside(self) -> tuple[Reading, ...]:
        """Read distances, and what is read of passive joints, named points and other links."""
        found = [(o, self.read(o)) for o in (*self.distances, *self.observables.values())]
        for o, reading in found:
            if o.ends and reading is None:
                raise InputError(
                    f"{self.table.path}: column {o.key!r} is missing or empty; "
                    f"--distance {o.key.removeprefix(DISTANCE)} names it"
                )
        return tuple(reading for _, reading in found if reading is not None)

    def sigmas(self, o: Observable) -> np.ndarray | None:
        """Read the standard deviations (n, w) of an observable: for each of its columns that is
        there, or for none.
        """
        given = [f"sigma_{s}" for s in o.sigmas]
        stray = next((name for name in given if name in self.table.columns), None)
        if stray is None:
            return None
        of = o.columns if o.of or o.kind != "orientation" else (*o.columns, "euler")
        held = {c.removeprefix("platform.") for c in self.table.columns}
        held |= {"euler" for c in held if "euler_" in c}
        # those of inclination and position are let stand alone
        if (o.of or len(given) == 1) and held.isdisjoint(of):
            raise InputError(
                f"{self.table.path}: column {stray!r} stands there without {' or '.join(of)}"
            )
        needed = [
            name in self.table.columns or s not in o.columns or self._column(s, own=bool(o.of))
            for s, name in zip(o.sigmas, given, strict=True)
        ]
        names = [name if need else None for name, need in zip(given, needed, strict=True)]
        return self._sigmas(names, o.measure)

    def joint_sigmas(self) -> np.ndarray | None:
        joints = [of_joint(c) for c in self.mechanism.actuated]
        if not any(f"sigma_{o.name}" in self.table.columns for o in joints):
            return None
        return np.hstack([self._sigmas([f"sigma_{o.name}"], o.measure) for o in joints])

    def _sigmas(self, names: Sequence[str | None], measure: Measure) -> np.ndarray:
        for name in names:
            if name is not None and name not in self.table.columns:
                raise InputError(
                    f"{self.table.path}: column {name!r} is missing; give standard deviations of "
                    f"all or of none of its kind; {self.table.held()}"
                )
        values = self._numbers(names, measure)
        joints = {f"sigma_{c.name}" for c in self.mechanism.actuated}
        least = [0.0 if name in joints else np.finfo(float).tiny for name in names]
        for row, k in np.argwhere(values < least):
            raise self._error(
                row,
                str(names[k]),
                f"{self.table.text(str(names[k]))[row].strip()} is no standard deviation; a "
                f"positive number is needed",
            )
        return values

    def _column(self, name: str, *, own: bool = False) -> str | None:
        """Find the column in which a reading stands, None where there is none or nothing is in
        it.
        """
        found = [name] * (own or name not in self.known) + [f"platform.{name}"] * (not own)
        held = (c for c in found if c in self.table.columns)
        return next((c for c in held if any(map(str.strip, self.table.text(c)))), None)

    def _numbers(
        self, names: Sequence[str | None], measure: Measure | None, *, empty: bool = True
    ) -> np.ndarray:
        """Numbers (n, k) of columns, NaN for those that are not there and for `empty` cells, which
        are refused else.
        """
        unit = {"length": self.mechanism.length_unit, "angle": "rad"}.get(measure or "")
        none = [np.nan] * len(self.table)
        columns = [
            none if name is None else self.table.numbers(name, measure, unit, empty=empty)
            for name in names
        ]
        return np.array(columns).T


DistancePoints = tuple[Sequence[float], Sequence[float]]
"""Ends of a distance: a point of the platform frame (tool frame of an arm) and one of the base
frame, length unit.
"""
WEDGE = ("wedge_alpha", "wedge_beta")
"""Columns of a plan that a measurement file may keep; they say where the configuration was meant to
be, not what was read.
"""
DISTANCE = "distance_"
"""Prefix of the columns of distances."""
_OBSERVABLE_PREFIXES = ("point.", "distance.")
"""What columns of named points and of their distances begin with."""
_MISSPELT = 0.85
"""Likeness (of difflib) from which an unknown column is taken for a slip of the pen."""
_MAX_LISTED_COLUMNS = 12
"""Most columns of joints, points and links that a message lists."""


def reading_name(mechanism: Mechanism, name: str) -> str:
    """Name the column of a reading: its name, or platform.NAME where a joint has that name."""
    return (
        f"platform.{name}"
        if any(c.name == name for c in mechanism.coordinates if c.width == 1)
        else name
    )


def columns_of_platform_link(
    mechanism: Mechanism, table: Table, known: Sequence[str]
) -> dict[str, str]:
    """Map columns of the platform's link, by its own name (foot.x), to those of the platform."""
    link, found = mechanism.platform_link, dict[str, str]()
    for name in table.columns:
        sigma = "sigma_" if name.startswith("sigma_") else ""
        begin, _, last = name.removeprefix("sigma_").rpartition(".")
        if begin != link or name in known:
            continue
        target = f"{sigma}{reading_name(mechanism, last)}"
        if target in known:
            if target in table.columns:
                raise InputError(
                    f"{table.path}: the columns {name!r} and {target!r} both mean {target!r}; "
                    f"leave one out"
                )
            found[name] = target
    return found


def refuse_misspelt(mechanism: Mechanism, path: str, header: str) -> None:
    """Refuse a column that is left out and looks like one of what can be read: by what it begins
    with, or a slip of the pen.
    """
    name = header.partition("[")[0].strip()
    bare, known = name.removeprefix("sigma_"), observables(mechanism).values()
    columns = list(dict.fromkeys(column for o in known for column in (*o.columns, *o.sigmas)))
    near = nearest(bare, columns, likeness=_MISSPELT)
    links = {f"{o.of[0]}." for o in known if o.kind in POSE_COLUMNS}
    if not near and not bare.startswith((*_OBSERVABLE_PREFIXES, *links)):
        return
    guess = meant(bare, columns) or "; no passive joint, named point or other link has such a name"
    raise InputError(
        f"{path}: column {name!r} is unknown{guess}; rename it where it is to be left out"
    )


def known_readings(mechanism: Mechanism) -> str:
    """The columns of readings that a mechanism may have, for a message."""
    known = observables(mechanism).values()
    own = [column for o in known if o.kind != "distance" for column in o.columns]
    platform = [
        "group, alpha, beta, x, y, z, distance_NAME, qw, qx, qy, qz, euler_1 to euler_3, "
        "euler_ZYX_1 to euler_ZYX_3 (any sequence), "
        "roll, pitch, yaw"
    ]
    between = (
        ["distance.A.B of two named points"] if any(o.kind == "distance" for o in known) else []
    )
    more = ["..."] if len(own) > _MAX_LISTED_COLUMNS else []
    return ", ".join(
        [
            *(platform if mechanism.platform_link is not None else ()),
            *own[:_MAX_LISTED_COLUMNS],
            *more,
            *between,
        ]
    )
