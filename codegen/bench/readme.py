"""Tables that scripts write into codegen/README.md."""

from __future__ import annotations

from pathlib import Path

README = Path(__file__).parent.parent / "README.md"


def written(mark: str, text: str) -> None:
    """Puts text between <!-- mark --> and <!-- end mark -->."""
    head, begin, rest = README.read_text().partition(f"<!-- {mark} -->\n")
    _, end, tail = rest.partition(f"<!-- end {mark} -->")
    if not begin or not end:
        raise ValueError(f"{README}: the marks of {mark!r} are missing")
    README.write_text(f"{head}{begin}{text}\n{end}{tail}")
