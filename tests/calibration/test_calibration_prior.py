"""The prior: what the readings hardly tell stays near nominal, what they tell is theirs alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.built_machines import built, explained_errors, random_postures
from helpers.gate import in_gate
from helpers.inside import (
    Noise,
    build_calibration,
    chi_square_tail,
    evaluate_state,
    lines_problem,
    nearest_rows,
    simulate_readings,
    table_of_lines,
    told_directions,
)
from symkin import InputError, calibrate

MACHINES = {
    "three_rps": samples.three_rps,
    "delta": lambda: replace(samples.delta(), motion="spatial"),
    "five_bar": lambda: replace(samples.five_bar(), motion="planar"),
}
STUCK = {"stuck": samples.five_bar}


def drawn(name, seed, off=1e-3, noise=1e-4, count=32):
    """A machine, and whole poses of one whose geometry is off by `off` of its size."""
    nominal, rng = (MACHINES | STUCK)[name](), np.random.default_rng([seed, len(name)])
    true, size = built(nominal, off, rng), nominal.characteristic_length
    made = random_postures(nominal, true, count, rng)
    stated = Noise(position=noise * size, orientation=noise)
    return nominal, simulate_readings(true, made, np.full(count, -1), ("pose",), stated, rng)


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(MACHINES, ["five_bar"]))
def test_machines_whose_readings_tell_some_of_it_are_calibrated(name):
    """Directions that poses tell to a few per cent of the size only: the fit ends in few steps and
    is believable.
    """
    for seed in range(2):
        nominal, data = drawn(name, seed)
        fit = calibrate(nominal, data)
        assert fit.status == "ok"
        assert fit.believable
        assert fit.iterations <= 30
        assert all("hardly told" not in text for text in fit.unobservable)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["three_rps", "delta"])
def test_the_estimate_is_what_readings_and_prior_ask_for(name):
    """In directions that the readings tell ten times better than the prior the gradient of
    chi-square vanishes; in the others that of chi-square and the prior together.
    """
    nominal, data = drawn(name, 3)
    fit = calibrate(nominal, data, outliers="ignore")
    problem, told = fit.problem, told_directions(fit.problem, fit.state)
    state = evaluate_state(problem.by_means, fit.state.p, fit.state.z)
    by_readings = told.columns.T @ (state.linearised.matrix.T @ state.linearised.vector)
    change = (fit.state.p - problem.model.nominal) / problem.model.scales / problem.prior**2
    by_prior = told.columns.T @ change
    well = told.ratios > 10.0
    assert np.any(well)
    assert np.any(~well)
    # the file holds values to rounding of its digits, so that gradients are small and not zero
    assert np.max(np.abs(by_readings[well] / told.ratios[well])) < 1e-5
    assert np.max(np.abs((by_readings + by_prior)[~well])) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("seed", in_gate([0, 1, 2], [0]))
def test_noise_moves_nothing_that_readings_do_not_tell(seed):
    """An arm whose three parallel axes may share their offsets in any way: in the directions that
    the readings do not tell the change from the file's geometry is none, whatever the noise.
    """
    nominal, rng = symkin.load("ur5e"), np.random.default_rng(seed)
    true, noise = built(nominal, 1e-3, rng), 1e-4
    made, groups = random_postures(nominal, true, 40, rng), np.full(40, -1)
    stated = Noise(position=noise * nominal.characteristic_length, orientation=noise)
    data = simulate_readings(true, made, groups, ("pose",), stated, rng)
    problem, state = (fit := calibrate(nominal, data, outliers="ignore")).problem, fit.state
    change = (state.p - problem.model.nominal) / problem.model.scales / problem.prior
    _, told, right = np.linalg.svd(state.linearised.matrix * problem.prior)
    silent = right[told < 0.1]
    assert len(silent) == 2
    assert np.max(np.abs(silent @ change)) < 1e-6
    assert np.max(np.abs(change)) > 0.1


@pytest.mark.slow
def test_angles_far_worse_than_positions_move_no_offset():
    """Positions to 0.01 mm and angles to 0.2 degrees, neither stated: weighed alike, the angles
    moved the offsets of parallel axes by a hundred sizes.
    """
    nominal, rng = symkin.load("ur5e"), np.random.default_rng(1)
    true, noise = built(nominal, 1e-3, rng), Noise(position=0.01, orientation=np.radians(0.2))
    made, groups = random_postures(nominal, true, 40, rng), np.full(40, -1)
    data = simulate_readings(true, made, groups, ("pose",), noise, rng)
    fit = calibrate(nominal, replace(data, position_sigma=None, orientation_sigma=None))
    assert fit.problem.estimated == pytest.approx(
        {"position": noise.position, "orientation": noise.orientation}, rel=0.3
    )
    changes = (fit.state.p - fit.problem.model.nominal) / fit.problem.model.scales
    assert np.max(np.abs(changes)) < 0.02 * nominal.characteristic_length
    assert not fit.outliers


@pytest.mark.slow
def test_steps_follow_bent_valleys():
    """A delta built a per cent off its file: what its poses hardly tell lies along valleys that
    bend; a fit that goes straight ahead in them is not at the minimum after sixty steps.
    """
    for seed in (6, 7):
        nominal, data = drawn("delta", seed, off=1e-2)
        fit = calibrate(nominal, data, outliers="ignore")
        assert fit.status == "ok"
        assert fit.iterations <= 30


@pytest.mark.slow
def test_standard_deviations_hold_where_the_readings_hardly_tell_the_geometry():
    """A delta by positions: half of what its parameters may do is hardly told, and along it they
    stray by a share of a per cent of the size, through curved valleys. What the fits say of the
    readings is off the readings without errors by as much as the covariance says, and single
    parameters scatter by no more than their standard deviations.
    """
    nominal, rng = replace(symkin.load("delta"), motion="spatial"), np.random.default_rng(5)
    true, noise = built(nominal, 1e-3, rng), Noise(position=1e-4 * nominal.characteristic_length)
    made, groups = random_postures(nominal, true, 40, rng), np.full(40, -1)
    exact = replace(
        simulate_readings(true, made, groups, ("position",), Noise(), rng),
        position_sigma=noise.position,
    )
    errors, values, sigmas = [], [], []
    for _ in range(8):
        fit = calibrate(
            nominal,
            simulate_readings(true, made, groups, ("position",), noise, rng),
            outliers="ignore",
        )
        errors.append(explained_errors(fit, exact))
        values.append([p.value for p in fit.parameters])
        sigmas.append([p.sigma for p in fit.parameters])
    every = np.concatenate(errors)
    assert len(every) > 60
    assert 1e-3 < chi_square_tail(float(every @ every), len(every)) < 1.0 - 1e-3
    scatter = np.std(values, axis=0, ddof=1) / np.sqrt(np.mean(np.square(sigmas), axis=0))
    assert np.max(scatter) < 1.7


@pytest.mark.slow
@pytest.mark.parametrize(("off", "believed"), [(3.0, True), (-6.0, False)])
def test_a_reading_beyond_chance_is_not_believed_though_chi_square_passes(off, believed):
    """Of some hundred residuals one of three standard deviations is chance, one of six is a reading
    that was kept and does not belong, however well chi-square passes with it.
    """
    nominal, data = drawn("five_bar", 0)
    fit = calibrate(nominal, data, outliers="ignore")
    assert fit.believable
    first, *others = fit.residuals
    spoilt = replace(fit, residuals=(replace(first, normalised=off), *others))
    assert spoilt.p_value == fit.p_value
    assert spoilt.believable == believed
    assert (spoilt.stray is None) == believed


@pytest.mark.slow
def test_a_reversed_sign_fits_another_machine():
    """A joint column with its sign reversed: the readings fit, and nothing is believable."""
    nominal, data = drawn("delta", 1)
    joints = data.joints * np.array([1.0, -1.0, 1.0])
    assert not calibrate(nominal, replace(data, joints=joints)).believable


def test_a_machine_that_does_not_move_is_not_simulated():
    """A five-bar whose axes are not quite parallel closes at its reference alone."""
    with pytest.raises(InputError, match="does not move; 32 random postures are one"):
        drawn("stuck", 0)


def test_neighbours_do_not_depend_on_units():
    """Angles beside lengths: the nearest rows are the same in metres and in micrometres."""
    rng = np.random.default_rng(0)
    joints, wanted = rng.normal(size=(30, 3)), rng.normal(size=(5, 3))
    units = np.array([1.0, 1e6, 1.0])
    ours, theirs = nearest_rows(joints, wanted, 4), nearest_rows(units * joints, units * wanted, 4)
    np.testing.assert_array_equal(ours, theirs)


def test_without_noise_stated_nothing_is_tested():
    """A sound fit without standard deviations and held-out postures is not believable but not
    tested, and the JSON says so.
    """
    nominal, data = drawn("five_bar", 2)
    fit = calibrate(nominal, replace(data, position_sigma=None, orientation_sigma=None))
    assert fit.sound
    assert not fit.believable
    assert fit.to_dict(residuals=False)["tested"] is False
    assert calibrate(nominal, data).to_dict(residuals=False)["tested"] is True


def test_a_joint_reading_beyond_all_measure_is_refused():
    """A slip of 1e300 is named with its posture and joint."""
    arm = symkin.load("gluon_6l3")
    joints = np.zeros((3, 6))
    joints[1, 2] = 1e300
    data = symkin.Measurements(joints, position=np.zeros((3, 3)))
    with pytest.raises(InputError, match=r"posture 2 reads 1e\+300 of q3"):
        calibrate(arm, data)


@pytest.mark.parametrize("convention", in_gate(["standard", "modified"], ["standard"]))
def test_lines_are_written_as_the_table_that_they_are_of(convention):
    """Of random tables, angles by whole turns as the file has them."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        rows = [symkin.DHRow(f"q{k}", "R", *rng.uniform(-4.0, 4.0, 4)) for k in range(1, 7)]
        arm = symkin.serial_arm_from_dh("arm", symkin.DHTable(convention, rows))
        problem = build_calibration(
            arm, symkin.Measurements(np.zeros((9, 6)), position=np.zeros((9, 3)))
        )
        lines = lines_problem(problem)
        found = table_of_lines(problem, lines, lines.model.nominal)
        np.testing.assert_allclose(found, problem.model.nominal, atol=1e-9)
