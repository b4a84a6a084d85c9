"""Expand xacro, the macros of URDF, by its own package, in a process of its own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path

from symkin.errors import InputError, MechanismError
from symkin.formats.child import ChildError, answer_of
from symkin.formats.packages import Packages
from symkin.formats.xml_text import Element, parse_xml, read_text
from symkin.text import first_of, meant, shown

_WORKER = Path(__file__).with_name("xacro_worker.py")
_INSTALL = (
    "is written in xacro, which takes the package `xacro`; pip install 'symkin[urdf]' installs it"
)
_ARGUMENT = re.compile(r"""<xacro:arg\b[^>]*?\bname\s*=\s*["']([^"']+)|\$\(arg\s+([^)\s]+)\s*\)""")
"""Where an argument is declared, or used."""
_TOLD = ("name", "link", "joint", "xyz", "rpy", "value", "lower", "upper", "multiplier", "offset")
"""Attributes whose values the kinematics needs: macros in others, such as names of meshes, do not
matter.
"""


def is_xacro(root: Element) -> bool:
    """Whether a robot's kinematics is written with macros."""
    return next(macros(root), None) is not None


def macros(root: Element) -> Iterator[Element]:
    """The elements that are macros, or have them in their values."""
    for element in root.walk():
        told = (element.attributes.get(key, "") for key in _TOLD)
        if element.tag.startswith("xacro:") or any(
            "${" in value or "$(" in value for value in told
        ):
            yield element


def expanded(path: Path, arguments: Mapping[str, str], packages: Packages) -> Element:
    """The root of a file in xacro, macros expanded; `arguments` are those of its <xacro:arg>. Lines
    are those of the expanded text.

    Raises InputError without the package, MechanismError with what xacro says of a file that is not
    right.
    """
    if find_spec("xacro") is None:
        raise InputError(f"{path}: {_INSTALL}")
    task = {
        "path": str(path),
        "arguments": dict(arguments),
        "folders": [str(folder) for folder in packages.folders],
    }
    try:
        told = answer_of(_WORKER, task)
    except ChildError as error:
        raise MechanismError(f"{path}: xacro {error}") from None
    if "error" in told:
        raise MechanismError(told["error"])
    _refuse_unknown(arguments, [path, *(Path(file) for file in told["files"])])
    return parse_xml(told["text"].encode(), f"{path} (xacro expanded)", "robot")


def _refuse_unknown(arguments: Mapping[str, str], files: list[Path]) -> None:
    """Raise InputError for an argument that none of the files declares or uses."""
    texts = [read_text(file).decode("utf-8", "replace") for file in files if file.is_file()]
    known = sorted(
        {name for text in texts for pair in _ARGUMENT.findall(text) for name in pair if name}
    )
    wrong = next((name for name in arguments if name not in known), None)
    if wrong is not None:
        raise InputError(
            f"arguments: {files[0]} has no argument {shown(wrong)}{meant(wrong, known)}; its "
            f"arguments: {first_of(known, 20) or 'none'}"
        )
