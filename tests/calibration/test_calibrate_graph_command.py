"""`symkin calibrate` of graphs of links, as a calibration engineer with a CSV file uses it."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import symkin
from helpers import linkages
from helpers.command_line import run


def four_bars(folder, rng=None):
    """A four-bar's file and that of one as it was built."""
    nominal, true = folder / "four_bar.toml", folder / "built.toml"
    nominal.write_text(linkages.toml())
    true.write_text(linkages.toml(linkages.built(rng or np.random.default_rng(0))))
    return nominal, true


def rows_of(path):
    return list(csv.reader(path.read_text().splitlines()))


def changed(path, made, column, change):
    """A copy of a CSV file with the numbers of a column changed."""
    rows = rows_of(path)
    k = rows[0].index(column)
    for row in rows[1:]:
        row[k] = repr(float(change(float(row[k]))))
    with made.open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return made


def test_plan_simulate_fit(capsys, tmp_path):
    """Planned postures, read on another machine than the file's, give that machine: the corrected
    file reads as it does.
    """
    nominal, true = four_bars(tmp_path)
    plan, data, out = tmp_path / "plan.csv", tmp_path / "data.csv", tmp_path / "out"
    kinds = [
        "--readings",
        "follower,point.pen,distance.pen.mark",
        "--noise-position",
        "0.01mm",
        "--noise-distance",
        "0.01mm",
    ]
    status, said, _ = run(
        capsys,
        "calibrate",
        "plan",
        nominal,
        "-o",
        plan,
        "--groups",
        "0",
        "--postures",
        "14",
        *kinds[:4],
    )
    assert status == 0
    # the height of a point in the plane of motion is told to second order only
    assert "rank 14 of 15 parameters" in said
    status, *_ = run(
        capsys,
        "calibrate",
        "simulate",
        nominal,
        "--truth",
        true,
        "--plan",
        plan,
        "-o",
        data,
        *kinds,
    )
    assert status == 0
    status, said, _ = run(capsys, "calibrate", "fit", nominal, data, "-o", out, "--pictures")
    assert (status, "four_bar: believable" in said) == (0, True)
    assert "link coupler" in said
    assert {f.name for f in out.iterdir()} >= {
        "four_bar.toml",
        "report.json",
        "report.md",
        "residuals.png",
        "parameters.png",
        "pose_sigma.png",
    }
    found, machine = (symkin.load(str(path)) for path in (out / "four_bar.toml", true))
    for crank in (75.0, 90.0, 105.0):
        one, other = (symkin.solve(m, joints=[crank]).solution for m in (found, machine))
        np.testing.assert_allclose(one.points["pen"], other.points["pen"], atol=0.05)
        assert one.joints["follower"] == pytest.approx(other.joints["follower"], abs=0.05)
    report = json.loads((out / "report.json").read_text())
    assert {r["kind"] for r in report["residuals"]} == {
        "follower",
        "point.pen",
        "distance.pen.mark",
    }


def test_a_geometry_that_does_not_move_is_said_to(capsys, tmp_path):
    """A Bennett loop with one link's twist off is a structure: no posture is found, and the
    redundant rows are named.
    """
    loop, bent = symkin.load("bennett"), tmp_path / "bent.toml"
    joints = [e.joint for e in loop.link_joints]
    axis = np.array(joints[2].axis) + [0.02, 0.0, 0.03]
    bent.write_text(
        loop.to_toml().replace(f"axis = {list(joints[2].axis)}", f"axis = {axis.tolist()}")
    )
    status, _, complaint = run(
        capsys,
        "calibrate",
        "simulate",
        "bennett",
        "--truth",
        bent,
        "-o",
        tmp_path / "new.csv",
        "--readings",
        joints[1].name,
    )
    assert status == 2
    assert "close at special geometry alone" in complaint


def test_readings_of_the_true_machine_are_simulated(capsys, tmp_path):
    """A point of the machine that is measured lies where that machine's file has it."""
    nominal, true = four_bars(tmp_path)
    data = tmp_path / "data.csv"
    run(
        capsys,
        "calibrate",
        "simulate",
        nominal,
        "--truth",
        true,
        "-o",
        data,
        "--readings",
        "point.pen",
        "--postures",
        "3",
        "--noise-joints",
        "0deg",
        "--noise-position",
        "0mm",
    )
    rows = rows_of(data)
    for row in rows[1:]:
        pen = symkin.solve(symkin.load(str(true)), joints=[float(row[0])]).solution.points["pen"]
        np.testing.assert_allclose([float(v) for v in row[1:4]], pen, atol=1e-8)


