"""The gallery: a card and a page for each shipped mechanism, and the list of studies, from their
files.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import symkin

INDEX = """# Gallery

Every mechanism that symkin ships, as a kinematic sketch at its reference. Give its name to any
command, such as `symkin modes ankle`. Each page has the counts that symkin finds, the literature,
and a page that moves.

"""
STUDIES = """
## Studies

A study answers one question with the library and prints its table. `python studies/FILE` runs it.

| study | what it does |
|---|---|
"""


@dataclass(frozen=True)
class Card:
    """What the index tells of a mechanism."""

    name: str
    title: str
    counts: str


def write_gallery(folder: Path, studies: Path, names: Sequence[str], moving: bool) -> None:
    """Write `index.md`, and a page, a sketch and (where it is wanted) a page that moves for each
    mechanism.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        cards = list(
            pool.map(_write_mechanism, names, [folder] * len(names), [moving] * len(names))
        )
    tree = "\n```{toctree}\n:hidden:\n\n" + "".join(f"{card.name}\n" for card in cards) + "```\n"
    grid = "::::{grid} 1 2 2 3\n:gutter: 3\n\n" + "".join(map(_card, cards)) + "::::\n"
    (folder / "index.md").write_text(
        INDEX + grid + STUDIES + "".join(_studies(studies)) + tree, encoding="utf-8"
    )


def _card(card: Card) -> str:
    return (
        f":::{{grid-item-card}} {card.title}\n:link: {card.name}\n:link-type: doc\n"
        f":img-top: {card.name}.png\n"
        f":img-alt: sketch of {card.name}\n\n`{card.name}`: {card.counts}\n:::\n\n"
    )


def _write_mechanism(name: str, folder: Path, moving: bool) -> Card:
    mechanism = symkin.load(name)
    account = symkin.mobility(mechanism)
    account.plot(folder / f"{name}.png")
    modes, asked = _modes(mechanism)
    card = Card(
        name,
        mechanism.title or name,
        f"mobility {account.mobility}, {_number(len(modes), 'mode')} {asked}",
    )
    page = [
        f"# {card.title}\n",
        f"`{name}`, {card.counts}.\n",
        f"![sketch of {name}]({name}.png)\n",
        _moving_link(name, folder) if moving else "",
        "## Account\n",
        f"```text\n{account}\n```\n",
        "## Modes\n",
        f"```text\n{modes}\n```\n",
        "## Literature\n",
        f"{mechanism.source or 'The file names no source.'}\n",
    ]
    (folder / f"{name}.md").write_text("\n".join(page), encoding="utf-8")
    return card


def _modes(mechanism: symkin.Mechanism) -> tuple[symkin.Modes, str]:
    """Modes of the example; of arms those of the pose that their example leads to, which is the
    question with several answers.
    """
    found = symkin.modes(mechanism)
    if mechanism.serial and found.method == "forward":
        return symkin.modes(mechanism, pose=found[0].pose), "at a pose"
    return found, "at its example"


def _number(count: int, thing: str) -> str:
    return f"{count} {thing}" + ("" if count == 1 else "s")


def _moving_link(name: str, folder: Path) -> str:
    """Write the page that moves, and a link to it; Sphinx copies what stands in
    `html_extra_path`.
    """
    pages = folder.parent / "extra" / "moving"
    pages.mkdir(parents=True, exist_ok=True)
    _view(name, pages / f"{name}.html")
    return f'<a class="moving" href="../../moving/{name}.html">Move it in the browser</a>\n'


def _view(name: str, path: Path) -> None:
    from symkin.page.view import view_mechanism

    view_mechanism(symkin.load(name), None, None, None).save(path)


def _studies(folder: Path) -> list[str]:
    """List the studies that can be run: file and the first line of what it says."""
    files = sorted(
        path
        for path in folder.rglob("*.py")
        if 'if __name__ == "__main__"' in path.read_text(encoding="utf-8")
    )
    said = (
        (
            path.relative_to(folder),
            ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "",
        )
        for path in files
    )
    return [f"| `{name}` | {text.splitlines()[0]} |\n" for name, text in said]
