"""What `import symkin` offers is listed, documented and short, and the examples of its docstrings
run.
"""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import symkin
from helpers.gate import in_gate_but

MOST_NAMES = 51
LONGEST_SENTENCE = 130
"""Characters of the first sentence of a public name, which lists show alone."""
NAMES = [name for name in symkin.__all__ if name != "__version__"]
DEAR = [
    "Loci",
    "ModeGraph",
    "mode_graph",
    "plan_measurements",
    "singular_loci",
    "sweep",
    "track",
    "write_firmware",
]
"""Those whose examples compute for seconds."""
SOURCE = ast.parse(Path(symkin.__file__).read_text(encoding="utf-8"))


def test_few_names_are_public_and_dir_shows_these_alone() -> None:
    assert len(symkin.__all__) <= MOST_NAMES
    assert dir(symkin) == sorted(set(symkin.__all__))


@pytest.mark.parametrize("name", symkin.__all__)
def test_a_public_name_is_one_thing(name: str) -> None:
    """What is imported at first use is what type checkers see: the name, from the module that
    defines it.
    """
    value = getattr(symkin, name)
    assert value is getattr(symkin, name)
    declared = {
        alias.asname or alias.name: node.module
        for node in ast.walk(SOURCE)
        if isinstance(node, ast.ImportFrom) and node.module is not None
        for alias in node.names
    }
    assert getattr(importlib.import_module(declared[name]), name) is value


def test_unknown_names_are_attribute_errors() -> None:
    with pytest.raises(AttributeError, match="no attribute 'mode'"):
        symkin.mode  # noqa: B018


def _documented(name: str) -> Any:
    return inspect.unwrap(getattr(symkin, name))


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_documented(name: str) -> None:
    """A short first sentence, and an example; functions say what they raise."""
    text = inspect.getdoc(_documented(name)) or ""
    assert re.match(rf".{{1,{LONGEST_SENTENCE}}}?[.:](\s|$)", " ".join(text.split())), text
    assert ">>> " in text
    if inspect.isfunction(_documented(name)) and inspect.signature(_documented(name)).parameters:
        assert "Raises" in text


@pytest.mark.parametrize("name", NAMES)
def test_types_of_a_signature_are_written_as_users_write_them(name: str) -> None:
    """Help of Python shows `Sequence[float]` and `Literal`, not the modules that they are from."""
    value = getattr(symkin, name)
    if inspect.isfunction(value):
        assert not re.search(r"\b(typing|collections|pathlib)\.", str(inspect.signature(value)))


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate_but(NAMES, DEAR))
def test_the_example_of_a_public_name_runs(name: str) -> None:
    """Each example alone, as a reader would type it."""
    value = _documented(name)
    finder = doctest.DocTestFinder(recurse=inspect.isclass(value), exclude_empty=True)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL)
    said: list[str] = []
    for example in finder.find(value, name, globs={}):
        runner.run(example, out=said.append)
    assert runner.failures == 0, "".join(said)
