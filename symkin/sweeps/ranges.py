"""`leg1=100:200:11,leg2=150`: ranges as text."""

from __future__ import annotations

import numpy as np

from symkin.errors import InputError

_MOST_VALUES = 10**7
_FORMS = "NAME=LOW:HIGH:COUNT or NAME=VALUE"
_SAMPLE_FORMS = "NAME=LOW:HIGH"


def read_ranges(text: str, *, sampled: bool = False) -> dict[str, np.ndarray]:
    """Names with their values; with `sampled` the least and the largest. Raises InputError."""
    found: dict[str, np.ndarray] = {}
    for part in text.split(","):
        name, equals, values = (piece.strip() for piece in part.partition("="))
        if not equals or not name:
            raise InputError(f"--grid: {part.strip()!r} is not of the form {_SAMPLE_FORMS if sampled else _FORMS}")
        if name in found:
            raise InputError(f"--grid: {name} is given twice")
        found[name] = _sampled(name, values) if sampled else _values(name, values)
    return found


def _values(name: str, text: str) -> np.ndarray:
    parts = text.split(":")
    if len(parts) == 1:
        return np.array([_number(name, parts[0])])
    if len(parts) != 3:
        raise InputError(f"--grid: {name} = {text!r}; allowed: {_FORMS} (with --random: {_SAMPLE_FORMS})")
    low, high = _ends(name, parts)
    try:
        count = int(parts[2])
    except ValueError:
        raise InputError(f"--grid: the count {parts[2].strip()!r} of {name} is not a whole number") from None
    if not 1 <= count <= _MOST_VALUES:
        raise InputError(f"--grid: {name} has {count} values; allowed: 1 to {_MOST_VALUES}")
    if (count == 1) != (low == high):
        raise InputError(f"--grid: {name} = {text}: one value has equal ends, several have different ones")
    return np.linspace(low, high, count)


def _sampled(name: str, text: str) -> np.ndarray:
    parts = text.split(":")
    if len(parts) != 2:
        raise InputError(f"--grid: {name} = {text!r}; with --random allowed: {_SAMPLE_FORMS}")
    return np.array(_ends(name, parts))


def _ends(name: str, parts: list[str]) -> tuple[float, float]:
    low, high = _number(name, parts[0]), _number(name, parts[1])
    if high < low:
        raise InputError(f"--grid: {name} = {parts[0]}:{parts[1]} is reversed; the lower bound comes first")
    return low, high


def _number(name: str, text: str, option: str = "grid") -> float:
    try:
        number = float(text)
    except ValueError:
        raise InputError(f"--{option}: {text.strip()!r} of {name} is not a number") from None
    if not np.isfinite(number):
        raise InputError(f"--{option}: {text.strip()!r} of {name} is not finite")
    return number


def read_values(text: str, option: str) -> dict[str, float]:
    """`leg3=150,leg4=120`: names with one value each."""
    found: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name:
            raise InputError(f"--{option}: {part.strip()!r} is not of the form NAME=VALUE")
        found[name] = _number(name, value, option)
    return found
