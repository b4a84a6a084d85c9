"""Estimators: exact data give back the exact geometry, every form agrees, and nothing is dropped in
silence.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inclinometer import (
    BASE_LIMBS,
    PLATFORM_LIMBS,
    geometry,
    measured,
    random_geometry,
)
from helpers.inside import (
    FORMS,
    METHODS,
    build_calibration,
    build_closure,
    build_model,
    default_parameters,
    joint_frames,
    nominal_parameters,
    parse,
    solve_configurations,
    with_parameters,
)
from helpers.inside import evaluate_state as evaluate
from helpers.samples import five_bar, three_rrr
from symkin import InputError, Measurements, Reading, calibrate

NOMINAL = symkin.load("ren2008")
HELD = joint_frames(NOMINAL, PLATFORM_LIMBS, BASE_LIMBS)


def largest_error(fit, truth) -> float:
    free = [p for p in fit.parameters if not p.held]
    return float(np.max(np.abs([p.value - truth.value(p.name) for p in free])))


def poses_measured(
    mechanism, joints, truth, *, names=None, orientation=True, sigma=1e-3, noise=0.0, seed=0
):
    """Full poses (or positions) of the mechanism with other parameter values, from the model
    itself.
    """
    names = default_parameters(mechanism) if names is None else names
    blank = Measurements(
        joints,
        position=np.zeros((len(joints), 3)),
        orientation=np.tile([1.0, 0, 0, 0], (len(joints), 1)),
    )
    model = build_model(mechanism, blank, names)
    near = solve_configurations(model, Measurements(joints), model.nominal)
    found = solve_configurations(model, Measurements(joints), truth, z=near.z)
    keep = near.solved & found.solved
    poses = model.poses(found.z, joints, truth)[keep]
    positions = poses[:, :3] + noise * np.random.default_rng(seed).normal(size=(len(poses), 3))
    turns = (
        {"orientation": poses[:, 3:], "orientation_sigma": sigma / mechanism.characteristic_length}
        if orientation
        else {}
    )
    return Measurements(
        joints[keep], position=positions, position_sigma=sigma, starts=poses, **turns
    ), poses


# --- noise-free recovery --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spread", "seeds"),
    [(0.05, range(2)), *(pytest.param(s, range(8), marks=pytest.mark.long) for s in (0.005, 0.05))],
)
def test_exact_data_give_the_exact_geometry(spread, seeds):
    """Without noise the identified parameters are the true ones to 1e-12 m, from 5 and from 50 mm
    away.
    """
    for seed in seeds:
        rng = np.random.default_rng(seed)
        truth = random_geometry(geometry(NOMINAL), HELD, spread, rng)
        fit = calibrate(NOMINAL, measured(truth, rng, rods=False), fixed=HELD, outliers="ignore")
        assert fit.status == "ok"
        assert largest_error(fit, truth) < 1e-12


@pytest.mark.slow
def test_names_of_methods_of_before_are_one():
    """They give the same numbers, and a note that says so."""
    rng = np.random.default_rng(4)
    truth = random_geometry(geometry(NOMINAL), HELD, 0.005, rng)
    data = measured(truth, rng, noisy=True)
    first, *others = (
        calibrate(NOMINAL, data, fixed=HELD, method=m, outliers="ignore") for m in METHODS
    )
    assert not any("method" in note for note in first.notes)
    for fit in others:
        assert fit.values == first.values
        assert any(f"{fit.method!r} is one with 'nested'" in note for note in fit.notes)


# --- derivatives ----------------------------------------------------------------------------------


@pytest.mark.parametrize("form", FORMS[:2])
def test_condensed_derivatives_are_those_of_the_direct_problem(form):
    """dr/dp of the condensed system equals central differences of residuals over solved
    postures.
    """
    rng = np.random.default_rng(6)
    truth = random_geometry(geometry(NOMINAL), HELD, 0.005, rng)
    problem = build_calibration(NOMINAL, measured(truth, rng, 3), fixed=HELD, residual=form)
    model, data = problem.model, problem.measurements
    z = solve_configurations(model, data, model.nominal).z
    exact = evaluate(problem, model.nominal, z).linearised.matrix
    for k in (0, 7, 20):
        step = np.zeros(len(model.nominal))
        step[k] = 1e-6 * model.scales[k]
        ends = []
        for sign in (1, -1):
            p = model.nominal + sign * step
            there = solve_configurations(model, data, p, z=z).z
            ends.append(evaluate(problem, p, there).linearised.vector)
        column = (ends[0] - ends[1]) / 2e-6
        assert np.max(np.abs(column - exact[:, k])) < 1e-6 * np.max(np.abs(exact))


# --- other mechanisms and readings ----------------------------------------------------------------


def test_serial_arm_by_dh_from_full_poses():
    """A 6R arm's DH table is found from full poses, and the corrected arm takes those poses."""
    arm = symkin.load("gluon_6l3")
    rng = np.random.default_rng(7)
    names = default_parameters(arm)
    nominal = nominal_parameters(arm)
    scale = np.array(
        [1.0 if nominal[n][1] == "length" else 1 / arm.characteristic_length for n in names]
    )
    truth = np.array(
        [nominal[n][0] for n in names]
    ) + 0.01 * arm.characteristic_length * scale * rng.uniform(-1, 1, len(names))
    data, poses = poses_measured(arm, rng.uniform(-2, 2, (30, 6)), truth)
    fit = calibrate(arm, data)
    assert fit.status == "ok"
    for joints, pose in zip(data.joints[:5], poses[:5], strict=True):
        there = symkin.solve(fit.corrected, joints=np.degrees(joints)).solution
        assert np.max(np.abs(there.position - pose[:3])) < 1e-8 * arm.characteristic_length
        assert 1 - abs(there.quaternion @ pose[3:]) < 1e-12


