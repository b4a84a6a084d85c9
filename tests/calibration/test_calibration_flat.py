"""Fits along flat valleys: parameters that readings tell to second order only, and closures that
leave rows to the parameters.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import (
    Noise,
    Workspace,
    fit_file,
    group_numbers,
    match_parameters,
    random_configurations,
    read_measurements,
    simulate_readings,
)
from helpers.measured_files import write_measurements
from helpers.samples import three_rrr
from symkin import InputError, calibrate


def three_rps():
    """Three limbs R P S at 120 degrees; each P axis meets its R axis, so that the offset between
    them counts in its square.
    """
    limbs = []
    for k in range(3):
        c, s = np.cos(2 * np.pi * k / 3 + 0.26), np.sin(2 * np.pi * k / 3 + 0.26)
        joints = [
            symkin.Joint(f"r{k}", "R", point=(0.3 * c, 0.3 * s, 0.0), axis=(-s, c, 0.0)),
            symkin.Joint(
                f"p{k}", "P", axis=(-0.1 * c, -0.1 * s, 0.5), actuated=True, limits=(-0.15, 0.2)
            ),
            symkin.Joint(f"s{k}", "S", point=(0.2 * c, 0.2 * s, 0.5)),
        ]
        limbs.append(symkin.Limb(f"limb{k}", joints))
    return symkin.Mechanism("rps", limbs, length_unit="m", platform_position=(0.0, 0.0, 0.5))


def five_bar(motion="spatial"):
    up = (0.0, 0.0, 1.0)
    tip = (0.0, 100 + 75 * np.sqrt(3), 0.0)
    left = [
        symkin.Joint("crank1", "R", point=(-75.0, 0.0, 0.0), axis=up, actuated=True),
        symkin.Joint("elbow1", "R", point=(-75.0, 100.0, 0.0), axis=up),
    ]
    right = [
        symkin.Joint("crank2", "R", point=(75.0, 0.0, 0.0), axis=up, actuated=True),
        symkin.Joint("elbow2", "R", point=(75.0, 100.0, 0.0), axis=up),
        symkin.Joint("tip", "R", point=tip, axis=up),
    ]
    return symkin.Mechanism(
        "five",
        [symkin.Limb("left", left), symkin.Limb("right", right)],
        platform_position=tip,
        motion=motion,
    )


def measured(mechanism, readings, noise, seed=0, count=40):
    rng, groups = np.random.default_rng(seed), group_numbers(count, 0)
    return simulate_readings(
        mechanism,
        random_configurations(Workspace.about(mechanism), groups, noise, rng),
        groups,
        readings,
        noise,
        rng,
    )


def quiet(mechanism):
    size = mechanism.characteristic_length
    return Noise(
        lengths=1e-6 * size,
        angles=np.radians(1e-3),
        position=1e-5 * size,
        orientation=np.radians(1e-3),
    )


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("hold", [None, "*.axis.*"])
def test_rps_platforms_are_calibrated(tmp_path, hold):
    """Data of the nominal geometry with noise, three seeds: converged, chi-square as expected, not
    worse than the nominal geometry, and the poses known to a few times the noise.
    """
    mechanism = three_rps()
    for seed in range(3):
        write_measurements(
            tmp_path / "d.csv", mechanism, measured(mechanism, ("pose",), quiet(mechanism), seed)
        )
        report = fit_file(mechanism, read_measurements(tmp_path / "d.csv", mechanism), hold=hold)
        assert report.usable, report.verdict
        assert 1e-3 < report.fit.p_value < 1 - 1e-3
        assert np.median(report.sigma.position) < 5e-5 * mechanism.characteristic_length


@pytest.mark.long
@pytest.mark.slow
def test_an_overconstrained_five_bar_is_calibrated(tmp_path):
    """All parameters of a closure with rows left over, two seeds: converged, its rows met to
    rounding, chi-square as expected.
    """
    mechanism = five_bar()
    for seed in range(2):
        write_measurements(
            tmp_path / "d.csv",
            mechanism,
            measured(mechanism, ("position",), quiet(mechanism), seed),
        )
        report = fit_file(mechanism, read_measurements(tmp_path / "d.csv", mechanism))
        assert report.fit.status == "ok"
        assert report.usable, report.verdict
        assert report.fit.p_value > 1e-3
        assert (
            np.max(np.abs(report.fit.state.leftover[0])) < 1e-10 * mechanism.characteristic_length
        )


@pytest.mark.slow
@pytest.mark.parametrize(("build", "readings"), [(three_rps, "pose"), (five_bar, "position")])
def test_without_noise_the_iteration_goes_on_to_rounding(build, readings):
    """Exact readings of the nominal geometry: residuals of rounding, no parameter moved."""
    mechanism = build()
    data = measured(mechanism, (readings,), Noise())
    fit = calibrate(mechanism, data, outliers="ignore")
    assert fit.status == "ok"
    assert max(abs(r.value) for r in fit.residuals) < 1e-11 * mechanism.characteristic_length
    assert max(abs(p.change) for p in fit.parameters) < 1e-8 * mechanism.characteristic_length


@pytest.mark.slow
def test_what_a_motion_binds_is_left_out_and_said(tmp_path):
    """Planar motion: the default and patterns leave tilts of axes out with a note; one named in
    full is refused with the remedy.
    """
    mechanism = five_bar("planar")
    path = tmp_path / "d.csv"
    write_measurements(path, mechanism, measured(mechanism, ("position",), quiet(mechanism)))
    data = read_measurements(path, mechanism)
    for patterns in (None, "all", "left.*"):
        report = fit_file(mechanism, data, parameters=patterns)
        assert report.usable, report.verdict
        assert not {"left.crank1.axis.x", "left.elbow1.axis.y"} & set(report.fit.values)
        assert any(
            "bound by the planar motion" in note and "left.crank1.axis.x" in note
            for note in report.notes
        )
    assert "left.crank1.axis.x" in match_parameters(mechanism, "left.crank1.axis.x")
    with pytest.raises(
        InputError,
        match="leave it out of the parameters to identify, hold it, or declare the motion spatial",
    ):
        fit_file(mechanism, data, parameters="left.crank1.axis.x,left.elbow1.point.x")


@pytest.mark.parametrize("turned", [True, False])
def test_a_planar_machine_is_not_told_of_frames_beside_its_plane(turned):
    """All three coordinates of a planar platform are read: heights and tilts, which no reading
    tells and no use asks, are no advice; the turn about the plane's normal, where it is not read,
    is.
    """
    mechanism = three_rrr("planar")
    data = measured(mechanism, ("pose",), Noise(position=1e-3, orientation=1e-5))
    position = data.position * [1.0, 1.0, np.nan]
    data = replace(data, position=position, orientation=data.orientation if turned else None)
    found = calibrate(mechanism, data).identifiability
    assert "base frame translation z" in found.unobservable
    assert any("frames are free" in text for text in found.advice) is not turned
