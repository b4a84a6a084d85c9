"""`leg1=100:200:11,leg2=150`: ranges as text; numbers may be arithmetic, as in mechanism files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from symkin.errors import InputError
from symkin.model.written_number import whole, written_number
from symkin.text import meant

_MOST_VALUES = 10**7
_ROUNDING = 1e-9
"""Share of a bound by which a slice may pass it: the last digits of arithmetic."""
_FORMS = "NAME=LOW:HIGH:COUNT or NAME=VALUE"
_SAMPLE_FORMS = "NAME=LOW:HIGH"
_SAMPLE_GIVEN_FORMS = "NAME=LOW:HIGH or NAME=VALUE"


def read_ranges(
    text: str, *, sampled: bool = False, angle_unit: str = "rad"
) -> dict[str, np.ndarray]:
    """Names with their values; with `sampled` the least and the largest. `angle_unit` is that of
    the arguments of sin, cos and tan. Raises InputError.
    """
    read = _Reader("grid", sampled, angle_unit)
    return {
        name: read.values(name, parts[0])
        for name, parts in read.split(text, whole_pose=False).items()
    }


def read_given(
    text: str, *, sampled: bool = False, angle_unit: str = "rad"
) -> dict[str, float | list[float] | np.ndarray]:
    """Names with the one value at which they are held, or with their values as `read_ranges` has
    them; "pose" with its seven numbers. Raises InputError.
    """
    read = _Reader("given", sampled, angle_unit)
    found: dict[str, float | list[float] | np.ndarray] = {}
    for name, parts in read.split(text, whole_pose=True).items():
        if len(parts) > 1:
            found[name] = [_number(name, part, angle_unit, "given") for part in parts]
        elif ":" in parts[0]:
            found[name] = read.values(name, parts[0])
        else:
            found[name] = _number(name, parts[0], angle_unit, "given")
    return found


def ranged(given: Mapping[str, float | list[float] | np.ndarray]) -> dict[str, np.ndarray]:
    """What is swept of values that `read_given` has read."""
    return {name: values for name, values in given.items() if isinstance(values, np.ndarray)}


@dataclass(frozen=True)
class _Reader:
    """How ranges of one option are read."""

    option: str
    sampled: bool
    angle_unit: str

    @property
    def forms(self) -> str:
        if not self.sampled:
            return _FORMS
        return _SAMPLE_FORMS if self.option == "grid" else _SAMPLE_GIVEN_FORMS

    def split(self, text: str, *, whole_pose: bool) -> dict[str, list[str]]:
        """What stands after each name, up to the next one: one piece, of a whole pose seven."""
        found: dict[str, list[str]] = {}
        name = ""
        for part in text.split(","):
            before, equals, after = (piece.strip() for piece in part.partition("="))
            if not equals and whole_pose and name == "pose":
                found[name].append(before)
                continue
            name = before
            if not equals or not name:
                raise InputError(
                    f"--{self.option}: {part.strip()!r} is not of the form {self.forms}"
                )
            if name in found:
                raise InputError(f"--{self.option}: {name} is given twice")
            found[name] = [after]
        return found

    def values(self, name: str, text: str) -> np.ndarray:
        """All values of a grid, the least and the largest of a sample."""
        parts = text.split(":")
        if self.sampled:
            if len(parts) != 2:
                raise InputError(
                    f"--{self.option}: {name} = {text!r}; with --random allowed: {self.forms}"
                )
            return np.array(self._ends(name, parts))
        if len(parts) == 1:
            return np.array([_number(name, parts[0], self.angle_unit, self.option)])
        if len(parts) != 3:
            raise InputError(
                f"--{self.option}: {name} = {text!r}; allowed: {_FORMS} (with --random: "
                f"{_SAMPLE_FORMS})"
            )
        return self._spaced(name, text, parts)

    def _spaced(self, name: str, text: str, parts: list[str]) -> np.ndarray:
        low, high = self._ends(name, parts)
        count = whole(parts[2])
        if count is None:
            raise InputError(
                f"--{self.option}: the count {parts[2].strip()!r} of {name} is not a whole number"
            )
        if not 1 <= count <= _MOST_VALUES:
            raise InputError(
                f"--{self.option}: {name} has {count} values; allowed: 1 to {_MOST_VALUES}"
            )
        if (count == 1) != (low == high):
            raise InputError(
                f"--{self.option}: {name} = {text}: one value has equal ends, several have "
                f"different ones"
            )
        return np.linspace(low, high, count)

    def _ends(self, name: str, parts: list[str]) -> tuple[float, float]:
        low, high = (_number(name, part, self.angle_unit, self.option) for part in parts[:2])
        if high < low:
            raise InputError(
                f"--{self.option}: {name} = {parts[0]}:{parts[1]} is reversed; the lower bound "
                f"comes first"
            )
        return low, high


def _number(name: str, text: str, angle_unit: str, option: str) -> float:
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


def check_slices(
    slices: Mapping[str, float], swept: Mapping[str, np.ndarray], *, sampled: bool
) -> None:
    """Raises InputError for slices that a sweep over these values does not have."""
    if slices and sampled:
        raise InputError(
            "slice: a random sample has no slices; it is drawn over the first two swept values"
        )
    for name, value in slices.items():
        if name not in swept:
            raise InputError(
                f"slice: {name!r} is not swept{meant(name, swept)}; allowed: {', '.join(swept)}"
            )
        low, high = float(np.min(swept[name])), float(np.max(swept[name]))
        slack = _ROUNDING * max(abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            allowed = f"{low:.10g} to {high:.10g}" if high > low else f"{low:.10g}"
            raise InputError(
                f"slice: {name} = {value:.10g} lies outside what is swept; allowed: {allowed}"
            )


def check_map_is_left(slices: Mapping[str, float], swept: Iterable[str]) -> None:
    """Raises InputError for slices that leave nothing over which a map could be drawn."""
    if slices and set(swept) <= set(slices):
        all_of_it = f"{', '.join(slices)} {'is' if len(slices) == 1 else 'are'} all that is swept"
        raise InputError(f"slice: {all_of_it}; leave at least one out, over which the map is drawn")
