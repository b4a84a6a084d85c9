"""The cubics that paths are proved about: their boxes hold curve and derivatives and are no larger
than needed, and their extremes are where the derivative vanishes."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.inside import Cubic, _extremes


def drawn(seed):
    """A cubic of five unknowns by its Hermite data, and the polynomial in time of each (4, 5), by
    the four conditions."""
    rng = np.random.default_rng(seed)
    length = float(np.exp(rng.normal()))
    a, b, va, vb = rng.normal(size=(4, 5))
    rows = [
        [1, 0, 0, 0],
        [0, 1, 0, 0],
        [1, length, length**2, length**3],
        [0, 1, 2 * length, 3 * length**2],
    ]
    return Cubic.hermite(a, va, b, vb, length), np.linalg.solve(
        np.array(rows, dtype=float), np.array([a, va, b, vb])
    )


@pytest.mark.parametrize("seed", range(5))
def test_boxes_hold_curve_velocity_and_acceleration(seed):
    """The box of the acceleration, which is linear, is that of its ends; those of curve and
    velocity hold all samples."""
    cubic, powers = drawn(seed)
    t = np.linspace(0.0, cubic.length, 201)
    curve = np.polynomial.polynomial.polyval(t, powers).T
    velocity = np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyder(powers)).T
    acceleration = np.polynomial.polynomial.polyval(
        t, np.polynomial.polynomial.polyder(powers, 2)
    ).T
    np.testing.assert_allclose([cubic.at(s) for s in t / cubic.length], curve, atol=1e-12)
    longer = cubic.longer(0.1)
    for s in t / cubic.length:
        np.testing.assert_allclose(longer.at((s + 0.1) / 1.2), cubic.at(s), atol=1e-12)
    np.testing.assert_allclose(cubic.middle_velocity, velocity[100], atol=1e-11)
    for (centre, half), values in (
        (cubic.hull, curve),
        (cubic.velocity, velocity),
        (cubic.acceleration, acceleration),
    ):
        assert np.all(np.abs(values - centre) <= half + 1e-12 * np.max(np.abs(values)))
    centre, half = cubic.acceleration
    np.testing.assert_allclose(
        [centre - half, centre + half],
        [acceleration.min(axis=0), acceleration.max(axis=0)],
        atol=1e-9,
    )
    centre, half = cubic.velocity
    ends = np.abs(velocity[[0, -1]] - centre) - half
    assert np.all(ends <= 1e-12)
    assert np.all(half <= 3.0 * np.max(np.abs(velocity), axis=0))


@pytest.mark.parametrize("seed", range(20))
def test_extremes_are_where_the_derivative_vanishes(seed):
    cubic, powers = drawn(seed)
    for k in range(5):
        b, c, d = np.polynomial.polynomial.polyder(powers[:, k]) * cubic.length ** np.arange(1, 4)
        inside = (
            (c**2 - 4 * b * d >= 0) * np.array([-1.0, 1.0]) * np.sqrt(max(c**2 - 4 * b * d, 0.0))
        )
        roots = (
            sorted(r for r in (-c + inside) / (2 * d) if 0.0 < r < 1.0) if c**2 >= 4 * b * d else []
        )
        np.testing.assert_allclose(_extremes(cubic, k), roots, atol=1e-9)
