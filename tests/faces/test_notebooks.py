"""The notebooks of docs/notebooks run from top to bottom, and are stored without outputs."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from traitlets.config import Config

from helpers.gate import in_gate

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


def read(path):
    return nbformat.read(path, as_version=4)


def test_there_are_three():
    assert [path.stem for path in NOTEBOOKS] == ["calibration", "modes", "path"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_only_sources_are_stored(path):
    """No outputs, no counts, no marks of the editor or the machine; as nbformat itself writes
    them.
    """
    book = read(path)
    nbformat.validate(book)
    assert set(book.metadata) == {"kernelspec", "language_info"}
    assert book.metadata.kernelspec.name == "python3"
    assert dict(book.metadata.language_info) == {"name": "python"}
    for cell in book.cells:
        assert not cell.metadata
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count) == ([], None)
    assert path.read_text() == nbformat.writes(book) + "\n"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning:(jupyter_client|nbclient|zmq|tornado).*")
@pytest.mark.parametrize("path", in_gate(NOTEBOOKS, NOTEBOOKS[:1]), ids=lambda path: path.stem)
def test_runs_and_draws(path, tmp_path):
    """Every cell runs, its assertions hold, nothing is said on stderr, and at least one picture is
    drawn.
    """
    book = read(path)
    settings = Config(
        {"KernelManager": {"transport": "ipc", "connection_file": str(tmp_path / "kernel.json")}}
    )
    NotebookClient(
        book, config=settings, timeout=120, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    assert any("image/png" in output.get("data", {}) for output in outputs)
