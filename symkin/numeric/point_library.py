"""Functions and extreme singular values at many points in C, where a compiler is found: one library
for all mechanisms (see `data/points.c`).

Values have the digits that CasADi computes. SYMKIN_ENGINE = numpy turns it off.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import instructions
from symkin.computed_once import lru_cache
from symkin.numeric.c_library import LANES, OFF, begin_of, library_of_all

MANY = 256
"""Points from which on a tape is evaluated: to write it takes as long as CasADi takes for these."""
_MANY_MATRICES = 64
"""Matrices from which on the library is asked for their extreme singular values."""
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


class PointLibrary:
    """The functions of points.c."""

    def __init__(self, library: ctypes.CDLL) -> None:
        pointer, number, long = ctypes.c_void_p, ctypes.c_int, ctypes.c_longlong
        self._evaluate, self._extremes = library.symkin_evaluate, library.symkin_extremes
        self._evaluate.argtypes = [long, pointer, number, pointer, number, pointer, pointer]
        self._evaluate.restype = number
        self._extremes.argtypes = [long, number, number, *[pointer] * 3]
        self._extremes.restype = None

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
        found, strides = np.empty((count, 2)), np.array(matrices.strides) // matrices.itemsize
        data, own = matrices.__array_interface__["data"][0], strides.ctypes.data
        self._extremes(count, rows, columns, data, own, begin_of(found))
        return found


def _arrays(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """`struct array` of points.c for each of some arrays: where it begins, and its stride."""
    return np.array(
        [[a.ctypes.data, 0 if a.ndim == 1 else a.strides[0] // a.itemsize] for a in arrays],
        dtype=np.int64,
    )


def point_library() -> PointLibrary | None:
    """The library, from the cache or compiled now; None where there is none."""
    return None if os.environ.get("SYMKIN_ENGINE") == OFF else _load()


def library_of_extremes(matrices: np.ndarray) -> PointLibrary | None:
    """The library, where it finds the extreme singular values of matrices (n, rows, columns)."""
    suit = len(matrices) >= _MANY_MATRICES and min(matrices.shape[1:]) <= _MOST_COLUMNS
    return point_library() if suit else None


@lru_cache(maxsize=1)
def _load() -> PointLibrary | None:
    """What was found at the first call, for good."""
    sources = (LANES.with_name("points.c"), LANES)
    library = library_of_all(sources, ("symkin_evaluate", "symkin_extremes"))
    return None if library is None else PointLibrary(library)
