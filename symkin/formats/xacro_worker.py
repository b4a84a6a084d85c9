"""Expand xacro by its own package, in a child process (`formats/child.py`): macros may call each
other without end.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any
from xml.parsers import expat

from symkin.errors import InputError, MechanismError
from symkin.formats.packages import Packages
from symkin.formats.xml_text import parse_xml, read_text
from symkin.text import one_line, shown


def work(task: dict[str, Any]) -> dict[str, Any]:
    """The expanded text of the file `task["path"]` and the files that it includes; or `error`, what
    is wrong with it.
    """
    sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - xacro prints, until the process ends
    path = Path(task["path"])
    try:
        xacro = import_module("xacro")
    except ImportError as error:
        return {"error": f"{path}: the package xacro cannot be imported: {error}"}
    _tell(xacro, Packages(path, tuple(map(Path, task["folders"]))))
    try:
        document = xacro.process_file(str(path), mappings=task["arguments"], verbosity=0)
        return {
            "text": document.toprettyxml(indent="  "),
            "files": [str(file) for file in xacro.all_includes],
        }
    except MemoryError:
        raise
    except Exception as error:
        # expressions in the file raise whatever Python does
        return {"error": _said(error, _place(xacro, path))}


def _tell(xacro: Any, packages: Packages) -> None:
    """Let xacro find packages where they are told, and read files of no entities and of bounded
    size only.
    """
    substitutions: Any = import_module("xacro.substitution_args")
    parse = xacro.parse

    def found(name: str) -> str:
        folder = packages.folder(name)
        if folder is None:
            raise MechanismError(
                f"{_place(xacro, packages.file)}: the package {name!r} of $(find {name}) is not "
                f"found; name the folder that holds it by "
                "packages (--packages)"
            )
        return str(folder)

    def safe(text: Any, filename: str | None = None) -> Any:
        if text is None and filename is not None and Path(filename).exists():
            parse_xml(read_text(Path(filename)), filename)
        return parse(text, filename)

    substitutions._eval_find = substitutions._eval_dict["find"] = found
    xacro.parse = safe


def _place(xacro: Any, path: Path) -> str:
    """The file that is being expanded."""
    inner = (xacro.filestack or [None])[-1]
    return f"{path}" if inner in (None, str(path)) else f"{path}: {inner}"


def _said(error: Exception, place: str) -> str:
    """What xacro says of a file that is not right, as a sentence."""
    if isinstance(error, MechanismError | InputError):
        return str(error)
    if isinstance(error, expat.ExpatError):
        return f"{place}: line {error.lineno}: xacro: not XML: {expat.ErrorString(error.code)}"
    if isinstance(error, RecursionError):
        return f"{place}: xacro: its macros or includes call themselves"
    return f"{place}: xacro: {_sentence(error)}"


def _sentence(error: Exception) -> str:
    if type(error).__name__ == "ArgException" or "Undefined substitution argument" in str(error):
        name = str(error).rpartition(" ")[2]
        return (
            f"its argument {shown(name)} is not told and has no default; give arguments "
            f"(--arguments {name}=VALUE)"
        )
    text = one_line(str(error)) or type(error).__name__
    names = [str(m.body.getAttribute("name")) for m in getattr(error, "macros", []) if m]
    return f"{text} (in macros {', '.join(names)})" if names else text
