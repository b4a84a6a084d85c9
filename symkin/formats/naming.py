"""Change the names of other formats as little as possible into names that mechanisms may have, each
of them unique.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from pathlib import Path

from symkin.model.names import LONGEST_NAME, identifier, is_device, name_fault
from symkin.text import first_of, shown

_CUT = LONGEST_NAME - 10
"""Characters kept of a name that is too long: there is room for a number."""


def allowed_names(names: Iterable[str], taken: Collection[str] = ()) -> dict[str, str]:
    """A name for each name: itself where it is allowed and not `taken`, else one near it.

    >>> allowed_names(["knee", "toe@left", "base"], taken=["base"])
    {'knee': 'knee', 'toe@left': 'toe_left', 'base': 'base_2'}
    """
    wanted = list(dict.fromkeys(names))
    free = [name for name in wanted if name_fault(name) is None and name not in taken]
    used = {*taken, *free}
    found = {name: name for name in free}
    for name in wanted:
        if name not in found:
            found[name] = fresh_name(_near(name), used)
    return {name: found[name] for name in wanted}


def renamed(what: str, names: dict[str, str]) -> tuple[str, ...]:
    """A note on the names that were changed; none where none was."""
    changed = [f"{shown(old)} is {new!r}" for old, new in names.items() if old != new]
    return (
        (f"names of {what} were changed to allowed ones: {first_of(changed)}",) if changed else ()
    )


def robot_name(written: str | None, path: Path) -> str:
    """The name that mechanisms ask for, an identifier of C, from that in the file or the file's
    own.
    """
    name = identifier((written or "").strip() or path.stem)[:_CUT].strip("_")
    return f"{name}_robot" if is_device(name) else name


def _near(name: str) -> str:
    """The name with _ for each character that is not allowed."""
    text = name.strip()[:_CUT] or "unnamed"
    text = "".join(c if name_fault(f"a{c}a") is None else "_" for c in text).rstrip(" ")
    return text if name_fault(text) is None else f"_{text}"


def fresh_name(name: str, taken: set[str]) -> str:
    """A name near this one that nothing has, which is then taken."""
    number, found = 2, name
    while found in taken:
        found, number = f"{name}_{number}", number + 1
    taken.add(found)
    return found
