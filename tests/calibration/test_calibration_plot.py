"""Pictures of a calibration show the figures of the fit."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.inside import (
    MEASURING_FRAMES,
    default_parameters,
    parameter_figure,
    picture,
    pose_sigma_figure,
    predict_pose_sigma,
)
from helpers.tracker import NOISE, WORLD_POSITION, Hexapod
from symkin import Measurements, calibrate


@pytest.fixture(scope="module")
def case():
    """A hexapod seen by a tracker: postures and fit."""
    rng = np.random.default_rng(0)
    nominal = Hexapod.nominal()
    posed, mechanism = nominal.spoilt(rng).postures(60, rng), nominal.mechanism()
    data = Measurements(
        posed.joints, position=posed.seen() + NOISE * rng.normal(size=(60, 3)), position_sigma=NOISE
    )
    return posed, calibrate(
        mechanism, data, parameters=(*default_parameters(mechanism), *MEASURING_FRAMES[:9])
    )


def bars(axes):
    return [patch.get_width() for patch in axes.patches]


def test_changes_stand_beside_changes_over_sigma(case):
    """One bar a parameter in both panels, the second the first over its standard deviation;
    measuring frames, which have no nominal place, are not among them.
    """
    _, fit = case
    left, right = parameter_figure(fit).axes
    own = [p for p in fit.parameters if p.name not in MEASURING_FRAMES]
    assert [label.get_text() for label in left.get_yticklabels()] == [p.name for p in own]
    assert bars(left) == pytest.approx([p.change for p in own])
    assert bars(right) == pytest.approx([p.change / p.sigma for p in own])
    low, high = right.get_xlim()
    assert all(low < width < high for width in bars(right))


def test_measured_poses_stand_on_the_map(case):
    """In the mechanism's own base frame, also where they were seen from elsewhere, in both
    views.
    """
    posed, fit = case
    sigma = predict_pose_sigma(fit)
    panels = [axes for axes in pose_sigma_figure(fit, sigma).axes if axes.lines]
    for axes, up in zip(panels, (1, 2), strict=True):
        drawn = np.column_stack(axes.lines[0].get_data())
        assert np.max(np.abs(drawn - posed.positions[list(fit.used)][:, [0, up]])) < 5.0
    assert np.linalg.norm(WORLD_POSITION) > 1000.0


def test_unknown_sigma_is_said():
    """Where no degree of freedom is left there is no standard deviation, and the second panel says
    so.
    """
    nominal = Hexapod.nominal()
    posed = nominal.postures(2, np.random.default_rng(1))
    fit = calibrate(
        nominal.mechanism(),
        Measurements(posed.joints, position=posed.positions),
        parameters=[f"leg{k}.offset" for k in range(1, 7)],
    )
    figure = parameter_figure(fit)
    assert figure.axes[1].get_title(loc="left") == "sigma unknown"
    assert picture(figure).startswith(b"\x89PNG")
