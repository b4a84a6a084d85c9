"""Calibration under its users' hands: large files, distances, gross errors, and starts of direct
problems.
"""

from __future__ import annotations

import json
import time
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inclinometer import BASE_LIMBS, PLATFORM_LIMBS, geometry, measured, random_geometry
from helpers.inside import (
    LinearModel,
    Noise,
    Workspace,
    build_calibration,
    deviations,
    estimate,
    evaluate_at,
    group_numbers,
    joint_frames,
    linear_model,
    linearise,
    random_configurations,
    simulate_readings,
    solve_configurations,
    told_directions,
    with_parameters,
)
from symkin import calibrate

NOMINAL, TRUE = symkin.load("ren2008"), symkin.load("ren2008_true")
HELD = joint_frames(NOMINAL, PLATFORM_LIMBS, BASE_LIMBS)
DISTANCES = {"a": "0.4,0.3,0:0,0,0", "b": "0.1,0,0:1,0,10cm", "c": "0,0.6,0.05:0,1,0"}


# --- the structure of groups ----------------------------------------------------------------------


def mixed_measurements():
    """Groups of unequal size in no order, postures without a group, each posture with its own
    noise.
    """
    rng = np.random.default_rng(21)
    data = measured(geometry(TRUE), rng, noisy=True)
    groups = data.groups.copy()
    groups[[3, 17]], groups[5] = -1, 8
    order = rng.permutation(len(data))
    sigma = np.asarray(data.group_sigma) * rng.uniform(0.5, 2.0, (len(data), 2))
    return replace(data, joints=data.joints[order], groups=groups[order], group_sigma=sigma)


def dense_model(problem, state, model):
    """The whitened deviations, and the same linear model with one orthonormal basis of all columns,
    groups and parameters together, by SVD.
    """
    readings = problem.readings
    count = readings.values.size
    e = evaluate_at(problem, state.p, state.z)
    flat = (model.whiten @ deviations(readings, e.readings)[:, :, None]).reshape(count)
    told = told_directions(problem, state)
    free = told.columns[:, told.ratios > 1.0]
    columns = [(model.whiten @ e.slopes).reshape(count, -1) @ free]
    basis = model.whiten[:, :, readings.columns]
    for g in range(readings.groups):
        columns.append(np.where((readings.group == g)[:, None, None], basis, 0.0).reshape(count, 2))
    stacked = np.hstack(columns)
    left, singular, _ = np.linalg.svd(
        stacked / np.linalg.norm(stacked, axis=0), full_matrices=False
    )
    whole = left[:, singular > 1e-8 * singular[0]]
    nothing = np.zeros((count, 2))
    return flat, LinearModel(
        flat - whole @ (whole.T @ flat),
        nothing,
        np.full(count, -1),
        whole,
        model.fitted + 2 * readings.groups,
        model.taken,
        model.whiten,
    )


def test_the_block_diagonal_basis_is_that_of_all_columns_together():
    """Residuals, absorbed shares, degrees and what is left of any reading agree to 1e-12 with one
    dense orthonormal basis, before and after a deletion.
    """
    problem = build_calibration(NOMINAL, mixed_measurements(), fixed=HELD)
    z = solve_configurations(problem.model, problem.measurements, problem.model.nominal).z
    state = estimate(problem, z).state
    model = linear_model(problem, state)
    raw, dense = dense_model(problem, state, model)
    rows = np.array([[0, 1], [30, 31], [44, 45]])
    for ours, theirs in ((model, dense), (model.without(rows[1]), dense.without(rows[1]))):
        assert ours.degrees == theirs.degrees
        assert np.abs(ours.residuals - theirs.residuals).max() < 1e-12 * np.abs(raw).max()
        assert np.abs(ours.absorbed - theirs.absorbed).max() < 1e-12
        assert np.abs(ours.freedom(rows) - theirs.freedom(rows)).max() < 1e-12


