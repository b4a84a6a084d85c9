"""Gross errors and robust losses, on a controller's log of a hexapod made in NumPy (see
`hexapod_log`).
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import hexapod_log
from helpers.inclinometer import (
    BASE_LIMBS,
    PLATFORM_LIMBS,
    geometry,
    measured,
    random_geometry,
)
from helpers.inside import Fit, estimate, joint_frames, main, outliers
from helpers.measured_files import write_measurements
from symkin import calibrate

INCLINED = symkin.load("ren2008")
HELD = joint_frames(INCLINED, PLATFORM_LIMBS, BASE_LIMBS)


@pytest.fixture(scope="module")
def logged():
    rng = np.random.default_rng(2)
    return hexapod_log.off_nominal(rng), hexapod_log.log(rng, 60), rng


def misfit(mechanism):
    """Largest distance of joint centres from the true ones, after the best rigid motions: none is
    needed where poses are read whole.
    """
    pairs = zip(mechanism.limbs, hexapod_log.TRUTH.limbs, strict=True)
    return max(float(np.linalg.norm(np.subtract(a.base, b.base))) for a, b in pairs)


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False], ids=["noise stated", "noise unknown"])
@pytest.mark.parametrize(
    ("share", "size"), [(0.02, 1e-4), (0.3, 5e-3), pytest.param(0.4, 1e-4, marks=pytest.mark.long)]
)
def test_gross_errors_are_found_and_no_others(logged, share, size, stated):
    """2 to 40 % of the positions off by normal errors: these are left out, hardly another, and the
    rest fits as without them; the lines give shift and statistic as they are.
    """
    nominal, data, rng = logged
    bad, rows = hexapod_log.spoilt(data, share, size, rng)
    fit = calibrate(nominal, bad if stated else hexapod_log.unstated(bad))
    found = {o.configuration for o in fit.outliers}
    far = {
        int(k)
        for k in rows
        if np.linalg.norm(bad.position[k] - data.position[k]) > 20 * hexapod_log.SCATTER
    }
    assert fit.refused is None
    assert far <= found
    assert len(found - set(rows.tolist())) <= 1
    assert (
        np.sqrt(np.mean([r.value**2 for r in fit.residuals if r.kind == "position"]))
        < 1.3 * hexapod_log.SCATTER
    )
    for o in fit.outliers:
        np.testing.assert_allclose(
            o.shift, (bad.position - data.position)[o.configuration], atol=10 * hexapod_log.SCATTER
        )
        assert float(re.search(r"statistic (\S+) with", o.reason)[1]) > 10
        assert "e-4" not in o.reason.split("probability")[1]


@pytest.mark.long
@pytest.mark.slow
def test_no_removal_loses_the_fit():
    """Six drawings of one machine, all off by millimetres: the same geometry, believable, and none
    of the clean rows called bad but by chance.
    """
    rng = np.random.default_rng(7)
    data = hexapod_log.log(rng, 150)
    for _ in range(6):
        fit = calibrate(hexapod_log.off_nominal(rng), data)
        assert fit.believable
        assert len(fit.outliers) <= 1
        assert misfit(fit.corrected) < 1e-4


def test_a_removal_that_does_not_converge_is_undone(logged):
    """Refits that fail: the first fit stays as it was, with all its readings, and is not refused
    for them.
    """
    nominal, data, rng = logged
    bad, _ = hexapod_log.spoilt(data, 0.02, 5e-6, rng)
    first = calibrate(nominal, bad, outliers="ignore")
    begun = []

    def fit(readings, near):
        begun.append(near)
        return replace(found, status="stalled")

    result = estimate(first.problem, first.state.z, p=first.state.p)
    found = Fit(
        **vars(result),
        problem=first.problem,
        used=np.arange(60),
        unsolved=np.zeros(0, dtype=int),
        start_signs=first.state.determinant_signs,
    )
    made, screening = outliers.fit_without_outliers(fit, bad, found, 0.02)
    assert made is found
    assert screening.refused is None
    assert not screening.outliers
    np.testing.assert_array_equal(begun[0].state.p, result.state.p)


@pytest.mark.slow
def test_too_many_gross_errors_are_refused(logged):
    """A leg of two thirds of the rows off by millimetres, which spoils position and orientation:
    refused, for gross errors.
    """
    nominal, data, rng = logged
    joints = data.joints.copy()
    joints[np.arange(40), rng.integers(6, size=40)] += 5e-3 * rng.normal(size=40)
    fit = calibrate(nominal, replace(data, joints=joints))
    assert "gross errors" in fit.refused
    assert "readings are off by more than chance allows" in fit.refused
    assert not fit.believable


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_robust_losses_keep_to_the_majority(capsys, tmp_path, logged, loss):
    """A tenth of the rows off by 0.1 mm and none left out: joint centres many times nearer to the
    truth than by least squares; without bad rows the same within the standard deviations, which are
    larger by 1 / sqrt(0.95); the report says what the loss does.
    """
    nominal, data, rng = logged
    bad, _ = hexapod_log.spoilt(data, 0.1, 1e-4, rng)
    robust, squares = (
        calibrate(nominal, bad, loss=k, outliers="ignore") for k in (loss, "squared")
    )
    assert misfit(robust.corrected) < 0.25 * misfit(squares.corrected)
    robust, squares = (
        calibrate(nominal, data, loss=k, outliers="ignore") for k in (loss, "squared")
    )
    for a, b in zip(robust.parameters, squares.parameters, strict=True):
        assert abs(a.value - b.value) < 2 * b.sigma
        assert a.sigma == pytest.approx(b.sigma / np.sqrt(0.95), rel=1e-3)
    (tmp_path / "m.toml").write_text(nominal.to_toml())
    write_measurements(tmp_path / "d.csv", nominal, data.subset(np.arange(20)))
    with pytest.raises(SystemExit) as ended:
        main(
            [
                "calibrate",
                "fit",
                str(tmp_path / "m.toml"),
                str(tmp_path / "d.csv"),
                "-o",
                str(tmp_path / "out"),
                "--loss",
                loss,
            ]
        )
    assert ended.value.code == 0
    notes = json.loads((tmp_path / "out" / "report.json").read_text())["notes"]
    assert any(f"loss {loss}: readings count less from" in note for note in notes)


@pytest.mark.parametrize("left_out", [0, 4, 9])
def test_what_is_put_back_is_judged_as_a_reading_that_took_no_part(logged, left_out):
    """The statistic of a clean reading that was left out is what chi-square grows by once it takes
    part: its error counts beside the noise and the estimate's own covariance. Few postures, so that
    the latter is not small. Its probability is the tail of chi-square of three degrees of freedom.
    """
    nominal, data, _ = logged
    few = data.subset(np.arange(12))
    with_it, without = (
        calibrate(nominal, few),
        calibrate(nominal, few.without(left_out, "position")),
    )
    assert with_it.outliers == without.outliers == ()
    outlier = outliers.Outlier(left_out, "position", 0.0, 3)
    (judged,) = outliers._retest(few, without, [outlier])
    grown = with_it.chi_square - without.chi_square
    assert judged.statistic == pytest.approx(grown, rel=0.02, abs=0.02)
    half = judged.statistic / 2
    tail = math.erfc(math.sqrt(half)) + 2 * math.sqrt(half / math.pi) * math.exp(-half)
    assert judged.probability == pytest.approx(tail, rel=1e-9)


def left_out(case, rng):
    """Clean readings of a machine off nominal, and one of them; few postures, so that the estimate
    is uncertain, too.
    """
    if case == "groups":
        truth = random_geometry(geometry(INCLINED), HELD, 1e-3, rng)
        data = measured(truth, rng, noisy=True)
        return INCLINED, data, "group", HELD
    nominal, data = hexapod_log.off_nominal(rng), hexapod_log.log(rng, 24 - 10 * (case == "poses"))
    if case == "positions, noise unknown":
        data = replace(hexapod_log.unstated(data), orientation=None)
    return nominal, data, "position", ()


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("case", ["poses", "positions, noise unknown", "groups"])
def test_probabilities_of_clean_readings_that_were_left_out_are_uniform(case):
    """Over 60 sets, by the test of Kolmogorov and Smirnov at 1 %: sqrt(n) times the largest gap
    between the distributions is below 1.63.
    """
    chances, count = [], 60
    for seed in range(count):
        rng = np.random.default_rng(seed)
        nominal, data, kind, fixed = left_out(case, rng)
        k = int(rng.integers(len(data)))
        fit = calibrate(nominal, data.without(k, kind), fixed=fixed, outliers="ignore")
        outlier = outliers.Outlier(k, kind, 0.0, 3)
        (judged,) = outliers._retest(data, fit, [outlier])
        chances.append(judged.probability)
    steps, chances = np.arange(count + 1) / count, np.sort(chances)
    apart = max(np.max(steps[1:] - chances), np.max(chances - steps[:-1]))
    assert np.sqrt(count) * apart < 1.63


def test_where_all_readings_are_put_back_none_is_tested_again():
    """Every outlier agrees with the last fit: there is nothing left to compare with it."""
    assert outliers._retest(None, None, []) == []
