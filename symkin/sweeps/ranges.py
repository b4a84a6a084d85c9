"""`leg1=100:200:11,leg2=150`: ranges as text; numbers may be arithmetic, as in mechanism files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from symkin.errors import InputError
from symkin.model.written_number import whole, written_number

_MOST_VALUES = 10**7
_ROUNDING = 1e-9
"""Share of a bound by which a slice may pass it: the last digits of arithmetic."""
_FORMS = "NAME=LOW:HIGH:COUNT or NAME=VALUE"
_SAMPLE_FORMS = "NAME=LOW:HIGH"


def read_ranges(text: str, *, sampled: bool = False, angle_unit: str = "rad") -> dict[str, np.ndarray]:
    """Names with their values; with `sampled` the least and the largest. `angle_unit` is that of the arguments of sin, cos and
    tan. Raises InputError."""
    found: dict[str, np.ndarray] = {}
    for part in text.split(","):
        name, equals, values = (piece.strip() for piece in part.partition("="))
        if not equals or not name:
            raise InputError(f"--grid: {part.strip()!r} is not of the form {_SAMPLE_FORMS if sampled else _FORMS}")
        if name in found:
            raise InputError(f"--grid: {name} is given twice")
        found[name] = _sampled(name, values, angle_unit) if sampled else _values(name, values, angle_unit)
    return found


def _values(name: str, text: str, angle_unit: str) -> np.ndarray:
    parts = text.split(":")
    if len(parts) == 1:
        return np.array([_number(name, parts[0], angle_unit)])
    if len(parts) != 3:
        raise InputError(f"--grid: {name} = {text!r}; allowed: {_FORMS} (with --random: {_SAMPLE_FORMS})")
    low, high = _ends(name, parts, angle_unit)
    count = whole(parts[2])
    if count is None:
        raise InputError(f"--grid: the count {parts[2].strip()!r} of {name} is not a whole number")
    if not 1 <= count <= _MOST_VALUES:
        raise InputError(f"--grid: {name} has {count} values; allowed: 1 to {_MOST_VALUES}")
    if (count == 1) != (low == high):
        raise InputError(f"--grid: {name} = {text}: one value has equal ends, several have different ones")
    return np.linspace(low, high, count)


def _sampled(name: str, text: str, angle_unit: str) -> np.ndarray:
    parts = text.split(":")
    if len(parts) != 2:
        raise InputError(f"--grid: {name} = {text!r}; with --random allowed: {_SAMPLE_FORMS}")
    return np.array(_ends(name, parts, angle_unit))


def _ends(name: str, parts: list[str], angle_unit: str) -> tuple[float, float]:
    low, high = (_number(name, part, angle_unit) for part in parts[:2])
    if high < low:
        raise InputError(f"--grid: {name} = {parts[0]}:{parts[1]} is reversed; the lower bound comes first")
    return low, high


def _number(name: str, text: str, angle_unit: str, option: str = "grid") -> float:
    try:
        number = written_number(text, angle_unit)
    except InputError as error:
        raise InputError(f"--{option}: {name}: {error}") from None
    if not np.isfinite(number):
        raise InputError(f"--{option}: {text.strip()!r} of {name} is not finite")
    return number


def read_values(text: str, option: str, *, angle_unit: str = "rad") -> dict[str, float]:
    """`leg3=150,leg4=120`: names with one value each."""
    found: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name:
            raise InputError(f"--{option}: {part.strip()!r} is not of the form NAME=VALUE")
        found[name] = _number(name, value, angle_unit, option)
    return found


def check_slices(slices: Mapping[str, float], swept: Mapping[str, np.ndarray], *, sampled: bool) -> None:
    """Raises InputError for slices that a sweep over these values does not have."""
    if slices and sampled:
        raise InputError("slice: a random sample has no slices; it is drawn over the first two swept values")
    for name, value in slices.items():
        if name not in swept:
            raise InputError(f"slice: {name!r} is not swept; allowed: {', '.join(swept)}")
        low, high = float(np.min(swept[name])), float(np.max(swept[name]))
        slack = _ROUNDING * max(abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            allowed = f"{low:.10g} to {high:.10g}" if high > low else f"{low:.10g}"
            raise InputError(f"slice: {name} = {value:.10g} lies outside what is swept; allowed: {allowed}")


def check_map_is_left(slices: Mapping[str, float], swept: Iterable[str]) -> None:
    """Raises InputError for slices that leave nothing over which a map could be drawn."""
    if slices and set(swept) <= set(slices):
        all_of_it = f"{', '.join(slices)} {'is' if len(slices) == 1 else 'are'} all that is swept"
        raise InputError(f"slice: {all_of_it}; leave at least one out, over which the map is drawn")
