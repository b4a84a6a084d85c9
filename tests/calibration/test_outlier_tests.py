"""The tests of single readings against plain least squares, and how many of them there are."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import symkin
from helpers.inside import OUTLIER_LEVEL, LinearModel, _test_readings, max_outliers, screen_readings

WIDTH = 3
"""Components of a reading."""


def model_of(errors, absorbed):
    """A linear model of whitened errors (n, K) whose fit absorbs some columns (n K, k)."""
    basis = np.linalg.qr(absorbed)[0] if absorbed.size else absorbed
    n, width = errors.shape
    flat = errors.ravel()
    return LinearModel(
        residuals=flat - basis @ (basis.T @ flat),
        group_columns=np.zeros((n * width, 2)),
        group=np.full(n * width, -1),
        parameter_columns=basis,
        fitted=float(basis.shape[1]) if basis.size else 0.0,
        taken=np.ones(n * width, dtype=bool),
        whiten=np.tile(np.eye(width), (n, 1, 1)),
    )


def problem_of(n, *kinds):
    """What the search asks of a problem that has one length read in each of n configurations, or
    some `kinds` of them whose noise is not stated.
    """
    keys = kinds or ("position",)
    unstated = [(SimpleNamespace(key=key), SimpleNamespace(sigma=None)) for key in kinds]
    return SimpleNamespace(
        model=SimpleNamespace(columns=[(key, "x") for key in keys], keys=keys),
        readings=SimpleNamespace(taken=np.ones((n, len(keys)), dtype=bool), known=not kinds),
        mechanism=symkin.load("zhao2000"),
        measurements=SimpleNamespace(
            labels=[str(k) for k in range(n)], channels=lambda _: unstated
        ),
    )


def squares(columns, values):
    """Sum of squares that least squares leaves, and the last coefficients."""
    found = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(np.sum((values - columns @ found) ** 2)), found


@pytest.mark.parametrize("absorbed", [0, 5, 30])
def test_a_statistic_is_what_a_free_shift_takes_of_chi_square(absorbed):
    """Of every reading: the fall of the sum of squares once its components have shifts of their own
    among the unknowns, these shifts, and their count."""
    rng = np.random.default_rng(absorbed)
    n = 20
    errors, columns = rng.normal(size=(n, WIDTH)), rng.normal(size=(n * WIDTH, absorbed))
    rows = np.arange(n * WIDTH).reshape(n, WIDTH)
    statistic, degrees, shift = _test_readings(model_of(errors, columns), rows)
    for k in range(n):
        before, _ = squares(columns, errors.ravel())
        after, coefficients = squares(
            np.hstack([columns, np.eye(n * WIDTH)[:, rows[k]]]), errors.ravel()
        )
        assert statistic[k] == pytest.approx(before - after, rel=1e-9, abs=1e-9)
        np.testing.assert_allclose(shift[k], coefficients[absorbed:], atol=1e-8)
        assert degrees[k] == WIDTH


def test_statistics_of_clean_readings_are_distributed_as_they_should_be():
    """Mean and variance of chi-square with three degrees of freedom, of 4000 clean readings beside
    a fit of 40 parameters."""
    rng = np.random.default_rng(8)
    n, rows = 40, np.arange(40 * WIDTH).reshape(40, WIDTH)
    drawn = [
        _test_readings(
            model_of(rng.normal(size=(n, WIDTH)), rng.normal(size=(n * WIDTH, 40))), rows
        )[0]
        for _ in range(100)
    ]
    statistics = np.concatenate(drawn)
    assert np.mean(statistics) == pytest.approx(WIDTH, abs=0.2)
    assert np.var(statistics) == pytest.approx(2 * WIDTH, rel=0.2)


def test_noise_that_is_not_stated_is_that_of_the_kind():
    """A reading that is off by eight deviations of its kind is found, with one probability, however
    much worse or better than its weight another kind is.
    """
    errors, found = np.random.default_rng(3).normal(size=(40, 2)), []
    errors[5, 0] = 8.0
    for factor in (1e-3, 1.0, 1e3):
        model = model_of(errors * [1.0, factor], np.zeros((80, 0)))
        (one,) = screen_readings(problem_of(40, "position", "point.toe"), model).outliers
        found.append((one.configuration, one.kind, one.probability))
    assert found[0][:2] == (5, "position")
    assert all(one[2] == pytest.approx(found[0][2], rel=1e-9) for one in found)


@pytest.mark.parametrize(("fitted", "share"), [(19, 0.03), (30, 0.3)])
def test_what_a_fit_moves_to_another_kind_makes_no_outliers(fitted, share):
    """Parameters that 20 readings of one kind decide, and those of another one see by a share,
    leave next to nothing of the first: of 40 clean sets no more than 5 have an outlier, whose
    number is above that by chance with a probability of 2e-4.
    """
    spoilt = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        errors, absorbed = rng.normal(size=(20, 2)), rng.normal(size=(40, fitted))
        absorbed[1::2] *= share
        problem = problem_of(20, "position", "point.toe")
        spoilt += bool(screen_readings(problem, model_of(errors, absorbed)).outliers)
    assert spoilt <= 5


@pytest.mark.parametrize("n", [10, 40])
@pytest.mark.parametrize("taken", [0, 1])
def test_the_level_is_shared_by_the_readings_that_are_left(n, taken):
    """Sidak: of m independent readings one is flagged if its probability is below 1 - (1 -
    level)^(1/m), where those that are out already do not count."""
    bound = 1.0 - (1.0 - OUTLIER_LEVEL) ** (1.0 / (n - taken))
    for factor, flagged in ((0.995, True), (1.005, False)):
        errors = np.full((n, 1), 0.1)
        errors[:taken] = 50.0
        errors[-1] = _normal_of(factor * bound)
        found = screen_readings(problem_of(n), model_of(errors, np.zeros((n, 0))))
        assert [o.configuration for o in found.outliers] == [
            *range(taken),
            *([n - 1] if flagged else []),
        ]
        assert not found.given_up


def _normal_of(probability):
    """The size that a normal error exceeds with a probability, by bisection of erfc."""
    low, high = 0.0, 40.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if math.erfc(middle / math.sqrt(2.0)) > probability else (low, middle)
        )
    return low


@pytest.mark.parametrize(
    ("n", "absorbed", "most"),
    [(100, 0, 20), (100, 70, 10), (100, 40, 20), (40, 25, 5), (2000, 0, 300)],
    ids=["a fifth", "a third of 30 freedoms", "a fifth of 60", "a third of 15 freedoms", "300"],
)
def test_a_search_is_given_up_where_too_many_would_go(n, absorbed, most):
    """As many gross errors as may go are found all; one more, and none is left out, with all that
    were found told. At most go a fifth of the readings, a third of the freedoms, and 300. What the
    fit absorbs whole is unchecked."""
    problem = problem_of(n)
    counts = (most, most + 1) if n < 1000 else ()
    assert max_outliers(problem) == min(300, n // 5)
    for count in counts:
        errors = 0.1 * np.ones((n, 1))
        errors[-count:] = 1e3 + np.arange(count)[:, None]
        found = screen_readings(problem, model_of(errors, np.eye(n)[:, :absorbed]))
        gone = {o.configuration for o in (found.outliers or found.given_up)}
        assert len(gone) == most
        assert gone <= set(range(n - count, n))
        assert bool(found.given_up) == (count > most)
        assert found.unchecked == tuple((k, "position") for k in range(absorbed))
