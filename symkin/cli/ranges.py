"""`leg1=100:200:11,leg2=150`: ranges as text; numbers may be arithmetic, as in mechanism files."""

from __future__ import annotations

import numpy as np

from symkin.cli.options import number, pieces_from
from symkin.errors import InputError
from symkin.model.written_number import whole

_MOST_VALUES = 10**7
_FORMS = "NAME=LOW:HIGH:COUNT or NAME=VALUE"


def read_values(
    text: str, option: str, *, sampled: bool = False, angle_unit: str = "rad"
) -> dict[str, float | list[float] | np.ndarray]:
    """Names with their values of --grid, with `sampled` the least and the largest; of --given also
    with the one value at which they are held, "pose" with its seven numbers. `angle_unit` is that
    of the arguments of sin, cos and tan. Raises InputError.
    """
    is_given, sample = option == "given", "NAME=LOW:HIGH"
    forms = sample + " or NAME=VALUE" * is_given if sampled else _FORMS
    allowed = f"with --random allowed: {forms}"
    if not sampled:
        allowed = f"allowed: {forms} (with --random: {sample})"
    found: dict[str, float | list[float] | np.ndarray] = {}
    wrong = f"is not of the form {forms}"
    for name, parts in pieces_from(text, option, wrong, whole_pose=is_given).items():
        texts = parts[0].split(":")
        held = is_given and (len(parts) > 1 or len(texts) == 1)
        if not held and len(texts) not in ((2,) if sampled else (1, 3)):
            raise InputError(f"--{option}: {name} = {parts[0]!r}; {allowed}")
        numbers = [
            _finite(name, part, option, angle_unit) for part in (parts if held else texts[:2])
        ]
        if held:
            found[name] = numbers if len(numbers) > 1 else numbers[0]
        elif numbers[-1] < numbers[0]:
            raise InputError(
                f"--{option}: {name} = {texts[0]}:{texts[1]} is reversed; the lower bound comes "
                f"first"
            )
        else:
            count = len(numbers) if len(texts) < 3 else _count(name, texts, numbers, option)
            found[name] = np.linspace(numbers[0], numbers[-1], count)
    return found


def _finite(name: str, text: str, option: str, angle_unit: str) -> float:
    found = number(text, name, option, angle_unit)
    if not np.isfinite(found):
        raise InputError(f"--{option}: {text.strip()!r} of {name} is not finite")
    return found


def _count(name: str, texts: list[str], ends: list[float], option: str) -> int:
    """How many values a range has."""
    count = whole(texts[2])
    if count is None:
        raise InputError(
            f"--{option}: the count {texts[2].strip()!r} of {name} is not a whole number"
        )
    if not 1 <= count <= _MOST_VALUES:
        raise InputError(f"--{option}: {name} has {count} values; allowed: 1 to {_MOST_VALUES}")
    if (count == 1) != (ends[0] == ends[1]):
        raise InputError(
            f"--{option}: {name} = {':'.join(texts)}: one value has equal ends, several have "
            f"different ones"
        )
    return count