def test_planar_five_bar_from_positions():
    """An overconstrained (spatial) five-bar: links and bases in the plane follow from positions of
    the platform.
    """
    bar = five_bar()
    names = tuple(
        n for n in build_closure(bar).parameter_names if n.endswith(("point.x", "point.y"))
    )
    rng = np.random.default_rng(8)
    truth = np.array([nominal_parameters(bar)[n][0] for n in names]) + rng.uniform(
        -1, 1, len(names)
    )
    joints = np.pi / 2 + rng.uniform(-0.5, 0.5, (30, 2))
    data, _ = poses_measured(bar, joints, truth, names=names, orientation=False)
    fit = calibrate(bar, data, parameters=names)
    assert fit.status == "ok"
    np.testing.assert_allclose([fit.values[n] for n in names], truth, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["zhao2000", "three_rrr"])
def test_limbs_of_joints_from_full_poses(name):
    """Mechanisms with passive joints and a declared motion: the corrected one closes at the poses
    that were measured.
    """
    if name == "zhao2000":
        mechanism = symkin.load(name)
        joints = np.array([c.reference[0] for c in mechanism.actuated]) + np.random.default_rng(
            9
        ).uniform(-1, 1, (40, 4)) * [0.1, 0.1, 0.1, 5.0]
    else:
        mechanism = three_rrr("planar")
        joints = np.array([c.reference[0] for c in mechanism.actuated]) + np.random.default_rng(
            9
        ).uniform(-0.2, 0.2, (30, 3))
    rng, names = np.random.default_rng(10), default_parameters(mechanism)
    table = nominal_parameters(mechanism)
    scale = np.array(
        [1.0 if table[n][1] == "length" else 1 / mechanism.characteristic_length for n in names]
    )
    truth = np.array(
        [table[n][0] for n in names]
    ) + 0.003 * mechanism.characteristic_length * scale * rng.uniform(-1, 1, len(names))
    data, poses = poses_measured(mechanism, joints, truth)
    fit = calibrate(mechanism, data)
    assert fit.status == "ok"
    for values, pose in zip(data.joints[:4], poses[:4], strict=True):
        given = [
            mechanism.angle_out(v) if c.is_angular else v
            for v, c in zip(values, mechanism.actuated, strict=True)
        ]
        there = symkin.solve(fit.corrected, joints=given, start=pose).solution
        assert np.max(np.abs(there.position - pose[:3])) < 1e-6 * mechanism.characteristic_length


