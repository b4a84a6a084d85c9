"""Pages of the reference that the program itself tells: the help of its commands, its tolerances."""

from __future__ import annotations

import ast
from pathlib import Path

import click
import typer

from symkin.cli.app import app
from symkin.numeric import tolerances

HELP = """# Help of the commands

What each command prints with `-h`. This page is made from the program.
"""
TOLERANCES = """# Tolerances

The numbers by which symkin judges configurations, from `symkin/numeric/tolerances.py`.
"""


def help_page() -> str:
    """The help of every command, 80 columns wide."""
    command = typer.main.get_command(app)
    return HELP + "".join(_help(command, "symkin", None))


def tolerances_page() -> str:
    """Name, value and reason of each tolerance, from the module's source."""
    tree = ast.parse(Path(tolerances.__file__).read_text(encoding="utf-8"))
    lead = (ast.get_docstring(tree) or "").split("\n\n")
    rows = [
        f"`{name.targets[0].id}`\n: **{ast.unparse(name.value)}**. {_reason(text)}\n"
        for name, text in zip(tree.body, tree.body[1:], strict=False)
        if isinstance(name, ast.Assign) and isinstance(name.targets[0], ast.Name) and isinstance(text, ast.Expr)
    ]
    table = [f"```text\n{part}\n```" if part.startswith("    ") else part for part in lead]
    return "\n\n".join([TOLERANCES, *table, "## Each of them", *rows])


def _help(command: click.Command, name: str, parent: click.Context | None) -> list[str]:
    context = command.make_context(name.split()[-1], [], parent, resilient_parsing=True, terminal_width=80, max_content_width=80)
    text = f"\n## `{name}`\n\n```text\n{command.get_help(context).rstrip()}\n```\n"
    below = command.commands if isinstance(command, click.Group) else {}
    return [text, *(part for word, each in below.items() for part in _help(each, f"{name} {word}", context))]


def _reason(text: ast.Expr) -> str:
    return " ".join(ast.literal_eval(text.value).split())
