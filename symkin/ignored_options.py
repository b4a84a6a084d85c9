"""Refuse options that a call would ignore: what is given must be read, or the answer is not the one
that was asked for.
"""

from __future__ import annotations

from collections.abc import Mapping

from symkin.errors import InputError


def refuse_ignored(options: Mapping[str, object], reason: str, instead: str = "") -> None:
    """Raise InputError for the options, by name, that are given (neither None nor False) although
    `reason` is that nothing reads them; `instead` is what to do in place of leaving them out.
    """
    names = [name for name, value in options.items() if value is not None and value is not False]
    if not names:
        return
    several = len(names) > 1
    listed = f"{', '.join(names[:-1])} and {names[-1]}" if several else names[0]
    remedy = f"leave {'them' if several else 'it'} out" + (f", or {instead}" if instead else "")
    raise InputError(
        f"{listed} {'are' if several else 'is'} given and would be ignored: {reason}; {remedy}"
    )
