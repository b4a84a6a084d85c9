"""`symkin track`: its JSON, its files, its exit status, and that every mistake is one line that
leaves files alone.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run, run_json
from helpers.inside import read_table, read_trajectory, write_track
from helpers.laws import closes
from helpers.samples import bars, three_rrr
from symkin import InputError, track

EXAMPLE = "144.6,347.0,110.3,178.6,277.6,269.4"
NEAR = "154.6,340.0,115.3,180.6,270.6,269.4"
BEYOND = "204.6,425.0,206.3,292.6,409.6,419.4"
KEYS = {
    "mechanism",
    "problem",
    "given",
    "length_unit",
    "angle_unit",
    "reached",
    "statement",
    "stop",
    "certified",
    "ground",
    "followed_to",
    "steps",
    "nearest",
    "samples",
    "elapsed_s",
    "notes",
}


def test_reached_path_has_all_its_samples(capsys):
    """Status 0; the first and the last sample have the given joint values, each is proved within
    its radius.
    """
    status, found = run_json(
        capsys, "track", "zhang2009", "--from", EXAMPLE, "--to", NEAR, "--samples", "5"
    )
    assert (status, set(found), len(found["samples"])) == (0, KEYS, 5)
    assert found["reached"]
    assert found["certified"]
    assert list(found["samples"][0]["joints"].values()) == [float(v) for v in EXAMPLE.split(",")]
    assert list(found["samples"][-1]["joints"].values()) == pytest.approx(
        [float(v) for v in NEAR.split(",")]
    )
    assert all(0 < sample["radius"] < 1e-9 for sample in found["samples"])


def test_stopped_path_has_status_3_and_says_where(capsys):
    """A fold on the way: status 3, the JSON is written, the last sample is the place, the modes
    that meet are numbered.
    """
    status, found = run_json(
        capsys, "track", "zhang2009", "--from", EXAMPLE, "--to", BEYOND, "--samples", "3"
    )
    assert status == 3
    assert not found["reached"]
    assert found["stop"]["kind"] == "turning point"
    assert found["stop"]["place"] == found["samples"][-1]
    meeting = found["stop"]["meeting"]
    listed = symkin.modes(symkin.load("zhang2009"), **meeting["given"])
    assert len(listed) == meeting["modes"]
    own, other = (listed[k - 1] for k in (meeting["own"], meeting["others"][0]))
    place = found["samples"][-1]["pose"]["position"]
    furthest = max(math.dist(mode.position, place) for mode in listed)
    assert max(math.dist(own.position, place), math.dist(other.position, place)) < 0.05 * furthest


def test_start_chooses_the_mode(capsys):
    """Two starts, two modes: mirror images in the base's plane."""
    ends = []
    for z in ("100", "-100"):
        start = f"0,0,{z},1,0,0,0"
        _, found = run_json(
            capsys,
            "track",
            "zhang2009",
            "--from",
            EXAMPLE,
            "--to",
            NEAR,
            "--samples",
            "2",
            "--start",
            start,
        )
        ends.append(found["samples"][-1]["pose"]["position"])
    assert ends[0] == pytest.approx([ends[1][0], ends[1][1], -ends[1][2]])


def test_poses_make_the_inverse_problem(capsys):
    """With --poses the end is a pose, and its joints close the loops there."""
    poses = ("0,0,100,1,0,0,0", "20,10,120,0.98,0.1,0.1,0.1")
    status, found = run_json(
        capsys,
        "track",
        "zhang2009",
        "--poses",
        "--from",
        poses[0],
        "--to",
        poses[1],
        "--samples",
        "4",
    )
    assert (status, found["problem"], len(found["samples"])) == (0, "inverse", 4)
    assert found["samples"][-1]["pose"]["position"] == pytest.approx([20, 10, 120])
    assert found["samples"][-1]["residual"] < 1e-9


