"""Identifiability: the known ranks, null spaces named in parameter terms, and advice that cures."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.built_machines import random_postures
from helpers.inclinometer import (
    BASE_LIMBS,
    INCLINOMETER,
    PLATFORM_LIMBS,
    ROD,
    geometry,
    groups_of_postures,
    measured,
    random_geometry,
)
from helpers.inside import (
    Noise,
    Workspace,
    build_calibration,
    build_closure,
    build_problem,
    default_parameters,
    error_free_state,
    group_numbers,
    identifiability,
    joint_frames,
    main,
    measure_departure,
    named_motions,
    nominal_parameters,
    predict_pose_sigma,
    random_configurations,
    simulate_readings,
    solve_configurations,
)
from helpers.inside import evaluate_state as evaluate
from helpers.measured_files import write_measurements
from helpers.samples import delta, five_bar
from symkin import InputError, Measurements, Pose, ReadOptions, calibrate

NOMINAL = symkin.load("ren2008")
ARM = Path(__file__).parents[2] / "docs" / "robots" / "arm.urdf"
HELD = joint_frames(NOMINAL, PLATFORM_LIMBS, BASE_LIMBS)
TEN = {
    *(f"base frame translation {k}" for k in "xyz"),
    "base frame yaw (about z)",
    *(f"platform frame translation {k}" for k in "xyz"),
    *(f"platform frame rotation about {k}" for k in "xyz"),
}


def grouped(rng, **options) -> Measurements:
    joints, groups = groups_of_postures(geometry(NOMINAL), rng, **options)
    return Measurements(joints, groups=groups, group_sigma=1e-5)


@pytest.mark.parametrize("spread", [0.0, 0.005])
def test_inclinations_leave_exactly_the_frames(spread):
    """42 parameters have rank 32; what is left is the platform frame (6), base translation (3) and
    yaw (1), at exact data and where the nominal geometry does not fit them.
    """
    rng = np.random.default_rng(1)
    truth = random_geometry(geometry(NOMINAL), (), spread, rng) if spread else geometry(NOMINAL)
    found = identifiability(NOMINAL, measured(truth, rng))
    assert found.rank == 32
    assert set(found.unobservable) == TEN
    assert len(found.unobservable) == 10
    assert found.singular_values[31] > 1e3 * found.singular_values[32]


def test_joint_frames_hold_what_is_free():
    """With the paper's ten entries held, all 32 parameters are told."""
    found = identifiability(NOMINAL, grouped(np.random.default_rng(2)), fixed=HELD)
    assert (found.rank, found.unobservable, found.advice) == (32, (), ())


def test_one_level_group():
    """One level group has rank 27 of 32, and the advice is other inclinations."""
    joints, _ = groups_of_postures(geometry(NOMINAL), np.random.default_rng(3), 10, 4, tilt=0.0)
    data = Measurements(joints, groups=np.zeros(40, dtype=int), group_sigma=1e-5)
    found = identifiability(NOMINAL, data, fixed=HELD)
    assert found.rank == 27
    assert len(found.unobservable) == 5
    assert any("other inclinations" in text for text in found.advice)
    for leg in (3, 4, 5):
        assert any(
            f"leg{leg}.platform.z" in text and f"leg{leg}.base.z" in text
            for text in found.unobservable
        )


def test_no_yaw():
    """With gamma always 0 the rank is 30 of 32: roll and pitch of the base frame are lost, and the
    advice is to vary yaw.
    """
    found = identifiability(NOMINAL, grouped(np.random.default_rng(4), yaw=0.0), fixed=HELD)
    assert found.rank == 30
    assert set(found.unobservable) == {"base frame roll (about x)", "base frame pitch (about y)"}
    assert any("vary the yaw" in text for text in found.advice)


