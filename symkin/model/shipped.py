"""The mechanisms that come with symkin: their files, names and titles, and examples of commands."""

from __future__ import annotations

import tomllib
from pathlib import Path

from symkin.errors import MechanismError

SHIPPED = Path(__file__).resolve().parent.parent / "mechanisms"


def shipped_names() -> list[str]:
    """Names of the mechanisms that come with symkin, which `load` takes.

    >>> import symkin
    >>> "zhao2000" in symkin.shipped_names()
    True
    """
    if not SHIPPED.is_dir():
        raise MechanismError(
            f"{SHIPPED} is no folder: symkin reads its own files from disk, and runs from no zip "
            f"file"
        )
    return sorted(path.stem for path in SHIPPED.glob("*.toml"))


def shipped_title(name: str) -> str:
    """The title in the file of a shipped mechanism."""
    text = (SHIPPED / f"{name}.toml").read_text(encoding="utf-8")
    return str(tomllib.loads(text).get("title", ""))


def shipped_examples(command: str, *, remarks: bool = False) -> list[str]:
    """The examples of a command as they are typed, or with `remarks` those with a remark beside
    them.
    """
    file = SHIPPED / "examples.txt"
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    return [
        line for line in lines if f"{line} ".startswith(f"{command} ") and ("  " in line) == remarks
    ]
