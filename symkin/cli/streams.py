"""Standard streams as commands find them: closed, broken, or of an encoding that cannot hold a
character.
"""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from typing import TextIO

from symkin.text import printable, shortened

_NARROWEST = 40
"""Columns of a terminal below which lines are left as they are."""


def prepare_streams() -> None:
    """Open what the caller has closed onto nothing, so that no file of the command takes its
    number, and write characters that an encoding cannot hold as escapes.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        _open_if_closed(number)
        if getattr(sys, name) is None:
            mode = "r" if number == 0 else "w"
            opened = open(number, mode, encoding="utf-8", closefd=False)  # noqa: SIM115
            setattr(sys, name, opened)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def _open_if_closed(number: int) -> None:
    try:
        os.fstat(number)
    except OSError:
        nothing = os.open(os.devnull, os.O_RDWR)
        if nothing != number:
            os.dup2(nothing, number)
            os.close(nothing)


def say(message: object) -> None:
    """One line on stderr, where there is one to read it; control characters as escapes."""
    try:
        print(
            "symkin: " + printable(shortened(" ".join(str(message).split()))),
            file=sys.stderr,
            flush=True,
        )
    except OSError:
        silence(sys.stderr)


def print_text(text: str) -> None:
    """Text for people: on a terminal, sentences that are longer than its lines go on, indented, on
    the next; a table keeps its lines.
    """
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 0
    print(
        "\n".join(_folded(line, width) for line in text.split("\n"))
        if width >= _NARROWEST
        else text
    )


def _folded(line: str, width: int) -> str:
    if len(line) <= width or "  " in line.strip():
        return line
    return "\n".join(
        textwrap.wrap(
            line, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
        )
    )


def silence(stream: TextIO) -> None:
    """Let nothing more be written where writing has failed, not even at the end of the process."""
    try:
        number = stream.fileno()
    except (OSError, ValueError):
        return
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, number)
    os.close(nothing)
