"""The code in documents: blocks by language, and commands with the output that stands below them."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
_ANY = "..."
"""Stands for any text of a line, or as a line of its own for any lines."""


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
    """The commands of each `console` block; a prompt `$ ` begins one, all until the next is its output."""
    found = []
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
    return re.findall(r"^```python\n((?:(?!```)[^\n]*\n)*)^```\n\n```output\n(.*?)^```$", text, re.M | re.S)


def is_as_printed(told: str, output: str) -> bool:
    """Whether an output is the one told, in which ... stands for any text, and spaces at ends of lines do not count."""
    pattern = "".join(
        "(?:.*\n)*" if line.strip() == _ANY else re.escape(line.rstrip()).replace(re.escape(_ANY), ".*") + "\n"
        for line in told.strip().splitlines()
    )
    return re.fullmatch(pattern, "".join(line.rstrip() + "\n" for line in output.strip().splitlines())) is not None


def _command(part: str) -> Command:
    first, _, output = part.partition("\n")
    return Command(tuple(shlex.split(first, comments=True)), output)
