"""CSV files of measurements and trajectories: a header of names with units, `leg1[mm],theta[deg],group`, then rows.

Lines that begin with # and empty lines are left out. Every mistake names file, row (the line of the file) and column.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from symkin.errors import InputError

UNITS: dict[str, tuple[str, float]] = {
    "m": ("length", 1.0), "mm": ("length", 1e-3), "um": ("length", 1e-6), "in": ("length", 0.0254),
    "rad": ("angle", 1.0), "mrad": ("angle", 1e-3), "deg": ("angle", math.pi / 180), "arcsec": ("angle", math.pi / 648000),
    "s": ("time", 1.0), "ms": ("time", 1e-3),
}  # fmt: skip
"""Units that a header may name, what they measure, and how many of the SI unit they are."""

_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_HEADER = re.compile(r"([A-Za-z_][\w.]*)\s*(?:\[(\w+)\])?")


@dataclass(frozen=True)
class Column:
    """One column: its name, the unit in its header (None without one), and the text of each cell."""

    name: str
    unit: str | None
    cells: tuple[str, ...]

    @property
    def header(self) -> str:
        return self.name if self.unit is None else f"{self.name}[{self.unit}]"


@dataclass(frozen=True)
class Table:
    """The columns of a file by name, and the line on which each row stands."""

    path: str
    columns: dict[str, Column]
    lines: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.lines)

    def text(self, name: str) -> tuple[str, ...]:
        """The cells of a column as they are written."""
        return self._column(name).cells

    def numbers(self, name: str, kind: str | None = None, unit: str | None = None, *, empty: bool = False) -> list[float]:
        """The numbers of a column. With `kind` ("length", "angle", "time") the header must name a unit of that kind, and
        values are converted to `unit`; without one, the header must name none. Empty cells are nan with `empty`, else refused."""
        column = self._column(name)
        factor = self._factor(column, kind, unit)
        return [self._number(column, k, empty) * factor for k in range(len(self))]

    def refuse_unknown(self, allowed: Iterable[str]) -> None:
        """Refuse columns whose names are not allowed."""
        known = list(allowed)
        for name in self.columns:
            if name not in known:
                raise InputError(f"{self.path}: column {name!r} is unknown; allowed: {', '.join(known)}")

    def copies(self) -> tuple[tuple[int, int], ...]:
        """Rows (from 0) that repeat an earlier one in every cell, numbers by their values, with that one."""
        first: dict[tuple[object, ...], int] = {}
        found = []
        for k, row in enumerate(zip(*(c.cells for c in self.columns.values()), strict=True)):
            earlier = first.setdefault(tuple(map(_value, row)), k)
            if earlier != k:
                found.append((k, earlier))
        return tuple(found)

    def _column(self, name: str) -> Column:
        if name not in self.columns:
            raise InputError(f"{self.path}: column {name!r} is missing; the header has {', '.join(self.columns)}")
        return self.columns[name]

    def _factor(self, column: Column, kind: str | None, unit: str | None) -> float:
        if kind is None:
            if column.unit is not None:
                raise InputError(f"{self.path}: column {column.header!r} has a unit; {column.name!r} is a plain number")
            return 1.0
        allowed = [name for name, (measured, _) in UNITS.items() if measured == kind]
        if column.unit not in allowed:
            raise InputError(
                f"{self.path}: column {column.header!r} needs a unit of {kind}, as in {column.name}[{allowed[0]}]; "
                f"allowed: {', '.join(allowed)}"
            )
        return 1.0 if column.unit == unit else UNITS[column.unit or ""][1] / UNITS[unit or allowed[0]][1]

    def _number(self, column: Column, row: int, empty: bool) -> float:
        cell = column.cells[row].strip()
        if not cell and empty:
            return math.nan
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if _DECIMAL_COMMA.fullmatch(cell):
            raise InputError(
                f"{self.path}, line {self.lines[row]}, column {column.header!r}: {cell!r} has a decimal comma; a point is needed, "
                f"as in {cell.replace(',', '.')}"
            )
        if not math.isfinite(value):
            raise InputError(
                f"{self.path}, line {self.lines[row]}, column {column.header!r}: {cell!r} is not a number; a finite number is needed"
            )
        return value


def read_table(path: str | Path) -> Table:
    """Read a CSV file (UTF-8, separated by commas) with a header of `name` or `name[unit]`."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: the file cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: the file is not UTF-8 text; a CSV file with a header of names and units is needed") from None
    rows = _rows(str(path), text)
    if not rows:
        raise InputError(f"{path}: the file is empty; a header of names and units is needed, as in leg1[mm],theta[deg]")
    _refuse_separators(str(path), *rows[0])
    names = [_header(str(path), k, cell) for k, cell in enumerate(rows[0][1], start=1)]
    for k, (name, _) in enumerate(names):
        if name in [earlier for earlier, _ in names[:k]]:
            raise InputError(f"{path}: column {name!r} stands twice in the header; each name once")
    for line, row in rows[1:]:
        if len(row) != len(names):
            _refuse_separators(str(path), line, row)
            hint = "; decimal commas, as in 0,213? a point is needed" if len(row) > len(names) else ""
            raise InputError(f"{path}, line {line}: {len(row)} cells where the header has {len(names)}{hint}")
    cells = zip(*(row for _, row in rows[1:]), strict=True) if len(rows) > 1 else [()] * len(names)
    columns = {name: Column(name, unit, tuple(c)) for (name, unit), c in zip(names, cells, strict=True)}
    return Table(str(path), columns, tuple(line for line, _ in rows[1:]))


def write_table(path: str | Path, headers: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; numbers with all their digits. A file that exists is replaced only when all is written."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(headers)
    writer.writerows([repr(float(cell)) if isinstance(cell, float) else cell for cell in row] for row in rows)
    replace_text(path, text.getvalue())


def replace_text(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all: under a temporary name beside it, then in its place."""
    target = Path(path)
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    except OSError as error:
        raise InputError(f"{path}: the file cannot be written ({error.strerror})") from None
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, target)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        raise InputError(f"{path}: the file cannot be written ({error.strerror})") from None


def _value(cell: str) -> float | str:
    """The number in a cell, else its text."""
    try:
        value = float(cell)
    except ValueError:
        return cell.strip()
    return value if math.isfinite(value) else cell.strip()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _rows(path: str, text: str) -> list[tuple[int, list[str]]]:
    """Line numbers and cells of all rows that hold something."""
    reader = csv.reader(io.StringIO(text), skipinitialspace=True, strict=True)
    rows = []
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#"):
                rows.append((reader.line_num, row))
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: the line is not CSV ({error})") from None
    return rows


def _refuse_separators(path: str, line: int, row: list[str]) -> None:
    """Refuse a line whose cells are separated by something else than commas."""
    for mark, name in ((";", "semicolons"), ("\t", "tabs")):
        if any(mark in cell.strip() for cell in row):
            raise InputError(f"{path}, line {line}: the cells are separated by {name}; commas are needed, and points in numbers")


def _header(path: str, number: int, cell: str) -> tuple[str, str | None]:
    match = _HEADER.fullmatch(cell.strip())
    if match is None:
        raise InputError(f"{path}: header of column {number} is {cell.strip()!r}; a name or name[unit] is needed, as in leg1[mm]")
    name, unit = match.groups()
    if unit is not None and unit not in UNITS:
        raise InputError(f"{path}: column {name!r} has the unit {unit!r}; allowed: {', '.join(UNITS)}")
    return name, unit
