"""Which boxes are proved to hold different roots, real ones, and poses.

Two roots are one if their features are equal: exp(i z) of an angle, the square of a rod's length, a length, and for a ray x the
ratios x_j / (a.x), a fixed. A complex number t = c.(features) is then equal too, so that roots with disjoint t differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nextafter

import numpy as np
from flint import acb, arb

from symkin.caching import lru_cache
from symkin.certificate.balls import Number, precision
from symkin.certificate.krawczyk import Box
from symkin.homotopy.algebraic import AlgebraicSystem

_WEIGHTS = 3
"""So many random t are computed; two roots differ if one of them does."""


def distinct_boxes(system: AlgebraicSystem, boxes: Sequence[Box]) -> list[int]:
    """Indices of boxes whose roots are proved to differ from each other: pairwise by disjoint t, taken one after another if
    they touch none that is taken."""
    n = len(boxes)
    touching = np.ones((n, n), dtype=bool)
    for which in range(_WEIGHTS):
        sides = np.array([_sides(_mixed(system, box, which)) for box in boxes]).reshape(n, 4)
        for low, high in (sides[:, :2].T, sides[:, 2:].T):
            touching &= (low[:, None] <= high[None]) & (low[None] <= high[:, None])
        if touching.sum() == n:
            break
    chosen: list[int] = []
    for i in range(n):
        if not touching[i, chosen].any():
            chosen.append(i)
    return chosen


def _mixed(system: AlgebraicSystem, box: Box, which: int) -> acb:
    """t over the box."""
    affine, weights, divisor = _random_weights(system, which)
    ray = system.projective
    with precision(box.bits):
        z = box.balls
        total = acb(0)
        for weight, x, c in zip(affine, z, system.unknowns, strict=False):
            if c.kind == "angle":
                total += weight * (acb(0, 1) * x).exp()
            elif c.least is None:
                total += weight * x
            else:
                length = x - arb(c.least) / arb(system.size)
                total += weight * (length * length)
        if not ray:
            return total
        top, bottom = acb(0), acb(0)
        for a, b, j in zip(weights, divisor, ray, strict=True):
            top, bottom = top + a * z[j], bottom + b * z[j]
        return total + top / bottom


@lru_cache(maxsize=64)
def _random_weights(system: AlgebraicSystem, which: int) -> tuple[list[acb], list[acb], list[acb]]:
    rng = np.random.default_rng(which)
    sizes = (len(system.unknowns), len(system.projective), len(system.projective))
    return tuple([acb(*rng.normal(size=2).tolist()) for _ in range(m)] for m in sizes)  # type: ignore[return-value]


def _sides(t: acb) -> tuple[float, float, float, float]:
    """Doubles: low and high of Re t, of Im t; infinite where t is not finite."""
    return (*_interval(t.real), *_interval(t.imag))


def _interval(x: arb) -> tuple[float, float]:
    if not x.is_finite():
        return (-inf, inf)
    return (nextafter(float(x.lower()), -inf), nextafter(float(x.upper()), inf))


def not_real(system: AlgebraicSystem, box: Box) -> bool:
    """Whether the root in the box differs from its conjugate: Im z_j is not zero, or, of a ray, Im (x_i conj(x_j))."""
    if box.ring.is_real:
        return False
    ray = list(system.projective)
    with precision(box.bits):
        z = box.balls
        if any(not _has_zero(z[j].imag) for j in range(system.width) if j not in ray):
            return True
        if not ray:
            return False
        x = np.array([complex(z[j]) for j in ray])
        i, j = np.unravel_index(np.argmax(np.abs((x[:, None] * np.conj(x)).imag)), (len(ray), len(ray)))
        return not _has_zero((z[ray[i]] * z[ray[j]].conjugate()).imag)


def is_pose(system: AlgebraicSystem, box: Box) -> bool:
    """Whether e.e is not zero, without which a ray is no pose; true where the unknowns hold no ray."""
    if not system.projective:
        return True
    with precision(box.bits):
        z = box.balls
        return not _has_zero(sum((z[j] * z[j] for j in system.projective[:4]), start=box.ring.number(0)))


def _has_zero(x: Number) -> bool:
    return bool(x.contains(0)) or not x.is_finite()