@pytest.mark.parametrize(
    ("column", "change", "words"),
    [
        pytest.param(
            "follower[deg]",
            np.radians,
            "the readings of follower look radians taken for degrees",
            marks=pytest.mark.long,
        ),
        ("crank[deg]", np.negative, "the sign of crank looks reversed"),
        pytest.param(
            "follower[deg]",
            np.negative,
            "the sign of follower looks reversed",
            marks=pytest.mark.long,
        ),
    ],
)
def test_a_wrong_column_is_named(capsys, tmp_path, column, change, words):
    """A sign or a unit that is wrong explains why the fit is none: exit status 3, no mechanism
    file.
    """
    nominal, true = four_bars(tmp_path)
    data, out = tmp_path / "data.csv", tmp_path / "out"
    run(
        capsys,
        "calibrate",
        "simulate",
        nominal,
        "--truth",
        true,
        "-o",
        data,
        "--readings",
        "follower,point.pen",
    )
    wrong = changed(data, tmp_path / "wrong.csv", column, change)
    status, said, _ = run(capsys, "calibrate", "fit", nominal, wrong, "-o", out)
    assert status == 3
    assert words in said
    assert not (out / "four_bar.toml").exists()


def test_angles_alone_need_a_length(capsys, tmp_path):
    """With encoders alone the size is open, and said; with points of the base held, and so a
    length, the fit is one.
    """
    nominal, true = four_bars(tmp_path)
    data = tmp_path / "data.csv"
    run(
        capsys,
        "calibrate",
        "simulate",
        nominal,
        "--truth",
        true,
        "-o",
        data,
        "--readings",
        "follower",
        "--postures",
        "60",
    )
    status, said, _ = run(capsys, "calibrate", "fit", nominal, data, "-o", tmp_path / "open")
    assert status == 3
    assert "NOT OBSERVABLE: size of the whole mechanism" in said
    assert "hold one length" in said
    held = "crank.point.*,follower.point.*"
    status, said, _ = run(
        capsys,
        "calibrate",
        "fit",
        nominal,
        data,
        "-o",
        tmp_path / "held",
        "--hold",
        held,
        "--hold-out",
        "10",
    )
    assert status == 0
    assert "rank 5 of 5 parameters" in said
    assert "10 held-out postures are predicted" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["plan", "four_bar", "--groups", "0", "--readings", "folower"], "do you mean 'follower'?"),
        (
            ["plan", "four_bar"],
            "groups: equal inclination is that of a platform, and four_bar has no platform link",
        ),
        (
            ["plan", "four_bar", "--groups", "0", "--readings", "pose"],
            "'pose' is read of a platform, and four_bar has no platform link",
        ),
        (
            ["plan", "five_link_suspension", "--groups", "0", "--readings", "pose"],
            "the actuated joints (rack) do not determine the pose",
        ),
        (
            ["simulate", "ankle", "--readings", "pose", "--box", "1,1,1"],
            "postures of ankle, whose joints carry what they move",
        ),
        (
            ["simulate", "four_bar", "--readings", "follower", "--noise-position", "1mm"],
            "no position is read",
        ),
        (
            ["simulate", "double_wishbone", "--readings", "lower_ball"],
            "'lower_ball' is a spherical joint, which no encoder reads",
        ),
        (["simulate", "ankle", "--readings", "distance.toe"], "do you mean 'distance.toe.heel'?"),
    ],
)
def test_what_cannot_be_is_one_sentence(capsys, tmp_path, arguments, words):
    """Exit status 2, one line on stderr, no file."""
    status, said, complaint = run(capsys, "calibrate", *arguments, "-o", tmp_path / "new.csv")
    assert (status, said, complaint.count("\n")) == (2, "", 1)
    assert words in complaint
    assert not (tmp_path / "new.csv").exists()


@pytest.mark.parametrize(
    ("option", "words"),
    [("--sigma-position", "holds no positions"), ("--sigma-distance", "holds no distances")],
)
def test_deviations_of_what_is_not_read_are_refused(capsys, tmp_path, option, words):
    path = tmp_path / "data.csv"
    path.write_text("crank[deg],follower[deg]\n10,1\n20,2\n30,3\n")
    status, _, complaint = run(
        capsys, "calibrate", "fit", "four_bar", path, "-o", tmp_path / "out", option, "0.1mm"
    )
    assert status == 2
    assert words in complaint


def test_deviations_hold_for_passive_joints_and_points(capsys, tmp_path):
    """--sigma-joints and --sigma-position stand for columns that the file leaves out."""
    nominal, true = four_bars(tmp_path)
    data, out = tmp_path / "data.csv", tmp_path / "out"
    run(
        capsys,
        "calibrate",
        "simulate",
        nominal,
        "--truth",
        true,
        "-o",
        data,
        "--readings",
        "follower,point.pen",
    )
    rows = rows_of(data)
    kept = [k for k, name in enumerate(rows[0]) if not name.startswith("sigma_")]
    with data.open("w", newline="") as file:
        csv.writer(file).writerows([[row[k] for k in kept] for row in rows])
    status, said, _ = run(
        capsys,
        "calibrate",
        "fit",
        nominal,
        data,
        "-o",
        out,
        "--sigma-joints",
        "0.001deg",
        "--sigma-position",
        "0.00117mm",
        "--force",
    )
    assert status == 0
    assert "probability" in said.splitlines()[1]
