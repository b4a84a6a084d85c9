"""What the shell completes: commands, mechanisms and the values of options. Where no mechanism
fits, shells go on with the names of files.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from symkin.errors import InputError
from symkin.text import not_among

_ASKED_BY = "_SYMKIN_COMPLETE"
"""The variable by which a shell's script asks, as in `_SYMKIN_COMPLETE=bash_complete`."""
_PLACES = {
    "bash": ("~/.bash_completions/symkin.sh", "~/.bashrc", "source '{}'"),
    "zsh": ("~/.zfunc/_symkin", "~/.zshrc", "autoload -Uz compinit; compinit; source '{}'"),
    "fish": ("~/.config/fish/completions/symkin.fish", "", ""),
    "powershell": ("~/.symkin_completion.ps1", "$profile", ". '{}'"),
    "pwsh": ("~/.symkin_completion.ps1", "$profile", ". '{}'"),
}
"""By shell: where its script goes, and the file that loads it with the line that does."""
_OF_THIS_TERMINAL = "this"


def mechanism_names(incomplete: str) -> list[Any]:
    """Shipped mechanisms and files in this folder that begin with `incomplete`; where there is no
    such mechanism, files, since shells complete folders better.
    """
    from click.shell_completion import CompletionItem

    from symkin.formats.load import is_robot
    from symkin.model.shipped import shipped_names

    names = [name for name in shipped_names() if name.startswith(incomplete)]
    if not names:
        return [CompletionItem(incomplete, type="file")]
    files = [path.name for path in Path().iterdir() if path.suffix == ".toml" or is_robot(path)]
    return [*names, *sorted(name for name in files if name.startswith(incomplete))]


def answer_shell(app: click.Command) -> bool:
    """Whether a shell asks for what may follow; it is told so."""
    asked = os.environ.get(_ASKED_BY)
    if not asked:
        return False
    from click.shell_completion import shell_complete

    shell_complete(app, {}, "symkin", _ASKED_BY, asked)
    return True


def _script(app: click.Command, shell: str) -> tuple[str, str]:
    """The shell that is meant, and the script that teaches it."""
    from click.shell_completion import get_completion_class

    if shell == _OF_THIS_TERMINAL:
        shell = Path(os.environ.get("SHELL") or "powershell").stem
    kinds = {name: get_completion_class(name.replace("pwsh", "powershell")) for name in _PLACES}
    kind = kinds.get(shell)
    if kind is None:  # older versions of Click have none for PowerShell
        raise InputError(f"shell {not_among(shell, [name for name in kinds if kinds[name]])}")
    return shell, kind(app, {}, "symkin", _ASKED_BY).source()


def _show(ctx: click.Context, _option: click.Parameter, shell: str | None) -> None:
    if shell is not None:
        print(_script(ctx.command, shell)[1])
        ctx.exit()


def _install(ctx: click.Context, _option: click.Parameter, shell: str | None) -> None:
    if shell is None:
        return
    from symkin.files.outputs import write_output

    shell, text = _script(ctx.command, shell)
    place, loader, line = _PLACES[shell]
    script = Path(place).expanduser()
    script.parent.mkdir(parents=True, exist_ok=True)
    write_output(script, text + "\n")
    if loader == "$profile":
        import subprocess

        asked = [shell, "-NoProfile", "-Command", "echo $profile"]
        loader = subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip()
    if loader:
        file = Path(loader).expanduser()
        before = file.read_text(encoding="utf-8") if file.is_file() else ""
        if line.format(script) not in before:
            file.parent.mkdir(parents=True, exist_ok=True)
            write_output(file, f"{before.rstrip()}\n{line.format(script)}\n".lstrip())
    print(f"{shell} completion installed in {script}; it works in terminals that are opened now")
    ctx.exit()


OPTIONS = [
    click.Option(
        [f"--{what}-completion"],
        is_flag=False,
        flag_value=_OF_THIS_TERMINAL,
        metavar="[SHELL]",
        expose_value=False,
        callback=callback,
        help=text,
    )
    for what, callback, text in (
        ("install", _install, "Install completion for the current shell."),
        (
            "show",
            _show,
            "Show completion for the current shell, to copy it or customize the installation.",
        ),
    )
]
