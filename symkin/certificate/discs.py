"""Discs: numbers known as a middle in double precision and a radius, in arrays over points;
functions of them.

Every result holds the exact results for all numbers in the operands. It is computed in C where a
compiler is found, else in NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.certificate import disc_arithmetic
from symkin.certificate.disc_library import disc_library
from symkin.certificate.tape import Code, Tape
from symkin.computed_once import cached_property


@dataclass(frozen=True, eq=False)
class Discs:
    """All numbers within `radius` (n, entries) of `middle` (n, entries): real ones if the middles
    are real.
    """

    middle: np.ndarray
    radius: np.ndarray

    @staticmethod
    def exact(middle: np.ndarray) -> Discs:
        return Discs(middle, np.zeros(middle.shape))

    @property
    def is_real(self) -> bool:
        return self.middle.dtype.kind != "c"

    def as_complex(self) -> Discs:
        return Discs(self.middle.astype(complex), self.radius) if self.is_real else self

    def beside(self, numbers: np.ndarray) -> Discs:
        """The entries, and further ones: doubles, the same in each row."""
        further = np.repeat(np.asarray(numbers, dtype=float)[None], len(self.middle), axis=0)
        return Discs(
            np.concatenate([self.middle, further], axis=1),
            np.concatenate([self.radius, np.zeros(further.shape)], axis=1),
        )

    def at(self, rows: np.ndarray) -> Discs:
        return Discs(self.middle[rows], self.radius[rows])


@dataclass(frozen=True, eq=False)
class DiscFunction:
    """A tape f(z, k), with a matrix for each of its parts, over discs of points and of
    instances.
    """

    tape: Tape

    def prepare(self, known: Discs) -> Discs:
        """What the known values (m, known) of m instances determine alone; one row where they do
        not enter.
        """
        return self._prepared(known) if self.tape.has_known else self._constant

    @cached_property
    def _constant(self) -> Discs:
        return self._prepared(
            Discs.exact(np.zeros((1, self.tape.before.inputs - len(self.tape.values))))
        )

    def _prepared(self, known: Discs) -> Discs:
        inputs = known.beside(self.tape.values)
        nothing = Discs(inputs.middle[:, :0], inputs.radius[:, :0])
        return run(self.tape.before, nothing, inputs, np.arange(len(inputs.middle)))

    def evaluate(self, part: int, z: Discs, prepared: Discs, instance: np.ndarray) -> Discs:
        """The nonzeros of a part at points z (n, width) of instances (n,)."""
        if z.is_real != prepared.is_real:
            z, prepared = z.as_complex(), prepared.as_complex()
        return run(
            self.tape.parts[part],
            z,
            prepared,
            instance if self.tape.has_known else np.zeros(len(instance)),
        )


def run(code: Code, z: Discs, known: Discs, instance: np.ndarray) -> Discs:
    """A code over points z (n, width), each with the row of `known` (m, kept) that `instance` (n,)
    names.
    """
    library = disc_library()
    chosen = np.ascontiguousarray(instance, dtype=np.intc)
    if library is not None:
        middle, radius, *own = [
            np.ascontiguousarray(a) for a in (z.middle, z.radius, known.middle, known.radius)
        ]
        return Discs(*library.run(code, middle, radius, (own[0], own[1]), chosen))
    outputs = disc_arithmetic.run(
        code, [*_columns(z), *_columns(known.at(chosen))], len(chosen), z.middle.dtype
    )
    found = Discs.exact(np.zeros((len(chosen), code.outputs), dtype=z.middle.dtype))
    for i, (m, r) in enumerate(outputs):
        found.middle[:, i], found.radius[:, i] = m, r
    return found


def _columns(discs: Discs) -> list[tuple[np.ndarray, np.ndarray]]:
    return list(zip(discs.middle.T, discs.radius.T, strict=True))
