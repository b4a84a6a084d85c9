"""Options that are quantities: numbers with a unit of their own, or in the mechanism's."""

from __future__ import annotations

import math
import re
import sys
from typing import TYPE_CHECKING

from symkin.errors import InputError
from symkin.files.csv_table import UNITS
from symkin.model.arithmetic import plain_number

if TYPE_CHECKING:
    import numpy as np

    from symkin.model.mechanism import Mechanism

DistancePoints = tuple[list[float], list[float]]
"""Ends of a distance: a point of the platform frame and one of the base frame, length unit."""
_MAX_NOISE_SHARE = 0.1
"""Standard deviation over the size, or in radians, from which readings tell nothing and a unit must
be wrong.
"""
_QUANTITY = re.compile(r"\s*([-+0-9.eE]+?)\s*([a-zA-Z]+)?\s*")


def quantity(
    text: str, kind: str, mechanism: Mechanism, option: str, *, least: float = 0.0
) -> float:
    """A length in the mechanism's unit or an angle in radians, from `2um`, `0.001deg` or a plain
    number in the mechanism's unit.
    """
    match = _QUANTITY.fullmatch(text)
    read = plain_number(match[1]) if match else None
    number = math.nan if read is None else read
    allowed = [name for name, (measured, _) in UNITS.items() if measured == kind]
    own = mechanism.length_unit if kind == "length" else mechanism.angle_unit
    unit = (match[2] or own) if match else own
    if not math.isfinite(number) or number < least or unit not in allowed:
        bound = "" if least == -math.inf else f" from {least:g}"
        raise InputError(
            f"--{option} {text.strip()!r}: a number{bound} with a unit of {kind} is needed "
            f"({', '.join(allowed)}; without "
            f"one {own} is meant)"
        )
    return number * UNITS[unit][1] / (UNITS[mechanism.length_unit][1] if kind == "length" else 1.0)


def noise_quantity(text: str, kind: str, mechanism: Mechanism, option: str) -> float:
    """A standard deviation of readings, as `quantity`; one that is out of all proportion is
    refused.
    """
    value = quantity(text, kind, mechanism, option)
    check_noise(value, kind, mechanism, option)
    return value


def check_noise(value: float, kind: str, mechanism: Mechanism, option: str) -> None:
    """Refuse a standard deviation beyond a tenth of the mechanism's size, or of a radian: nothing
    could be told from such readings.
    """
    m = mechanism
    most, given, unit = (
        (_MAX_NOISE_SHARE * m.characteristic_length, value, m.length_unit)
        if kind == "length"
        else (_MAX_NOISE_SHARE, m.angle_out(value), m.angle_unit)
    )
    if value > most:
        bound = (
            f"a tenth of the size of {m.name}, {most:.3g}"
            if kind == "length"
            else f"{m.angle_out(most):.3g}"
        )
        raise InputError(
            f"--{option}: a standard deviation of {given:g} {unit} is given; allowed: to {bound} "
            f"{unit}; check the unit"
        )


def joint_quantities(text: str, mechanism: Mechanism, option: str) -> np.ndarray:
    """One value for each actuated joint (a,): a length, an angle or both (`2um,0.001deg`), each for
    the joints of its kind.
    """
    values: dict[str, float] = {}
    kinds = {"angle" if c.is_angular else "length" for c in mechanism.actuated}
    for part in text.split(","):
        match = _QUANTITY.fullmatch(part)
        unit = match[2] if match else None
        if unit is None and len(kinds) > 1:
            raise InputError(
                f"--{option} {part.strip()!r}: {mechanism.name} has lengths and angles; give a "
                f"unit, as in 2um,0.001deg"
            )
        kind = UNITS[unit][0] if unit in UNITS else next(iter(kinds))
        values[kind] = quantity(part, kind, mechanism, option)
    missing = kinds - set(values)
    if missing or set(values) - kinds:
        raise InputError(
            f"--{option} {text!r}: {mechanism.name} has actuated joints that are "
            f"{' and '.join(sorted(kinds))}s; one value for each is needed"
        )
    import numpy as np

    return np.array([values["angle" if c.is_angular else "length"] for c in mechanism.actuated])


def tolerances(text: str, mechanism: Mechanism) -> tuple[float, float]:
    """Tolerances of lengths (length unit) and of angles (radians), from `1mm,0.1deg` in any
    order.
    """
    values: dict[str, float] = {}
    for part in text.split(","):
        match = _QUANTITY.fullmatch(part)
        kind = UNITS[match[2]][0] if match and match[2] in UNITS else ""
        if kind in ("length", "angle") and kind not in values:
            values[kind] = quantity(part, kind, mechanism, "tolerance", least=sys.float_info.min)
    if len(values) != 2 or text.count(",") != 1:
        raise InputError(
            f"--tolerance {text!r}: a length and an angle with their units are needed, as in "
            f"1mm,0.1deg"
        )
    return values["length"], values["angle"]


def distance_points(texts: list[str] | None, mechanism: Mechanism) -> dict[str, DistancePoints]:
    """Points of distances by name, from `bar=0,0,50:0,0,-20mm`: in the platform's or tool's frame,
    then in the base frame.
    """
    found: dict[str, DistancePoints] = {}
    for text in texts or ():
        name, _, points = text.partition("=")
        ends = [end.split(",") for end in points.split(":")]
        name = name.strip()
        if not re.fullmatch(r"[A-Za-z]\w*", name) or [len(end) for end in ends] != [3, 3]:
            raise InputError(
                f"--distance {text!r}: NAME=X,Y,Z:BX,BY,BZ is needed, a point in the platform "
                f"frame and one in the base frame, as in "
                "bar=0,0,50:0,0,-20"
            )
        if name in found:
            raise InputError(f"--distance {text!r}: {name!r} is given twice")
        platform, base = (
            [quantity(v, "length", mechanism, "distance", least=-math.inf) for v in end]
            for end in ends
        )
        found[name] = platform, base
    return found


def angle_pairs(text: str, mechanism: Mechanism, option: str) -> np.ndarray:
    """Pairs of angles (n, 2) in radians, from `20:20,-20:20`."""
    pairs = []
    for part in text.split(","):
        ends = part.split(":")
        if len(ends) != 2:
            raise InputError(
                f"--{option}: {part.strip()!r} is no pair; alpha:beta pairs separated by commas "
                f"are needed, as in 0:0,20:-20"
            )
        pairs.append([quantity(end, "angle", mechanism, option, least=-math.inf) for end in ends])
    import numpy as np

    return np.array(pairs)
