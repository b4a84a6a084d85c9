"""Text that others wrote (files, arguments) on its way into messages and outputs: what is refused,
shortened and escaped.

Each output has its own escapes here, so that text stays text in it: no end of a comment, no markup,
no mathematics, no command of a terminal.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches

_DIRECTIONS = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
"""Bidirectional classes of characters that reorder the text after them (Unicode, annex 9)."""
_MARKS = "\u061c\u200e\u200f"
"""Direction marks, which belong to ordinary classes."""
_LONGEST_VALUE = 60
"""Characters of a value that a message shows."""
_LONGEST_NUMBER = 1000
"""Bits of a whole number that a message shows; Python refuses to write those of more than 4300
digits.
"""
_LONGEST_WORD = 600
"""Characters of a quoted value or a word in a message: enough for paths of files."""
_LONGEST_MESSAGE = 2000
"""Characters of a message; lists of a file's columns are the longest ones."""


def refused_character(text: str) -> str | None:
    """The first character that no text may hold: control and bidirectional ones, line separators,
    surrogates and what is none.
    """
    if text.isascii() and text.isprintable():  # nearly all are
        return None
    return next((c for c in text if _is_refused(c)), None)


def _is_refused(c: str) -> bool:
    if c.isascii():
        return c < " " or c == "\x7f"
    if (
        unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp")
        or c in _MARKS
        or unicodedata.bidirectional(c) in _DIRECTIONS
    ):
        return True
    return 0xFDD0 <= ord(c) <= 0xFDEF or ord(c) & 0xFFFE == 0xFFFE


def one_line(text: str) -> str:
    """Text with its line breaks and tabs as spaces."""
    return re.sub(r"[ \t]*[\r\n]+[ \t]*", " ", text).replace("\t", " ").strip(" ")


def code_point(c: str) -> str:
    """A character by its number: U+202E."""
    return f"U+{ord(c):04X}"


def printable(text: str) -> str:
    """Text for a terminal or a report: refused characters as escapes."""
    return "".join(_escaped(c) if _is_refused(c) else c for c in text)


def _escaped(c: str) -> str:
    return (
        f"\\x{ord(c):02x}"
        if ord(c) < 256
        else f"\\u{ord(c):04x}"
        if ord(c) < 65536
        else f"\\U{ord(c):08x}"
    )


# --- messages -------------------------------------------------------------------------------------


def shown(value: object) -> str:
    """A value in a message, not longer than a line has room for."""
    text = _beginning(value)
    if len(text) <= _LONGEST_VALUE:
        return text
    return (
        text[: _LONGEST_VALUE - 3]
        + "..."
        + (f" ({len(value)} characters)" if isinstance(value, str) else "")
    )


def _beginning(value: object) -> str:
    """The first characters of a value's repr, of no more than a message shows: lists may hold each
    other, numbers be endless.
    """
    text = ""
    for piece in _pieces(value):
        text += piece
        if len(text) > _LONGEST_VALUE:
            break
    return text


def _pieces(value: object) -> Iterator[str]:
    """The repr of a value, piece by piece from its beginning."""
    if isinstance(value, str):
        yield repr(value[: 2 * _LONGEST_VALUE])
    elif isinstance(value, int) and value.bit_length() > _LONGEST_NUMBER:
        yield f"a whole number of {value.bit_length()} bits"
    elif isinstance(value, float):
        yield float.__repr__(value)  # NumPy's own names its type
    elif isinstance(value, list | tuple):
        yield "[" if isinstance(value, list) else "("
        for k, item in enumerate(value):
            yield from ((", ",) if k else ())
            yield from _pieces(item)
        yield "]" if isinstance(value, list) else ",)" if len(value) == 1 else ")"
    elif isinstance(value, dict):
        yield "{"
        for k, (key, item) in enumerate(value.items()):
            yield from ((", ",) if k else ())
            yield from _pieces(key)
            yield ": "
            yield from _pieces(item)
        yield "}"
    else:
        yield repr(value)


