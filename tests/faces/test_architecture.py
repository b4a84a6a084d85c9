"""The house stays as docs/architecture.md draws it: imports run down its layers and in no circle,
functions take few parameters, and every path and function that the page names exists.
"""

from __future__ import annotations

import ast
import gc
import re
import tomllib
from collections.abc import Iterator
from functools import cache, lru_cache
from itertools import pairwise
from pathlib import Path

from helpers import inside

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "symkin"
TESTS = ROOT / "tests"
DOOR = TESTS / "helpers" / "inside.py"
PAGE = ROOT / "docs" / "architecture.md"
MOST_PARAMETERS = 8
COMMANDS = "symkin.cli"
"""An option is made of each parameter of a command: these functions have as many as the command
line has options.
"""
PARTS = ("text", "steps", "map", "folder")
"""Packages of codegen, each of which reads those before it."""
PUBLIC = "symkin"
"""What it exports and takes a mechanism is a verb, and so is what commands call: its keywords are a
command's options.
"""


@lru_cache(maxsize=1)
def modules() -> dict[str, ast.Module]:
    """Every module of the package, parsed, by its dotted name."""
    # none of the many objects is garbage: collecting takes twice as long as parsing
    gc.disable()
    try:
        return {
            dotted_name(path): ast.parse(path.read_text(encoding="utf-8"))
            for path in sorted(PACKAGE.rglob("*.py"))
        }
    finally:
        gc.enable()


def dotted_name(path: Path) -> str:
    """The name by which a file of the package is imported."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def nodes(module: str) -> list[ast.AST]:
    """Every node of a module."""
    return list(ast.walk(modules()[module]))


@lru_cache(maxsize=1)
def imports() -> dict[str, set[str]]:
    """Modules that each module imports: at its top, within functions and for type checkers
    alike.
    """
    return {name: set(_imported(name)) - {name} for name in modules()}


def _imported(module: str) -> Iterator[str]:
    for node in nodes(module):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules())
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            below = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name for name in below if name in modules())
            if node.module in modules() and any(name not in modules() for name in below):
                yield node.module
        elif (
            isinstance(node, ast.Call)
            and getattr(node.func, "id", "") == "import_module"
            and node.args
        ):
            yield from (v for v in [getattr(node.args[0], "value", None)] if v in modules())


@lru_cache(maxsize=1)
def layers() -> list[list[str]]:
    """Packages of each line of the page's table of layers, the lowest first; the public names and
    commands are above them.
    """
    (table,) = re.findall(r"^```layers\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    return [line.split(":")[0].split() for line in table.splitlines()]


@cache
def layer_of(module: str) -> int:
    """The number of a module's layer: 0 for modules that stand alone in symkin/, the last for
    symkin itself.
    """
    parts = module.split(".")
    if len(parts) == 1 or parts[1] == "__main__":
        return len(layers())
    packages = [name for line in layers()[1:] for name in line]
    return (
        next((k for k, line in enumerate(layers()) if k and parts[1] in line), 0)
        if parts[1] in packages
        else 0
    )


@cache
def part_of(module: str) -> int:
    """The number of a module's package in codegen; -1 for modules elsewhere."""
    names = module.split(".")
    inside_codegen = names[:2] == ["symkin", "codegen"] and len(names) > 3
    return PARTS.index(names[2]) if inside_codegen else -1


def test_the_page_lists_every_package_once() -> None:
    listed = sorted(name for line in layers()[1:] for name in line)
    assert listed == sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))


def test_the_code_is_as_the_house_wants_it() -> None:
    """The laws of one module and of all together, in one test, which parses the package once."""
    assert [*upward_imports(), *rings(), *deciding_asserts(), *many_parameters()] == []


def upward_imports() -> Iterator[str]:
    """No module imports one of a layer above its own, deferred imports and those for type checkers
    included.
    """
    for module, others in imports().items():
        yield from (
            f"{module} imports {other}, a layer above"
            for other in others
            if layer_of(other) > layer_of(module) or part_of(other) > part_of(module) >= 0
        )


