"""Writing what a user asked for: a regular file whole or not at all, through symbolic links, into
devices and pipes as they are.
"""

from __future__ import annotations

import io
import os
import stat
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from symkin.errors import InputError


def write_output(path: str | Path, content: str | bytes | Iterable[str]) -> None:
    """Write a file, text as UTF-8, pieces as they come. A regular file is replaced once all is
    written, and keeps its permissions; a symbolic link stays one, and what it leads to is written;
    a device, a pipe or this process's own output is written into. Raises InputError.
    """
    whole = [content] if isinstance(content, str | bytes) else content
    data = (
        piece.encode("utf-8", "backslashreplace") if isinstance(piece, str) else piece
        for piece in whole
    )
    try:
        there = _status(path)
        if there is None or (stat.S_ISREG(there.st_mode) and not _is_own_output(there)):
            _replace(Path(os.path.realpath(path)), data, there)
        else:
            _write_into(path, data, there)
    except OSError as error:
        raise InputError(f"{path}: the file cannot be written ({error.strerror})") from None


def check_output(
    path: str | Path, suffixes: Sequence[str], verb: str, reads: str | Path = ""
) -> None:
    """Refuse, before the work, an output of a suffix that a verb does not write, one that cannot be
    written, and one that would replace what is read. Raises InputError.
    """
    output = Path(path)
    if output.suffix.lower() not in suffixes:
        raise InputError(
            f"output {str(path)!r} has another suffix than {', '.join(suffixes)}, which {verb} "
            f"writes"
        )
    check_place(output, reads)


def check_place(output: Path, *reads: str | Path | None) -> None:
    """Refuse, before the work, an output that cannot be written, and one that would replace what is
    read. Raises InputError.
    """
    if output.is_dir() or not output.resolve().parent.is_dir():
        raise InputError(
            f"output {str(output)!r} is a folder, or its folder does not exist; the name of a file "
            f"is needed"
        )
    files = [Path(given) for given in reads if given and Path(given).exists()]
    if output.exists() and any(os.path.samefile(output, file) for file in files):
        raise InputError(f"output {str(output)!r} is read by this command; give another name")


def _status(path: str | Path) -> os.stat_result | None:
    """What the path leads to; None where there is nothing yet."""
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _is_own_output(there: os.stat_result) -> bool:
    """Whether the file is where this process's standard output goes, as /dev/stdout is."""
    try:
        return os.path.samestat(there, os.fstat(1))
    except OSError:
        return False


def _write_into(path: str | Path, data: Iterable[bytes], there: os.stat_result) -> None:
    """Write into what is there: nothing is made, cut off or replaced."""
    if sys.stdout is not None:
        sys.stdout.flush()
    with os.fdopen(
        os.dup(1) if _is_own_output(there) else os.open(path, os.O_WRONLY), "wb"
    ) as file:
        file.writelines(data)


def _replace(target: Path, data: Iterable[bytes], there: os.stat_result | None) -> None:
    """Write under a temporary name beside the file, then in its place; into a file whose folder
    takes no new ones.
    """
    if there is not None and not os.access(target.parent, os.W_OK):
        _overwrite(target, b"".join(data))
        return
    temporary = target.parent / f"{f'.{target.name}'[:100]}.{os.urandom(8).hex()}"
    try:
        with temporary.open("xb") as file:
            file.writelines(data)
        if there is not None:
            os.chmod(temporary, stat.S_IMODE(there.st_mode))
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _overwrite(target: Path, data: bytes) -> None:
    """Write over what a file holds, first what goes beyond its end: where a full disk does not take
    that, the file stays as it was.
    """
    with target.open("r+b", buffering=0) as file:
        length = file.seek(0, os.SEEK_END)
        try:
            _write_all(file, data[length:])
            os.fsync(file.fileno())
        except OSError:
            file.truncate(length)
            raise
        file.seek(0)
        _write_all(file, data[:length])
        file.truncate(len(data))


def _write_all(file: io.RawIOBase, data: bytes) -> None:
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]
