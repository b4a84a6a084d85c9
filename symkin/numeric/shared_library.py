"""Functions and extreme singular values at many points, discs and Krawczyk's test in C, where a
compiler is found: one library for all mechanisms (see `data/points.c` and `data/certificate.c`).

Values have the digits that CasADi computes. SYMKIN_ENGINE = numpy turns it off.
"""

from __future__ import annotations

import ctypes
import functools
import os
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import instructions
from symkin.computed_once import lru_cache
from symkin.numeric.c_library import LANES, OFF, library_of_all
from symkin.numeric.tape import Code, Tape

MANY = 256
"""Points from which on a tape is evaluated: to write it takes as long as CasADi takes for these."""
_MOST_COLUMNS = 8
"""MOST of points.c."""
_INPUT, _CONSTANT, _OUTPUT = range(3)
_OPERATIONS = {
    operation: place
    for place, operation in enumerate(
        (
            *(ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_DIV, ca.OP_SQ, ca.OP_NEG, ca.OP_TWICE),
            *(ca.OP_INV, ca.OP_SIN, ca.OP_COS, ca.OP_SQRT, ca.OP_FABS, ca.OP_FMAX, ca.OP_ATAN2),
        ),
        start=3,
    )
}
"""The operations of points.c, whose numbers follow those of input, constant and output."""


@dataclass(frozen=True, eq=False)
class PointTape:
    """Instructions (length, 4) of a function of arguments of some `widths` as points.c reads them,
    with their constants.
    """

    widths: tuple[int, ...]
    instructions: np.ndarray
    constants: np.ndarray
    places: int

    @staticmethod
    def of(function: ca.Function) -> PointTape | None:
        """The tape of a function of dense arguments and results; None where it has an operation
        that points.c has not.
        """
        lines, constants = [], list[float]()
        for op, i, o, constant in instructions(function):
            if op == ca.OP_INPUT:
                lines.append((_INPUT, o[0], i[0], i[1]))
            elif op == ca.OP_OUTPUT:
                lines.append((_OUTPUT, i[0], o[0], o[1]))
            elif op == ca.OP_CONST:
                lines.append((_CONSTANT, o[0], len(constants), 0))
                constants.append(constant)
            elif op in _OPERATIONS:
                lines.append((_OPERATIONS[op], o[0], i[0], i[-1]))
            else:
                return None
        tape = np.array(lines, dtype=np.intc).reshape(-1, 4)
        places = 1 + int(tape[:, 1].max(initial=0))
        widths = tuple(function.numel_in(i) for i in range(function.n_in()))
        return PointTape(widths, tape, np.array(constants, dtype=float), places)


class _Code(ctypes.Structure):
    """`struct code` of certificate.c."""

    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("instructions", "constants")),
        *((name, ctypes.c_int) for name in ("length", "places", "outputs")),
    ]


class _Problem(ctypes.Structure):
    """`struct problem` of certificate.c."""

    _fields_ = [
        *((name, _Code) for name in ("value", "slope", "before")),
        *((name, ctypes.c_void_p) for name in ("row", "column", "values")),
        *((name, ctypes.c_int) for name in ("width", "count")),
    ]