def test_full_poses_identify_a_platform_from_far_away():
    """Joint centres wrong by a tenth of the size are found from full poses: no direct problem is
    needed at the start.
    """
    rng = np.random.default_rng(11)
    nominal = geometry(NOMINAL)
    truth = random_geometry(nominal, (), 0.1 * NOMINAL.characteristic_length, rng)
    tables = {
        f"leg{k + 1}.{what}.{c}": getattr(truth, what)[k][i]
        for what in ("base", "platform")
        for k in range(6)
        for i, c in enumerate("xyz")
    }
    true = with_parameters(
        NOMINAL, tables | {f"leg{k + 1}.offset": truth.offset[k] for k in range(6)}
    )
    rows, poses = [], []
    while len(rows) < 60:
        q = np.append(1.0, 0.15 * rng.uniform(-1, 1, 3))
        pose = np.concatenate(
            [
                np.array(NOMINAL.platform_position) + rng.uniform(-0.15, 0.15, 3),
                q / np.linalg.norm(q),
            ]
        )
        poses.append(pose)
        rows.append(symkin.solve(true, pose=pose, start=[0.2] * 6).solution.actuated_values)
    data = Measurements(
        np.array(rows),
        position=np.array(poses)[:, :3],
        orientation=np.array(poses)[:, 3:],
        position_sigma=1e-5,
        orientation_sigma=1e-5,
    )
    fit = calibrate(NOMINAL, data)
    assert fit.rank == 42
    assert max(abs(fit.values[n] - truth.value(n)) for n in fit.values) < 1e-8


def test_absolute_inclinations_and_distances():
    """Absolute inclinations fix the platform's attitude and distances its place: with both, fewer
    parameters are free.
    """
    rng = np.random.default_rng(12)
    truth = random_geometry(geometry(NOMINAL), HELD, 0.003, rng)
    data = measured(truth, rng, rods=False)
    problem = build_calibration(NOMINAL, data, fixed=HELD)
    exact = solve_configurations(problem.model, data, truth.values(problem.names))
    poses = problem.model.poses(exact.z, data.joints, truth.values(problem.names))
    w, x, y, z = poses[:, 3:].T
    tilt = np.column_stack(
        [np.arctan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y)), np.arcsin(2 * (w * y - x * z))]
    )
    gaps = np.linalg.norm(poses[:, :3] - [0.5, -0.4, 0.1], axis=1)
    both = Measurements(
        data.joints,
        inclination=tilt,
        inclination_sigma=1e-5,
        readings=[Reading("distance", gaps, 1e-6, ((0, 0, 0), (0.5, -0.4, 0.1)))],
    )
    fit = calibrate(NOMINAL, both, fixed=HELD)
    assert fit.rank == 32
    assert largest_error(fit, truth) < 1e-10


def test_factors_of_readings_are_identified():
    """A rod that reads 1.001 of its extension: the factor is found when another rod's is held at
    1.
    """
    rng = np.random.default_rng(13)
    truth = random_geometry(geometry(NOMINAL), HELD, 0.003, rng)
    data = measured(truth, rng, rods=False)
    read = data.joints.copy()
    read[:, 3] /= 1.001
    names = (*default_parameters(NOMINAL), "leg4.scale")
    fit = calibrate(NOMINAL, replace(data, joints=read), parameters=names, fixed=HELD)
    assert fit.values["leg4.scale"] == pytest.approx(1.001, abs=1e-11)
    assert any("leg4.scale" in note for note in fit.notes)


# --- frames ---------------------------------------------------------------------------------------


