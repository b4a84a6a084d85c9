"""Certificates of the roots of one instance, as tests look at them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, arb

from helpers.inside import (
    AlgebraicSystem,
    CertificateBatch,
    Discs,
    Knowns,
    certify_batch,
    plain_number,
)


@dataclass(frozen=True, eq=False)
class Certificates:
    """What is proved of the n roots of one instance of a batch: `pose` (n,) that e.e is not zero,
    `distinct` that so many certified roots differ from each other.
    """

    system: AlgebraicSystem
    certified: np.ndarray
    centre: np.ndarray
    ball: np.ndarray
    real: np.ndarray
    pose: np.ndarray
    distinct: int
    batch: CertificateBatch
    instance: int

    @property
    def radius(self) -> np.ndarray:
        return self.batch.radius[self._rows]

    @property
    def reasons(self) -> tuple[str, ...]:
        return tuple(self.batch.reason(i) for i in range(self._rows.start, self._rows.stop))

    @property
    def _rows(self) -> slice:
        return _rows(self.batch, self.instance)

    @property
    def disjoint(self) -> bool:
        """Whether all certified roots are proved to differ from each other."""
        return self.distinct == int(np.sum(self.certified))

    def find(self, point: np.ndarray) -> tuple[int, float] | None:
        """The certified real root at a real point (width,), such as one with other whole turns,
        scale or sign of a length, or one that was polished on other rows: its index, and `radius`
        about that point. None where there is none.
        """
        index, radius = self.batch.find(
            np.asarray(point, dtype=complex)[:, None], np.array([self.instance])
        )
        return None if index[0] < 0 else (int(index[0]) - self._rows.start, float(radius[0]))


def _rows(batch: CertificateBatch, j: int) -> slice:
    """The roots of instance j."""
    return slice(*np.searchsorted(batch.instance, [j, j + 1]).tolist())


def of_instance(batch: CertificateBatch, j: int) -> Certificates:
    """What is proved of instance j."""
    rows = _rows(batch, j)
    return Certificates(
        system=batch.system,
        certified=batch.certified[rows],
        centre=batch.centre[:, rows],
        ball=batch.ball[rows],
        real=batch.real[rows],
        pose=batch.pose[rows],
        distinct=int(batch.distinct[j]),
        batch=batch,
        instance=j,
    )


def knowns_of_one(k: Sequence[Any] | np.ndarray) -> Knowns:
    """Known values of one instance: doubles and complex numbers, taken as exact, or balls."""
    numbers = tuple(plain_number(v) for v in k)
    pairs = [_disc(v) for v in numbers]
    middle = np.array([m for m, _ in pairs])
    return Knowns(Discs(middle[None], np.array([[r for _, r in pairs]])), lambda _: numbers)


def _disc(value: Any) -> tuple[float | complex, float]:
    """Middle and radius: of a ball, the double next to its middle, and what that leaves out."""
    if isinstance(value, arb):
        middle = float(value)
        return middle, _above((value - middle).abs_upper())
    if isinstance(value, acb):
        point = complex(float(value.real), float(value.imag))
        return point, _above((value - point).abs_upper())
    return value, 0.0


def _above(value: arb) -> float:
    return math.nextafter(float(value), math.inf)


def certify(
    system: AlgebraicSystem,
    z: np.ndarray,
    k: Knowns | Sequence[Any] | np.ndarray,
    size: float | None = None,
) -> Certificates:
    """Certificates of approximate roots z (width, n) of one instance with known values k: doubles,
    taken as exact, or balls. `size` is the length that z has as its unit, by default the system's.
    """
    knowns = k if isinstance(k, Knowns) else knowns_of_one(k)
    return of_instance(certify_batch(system, z, knowns, size=size), 0)
