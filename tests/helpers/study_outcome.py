"""What a study prints and writes, read back, and the laws that every study of a paper obeys."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

STUDIES = Path(__file__).resolve().parents[2] / "studies"
sys.path.append(str(STUDIES.parent))

from studies import SCRIPTS  # noqa: E402

DOCS = STUDIES.parent / "docs" / "papers"
VERDICTS = {"reproduced", "differs", "refuted", "outside", "-"}


def command(name: str, folder: Path, *options: str) -> list[str]:
    """The command that runs a study, with warnings as errors."""
    return [
        sys.executable,
        "-W",
        "error",
        str(STUDIES / SCRIPTS[name]),
        "-o",
        str(folder),
        *options,
    ]


class Outcome:
    """One run of a study's file with warnings as errors: its output, pictures and rows."""

    def __init__(self, name: str, folder: Path, *options: str) -> None:
        self.run = subprocess.run(
            command(name, folder, *options),
            capture_output=True,
            text=True,
            timeout=900,
            check=False,
        )
        self.name, self.folder = name, folder
        self.picture = folder / f"{name}.png"
        self.content = (
            json.loads((folder / f"{name}.json").read_text()) if self.run.returncode == 0 else {}
        )

    def rows(self, beginning: str) -> list[dict]:
        found = [row for row in self.content["rows"] if row["quantity"].startswith(beginning)]
        assert found, f"no row begins with {beginning!r}"
        return found

    def number(self, beginning: str) -> np.ndarray:
        """`computed` of the only row that begins so."""
        (row,) = self.rows(beginning)
        return np.array(row["computed"])


def assert_complete(outcome: Outcome, errata: list[str]) -> None:
    """Exit 0, pictures, and every erratum in the JSON and in print, in order."""
    assert outcome.run.returncode == 0, outcome.run.stderr
    assert outcome.picture.read_bytes()[:4] == b"\x89PNG"
    assert len(outcome.content["errata"]) == len(errata)
    assert outcome.run.stdout.count("Erratum, shown by computation") == len(errata)
    for text, part in zip(outcome.content["errata"], errata, strict=True):
        assert part in text


def assert_rows_quote_runs(outcome: Outcome) -> None:
    """Every row has a verdict and what was run; a row that speaks of multistart, starts or
    continuation quotes a result whose own method says so, with as many starts; only items outside
    have no run, and they give a reason.
    """
    for row in outcome.content["rows"]:
        words, runs = row["quantity"].lower(), row["run"]
        assert row["verdict"] in VERDICTS, row
        assert runs or row["verdict"] == "outside", f"nothing was run for {row['quantity']!r}"
        assert row["verdict"] != "outside" or isinstance(row["computed"], str), row
        methods = [str(entry["method"]) for entry in runs if entry["by"] == "symkin.modes"]
        if "multistart" in words:
            assert any(method.startswith("multistart") for method in methods), row
            assert all(
                entry["starts"] for entry in runs if str(entry["method"]).startswith("multistart")
            ), row
        if "continuation" in words:
            assert "continuation" in methods, row


def assert_docs_show(outcome: Outcome) -> None:
    """docs/papers/NAME.md has the study's items, places, runs and verdicts, row by row; numbers may
    differ in last digits.
    """
    page = (DOCS / f"{outcome.name}.md").read_text().splitlines()
    written = (outcome.folder / f"{outcome.name}.md").read_text().splitlines()
    assert [_frame(line) for line in page] == [_frame(line) for line in written]


def _frame(line: str) -> str:
    """A row without its computed value."""
    cells = line.replace("\\|", "/").split("|")
    return "|".join([*cells[:5], *cells[6:]]) if len(cells) > 6 else line