def test_written_track_can_be_read_again(tmp_path, capsys):
    """-o writes the rows that --csv reads; joints and poses of the second track are those of the
    first, times are kept.
    """
    times = "\n".join(f"{k * 250},{144.6 + k},347,110.3,178.6,277.6,269.4" for k in range(4))
    source, one, two = tmp_path / "in.csv", tmp_path / "one.csv", tmp_path / "two.csv"
    legs = ",".join(f"leg{k}[mm]" for k in range(1, 7))
    source.write_text(f"# a trajectory\nt[ms],{legs}\n{times}\n")
    assert run(capsys, "track", "zhang2009", "--csv", str(source), "-o", str(one))[0] == 0
    assert run(capsys, "track", "zhang2009", "--csv", str(one), "--poses", "-o", str(two))[0] == 0
    first, second = read_table(one), read_table(two)
    assert (
        first.numbers("t", "time", "s")
        == second.numbers("t", "time", "s")
        == [0.0, 0.25, 0.5, 0.75]
    )
    for name in [f"leg{k}" for k in range(1, 7)]:
        assert first.numbers(name, "length", "mm") == pytest.approx(
            second.numbers(name, "length", "mm"), abs=1e-9
        )


def test_a_spreadsheets_trajectory_is_the_same(tmp_path, capsys):
    """Semicolons, decimal commas, capitals, parentheses and a column of remarks: the same samples,
    and notes that say so.
    """
    legs = [f"leg{k}" for k in range(1, 7)]
    header = ",".join(f"{name}[mm]" for name in legs)
    (tmp_path / "own.csv").write_text(f"{header}\n{EXAMPLE}\n{NEAR}\n")
    lines = [";".join([*(f"{name.capitalize()} (mm)" for name in legs), "Remark"])]
    lines += [
        ";".join([*row.replace(".", "_").replace(",", ";").replace("_", ",").split(";"), "1.5"])
        for row in (EXAMPLE, NEAR)
    ]
    (tmp_path / "other.csv").write_bytes(("\ufeff" + "\r\n".join(lines)).encode())
    own, other = (
        run_json(capsys, "track", "zhang2009", "--csv", str(tmp_path / f"{n}.csv"))[1]
        for n in ("own", "other")
    )
    assert other["samples"] == own["samples"]
    assert not own["notes"]
    for words in ("semicolons", "decimal commas", "'Leg1 (mm)' as leg1[mm]", "left out: 'Remark'"):
        assert any(words in note for note in other["notes"])


def test_angles_of_a_file_are_those_of_pose(tmp_path, capsys):
    """Roll, pitch and yaw, and Euler angles of a sequence in the header, are the poses that
    `Pose.from_euler` makes.
    """
    mechanism, rows = symkin.load("zhang2009"), [(5, -5, 100, 3, -2, 4), (8, -2, 104, 6, 1, -5)]
    for header, sequence in (
        ("Roll[deg],pitch[deg],yaw[deg]", "xyz"),
        (",".join(f"euler_ZYX_{k}[deg]" for k in (1, 2, 3)), "ZYX"),
    ):
        lines = [f"x[mm],y[mm],z[mm],{header}", *(",".join(map(str, row)) for row in rows)]
        (tmp_path / "poses.csv").write_text("\n".join(lines))
        read = read_trajectory(mechanism, tmp_path / "poses.csv")["poses"]
        for row, pose in zip(rows, read, strict=True):
            expected = symkin.Pose.from_euler(row[:3], row[3:], sequence, angle_unit="deg")
            assert pose == pytest.approx([*expected.position, *expected.quaternion], abs=1e-12)
        assert run(capsys, "track", "zhang2009", "--csv", tmp_path / "poses.csv")[0] == 0


def test_positions_alone_are_poses_of_a_platform_that_keeps_its_orientation(tmp_path, capsys):
    (tmp_path / "poses.csv").write_text("x[mm],y[mm],z[mm]\n0,0,-200\n20,10,-250\n")
    status, found = run_json(capsys, "track", "delta", "--csv", tmp_path / "poses.csv")
    assert (status, found["problem"]) == (0, "inverse")
    assert found["samples"][-1]["pose"]["position"] == pytest.approx([20, 10, -250])


