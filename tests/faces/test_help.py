"""Help: printed as it is written, in groups, within 80 columns; every example of it runs."""

import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import symkin
from helpers.command_line import run
from helpers.gate import in_gate_but
from helpers.inside import app


def _commands(
    group: Any = app, before: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        yield (*before, name), command
        if hasattr(command, "commands"):
            yield from _commands(command, (*before, name))


ALL = list(_commands())
EXAMPLES = {
    name: [line for words, c in ALL if words[0] == name for line in (c.epilog or "").splitlines()]
    for name in app.list_commands(None)
}
"""By command, those of `calibrate` in one list: they read what others have written."""


def test_symkin_alone_prints_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a command: the help, line by line, on stdout, and status 0; so has `calibrate`."""
    assert run(capsys) == run(capsys, "--help") == run(capsys, "-h")
    status, out, err = run(capsys)
    assert (status, err) == (0, "")
    assert out.splitlines()[0] == "Usage: symkin [OPTIONS] COMMAND [ARGS]..."
    assert run(capsys, "calibrate") == run(capsys, "calibrate", "-h")


@pytest.mark.parametrize(
    ("words", "command"),
    [((), app), *ALL],
    ids=lambda w: " ".join(w) if isinstance(w, tuple) else "",
)
def test_help_fits_a_terminal_and_has_examples(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], command: Any
) -> None:
    """`-h` of every command: within 80 columns, no escape of a markup, every option in it, an
    example for each command.
    """
    status, out, err = run(capsys, *words, "-h")
    assert (status, err) == (0, "")
    assert [line for line in out.splitlines() if len(line) > 80] == []
    assert "\\[" not in out
    assert all(
        parameter.opts[0] in out
        for parameter in command.params
        if parameter.param_type_name == "option"
    )
    if not hasattr(command, "commands"):
        assert f"  symkin {' '.join(words)}" in out.split("Examples:")[1]
        assert f"Usage: symkin {' '.join(words)}" in out


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    in_gate_but(
        EXAMPLES,
        ["calibrate", "singularities", "sweep", "firmware", "track", "modes", "show", "view"],
    ),
)
def test_examples_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str
) -> None:
    """Every example in the order of the help, in a folder with the files that are the user's
    own.
    """
    monkeypatch.chdir(tmp_path)
    symkin.convert("ankle", "robot.urdf")
    for example in EXAMPLES[name]:
        status, _, err = run(capsys, *shlex.split(example)[1:])
        assert (status, err) == (0, ""), example


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("symkin mod", ["modes", "mode-graph"]),
        ("symkin modes zhao", ["zhao2000", "zhao2000_links", "zhao_mine.toml"]),
        ("symkin modes other", ["file,other"]),
        ("symkin modes zhao2000 --method m", ["multistart"]),
        ("symkin calibrate pl", ["plan"]),
        ("symkin jacobian ankle --format n", ["numpy"]),
    ],
)
def test_bash_completes(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    words: str,
    expected: list[str],
) -> None:
    """What bash is offered: commands, mechanisms by name, files of mechanisms beside them, values
    of options. Where nothing fits, it goes on with files.
    """
    for name in ("zhao_mine.toml", "zhao.txt", "other.toml"):
        (tmp_path / name).write_text("")
    environment = {
        "_SYMKIN_COMPLETE": "bash_complete",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.chdir(tmp_path)
    status, out, _ = run(capsys)
    assert (status, out.replace("plain,", "").split()) == (0, expected)


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is needed")
def test_completion_is_a_script(capsys: pytest.CaptureFixture[str]) -> None:
    """`--show-completion bash` prints a script that bash reads; an unknown shell is refused with
    those that are known.
    """
    status, script, _ = run(capsys, "--show-completion", "bash")
    assert (status, "_SYMKIN_COMPLETE" in script) == (0, True)
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    status, out, err = run(capsys, "--show-completion", "zhs")
    assert (status, out, "do you mean 'zsh'?" in err) == (2, "", True)


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is needed")
def test_completion_is_installed_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of the terminal's own shell; what the user's file held stays, and a second time adds
    nothing.
    """
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("SHELL", "/bin/bash")
    start = tmp_path / ".bashrc"
    start.write_text("export KEPT=1\n")
    for _ in range(2):
        status, out, err = run(capsys, "--install-completion")
        assert (status, err) == (0, "")
        assert "bash completion installed" in out
        lines = start.read_text().splitlines()
        assert len(lines) == 2
        assert lines[0] == "export KEPT=1"
        subprocess.run(["bash", "-c", lines[1]], check=True)


@pytest.mark.parametrize(
    ("missing", "words", "extra"),
    [
        ("zarr", ["sweep", "zhao2000", "--grid", "nonsense", "-o", "x"], "symkin[sweep]"),
        ("mujoco", ["show", "robot.xml"], "symkin[mjcf]"),
    ],
)
def test_extras_are_named(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    missing: str,
    words: list[str],
    extra: str,
) -> None:
    """The help of a command that needs an extra names it, and so does the error without it, before
    anything else is looked at.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.xml").write_text("<mujoco/>")
    monkeypatch.setitem(sys.modules, missing, None)
    assert extra in " ".join(run(capsys, words[0], "-h")[1].split())
    status, _, err = run(capsys, *words)
    assert (status, err.count("\n")) == (2, 1)
    assert f"pip install '{extra}'" in err
