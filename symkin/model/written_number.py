"""Read numbers that users write: plain, or arithmetic as in mechanism files."""

from __future__ import annotations

import re

from symkin.errors import InputError, MechanismError
from symkin.model.arithmetic import evaluate, plain_number

_NOT_FINITE = re.compile(r"[-+]?(?:inf|infinity|nan)", re.IGNORECASE)


def written_number(text: str, angle_unit: str) -> float:
    """The value of "12.5" or "2*pi/3"; sin, cos and tan take their argument in `angle_unit`. NaN
    and infinities pass, to be refused with their place. Raises InputError, whose sentence begins
    with the text.
    """
    plain = text.strip()
    if _NOT_FINITE.fullmatch(plain):
        return float(plain)
    number = plain_number(plain)
    if number is not None:
        return number
    try:
        return evaluate(plain, angle_unit)
    except MechanismError as error:
        raise InputError(str(error).replace("is no arithmetic", "is not a number")) from None


def whole(text: str) -> int | None:
    """The value of a whole number with or without a sign, in ASCII digits; None for any other
    text.
    """
    return int(text) if re.fullmatch(r"[ \t]*[-+]?[0-9]{1,100}[ \t]*", text) else None
