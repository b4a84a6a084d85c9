"""Bounds of functions along lines: held against values of their own."""

from __future__ import annotations

import numpy as np
import pytest

from symkin.codegen.line_bounds import Span, bend_of

SPANS = (Span(True), Span(True), Span(False, 2.0, 3.0))


def wave(given):
    """A function of two angles and a length that is no sum of squares."""
    p, q, x = given.T
    return 3.0 + np.cos(p - 2 * q) + 0.5 * x**2 * np.sin(p) - 0.1 * x**3 * np.cos(q) ** 2


def test_second_differences_keep_to_the_bound():
    """Along random lines the second difference quotient is at most the sum of weights times squared changes."""
    bend = bend_of(wave, SPANS)
    rng = np.random.default_rng(1)
    middle = np.array([0.0, 0.0, 2.0]) + np.array([np.pi, np.pi, 2.9]) * rng.uniform(-1, 1, (4000, 3))
    change = rng.normal(size=(4000, 3))
    step = 1e-3
    quotient = (wave(middle + step * change) - 2 * wave(middle) + wave(middle - step * change)) / step**2
    bound = change**2 @ bend.weights
    assert np.all(np.abs(quotient) <= bound + 1e-5)
    assert np.max(np.abs(quotient) / bound) > 0.2


def test_slopes_and_size_are_bounds_too():
    bend = bend_of(wave, SPANS)
    rng = np.random.default_rng(2)
    given = np.array([0.0, 0.0, 2.0]) + np.array([np.pi, np.pi, 2.9]) * rng.uniform(-1, 1, (4000, 3))
    assert np.all(np.abs(wave(given)) <= bend.size)
    for i in range(3):
        step = 1e-5 * np.eye(3)[i]
        assert np.all(np.abs(wave(given + step) - wave(given - step)) / 2e-5 <= bend.slopes[i] + 1e-5)


@pytest.mark.parametrize(
    "values", [lambda q: np.abs(np.cos(q[:, 0])), lambda q: 1.0 / (1.2 + np.cos(q[:, 1])), lambda q: np.cos(7 * q[:, 0])]
)
def test_what_is_no_such_sum_has_no_bounds(values):
    assert bend_of(values, SPANS) is None
