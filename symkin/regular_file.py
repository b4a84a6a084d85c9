"""Open regular files only: a FIFO or a device in a file's place neither blocks nor never ends."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

from symkin.errors import InputError
from symkin.text import meant


def open_regular(path: Path | str, *, follow: bool = True, within: int | None = None) -> BinaryIO:
    """Open a regular file for reading, unless `follow` no symbolic link in its place; `within` is
    the open folder of a relative path. Raises OSError for anything else.
    """
    flags = ("O_NONBLOCK", "O_BINARY", "O_CLOEXEC", *(() if follow else ("O_NOFOLLOW",)))
    handle = os.open(path, os.O_RDONLY | sum(getattr(os, flag, 0) for flag in flags), dir_fd=within)
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(handle, "rb")
    os.close(handle)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    raise OSError(errno.EINVAL, "it is no regular file")


def content_of(path: Path | str, most: int = -1) -> bytes:
    """The bytes of a file that a user names, at most `most` of them. Raises InputError, for a file
    that is not there with the one of its folder whose name is most like it.
    """
    try:
        with open_regular(path) as file:
            return file.read(most)
    except FileNotFoundError:
        named, folder = Path(path), Path(path).parent
        files = folder.iterdir() if folder.is_dir() else ()
        beside = [file.stem for file in files if file.suffix == named.suffix]
        guess = meant(named.stem, beside, named.suffix)  # a suffix makes any two names alike
        raise InputError(f"{path}: there is no such file{guess}") from None
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path}: the file cannot be read ({getattr(error, 'strerror', None) or error})"
        ) from None
