"""`symkin list`: apart from the other commands, so that it starts without what these need."""

from __future__ import annotations

from textwrap import shorten

from symkin.model.shipped import shipped_names, shipped_title
from symkin.result import TERMINAL_WIDTH


def list_() -> None:
    """List the shipped mechanisms."""
    names = shipped_names()
    width = max(map(len, names))
    for name in names:
        title = shorten(shipped_title(name), TERMINAL_WIDTH - width - 2, placeholder=" ...")
        print(f"{name:{width}}  {title}")
