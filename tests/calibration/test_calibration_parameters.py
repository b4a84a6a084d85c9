"""Which parameters are identified: none that moves no pose, none missing, and sets that the
readings tell whole.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import (
    RULES,
    Case,
    Noise,
    Workspace,
    bound_by_motion,
    build_closure,
    default_parameters,
    diagnose,
    fit_file,
    group_numbers,
    main,
    match_parameters,
    random_configurations,
    read_measurements,
    simulate_readings,
)
from helpers.measured_files import write_measurements
from symkin import calibrate

Z = (0.0, 0.0, 1.0)


def planar_3rpr():
    """Three limbs R, actuated P, R, the slides off the lines between their revolute joints."""
    limbs = []
    for k, (a, b, off) in enumerate(
        [((0, 0), (210, 190), 20), ((600, 40), (350, 180), -15), ((280, 560), (290, 300), 30)],
        start=1,
    ):
        base, tip = np.array([*a, 0.0]), np.array([*b, 0.0])
        along = (tip - base) / np.linalg.norm(tip - base) + off / 600 * np.array([1.0, 0.5, 0.0])
        slide = symkin.Joint(f"slide{k}", "P", point=tuple(base), axis=tuple(along), actuated=True)
        ends = (
            symkin.Joint(f"{n}{k}", "R", point=tuple(p), axis=Z)
            for n, p in (("base", base), ("tip", tip))
        )
        first, last = ends
        limbs.append(symkin.Limb(f"limb{k}", [first, slide, last]))
    return symkin.Mechanism(
        "planar_3rpr", limbs, platform_position=(280, 220, 0), motion="planar", angle_unit="deg"
    )


def gaps(values, pose, joints):
    """What each limb of the planar 3-RPR leaves open (3,), from the numbers of its file alone: its
    tip is as far from its base joint at the pose (x, y, turn) as the slide puts it.
    """

    def turned(angle, v):
        return np.array(
            [
                np.cos(angle) * v[0] - np.sin(angle) * v[1],
                np.sin(angle) * v[0] + np.cos(angle) * v[1],
            ]
        )

    def pair(path):
        return np.array([values[f"{path}.x"], values[f"{path}.y"]])

    home = 2 * np.arctan2(values["platform.quaternion.z"], values["platform.quaternion.w"])
    found = []
    for k, q in enumerate(joints, start=1):
        base, tip, along = (
            pair(f"limb{k}.base{k}.point"),
            pair(f"limb{k}.tip{k}.point"),
            pair(f"limb{k}.slide{k}.axis"),
        )
        reach = tip + (q - values[f"limb{k}.slide{k}.zero"]) * along / np.linalg.norm(along) - base
        at = np.array(pose[:2]) + turned(pose[2] - home, tip - pair("platform.position"))
        found.append(np.linalg.norm(at - base) - np.linalg.norm(reach))
    return np.array(found)


def slopes(function, at):
    """Central differences of a function of a vector."""
    steps = 1e-5 * np.eye(len(at))
    return np.array([(function(at + h) - function(at - h)) / 2e-5 for h in steps]).T


def poses_by(mechanism, names, joints, poses):
    """dX/dp (3 n, P) of the closed loops at planar poses (n, 3), an implicit derivative."""
    closure = build_closure(mechanism)
    values = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    start, rows = np.array([values[n] for n in names]), []
    for q, pose in zip(joints, poses, strict=True):
        by_pose = slopes(lambda x, q=q: gaps(values, x, q), pose)
        by_p = slopes(
            lambda p, q=q, pose=pose: gaps(values | dict(zip(names, p, strict=True)), pose, q),
            start,
        )
        rows.append(np.linalg.solve(by_pose, by_p))
    return np.vstack(rows)


def rank(matrix):
    singular = np.linalg.svd(
        matrix / np.maximum(np.linalg.norm(matrix, axis=0), 1e-12), compute_uv=False
    )
    return int(np.sum(singular > 1e-6 * singular[0]))


def quiet(mechanism):
    return Noise(
        lengths=1e-6 * mechanism.characteristic_length,
        angles=1e-6,
        position=1e-5 * mechanism.characteristic_length,
        orientation=1e-5,
    )


def file_of(folder, mechanism, readings, postures=40, **region):
    rng, groups, noise = np.random.default_rng(3), group_numbers(postures, 0), quiet(mechanism)
    made = random_configurations(Workspace.about(mechanism, **region), groups, noise, rng)
    write_measurements(
        folder / "data.csv",
        mechanism,
        simulate_readings(mechanism, made, groups, readings, noise, rng),
    )
    return folder / "data.csv"


@pytest.mark.slow
def test_all_is_minimal_and_whole():
    """Planar 3-RPR, by its loop equations in plain NumPy: each default parameter moves poses, no
    one more than the rank of all that the file has. Those that move the platform out of the plane
    count by themselves.
    """
    mechanism = planar_3rpr()
    rng, names = np.random.default_rng(0), default_parameters(mechanism)
    made = random_configurations(
        Workspace.about(mechanism, tilt=0.0), group_numbers(20, 0), Noise(), rng
    )
    poses = np.column_stack([made.poses[:, :2], 2 * np.arctan2(made.poses[:, 6], made.poses[:, 3])])
    above = {"platform.position.z", "platform.quaternion.x", "platform.quaternion.y"}
    everything = [
        n
        for n in build_closure(mechanism).parameter_names
        if n not in bound_by_motion(mechanism) | above
    ]
    whole, ours = (
        poses_by(mechanism, n, made.joints, poses)
        for n in (everything, [n for n in names if n not in above])
    )
    assert set(names) == set(match_parameters(mechanism, "all")) < set(everything) | above
    assert np.all(np.linalg.norm(ours, axis=0) > 1e-3)
    assert rank(ours) == ours.shape[1] == rank(whole)


@pytest.mark.slow
def test_a_planar_machine_fits_with_defaults(tmp_path):
    """Whole poses of a planar 3-RPR: believable, everything observable, no parameter without
    effect.
    """
    mechanism = planar_3rpr()
    report = fit_file(
        mechanism, read_measurements(file_of(tmp_path, mechanism, ("pose",), tilt=0.0), mechanism)
    )
    assert report.believable, report.verdict
    assert not report.fit.identifiability.unobservable
    assert report.fit.identifiability.base_set == report.fit.problem.names


def arm():
    """Three parallel axes within six."""
    rows = [
        (0.1, 0.0, np.pi / 2),
        (0.05, 0.4, 0.0),
        (0.02, 0.35, 0.0),
        (0.08, 0.0, np.pi / 2),
        (0.09, 0.0, -np.pi / 2),
        (0.07, 0.03, 0.2),
    ]
    table = symkin.DHTable(
        "standard",
        [
            symkin.DHRow(f"q{k + 1}", "R", 0.1 * k, d, a, alpha)
            for k, (d, a, alpha) in enumerate(rows)
        ],
    )
    return symkin.serial_arm_from_dh("arm", table, length_unit="m", angle_unit="rad")


@pytest.mark.slow
def test_parallel_axes_are_named(tmp_path):
    """d of parallel axes: only sums are told, and the report says why, in the words that a user
    searches for.
    """
    mechanism = arm()
    data = read_measurements(file_of(tmp_path, mechanism, ("pose",)), mechanism)
    fit = calibrate(
        mechanism,
        data.measurements,
        parameters=[f"dh.{k}.{w}" for k in range(1, 7) for w in ("theta", "d", "a")],
    )
    named = [text for text in fit.identifiability.unobservable if text.startswith("parallel axes")]
    assert len(named) == 2
    assert "q2 and q3" in named[0]
    assert "dh.2.d and dh.3.d" in named[0]


@pytest.mark.long
@pytest.mark.slow
def test_the_base_set_can_be_copied(capsys, tmp_path):
    """--parameters with the base set of the report: the same rank and chi-square, nothing
    unobservable.
    """
    mechanism = arm()
    (tmp_path / "arm.toml").write_text(mechanism.to_toml())
    data, reports = file_of(tmp_path, mechanism, ("pose",)), []
    chosen = "dh.*.theta,dh.*.d,dh.*.a"
    for _ in range(2):
        with pytest.raises(SystemExit) as ended:
            main(
                [
                    "calibrate",
                    "fit",
                    str(tmp_path / "arm.toml"),
                    str(data),
                    "-o",
                    str(tmp_path / "out"),
                    "--parameters",
                    chosen,
                ]
            )
        assert not ended.value.code
        reports.append(json.loads((tmp_path / "out" / "report.json").read_text()))
        chosen = ",".join(reports[0]["base_set"])
        capsys.readouterr()
    first, second = reports
    assert (
        len(first["base_set"])
        == first["rank"]
        == second["rank"]
        == second["parameters_in_all"]
        < first["parameters_in_all"]
    )
    assert first["unobservable"]
    assert not second["unobservable"]
    assert second["chi_square"] == pytest.approx(first["chi_square"], rel=1e-6)


def test_order_and_signs_of_columns_are_found_together(tmp_path):
    """Slides read in another order and one with its sign turned: the columns are assigned to the
    limbs by the inverse problem, and put right they are the true ones.
    """
    mechanism = planar_3rpr()
    data = read_measurements(
        file_of(tmp_path, mechanism, ("pose",), tilt=0.0), mechanism
    ).measurements
    joints = np.column_stack([data.joints[:, 1], -data.joints[:, 2], data.joints[:, 0]])
    case = Case(mechanism, replace(data, joints=joints))
    ((text, put_right),) = RULES["order"]["joint columns in another order, with other signs"](case)
    assert text in diagnose(case)[0]
    assert (
        "the columns slide1, slide2, slide3 look exchanged: they seem to hold slide2, slide3, "
        "slide1" in text
    )
    assert "the sign of slide2 looks reversed" in text
    assert np.array_equal(put_right.measurements.joints, data.joints)
