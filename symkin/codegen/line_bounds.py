"""Bounds for the straight line of given values: how far a function of them bends away from its
chord.

A function g that is a polynomial in lengths and in cosines and sines of angles is a finite sum of
products of Chebyshev polynomials of lengths over their ranges and of waves of angles. Its
coefficients bound its second derivatives by each pair of given values, for all values at once, so
that along a line, t from 0 to 1 with changes d of the given values, each in a unit of its own,

    |g''| <= sum of weights_i d_i^2,

and g is above zero between two points of it where that is below 2 (g_a + g_b + 2 min(g_a, g_b)).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from symkin.computed_once import lru_cache

_DEGREE = 4
"""Highest wave, and degree in a length, that is looked for."""
_HIGHEST = 6
"""The same of a second look, for at most so many given values:"""
_FEW = 3
_SHIFT = 0.0711
"""By how much more each angle's samples are shifted than those of the one before (rad): equal
angles are special.
"""
_MISFIT = 1e-9
"""Share of the largest value by which the sum may be off at points that it was not made from."""
_CHECKED = 64
_PLAINLY_OFF = 1e-4
"""The same share along one given value, at which a function is no such sum for certain."""
_ALONG = 16
"""Points of one given value at which that is asked, beside those that the sum is made from."""


@dataclass(frozen=True)
class Span:
    """What a given value runs over: all angles, or lengths `middle` +- `half`; `unit` is what its
    changes are told in.
    """

    angular: bool
    middle: float = 0.0
    half: float = 1.0
    unit: float = 1.0


@dataclass(frozen=True)
class Bend:
    """Bounds of a function: `size` of itself, `slopes` (given values) of first derivatives,
    `weights` (given values) of the second one along a line as above, for changes in units of the
    spans.
    """

    size: float
    slopes: np.ndarray
    weights: np.ndarray


def bend_of(values: Callable[[np.ndarray], np.ndarray], spans: Sequence[Span]) -> Bend | None:
    """Bounds of a function (n, given) -> (n,); None where it is no such polynomial."""
    found = (
        _bend_of(values, spans, degree)
        for degree in (_DEGREE, _HIGHEST)[: 2 if len(spans) <= _FEW else 1]
    )
    return next((bend for bend in found if bend is not None), None)


def _bend_of(
    values: Callable[[np.ndarray], np.ndarray], spans: Sequence[Span], degree: int
) -> Bend | None:
    """The same for waves and degrees up to one."""
    count, points = len(spans), 2 * degree + 2
    if _is_off_along_one(values, spans, points):
        return None
    samples = values(_placed(_grid(points, count), spans))
    if not np.isfinite(samples).all():
        return None
    waves = np.fft.fftn(samples.reshape((points,) * count)) / points**count
    orders = np.fft.fftfreq(points, 1.0 / points)
    amplitudes = np.abs(waves).ravel()
    largest = float(np.max(np.abs(samples)))
    if not _reproduces(values, spans, waves, orders, largest):
        return None
    first = np.array([[_slope(span, k) for k in np.abs(orders)] for span in spans])
    second = np.array([[_curvature(span, k) for k in np.abs(orders)] for span in spans])
    places = np.indices((points,) * count).reshape(count, -1)
    once = np.stack([first[i][places[i]] for i in range(count)])
    twice = np.stack([second[i][places[i]] for i in range(count)])
    # 2 |d_i| |d_j| <= d_i^2 + d_j^2
    hessian = np.array(
        [
            [np.sum(amplitudes * (twice[i] if i == j else once[i] * once[j])) for j in range(count)]
            for i in range(count)
        ]
    )
    return Bend(
        size=float(np.sum(amplitudes)),
        slopes=np.sum(amplitudes * once, axis=1),
        weights=np.sum(hessian, axis=1),
    )


@lru_cache(maxsize=4)
def _grid(points: int, count: int) -> np.ndarray:
    angles = 2 * np.pi * np.arange(points) / points
    return np.array(list(product(angles, repeat=count))).reshape(-1, count)


def _is_off_along_one(
    values: Callable[[np.ndarray], np.ndarray], spans: Sequence[Span], points: int
) -> bool:
    """Whether a function of one given value after the other, the others at random, is no sum of so
    many waves: far fewer points than those of all tell.
    """
    rng = np.random.default_rng(6)
    rows = np.tile(rng.uniform(-np.pi, np.pi, len(spans)), (len(spans), points + _ALONG, 1))
    own = np.append(2 * np.pi * np.arange(points) / points, rng.uniform(-np.pi, np.pi, _ALONG))
    for i in range(len(spans)):
        rows[i, :, i] = own
    found = values(_placed(rows.reshape(-1, len(spans)), spans)).reshape(len(spans), -1)
    if not np.isfinite(found).all():
        return True
    waves = np.fft.fft(found[:, :points]) / points
    orders = np.fft.fftfreq(points, 1.0 / points)
    told = (waves @ np.exp(1j * np.outer(orders, own[points:]))).real
    off = np.abs(told - found[:, points:]) > _PLAINLY_OFF * np.max(np.abs(found))
    return bool(off.any())


def _placed(angles: np.ndarray, spans: Sequence[Span]) -> np.ndarray:
    """Given values for angles of the waves: a length is middle + half cos, whose waves are
    Chebyshev polynomials.
    """
    columns = [
        angles[:, i] + _SHIFT * (i + 1) if s.angular else s.middle + s.half * np.cos(angles[:, i])
        for i, s in enumerate(spans)
    ]
    return np.stack(columns, axis=-1)


def _reproduces(
    values: Callable[[np.ndarray], np.ndarray],
    spans: Sequence[Span],
    waves: np.ndarray,
    orders: np.ndarray,
    largest: float,
) -> bool:
    angles = np.random.default_rng(5).uniform(-np.pi, np.pi, (_CHECKED, len(spans)))
    # the sum over all waves, one given value after the other
    turns = np.exp(1j * angles[:, :, None] * orders)
    told = turns[:, 0] @ waves.reshape(len(orders), -1)
    for i in range(1, len(spans)):
        told = (turns[:, i, None] @ told.reshape(_CHECKED, len(orders), -1))[:, 0]
    told = told.reshape(_CHECKED)
    return bool(np.max(np.abs(told.real - values(_placed(angles, spans)))) <= _MISFIT * largest)


def _slope(span: Span, order: float) -> float:
    """Largest first derivative of a wave."""
    return float(span.unit * (order if span.angular else order**2 / span.half))


def _curvature(span: Span, order: float) -> float:
    """Largest second derivative of a wave."""
    return float(
        span.unit**2 * (order**2 if span.angular else order**2 * (order**2 - 1) / 3 / span.half**2)
    )