def test_orientations_that_a_file_leaves_open_are_refused(tmp_path, capsys):
    for mechanism, header, row, part in (
        ("zhang2009", "x[mm],y[mm],z[mm]", "1,2,3", "no columns of the orientation"),
        (
            "zhang2009",
            "x[mm],y[mm],z[mm],roll[deg],pitch[deg]",
            "1,2,3,4,5",
            "'roll' stands there without yaw",
        ),
        (
            "zhang2009",
            "x[mm],y[mm],z[mm],roll[deg],pitch[deg],yaw[deg],qw",
            "1,2,3,4,5,6,1",
            "stands twice",
        ),
        ("zhang2009", "x[mm],y[mm],z[mm],roll,pitch,yaw", "1,2,3,4,5,6", "unit of angle"),
        (
            "zhang2009",
            "x[mm],y[mm],z[mm],euler_ZYX_1[deg],euler_ZYX_2[deg]",
            "1,2,3,4,5",
            "euler_ZYX_3",
        ),
        ("zhang2009", "x[mm],y[mm],z[mm],euler_ZZX_1[deg]", "1,2,3,4", "neighbours different"),
        (
            "zhang2009",
            "x[mm],y[mm],z[mm],euler_xyz_1[deg],roll[deg],pitch[deg],yaw[deg]",
            "1,2,3,4,5,6,7",
            "both mean",
        ),
    ):
        (tmp_path / "poses.csv").write_text(f"{header}\n{row}\n")
        status, _, err = run(capsys, "track", mechanism, "--csv", tmp_path / "poses.csv")
        assert (status, err.count("\n")) == (2, 1)
        assert part in err
    status, _, err = run(
        capsys, "track", "zhang2009", "--poses", "--euler", "rpy", "--csv", tmp_path / "poses.csv"
    )
    assert (status, "header" in err) == (2, True)


def test_passive_joints_of_every_kind_are_written(tmp_path):
    """A closure with quaternions and angles: each written row, read back, is the sample."""
    mechanism = symkin.load("zhao2000_links")
    q = symkin.solve(mechanism).solution.actuated_values
    found = track(mechanism, joints=[q, [q[0] + 1, *q[1:]]])
    assert all(closes(mechanism, sample.solution) for sample in found.samples)
    write_track(found, tmp_path / "t.csv")
    table = read_table(tmp_path / "t.csv")
    unit = {"deg": "angle", "mm": "length"}
    for name, value in found.end.joints.items():
        if isinstance(value, list):
            assert [
                table.numbers(f"{name}.{part}")[-1] for part in ("qw", "qx", "qy", "qz")
            ] == value
        else:
            column = table.columns[name]
            assert table.numbers(name, unit[column.unit], column.unit)[-1] == value
    again = read_trajectory(mechanism, tmp_path / "t.csv")
    assert again["joints"] == [sample.actuated_values for sample in found.samples]