def test_group_means_are_weighted_averages():
    """In each group the weighted residuals of the form "means" sum to zero, and its Jacobian
    likewise.
    """
    problem = build_calibration(NOMINAL, mixed_measurements(), fixed=HELD)
    readings, rng = problem.readings, np.random.default_rng(0)
    h, h_p = rng.normal(size=(40, 2)), rng.normal(size=(40, 2, 5))
    fit = linearise("means", readings, h, h_p)
    for g in range(readings.groups):
        inside = readings.group == g
        weight = readings.weight[inside]
        assert np.abs(np.sum(weight * fit.residuals[inside], axis=0)).max() < 1e-9 * weight.max()
        assert (
            np.abs(
                np.sum(
                    weight[:, :, None] * fit.matrix.reshape(*fit.residuals.shape, -1)[inside],
                    axis=0,
                )
            ).max()
            < 1e-9 * weight.max() ** 2
        )
    assert readings.groups == 10


@pytest.mark.long
@pytest.mark.slow
def test_time_grows_with_the_number_of_groups_and_not_with_its_square():
    """Eight times the groups take less than 24 times as long."""
    truth, took = geometry(TRUE), []
    for groups in (50, 400):
        data = measured(truth, np.random.default_rng(1), groups, noisy=True)
        calibrate(NOMINAL, data.subset(np.arange(40)), fixed=HELD)
        begin = time.process_time()
        assert calibrate(NOMINAL, data, fixed=HELD, outliers="report").status == "ok"
        took.append(time.process_time() - begin)
    assert took[1] < 24 * took[0]


# --- gross errors ---------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.slow
def test_a_gross_error_makes_no_others():
    """A rod off by 5 mm, 2500 times its noise, bends the fit: this posture is left out, and in six
    sets no other but for one.
    """
    others = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        data = measured(random_geometry(geometry(NOMINAL), HELD, 0.005, rng), rng, noisy=True)
        joints = data.joints.copy()
        joints[7, 2] += 0.005
        found = [
            o.configuration
            for o in calibrate(NOMINAL, replace(data, joints=joints), fixed=HELD).outliers
        ]
        assert 7 in found
        others += len(found) - 1
    assert others <= 1


@pytest.mark.slow
def test_many_bad_readings_are_found_or_the_fit_is_refused():
    """A third of the postures bad: either these are left out and hardly another, and what is left
    fits, or nothing is usable and the reason is said.
    """
    rng = np.random.default_rng(4)
    data = measured(geometry(TRUE), rng, noisy=True)
    joints = data.joints.copy()
    joints[::3, 2] += 2e-4 * rng.choice([-1, 1], 14)
    fit = calibrate(NOMINAL, replace(data, joints=joints), fixed=HELD)
    found = {o.configuration for o in fit.outliers}
    if fit.refused is None:
        assert found >= set(range(0, 40, 3))
        assert len(found) <= 16
        assert fit.believable
    else:
        assert not found
        assert fit.given_up
        assert not fit.believable
        assert any("none was left out" in note for note in fit.notes)


