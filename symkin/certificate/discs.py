"""Discs: numbers known as a middle in double precision and a radius, in arrays over points; functions of them.

Every result holds the exact results for all numbers in the operands. It is computed in C where a compiler is found, else in NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.certificate import disc_arithmetic
from symkin.certificate.disc_arithmetic import TINY, UNIT
from symkin.certificate.disc_library import disc_library
from symkin.certificate.tape import Code, Tape


@dataclass(frozen=True, eq=False)
class Discs:
    """All numbers within `radius` (n, entries) of `middle` (n, entries): real ones if the middles are real."""

    middle: np.ndarray
    radius: np.ndarray

    @staticmethod
    def exact(middle: np.ndarray) -> Discs:
        return Discs(middle, np.zeros(middle.shape))

    @staticmethod
    def rounded(middle: np.ndarray) -> Discs:
        """Results of one real operation each, rounded to nearest."""
        return Discs(middle, np.abs(middle) * (2.0 * UNIT) + TINY)

    @property
    def is_real(self) -> bool:
        return not np.iscomplexobj(self.middle)

    def as_complex(self) -> Discs:
        return Discs(self.middle.astype(complex), self.radius) if self.is_real else self

    def beside(self, other: Discs) -> Discs:
        """The entries of both; of `other` there may be one row for all."""
        rows = len(self.middle)
        right = [np.broadcast_to(a, (rows, a.shape[1])) for a in (other.middle, other.radius)]
        return Discs(np.hstack([self.middle, right[0]]), np.hstack([self.radius, right[1]]))

    def at(self, rows: np.ndarray) -> Discs:
        return Discs(self.middle[rows], self.radius[rows])


@dataclass(frozen=True, eq=False)
class DiscFunction:
    """A tape f(z, k), with a matrix for each of its parts, over discs of points and of instances."""

    tape: Tape

    def prepare(self, known: Discs) -> Discs:
        """What the known values (m, known) of m instances determine alone."""
        inputs = known.beside(Discs.exact(self.tape.values[None]))
        rows = np.arange(len(inputs.middle), dtype=np.intc)
        return run(self.tape.before, Discs.exact(np.zeros((len(rows), 0), dtype=inputs.middle.dtype)), inputs, rows)

    def evaluate(self, part: int, z: Discs, prepared: Discs, instance: np.ndarray) -> Discs:
        """The nonzeros of a part at points z (n, width) of instances (n,)."""
        if z.is_real != prepared.is_real:
            z, prepared = z.as_complex(), prepared.as_complex()
        return run(self.tape.parts[part], z, prepared, instance)


def run(code: Code, z: Discs, known: Discs, instance: np.ndarray) -> Discs:
    """A code over points z (n, width), each with the row of `known` (m, kept) that `instance` (n,) names."""
    library = disc_library()
    if library is not None:
        parts = [np.ascontiguousarray(a) for a in (z.middle, z.radius, known.middle, known.radius)]
        chosen = np.ascontiguousarray(instance, dtype=np.intc)
        return Discs(*library.run(code, parts[0], parts[1], (parts[2], parts[3]), chosen))
    inputs = [*_columns(z), *_columns(known.at(instance))]
    outputs = disc_arithmetic.run(code, inputs) if inputs else []
    shape = (len(instance), code.outputs)
    middle, radius = (np.array(side).T.reshape(shape) for side in zip(*outputs, strict=True)) if outputs else np.zeros((2, *shape))
    return Discs(middle.astype(z.middle.dtype), radius)


def _columns(discs: Discs) -> list[tuple[np.ndarray, np.ndarray]]:
    return list(zip(discs.middle.T, discs.radius.T, strict=True))
