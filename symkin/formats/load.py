"""Load a mechanism by name or path: symkin's own file format, and those in which robots are described elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from symkin.errors import InputError, MechanismError
from symkin.formats.assembled import mechanism_of
from symkin.formats.robot import Robot
from symkin.model.file import read, shipped, shipped_names
from symkin.model.mechanism import Mechanism
from symkin.text import shown


def load(name_or_path: str | Path) -> Mechanism:
    """Load a shipped mechanism by name, or a mechanism by path: .toml, or a robot in MJCF (.xml), URDF (.urdf) or SDF (.sdf).

    A robot becomes a graph of links at the closed configuration that is nearest to the file's own, in metres and radians, its root
    held as the link "base"; `close` tells the rest. Raises InputError when there is no such mechanism or file, MechanismError for a
    file that is not right: one line with file, key path or line and element, value and what is allowed.

    >>> import symkin
    >>> hexapod = symkin.load("zhang2009")
    >>> len(hexapod.limbs), hexapod.length_unit
    (6, 'mm')
    """
    text, path = str(name_or_path), Path(name_or_path)
    if text in shipped_names():
        return shipped(text)
    if path.suffix == ".toml":
        return read(path)
    if is_robot(path):
        return mechanism_of(read_robot(path))
    raise InputError(
        f"mechanism {shown(text)} is unknown; allowed: a path to a .toml, {', '.join(_READERS)} file, or {', '.join(shipped_names())}"
    )


def is_robot(path: Path) -> bool:
    """Whether a file is in a format of others."""
    return path.suffix.lower() in _READERS


def read_robot(path: Path) -> Robot:
    """The robot that a file of another format describes, its loops open as they are there."""
    try:
        return _READERS[path.suffix.lower()](path)
    except MechanismError as error:
        # parts of a robot name themselves, but not their file
        text = str(error)
        raise error if str(path) in text or path.name in text else MechanismError(f"{path}: {text}") from None


def _mjcf(path: Path) -> Robot:
    from symkin.formats.mjcf import read_mjcf

    return read_mjcf(path)


def _urdf(path: Path) -> Robot:
    from symkin.formats.urdf import read_urdf

    return read_urdf(path)


def _sdf(path: Path) -> Robot:
    from symkin.formats.sdf import read_sdf

    return read_sdf(path)


_READERS: dict[str, Callable[[Path], Robot]] = {".xml": _mjcf, ".urdf": _urdf, ".sdf": _sdf}
