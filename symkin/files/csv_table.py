"""CSV files of measurements and trajectories: a header of names with units,
`leg1[mm],theta[deg],group`, then rows.

Lines that begin with # and empty lines are left out. Every mistake names file, row (the line of the
file) and column.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from symkin.errors import InputError
from symkin.files.csv_dialect import (
    SEPARATORS,
    blanked,
    has_decimal_commas,
    listed,
    matched_names,
    read_text,
    split_header,
    split_rows,
    with_points,
)
from symkin.files.outputs import write_output
from symkin.model.arithmetic import plain_number
from symkin.text import code_point, counted, refused_character

UNITS: dict[str, tuple[str, float]] = {
    "m": ("length", 1.0),
    "mm": ("length", 1e-3),
    "um": ("length", 1e-6),
    "in": ("length", 0.0254),
    "rad": ("angle", 1.0),
    "mrad": ("angle", 1e-3),
    "deg": ("angle", math.pi / 180),
    "arcsec": ("angle", math.pi / 648000),
    "s": ("time", 1.0),
    "ms": ("time", 1e-3),
}
"""Units that a header may name, what they measure, and how many of the SI unit they are."""

ROWS_AT_ONCE = 4096
"""Rows of a table that are held as text."""


@dataclass(frozen=True)
class Column:
    """One column: its name, the unit in its header (None without one), the text of each cell, and
    the header as it is written.
    """

    name: str
    unit: str | None
    cells: tuple[str, ...]
    written: str = ""

    @property
    def header(self) -> str:
        return self.name if self.unit is None else f"{self.name}[{self.unit}]"

    def loose(self, name: str) -> bool:
        """Whether the header of a file was written otherwise than name[unit], but for spaces."""
        return re.sub(r"\s", "", self.written) != re.sub(r"\s", "", replace(self, name=name).header)


@dataclass(frozen=True)
class Table:
    """The columns of a file by name, the line on which each row stands, what separates the cells,
    notes on how it was read, and the headers of columns that mean nothing.
    """

    path: str
    columns: dict[str, Column]
    lines: tuple[int, ...]
    separator: str = ","
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.lines)

    def text(self, name: str) -> tuple[str, ...]:
        """The cells of a column as they are written."""
        return self._column(name).cells

    def numbers(
        self, name: str, kind: str | None = None, unit: str | None = None, *, empty: bool = False
    ) -> list[float]:
        """The numbers of a column. With `kind` ("length", "angle", "time") the header must name a
        unit of that kind, and values are converted to `unit`; without one, the header must name
        none. Empty cells are nan with `empty`, else refused.
        """
        column = self._column(name)
        factor = self._factor(column, kind, unit)
        return [self._number(column, k, empty) * factor for k in range(len(self))]

    def matched(
        self,
        known: Sequence[str],
        *,
        text: Sequence[str] = (),
        aliases: Mapping[str, str] | None = None,
    ) -> Table:
        """The known columns under their names (`aliases` are other names of some), blanks and
        decimal points as usual in all but those of `text`; the notes say what was read otherwise
        than it stands there, and which columns were left out.

        Raises InputError for what can be read in two ways.
        """
        names = matched_names(
            self.path, [n for n in self.columns if n not in (aliases or {})], known
        ) | dict(aliases or {})
        kept = {names[name]: column for name, column in self.columns.items() if name in names}
        blank = {name: blanked(column.cells) for name, column in kept.items()}
        numbers = [
            (column.header, blank[name][0]) for name, column in kept.items() if name not in text
        ]
        commas = has_decimal_commas(self.path, numbers, self.separator)
        columns = {
            name: Column(
                name,
                column.unit,
                with_points(blank[name][0]) if commas and name not in text else blank[name][0],
            )
            for name, column in kept.items()
        }
        notes = [
            *self.notes,
            *self._notes(names, columns, sum(count for _, count in blank.values())),
        ]
        if commas:
            notes.append("numbers were read with decimal commas")
        left_out = tuple(c.written for name, c in self.columns.items() if name not in names)
        return replace(self, columns=columns, notes=tuple(notes), left_out=left_out)

    def _notes(
        self, names: Mapping[str, str], columns: Mapping[str, Column], blanks: int
    ) -> Iterator[str]:
        """What was read otherwise than it stands there."""
        if self.separator != ",":
            yield (
                f"cells were read as separated by "
                f"{SEPARATORS.get(self.separator, repr(self.separator))}"
            )
        other = [
            f"{c.written!r} as {columns[names[n]].header}"
            for n, c in self.columns.items()
            if n in names and c.loose(names[n])
        ]
        if other:
            yield f"columns were read by other names or units than they bear: {', '.join(other)}"
        if left_out := [c.written for n, c in self.columns.items() if n not in names]:
            yield f"columns that mean nothing here were left out: {listed(left_out)}"
        if blanks:
            yield (
                f"{counted(blanks, 'cell')} with NaN or its like "
                f"{'were' if blanks != 1 else 'was'} read as blank"
            )

    def copies(self) -> tuple[tuple[int, int], ...]:
        """Rows (from 0) that repeat an earlier one in every cell, numbers by their values, with
        that one.
        """
        first: dict[tuple[object, ...], int] = {}
        found = []
        for k, row in enumerate(zip(*(c.cells for c in self.columns.values()), strict=True)):
            earlier = first.setdefault(tuple(map(_value, row)), k)
            if earlier != k:
                found.append((k, earlier))
        return tuple(found)

    def held(self) -> str:
        """What columns there are, for messages about one that is missing."""
        left_out = f"; left out: {listed(self.left_out)}" if self.left_out else ""
        return f"the header has {', '.join(self.columns) or 'none that is read'}{left_out}"

    def _column(self, name: str) -> Column:
        if name not in self.columns:
            raise InputError(f"{self.path}: column {name!r} is missing; {self.held()}")
        return self.columns[name]

    def _factor(self, column: Column, kind: str | None, unit: str | None) -> float:
        if kind is None:
            if column.unit is not None:
                raise InputError(
                    f"{self.path}: column {column.header!r} has a unit; {column.name!r} is a plain "
                    f"number"
                )
            return 1.0
        allowed = [name for name, (measured, _) in UNITS.items() if measured == kind]
        if column.unit not in allowed:
            raise InputError(
                f"{self.path}: column {column.header!r} needs a unit of {kind}, as in "
                f"{column.name}[{allowed[0]}]; "
                f"allowed: {', '.join(allowed)}"
            )
        return (
            1.0
            if column.unit == unit
            else UNITS[column.unit or ""][1] / UNITS[unit or allowed[0]][1]
        )

    def _number(self, column: Column, row: int, empty: bool) -> float:
        cell = column.cells[row].strip()
        if not cell and empty:
            return math.nan
        number = plain_number(cell)
        value = math.nan if number is None else number
        if not math.isfinite(value):
            raise InputError(
                f"{self.path}, line {self.lines[row]}, column {column.header!r}: "
                f"{repr(cell) if cell else 'an empty cell, or one of NaN or its like,'} is not a "
                f"number; a finite number is needed"
            )
        return value


def read_table(path: str | Path) -> Table:
    """Read a CSV file with a header of `name` or `name[unit]`, its cells separated by commas,
    semicolons or tabs.
    """
    text, notes = read_text(path)
    rows, separator = split_rows(str(path), text)
    _refuse_controls(str(path), rows)
    if not rows:
        raise InputError(
            f"{path}: the file is empty; a header of names and units is needed, as in "
            f"leg1[mm],theta[deg]"
        )
    headers = [cell.strip() for cell in rows[0][1]]
    if all(plain_number(cell) is not None for cell in headers):
        raise InputError(
            f"{path}, line {rows[0][0]}: there are numbers where a header of names and units is "
            f"needed, as in leg1[mm],theta[deg]"
        )
    for line, row in rows[1:]:
        _check_width(str(path), line, row, len(headers), separator)
    cells = (
        list(zip(*(row[: len(headers)] for _, row in rows[1:]), strict=True))
        if len(rows) > 1
        else [()] * len(headers)
    )
    columns: dict[str, Column] = {}
    for number, (header, held) in enumerate(zip(headers, cells, strict=True), start=1):
        name, unit = split_header(header or f"column {number}", UNITS)
        if name in columns:
            raise InputError(f"{path}: column {name!r} stands twice in the header; each name once")
        if header or any(cell.strip() for cell in held):
            columns[name] = Column(name, unit, held, header)
    return Table(str(path), columns, tuple(line for line, _ in rows[1:]), separator, notes)


def _check_width(path: str, line: int, row: list[str], width: int, separator: str) -> None:
    """Refuse a row of another number of cells than the header; empty ones at its end do not
    count.
    """
    if len(row) == width or (len(row) > width and not any(cell.strip() for cell in row[width:])):
        return
    other = next(
        (
            name
            for mark, name in SEPARATORS.items()
            if mark != separator and any(mark in cell.strip() for cell in row)
        ),
        None,
    )
    hint = (
        "; decimal commas, as in 0,213? points are needed where commas separate the cells"
        if len(row) > width and separator == ","
        else ""
    )
    hint = (
        f"; it looks separated by {other}, the header by "
        f"{SEPARATORS.get(separator, repr(separator))}"
        if other and len(row) < width
        else hint
    )
    if width == 1:
        hint = "; the first line is the header, unless it begins with #"
    raise InputError(f"{path}, line {line}: {len(row)} cells where the header has {width}{hint}")


def write_table(path: str | Path, headers: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; numbers with all their digits. A file that exists is replaced only when all
    is written.
    """
    write_output(path, table_text(headers, iter(rows)))


def table_text(headers: Sequence[str], rows: Iterator[Sequence[object]]) -> Iterator[str]:
    """The text of a table, many rows at a time."""
    block: list[Sequence[object]] = [headers]
    while block:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(
            [repr(float(cell)) if isinstance(cell, float) else cell for cell in row]
            for row in block
        )
        yield text.getvalue()
        block = list(itertools.islice(rows, ROWS_AT_ONCE))


def _value(cell: str) -> float | str:
    """The number in a cell, else its text."""
    try:
        value = float(cell)
    except ValueError:
        return cell.strip()
    return value if math.isfinite(value) else cell.strip()


def _refuse_controls(path: str, rows: list[tuple[int, list[str]]]) -> None:
    """Refuse cells with control or bidirectional characters, which are no text of a header, a label
    or a number.
    """
    for line, row in rows:
        for k, cell in enumerate(row, start=1):
            refused = refused_character(cell.replace("\t", " "))
            if refused is not None:
                raise InputError(
                    f"{path}, line {line}: cell {k} holds {code_point(refused)}; control and "
                    f"bidirectional characters are not allowed"
                )
