"""The page of the papers: how many lines each study prints, and what became of them."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

LEAD = """# The papers, checked

Five papers were worked through line by line. A study computes what the paper prints and compares
the two. It writes the table that stands on the paper's page, so that every line there comes from a
program that you can run. Lines without a verdict have nothing printed beside them.

**reproduced** means that the numbers agree to the paper's digits. **differs** means that they do
not. **refuted** means that a statement of the paper is wrong, and the line shows why. **outside**
means that the claim is about something symkin does not compute.

| paper | lines | reproduced | differs | refuted | outside |
|---|---|---|---|---|---|
"""
TREE = """
```{toctree}
:maxdepth: 1
:hidden:

"""
VERDICTS = ("reproduced", "differs", "refuted", "outside")


def papers_page(folder: Path) -> str:
    """The counts of all tables in a folder, read from the tables, with links from `generated/`."""
    pages = sorted(folder.glob("*.md"))
    return (
        LEAD
        + "".join(map(_row, pages))
        + TREE
        + "".join(f"../papers/{page.stem}\n" for page in pages)
        + "```\n"
    )


def _row(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    title = text.splitlines()[0].removeprefix("# ")
    counts = verdicts(text)
    told = " | ".join(str(counts[verdict]) for verdict in VERDICTS)
    return f"| [{title}](../papers/{page.name}) | {counts.total()} | {told} |\n"


def verdicts(text: str) -> Counter[str]:
    """Verdicts of a table's rows: the last cell of each."""
    table = [line for line in text.splitlines() if line.startswith("| ")]
    cells = [
        re.split(r"(?<!\\)\|", line.strip().strip("|"))[-1].strip()
        for line in table
        if not line.startswith("| item ")
    ]
    return Counter(cells)