@pytest.mark.parametrize("kind", ["hexapod", "open chain"])
def test_readings_without_errors_agree_in_their_groups(kind):
    """Joint readings moved least so that every group has one inclination: none is left over,
    of a platform that closes loops and of one that a chain of joints carries alone.
    """
    rng = np.random.default_rng(11)
    machine = NOMINAL if kind == "hexapod" else symkin.load(ARM, ReadOptions(platform="tool0"))
    noise = Noise(lengths=1e-5 * machine.characteristic_length, angles=1e-5)
    groups = group_numbers(24, 6)
    made = random_configurations(Workspace.about(machine), groups, Noise(), rng)
    data = simulate_readings(machine, made, groups, (), dataclasses.replace(noise, group=1e-5), rng)
    problem = build_calibration(machine, data)
    z = solve_configurations(problem.model, data, problem.model.nominal).z
    before = evaluate(problem.by_means, problem.model.nominal, z)
    after = error_free_state(problem, before)
    assert np.max(np.abs(before.linearised.residuals)) > 0.1
    assert np.max(np.abs(after.linearised.residuals)) < 1e-4


def test_scale_factors():
    """Six factors of the rods' readings make 38 parameters of rank 37: the size with all factors is
    free.
    """
    names = [*default_parameters(NOMINAL), *(f"leg{k}.scale" for k in range(1, 7))]
    data = grouped(np.random.default_rng(5))
    found = identifiability(NOMINAL, data, parameters=names, fixed=HELD)
    assert found.rank == 37
    assert found.unobservable == (
        "size of the whole mechanism with the factors of all length readings",
    )
    assert any("distance" in text for text in found.advice)
    cured = identifiability(NOMINAL, data, parameters=names, fixed=[*HELD, "leg1.scale"])
    assert (cured.rank, cured.unobservable) == (37, ())


def test_named_directions_span_the_null_space():
    """The named motions of the frames, as vectors, and the null space are the same space."""
    data = grouped(np.random.default_rng(6))
    found = identifiability(NOMINAL, data)
    problem = build_calibration(NOMINAL, data)
    named = np.array(
        [v for name, v in named_motions(problem.model, problem.model.nominal) if name in TEN]
    ).T
    overlap = np.linalg.svd(np.linalg.qr(named)[0].T @ found.null_space, compute_uv=False)
    np.testing.assert_allclose(overlap, 1.0, atol=1e-6)


def test_parallel_axes_of_an_arm():
    """Three parallel axes in a row: only the sum of their offsets d is told, so that two
    differences are not.
    """
    arm = symkin.load("gluon_6l3")
    forward = build_problem(arm, "direct").forward
    joints = np.random.default_rng(7).uniform(-2, 2, (30, 6))
    poses = np.array([forward(q) for q in joints])
    found = identifiability(
        arm,
        Measurements(
            joints,
            position=poses[:, :3],
            orientation=poses[:, 3:],
            position_sigma=0.01,
            orientation_sigma=1e-4,
        ),
    )
    assert found.rank == 22
    assert len(found.unobservable) == 2
    mentioned = {name for text in found.unobservable for name in re.findall(r"dh\.\d\.\w+", text)}
    assert mentioned == {"dh.2.d", "dh.3.d", "dh.4.d"}
    assert all(text.startswith("parallel axes") for text in found.unobservable)


def test_measuring_frames_are_named_with_what_they_mix():
    """A world frame beside full freedom of a platform's base: six combinations, each naming
    both.
    """
    rng = np.random.default_rng(8)
    joints, _ = groups_of_postures(geometry(NOMINAL), rng)
    poses = [symkin.solve(NOMINAL, joints=q).solution for q in joints]
    data = Measurements(
        joints,
        position=np.array([s.position for s in poses]),
        orientation=np.array([s.quaternion for s in poses]),
        position_sigma=1e-5,
        orientation_sigma=1e-5,
    )
    world = [f"world.{what}.{k}" for what in ("position", "rotation") for k in "xyz"]
    found = identifiability(NOMINAL, data, parameters=[*default_parameters(NOMINAL), *world])
    assert found.rank == 42
    assert sorted(found.unobservable) == sorted(
        f"world frame {w[6:].replace('.', ' ')} with the base frame" for w in world
    )


