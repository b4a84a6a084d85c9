"""Numbers that users write at the border: plain, or arithmetic as in mechanism files."""

from __future__ import annotations

import re

from symkin.errors import InputError, MechanismError
from symkin.model.arithmetic import evaluate

_TRIGONOMETRY = re.compile(r"\b(sin|cos|tan)\b")


def written_number(text: str, angle_unit: str | None = None) -> float:
    """The value of "12.5" or "2*pi/3"; sin, cos and tan take their argument in `angle_unit`, and are refused where that is not
    known. NaN and infinities pass. Raises InputError, whose sentence begins with the text."""
    try:
        return float(text)
    except ValueError:
        pass
    if angle_unit is None and _TRIGONOMETRY.search(text):
        raise InputError(f"{text.strip()!r} is not a number; sin, cos and tan are not allowed here, where no angle unit is known")
    try:
        return evaluate(text.strip(), angle_unit or "rad")
    except MechanismError as error:
        raise InputError(str(error).replace("is no arithmetic", "is not a number")) from None
