"""What may be chosen of a picture of configurations: which names it has, from which sides it is
seen, which modes it shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, cast, get_args

from symkin.drawing.camera import ViewName
from symkin.drawing.layout import layout_of
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.model.written_number import whole
from symkin.text import counted, not_among, shown

Names = Literal["all", "joints", "links", "loops", "none"]
"""What is named: all that is drawn, joints, links with base and platform, only the joints that
close loops of a graph, or nothing.
"""
MOST_PANELS = 200
"""Panels of one picture at most."""


def names_from(text: str, mechanism: Mechanism | None) -> Names:
    """The names of a picture. Raises InputError for another word, and for loops where no joint of a
    mechanism that is known closes one.
    """
    if text not in get_args(Names):
        raise InputError(f"--names: {not_among(text, get_args(Names))}")
    if text == "loops" and mechanism is not None and not layout_of(mechanism).closing:
        limbs = f"{mechanism.name} has {'limbs' if mechanism.limbs else 'no loops'}"
        raise InputError(
            f"--names loops: {limbs}; joints that close loops are those between links of a graph"
        )
    return cast(Names, text)


def views_from(views: str | Sequence[str]) -> tuple[ViewName, ...]:
    """The views of a picture from their names, or from names separated by commas. Raises
    InputError.
    """
    found = [part.strip() for part in views.split(",")] if isinstance(views, str) else list(views)
    wrong = next((name for name in found if name not in get_args(ViewName)), None)
    if wrong is not None or not found:
        raise InputError(
            f"--views: {shown(wrong or '')} is no view; allowed, separated by commas: "
            f"{', '.join(get_args(ViewName))}"
        )
    if len(set(found)) < len(found):
        raise InputError(f"--views {','.join(found)}: a view stands twice")
    return cast(tuple[ViewName, ...], tuple(found))


def looks_of(mechanism: Mechanism, names: str, views: str | Sequence[str]) -> dict[str, Any]:
    """Names and views as figures of configurations take them, checked."""
    return {"names": names_from(names, mechanism), "views": views_from(views)}


def check_numbers(text: str) -> list[tuple[int, int | None]]:
    """First and last of each part of `1-16,20` (the last is None where it is one number). Raises
    InputError for anything else.
    """
    parts = []
    for part in text.split(","):
        first, dash, last = (piece.strip() for piece in part.partition("-"))
        low, high = whole(first), whole(last) if dash else None
        if low is None or low < 1 or (dash and (high is None or high < low)):
            raise InputError(
                f"--modes: {shown(part.strip())} is no choice of modes; numbers from 1 and ranges, "
                f"such as 1-16 or 1,3, or all"
            )
        parts.append((low, high))
    return parts


def chosen_numbers(choice: str | Sequence[int], count: int) -> list[int]:
    """Numbers of modes from `all`, `1-16,20` or a list, without repetition and rising: of a range
    those of the `count` that are there. Raises InputError for a number, or a whole choice, that is
    not there.
    """
    if isinstance(choice, str) and choice.strip() == "all":
        choice = f"1-{count}"
    parts = check_numbers(choice if isinstance(choice, str) else ",".join(map(str, choice)))
    there = f"there {'is' if count == 1 else 'are'} {counted(count, 'mode')}"
    alone = next((low for low, high in parts if high is None and low > count), None)
    if alone is not None:
        raise InputError(f"--modes: there is no mode {alone}; {there}")
    found = sorted({k for low, high in parts for k in range(low, min(high or low, count) + 1)})
    if not found:
        raise InputError(f"--modes {choice}: none of these is there; {there}")
    if len(found) > MOST_PANELS:
        raise InputError(
            f"--modes: {len(found)} modes are more than one picture takes; choose {MOST_PANELS} at "
            f"most, such as 1-{MOST_PANELS}"
        )
    return found


def ranges_text(numbers: Sequence[int]) -> str:
    """Rising numbers in short: 1-3, 7."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)
