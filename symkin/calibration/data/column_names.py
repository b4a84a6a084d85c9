"""Name the columns of measurement files: which are known, what they mean by other names, and what
misspelt ones may mean.
"""

from __future__ import annotations

from collections.abc import Sequence

from symkin.calibration.data.observables import POSE_COLUMNS, Measure, observables
from symkin.errors import InputError
from symkin.files.csv_table import Table
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.text import meant, nearest

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


def unit_of(mechanism: Mechanism, measure: Measure) -> str:
    """Return the file's unit of lengths or angles."""
    return mechanism.length_unit if measure == "length" else mechanism.angle_unit


def reading_name(mechanism: Mechanism, name: str) -> str:
    """Name the column of a reading: its name, or platform.NAME where a joint has that name."""
    return (
        f"platform.{name}"
        if any(c.name == name for c in mechanism.coordinates if c.width == 1)
        else name
    )


def measure_of(c: Coordinate) -> Measure:
    """Say whether a coordinate is a length or an angle."""
    return "angle" if c.is_angular else "length"


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
