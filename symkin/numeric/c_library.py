"""C sources to a loaded library: the compiler that there is, and a cache of what it has built.

Libraries are built for the processor at hand. Their names hold a hash of the sources, the flags and the compiler's own
macros (its version, and the instruction sets that it may use here), and one of their content: a library for another
processor is never looked up, and a damaged one is never loaded.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from symkin.computed_once import lru_cache
from symkin.numeric.cache_folder import keep, read_kept

FLAGS = ("-O2", "-std=gnu11", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-w")
"""No -ffast-math: a path that fails is seen by its NaN."""
NATIVE = "-march=native"
_LONGEST = 120.0
"""Seconds after which a compiler is given up."""


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
    compilers: Iterable[Compiler], sources: Mapping[str, str], main: str, folder: Path, *, build: bool
) -> ctypes.CDLL:
    """The library of the source file `main` among `sources` (names and texts), from `folder` or, if `build`, made and put
    there, by the first of the compilers that can. Raises CompilerError, NotBuiltError where `build` was needed."""
    tried = []
    for compiler in compilers:
        key = _key(compiler, sources, main)
        kept = _kept(folder, key)
        if kept is not None:
            return kept
        tried.append((compiler, key))
    if not build:
        raise NotBuiltError("not compiled yet")
    error = CompilerError("no C compiler was found")
    for compiler, key in tried:
        try:
            return _built(compiler, sources, main, folder, key)
        except CompilerError as reason:
            error = reason
    raise error


def find_compilers(named: str, path: str) -> Iterator[Compiler]:
    """The compiler that the environment variable CC names, else cc, gcc or clang on PATH: for this processor, then for
    any of its kind. Raises CompilerError where there is none."""
    if sys.platform == "win32":
        raise CompilerError("not used on Windows, where compilers misplace wide vectors on the stack")
    command, error, found = _command(named, path), None, False
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
    macros = _run([*command, *flags, "-dM", "-E", "-x", "c", os.devnull])
    if "__GNUC__" not in macros:
        raise CompilerError(f"{' '.join(command)} is neither GCC nor Clang")
    return Compiler(command, flags, macros)


def _command(named: str, path: str) -> tuple[str, ...]:
    if named.strip():
        try:
            return tuple(shlex.split(named))
        except ValueError as error:
            raise CompilerError(f"CC = {named!r} is not a command: {error}") from None
    found = next(filter(None, (shutil.which(name, path=path) for name in ("cc", "gcc", "clang"))), None)
    if found is None:
        raise CompilerError("no C compiler was found (cc, gcc, clang; CC may name one)")
    return (found,)


def _run(command: Sequence[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, timeout=_LONGEST, check=False, stdin=subprocess.DEVNULL)
    except (OSError, ValueError, subprocess.SubprocessError) as error:
        raise CompilerError(f"{command[0]} cannot be run: {error}") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise CompilerError(f"{command[0]} failed with status {done.returncode}{': ' + said[0] if said else ''}")
    return done.stdout.decode(errors="replace")


def _key(compiler: Compiler, sources: Mapping[str, str], main: str) -> str:
    digest = hashlib.sha256()
    parts = (part for item in sorted(sources.items()) for part in item)
    for text in (*compiler.command[1:], *compiler.flags, compiler.macros, main, *parts):
        digest.update(f"{len(text)} {text}".encode())
    return digest.hexdigest()[:32]


def _built(compiler: Compiler, sources: Mapping[str, str], main: str, folder: Path, key: str) -> ctypes.CDLL:
    """Compile in a folder of its own; load from the cache or, where nothing can be written there, from that folder."""
    try:
        with tempfile.TemporaryDirectory() as work:
            for name, text in sources.items():
                (Path(work) / name).write_text(text)
            library = Path(work) / "library.so"
            _run([*compiler.command, *compiler.flags, str(Path(work) / main), "-o", str(library), "-lm"])
            kept = keep(folder, key, ".so", library.read_bytes())
            if kept is not None:
                with suppress(OSError):
                    return _loaded(kept)
            return _loaded(library)
    except OSError as error:
        raise CompilerError(f"the compiled library is not usable: {error}") from None


def _kept(folder: Path, key: str) -> ctypes.CDLL | None:
    """A whole library of the user's own from the cache."""
    for place, _ in read_kept(folder, key, ".so"):
        with suppress(OSError):
            return _loaded(place)
    return None


def _loaded(place: Path) -> ctypes.CDLL:
    return ctypes.CDLL(str(place))
