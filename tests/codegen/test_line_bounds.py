"""Bounds of functions along lines: held against values of their own."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Chebyshev

from helpers.inside import Span, bend_of

SPANS = (Span(True), Span(True), Span(False, 2.0, 3.0))


def wave(given):
    """A function of two angles and a length that is no sum of squares."""
    p, q, x = given.T
    return 3.0 + np.cos(p - 2 * q) + 0.5 * x**2 * np.sin(p) - 0.1 * x**3 * np.cos(q) ** 2


def test_second_differences_keep_to_the_bound():
    """Along random lines the second difference quotient is at most the sum of weights times squared
    changes.
    """
    bend = bend_of(wave, SPANS)
    rng = np.random.default_rng(1)
    middle = np.array([0.0, 0.0, 2.0]) + np.array([np.pi, np.pi, 2.9]) * rng.uniform(
        -1, 1, (4000, 3)
    )
    change = rng.normal(size=(4000, 3))
    step = 1e-3
    quotient = (
        wave(middle + step * change) - 2 * wave(middle) + wave(middle - step * change)
    ) / step**2
    bound = change**2 @ bend.weights
    assert np.all(np.abs(quotient) <= bound + 1e-5)
    assert np.max(np.abs(quotient) / bound) > 0.2


@pytest.mark.parametrize("factor", [1e-8, 1e-3, 1e3, 1e6])
def test_bounds_are_the_same_in_any_unit_of_length(factor):
    """Of a function of an angle and a length, told in units of the length, no bound depends on what
    the length is measured in.
    """
    bend = bend_of(wave, SPANS)
    long = Span(False, 2.0 * factor, 3.0 * factor, factor)
    other = bend_of(lambda given: wave(given / [1.0, 1.0, factor]), (Span(True), Span(True), long))
    np.testing.assert_allclose(other.weights, bend.weights, rtol=1e-9)
    np.testing.assert_allclose(other.slopes, bend.slopes, rtol=1e-9)


def test_slopes_and_size_are_bounds_too():
    bend = bend_of(wave, SPANS)
    rng = np.random.default_rng(2)
    given = np.array([0.0, 0.0, 2.0]) + np.array([np.pi, np.pi, 2.9]) * rng.uniform(
        -1, 1, (4000, 3)
    )
    assert np.all(np.abs(wave(given)) <= bend.size)
    for i in range(3):
        step = 1e-5 * np.eye(3)[i]
        assert np.all(
            np.abs(wave(given + step) - wave(given - step)) / 2e-5 <= bend.slopes[i] + 1e-5
        )


@pytest.mark.parametrize(
    "values",
    [
        lambda q: np.abs(np.cos(q[:, 0])),
        lambda q: 1.0 / (1.2 + np.cos(q[:, 1])),
        lambda q: np.cos(7 * q[:, 0]),
    ],
)
def test_what_is_no_such_sum_has_no_bounds(values):
    assert bend_of(values, SPANS) is None


@pytest.mark.parametrize("degree", range(1, 7))
def test_bounds_of_one_wave_are_reached(degree):
    """A Chebyshev polynomial of a length: its largest slope and second derivative, which it has at
    the ends, are the bounds; those of a wave of an angle are reached too.
    """
    rng = np.random.default_rng(degree)
    for middle, half, factor in np.exp(rng.normal(size=(5, 3))):
        polynomial = factor * Chebyshev.basis(degree, domain=[middle - half, middle + half])
        bend = bend_of(lambda x, p=polynomial: p(x[:, 0]), [Span(False, middle, half)])
        x = np.linspace(middle - half, middle + half, 2001)
        assert bend.slopes[0] == pytest.approx(np.max(np.abs(polynomial.deriv()(x))), rel=1e-6)
        assert bend.weights[0] == pytest.approx(
            np.max(np.abs(polynomial.deriv(2)(x))), rel=1e-6, abs=1e-6 * factor / half**2
        )
    bend = bend_of(lambda q: 2.0 * np.sin(degree * q[:, 0] + 0.4), [Span(True)])
    np.testing.assert_allclose(
        [bend.size, bend.slopes[0], bend.weights[0]], [2, 2 * degree, 2 * degree**2], rtol=1e-6
    )


def test_sums_of_waves_keep_to_the_bounds_at_the_corners():
    """Random products of Chebyshev polynomials of two lengths and a wave: the second derivatives
    along lines, taken exactly at corners and within, are at most the bound, and along each single
    given value some come near it.
    """
    rng = np.random.default_rng(7)
    spans = [Span(False, 1.0, 0.3), Span(False, -2.0, 5.0), Span(True)]
    shape = 3, 5, 3
    nearest = np.zeros(3)
    for _ in range(12):
        c = rng.normal(size=shape) * (rng.random(shape) < 0.2)
        c[1, 4, 2] = 3.0
        basis = [[_wave(span, k) for k in range(n)] for span, n in zip(spans, shape, strict=True)]

        def derivative(given, orders, c=c, basis=basis):
            parts = [np.stack([w(given[:, i], orders[i]) for w in basis[i]]) for i in range(3)]
            return np.einsum("ijk,in,jn,kn->n", c, *parts)

        bend = bend_of(lambda given, g=derivative: g(given, (0, 0, 0)), spans)
        u = np.where(
            rng.random((800, 3)) < 0.5,
            np.sign(rng.normal(size=(800, 3))),
            rng.uniform(-1, 1, (800, 3)),
        )
        given = np.array([1.0, -2.0, 0.0]) + u * [0.3, 5.0, np.pi]
        hessian = np.array(
            [
                [
                    derivative(given, np.eye(3, dtype=int)[i] + np.eye(3, dtype=int)[j])
                    for j in range(3)
                ]
                for i in range(3)
            ]
        )
        d = rng.normal(size=(800, 3)) * np.exp(rng.normal(size=(800, 3)))
        assert np.all(
            np.abs(np.einsum("ni,ijn,nj->n", d, hessian, d)) <= (1 + 1e-9) * (d**2 @ bend.weights)
        )
        own = [np.max(np.abs(hessian[i, i])) for i in range(3)]
        assert np.all(own <= bend.weights)
        nearest = np.maximum(nearest, own / bend.weights)
    assert np.all(nearest > 0.05)


def _wave(span, order):
    """A wave and its derivatives: T_k of a length, cos(k q + k) of an angle."""
    if span.angular:
        return lambda q, n: float(order) ** n * np.cos(order * q + order + 0.5 * np.pi * n)
    polynomial = Chebyshev.basis(order, domain=[span.middle - span.half, span.middle + span.half])
    return lambda x, n: polynomial.deriv(n)(x) if n else polynomial(x)