# --- distances ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_distances_go_from_file_to_geometry(capsys, tmp_path):
    """Distances of three points with groups: rank as of the Jacobian without null space but for
    what they leave; sigma from the file, none from the option beside it; the identified distances
    are those measured.
    """
    path, out = tmp_path / "d.csv", tmp_path / "out"
    points = [
        word
        for name, ends in DISTANCES.items()
        for word in ("--distance", f"{name}={ends.replace('10cm', '100mm')}")
    ]
    simulate = [
        "calibrate",
        "simulate",
        "ren2008",
        "--truth",
        "ren2008_true",
        "--postures",
        "60",
        "-o",
        path,
        *points,
    ]
    assert run(capsys, *simulate, "--noise-distance", "10um")[0] == 0
    header = next(line for line in path.read_text().splitlines() if not line.startswith("#"))
    assert "distance_b[m]" in header
    assert "sigma_distance_b[m]" in header
    status, said, _ = run(capsys, "calibrate", "fit", "ren2008", path, "-o", out, *points)
    report = json.loads((out / "report.json").read_text())
    assert {r["kind"] for r in report["residuals"]} == {"distance"}
    assert status == (0 if report["usable"] else 3)
    assert report["degrees"] == 180 - report["rank"]
    assert report["p_value"] > 1e-3, said
    assert (
        run(
            capsys,
            "calibrate",
            "fit",
            "ren2008",
            path,
            "-o",
            out,
            *points,
            "--sigma-distance",
            "1um",
        )[0]
        == 2
    )


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (["a=1,2:3"], "NAME=X,Y,Z:BX,BY,BZ is needed"),
        (["a=1,2,3:4,5,6deg"], "unit of length"),
        (["a=0,0,0:1,1,1", "a=0,0,0:1,1,1"], "given twice"),
        ([], "the points of this distance are not known"),
        (["a=0,0,0:1,1,1", "z=0,0,0:1,1,1"], "'distance_z' is missing or empty"),
    ],
)
def test_wrong_distances_are_refused(capsys, tmp_path, points, said):
    """Each mistake is a sentence with its option or column, exit 2."""
    path = tmp_path / "d.csv"
    ends = ["--distance", "a=0.4,0.3,0:0,0,0"]
    assert (
        run(capsys, "calibrate", "simulate", "ren2008", "--postures", "8", "-o", path, *ends)[0]
        == 0
    )
    options = [word for text in points for word in ("--distance", text)]
    status, _, error = run(
        capsys, "calibrate", "fit", "ren2008", path, "-o", tmp_path / "out", *options
    )
    assert status == 2
    assert said in error


@pytest.mark.long
@pytest.mark.slow
def test_use_beyond_the_measured_postures_is_said(capsys, tmp_path):
    """Postures in half of the workspace: a note gives sigma beyond the measured joint values,
    larger than elsewhere; with postures over all of it there is none.
    """
    notes = []
    for box in ("0.2,0.2,0.2", "0.35,0.35,0.35"):
        path, out = tmp_path / "d.csv", tmp_path / box
        options = [
            "--readings",
            "pose",
            "--box",
            box,
            "--tilt",
            "10deg" if box == "0.2,0.2,0.2" else "20deg",
            "--spin",
            "10deg" if box == "0.2,0.2,0.2" else "20deg",
        ]
        assert (
            run(
                capsys,
                "calibrate",
                "simulate",
                "ren2008",
                "--postures",
                "120",
                "-o",
                path,
                *options,
            )[0]
            == 0
        )
        assert run(capsys, "calibrate", "fit", "ren2008", path, "-o", out)[0] == 0
        report = json.loads((out / "report.json").read_text())
        notes.append([note for note in report["notes"] if "beyond those measured" in note])
    assert [len(n) for n in notes] == [1, 0]
    there, elsewhere = (
        float(word)
        for word in notes[0][0].split(" position is ")[1].replace(" and ", " ").split()[0:4:3]
    )
    assert there > elsewhere


# --- starts ---------------------------------------------------------------------------------------


def test_postures_start_at_home_where_the_reference_is_singular():
    """Offsets from inclinations alone, the reference pose flat: errors within four standard
    deviations, the fit believable.
    """
    nominal = symkin.load("zhang2009")
    names = [f"leg{k}.offset" for k in range(1, 7)]
    rng = np.random.default_rng(2)
    truth = dict(zip(names, rng.uniform(-0.3, 0.3, 6), strict=True))
    groups, noise = group_numbers(40, 0), Noise(lengths=1e-3, inclination=1e-5)
    made = random_configurations(
        Workspace.about(with_parameters(nominal, truth)), groups, noise, rng
    )
    fit = calibrate(
        nominal,
        simulate_readings(nominal, made, groups, ["inclination"], noise, rng),
        parameters=names,
    )
    assert fit.believable
    assert all(abs(p.value - truth[p.name]) < 4 * p.sigma for p in fit.parameters)
