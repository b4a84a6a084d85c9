"""Find the files that a robot's file names by a package: package://NAME/..., model://NAME/...,
$(find NAME).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

_SCHEMES = ("package://", "model://")
_LEVELS_ABOVE = 4
"""Folders above a file in which packages are looked for: that of the file is mostly PACKAGE/urdf or
PACKAGE/models/NAME.
"""


@dataclass(frozen=True)
class Packages:
    """Where packages are looked for: the `folders` that are told, each a package or a folder of
    packages, then those above the file.
    """

    file: Path
    folders: tuple[Path, ...] = ()

    def folder(self, name: str) -> Path | None:
        """The folder of a package; None where there is none."""
        return next((path for path in self._candidates(name) if path.is_dir()), None)

    def find(self, uri: str) -> Path | None:
        """The file that a robot's file names, by a package or beside itself; None where there is
        none.
        """
        tries: Iterable[Path] = [self.file.parent / uri.removeprefix("file://")]
        if uri.startswith(_SCHEMES):
            name, _, rest = uri.partition("://")[2].partition("/")
            tries = (folder / rest for folder in self._candidates(name))
        return next(filter(_is_file, tries), None)

    def written(self, uri: str) -> str:
        """The path of the file that is named, or the name as it is written where no file is
        found.
        """
        return str(self.find(uri) or uri)

    def _candidates(self, name: str) -> Iterator[Path]:
        for folder in (*self.folders, *list(self.file.resolve().parents)[:_LEVELS_ABOVE]):
            if folder.resolve().name == name:
                yield folder
            yield folder / name


def _is_file(path: Path) -> bool:
    """Whether there is such a file; names that no file can have are none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
