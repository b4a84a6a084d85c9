"""Discs: numbers known as a middle in double precision and a radius, in arrays over points;
functions of them; known values of many instances, as discs for the quick test and as balls for what
it leaves open.

Every result holds the exact results for all numbers in the operands. It is computed in C where a
compiler is found, else in NumPy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from flint import acb, arb

from symkin.certificate.disc_arithmetic import UP, balls_about, disc_about
from symkin.computed_once import cached_property
from symkin.numeric import balls
from symkin.numeric.balls import COMPLEX, REAL, Number, precision
from symkin.numeric.shared_library import shared_library
from symkin.numeric.tape import Code, Tape


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
        n, own = self.middle.shape
        middle = np.empty((n, own + len(numbers)), dtype=self.middle.dtype)
        radius = np.zeros(middle.shape)
        middle[:, :own], middle[:, own:], radius[:, :own] = self.middle, numbers, self.radius
        return Discs(middle, radius)

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
        # all that the code reads stands among the entries of its points
        return run(self.tape.before, inputs, inputs, np.arange(len(inputs.middle)))

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
    library = shared_library()
    chosen = np.ascontiguousarray(instance, dtype=np.intc)
    if library is not None:
        middle, radius, *own = [
            np.ascontiguousarray(a) for a in (z.middle, z.radius, known.middle, known.radius)
        ]
        return Discs(*library.run(code, middle, radius, (own[0], own[1]), chosen))
    ring, held = REAL if z.is_real else COMPLEX, dict[int, list[Number]]()
    found = Discs.exact(np.zeros((len(chosen), code.outputs), dtype=z.middle.dtype))
    with precision(_DISC_BITS):
        for i, j in enumerate(chosen.tolist()):
            if j not in held:
                held[j] = balls_about(known.middle[j], known.radius[j])
            inputs = balls_about(z.middle[i], z.radius[i]) + held[j]
            told = [disc_about(ball) for ball in balls.run(code, inputs, ring)]
            found.middle[i], found.radius[i] = zip(*told, strict=True) if told else ([], [])
    return found


_BITS, _DISC_BITS = 128, 64
"""Precision of known values, and of balls in place of discs: more than a double has."""


@dataclass(frozen=True, eq=False)
class Knowns:
    """Known values of instances 0, 1, ...: discs (m, known), and the same values of one instance as
    numbers, balls where they are not doubles.
    """

    discs: Discs
    numbers: Callable[[int], tuple[Number, ...]]

    @property
    def count(self) -> int:
        """Instances."""
        return len(self.discs.middle)

    def beside(self, numbers: Sequence[float]) -> Knowns:
        """With further doubles behind, the same in each instance."""
        return Knowns(self.discs.beside(np.array(numbers)), lambda j: (*self.numbers(j), *numbers))

    def widened(self, radius: np.ndarray) -> Knowns:
        """Each value within a radius (m, known) of what it is."""
        discs = Discs(self.discs.middle, (self.discs.radius + radius) * UP)

        def numbers(j: int) -> tuple[Number, ...]:
            middle, radii = discs.middle[j].real.tolist(), discs.radius[j].tolist()
            with precision(_BITS):
                return tuple(
                    arb(m, r) if r > 0.0 else v
                    for v, m, r in zip(self.numbers(j), middle, radii, strict=True)
                )

        return Knowns(discs, numbers)

    @staticmethod
    def exact(k: np.ndarray) -> Knowns:
        """Doubles or complex numbers (m, known), taken as exact."""
        middle = np.asarray(k)
        if np.iscomplexobj(middle) and not np.any(middle.imag):
            middle = middle.real
        return Knowns(
            Discs.exact(np.ascontiguousarray(middle)), lambda j: tuple(plain(v) for v in middle[j])
        )


def plain(value: Number) -> Number:
    """A known value as a float, a complex number that is not real, or a ball."""
    if isinstance(value, (arb, acb)):
        return value.real if isinstance(value, acb) and value.imag == 0 else value
    number = complex(value)
    return number.real if number.imag == 0.0 else number
