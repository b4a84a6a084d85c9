"""The site of docs/ is built without a warning, and its pages hold what the program tells."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from helpers.needed import needs

pytestmark = needs("furo")
ROOT = Path(__file__).resolve().parents[2]


def build(folder: Path, *options: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", *options, "docs", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-4000:]


@pytest.mark.long
def test_site_is_built_without_a_warning(tmp_path: Path) -> None:
    """With a gallery of three; help, tolerances and verdicts are there."""
    build(tmp_path, "-t", "short")
    for page, told in {
        "index.html": "Describe your machine",
        "generated/help.html": "symkin calibrate fit",
        "generated/tolerances.html": "CLOSURE_TOLERANCE",
        "generated/papers.html": "refuted",
        "generated/gallery/zhao2000.html": "4 modes",
        "explanations/completeness.html": "<math",
        "generated/api.html": "symkin.modes",
    }.items():
        text = (tmp_path / page).read_text(encoding="utf-8")
        assert told in text or told in re.sub("<[^>]*>", "", text), page


@pytest.mark.long
def test_whole_gallery_is_built(tmp_path: Path) -> None:
    """Every mechanism has its page that moves."""
    import symkin

    build(tmp_path)
    assert {path.stem for path in (tmp_path / "moving").glob("*.html")} == set(
        symkin.shipped_names()
    )


def test_a_command_that_draws_nothing_is_named_with_its_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In place of the picture that is missing."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from _site.pictures import draw_pictures

    page = tmp_path / "page.md"
    page.write_text(
        "```console\n$ symkin modes no_such_machine --plot seen.png\n```\n", encoding="utf-8"
    )
    with pytest.raises(
        RuntimeError,
        match=r"page: symkin modes no_such_machine .* drew nothing .*'no_such_machine' is unknown",
    ):
        draw_pictures([page], tmp_path / "pictures")
