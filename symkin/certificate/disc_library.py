"""Discs and Krawczyk's test in C, where a compiler is found: one library for all mechanisms (see
`data/certificate.c`).

SYMKIN_ENGINE = numpy turns it off.
"""

from __future__ import annotations

import ctypes
import functools
import os
import threading
from pathlib import Path

import numpy as np

from symkin.computed_once import lru_cache
from symkin.numeric.c_library import LANES, OFF, begin_of, library_of_all
from symkin.numeric.tape import Code, Tape

_DATA = Path(__file__).resolve().parent / "data"
_SOURCES = (*(_DATA / name for name in ("certificate.c", "discs.h", "krawczyk.h")), LANES)


class _Code(ctypes.Structure):
    """`struct code` of certificate.c."""

    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("instructions", "constants")),
        *((name, ctypes.c_int) for name in ("length", "places", "outputs")),
    ]


class _Problem(ctypes.Structure):
    """`struct problem` of certificate.c."""

    _fields_ = [
        *((name, _Code) for name in ("value", "slope")),
        *((name, ctypes.c_void_p) for name in ("row", "column")),
        *((name, ctypes.c_int) for name in ("width", "kept")),
    ]


class DiscLibrary:
    """The functions of certificate.c. Arrays are in one piece, of doubles or complex numbers, all
    of one kind.
    """

    def __init__(self, library: ctypes.CDLL) -> None:
        pointer, number = ctypes.c_void_p, ctypes.c_int
        self._run, self._enclose = library.symkin_run, library.symkin_enclose
        self._run.argtypes = [number, number, number, number, *[pointer] * 8]
        self._enclose.argtypes = [
            number,
            pointer,
            number,
            *[pointer] * 5,
            ctypes.c_double,
            pointer,
            pointer,
        ]
        self._run.restype = self._enclose.restype = number

    def run(
        self,
        code: Code,
        z: np.ndarray,
        radii: np.ndarray,
        known: tuple[np.ndarray, np.ndarray],
        instance: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """A code at discs z, radii (n, width) with discs `known` (m, kept), of each point those of
        its `instance` (n,).
        """
        n, width = z.shape
        middle, radius = np.empty((n, code.outputs), dtype=z.dtype), np.empty((n, code.outputs))
        arrays = [begin_of(a) for a in (z, radii, *known, instance, middle, radius)]
        if not self._run(
            z.dtype.kind == "c",
            n,
            width,
            known[0].shape[1],
            ctypes.byref(_struct_of(code)),
            *arrays,
        ):
            raise MemoryError
        return middle, radius

    def enclose(
        self,
        tape: Tape,
        z: np.ndarray,
        patch: np.ndarray,
        known: tuple[np.ndarray, np.ndarray],
        instance: np.ndarray,
        wide: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """One Newton step from z (n, width), and half widths (n,) of boxes about where it leads
        that hold one root each.
        """
        n = len(z)
        centre, half = np.empty(z.shape, dtype=z.dtype), np.empty(n)
        arrays = [begin_of(a) for a in (z, patch, *known, instance)]
        problem = ctypes.byref(_problem_of(tape))
        if not self._enclose(
            z.dtype.kind == "c", problem, n, *arrays, wide, begin_of(centre), begin_of(half)
        ):
            raise MemoryError
        return centre, half


def disc_library() -> DiscLibrary | None:
    """The library, from the cache or compiled now; None where there is none."""
    return None if os.environ.get("SYMKIN_ENGINE") == OFF else _loaded()


def begin_loading() -> None:
    """Compile the library in a thread of its own, where that is to be done, while other things are:
    whoever asks for it waits.
    """
    if os.environ.get("SYMKIN_ENGINE") != OFF and not _loaded.cache_info().currsize:
        threading.Thread(target=_loaded).start()


@functools.lru_cache(maxsize=1)
def _loaded() -> DiscLibrary | None:
    return _load()


@lru_cache(maxsize=1)
def _load() -> DiscLibrary | None:
    """What was found at the first call, for good."""
    library = library_of_all(_SOURCES, ("symkin_run", "symkin_enclose"))
    return None if library is None else DiscLibrary(library)


# Two threads may make these twice, which does no harm; they are asked for at every call.


@functools.lru_cache(maxsize=512)
def _struct_of(code: Code) -> _Code:
    return _Code(
        code.instructions.ctypes.data,
        code.constants.ctypes.data,
        len(code.instructions),
        code.places,
        code.outputs,
    )


@functools.lru_cache(maxsize=128)
def _problem_of(tape: Tape) -> _Problem:
    rows, columns = tape.patterns[1]
    value, slope = (_struct_of(code) for code in tape.parts)
    return _Problem(
        value, slope, rows.ctypes.data, columns.ctypes.data, tape.width, tape.before.outputs
    )
