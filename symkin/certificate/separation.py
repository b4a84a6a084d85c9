"""Which boxes are proved to hold different roots, real ones, and poses.

Two roots are one if their features are equal: exp(i z) of an angle, the square of a rod's length, a
length, and for a ray x the ratios x_j / (a.x), a fixed. A complex number t = c.(features) is then
equal too, so that roots with disjoint t differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, nextafter

import casadi as ca
import numpy as np
from flint import acb, arb

from symkin.certificate.disc_arithmetic import UP
from symkin.certificate.discs import DiscFunction, Discs
from symkin.certificate.krawczyk import Box
from symkin.computed_once import lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.numeric.balls import COMPLEX, BallFunction, Number, precision

_WEIGHTS = 3
"""So many random t are computed; two roots differ if one of them does."""


def distinct_boxes(system: AlgebraicSystem, boxes: Sequence[Box]) -> list[int]:
    """Indices of boxes whose roots are proved to differ from each other: pairwise by disjoint t,
    taken one after another if they touch none that is taken.
    """
    n = len(boxes)
    touching = np.ones((n, n), dtype=bool)
    mixed = [_mixed(system, box)[:_WEIGHTS] for box in boxes]
    for numbers in zip(*mixed, strict=True):
        sides = np.array([_sides(t) for t in numbers]).reshape(n, 4)
        for low, high in (sides[:, :2].T, sides[:, 2:].T):
            touching &= (low[:, None] <= high[None]) & (low[None] <= high[:, None])
    chosen: list[int] = []
    for i in range(n):
        if not touching[i, chosen].any():
            chosen.append(i)
    return chosen


def _mixed(system: AlgebraicSystem, box: Box) -> list[Number]:
    """The numbers t over the box and, of a ray, e.e."""
    mixing = _mixing(system)
    with precision(box.bits):
        prepared = mixing.balls.prepare(COMPLEX, mixing.weights)
        return mixing.balls.evaluate(0, [acb(z) for z in box.balls], prepared)


def _random_numbers(
    system: AlgebraicSystem, which: int
) -> tuple[list[complex], list[complex], list[complex]]:
    """Weights of the affine unknowns' features, and a and b of the ray's ratio a.x / b.x."""
    rng = np.random.default_rng(which)
    sizes = (len(system.unknowns), len(system.projective), len(system.projective))
    return tuple([complex(*rng.normal(size=2).tolist()) for _ in range(m)] for m in sizes)  # type: ignore[return-value]


def _sides(t: acb) -> tuple[float, float, float, float]:
    """Doubles: low and high of Re t, of Im t; infinite where t is not finite."""
    return (*_interval(t.real), *_interval(t.imag))


def _interval(x: arb) -> tuple[float, float]:
    if not x.is_finite():
        return (-inf, inf)
    return (nextafter(float(x.lower()), -inf), nextafter(float(x.upper()), inf))


def not_real(system: AlgebraicSystem, box: Box) -> bool:
    """Whether the root in the box differs from its conjugate: Im z_j is not zero, or, of a ray, Im
    (x_i conj(x_j)).
    """
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
        i, j = np.unravel_index(
            np.argmax(np.abs((x[:, None] * np.conj(x)).imag)), (len(ray), len(ray))
        )
        return not _has_zero((z[ray[i]] * z[ray[j]].conjugate()).imag)


def is_pose(system: AlgebraicSystem, box: Box) -> bool:
    """Whether e.e is not zero, without which a ray is no pose; true where the unknowns hold no
    ray.
    """
    if not system.projective:
        return True
    return not _has_zero(_mixed(system, box)[_WEIGHTS])


def _has_zero(x: Number) -> bool:
    return bool(x.contains(0)) or not x.is_finite()


# --- many boxes, in double precision --------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Features:
    """Of n roots within discs: the numbers t, `mixed` (n, 3), and which are proved to be poses,
    (n,).
    """

    mixed: Discs
    poses: np.ndarray


def features(system: AlgebraicSystem, z: Discs) -> Features:
    """Features of roots within discs z (n, width)."""
    mixing, n = _mixing(system), len(z.middle)
    values = mixing.discs.evaluate(0, z.as_complex(), mixing.prepared, np.zeros(n, dtype=int))
    if not system.projective:
        return Features(values, np.ones(n, dtype=bool))
    square = values.middle[:, _WEIGHTS]
    poses = np.maximum(np.abs(square.real), np.abs(square.imag)) > values.radius[:, _WEIGHTS]
    return Features(Discs(values.middle[:, :_WEIGHTS], values.radius[:, :_WEIGHTS]), poses)


def are_apart(mixed: Discs, instance: np.ndarray, count: int) -> np.ndarray:
    """For each of `count` instances whether all its roots are proved to differ: by disjoint
    intervals of Re t, for one of the t. `instance` (n,) is ascending.
    """
    apart = np.zeros(count, dtype=bool)
    for which in range(_WEIGHTS):
        middle, radius = mixed.middle[:, which].real, mixed.radius[:, which]
        order = np.lexsort((middle, instance)) if count > 1 else middle.argsort()
        middle, radius = middle[order], radius[order]
        # of neighbours alone: those that are disjoint one by one are disjoint from all others of
        # their instance
        meeting = ~(middle[1:] - middle[:-1] > (radius[1:] + radius[:-1]) * UP)
        here = np.ones(count, dtype=bool)
        if meeting.any():
            owner = instance[order]
            here[owner[1:][meeting & (owner[1:] == owner[:-1])]] = False
        apart |= here
        if apart.all():
            break
    return apart


def are_not_real(system: AlgebraicSystem, centre: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Which roots in boxes of half width (n,) about centres (width, n) are proved to differ from
    their conjugates.
    """
    ray, affine = list(system.projective), slice(len(system.unknowns))
    shown: np.ndarray = np.abs(centre[affine].imag).max(axis=0, initial=0.0) > half
    if ray and half.size:
        # Im (x_i conj(x_j)) for the largest x_j, |x_i| <= s: off by 2 h (2 s + h) in the box, and
        # by 4 u s^2 in rounding
        x = centre[ray]
        sizes = np.abs(x.real) + np.abs(x.imag)
        largest = (sizes.argmax(axis=0), np.arange(x.shape[1]))
        pivot, size = x[largest], sizes[largest]
        off = 2.0 * half * (2.0 * size + half) + 2.0**-50 * size * size
        shown = shown | (np.abs(pivot.imag * x.real - pivot.real * x.imag).max(axis=0) > off * UP)
    return shown


