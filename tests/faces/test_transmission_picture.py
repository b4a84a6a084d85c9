"""The picture of a transmission: legends cover no mark, and axes tell their units."""

import numpy as np
import pytest

import symkin
from helpers.inside import figure_of_transmission
from helpers.transmissions import G1, G1_RANGES, transmission


@pytest.fixture(scope="module")
def axes():
    """The panels of an ankle whose motors' limits are told."""
    options = {"ranges": G1_RANGES, "torque_limits": 25.0, "speed_limits": 20.0}
    found = symkin.transmission(symkin.load(G1), resolution=1e-3, **options).found[0]
    figure = figure_of_transmission(found)
    figure.canvas.draw()
    return [ax for ax in figure.axes if ax.get_title()]


def test_no_legend_covers_a_panel(axes):
    """Every legend stands outside of what is drawn, of all panels."""
    legends = [ax.get_legend().get_window_extent() for ax in axes]
    assert len(legends) == 6
    for ax in axes:
        assert not any(ax.get_window_extent().overlaps(legend) for legend in legends)


def test_panels_tell_units(axes):
    """Torques are in N m, rates in rad/s, positions and play in rad."""
    torques, rates = axes[2], axes[5]
    assert [torques.get_xlabel(), torques.get_ylabel()] == ["pitch_joint, N m", "roll_joint, N m"]
    assert [rates.get_xlabel(), rates.get_ylabel()] == ["pitch_joint, rad/s", "roll_joint, rad/s"]
    assert axes[0].get_title().endswith("N m")
    assert axes[3].get_title().endswith("rad")


def test_without_limits_torques_are_multiples():
    """Where no torque is told none is called newton metres; the curve of ratios is the verb's, and
    that of torques goes as far.
    """
    found = transmission("four_bar")
    upper, lower = figure_of_transmission(found).axes
    assert "N" not in upper.get_title().split(",")[1]
    reach, whole = (np.ptp(ax.lines[0].get_xdata()) for ax in (upper, lower))
    assert reach > 0.95 * whole
    follower, ratio = lower.lines[0].get_data()
    known = np.isfinite(ratio)
    assert known.sum() > 50
    told = found.inverse_jacobian(joints=follower[known][:, None])[:, 0, 0]
    assert ratio[known] == pytest.approx(told)


@pytest.mark.parametrize("name", ["ankle", "differential"])
def test_a_map_has_no_holes_between_samples(name):
    """Halfway between any two samples that neighbour on the motors' grid the map has a colour, and
    the bar of a map of one torque tells no rounding.
    """
    found = symkin.transmission(symkin.load(name)).found[0]
    figure = figure_of_transmission(found)
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3]
    survey, linkage = found.survey, found.linkage
    motors = np.round(survey.states.w[1:, linkage.places_of(linkage.motors)], 9)
    joints = np.degrees(survey.states.joints[1:])
    numbers = np.column_stack([np.unique(column, return_inverse=True)[1] for column in motors.T])
    place = {tuple(pair): k for k, pair in enumerate(numbers.tolist())}
    halfway = [
        0.5 * (joints[k] + joints[place[a + 1, b]])
        for (a, b), k in place.items()
        if {(a + 1, b), (a, b + 1), (a + 1, b + 1)} <= place.keys()
    ]
    assert len(halfway) > 300
    for ax in figure.axes[:2]:
        x, y = np.rint(ax.transData.transform(np.array(halfway))).astype(int).T
        assert (pixels[y, x] < 250).any(axis=1).all()
    bars = [ax for ax in figure.axes if not ax.get_title()]
    for bar, torque in zip(bars, survey.alone.T, strict=True):
        low, high = bar.get_ylim()
        assert high - low > 0.1 * torque.max()
