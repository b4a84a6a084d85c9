"""Known values of many instances at once: as discs for the quick test, and as balls for what it
leaves open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from flint import acb, arb

from symkin.certificate.disc_arithmetic import UP
from symkin.certificate.discs import Discs
from symkin.numeric.balls import Number, precision

_BITS = 128


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