def deciding_asserts() -> Iterator[str]:
    """Asserts tell a type checker what has been looked at before: that something is there, or of
    which class it is. Whatever compares values is an error with a sentence.
    """
    for name in modules():
        found = (
            node for node in nodes(name) if isinstance(node, ast.Assert) and not _narrows(node.test)
        )
        yield from (f"{name}:{node.lineno}: an assert decides on input" for node in found)


def _narrows(test: ast.expr) -> bool:
    if isinstance(test, ast.BoolOp):
        return all(map(_narrows, test.values))
    if isinstance(test, ast.UnaryOp):
        return isinstance(test.op, ast.Not) and _narrows(test.operand)
    if isinstance(test, ast.Compare):
        return isinstance(test.ops[0], ast.IsNot) and isinstance(test.comparators[0], ast.Constant)
    return isinstance(test, ast.Call) and getattr(test.func, "id", "") == "isinstance"


def rings() -> Iterator[str]:
    """No two modules import each other, nor three or more in a ring."""
    left = {name: set(others) for name, others in imports().items()}
    while free := [name for name, others in left.items() if not others]:
        left = {name: others - set(free) for name, others in left.items() if name not in free}
    yield from (f"{name} imports {sorted(others)} in a ring" for name, others in left.items())


def functions(module: str) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (
        node for node in nodes(module) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    )


@lru_cache(maxsize=1)
def called() -> set[tuple[str, str]]:
    """Module and name of all that symkin exports or that a module of commands imports from
    below.
    """
    found = [
        node
        for face in modules()
        if face == PUBLIC or face.startswith(COMMANDS)
        for node in nodes(face)
        if isinstance(node, ast.ImportFrom) and node.module in modules()
    ]
    return {
        (node.module, alias.name)
        for node in found
        if not node.module.startswith(COMMANDS)
        for alias in node.names
    }


