"""What every result of symkin offers: its table as text, a short one as its repr, HTML for
notebooks, a dictionary, a picture.

A result type inherits `Result` and writes two methods, `summary` and `to_dict`. Pictures are drawn
by `symkin.plots`, which imports the results; so that no result imports it in turn,
`symkin/__init__.py` hands its drawing function down by `draw_with`, and the function that makes
pages, of `symkin.page`, by `view_with`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.text import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST_REPR = 2500
"""Characters of a result's repr at most: a screen of a terminal."""
_REPR_ROWS = (10, 5, 2, 0)
"""Rows of the table in a repr; the first that is short enough is taken."""
TERMINAL_WIDTH = 80
"""Columns of characters that a table takes at most."""
_HTML_ROWS = 40
"""Rows of the table in a notebook."""


@dataclass(frozen=True)
class Summary:
    """A result in short: sentences, a table (`rows` below `header`, one text a cell), and sentences
    below it.
    """

    above: Sequence[str] = ()
    header: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    below: Sequence[str] = ()

    def text(self) -> str:
        """For a terminal: columns flush right, two spaces between them, in blocks where they are
        wider than a terminal.
        """
        table = folded([self.header, *self.rows]) if self.rows else []
        return "\n".join([*self.above, *table, *self.below])

    def html(self) -> str:
        """For a notebook: tables only, no script and no style sheet. Without rows each sentence is
        one, its name apart.
        """
        if not self.rows:
            pairs = [line.strip().split(": ", 1) for line in (*self.above, *self.below)]
            return _html_table([], [[name, *rest] if rest else ["", name] for name, *rest in pairs])
        above, below = (
            "".join(f"<p>{_escaped(line)}</p>" for line in lines)
            for lines in (self.above, self.below)
        )
        return above + _html_table(self.header, self.rows) + below


class Result:
    """What every verb returns: `print(result)` writes its table, `repr(result)` a short one, and a
    notebook shows it as HTML.
    """

    def __post_init__(self) -> None:
        """Keep each note once, where it is said first: several steps of a verb may have the same to
        say.
        """
        notes = self.__dict__.get("notes")
        if isinstance(notes, tuple):
            object.__setattr__(self, "notes", tuple(dict.fromkeys(notes)))

    def summary(self, most_rows: int | None = None) -> Summary:
        """The result's sentences and table, of at most `most_rows` rows (None: as many as the
        command prints).
        """
        raise NotImplementedError(f"{type(self).__name__}.summary")

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the command line: numbers, texts, lists and dictionaries only."""
        raise NotImplementedError(f"{type(self).__name__}.to_dict")

    def plot(self, path: Path | str | None = None, **options: Any) -> Figure:
        """Draw the result; with `path` also write the picture to a file whose suffix is its format
        (.png, .svg, .pdf).

        `options` are those of the result's picture (docs/reference/pictures.md). Raises InputError
        for a file that cannot be written, and where there is nothing to draw.
        """
        return _draw(self, path, **options)

    def view(self, **options: Any) -> Any:
        """The page on which the result moves: `.save("robot.html")` writes it, `.open()` shows it
        in the browser, a notebook shows it in place. `options` are those of the result's page
        (`symkin.view`). Raises InputError where there is no configuration to show.
        """
        return _view(self, **options)

    def __str__(self) -> str:
        return self.summary().text()

    def __repr__(self) -> str:
        texts = (self.summary(rows).text() for rows in _REPR_ROWS)
        text = ""
        for text in texts:
            if len(text) <= LONGEST_REPR:
                return text
        return f"{text[:LONGEST_REPR]}..."

    def _repr_html_(self) -> str:
        return self.summary(_HTML_ROWS).html()


def json_fields(owner: object, *names: str) -> dict[str, Any]:
    """Attributes by name, as JSON has them."""
    return {name: json_value(getattr(owner, name)) for name in names}


def json_value(value: Any) -> Any:
    """Lists for arrays and tuples, dictionaries for what has some."""
    if isinstance(value, tuple):
        return [json_value(one) for one in value]
    turned = getattr(value, "to_dict", None) or getattr(value, "tolist", None)
    return value if turned is None else turned()


def draw_with(function: Callable[..., Figure]) -> None:
    """Name the function that draws results: `function(result, path, **options)`."""
    global _draw
    _draw = function


def _draw(result: Result, path: Path | str | None, **options: Any) -> Figure:
    raise NotImplementedError("no drawing function is set; `import symkin` sets one")


def view_with(function: Callable[..., Any]) -> None:
    """Name the function that makes pages of results: `function(result, **options)`."""
    global _view
    _view = function


def _view(result: Result, **options: Any) -> Any:
    raise NotImplementedError("no function that makes pages is set; `import symkin` sets one")


def folded(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table: those of `aligned`; where they are wider than a terminal, with one space
    between columns, and in blocks of columns, one below the other, each with the first column.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    if sum(widths) + 2 * (len(widths) - 1) <= TERMINAL_WIDTH:
        return aligned(rows)
    blocks: list[list[int]] = [[0]]
    for k in range(1, len(widths)):
        if (
            sum(widths[i] + 1 for i in blocks[-1]) + widths[k] > TERMINAL_WIDTH
            and len(blocks[-1]) > 1
        ):
            blocks.append([0])
        blocks[-1].append(k)
    lines = [aligned([[row[k] for k in block] for row in rows], " ") for block in blocks]
    return [line for k, block in enumerate(lines) for line in ([""] * (k > 0) + block)]


def aligned(rows: Sequence[Sequence[str]], gap: str = "  ") -> list[str]:
    """Lines of a table: cells flush right, as wide as the widest of their column."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        gap.join(text.rjust(width) for text, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _html_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{_escaped(name)}</th>" for name in header)
    body = "".join(
        "<tr>" + "".join(f"<td>{_escaped(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return (
        f"<table>{f'<thead><tr>{head}</tr></thead>' if head else ''}<tbody>{body}</tbody></table>"
    )


def _escaped(text: str) -> str:
    return escape(printable(text))