class SharedLibrary:
    """The functions of points.c and certificate.c. Arrays of discs are in one piece, of doubles or
    complex numbers, all of one kind.
    """

    def __init__(self, library: ctypes.CDLL) -> None:
        pointer, number, long = ctypes.c_void_p, ctypes.c_int, ctypes.c_longlong
        self._evaluate, self._extremes = library.symkin_evaluate, library.symkin_extremes
        self._evaluate.argtypes = [long, pointer, number, pointer, number, pointer, pointer]
        self._evaluate.restype = number
        self._extremes.argtypes = [long, number, number, *[pointer] * 3]
        self._extremes.restype = None
        self._run, self._enclose = library.symkin_run, library.symkin_enclose
        self._run.argtypes = [number, number, number, number, *[pointer] * 8]
        counts, arrays = [number] * 3, [pointer] * 5
        self._enclose.argtypes = [number, number, pointer, *counts, *arrays, ctypes.c_double]
        self._enclose.argtypes += [pointer, pointer]
        self._run.restype = self._enclose.restype = number

    def evaluate(
        self, tape: PointTape, arguments: Sequence[np.ndarray], results: Sequence[np.ndarray]
    ) -> None:
        """Fill results (n, ...) by a tape at arguments (n, length), or (length,) of all points.
        Raises ValueError for others, of which C would read what is not theirs.
        """
        for a, width in zip(arguments, tape.widths, strict=True):
            if a.shape not in ((width,), (len(results[0]), width)):
                raise ValueError(f"an argument of shape {a.shape} for {width} numbers a point")
        own = [np.ascontiguousarray(a, dtype=float) for a in arguments]
        read, filled = _arrays(own), _arrays(results)
        if not self._evaluate(
            len(results[0]),
            tape.instructions.ctypes.data,
            len(tape.instructions),
            tape.constants.ctypes.data,
            tape.places,
            begin_of(read),
            begin_of(filled),
        ):
            raise MemoryError

    def squared_extremes(self, matrices: np.ndarray) -> np.ndarray:
        """Squares (n, 2) of the largest and smallest singular values of matrices (n, rows,
        columns), for which it is a `library_of_extremes`.
        """
        matrices = np.asarray(matrices, dtype=float)
        if matrices.shape[1] < matrices.shape[2]:
            matrices = matrices.transpose(0, 2, 1)
        count, rows, columns = matrices.shape
        found, data = np.empty((count, 2)), matrices.ctypes.data
        strides = (ctypes.c_longlong * 3)(*(s // matrices.itemsize for s in matrices.strides))
        self._extremes(count, rows, columns, data, strides, begin_of(found))
        return found

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
        """One Newton step from z (n, width), at discs `known` (m, known) of their `instance` (n,),
        and half widths (n,) of boxes about where it leads that hold one root each.
        """
        n = len(z)
        centre, half = np.empty(z.shape, dtype=z.dtype), np.empty(n)
        arrays = [begin_of(a) for a in (z, patch, *known, instance)]
        problem = ctypes.byref(_problem_of(tape))
        parts = [1 + (of.dtype.kind == "c") for of in (z, known[0])]
        ends = begin_of(centre), begin_of(half)
        if not self._enclose(*parts, problem, n, *known[0].shape, *arrays, wide, *ends):
            raise MemoryError
        return centre, half


def begin_of(array: np.ndarray) -> Any:
    """Where an array begins, None for an empty one: three times as fast as its own `ctypes.data`,
    where it may be written to.
    """
    if not array.size:
        return None
    try:
        return ctypes.byref(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        if array.flags.writeable:
            raise  # it is not in one piece
        return array.ctypes.data


def _arrays(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """`struct array` of points.c for each of some arrays: where it begins, and its stride."""
    return np.array(
        [[a.ctypes.data, 0 if a.ndim == 1 else a.strides[0] // a.itemsize] for a in arrays],
        dtype=np.int64,
    )


def shared_library() -> SharedLibrary | None:
    """The library, from the cache or compiled now; None where there is none."""
    return None if os.environ.get("SYMKIN_ENGINE") == OFF else _loaded()


def library_of_extremes(matrices: np.ndarray) -> SharedLibrary | None:
    """The library, where it finds the extreme singular values of matrices (n, rows, columns)."""
    return shared_library() if min(matrices.shape[1:]) <= _MOST_COLUMNS else None


def begin_loading() -> None:
    """Compile the library in a thread of its own, where that is to be done, while other things are:
    whoever asks for it waits.
    """
    if os.environ.get("SYMKIN_ENGINE") != OFF and not _loaded.cache_info().currsize:
        threading.Thread(target=_loaded).start()


@functools.lru_cache(maxsize=1)
def _loaded() -> SharedLibrary | None:
    return _load()


@lru_cache(maxsize=1)
def _load() -> SharedLibrary | None:
    """What was found at the first call, for good."""
    names = "points.c", "certificate.c", "discs.h", "krawczyk.h"
    symbols = "symkin_evaluate", "symkin_extremes", "symkin_run", "symkin_enclose"
    library = library_of_all([LANES, *map(LANES.with_name, names)], symbols)
    return None if library is None else SharedLibrary(library)


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
    codes = map(_struct_of, (*tape.parts, tape.before))
    arrays = (array.ctypes.data for array in (*tape.patterns[1], tape.values))
    return _Problem(*codes, *arrays, tape.width, len(tape.values))