def test_least_change_is_a_rigid_motion_of_the_fit_in_joint_frames():
    """Frames do not matter: with free frames the joints' mutual distances and the offsets are those
    of the held frames, and the change from nominal is smaller.
    """
    rng = np.random.default_rng(14)
    truth = random_geometry(geometry(NOMINAL), HELD, 0.005, rng)
    data = measured(truth, rng, rods=False)
    held, free = calibrate(NOMINAL, data, fixed=HELD), calibrate(NOMINAL, data)
    tables = [geometry(f.corrected) for f in (held, free)]
    for key in ("base", "platform"):
        a, b = (
            np.linalg.norm(t[:, None] - t[None], axis=2) for t in (getattr(g, key) for g in tables)
        )
        np.testing.assert_allclose(a, b, atol=1e-10)
    np.testing.assert_allclose(tables[0].offset, tables[1].offset, atol=1e-10)
    assert sum(p.change**2 for p in free.parameters) < sum(p.change**2 for p in held.parameters)


# --- honesty --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_postures_that_cannot_be_solved_are_named():
    """Joint readings that no pose of the mechanism has are reported, and the other postures give
    the exact geometry.
    """
    rng = np.random.default_rng(15)
    truth = random_geometry(geometry(NOMINAL), HELD, 0.003, rng)
    data = measured(truth, rng, rods=False)
    read = data.joints.copy()
    read[5, 0], read[5, 3] = 6.0, -1.0
    fit = calibrate(NOMINAL, replace(data, joints=read), fixed=HELD)
    assert fit.unsolved == (5,)
    assert any("posture 6" in note for note in fit.notes)
    assert 5 not in fit.used
    assert largest_error(fit, truth) < 1e-12


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ({"parameters": ["leg1.base.q"]}, ["leg1.base.q"]),
        ({"fixed": ["leg9.offset"]}, ["leg9.offset"]),
        ({"residual": "medians"}, ["medians", "differences"]),
        ({"method": "simplex"}, ["simplex", "ipopt"]),
        ({"outliers": "hide"}, ["hide", "remove"]),
        ({"parameters": ["leg1.offset", "leg1.offset"]}, ["twice"]),
        ({"level": 2.0}, ["2.0"]),
    ],
)
def test_wrong_options_are_refused(options, fragments):
    """Every option that cannot be is one sentence with its value."""
    data = Measurements(np.full((4, 6), 0.2), groups=np.zeros(4, dtype=int))
    with pytest.raises(InputError) as error:
        calibrate(NOMINAL, data, **options)
    assert all(f in str(error.value) for f in fragments)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("readings", "fragment"),
    [
        ({"joints": np.full((4, 5), 0.2), "groups": np.zeros(4, dtype=int)}, "5 readings"),
        ({"joints": np.full((4, 6), 0.2)}, "no reading"),
        ({"joints": [[0.2] * 5 + [np.nan]], "groups": np.zeros(1, dtype=int)}, "nan"),
        ({"joints": np.full((4, 6), 0.2), "inclination": np.zeros((3, 2))}, "inclination"),
        ({"joints": np.full((4, 6), 0.2), "orientation": np.ones((4, 4))}, "norm"),
        (
            {"joints": np.full((4, 6), 0.2), "groups": np.zeros(4, dtype=int), "group_sigma": 0.0},
            "group_sigma",
        ),
        ({"joints": np.full((4, 6), 0.2), "groups": np.zeros(4)}, "integer"),
    ],
)
def test_wrong_readings_are_refused(readings, fragment):
    """Readings that do not fit the mechanism or themselves are refused in one sentence."""
    with pytest.raises(InputError, match=fragment):
        calibrate(NOMINAL, Measurements(**readings))


def test_parameters_bound_by_a_motion_are_refused():
    """A joint axis that a declared motion needs upright cannot be tilted alone."""
    with pytest.raises(InputError, match="schoenflies"):
        build_calibration(
            symkin.load("zhao2000"),
            Measurements(np.zeros((4, 4)), position=np.zeros((4, 3))),
            parameters=["trt1.theta1.axis.x"],
        )


