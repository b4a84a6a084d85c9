"""Numbers that users write at the border: plain, or arithmetic as in mechanism files."""

from __future__ import annotations

from symkin.errors import InputError, MechanismError
from symkin.model.arithmetic import evaluate


def written_number(text: str, angle_unit: str) -> float:
    """The value of "12.5" or "2*pi/3"; sin, cos and tan take their argument in `angle_unit`. NaN and infinities pass. Raises
    InputError, whose sentence begins with the text."""
    try:
        return float(text)
    except ValueError:
        pass
    try:
        return evaluate(text.strip(), angle_unit)
    except MechanismError as error:
        raise InputError(str(error).replace("is no arithmetic", "is not a number")) from None