def test_local_freedoms_of_joints():
    """How a joint is written down is never told: its point along the axis, the length of the
    axis.
    """
    bar = five_bar()
    names = [n for n in build_closure(bar).parameter_names if n.startswith("left.q1")]
    joints = np.pi / 2 + np.random.default_rng(9).uniform(-0.5, 0.5, (20, 2))
    data = Measurements(joints, position=np.zeros((20, 3)), position_sigma=1e-3)
    found = identifiability(bar, data, parameters=names)
    assert {"point of left.q1 along its axis", "length of the vector left.q1.axis"} <= set(
        found.unobservable
    )


def test_null_space_changes_nothing():
    """Moving along a null direction changes the residuals by the square of the step only."""
    data = grouped(np.random.default_rng(10))
    found, problem = identifiability(NOMINAL, data), build_calibration(NOMINAL, data)
    model = problem.model
    z = solve_configurations(model, data, model.nominal).z
    before = evaluate(problem.by_means, model.nominal, z).linearised.vector
    direction = model.scales * (found.null_space @ np.random.default_rng(11).normal(size=10))
    changes = []
    for step in (1e-3, 1e-4):
        p = model.nominal + step * direction
        changes.append(
            np.linalg.norm(
                evaluate(
                    problem.by_means, p, solve_configurations(model, data, p, z=z).z
                ).linearised.vector
                - before
            )
        )
    assert changes[1] < 0.02 * changes[0]


def test_joint_frames_refuse_what_is_not_zero():
    """Frames in joints need the entries that they hold to be zero already."""
    with pytest.raises(InputError, match=r"leg3\.platform\.x"):
        joint_frames(NOMINAL, ("leg3", "leg2", "leg6"), BASE_LIMBS)
    with pytest.raises(InputError, match="leg9"):
        joint_frames(NOMINAL, ("leg9", "leg2", "leg6"), BASE_LIMBS)


def test_every_parameter_has_a_kind():
    """Angles and directions are scaled by the size, lengths are not."""
    kinds = {n: kind for n, (_, kind) in nominal_parameters(symkin.load("zhao2000")).items()}
    assert kinds["trt1.theta1.zero"] == "angle"
    assert kinds["trt1.radial1.zero"] == "length"
    assert kinds["trt1.theta1.axis.x"] == "number"
    assert kinds["op.base.x"] == "length"


@pytest.mark.parametrize(
    "turn", [(0.5**0.5, 0.0, 0.5**0.5, 0.0), (0.0, 1.0, 0.0, 0.0)], ids=["x up", "z down"]
)
def test_groups_fit_alike_wherever_the_platform_frame_points(turn):
    """Chi-square of groups of equal inclination is that of the upright frame: errors of tilt weigh
    alike (alpha of a frame whose x axis points up does not).
    """
    rng = np.random.default_rng(3)
    truth = random_geometry(geometry(NOMINAL), (), 1e-3, rng)
    joints, groups = groups_of_postures(truth, rng, each=6, errors=(ROD, INCLINOMETER))
    data = Measurements(
        joints,
        groups=groups,
        group_sigma=INCLINOMETER / np.sqrt(12),
        joint_sigma=ROD / np.sqrt(12),
    )
    back = Pose(np.zeros(3), np.array(turn)).rotation.T
    limbs = [
        dataclasses.replace(limb, platform=tuple(back @ np.array(limb.platform)))
        for limb in NOMINAL.limbs
    ]
    turned = dataclasses.replace(NOMINAL, limbs=limbs, platform_quaternion=turn)
    upright, found = symkin.calibrate(NOMINAL, data), symkin.calibrate(turned, data)
    assert found.believable
    assert found.chi_square == pytest.approx(upright.chi_square, rel=1e-6)