def test_repeated_rows_stand_still(tmp_path, capsys):
    """Rows that repeat give samples that repeat."""
    legs = ",".join(f"leg{k}[mm]" for k in range(1, 7))
    (tmp_path / "in.csv").write_text(f"{legs}\n{EXAMPLE}\n{EXAMPLE}\n{NEAR}\n{NEAR}\n")
    status, found = run_json(capsys, "track", "zhang2009", "--csv", str(tmp_path / "in.csv"))
    poses = [sample["pose"] for sample in found["samples"]]
    assert status == 0
    assert (poses[0], poses[2]) == (poses[1], poses[3])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--from", "1,2", "--to", "3,4"], "sample 1: 2 values given"),
        (["--from", EXAMPLE], "--to is missing"),
        (["--to", EXAMPLE], "--from is missing"),
        (["--from", EXAMPLE, "--to", EXAMPLE.replace("347.0", "nan")], "sample 2: value 2"),
        (["--from", EXAMPLE, "--to", EXAMPLE.replace("347.0", "-3")], "leg2 = -3"),
        (["--from", EXAMPLE, "--to", EXAMPLE, "--poses"], "6 values given, 7"),
        (["--from", EXAMPLE, "--to", NEAR, "--samples", "1"], "samples = 1"),
        (["--from", EXAMPLE, "--to", NEAR, "--samples", "10000000"], "from 2 to 1000000"),
        (["--from", EXAMPLE, "--to", NEAR, "--start", "1,2"], "start: 2 values"),
        (["--from", EXAMPLE, "--to", NEAR, "--plot", "nowhere.xyz"], "nowhere.xyz"),
        (["--csv", "missing.csv", "--from", EXAMPLE], "give one of them"),
        (["--csv", "missing.csv"], "there is no such file"),
        (["--from", EXAMPLE, "--to", NEAR, "-o", "/no/such/folder/t.csv"], "folder"),
    ],
)
def test_mistakes_are_one_line(capsys, arguments, words):
    """Status 2 and one line that names what is wrong."""
    status, out, err = run(capsys, "track", "zhang2009", *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert words in err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("leg1[mm],leg2\n1,2\n", "leg2' needs a unit"),
        ("leg1[mm],foo[mm]\n1,2\n", "'leg2' is missing; the header has leg1; left out: 'foo[mm]'"),
        ("leg1[mm],leg2[mm]\n1,2\n", "'leg3' is missing"),
        ("leg1[mm],leg2[deg]\n1,2\n", "leg2[deg]"),
        ("x[mm],y[mm],z[mm],qw,qx,qy\n1,2,3,1,0,0\n", "'qz' is missing"),
        (",".join(f"leg{k}[mm]" for k in range(1, 7)) + "\n", "no rows"),
        (",".join(f"leg{k}[mm]" for k in range(1, 7)) + "\n1,2,3,4,5,nan\n", "line 2"),
        (
            "t[s],"
            + ",".join(f"leg{k}[mm]" for k in range(1, 7))
            + "\n0"
            + ",9" * 6
            + "\n\n2"
            + ",9" * 6
            + "\n1"
            + ",9" * 6
            + "\n",
            "line 5, column 't'",
        ),
    ],
)
def test_wrong_tables_leave_the_output_alone(tmp_path, capsys, text, words):
    """A table that does not fit is refused in one line, and the file named by -o stays as it is."""
    source, output = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(text)
    output.write_text("kept")
    status, _, err = run(capsys, "track", "zhang2009", "--csv", str(source), "-o", str(output))
    assert (status, err.count("\n"), output.read_text()) == (2, 1, "kept")
    assert words in err


def test_no_start_has_status_3(capsys):
    """Inputs that no pose takes: status 3, no samples, and the reason."""
    status, found = run_json(
        capsys, "track", "zhang2009", "--from", "1,1,1,1,1,1", "--to", "2,2,2,2,2,2"
    )
    assert (status, found["samples"], found["stop"]["kind"]) == (3, [], "no start")


