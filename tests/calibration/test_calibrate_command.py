"""`symkin calibrate` as a calibration engineer uses it: simulate, plan, fit, and what goes
wrong.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inside import main

FILES = {
    "residuals.png",
    "parameters.png",
    "pose_sigma.png",
    "report.json",
    "report.md",
    "ren2008.toml",
    "manifest.json",
}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    path = tmp_path_factory.mktemp("calibrate") / "data.csv"
    with pytest.raises(SystemExit) as ended:
        main(
            [
                "calibrate",
                "simulate",
                "ren2008",
                "--truth",
                "ren2008_true",
                "--groups",
                "10",
                "--seed",
                "3",
                "-o",
                str(path),
            ]
        )
    assert not ended.value.code
    return path


def changed(path, target, change):
    """A copy with its rows changed."""
    header, *rows = [line.split(",") for line in path.read_text().splitlines()]
    change(rows)
    target.write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")
    return target


@pytest.mark.slow
@pytest.mark.usefixtures("rasterised")
def test_a_fit_gives_a_mechanism_that_modes_takes(capsys, tmp_path, data):
    """Simulate, fit, modes: exit 0, seven files with pictures and four without, the corrected
    mechanism nearer to the truth in poses than the nominal one.
    """
    plain, out = tmp_path / "plain", tmp_path / "out"
    assert run(capsys, "calibrate", "fit", "ren2008", data, "-o", plain)[0] == 0
    assert {p.name for p in plain.iterdir()} == {n for n in FILES if not n.endswith(".png")}
    assert ".png" not in (plain / "report.md").read_text()
    status, said, _ = run(capsys, "calibrate", "fit", "ren2008", data, "-o", out, "--pictures")
    assert status == 0
    assert {p.name for p in out.iterdir()} == FILES
    assert said.startswith("ren2008: believable")
    report = json.loads((out / "report.json").read_text())
    assert report["believable"]
    assert report["rank"] == 32
    assert len(report["frames"]) == 10
    assert not report["unobservable"]
    assert (out / "residuals.png").read_bytes()[:4] == b"\x89PNG"
    assert "| leg3.base.z | m |" in (out / "report.md").read_text()
    corrected, true, nominal = (
        symkin.load(name) for name in (str(out / "ren2008.toml"), "ren2008_true", "ren2008")
    )
    assert "calibrated" in corrected.title
    status, said, _ = run(
        capsys,
        "modes",
        out / "ren2008.toml",
        "--joints",
        "0.2,0.25,0.2,0.22,0.3,0.25",
        "--method",
        "multistart",
        "--starts",
        "200",
        "--json",
    )
    assert status == 0
    assert json.loads(said)["modes"]
    assert relative_error(corrected, true) < 0.1 * relative_error(nominal, true)


def relative_error(mechanism, true):
    """Largest difference of the platform's angle between two poses at the same joints: constant
    frames do not enter.
    """
    worst = 0.0
    joints = [
        [0.2, 0.25, 0.2, 0.22, 0.3, 0.25],
        [0.3, 0.2, 0.25, 0.3, 0.2, 0.22],
        [0.15, 0.2, 0.3, 0.25, 0.2, 0.2],
    ]
    turns = [
        [symkin.solve(m, joints=q).solution.rotation for q in joints] for m in (mechanism, true)
    ]
    for a in range(3):
        for b in range(a):
            angles = [np.arccos(np.clip((np.trace(t[a].T @ t[b]) - 1) / 2, -1, 1)) for t in turns]
            worst = max(worst, abs(angles[0] - angles[1]))
    return worst


@pytest.mark.long
@pytest.mark.slow
def test_a_plan_is_simulated_and_fitted(capsys, tmp_path):
    """The plan's file has what it expects in comments and goes through simulate to a believable fit
    in joint frames.
    """
    plan, data = tmp_path / "plan.csv", tmp_path / "data.csv"
    status, said, _ = run(
        capsys,
        "calibrate",
        "plan",
        "ren2008",
        "-o",
        plan,
        "--postures",
        "24",
        "--groups",
        "3",
        "--wedges",
        "20:20,-20:20,20:-20",
    )
    assert status == 0
    assert "rank 32 of 42" in said
    lines = plan.read_text().splitlines()
    assert lines[1].startswith("# expected pose error: rms")
    assert lines[3].endswith("wedge_alpha[deg],wedge_beta[deg]")
    assert len(lines) == 4 + 24
    assert (
        run(
            capsys,
            "calibrate",
            "simulate",
            "ren2008",
            "--truth",
            "ren2008_true",
            "--plan",
            plan,
            "-o",
            data,
        )[0]
        == 0
    )
    frames = "joints:leg1,leg2,leg6/leg1,leg2"
    status, said, _ = run(
        capsys, "calibrate", "fit", "ren2008", data, "-o", tmp_path / "out", "--frames", frames
    )
    assert status == 0
    assert "believable" in said
    assert "rank 32 of 32" in said
    assert symkin.load(str(tmp_path / "out" / "ren2008.toml")).limbs[0].base == (0.0, 0.0, 0.0)


def test_a_simulation_is_a_function_of_its_seed_and_tells_no_truth(capsys, tmp_path, data):
    """The same seed writes the same bytes; the file holds readings and standard deviations only."""
    again = tmp_path / "again.csv"
    run(
        capsys,
        "calibrate",
        "simulate",
        "ren2008",
        "--truth",
        "ren2008_true",
        "--groups",
        "10",
        "--seed",
        "3",
        "-o",
        again,
    )
    assert again.read_bytes() == data.read_bytes()
    header, *rows = data.read_text().splitlines()
    legs = [f"leg{k}[m]" for k in range(1, 7)]
    assert header.split(",") == [
        "group",
        *legs,
        *(f"sigma_{leg}" for leg in legs),
        "sigma_group[deg]",
    ]
    assert len(rows) == 40


def scaled(factor):
    def change(rows):
        for row in rows:
            row[1:7] = [repr(float(cell) * factor) for cell in row[1:7]]

    return change


def exchanged(rows):
    for row in rows:
        row[2], row[5] = row[5], row[2]


def one_scaled(rows):
    for row in rows:
        row[3] = repr(1e3 * float(row[3]))


def regrouped(rows):
    rows[5][0] = "9"


def level(rows):
    for row in rows:
        row[0] = "1"
    del rows[4:]


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (scaled(1e3), "1000 too large"),
        (scaled(1e-3), "1000 too small"),
        (exchanged, "leg2 and leg5 look exchanged"),
        (level, "NOT USABLE"),
        (one_scaled, "leg3 look a factor of 1000 too large"),
    ],
    ids=[
        "mm for m",
        "m for mm",
        "columns exchanged",
        "four postures",
        "one leg in mm",
    ],
)
def test_what_cannot_be_used_is_reported_and_why(capsys, tmp_path, data, change, words):
    """Exit status 3, a report that says why, and no mechanism file."""
    out = tmp_path / "out"
    status, said, _ = run(
        capsys,
        "calibrate",
        "fit",
        "ren2008",
        changed(data, tmp_path / "bad.csv", change),
        "-o",
        out,
    )
    assert status == 3
    assert words in said
    assert words in (out / "report.md").read_text()
    report = json.loads((out / "report.json").read_text())
    assert not report["usable"]
    assert not (out / "ren2008.toml").exists()
    assert report.get("pose_sigma") is None
    assert not (out / "pose_sigma.png").exists()
    assert "poses in aligned frames" not in said + (out / "report.md").read_text()


@pytest.mark.slow
def test_a_posture_in_a_wrong_group_is_left_out_and_named(capsys, tmp_path, data):
    """The other 39 are a calibration by themselves (their parameters agree with the truth); what
    the posture that is left out looks like stands in text and report.
    """
    out, words = tmp_path / "out", "posture line 7 looks to be in the wrong group"
    bad = changed(data, tmp_path / "bad.csv", regrouped)
    status, said, _ = run(capsys, "calibrate", "fit", "ren2008", bad, "-o", out)
    assert status == 0
    assert words in said
    assert words in (out / "report.md").read_text()
    report = json.loads((out / "report.json").read_text())
    assert [o["posture"] for o in report["outliers"]] == ["line 7"]
    assert report["used"] == report["postures"] - 1


@pytest.mark.slow
def test_a_fit_that_can_be_used_has_a_pose_sigma(capsys, tmp_path, data):
    """Of a usable fit the same places hold figures."""
    out = tmp_path / "out"
    _, said, _ = run(capsys, "calibrate", "fit", "ren2008", data, "-o", out)
    assert json.loads((out / "report.json").read_text())["pose_sigma"]["position_rms"] > 0
    assert "poses in aligned frames" in said


@pytest.mark.slow
def test_too_few_solvable_postures_are_the_reason_given(capsys, tmp_path, data):
    """Groups are there but only one posture closes: the sentence says so, and not that nothing was
    read.
    """

    def change(rows):
        del rows[12:]
        for row in rows[1:]:
            row[1] = "3.9"

    bad = changed(data, tmp_path / "bad.csv", change)
    status, said, complaint = run(
        capsys, "calibrate", "fit", "ren2008", bad, "-o", tmp_path / "out"
    )
    assert status == 2
    assert "the direct problem of only 1 of 12 postures has a solution" in complaint
    assert "no reading beside" not in said + complaint


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("sigma", [True, False], ids=["sigma known", "sigma unknown"])
def test_rounding_is_no_outlier(capsys, tmp_path, sigma):
    """Of a simulation without noise nothing is flagged, whether sigma is known or not, and a note
    asks what it is; one gross error is the only outlier.
    """
    exact, bad, options = (
        tmp_path / "exact.csv",
        tmp_path / "bad.csv",
        ["--sigma-group", "1arcsec"] if sigma else [],
    )
    none = ["--noise-joints", "0", "--noise-group", "0"]
    run(
        capsys,
        "calibrate",
        "simulate",
        "ren2008",
        "--truth",
        "ren2008_true",
        "--groups",
        "5",
        *none,
        "-o",
        exact,
    )

    def change(rows):
        rows[8][2] = repr(float(rows[8][2]) + 5e-5)

    changed(exact, bad, change)
    for path, lines in ((exact, []), (bad, ["line 10"])):
        run(capsys, "calibrate", "fit", "ren2008", path, "-o", tmp_path / "out", *options)
        report = json.loads((tmp_path / "out" / "report.json").read_text())
        assert [o["posture"] for o in report["outliers"]] == lines
        assert any(
            "is this a plan, or a simulation without noise?" in note for note in report["notes"]
        )


@pytest.mark.slow
def test_noise_is_not_called_rounding(capsys, tmp_path, data):
    """With noise of 2e-6 of the size there is no such question."""
    run(capsys, "calibrate", "fit", "ren2008", data, "-o", tmp_path / "out")
    assert "without noise" not in (tmp_path / "out" / "report.md").read_text()


@pytest.mark.long
@pytest.mark.slow
def test_single_bad_rows_are_named(capsys, tmp_path, data):
    """A posture that does not close is named by its line; the fit of the others stands."""

    def change(rows):
        rows[5][1] = "3.9"

    status, said, _ = run(
        capsys,
        "calibrate",
        "fit",
        "ren2008",
        changed(data, tmp_path / "bad.csv", change),
        "-o",
        tmp_path / "out",
    )
    assert status == 0
    assert "line 7" in said
    assert "39 of 40 postures" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["fit", "ren2008", "DATA", "-o", "KEPT"], "is a file; the name of a folder"),
        (["fit", "ren2008", "none.csv", "-o", "OUT"], "none.csv: there is no such file"),
        (["fit", "ren2008", "DATA", "-o", "OUT", "--parameters", "leg*.bse.*"], "matches nothing"),
        (["fit", "ren2008", "DATA", "-o", "OUT", "--hold", "nonsense"], "matches nothing"),
        (
            ["fit", "ren2008", "DATA", "-o", "OUT", "--frames", "joints:leg1"],
            "joints:P1,P2,P3/B1,B2",
        ),
        (["fit", "ren2008", "DATA", "-o", "OUT", "--sigma-group", "1mm"], "unit of angle"),
        (["fit", "ren2008", "DATA", "-o", "OUT", "--sigma-group", "0.1"], "stands in the file"),
        (
            ["fit", "zhao2000", "DATA", "-o", "OUT"],
            "there is no column of the actuated joint 'theta1'; unknown: 'leg1[m]'",
        ),
        (["simulate", "ren2008", "-o", "FILE", "--readings", "colour"], "allowed: inclination"),
        (["simulate", "ren2008", "-o", "FILE", "--truth", "zhang2009"], "are not those of ren2008"),
        (
            ["simulate", "ren2008", "-o", "FILE", "--postures", "3", "--groups", "2"],
            "two postures in each",
        ),
        (["simulate", "ren2008", "-o", "FILE", "--seed", "-1"], "negative"),
        (["fit", "ren2008", "DATA", "-o", "OUT", "--seed", "-1"], "negative"),
        (["plan", "ren2008", "-o", "FILE", "--seed", "-1"], "negative"),
        (["simulate", "ren2008", "-o", "FILE", "--box", "1"], "three numbers"),
        (["plan", "ren2008", "-o", "FILE", "--wedges", "5"], "alpha:beta"),
        (["plan", "ren2008", "-o", "FILE", "--noise-joints", "fast"], "unit of length"),
        (["plan", "ren2008", "-o", "FILE", "--groups", "0"], "nothing is read"),
        (
            ["fit", "ren2008", "DATA", "-o", "OUT", "--parameters", ""],
            "parameter '' matches nothing",
        ),
        (["fit", "ren2008", "DATA", "-o", "OUT", "--hold", ""], "parameter '' matches nothing"),
        (
            ["simulate", "ren2008", "-o", "FILE", "--noise-group", "0.001deg"],
            "there are no groups; give --groups",
        ),
        (["simulate", "ren2008", "-o", "FILE"], "nothing is read beside the joints"),
        (["simulate", "ren2008", "-o", "FILE", "--groups", "-1"], "-1 groups are asked for"),
        (
            ["simulate", "ren2008", "-o", "FILE", "--groups", "5", "--noise-joints", "2"],
            "2 m is given; allowed: to a tenth of the size",
        ),
        (
            ["simulate", "ren2008", "-o", "FILE", "--readings", "pose", "--noise-position", "1"],
            "--noise-position",
        ),
        (["plan", "ren2008", "-o", "FILE", "--noise-group", ""], "unit of angle"),
        (["plan", "ren2008", "-o", "FILE", "--noise-group", "10deg"], "allowed: to 5.73 deg"),
        (
            ["plan", "ren2008", "-o", "FILE", "--postures", "1"],
            "at least 10 postures for 5 groups, or fewer --groups",
        ),
    ],
)
def test_bad_input_is_one_line_and_loses_nothing(capsys, tmp_path, data, arguments, fragment):
    """Exit status 2, one sentence on stderr, files that exist stay as they were, and none is
    made.
    """
    kept = tmp_path / "kept.txt"
    kept.write_text("mine")
    places = {"DATA": data, "KEPT": kept, "FILE": tmp_path / "new.csv", "OUT": tmp_path / "out"}
    status, said, complaint = run(capsys, "calibrate", *(places.get(a, a) for a in arguments))
    assert (status, said) == (2, "")
    assert fragment in complaint
    assert complaint.count("\n") == 1
    assert kept.read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["kept.txt"]


def test_the_mechanism_that_was_given_is_not_overwritten(capsys, tmp_path, data):
    """A fit into the folder of its own mechanism file is refused."""
    own = tmp_path / "ren2008.toml"
    own.write_text(symkin.load("ren2008").to_toml())
    before = own.read_text()
    status, _, complaint = run(capsys, "calibrate", "fit", own, data, "-o", tmp_path)
    assert status == 2
    assert "would be lost" in complaint
    assert own.read_text() == before


@pytest.mark.slow
def test_other_content_of_the_folder_stays(capsys, tmp_path, data):
    """A folder with other files keeps them, and pictures of an earlier fit are said to be so."""
    fit = ("calibrate", "fit", "ren2008", data, "-o", tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    status, said, _ = run(capsys, *fit, "--pictures")
    assert (status, "of an earlier fit" in said) == (0, False)
    said = run(capsys, *fit)[1]
    assert said.count("is of an earlier fit") == 3
    assert f"note: {tmp_path / 'residuals.png'} is of an earlier fit" in said
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert {p.name for p in tmp_path.iterdir()} >= FILES
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_outputs_do_not_replace_what_is_read(capsys, tmp_path, data):
    """`simulate -o` with the plan's name, and `plan -o` with the mechanism's: refused, both files
    stay.
    """
    plan, mechanism = tmp_path / "plan.csv", tmp_path / "m.toml"
    plan.write_text(data.read_text())
    mechanism.write_text(symkin.load("ren2008").to_toml())
    before = plan.read_text(), mechanism.read_text()
    for arguments in (
        ["simulate", "ren2008", "--plan", plan, "-o", plan],
        ["plan", mechanism, "-o", mechanism],
    ):
        status, out, err = run(capsys, "calibrate", *arguments)
        assert (status, out) == (2, "")
        assert "is read by this command" in err
    assert (plan.read_text(), mechanism.read_text()) == before
