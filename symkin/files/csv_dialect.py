"""CSV text as people have it, brought into one form: cells separated by semicolons or tabs, decimal
commas, NaN, units in parentheses, names in capitals. What can be read in two ways is refused.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from symkin.errors import InputError
from symkin.regular_file import content_of

_SPREADSHEETS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""How .xlsx and .ods, and .xls, begin."""
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
_NAMED = re.compile(r"sep=(.)", re.IGNORECASE)
"""A first line by which spreadsheets name the separator."""
_HEADER = re.compile(r"(.+?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\)|/\s*([^/\s]+))?")
_SAME_UNIT = {
    "µm": "um",
    "μm": "um",
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "radian": "rad",
    "radians": "rad",
    "inch": "in",
}
"""Other ways to write a unit."""
_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_POINT = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(?:,\d{3})+")
"""A number whose comma may as well separate thousands."""
_BLANK = ("nan", "na", "n/a", "#n/a", "#nv", "null", "none")
"""Cells, in small letters, by which programs say that nothing was read."""
_LISTED = 5
"""Most names that a note lists."""


def read_text(path: str | Path) -> tuple[str, tuple[str, ...]]:
    """A file's text, UTF-8 or else Windows-1252, and a note on the latter."""
    content = content_of(path)
    if content.startswith(_SPREADSHEETS):
        raise InputError(
            f"{path}: the file is a spreadsheet; a CSV file is needed; save the sheet as one"
        )
    try:
        return content.decode("utf-8-sig"), ()
    except UnicodeDecodeError:
        pass
    try:
        text = content.decode("cp1252")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise InputError(
            f"{path}: the file is not UTF-8 text; a CSV file with a header of names and units is "
            f"needed, which spreadsheets save as CSV UTF-8"
        )
    return text, ("the file is not UTF-8 text; it was read as Windows-1252",)


# --- separators -----------------------------------------------------------------------------------


def split_rows(path: str, text: str) -> tuple[list[tuple[int, list[str]]], str]:
    """Line numbers and cells of all rows that hold something, comments left out, and the separator:
    the only one of commas, semicolons and tabs that stands in the header, outside quotes and units.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    named = _NAMED.fullmatch(lines[0].strip('" '))
    begin = 1 if named else 0
    header = next(
        (
            line
            for line in lines[begin:]
            if line.strip(" ,;\t") and not line.lstrip().startswith("#")
        ),
        "",
    )
    separator = named[1] if named else _separator(path, header)
    reader = csv.reader(
        io.StringIO("\n".join(lines[begin:])),
        delimiter=separator,
        skipinitialspace=True,
        strict=True,
    )
    rows = []
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not _is_comment(row[0]):
                rows.append((reader.line_num + begin, row))
    except csv.Error as error:
        raise InputError(
            f"{path}, line {reader.line_num + begin}: the line is not CSV ({error})"
        ) from None
    return rows, separator


def _is_comment(cell: str) -> bool:
    return cell.lstrip().startswith("#") and cell.strip().casefold() not in _BLANK


def _separator(path: str, header: str) -> str:
    bare = re.sub(r'"[^"]*"|\([^()]*\)|\[[^\[\]]*\]', "", header)
    found = [mark for mark in SEPARATORS if mark in bare]
    if len(found) > 1:
        names = " and ".join(SEPARATORS[mark] for mark in found)
        raise InputError(
            f"{path}: {names} stand in the header, so that either may separate the cells; use one "
            f"of them only"
        )
    return found[0] if found else ","


# --- headers --------------------------------------------------------------------------------------


def split_header(cell: str, units: Iterable[str]) -> tuple[str, str | None]:
    """Name and unit, from `leg1[mm]`, `Leg1 (mm)` or `leg1 / mm`; a unit in brackets that is
    unknown stays as it is.
    """
    match = _HEADER.fullmatch(cell.strip())
    if match is None:
        return cell.strip(), None
    name, *written = match.groups()
    given = next((unit.strip() for unit in written if unit is not None), None)
    if given is None:
        return name, None
    meant = next(
        (unit for unit in units if unit in (given, _SAME_UNIT.get(given, given).lower())), None
    )
    if meant is None and written[0] is None:
        return cell.strip(), None  # a remark, and no unit
    return name, given if meant is None else meant


def matched_names(path: str, names: Sequence[str], known: Sequence[str]) -> dict[str, str]:
    """Names of columns that mean known ones: the same, or the only ones that differ in capitals,
    spaces, hyphens and underscores.
    """
    found = {name: name for name in names if name in known}
    loose: dict[str, list[str]] = {}
    for name in known:
        loose.setdefault(_key(name), []).append(name)
    for name in names:
        meant = loose.get(_key(name), [])
        if name in found or not meant:
            continue
        if len(meant) > 1:
            raise InputError(
                f"{path}: column {name!r} may be {' or '.join(map(repr, meant))}; write the one "
                f"that is meant"
            )
        earlier = next((other for other, target in found.items() if target == meant[0]), None)
        if earlier is not None:
            raise InputError(
                f"{path}: the columns {earlier!r} and {name!r} both mean {meant[0]!r}; leave one "
                f"out"
            )
        found[name] = meant[0]
    return found


def _key(name: str) -> str:
    return re.sub(r"[\s_-]", "", name).casefold()


# --- cells ----------------------------------------------------------------------------------------


def blanked(cells: Sequence[str]) -> tuple[tuple[str, ...], int]:
    """Cells with NaN and its like empty, and how many these were."""
    blank = [cell.strip().casefold() in _BLANK for cell in cells]
    return tuple("" if empty else cell for cell, empty in zip(cells, blank, strict=True)), sum(
        blank
    )


def has_decimal_commas(
    path: str, columns: Iterable[tuple[str, Sequence[str]]], separator: str
) -> bool:
    """Whether the numbers of some columns (header, cells) have decimal commas. Raises InputError
    where points stand beside them, and where all commas may separate thousands: not where
    semicolons separate the cells, as they do because of decimal commas.
    """
    columns = list(columns)
    if not any("," in cell for _, cells in columns for cell in cells):
        return False
    commas, points, sure = None, None, separator == ";"
    for header, cells in columns:
        for cell in map(str.strip, cells):
            if _COMMA.fullmatch(cell) or _THOUSANDS.fullmatch(cell):
                commas, sure = commas or (header, cell), sure or not _THOUSANDS.fullmatch(cell)
            elif points is None and _POINT.fullmatch(cell):
                points = (header, cell)
    if commas is None:
        return False
    if points is not None:
        raise InputError(
            f"{path}: column {commas[0]!r} has {commas[1]!r} and column {points[0]!r} has "
            f"{points[1]!r}, so that commas may be decimal "
            "or separate thousands; write all numbers with decimal points, or all with decimal "
            "commas, and none for thousands"
        )
    if not sure:
        raise InputError(
            f"{path}: column {commas[0]!r} has {commas[1]!r}, and every comma of the file may be "
            f"decimal or separate thousands; write "
            "decimal points"
        )
    return True


def with_points(cells: Sequence[str]) -> tuple[str, ...]:
    """Numbers with decimal commas as numbers with points."""
    return tuple(
        cell.replace(",", ".") if _COMMA.fullmatch(cell.strip()) else cell for cell in cells
    )


def listed(names: Sequence[str]) -> str:
    """The first few of some names, and how many more there are."""
    more = len(names) - _LISTED
    return ", ".join(map(repr, names[:_LISTED])) + (f" and {more} more" if more > 0 else "")
