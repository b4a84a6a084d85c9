"""Load a mechanism by name or path: symkin's own file format, and those in which robots are
described elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from symkin.errors import InputError, MechanismError
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.model.file import read as read_file
from symkin.model.file import shipped
from symkin.model.mechanism import Mechanism
from symkin.model.shipped import SHIPPED, shipped_names
from symkin.text import meant, shown
from symkin.verb import verb

if TYPE_CHECKING:
    from symkin.formats.robot import Robot


@verb()
def load(
    name_or_path: str | Path,
    read: ReadOptions = AS_IT_IS,
    *,
    set: Mapping[str, float | str] | None = None,
) -> Mechanism:
    """Load a shipped mechanism by name, or a mechanism by path: .toml, or a robot in MJCF (.xml),
    URDF (.urdf, .xacro) or SDF (.sdf).

    A robot becomes a graph of links at the closed configuration that is nearest to the file's own,
    in metres and radians, its root held as the link "base"; `close` tells the rest. `set` gives
    parameters of a mechanism file other numbers, or arithmetic, than the file does. `read` tells
    what the robot's file does not: kinds of closures, actuated joints, the link of the platform
    frame, arguments of xacro, packages. Raises InputError when there is no such mechanism or file,
    MechanismError for a file that is not right: one line with file, key path or line and element,
    value and what is allowed.

    >>> import symkin
    >>> hexapod = symkin.load("zhang2009")
    >>> len(hexapod.limbs), hexapod.length_unit
    (6, 'mm')
    """
    text, path = str(name_or_path), Path(name_or_path)
    read = read if set is None else replace(read, set=set)
    is_shipped = text in shipped_names()
    if is_shipped or path.suffix.lower() == ".toml":
        read.refuse_but(("set",), text, _OF_ROBOTS)
        if is_shipped and not read.set:
            return shipped(text)
        return read_file(SHIPPED / f"{text}.toml" if is_shipped else path, read.set)
    if is_robot(path):
        from symkin.formats.assembled import mechanism_of

        with _naming(path):
            return mechanism_of(read_robot(path, read))
    raise InputError(_no_mechanism(text, path))


def _no_mechanism(text: str, path: Path) -> str:
    """Why a text is neither the name of a shipped mechanism nor the path of a file that is read."""
    suffixes = ", ".join((".toml", *_READERS))
    if not text.strip():
        return (
            "the mechanism is an empty text; a name from `symkin list` or the path of a file is "
            "needed"
        )
    if path.is_dir():
        return f"{path}: is a folder; the path of a file in it is needed ({suffixes})"
    if path.exists():
        ending = f"the suffix {path.suffix!r}" if path.suffix else "no suffix"
        untold = f"the file has {ending}, which tells no format of a mechanism"
        return f"{path}: {_OTHER_SUFFIXES.get(path.suffix.lower(), untold)}; allowed: {suffixes}"
    for suffix in (".toml", *_READERS):
        if Path(text + suffix).exists():
            return f"mechanism {shown(text)} is unknown; the file is named {text}{suffix}"
    if path.suffix or len(path.parts) > 1:
        return (
            f"{path}: there is no such file; allowed: a name from `symkin list`, or a path to a "
            f"file ({suffixes})"
        )
    names = shipped_names()
    return (
        f"mechanism {shown(text)} is unknown{meant(text, names)}; allowed: {', '.join(names)}, or "
        f"a path to a file ({suffixes})"
    )


def is_robot(path: Path) -> bool:
    """Whether a file is in a format of others."""
    return path.suffix.lower() in _READERS


def read_robot(path: Path, read: ReadOptions = AS_IT_IS) -> Robot:
    """The robot that a file of another format describes, its loops open as they are there."""
    form, allowed, because = _READERS[path.suffix.lower()]
    read.refuse_but(allowed, str(path), because)
    from symkin.formats.told import as_told

    reader = getattr(import_module(f"symkin.formats.{form}"), f"read_{form}")
    with _naming(path):
        return as_told(reader(path, read), read)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Put the file before what parts of a robot, which name themselves, say is wrong."""
    try:
        yield
    except MechanismError as error:
        text = str(error)
        # a path ends with its name
        raise (error if path.name in text else MechanismError(f"{path}: {text}")) from None


_OF_ROBOTS = (
    "it is told of robots in MJCF, URDF and SDF, and a mechanism file says everything itself"
)


_YAML = "a YAML file tells the loops of a URDF file beside it, and that file is the one to name"
_OTHER_SUFFIXES = {
    ".yaml": _YAML,
    ".yml": _YAML,
    ".json": "a JSON file holds results, which are not read as mechanisms",
    ".csv": "a CSV file holds measurements or a trajectory; the mechanism is another file",
    ".world": "a world of Gazebo is SDF; give it the suffix .sdf",
    ".mjcf": "an MJCF file is read with the suffix .xml",
    ".step": "a STEP file has no joints; describe them in a .toml",
    ".stl": "an STL file has no joints; describe them in a .toml",
}
"""By suffix: what files are that are no mechanisms."""
_URDF = (
    "urdf",
    ("loop", "actuated", "platform", "arguments", "packages"),
    "a URDF file describes one robot",
)
_READERS: dict[str, tuple[str, tuple[str, ...], str]] = {
    ".xml": (
        "mjcf",
        ("loop", "actuated", "platform"),
        "an MJCF file names its parts by paths, and describes one model without macros",
    ),
    ".urdf": _URDF,
    ".xacro": _URDF,
    ".sdf": (
        "sdf",
        ("loop", "actuated", "platform", "packages", "model"),
        "SDF has no macros that are expanded here",
    ),
}
"""By suffix: the module that reads it, the options that mean something there, and why the others do
not.
"""
