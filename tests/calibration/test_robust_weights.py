"""Weights of robust losses: their efficiency with normal errors, and what a weight means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from helpers.inside import EFFICIENCY, loss_weights, with_weights

T = np.linspace(-12.0, 12.0, 200_001)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_losses_have_their_efficiency(loss):
    """Of the influence psi = w(t) t with normal errors: E(psi')^2 / E(psi^2), the least squares
    variance over that of the loss."""
    density = np.exp(-0.5 * T**2) / np.sqrt(2 * np.pi)
    psi = loss_weights(loss, T) * T
    step = T[1] - T[0]
    slope, square = np.sum(np.gradient(psi, T) * density) * step, np.sum(psi**2 * density) * step
    assert slope**2 / square == pytest.approx(EFFICIENCY, abs=5e-4)


@pytest.mark.parametrize("loss", ["squared", "huber", "cauchy"])
def test_far_readings_count_less_and_none_more_than_whole(loss):
    weights = loss_weights(loss, T[T >= 0])
    assert weights[0] == 1.0
    assert np.all(np.diff(weights) <= 0.0)
    np.testing.assert_array_equal(weights, loss_weights(loss, -T[T >= 0]))


@dataclass(frozen=True)
class _Readings:
    sigma: np.ndarray


@dataclass(frozen=True)
class _Problem:
    readings: _Readings


def test_a_weight_multiplies_the_square_of_a_residual():
    """A reading of weight w counts as w readings: (r / sigma')^2 = w (r / sigma)^2."""
    rng = np.random.default_rng(0)
    sigma, weight, residual = np.exp(rng.normal(size=(3, 8, 2)))
    weighted = with_weights(_Problem(_Readings(sigma)), weight).readings.sigma
    np.testing.assert_allclose((residual / weighted) ** 2, weight * (residual / sigma) ** 2)
