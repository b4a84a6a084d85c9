"""CasADi functions of vectors, evaluated at many points in few calls and without conversions.

A call of a CasADi function from Python costs some 30 us, most of it for turning arrays into
CasADi's matrices and back; a call on a buffer costs 1 us. Points are taken in blocks of 256, 128,
..., 1, each by the function mapped to so many points, so that no evaluation is wasted and one point
costs one evaluation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.computed_once import cached_property
from symkin.locks import Pool
from symkin.numeric.shared_library import MANY, PointTape, shared_library

_LARGEST_BLOCK = 256
"""Points of the largest block; its inputs and outputs stay in the second level of the cache."""
_LARGE, _SPARSE = 1024, 0.25
"""Numbers of a result, and share of them that are no constant zeros, from and up to which the zeros
are left out: of a Jacobian of many loops most of an evaluation would be writing them.
"""


@dataclass(frozen=True, eq=False)
class Mapped:
    """A CasADi function of vectors at many points: each argument and each result has the points
    along its first axis. Of results that are nearly empty the function tells the nonzeros, which
    stand at `places`, column by column, in a matrix of their shape.
    """

    function: ca.Function
    shapes: tuple[tuple[int, int], ...]
    places: tuple[np.ndarray | None, ...]

    @staticmethod
    def of(arguments: Sequence[ca.SX], results: Sequence[ca.SX], *, common: bool = True) -> Mapped:
        """The function of symbols (columns) with some expressions as its results, `common` parts
        computed once.
        """
        results = [ca.SX(r) for r in results]
        places = tuple(
            np.array(r.sparsity().find(), dtype=int) if _is_nearly_empty(r) else None
            for r in results
        )
        told = [
            ca.densify(r) if place is None else ca.vertcat(ca.SX(0, 1), *r.nonzeros())
            for r, place in zip(results, places, strict=True)
        ]
        function = ca.Function("mapped", list(arguments), told, {"cse": common})
        return Mapped(function, tuple(r.shape for r in results), places)

    def __call__(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Results (n, rows, columns) at arguments (n, length); an argument (length,) is that of all
        points.
        """
        count = max((len(argument) for argument in arguments if argument.ndim == 2), default=1)
        told = [np.empty((count, *shape)) for shape in self._shapes]
        begin, library = 0, shared_library() if count >= MANY else None
        if library is not None and self._tape is not None:
            library.evaluate(self._tape, arguments, told)
            begin = count
        while begin < count:
            size = min(_LARGEST_BLOCK, 1 << (count - begin).bit_length() - 1)
            self._blocks[size].evaluate(arguments, told, begin)
            begin += size
        results = zip(told, self.shapes, self.places, strict=True)
        return [
            (numbers if places is None else _whole(numbers, shape, places)).transpose(0, 2, 1)
            for numbers, shape, places in results
        ]

    @cached_property
    def _shapes(self) -> list[tuple[int, int]]:
        return [self.function.size_out(i)[::-1] for i in range(self.function.n_out())]

    @cached_property
    def _tape(self) -> PointTape | None:
        return PointTape.of(self.function)

    @cached_property
    def _blocks(self) -> dict[int, _Block]:
        sizes = [1 << i for i in range(_LARGEST_BLOCK.bit_length())]
        return {size: _Block(self.function, size) for size in sizes}


def _is_nearly_empty(result: ca.SX) -> bool:
    return result.numel() >= _LARGE and result.nnz() <= _SPARSE * result.numel()


def _whole(numbers: np.ndarray, shape: tuple[int, int], places: np.ndarray) -> np.ndarray:
    """Matrices (n, columns, rows) of their nonzeros (n, 1, nonzeros)."""
    rows, columns = shape
    found = np.zeros((len(numbers), columns * rows))
    found[:, places] = numbers[:, 0]
    return found.reshape(-1, columns, rows)


class _Block:
    """A function at a fixed number of points; as many threads as ask may use it at once, each with
    buffers of its own.
    """

    def __init__(self, function: ca.Function, size: int) -> None:
        self.function, self.size = function, size
        self._pool: Pool[_Buffers] = Pool(self._make)

    def evaluate(
        self, arguments: Sequence[np.ndarray], results: Sequence[np.ndarray], begin: int
    ) -> None:
        """Fill results[i][begin : begin + size]."""
        end, buffers = begin + self.size, self._pool.take()
        for inside, argument in zip(buffers.inside, arguments, strict=True):
            inside[:] = argument[begin:end] if argument.ndim == 2 else argument
        buffers.call()
        for outside, result in zip(buffers.outside, results, strict=True):
            result[begin:end] = outside
        self._pool.give(buffers)

    @cached_property
    def _mapped(self) -> ca.Function:
        return self.function if self.size == 1 else self.function.map(self.size)

    def _make(self) -> _Buffers:
        f, mapped = self.function, self._mapped
        inside = [np.zeros((self.size, f.numel_in(i))) for i in range(f.n_in())]
        outside = [np.zeros((self.size, f.size2_out(i), f.size1_out(i))) for i in range(f.n_out())]
        buffer, call = mapped.buffer()
        for i, array in enumerate(inside):
            buffer.set_arg(i, array.reshape(-1).data)
        for i, array in enumerate(outside):
            buffer.set_res(i, array.reshape(-1).data)
        return _Buffers(mapped, buffer, call, inside, outside)


@dataclass(frozen=True, eq=False)
class _Buffers:
    """Inputs and outputs (column by column) of one call; `buffer` points into them."""

    mapped: ca.Function
    buffer: object
    call: Callable[[], None]
    inside: list[np.ndarray]
    outside: list[np.ndarray]
