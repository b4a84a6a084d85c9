"""What studies, docs and benchmarks call of the package takes what they give it, those too whose
runs are too long for the gate.
"""

import ast
import inspect
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path for folder in ("studies", "docs", "benchmarks") for path in (ROOT / folder).rglob("*.py")
)


def called(tree: ast.Module) -> Iterator[tuple[ast.Call, object]]:
    """Calls of functions that the file imports from symkin, with these."""
    known: dict[str, object] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("symkin"):
            module = import_module(node.module or "")
            known |= {a.asname or a.name: getattr(module, a.name, None) for a in node.names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            yield node, known.get(node.func.id)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_calls_have_arguments_that_are_taken(path: Path) -> None:
    """Places and names of arguments fit the signature, wherever none of them is unpacked."""
    for node, function in called(ast.parse(path.read_text(encoding="utf-8"))):
        names = [keyword.arg for keyword in node.keywords]
        starred = any(isinstance(argument, ast.Starred) for argument in node.args)
        if inspect.isfunction(function) and not starred and None not in names:
            given = dict.fromkeys(map(str, names))
            inspect.signature(function).bind(*node.args, **given)