def is_verb(module: str, function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether users or commands call the function, and it takes a mechanism first."""
    first = function.args.args[0].annotation if function.args.args else None
    return (
        (module, function.name) in called()
        and first is not None
        and "Mechanism" in ast.unparse(first)
    )


def parameters(
    function: ast.FunctionDef | ast.AsyncFunctionDef, *, options: bool = True
) -> list[str]:
    """Names of a function's parameters but for `self`, with or without its options, which are only
    given by name.
    """
    a = function.args
    named = [*a.kwonlyargs, *(arg for arg in (a.kwarg,) if arg is not None)] if options else []
    given = [*a.posonlyargs, *a.args, *(arg for arg in (a.vararg,) if arg is not None), *named]
    return [arg.arg for arg in given if arg.arg not in ("self", "cls")]


def many_parameters() -> Iterator[str]:
    """Functions take at most eight. Commands are excepted, and the options of verbs, which
    are those of their commands: a copy of them in a dictionary or a class hides them from the
    reader, and saves nothing.
    """
    for module in modules():
        if module.startswith(COMMANDS):
            continue
        counted = (
            (f.name, len(parameters(f, options=not is_verb(module, f)))) for f in functions(module)
        )
        yield from (
            f"{module}: {name} takes {count} parameters"
            for name, count in counted
            if count > MOST_PARAMETERS
        )


# --- the tests' door ------------------------------------------------------------------------------


def test_tests_come_in_by_one_door() -> None:
    """Only `inside.py` names what is below the public names, in imports and in strings; it names
    nothing that no file uses, and all that a file takes from it.
    """
    below = re.compile(
        rf"(?:from|import) symkin\.\w|\bsymkin\.(?:{'|'.join(sorted(inner_names()))})\.\w"
    )
    texts = {
        path: path.read_text(encoding="utf-8")
        for path in sorted(TESTS.rglob("*.py"))
        if path != DOOR
    }
    assert [
        f"{path.relative_to(TESTS)}: {line}"
        for path, text in texts.items()
        for line in text.splitlines()
        if below.search(line)
    ] == []
    taken = {
        f"{path.relative_to(TESTS)}: {name}"
        for path, text in texts.items()
        for names in re.findall(r"from helpers\.inside import (\([^)]*\)|[^(\n]+)", text)
        for name in re.findall(r"\w+", re.sub(r" as \w+|#.*", "", names))
        if name not in {*inside.NAMES, *inside.MODULES, *vars(inside)}
    }
    assert taken == set()
    words = {word for text in texts.values() for word in re.findall(r"\w+", text)}
    assert [name for name in [*inside.NAMES, *inside.MODULES] if name not in words] == []


def inner_names() -> set[str]:
    """Packages, and modules that stand alone."""
    return {
        path.stem
        for path in PACKAGE.iterdir()
        if path.suffix in ("", ".py") and path.stem.isidentifier()
    } - {"__init__"}


# --- the page -------------------------------------------------------------------------------------


def named_paths() -> list[str]:
    """Paths in backticks on the page."""
    text = PAGE.read_text(encoding="utf-8")
    return sorted(set(re.findall(r"`([\w.-]+(?:/[\w.-]+)*/?)`", text)) & set(_paths(text)))


def _paths(text: str) -> Iterator[str]:
    return (
        name
        for name in re.findall(r"`([\w./-]+)`", text)
        if "/" in name or re.search(r"\.(py|md|toml|yaml|npz)$", name)
    )


def test_paths_and_functions_on_the_page_exist() -> None:
    assert named_paths()
    assert [
        path
        for path in named_paths()
        if not any((folder / path).exists() for folder in (ROOT, PACKAGE))
    ] == []
    assert named_functions()
    assert [
        (path, name)
        for path, name in named_functions()
        if not set(name.split(".")) <= names_in(path)
    ] == []


def named_functions() -> list[tuple[str, str]]:
    """Pairs `file.py`: `function` on the page."""
    return re.findall(r"`([\w/]+\.py)`: `([\w.]+)`", PAGE.read_text(encoding="utf-8"))


@cache
def names_in(path: str) -> set[str]:
    """Functions, classes and variables that a file of the package defines."""
    tree = ast.parse((PACKAGE / path).read_text(encoding="utf-8"))
    defined = {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    assigned = {
        t.id
        for n in ast.walk(tree)
        if isinstance(n, ast.Assign | ast.AnnAssign)
        for t in _targets(n)
    }
    return defined | assigned


def _targets(node: ast.Assign | ast.AnnAssign) -> list[ast.Name]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [t for t in targets if isinstance(t, ast.Name)]


def test_the_way_of_the_data_has_at_most_eight_steps() -> None:
    """Numbered from 1, each with a file and a function."""
    text = (
        PAGE.read_text(encoding="utf-8")
        .split("## From a file to the printed table")[1]
        .split("\n## ")[0]
    )
    steps = re.findall(r"^(\d)\. .*$", text, re.M)
    assert 1 <= len(steps) <= 8
    assert all(int(b) - int(a) == 1 for a, b in pairwise(steps))
    assert all(
        re.search(r"`[\w/]+\.py`: `\w+`", line)
        for line in re.findall(r"^\d\. .*(?:\n   .*)*", text, re.M)
    )


def test_each_fault_of_the_mutations_stands_in_the_code() -> None:
    """A fault whose text has gone is no longer tried, and its test guards nothing that is known."""
    faults = tomllib.loads((TESTS / "campaigns" / "mutations.toml").read_text())["fault"]
    for fault in faults:
        assert (ROOT / fault["file"]).read_text().count(fault["old"]) == 1, fault["name"]


def test_campaigns_end_with_a_status_of_what_they_found() -> None:
    """CONTRIBUTING.md promises it of its table: one that printed duplicates ended with 0."""
    table = (ROOT / "CONTRIBUTING.md").read_text().split("\n## Campaigns\n")[1].split("\n## ")[0]
    names = re.findall(r"^\| `(\w+)` \|", table, re.M)
    assert len(names) > 10
    for name in names:
        assert "    sys.exit(" in (TESTS / "campaigns" / f"{name}.py").read_text(), name