@pytest.mark.parametrize("name", ["ren2008", "gluon_6l3", "zhao2000_links", "yao2020"])
def test_corrected_mechanisms_have_the_values_and_a_file(name):
    """with_parameters puts each value where the closure reads it, and the file that it writes reads
    back the same.
    """
    mechanism = symkin.load(name)
    closure = build_closure(mechanism)
    rng = np.random.default_rng(16)
    moved = [n for n in closure.parameter_names if "axis" not in n and "quaternion" not in n]
    values = dict(zip(closure.parameter_names, closure.parameter_values, strict=True))
    changed = with_parameters(mechanism, {n: values[n] + 1e-3 * rng.uniform(-1, 1) for n in moved})
    again = parse(changed.to_toml())
    after = build_closure(changed)
    assert after.parameter_names == closure.parameter_names
    assert np.max(np.abs(after.parameter_values - closure.parameter_values)) > 1e-4
    np.testing.assert_allclose(
        build_closure(again).parameter_values, after.parameter_values, rtol=1e-14, atol=1e-14
    )


@pytest.mark.parametrize("count", [3, 6, 8])
@pytest.mark.parametrize("per", ["reading", "posture"])
def test_a_part_of_the_postures_keeps_their_standard_deviations(count, per):
    """Of joints and of other readings, whether one is given for each column or each posture, and
    whether these are as many or not.
    """
    rng = np.random.default_rng(count)

    def some(width):
        if per == "reading":
            return rng.uniform(1.0, 2.0, width)
        return rng.uniform(1.0, 2.0, (count, 1))

    reading = symkin.Reading("point.tip", rng.normal(size=(count, 3)), some(3))
    data = Measurements(
        rng.normal(size=(count, 6)),
        position=rng.normal(size=(count, 3)),
        joint_sigma=some(6),
        position_sigma=some(3),
        readings=[reading],
    )
    for rows in ([0, 1, 2], [2, 0], [1]):
        part = data.subset(rows)
        for key in ("joint", "position"):
            np.testing.assert_array_equal(part.sigma(key), data.sigma(key)[rows])
        np.testing.assert_array_equal(part.readings[0].sigma, reading.sigma[rows])


@pytest.mark.parametrize(("name", "redundant"), [("ren2008", False), ("zhao2000_links", True)])
def test_only_redundant_loops_are_blamed_for_a_fit_that_breaks_down(name, redundant, monkeypatch):
    """Where equations are no finite numbers, the reason told is one that the machine can have."""

    def breaks_down(*_):
        raise np.linalg.LinAlgError

    machine = symkin.load(name)
    monkeypatch.setattr(sys.modules[calibrate.__module__], "_calibrate", breaks_down)
    with pytest.raises(InputError, match="the fit broke down") as error:
        calibrate(machine, Measurements(np.zeros((1, len(machine.actuated)))))
    assert ("redundant" in str(error.value)) is redundant


def test_a_passive_joint_may_be_called_as_a_table_is():
    """Deviations of a joint called position are not those of the platform's position, nor the other
    way round.
    """
    table, read = np.ones((2, 3)), Reading("position", np.ones(2))
    m = Measurements(np.zeros((2, 1)), position=table, readings=[read])
    joint = m.replaced("position", by_name=True, sigma=0.1)
    assert joint.position_sigma is None
    assert np.all(joint.readings[0].sigma == 0.1)
    platform = m.replaced("position", sigma=0.2)
    assert np.all(platform.position_sigma == 0.2)
    assert platform.readings[0].sigma is None


@pytest.mark.parametrize("ends", [((0, 0, 0),), ((0, 0, 0), (1, 0))])
def test_a_distance_to_the_base_has_two_points(ends):
    """One point, or a point of two numbers, is refused with the reading's name."""
    with pytest.raises(symkin.SymkinError, match="gauge"):
        Reading("gauge", np.ones(2), ends=ends)


def test_two_distances_of_one_name_are_refused():
    """What is left out of one would be left out of the other."""
    ends = [((0.0, y, 0.0), (1.0, 0.0, 0.0)) for y in (0.0, 1.0)]
    read = [Reading("gauge", np.ones(2), ends=one) for one in ends]
    with pytest.raises(InputError, match="readings: 'gauge' stands twice"):
        Measurements(np.zeros((2, 3)), readings=read).check(symkin.load("delta"))
