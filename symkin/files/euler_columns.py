"""Columns of CSV files that hold orientations as three angles: `euler_ZYX_1` to `euler_ZYX_3` of
any sequence, or roll, pitch, yaw.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from itertools import product

from symkin.errors import InputError
from symkin.files.csv_table import Table

SEQUENCES = tuple(
    "".join(s).upper() if moving else "".join(s)
    for moving in (True, False)
    for s in product("xyz", repeat=3)
    if s[0] != s[1] != s[2]
)
"""The twelve sequences about moving axes (capitals), then the twelve about fixed ones."""
_EULER_HEADER = re.compile(r"(platform\.)?(euler)_([A-Za-z]{3})_([123])", re.IGNORECASE)
_ROLL_PITCH_YAW = ("roll", "pitch", "yaw")
"""Names of the angles about the fixed axes x, y, z, in this order."""


def sequenced_columns(table: Table, names: Collection[str]) -> dict[str, str]:
    """Map columns of Euler angles whose header names the sequence to their names as they are
    written here; roll, pitch and yaw too, unless one of these is among the mechanism's `names`.
    Letters of the sequence say by their size which axes are meant; where the whole header is in
    capitals they do not.
    """
    found = _roll_pitch_yaw(table, names)
    for name in table.columns:
        match = _EULER_HEADER.fullmatch(name)
        if match is None:
            continue
        place, word, sequence, number = match.groups()
        if word.isupper() and sequence.isupper():
            raise InputError(
                f"{table.path}: column {name!r} is in capitals, so that the letters do not say "
                f"which axes are meant; write "
                f"euler_{sequence}_{number} for moving axes, euler_{sequence.lower()}_{number} for "
                f"fixed ones"
            )
        if sequence not in SEQUENCES:
            raise InputError(
                f"{table.path}: column {name!r} names the sequence {sequence!r}; allowed: three "
                f"letters x, y, z with "
                "neighbours different, capitals about moving axes (ZYX), small letters about fixed "
                "ones (xyz)"
            )
        target = f"{'platform.' if place else ''}euler_{sequence}_{number}"
        twice = next((other for other, meant in found.items() if meant == target), None)
        if twice is not None:
            raise InputError(
                f"{table.path}: the columns {twice!r} and {name!r} both mean {target!r}; leave one "
                f"out"
            )
        found[name] = target
    return found


def _roll_pitch_yaw(table: Table, names: Collection[str]) -> dict[str, str]:
    angles = {name.casefold(): name for name in table.columns if name.casefold() in _ROLL_PITCH_YAW}
    if not angles or any(angle in names for angle in _ROLL_PITCH_YAW):
        return {}
    missing = [angle for angle in _ROLL_PITCH_YAW if angle not in angles]
    if missing:
        raise InputError(
            f"{table.path}: column {next(iter(angles.values()))!r} stands there without "
            f"{' and '.join(missing)}; roll, pitch and yaw are read together; rename it where it "
            f"is to be left out"
        )
    return {angles[a]: f"euler_xyz_{k}" for k, a in enumerate(_ROLL_PITCH_YAW, start=1)}
