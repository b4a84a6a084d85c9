"""Expand xacro, the macros of URDF, by its own package."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Any
from xml.parsers import expat

from symkin.errors import InputError, MechanismError
from symkin.formats.packages import Packages
from symkin.formats.xml_text import Element, parse_xml, read_text
from symkin.text import first_of, meant, one_line, shown

_INSTALL = "is written in xacro, which takes the package `xacro`; pip install 'symkin[urdf]' installs it"
_ARGUMENT = re.compile(r"""<xacro:arg\b[^>]*?\bname\s*=\s*["']([^"']+)|\$\(arg\s+([^)\s]+)\s*\)""")
"""Where an argument is declared, or used."""
_TOLD = ("name", "link", "joint", "xyz", "rpy", "value", "lower", "upper", "multiplier", "offset")
"""Attributes whose values the kinematics needs: macros in others, such as names of meshes, do not matter."""


def is_xacro(root: Element) -> bool:
    """Whether a robot's kinematics is written with macros."""
    return next(macros(root), None) is not None


def macros(root: Element) -> Iterator[Element]:
    """The elements that are macros, or have them in their values."""
    for element in root.walk():
        told = (element.attributes.get(key, "") for key in _TOLD)
        if element.tag.startswith("xacro:") or any("${" in value or "$(" in value for value in told):
            yield element


def expanded(path: Path, arguments: Mapping[str, str], packages: Packages) -> Element:
    """The root of a file in xacro, macros expanded; `arguments` are those of its <xacro:arg>. Lines are those of the expanded text.

    Raises InputError without the package, MechanismError with what xacro says of a file that is not right.
    """
    xacro: Any = _package(path)
    with _ALONE, _told(xacro, packages):
        xacro.all_includes = []
        try:
            document = xacro.process_file(str(path), mappings=dict(arguments), verbosity=0)
        except (MechanismError, InputError):
            raise
        except expat.ExpatError as error:
            place = f"{_place(xacro, path)}: line {error.lineno}"
            raise MechanismError(f"{place}: xacro: not XML: {expat.ErrorString(error.code)}") from None
        except RecursionError:
            raise MechanismError(f"{_place(xacro, path)}: xacro: its macros or includes call themselves") from None
        except Exception as error:
            # expressions in the file raise whatever Python does
            raise MechanismError(f"{_place(xacro, path)}: xacro: {_sentence(error)}") from None
        _refuse_unknown(arguments, [path, *(Path(file) for file in xacro.all_includes)])
    text = document.toprettyxml(indent="  ")
    return parse_xml(text.encode(), f"{path} (xacro expanded)", "robot")


def _refuse_unknown(arguments: Mapping[str, str], files: list[Path]) -> None:
    """Raise InputError for an argument that none of the files declares or uses."""
    texts = [read_text(file).decode("utf-8", "replace") for file in files if file.is_file()]
    known = sorted({name for text in texts for pair in _ARGUMENT.findall(text) for name in pair if name})
    wrong = next((name for name in arguments if name not in known), None)
    if wrong is not None:
        raise InputError(
            f"arguments: {files[0]} has no argument {shown(wrong)}{meant(wrong, known)}; its arguments: {first_of(known, 20) or 'none'}"
        )


def _package(path: Path) -> ModuleType:
    try:
        return import_module("xacro")
    except ImportError:
        raise InputError(f"{path}: {_INSTALL}") from None


_ALONE = Lock()
"""Held while xacro expands: it keeps its state in its module."""


@contextmanager
def _told(xacro: Any, packages: Packages) -> Iterator[None]:
    """Let xacro find packages where they are told, read files of no entities and of bounded size only, and print nothing."""
    substitutions: Any = import_module("xacro.substitution_args")
    find, inner, parse = substitutions._eval_find, substitutions._eval_dict["find"], xacro.parse

    def found(name: str) -> str:
        folder = packages.folder(name)
        if folder is None:
            raise MechanismError(
                f"{_place(xacro, packages.file)}: the package {name!r} of $(find {name}) is not found; name the folder that holds it by "
                "packages (--packages)"
            )
        return str(folder)

    def safe(text: Any, filename: str | None = None) -> Any:
        if text is None and filename is not None and Path(filename).is_file():
            parse_xml(read_text(Path(filename)), filename)
        return parse(text, filename)

    substitutions._eval_find = substitutions._eval_dict["find"] = found
    xacro.parse = safe
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            yield
    finally:
        substitutions._eval_find, substitutions._eval_dict["find"], xacro.parse = find, inner, parse


def _place(xacro: Any, path: Path) -> str:
    """The file that is being expanded."""
    inner = (xacro.filestack or [None])[-1]
    return f"{path}" if inner in (None, str(path)) else f"{path}: {inner}"


def _sentence(error: Exception) -> str:
    if type(error).__name__ == "ArgException" or "Undefined substitution argument" in str(error):
        name = str(error).rpartition(" ")[2]
        return f"its argument {shown(name)} is not told and has no default; give arguments (--arguments {name}=VALUE)"
    text = one_line(str(error)) or type(error).__name__
    names = [macro for macro in getattr(error, "macros", []) if macro]
    return text + (f" (in macros {', '.join(str(m.body.getAttribute('name')) for m in names)})" if names else "")
