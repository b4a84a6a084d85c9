"""The user's cache folder: starts and compiled closures of his own mechanisms.

A file's name ends in a digest of its content, and only whole files of the user's own are read: one
that was cut short, changed, or put there by somebody else is taken for missing. A folder in which
others may write is not used at all: they could exchange one file of the user for another. Processes
may share a folder: files appear at once or not at all, and one that disappears is made anew. The
folder is bounded: when it has grown beyond its size, the files that were not used for longest are
removed.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.regular_file import open_regular

SIZE = 500.0
"""Megabytes that the folder may hold, unless SYMKIN_CACHE_SIZE says otherwise."""
_KEPT = 0.8
"""Share of the size that is left when files are removed, so that this does not happen at every
writing.
"""
_ABANDONED = 3600.0
"""Seconds after which an unfinished file belongs to no process that still writes it."""
_USED = 3600.0
"""Seconds between two notes of a file's use."""
_MINE = (".npz", ".so")


def cache_folder() -> Path:
    """SYMKIN_CACHE, else the platform's folder for caches."""
    return _folder(os.environ.get("SYMKIN_CACHE", ""))


@lru_cache(maxsize=8)
def _folder(named: str) -> Path:
    """The folder for a value of the environment."""
    if named:
        return Path(named)
    from platformdirs import user_cache_path

    return Path(user_cache_path("symkin"))


def cache_size() -> float:
    """Bytes that the folder may hold. Raises InputError where SYMKIN_CACHE_SIZE is no number of
    megabytes.
    """
    named = os.environ.get("SYMKIN_CACHE_SIZE", "").strip()
    try:
        size = float(named) if named else SIZE
    except ValueError:
        size = -1.0
    if not size >= 0.0:
        raise InputError(
            f"SYMKIN_CACHE_SIZE = {named!r} is unknown; allowed: a number of megabytes from 0"
        )
    return size * 1e6


def folder_fault(folder: Path) -> str | None:
    """Why a folder is not used: somebody else may write in it. None where that is not so, or there
    is no such folder yet.
    """
    try:
        return _fault_of(folder, folder.stat())
    except OSError:
        return None


def _fault_of(folder: Path, about: os.stat_result) -> str | None:
    """Access of other kinds (lists) shows in the group's bits, or needs the owner."""
    if not hasattr(os, "getuid"):
        return None
    if about.st_uid not in (0, os.getuid()):
        return (
            f"{folder} belongs to another user, who may exchange what is in it; SYMKIN_CACHE may "
            f"name a folder of your own"
        )
    if about.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return (
            f"others may write in {folder}, and exchange what is in it; SYMKIN_CACHE may name a "
            f"folder of your own (chmod go-w "
            "closes this one)"
        )
    return None


@contextmanager
def _opened(folder: Path) -> Iterator[int | None]:
    """The open folder, so that it stays the one that was checked; None on systems without such
    handles. Raises OSError for one that is not there or not used.
    """
    if os.open not in os.supports_dir_fd:
        yield None
        return
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fault = _fault_of(folder, os.fstat(handle))
        if fault is not None:
            raise PermissionError(fault)
        yield handle
    finally:
        os.close(handle)


def read_kept(folder: Path, key: str, suffix: str) -> list[tuple[Path, bytes]]:
    """Whole files of the user's own that are kept under a key, with their contents; none of a
    folder in which others may write.
    """
    found = []
    with suppress(OSError), _opened(folder) as within:
        names = os.listdir(folder if within is None else within)
        for name in sorted(
            name for name in names if name.startswith(f"{key}-") and name.endswith(suffix)
        ):
            content = _own_file(folder / name if within is None else name, within)
            if content is None:
                continue
            if name == _name(key, content, suffix):
                _note_use(folder / name)
                found.append((folder / name, content))
            else:
                discard(folder / name)
    return found


def keep(folder: Path, key: str, suffix: str, content: bytes) -> Path | None:
    """Put a file into the folder, at once or not at all; None where that cannot be done, or others
    may write there. Of a folder that is full the files not used for longest go.
    """
    size = cache_size()
    if len(content) > size:
        return None
    place, part = folder / _name(key, content, suffix), None
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if folder_fault(folder) is not None:
            return None
        handle, part = tempfile.mkstemp(dir=folder, suffix=".part")
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(part, place)
    except OSError:
        if part is not None:
            discard(Path(part))
        return None
    _bound(folder, size, place)
    return place


def _name(key: str, content: bytes, suffix: str) -> str:
    return f"{key}-{hashlib.sha256(content).hexdigest()[:16]}{suffix}"


def _own_file(place: Path | str, within: int | None) -> bytes | None:
    """The content of a regular file that only the user may write, not of one that a link leads
    to.
    """
    with suppress(OSError), open_regular(place, follow=False, within=within) as file:
        return file.read() if is_own(os.fstat(file.fileno())) else None
    return None


def is_own(about: os.stat_result) -> bool:
    """Whether a file is the user's, and nobody else may write it."""
    return not hasattr(os, "getuid") or (
        about.st_uid == os.getuid() and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    )


def _note_use(place: Path) -> None:
    """The file's time is that of its last use, to the hour: what is removed first is what was not
    used for longest.
    """
    with suppress(OSError):
        if time.time() - place.stat().st_mtime > _USED:
            os.utime(place)


def _bound(folder: Path, size: float, new: Path) -> None:
    """Remove what other processes left unfinished and, of a folder that is too large, files by
    their last use. Files of other kinds, and of other users, are left alone.
    """
    files, total, now = [], 0, time.time()
    with suppress(OSError):
        for place in folder.iterdir():
            about = _about(place)
            if about is None:
                continue
            if place.suffix == ".part" and now - about.st_mtime > _ABANDONED:
                discard(place)
            elif place.suffix in _MINE:
                files.append((about.st_mtime, about.st_size, place))
                total += about.st_size
    if total <= size:
        return
    for _, length, place in sorted(files):
        if total <= _KEPT * size:
            return
        if place != new:
            discard(place)
            total -= length


def _about(place: Path) -> os.stat_result | None:
    """What is known of a regular file of the user's own."""
    with suppress(OSError):
        about = place.lstat()
        if stat.S_ISREG(about.st_mode) and (
            not hasattr(os, "getuid") or about.st_uid == os.getuid()
        ):
            return about
    return None


def discard(place: Path) -> None:
    """Remove a file, if it is there and may be removed."""
    with suppress(OSError):
        place.unlink()
