"""Docstrings, which are plain text, as the site sets them: paragraphs, examples, and formulas in
which columns count.
"""

from __future__ import annotations

import re
from itertools import groupby

_COLUMNS = re.compile(r"\S {3,}\S")
"""Two words far apart: the line belongs to a table."""


def docstring_as_rst(lines: list[str]) -> list[str]:
    """The docstring as reStructuredText. Names in single backticks become literal text; nothing
    else in a paragraph is markup.
    """
    told: list[str] = []
    for part in "\n".join(lines).strip("\n").split("\n\n"):
        block = part.strip("\n").split("\n")
        if block[0].startswith(">>> "):
            told += _literal(block, "pycon")
        elif any(_COLUMNS.search(line) for line in block):
            told += _literal(block)
        else:
            for is_formula, group in groupby(block, lambda line: line.startswith("    ")):
                told += (_literal if is_formula else _paragraph)(list(group))
    return told


def _literal(block: list[str], language: str = "text") -> list[str]:
    return [f".. code-block:: {language}", "", *("   " + line for line in block), ""]


def _paragraph(block: list[str]) -> list[str]:
    return [*map(_plain, block), ""]


def _plain(line: str) -> str:
    words = line.split("`")
    if len(words) % 2 == 0:
        return _escaped(line)
    return "".join(f"\\ ``{word}``\\ " if k % 2 else _escaped(word) for k, word in enumerate(words))


def _escaped(text: str) -> str:
    return re.sub(r"([\\*|_`])", r"\\\1", text)
