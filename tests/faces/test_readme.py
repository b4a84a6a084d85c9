"""The examples of documents run as they stand: Python, TOML, and commands with the output that is
printed below them.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import symkin
from helpers.command_line import run
from helpers.documents import (
    ROOT,
    Command,
    blocks,
    is_as_printed,
    machines,
    sessions,
    shown_outputs,
)
from helpers.inside import parse
from symkin import shipped_names

TUTORIALS = tuple(
    str(path.relative_to(ROOT)) for path in sorted((ROOT / "docs" / "tutorials").glob("*.md"))
)
RECIPES = tuple(
    str(path.relative_to(ROOT)) for path in sorted((ROOT / "docs" / "recipes").glob("*.md"))
)
DOCUMENTS = ("README.md", "docs/index.md", "docs/bring-your-robot.md", *TUTORIALS, *RECIPES)
ROBOTS = ROOT / "docs" / "robots"


@pytest.fixture
def beside_robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder of the test's own with the example robots where documents name them: what a block
    writes is written there, and the paths that it adds end with it.
    """
    shutil.copytree(ROBOTS, tmp_path / "docs" / "robots")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])


@pytest.mark.slow
@pytest.mark.usefixtures("beside_robots")
@pytest.mark.parametrize(
    "code", [code for document in DOCUMENTS for code in blocks(document, "python")]
)
def test_python_blocks_run(code: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each Python block runs alone and prints something."""
    exec(compile(code, "document", "exec"), {})
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
def test_toml_block_has_two_modes() -> None:
    """The five-bar of the tutorial has the two modes of a dyad (Hunt 1978: two circles meet in two
    points).
    """
    text = machines("docs/tutorials/describe.md")["five_bar.toml"]
    assert len(symkin.modes(parse(text, "five_bar.toml"), joints=[10, -10])) == 2


def test_shipped_mechanisms_are_listed() -> None:
    """The README names every shipped mechanism."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in shipped_names())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("document", "session"),
    [(document, session) for document in DOCUMENTS for session in sessions(document)],
    ids=lambda value: value if isinstance(value, str) else str(value[0]),
)
def test_commands_print_what_stands_below_them(
    document: str,
    session: list[Command],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In a copy of the folder of example robots, with the document's machines and, for tutorials,
    those of the first one; `...` stands for any text.
    """
    pytest.importorskip("mujoco")
    folder = Path(shutil.copytree(ROBOTS, tmp_path / "robots"))
    monkeypatch.chdir(folder)
    described = machines("docs/tutorials/describe.md") if "tutorials" in document else {}
    for name, text in (described | machines(document)).items():
        (folder / name).write_text(text, encoding="utf-8")
    for command in session:
        assert command.words[0] == "symkin"
        _, out, err = run(capsys, *command.words[1:])
        assert is_as_printed(command.output, out + err), f"$ {command}\n{out}{err}"
        for at, word in enumerate(command.words):
            assert word not in ("-o", "--plot") or os.path.getsize(folder / command.words[at + 1])


def test_the_readmes_own_commands_are_among_them() -> None:
    """The one of the block that installs symkin, too, whose output stands in a block below."""
    first, five_bar = sessions("README.md")
    assert [str(command) for command in first] == ["symkin modes zhao2000 --plot zhao2000.png"]
    assert "4 modes" in first[0].output
    assert [command.words[1] for command in five_bar] == ["modes", "view"]


def test_what_stands_below_a_command_may_be_wrong() -> None:
    """The comparison tells other numbers, missing lines and lines too many; figures of the size of
    rounding are all one.
    """
    told = "closed to ... m\n...\nnote: held\n"
    assert is_as_printed(told, "closed to 1e-17 m\n  \na\nb\nnote: held\n\n")
    assert is_as_printed(told, "closed to 2 m\nnote: held")
    assert is_as_printed("to 7.5e-12 mm", "to 1e-15 mm")
    assert not any(
        is_as_printed("to 7.5e-12 mm", wrong)
        for wrong in ("to 7.5e-05 mm", "to 7.5 mm", "to 7.5e-12 m")
    )
    for wrong in (
        "closed to 1e-17\na\nnote: held",
        "closed to 1 m\na",
        "closed to 1 m\nnote: held\nnote: lost",
        "note: held",
    ):
        assert not is_as_printed(told, wrong)


@pytest.mark.parametrize("language", ["xml", "yaml"])
def test_parts_of_files_are_those_of_the_files(language: str) -> None:
    """What the page shows of a robot's file stands in it."""
    files = [path.read_text(encoding="utf-8") for path in sorted(ROBOTS.iterdir())]
    shown = blocks("docs/bring-your-robot.md", language)
    assert shown
    assert all(any(part in text for text in files) for part in shown)


@pytest.mark.slow
@pytest.mark.usefixtures("beside_robots")
@pytest.mark.parametrize(
    ("code", "told"), [pair for document in DOCUMENTS for pair in shown_outputs(document)]
)
def test_python_prints_what_stands_below_it(
    code: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """An `output` block below a Python block is what it prints."""
    exec(compile(code, "document", "exec"), {})
    assert is_as_printed(told, capsys.readouterr().out)


@pytest.mark.slow
def test_c_of_the_firmware_tutorial_compiles(tmp_path: Path) -> None:
    """Against the folder that the tutorial's command writes, with that folder's warnings."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    symkin.write_firmware(symkin.load("zhang2009"), tmp_path, real="float")
    for number, code in enumerate(blocks("docs/tutorials/firmware.md", "c")):
        (tmp_path / f"block{number}.c").write_text(code, encoding="utf-8")
        strict = [
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Wconversion",
            "-Werror",
            "-fsyntax-only",
        ]
        subprocess.run(["gcc", *strict, f"block{number}.c"], cwd=tmp_path, check=True)
