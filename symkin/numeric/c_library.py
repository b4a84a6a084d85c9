"""C sources to a loaded library: the compiler that there is, and a cache of what it has built.

Libraries are built for the processor at hand. Their names hold a hash of the sources, the flags and
the compiler's own macros (its version, and the instruction sets that it may use here), and one of
their content: a library for another processor is never looked up, and a damaged one is never
loaded. What is loaded is a copy of the bytes that were checked, which nobody else can reach: a file
that is exchanged after the check is not run.
"""

from __future__ import annotations

import ctypes
import hashlib
import itertools
import logging
import os
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from symkin.computed_once import lru_cache
from symkin.numeric.cache_folder import cache_folder, discard, folder_fault, keep, read_kept

FLAGS = ("-O2", "-std=gnu11", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-w")
"""No -ffast-math: a path that fails is seen by its NaN."""
NATIVE = "-march=native"
_LONGEST_S, _ANSWERS_S = 120.0, 10.0
"""Seconds after which a compiler is given up: one that compiles, and one that is asked for its
macros.
"""
_silent: set[str] = set()
"""Compilers that were given up in this process; they are not run again."""
LANES = Path(__file__).resolve().parent / "data" / "lanes.h"
"""Vectors of numbers, which the sources of several libraries include."""
OFF = "numpy"
"""Value of the environment variable SYMKIN_ENGINE that forbids compiled code."""
LOG = logging.getLogger(__name__)
_MOST_SLASHES = 3000
"""Slashes in a path at most: a path may have 4096 characters."""


class CompilerError(Exception):
    """No library; the text says why."""


class NotBuiltError(CompilerError):
    """A library that was not to be built, and is not in the cache."""


@dataclass(frozen=True)
class Compiler:
    """A command with its flags, and the macros that it defines with them."""

    command: tuple[str, ...]
    flags: tuple[str, ...]
    macros: str


def load_library(
    compilers: Iterable[Compiler],
    sources: Mapping[str, str],
    symbols: Sequence[str],
    folder: Path,
    *,
    build: bool,
) -> ctypes.CDLL:
    """The library of the source files among `sources` (names and texts), which has the functions
    `symbols`, from the cache `folder` or, if `build`, made and put there, by the first of
    the compilers that can. Raises CompilerError, where others may write in the folder too, and
    NotBuiltError where `build` was needed.
    """
    fault = folder_fault(folder)
    if fault is not None:
        raise CompilerError(fault)
    tried = []
    for compiler in compilers:
        key = _key(compiler, sources)
        kept = _kept(folder, key, symbols)
        if kept is not None:
            return kept
        tried.append((compiler, key))
    if not build:
        raise NotBuiltError("not compiled yet")
    error = CompilerError("no C compiler was found")
    for compiler, key in tried:
        try:
            content = _compiled(compiler, sources)
            keep(folder, key, ".so", content)
            return _loaded(content, symbols)
        except CompilerError as reason:
            error = reason
    raise error


def library_of_all(paths: Sequence[Path], symbols: Sequence[str]) -> ctypes.CDLL | None:
    """The library of some sources and what they include: one for all mechanisms, from the cache or
    compiled now; None where there is none.
    """
    try:
        return load_library(
            find_compilers(os.environ.get("CC", ""), os.environ.get("PATH", "")),
            {path.name: path.read_text() for path in paths},
            symbols,
            cache_folder(),
            build=True,
        )
    except (CompilerError, OSError):
        return None


def find_compilers(named: str, path: str) -> Iterator[Compiler]:
    """The compiler that the environment variable CC names, else cc, gcc or clang on PATH: for this
    processor, then for any of its kind. Raises CompilerError where there is none.
    """
    if sys.platform == "win32":
        raise CompilerError(
            "not used on Windows, where compilers misplace wide vectors on the stack"
        )
    command, error, found = compiler_command(named, path), None, False
    for flags in ((*FLAGS, NATIVE), FLAGS):
        try:
            yield _asked(command, flags)
            found = True
        except CompilerError as reason:
            error = reason
    if not found and error is not None:
        raise error


@lru_cache(maxsize=8)
def _asked(command: tuple[str, ...], flags: tuple[str, ...]) -> Compiler:
    """Asks the compiler for its macros."""
    macros = _run([*command, *flags, "-dM", "-E", "-x", "c", os.devnull], _ANSWERS_S)
    if "__GNUC__" not in macros:
        raise CompilerError(f"{' '.join(command)} is neither GCC nor Clang")
    return Compiler(command, flags, macros)


def compiler_command(named: str, path: str) -> tuple[str, ...]:
    """The command that `named` is, else cc, gcc or clang on a path. Raises CompilerError where
    there is none.
    """
    if named.strip():
        try:
            return tuple(shlex.split(named))
        except ValueError as error:
            raise CompilerError(f"CC = {named!r} is not a command: {error}") from None
    found = next(
        filter(None, (shutil.which(name, path=path) for name in ("cc", "gcc", "clang"))), None
    )
    if found is None:
        raise CompilerError("no C compiler was found (cc, gcc, clang; CC may name one)")
    return (found,)


def _run(command: Sequence[str], longest_s: float = _LONGEST_S) -> str:
    if command[0] in _silent:
        raise CompilerError(f"{command[0]} has not answered before")
    try:
        done = subprocess.run(
            command, capture_output=True, timeout=longest_s, check=False, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        _silent.add(command[0])
        silence = f"the C compiler {command[0]} has not answered for {longest_s:g} s"
        LOG.warning("%s; what it speeds up is computed without it", silence)
        raise CompilerError(silence) from None
    except (OSError, ValueError, subprocess.SubprocessError) as error:
        raise CompilerError(f"{command[0]} cannot be run: {error}") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise CompilerError(
            f"{command[0]} failed with status {done.returncode}{': ' + said[0] if said else ''}"
        )
    return done.stdout.decode(errors="replace")


def _key(compiler: Compiler, sources: Mapping[str, str]) -> str:
    digest = hashlib.sha256()
    parts = (part for item in sorted(sources.items()) for part in item)
    for text in (*compiler.command[1:], *compiler.flags, compiler.macros, *parts):
        digest.update(f"{len(text)} {text}".encode())
    return digest.hexdigest()[:32]


def _compiled(compiler: Compiler, sources: Mapping[str, str]) -> bytes:
    """The bytes of the library, compiled in a folder of its own."""
    try:
        _refuse_open_folder(tempfile.gettempdir())
        with tempfile.TemporaryDirectory() as work:
            for name, text in sources.items():
                (Path(work) / name).write_text(text)
            library = Path(work) / "library.so"
            _run(
                [
                    *compiler.command,
                    *compiler.flags,
                    *(str(Path(work) / name) for name in sources if name.endswith(".c")),
                    "-o",
                    str(library),
                    "-lm",
                ]
            )
            return library.read_bytes()
    except OSError as error:
        raise CompilerError(f"the compiled library is not usable: {error}") from None


def _refuse_open_folder(folder: str) -> None:
    """Raise CompilerError for a folder in which others may exchange what is not theirs; that of all
    users, where they may not (its sticky bit), is a good one.
    """
    about = os.stat(folder)
    if about.st_mode & stat.S_IWOTH and not about.st_mode & stat.S_ISVTX and hasattr(os, "getuid"):
        raise CompilerError(
            f"everybody may exchange files in the temporary folder {folder}; TMPDIR may name "
            f"another one"
        )


def _kept(folder: Path, key: str, symbols: Sequence[str]) -> ctypes.CDLL | None:
    """A whole library of the user's own from the cache; one that cannot be loaded, or lacks a
    function, is removed.
    """
    for place, content in read_kept(folder, key, ".so"):
        try:
            return _loaded(content, symbols)
        except CompilerError:
            discard(place)
    return None


def _loaded(content: bytes, symbols: Sequence[str]) -> ctypes.CDLL:
    """The library of some bytes, from a copy in memory, or in a temporary file where the system has
    no such copies. Raises CompilerError for one that cannot be loaded or lacks a function.
    """
    error: OSError | None = None
    for copied in (_in_memory, _in_a_file):
        try:
            with copied(content) as path:
                library = ctypes.CDLL(path)
        except OSError as reason:
            error = reason
            continue
        missing = next((name for name in symbols if not hasattr(library, name)), None)
        if missing is not None:
            raise CompilerError(f"the compiled library is not usable: it has no function {missing}")
        return library
    raise CompilerError(f"the compiled library is not usable: {error}")


_copies = itertools.count()


@contextmanager
def _in_memory(content: bytes) -> Iterator[str]:
    """The path of a file in memory that has no name. The path is another one each time (the loader
    takes paths that it knows for libraries that it has): the number of slashes tells copies apart.
    """
    if not hasattr(os, "memfd_create"):
        raise OSError("no files in memory here")
    handle = os.memfd_create("symkin", os.MFD_CLOEXEC)
    try:
        with os.fdopen(os.dup(handle), "wb") as file:
            file.write(content)
        yield f"/proc/self/fd/{'/' * (next(_copies) % _MOST_SLASHES)}{handle}"
    finally:
        os.close(handle)


@contextmanager
def _in_a_file(content: bytes) -> Iterator[str]:
    """The path of a temporary file that only the user may read and write."""
    _refuse_open_folder(tempfile.gettempdir())
    handle, path = tempfile.mkstemp(suffix=".so")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        yield path
    finally:
        discard(Path(path))
