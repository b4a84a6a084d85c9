"""The README's Python and TOML examples run as they stand."""

import re
from pathlib import Path

import pytest

import symkin
from symkin.model.file import parse, shipped_names

README = Path(__file__).resolve().parent.parent / "README.md"
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", README.read_text(encoding="utf-8"), re.M | re.S)


@pytest.mark.slow
@pytest.mark.parametrize("code", [text for kind, text in BLOCKS if kind == "python"])
def test_python_blocks_run(code: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each Python block runs alone and prints something."""
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
def test_toml_block_has_two_modes() -> None:
    """The five-bar of the README has the two modes of a dyad (Hunt 1978: two circles meet in two points)."""
    (text,) = [text for kind, text in BLOCKS if kind == "toml"]
    assert len(symkin.modes(parse(text, "README.md"), joints=[10, -10])) == 2


def test_shipped_mechanisms_are_listed() -> None:
    """The README's table names every shipped mechanism."""
    text = README.read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in shipped_names())
