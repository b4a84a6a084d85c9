"""A sweep as a table: a row for each mode, or for each point where nothing is stored of single
modes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.files.csv_table import ROWS_AT_ONCE, write_table
from symkin.sweeps.interrupts import interrupts_held
from symkin.sweeps.layout import labels

MOST_ROWS = 1_000_000
"""Rows of a table: more are for the arrays and not for a spreadsheet."""
_FIRST = ("points", "position", "quaternion", "joints", "residual", "condition")
"""Arrays whose columns come first."""
_LEFT_OUT = ("completeness", "unresolved", "continuum")
"""Arrays over the points that say how a list was found, and are no column."""


@dataclass(frozen=True, eq=False)
class _Column:
    """A column of a table: its header and its numbers, one a row."""

    header: str
    numbers: np.ndarray


def write_csv(data: Any, swept: Sequence[str], path: Path | str) -> int:
    """Write the arrays of a sweep over some names as a CSV file; how many rows it has. Raises
    InputError.
    """
    with interrupts_held():
        columns = _columns(data, swept)
    write_table(
        path,
        [column.header for column in columns],
        rows_of([column.numbers for column in columns]),
    )
    return len(columns[0].numbers)


def rows_of(columns: Sequence[np.ndarray]) -> Iterator[tuple[float | int | str, ...]]:
    """The cells of each row, from as many at once as are held as Python's numbers."""
    for begin in range(0, len(columns[0]), ROWS_AT_ONCE):
        block = slice(begin, begin + ROWS_AT_ONCE)
        yield from zip(*(_cells(numbers[block]) for numbers in columns), strict=True)


def _cells(numbers: np.ndarray) -> list[float | int | str]:
    """Numbers as they are written; what is not there, a flag that is -1 among them, is an empty
    cell.
    """
    flags = numbers.dtype.kind == "i"
    return [
        "" if number != number or (flags and number < 0) else number for number in numbers.tolist()
    ]


def _columns(data: Any, swept: Sequence[str]) -> list[_Column]:
    count = np.maximum(data["count"].values.ravel(), 0)
    per_mode = any("mode" in data[name].dims for name in data.data_vars)
    rows = int(count.sum()) if per_mode else count.size
    if rows > MOST_ROWS:
        raise InputError(
            f"csv: the sweep has {rows} rows; allowed: {MOST_ROWS}, and xarray.open_zarr reads the "
            f"arrays of more"
        )
    owner = np.repeat(np.arange(count.size), count) if per_mode else np.arange(count.size)
    number = (
        np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) if per_mode else None
    )
    columns = list(_of_points(data, swept, owner, count.size))
    columns += [] if number is None else [_Column("mode", number + 1)]
    others = sorted(str(name) for name in data.data_vars if name not in (*_FIRST, *_LEFT_OUT))
    for name in (*(name for name in _FIRST if name in data), *others):
        if number is not None and "mode" in data[name].dims:
            columns += _of_modes(data, name, owner, number)
        elif number is None and set(data[name].dims) == set(data["count"].dims):
            columns.append(_Column(_header(name, data[name]), data[name].values.ravel()))
    first: dict[str, _Column] = {}
    for column in columns:
        # a coordinate that is swept is a joint, or of the platform's place, as well
        first.setdefault(column.header, column)
    return list(first.values())


def _of_points(
    data: Any, swept: Sequence[str], owner: np.ndarray, points: int
) -> Iterator[_Column]:
    """The values that are swept."""
    for name, label in zip(swept, labels(swept), strict=True):
        values = data[label].broadcast_like(data["count"]).transpose(*data["count"].dims).values
        yield _Column(_header(name, data[label]), values.reshape(points)[owner])


def _of_modes(data: Any, name: str, owner: np.ndarray, number: np.ndarray) -> Iterator[_Column]:
    """The columns of an array that has a value, or several, for each mode."""
    array = data[name]
    points = array.ndim - 1 - array.dims.index("mode")
    values = array.values.reshape(-1, *array.shape[array.ndim - points - 1 :])[owner, number]
    if not points:
        yield _Column(_header(name, array), values)
    elif name == "joints":
        for k, (joint, unit) in enumerate(
            zip(data["joint"].values, data["joint_units"].values, strict=True)
        ):
            yield _Column(f"{joint}[{unit}]" if unit != "1" else str(joint), values[:, k])
    elif name == "points":
        for i, point in enumerate(data["named_point"].values):
            for k, axis in enumerate("xyz"):
                yield _Column(f"{point}.{axis}[{array.attrs['units']}]", values[:, i, k])
    else:
        prefix, unit = ("", f"[{array.attrs['units']}]") if name == "position" else ("q", "")
        for k, axis in enumerate(data[array.dims[-1]].values):
            yield _Column(f"{prefix}{axis}{unit}", values[:, k])


def _header(name: str, array: Any) -> str:
    unit = array.attrs.get("units", "1")
    return name if unit == "1" else f"{name}[{unit}]"
