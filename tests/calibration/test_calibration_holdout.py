"""Held-out postures: predictions are as good as they are said to be, and one that is not is no
believable fit.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from helpers.inside import draw_held_out, held_out_count, main, predict_held_out
from helpers.tracker import NOISE, Hexapod
from symkin import InputError, Measurements, calibrate

NOMINAL = Hexapod.nominal()
MECHANISM = NOMINAL.mechanism()


def readings(posed, rng):
    """Positions of the platform with noise, in its own frames."""
    return posed.positions + NOISE * rng.normal(size=posed.positions.shape)


def measured(count, seed, *, known=True):
    rng = np.random.default_rng(seed)
    posed = NOMINAL.spoilt(rng).postures(count, rng)
    return Measurements(
        posed.joints, position=readings(posed, rng), position_sigma=NOISE if known else None
    )


@pytest.mark.long
@pytest.mark.slow
def test_predictions_scatter_as_they_say():
    """Fits to 24 postures predict 12 others: chi-square over its degrees of freedom is 1 to within
    four standard deviations, noise known; that of the noise alone is clearly more, since the
    parameters are uncertain too.
    """
    chi_square, degrees, alone = 0.0, 0, 0.0
    for seed in range(8):
        data = measured(36, seed)
        fit = calibrate(MECHANISM, data.subset(np.arange(24)), outliers="ignore")
        found = predict_held_out(fit, data.subset(np.arange(24, 36)), 0)
        assert not found.unsolved
        chi_square, degrees = chi_square + found.chi_square, degrees + found.degrees
        alone += (found.rms["position"] / NOISE) ** 2 * 36
    assert abs(chi_square / degrees - 1.0) < 4.0 * np.sqrt(2.0 / degrees)
    assert alone / degrees > 1.5


def test_a_draw_takes_whole_groups_and_what_is_read():
    """Members of a group are held out together, rows without a reading never; as many as asked, or
    the last group more.
    """
    groups = np.repeat(np.arange(10), 4)
    groups[36:] = -1
    inclination = np.where(np.arange(40)[:, None] < 38, 0.1, np.nan) * np.ones(2)
    data = Measurements(np.zeros((40, 6)), groups=groups, inclination=inclination)
    for seed in range(20):
        held = draw_held_out(data, 10, seed)
        assert 10 <= held.sum() <= 13
        assert not held[38:].any()
        assert all(len(set(held[groups == k])) == 1 for k in range(9))
    assert not np.array_equal(draw_held_out(data, 10, 1), draw_held_out(data, 10, 2))


def test_postures_that_the_fit_cannot_take_are_told():
    """Where none of those held out has a solution there is no prediction, and no error."""
    data = measured(12, 0)
    fit = calibrate(MECHANISM, data, outliers="ignore", method="nested")
    far = data.subset(np.arange(2))
    found = predict_held_out(fit, replace(far, joints=far.joints * ([1.0] * 5 + [9.0])), 0)
    assert (found.unsolved, found.rms) == (found.labels, {})


@pytest.mark.parametrize("asked", ["", "some", "0", "0%", "40", "100%", "2.5", "-3"])
def test_impossible_numbers_are_refused(asked):
    with pytest.raises(InputError, match="--hold-out"):
        held_out_count(asked, 40)


def fit(folder, data, *options):
    """Exit status and report of the command."""
    (folder / "hexapod.toml").write_text(MECHANISM.to_toml())
    header = ",".join([*(f"leg{k}[mm]" for k in range(1, 7)), "x[mm]", "y[mm]", "z[mm]"])
    rows = np.column_stack([data.joints, data.position])
    (folder / "data.csv").write_text(
        "\n".join([header, *(",".join(map(repr, map(float, row))) for row in rows)]) + "\n"
    )
    with pytest.raises(SystemExit) as ended:
        main(
            [
                "calibrate",
                "fit",
                str(folder / "hexapod.toml"),
                str(folder / "data.csv"),
                "-o",
                str(folder / "out"),
                *options,
            ]
        )
    return ended.value.code or 0, json.loads((folder / "out" / "report.json").read_text())


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("known", [True, False], ids=["noise known", "noise unknown"])
def test_the_command_reports_what_it_held_out(capsys, tmp_path, known):
    """A quarter is not fitted but predicted, by line and with the seed; the verdict, the summary
    and JSON say so.
    """
    noise = ("--sigma-position", f"{NOISE}mm") if known else ()
    status, report = fit(tmp_path, measured(60, 3), "--hold-out", "25%", "--seed", "7", *noise)
    said = capsys.readouterr().out
    held = report["held_out"]
    assert status == 0
    assert report["believable"]
    assert (len(held["postures"]), held["seed"], report["used"]) == (15, 7, 45)
    assert held["degrees"] == 45
    assert held["p_value"] > 1e-3
    assert 0.5 * NOISE < held["rms"]["position"] < 4.0 * NOISE
    assert "15 held-out postures are predicted" in report["verdict"]
    assert "held out, at random with seed 7: 15 postures" in said


@pytest.mark.slow
def test_a_missed_prediction_is_not_believable(tmp_path):
    """Held-out rows that are all 0.3 mm off: the fit is as good as before, and yet not believable,
    with the reason. Of one such row the line is named as an outlier, and the fit stands.
    """
    data = measured(60, 4)
    held = np.flatnonzero(draw_held_out(data, 15, 0))
    for spoilt, believable in ((held, False), (held[:1], True)):
        position = data.position.copy()
        position[spoilt] += 0.3 * np.random.default_rng(5).choice([-1.0, 1.0], (len(spoilt), 3))
        wrong = Measurements(data.joints, position=position)
        _, report = fit(tmp_path, wrong, "--hold-out", "15", "--sigma-position", f"{NOISE}mm")
        assert report["p_value"] > 1e-3
        assert report["believable"] == believable
        if believable:
            assert report["held_out"]["outliers"] == [f"line {held[0] + 2}"]
        else:
            assert "held-out postures are missed by" in report["verdict"]
