"""`leg1=100:200:11,leg2=150`: ranges as text; numbers may be arithmetic, as in mechanism files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.cli.options import number, pieces_from
from symkin.errors import InputError
from symkin.model.written_number import whole

_MOST_VALUES = 10**7
_FORMS = "NAME=LOW:HIGH:COUNT or NAME=VALUE"
_SAMPLE_FORMS = "NAME=LOW:HIGH"
_SAMPLE_GIVEN_FORMS = "NAME=LOW:HIGH or NAME=VALUE"


def read_values(
    text: str, option: str, *, sampled: bool = False, angle_unit: str = "rad"
) -> dict[str, float | list[float] | np.ndarray]:
    """Names with their values of --grid, with `sampled` the least and the largest; of --given also
    with the one value at which they are held, "pose" with its seven numbers. `angle_unit` is that
    of the arguments of sin, cos and tan. Raises InputError.
    """
    read, is_given = _Reader(option, sampled, angle_unit), option == "given"
    found: dict[str, float | list[float] | np.ndarray] = {}
    for name, parts in pieces_from(text, option, read.wrong, whole_pose=is_given).items():
        if is_given and (len(parts) > 1 or ":" not in parts[0]):
            numbers = [read.number(name, part) for part in parts]
            found[name] = numbers if len(numbers) > 1 else numbers[0]
        else:
            found[name] = read.values(name, parts[0])
    return found


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

    @property
    def wrong(self) -> str:
        return f"is not of the form {self.forms}"

    def number(self, name: str, text: str) -> float:
        found = number(text, name, self.option, self.angle_unit)
        if not np.isfinite(found):
            raise InputError(f"--{self.option}: {text.strip()!r} of {name} is not finite")
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
            return np.array([self.number(name, parts[0])])
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
        low, high = (self.number(name, part) for part in parts[:2])
        if high < low:
            raise InputError(
                f"--{self.option}: {name} = {parts[0]}:{parts[1]} is reversed; the lower bound "
                f"comes first"
            )
        return low, high
