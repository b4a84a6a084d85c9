"""Gathered expressions: the same values in fewer operations."""

from __future__ import annotations

import casadi as ca
import numpy as np

from helpers.inside import gathered


def _values(expressions, symbols, point):
    return np.asarray(
        ca.Function("f", [ca.vertcat(*symbols)], [ca.vertcat(*expressions)])(point)
    ).ravel()


def test_constants_that_cancel_are_gone():
    c, s, x = (ca.SX.sym(name) for name in "csx")
    # |(a cos t + x, a sin t)|^2 - x^2 = a^2 + 2 a x cos t
    square = (3 * c + x) ** 2 + (3 * s) ** 2 - x * x
    (found,) = gathered([square], [c, s, x], [(c, s)])
    assert ca.Function("f", [c, s, x], [found]).n_instructions() <= 8
    for angle in (0.3, 2.0, -1.1):
        point = [np.cos(angle), np.sin(angle), 0.7]
        np.testing.assert_allclose(
            _values([found], [c, s, x], point), 9 + 6 * 0.7 * np.cos(angle), rtol=1e-14
        )


def test_values_stay():
    """Random expressions with quotients and roots, at points on the circle."""
    rng = np.random.default_rng(4)
    c, s, x, y = (ca.SX.sym(name) for name in "csxy")
    for _ in range(20):
        a, b, d = (float(v) for v in rng.normal(size=3))
        first = (a * c - b * s + x) * (b * c + a * s - y) + d
        second = ca.sqrt(first * first + 1) / (x * x + y * y + 0.5) - a * first
        expressions = [first * second, ca.vertcat(second - c * c, first)]
        found = gathered(expressions, [c, s, x, y], [(c, s)])
        angle = rng.uniform(-3, 3)
        point = [np.cos(angle), np.sin(angle), *rng.normal(size=2)]
        np.testing.assert_allclose(
            _values(found, [c, s, x, y], point),
            _values(expressions, [c, s, x, y], point),
            rtol=1e-11,
            atol=1e-12,
        )


def test_polynomials_with_whole_coefficients_keep_their_values():
    """Products of sums of which much cancels, so that polynomials with coefficients of both signs
    are left and are written anew.
    """
    rng = np.random.default_rng(5)
    x, y, z = symbols = [ca.SX.sym(name) for name in "xyz"]
    for _ in range(40):
        a, b, c, d = (int(v) for v in rng.integers(-4, 5, 4))
        product = (x + a) * (y + b) * (z + c) - x * y * z
        expression = product - c * x * y - (y + d) * (a * z + 1) + b * (x - z) ** 2 - b * x * x
        found = gathered([expression], symbols, [])
        for _ in range(3):
            point = rng.normal(size=3)
            np.testing.assert_allclose(
                _values(found, symbols, point),
                _values([expression], symbols, point),
                rtol=1e-11,
                atol=1e-11,
            )
