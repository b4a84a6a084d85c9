"""Pages of the reference that the program itself tells: the help of its commands, its
tolerances.
"""

from __future__ import annotations

import ast
import inspect
from pathlib import Path
from typing import Any

import symkin
from symkin.cli.app import app
from symkin.numeric import tolerances

HELP = """# Help of the commands

What each command prints with `-h`. This page is made from the program.
"""
API = """# Python API

The functions and types of `import symkin`, from their docstrings. [Python](../reference/python.md)
says how they go together.
"""
TOLERANCES = """# Tolerances

The numbers by which symkin judges configurations, from `symkin/numeric/tolerances.py`.
"""


def help_page() -> str:
    """The help of every command, 80 columns wide."""
    return HELP + "".join(_help(app, "symkin", None))


def api_page() -> str:
    """Every name of `symkin`: its verbs, its types, its errors."""
    shown = {name: getattr(symkin, name) for name in symkin.__all__}
    errors = [
        name
        for name, each in shown.items()
        if inspect.isclass(each) and issubclass(each, Exception)
    ]
    types = [name for name, each in shown.items() if inspect.isclass(each) and name not in errors]
    verbs = [name for name, each in shown.items() if inspect.isfunction(each)]
    text = API
    for title, names, directive in [
        ("Verbs", verbs, "function"),
        ("Types", types, "class"),
        ("Errors", errors, "class"),
    ]:
        text += f"\n## {title}\n"
        for name in names:
            members = "" if directive == "function" else "   :members:\n"
            text += (
                f"\n### {name}\n\n```{{eval-rst}}\n.. auto{directive}:: symkin.{name}\n"
                f"{members}```\n"
            )
    return text


def tolerances_page() -> str:
    """Name, value and reason of each tolerance, from the module's source."""
    tree = ast.parse(Path(tolerances.__file__).read_text(encoding="utf-8"))
    lead = (ast.get_docstring(tree) or "").split("\n\n")
    rows = [
        f"`{name.targets[0].id}`\n: **{ast.unparse(name.value)}**. {_reason(text)}\n"
        for name, text in zip(tree.body, tree.body[1:], strict=False)
        if isinstance(name, ast.Assign)
        and isinstance(name.targets[0], ast.Name)
        and isinstance(text, ast.Expr)
    ]
    table = [f"```text\n{part}\n```" if part.startswith("    ") else part for part in lead]
    return "\n\n".join([TOLERANCES, *table, "## Each of them", *rows])


def _help(command: Any, name: str, parent: Any) -> list[str]:
    """The help of a command, and of those below it."""
    context = command.make_context(
        name.split()[-1],
        [],
        parent,
        resilient_parsing=True,
        terminal_width=80,
        max_content_width=80,
    )
    text = f"\n## `{name}`\n\n```text\n{command.get_help(context).rstrip()}\n```\n"
    below = command.list_commands(context) if hasattr(command, "list_commands") else []
    return [
        text,
        *(
            part
            for word in below
            for part in _help(command.get_command(context, word), f"{name} {word}", context)
        ),
    ]


def _reason(text: ast.Expr) -> str:
    return " ".join(ast.literal_eval(text.value).split())
