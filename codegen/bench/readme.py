"""Tables that scripts print, and write into codegen/README.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

README = Path(__file__).parent.parent / "README.md"


def table(rows: Sequence[Mapping[str, str]]) -> str:
    """Rows by the heads of their columns; columns of which no row says anything are left out."""
    heads = [head for head in rows[0] if any(row[head] for row in rows)] if rows else []
    lines = [[row[head] for head in heads] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in (heads, ["---"] * len(heads), *lines))


def told(mark: str) -> str:
    """The text between <!-- mark --> and <!-- end mark -->."""
    return README.read_text().partition(f"<!-- {mark} -->\n")[2].partition(f"<!-- end {mark}")[0]


def written(mark: str, text: str) -> None:
    """Puts text between the marks."""
    before, marks = README.read_text(), (f"<!-- {mark} -->\n", f"\n<!-- end {mark} -->")
    if not all(words in before for words in marks):
        raise ValueError(f"{README}: the marks of {mark!r} are missing")
    head, rest = before.split(marks[0])
    README.write_text(head + marks[0] + text + marks[1] + rest.split(marks[1])[1])