def shortened(message: str) -> str:
    """A message whose quoted values and words are cut, and which is cut in its middle where it is
    still too long.
    """
    quoted = rf"'(?:[^'\\]|\\.){{{_LONGEST_WORD},}}?'|\S{{{_LONGEST_WORD},}}"
    text = (
        re.sub(quoted, lambda found: _cut(found[0], _LONGEST_WORD // 6), message)
        if len(message) > _LONGEST_WORD
        else message
    )
    return text if len(text) <= _LONGEST_MESSAGE else _cut(text, _LONGEST_MESSAGE // 2)


def _cut(text: str, kept: int) -> str:
    """Both ends of a text."""
    return f"{text[:kept]}...{text[-kept // 4 :]}"


def first_of(items: Sequence[str], count: int = 5, comma: str = ", ") -> str:
    """The first few of some names, and how many more there are."""
    more = len(items) - count
    return comma.join(items[:count]) + (f" and {more} more" if more > 0 else "")


LIKENESS = 0.6
"""Share of two names that must agree (difflib's ratio) for one to be taken for the other."""


def nearest(name: object, known: Iterable[object], likeness: float = LIKENESS) -> str | None:
    """The known name that a misspelt one is most like, by its letters, small and capital alike;
    None where none is. Names may be numbers, where a caller in Python has given some.

    >>> nearest("bsae", ["base", "platform"])
    'base'
    """
    by_letters: dict[str, str] = {}
    for each in known:
        by_letters.setdefault(str(each).lower(), str(each))
    found = get_close_matches(str(name).lower(), by_letters, 1, likeness)
    return by_letters[found[0]] if found else None


def not_among(name: object, known: Iterable[object]) -> str:
    """What a message says of a name that is none of the known ones.

    >>> not_among("bsae", ["base", "platform"])
    "'bsae' is unknown (do you mean 'base'?); allowed: base, platform"
    """
    allowed = [str(each) for each in known]
    return (
        f"{shown(name)} is unknown{meant(name, allowed)}; allowed: {', '.join(allowed) or 'none'}"
    )


def meant(name: object, known: Iterable[object], suffix: str = "") -> str:
    """A question for a message that refuses a name: " (do you mean 'base'?)", or nothing where no
    known name is like it; all names have the `suffix` besides.
    """
    found = nearest(name, known)
    return "" if found is None else f" (do you mean {shown(found + suffix)}?)"


def counted(count: int, what: str = "value") -> str:
    """A count with its word: 1 value, 2 values."""
    return f"{count} {what}{'' if count == 1 else 's'}"


# --- numbers --------------------------------------------------------------------------------------

NOTHING = 1e-12
"""Values below this (lengths over the size) are rounding noise, which prints as 0."""


def plain(value: float, size: float = 1.0, least: float = NOTHING) -> float:
    """The value, or 0 without a sign where it is below `least` times the size."""
    return value if abs(value) >= least * size else 0.0


# --- outputs --------------------------------------------------------------------------------------


def c_comment(text: str) -> str:
    """Text within a block comment of C: it neither ends nor begins one, and holds no trigraph and
    no line splice.
    """
    text = text.replace("*/", "* /").replace("/*", "/ *")
    return re.sub(r"\\+$", lambda found: found[0] + ".", re.sub(r"\?(?=\?)", "? ", printable(text)))


def docstring_line(text: str) -> str:
    """A line within a triple-quoted string of Python."""
    return printable(text).replace("\\", "\\\\").replace('"', "'")


def markdown(text: str) -> str:
    """Text in a paragraph, heading, list or table cell of Markdown: no markup, HTML, mathematics or
    links but plain addresses.
    """
    text = re.sub(r"([\\`*\[\]|$~])", r"\\\1", printable(text))
    text = re.sub(r"(?<![^\W_])_|_(?![^\W_])", r"\_", text)
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"^(\s*)([-+#=])|^(\s*\d+)([.)])", r"\1\3\\\2\4", text)


def markdown_code(text: str) -> str:
    """A span of code in Markdown, within more backticks than the text has in a row."""
    text = printable(text)
    ticks = _ticks(text, 1)
    pad = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{ticks}{pad}{text}{pad}{ticks}"


def markdown_block(language: str, text: str) -> list[str]:
    """Lines of a fenced block of code in Markdown."""
    lines = [printable(line) for line in text.split("\n")]
    fence = _ticks(text, 3)
    return [f"{fence}{language}", *lines, fence]


def _ticks(text: str, least: int) -> str:
    return "`" * max(least, 1 + max(map(len, re.findall("`+", text)), default=0))


_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
}


def latex_text(text: str) -> str:
    """Text in LaTeX, in ASCII."""
    return "".join(_LATEX.get(c, c) for c in printable(ascii_letters(text)))


def ascii_letters(text: str) -> str:
    """Text in ASCII: letters without their accents, Greek ones by their names, ? for all others."""
    plain = (c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    return "".join(c if c.isascii() else _greek(c) or "?" for c in plain)


def _greek(c: str) -> str | None:
    """theta for the small letter, Delta for the capital."""
    found = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (FINAL )?([A-Z]+)", unicodedata.name(c, ""))
    if found is None:
        return None
    return found[3].lower() if found[1] == "SMALL" else found[3].capitalize()


def matplotlib_text(text: str) -> str:
    """Text of a picture: no mathematics, and no _ at the beginning, which would keep it out of a
    legend.
    """
    return re.sub("^_", " _", text.replace("$", r"\$"))