@pytest.mark.slow
@pytest.mark.parametrize("problem", ["direct", "inverse"])
def test_picture_is_written(tmp_path, problem):
    """The robot at start and end; panels of what moves and of distances over the inputs; a stop is
    marked in all panels.
    """
    from helpers.inside import figure_of_track

    mechanism = symkin.load("zhang2009")
    if problem == "direct":
        rows = [[float(v) for v in text.split(",")] for text in (EXAMPLE, BEYOND)]
        found = track(mechanism, joints=rows, samples=5, name_modes=False)
    else:
        found = track(
            mechanism, poses=[[0, 0, 100, 1, 0, 0, 0], [0, 0, 120, 1, 0, 0, 0]], samples=5
        )
    figure = figure_of_track(found)
    sheet, *panels = figure.axes
    assert [sum(line.get_gid() == "stop" for line in ax.get_lines()) for ax in panels] == [
        int(not found.reached)
    ] * len(panels)
    labels = " ".join(ax.get_ylabel() for ax in panels)
    assert "distance to\nsingularity" in labels
    assert ("turned" in labels) == (problem == "direct")
    titles = {text.get_text() for text in sheet.texts}
    assert {"start", "end" if found.reached else f"stop: {found.stop.kind}"} <= titles
    told = " ".join(text.get_text() for text in panels[-1].texts) + panels[-1].get_xlabel()
    assert ("leg1 [mm]" in told) == (problem == "direct")
    assert ("z [mm]" in told) == (problem == "inverse")
    found.plot(tmp_path / "t.png", names="all", views="top")
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", ["ren2008", "ankle", "gluon_6l3"])
def test_texts_of_the_picture_lie_apart_and_within(name):
    """No text of a track's picture meets another or the edge; every curve has a name, and limits a
    panel where there are some.
    """
    from itertools import combinations

    from helpers.inside import figure_of_track

    ends = {
        "ren2008": [[0.2, 0.25, 0.2, 0.22, 0.3, 0.25], [0.4, 0.25, 0.2, 0.22, 0.6, 0.25]],
        "ankle": [[0.0, 0.0], [80.0, 60.0]],
        "gluon_6l3": [[15.0] * 6, [40.0, 20.0, 30.0, -15.0, 15.0, 15.0]],
    }[name]
    mechanism = symkin.load(name)
    found = track(mechanism, joints=ends, samples=21, name_modes=False)
    figure = figure_of_track(found)
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    texts = [*figure.texts, *(text for ax in figure.axes for text in ax.texts)]
    for ax in figure.axes:
        if ax.axison:
            texts += [
                ax.xaxis.label,
                ax.yaxis.label,
                *ax.get_xticklabels(),
                *ax.get_legend().get_texts(),
            ]
    boxes = [
        (text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_text()
    ]
    for text, box in boxes:
        assert min(box.x0, box.y0, figure.bbox.width - box.x1, figure.bbox.height - box.y1) >= 0, (
            text
        )
    assert [(a, b) for (a, one), (b, other) in combinations(boxes, 2) if one.overlaps(other)] == []
    has_limits = any(c.limits is not None for c in mechanism.coordinates)
    assert any("distance to limits" in ax.get_ylabel() for ax in figure.axes) == has_limits


def test_curves_that_are_one_have_all_their_names():
    """A level platform that rises: six rods move alike, in one line with six names."""
    from helpers.inside import panels_of

    found = track(
        symkin.load("zhang2009"),
        poses=[[0, 0, 100, 1, 0, 0, 0], [0, 0, 120, 1, 0, 0, 0]],
        samples=5,
    )
    (curve,) = next(panels_of(found)).curves
    assert all(f"leg{k}" in curve.name for k in range(1, 7))
    assert curve.name.endswith(f"from {found.samples[0].joints['leg1']:.5g}")


def test_a_curve_that_another_covers_is_seen():
    """Law: of curves that lie on each other the earlier is wider there; of curves that only cross
    none is.
    """
    from matplotlib.figure import Figure

    from helpers.inside import Curve, CurvePanel, _draw_curves

    x, at = np.linspace(0.0, 1.0, 51), np.arange(51)
    for second, widths in ((x.copy(), 1), (1.0 - x, 0), (np.where(x < 0.5, x, 0.5), 1)):
        ax = Figure().add_subplot()
        _draw_curves(ax, CurvePanel("", (Curve("a", x, at), Curve("b", second, at))), x)
        wide = [line for line in ax.get_lines() if line.get_gid() == "covered"]
        assert len(wide) == widths
        for line in wide:
            assert line.get_zorder() < max(other.get_zorder() for other in ax.get_lines())
            assert line.get_linewidth() > 2.0 * ax.get_lines()[-1].get_linewidth()


def test_text_is_a_short_table(capsys):
    """At most eleven rows, then the statement and its ground."""
    status, out, _ = run(
        capsys, "track", "zhang2009", "--from", EXAMPLE, "--to", NEAR, "--samples", "40"
    )
    lines = out.splitlines()
    assert (status, len(lines)) == (0, 2 + 11 + 4)
    assert lines[-3].startswith("nearest to a singularity at ")
    assert lines[-2].startswith("reached")
    assert json.dumps(lines[-1]).startswith('"ground: proved')


def test_nothing_is_printed_as_0():
    """Coordinates that are zero but for rounding are printed as 0, without a sign, and columns are
    aligned.
    """
    found = track(
        bars(100.0, 40.0, 100.0, 40.0, "spatial"), joints=[[1.0], [-1.0]], name_modes=False
    )
    header, *rows = str(found).splitlines()[1:4]
    assert all(len(row) == len(header) for row in rows)
    assert rows[-1].split()[2:-1] == ["0", "0", "1.00000", "0.00000", "0.00000", "0.00000", "0"]


def test_far_starts_are_noted(capsys):
    """A start far from the mode that it led to is followed with a note; a near one without."""
    arguments = ("track", "zhang2009", "--from", EXAMPLE, "--to", NEAR, "--samples", "2", "--start")
    _, far = run_json(capsys, *arguments, "500,500,500,1,0,0,0")
    _, near = run_json(
        capsys,
        *arguments,
        ",".join(str(v) for v in far["samples"][0]["pose"]["position"]) + ",1,0,0,0.1",
    )
    assert any("the start lies" in note for note in far["notes"])
    assert far["samples"][0]["pose"]["position"] == pytest.approx(
        near["samples"][0]["pose"]["position"]
    )


def test_limits_may_be_ignored(tmp_path, capsys):
    """--ignore-limits goes on where a limit would stop."""
    text = (
        symkin.load("zhang2009")
        .to_toml()
        .replace('name = "leg1"', 'name = "leg1"\nlimits = [100.0, 150.0]', 1)
    )
    path = Path(tmp_path) / "limited.toml"
    path.write_text(text)
    stopped = run_json(
        capsys, "track", str(path), "--from", EXAMPLE, "--to", NEAR, "--samples", "2"
    )
    assert (stopped[0], stopped[1]["stop"]["limit"]) == (3, "leg1")
    assert stopped[1]["samples"][-1]["joints"]["leg1"] == pytest.approx(150.0, abs=1e-6)
    assert (
        run_json(
            capsys,
            "track",
            str(path),
            "--from",
            EXAMPLE,
            "--to",
            NEAR,
            "--samples",
            "2",
            "--ignore-limits",
        )[0]
        == 0
    )


def test_a_start_beyond_a_limit_is_said_to_be(capsys, tmp_path):
    """A joint that begins outside its limits does not meet them."""
    mechanism = bars(100.0, 40.0, 100.0, 40.0, limits=(-0.5, 0.5))
    (tmp_path / "bars.toml").write_text(mechanism.to_toml())
    status, found = run_json(
        capsys, "track", str(tmp_path / "bars.toml"), "--from", "1", "--to", "0"
    )
    assert status == 3
    assert "lies beyond its limit 0.5 rad at the start" in found["statement"]


@pytest.mark.parametrize("verb", [symkin.solve, symkin.modes, symkin.jacobian, symkin.track])
@pytest.mark.parametrize("wrong", ["zhang2009", 3])
def test_a_name_is_no_mechanism(verb, wrong):
    """The verbs of Python refuse what is not a mechanism in a sentence, which names `load` for a
    name.
    """
    with pytest.raises(
        InputError, match=r"symkin\.load\('zhang2009'\)" if wrong == "zhang2009" else "int"
    ):
        verb(wrong)


@pytest.mark.parametrize("motion", ["spatial", "planar"])
def test_motors_that_leave_a_platform_free_are_refused(motion: str) -> None:
    """Two limbs of a 3-RRR hold its platform but for one freedom, whether or not its motion is
    declared: there is no mode to stay on.
    """
    whole = three_rrr(motion)
    free = replace(whole, limbs=whole.limbs[:2])
    first = [free.angle_out(c.reference[0]) for c in free.actuated]
    with pytest.raises(InputError, match=r"leaves 1 of . unknowns free"):
        track(free, joints=[first, [value + 3.0 for value in first]])