def read_delta(count, noise=1e-4):
    """Positions of a delta whose parallelograms are redundant, with noise."""
    rng, machine = np.random.default_rng(1), delta()
    stated = Noise(position=noise * machine.characteristic_length)
    made = random_postures(machine, machine, count, rng)
    return simulate_readings(machine, made, np.full(count, -1), ("position",), stated, rng)


@pytest.mark.parametrize(("count", "opens"), [(5, True), (20, False)])
def test_loops_must_close_elsewhere_too(count, opens):
    """Each parallelogram has six conditions to close everywhere, one a posture: five postures leave
    three open, and the fit is not believable, however well it fits, and says what to do.
    """
    fit = calibrate(delta(), read_delta(count))
    assert fit.p_value > 1e-3
    assert fit.identifiability.opens is opens
    assert fit.believable is not opens
    assert any("need not close at others" in text for text in fit.notes) is opens


def test_a_file_of_too_few_postures_is_not_usable(tmp_path):
    """The command writes no geometry whose loops need not close, and its verdict says why."""
    write_measurements(tmp_path / "d.csv", delta(), read_delta(5))
    (tmp_path / "m.toml").write_text(delta().to_toml())
    files = [str(tmp_path / name) for name in ("m.toml", "d.csv")]
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", "fit", *files, "-o", str(tmp_path / "out")])
    assert ended.value.code == 3
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["verdict"].startswith("NOT USABLE: loops that are redundant")


@pytest.mark.parametrize(("times", "blind"), [(3.0, True), (0.3, False)])
def test_a_blind_direction_counts_where_the_prior_leaves_poses_less_sure(times, blind):
    """A direction that no reading tells is known by the prior alone: it matters where a standard
    deviation of the prior along it moves poses by more than what the readings leave them.
    """
    fit = calibrate(delta(), read_delta(20, 1e-5))
    found, prior = fit.identifiability, 0.01 * fit.mechanism.characteristic_length
    quiet = dataclasses.replace(found, null_space=found.blind)
    seen = np.zeros((len(found.names), 1))
    seen[found.names.index("limb1.rod1.length")] = 1.0
    usual = predict_pose_sigma(dataclasses.replace(fit, identifiability=quiet))
    count = len(found.names)
    alone = dataclasses.replace(
        fit, identifiability=quiet, covariance=np.zeros_like(fit.covariance)
    )
    alone.covariance[:count, :count] = seen @ seen.T
    moved = predict_pose_sigma(alone).position
    share = times * np.sqrt(np.mean(usual.position**2)) / prior / np.max(moved)
    other = dataclasses.replace(quiet, blind=share * seen, null_space=share * seen)
    assert predict_pose_sigma(dataclasses.replace(fit, identifiability=other)).blind is blind


@pytest.mark.parametrize(("end", "most"), [("base", 0.2**3 / 12), ("platform", 1e-7)])
def test_a_departure_knows_no_frames(end, most):
    """Joint centres of one end turned (by 0.2 rad) and shifted as a whole move poses by a constant
    frame, which is no departure: of a turn of the base a twelfth of its cube is left.
    """
    data = grouped(np.random.default_rng(12))
    problem = build_calibration(NOMINAL, data)
    turn = Pose(np.zeros(3), np.array([np.cos(0.1), 0.0, np.sin(0.1), 0.0])).rotation
    values = dict(zip(problem.names, problem.model.nominal, strict=True))
    for leg in range(1, 7):
        names = [f"leg{leg}.{end}.{k}" for k in "xyz"]
        moved = turn @ [values[n] for n in names] + [0.03, -0.02, 0.01]
        values |= dict(zip(names, moved, strict=True))
    p = np.array([values[n] for n in problem.names])
    z = solve_configurations(problem.model, data, p).z
    found = measure_departure(problem, evaluate(problem.by_means, p, z))
    assert found.unclosed == 0
    assert found.share < most
