"""Tables that scripts print, and write into codegen/README.md."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

README = Path(__file__).parent.parent / "README.md"


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Rows of cells under the heads of their columns."""
    lines = (heads, ["---"] * len(heads), *rows)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


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
