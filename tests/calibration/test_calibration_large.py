"""Fits of many postures: a part at a time, with the results of the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers import inside
from helpers.inclinometer import geometry, measured, random_geometry
from helpers.tracker import NOISE, Hexapod
from symkin import Measurements, calibrate, load

HEXAPOD = Hexapod.nominal()
PLATFORM = load("ren2008")


def positions(seed=0, count=70):
    rng = np.random.default_rng(seed)
    posed = HEXAPOD.spoilt(rng).postures(count, rng)
    read = posed.positions + NOISE * rng.normal(size=(count, 3))
    read[5, 1], read[17] = np.nan, np.nan
    read[30] += 1.0
    return HEXAPOD.mechanism(), Measurements(
        posed.joints, position=read, position_sigma=NOISE, joint_sigma=0.5 * NOISE
    )


def groups(seed=0):
    """Twelve groups of four, in mixed order, and some postures without one."""
    rng = np.random.default_rng(seed)
    data = measured(random_geometry(geometry(PLATFORM), (), 0.002, rng), rng, 12, noisy=True)
    numbers = np.where(np.arange(len(data)) < 3, -1, data.groups)
    return PLATFORM, replace(data, groups=numbers).subset(rng.permutation(len(data)))


def fitted(case, residual, method):
    mechanism, data = case()
    return calibrate(mechanism, data, residual=residual, method=method)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "residual", "method"),
    [
        (positions, "means", "nested"),
        (positions, "maximum likelihood", "lifted"),
        (groups, "means", "nested"),
        (groups, "differences", "nested"),
        (groups, "maximum likelihood", "nested"),
    ],
)
def test_parts_give_the_fit_of_the_whole(monkeypatch, case, residual, method):
    """Values, standard deviations, chi-square, residuals, outliers and notes are those of all
    postures taken together.
    """
    whole = fitted(case, residual, method)
    monkeypatch.setattr(inside.fit_problem, "MAX_WHOLE_ROWS", 20)
    monkeypatch.setattr(inside.fit_problem, "PART_ROWS", 9)
    found = fitted(case, residual, method)
    assert found.problem.is_large
    assert len(found.problem.parts) > 3
    assert sorted(np.concatenate([rows for rows, _ in found.problem.parts])) == list(
        range(len(found.used))
    )
    assert (found.status, found.rank, found.degrees) == (whole.status, whole.rank, whole.degrees)
    assert found.chi_square == pytest.approx(whole.chi_square, rel=1e-6)
    for ours, theirs in zip(found.parameters, whole.parameters, strict=True):
        assert abs(ours.value - theirs.value) < 1e-3 * theirs.sigma + 1e-9
        assert ours.sigma == pytest.approx(theirs.sigma, rel=1e-5, abs=1e-12)
    assert [o.label for o in found.outliers] == [o.label for o in whole.outliers]
    assert len(found.notes) == len(whole.notes)
    for ours, theirs in zip(found.residuals, whole.residuals, strict=True):
        assert (ours.configuration, ours.kind, ours.component) == (
            theirs.configuration,
            theirs.kind,
            theirs.component,
        )
        assert ours.normalised == pytest.approx(theirs.normalised, abs=2e-3)


def test_members_of_a_group_stay_together(monkeypatch):
    """No group is divided, however large it is."""
    monkeypatch.setattr(inside.fit_problem, "MAX_WHOLE_ROWS", 20)
    monkeypatch.setattr(inside.fit_problem, "PART_ROWS", 5)
    mechanism, data = groups()
    made = inside.fit_problem.build_calibration(mechanism, data)
    for rows, part in made.parts:
        held = set(data.groups[rows].tolist()) - {-1}
        assert all(set(np.flatnonzero(data.groups == k)) <= set(rows.tolist()) for k in held)
        assert len(part.measurements) == len(rows) < 9
