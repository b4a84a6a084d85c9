"""The code in documents: blocks by language, and commands with the output that stands below
them.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
_INSTALLED = re.compile(
    r"^```sh\n[^\n]*\.venv/bin/(symkin [^\n]*\n)```\n\n```text\n(.*?)^```$", re.M | re.S
)
"""The last command of a `sh` block that runs symkin from a new environment, and the `text` block
right below it.
"""
_ANY = "..."
"""Stands for any text of a line, or as a line of its own for any lines."""
_ROUNDING = r"\d(?:\.\d+)?e-(?:09|[1-9]\d)\b"
"""A figure of the size of rounding, which another processor may print otherwise."""


@dataclass(frozen=True)
class Command:
    """A command of a document, as words, and the output printed below it."""

    words: tuple[str, ...]
    output: str

    def __str__(self) -> str:
        return " ".join(self.words)


def blocks(document: str, language: str) -> list[str]:
    """The blocks of a language in a document, by its path in the repository."""
    text = (ROOT / document).read_text(encoding="utf-8")
    return [body for kind, body in _BLOCK.findall(text) if kind == language]


def sessions(document: str) -> list[list[Command]]:
    """The commands of each `console` block; a prompt `$ ` begins one, all until the next is its
    output.

    Also those of `sh` blocks whose output stands in a `text` block right below.
    """
    text = (ROOT / document).read_text(encoding="utf-8")
    found = [[_command(command + output)] for command, output in _INSTALLED.findall(text)]
    for block in blocks(document, "console"):
        parts = re.split(r"^\$ ", block, flags=re.M)
        found.append([_command(part) for part in parts[1:]])
    return found


def machines(document: str) -> dict[str, str]:
    """The TOML blocks that begin with a comment of their file's name, by that name."""
    named = ((re.match(r"# (\w+\.toml)\n", text), text) for text in blocks(document, "toml"))
    return {name[1]: text for name, text in named if name}


def shown_outputs(document: str) -> list[tuple[str, str]]:
    """Python blocks with an `output` block right below them."""
    text = (ROOT / document).read_text(encoding="utf-8")
    return re.findall(
        r"^```python\n((?:(?!```)[^\n]*\n)*)^```\n\n```output\n(.*?)^```$", text, re.M | re.S
    )


def is_as_printed(told: str, output: str) -> bool:
    """Whether an output is the one told, in which ... stands for any text and spaces at ends of
    lines do not count.

    A figure of the size of rounding stands for any such figure.
    """
    pattern = "".join(_pattern(line.rstrip()) for line in told.strip().splitlines())
    return (
        re.fullmatch(pattern, "".join(line.rstrip() + "\n" for line in output.strip().splitlines()))
        is not None
    )


def _pattern(line: str) -> str:
    """The regular expression of a line of an output."""
    if line.strip() == _ANY:
        return "(?:.*\n)*"
    parts = re.split(rf"({re.escape(_ANY)}|{_ROUNDING})", line)
    parts[::2] = [re.escape(part) for part in parts[::2]]
    parts[1::2] = [".*" if part == _ANY else _ROUNDING for part in parts[1::2]]
    return "".join(parts) + "\n"


def _command(part: str) -> Command:
    first, _, output = part.partition("\n")
    return Command(tuple(shlex.split(first, comments=True)), output)