@dataclass(frozen=True, eq=False)
class _Mixing:
    """The numbers t of a point, and, of a ray, e.e, as functions of z and of the `weights`, which
    are `prepared` for discs.
    """

    discs: DiscFunction
    prepared: Discs
    balls: BallFunction
    weights: list[complex]


@lru_cache(maxsize=64)
def _mixing(system: AlgebraicSystem) -> _Mixing:
    z, ray = system.z, list(system.projective)
    # the size and the least lengths are weights too: CasADi would round their quotients
    least = [complex(c.least or 0.0) for c in system.unknowns]
    weights, rows = [1j, complex(system.characteristic_length), *least], []
    symbols = ca.SX.sym("w", len(weights) + _WEIGHTS * (len(system.unknowns) + 2 * len(ray)))
    for which in range(_WEIGHTS):
        total = ca.SX(0)
        affine, top, bottom = _random_numbers(system, which)
        for i, (w, c) in enumerate(zip(affine, system.unknowns, strict=True)):
            weight = symbols[len(weights)]
            weights.append(w)
            if c.is_periodic:
                total += weight * (ca.cos(z[i]) + symbols[0] * ca.sin(z[i]))
            elif c.least is None:
                total += weight * z[i]
            else:
                total += weight * (z[i] - symbols[2 + i] / symbols[1]) ** 2
        if ray:
            own = symbols[len(weights) : len(weights) + 2 * len(ray)]
            weights += [*top, *bottom]
            total += ca.dot(own[: len(ray)], z[ray]) / ca.dot(own[len(ray) :], z[ray])
        rows.append(total)
    if ray:
        rows.append(ca.sumsqr(z[ray[:4]]))
    balls = BallFunction(z, symbols, ca.vertcat(*rows))
    discs = DiscFunction(balls.tape)
    prepared = discs.prepare(Discs.exact(np.array([weights], dtype=complex)))
    return _Mixing(discs, prepared, balls, weights)
