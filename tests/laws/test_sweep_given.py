"""Sweeps over coordinates told by name: of graphs of links and of limbs, passive joints and poses,
with named points, tables and pictures.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.folders import same_files
from helpers.graph_twin import graph_twin
from helpers.inside import main, make_space, read_given_text
from helpers.needed import Later, needs
from helpers.samples import five_bar, three_rps, three_rrr
from oracle.plain_check import MECHANISMS
from oracle.plain_graph import configurations, read
from symkin import InputError, sweep

xarray = Later("xarray")
pytestmark = needs("xarray")
COUPLER_POINT = """
[[link]]
name = "coupler"
points = { tracer = [40.0, 95.0, 0.0] }
"""


def four_bar_with_tracer(folder):
    """The gallery's four-bar with a named point on its coupler."""
    path = folder / "four_bar.toml"
    path.write_text((MECHANISMS / "four_bar.toml").read_text() + COUPLER_POINT)
    return path


def command(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main(["sweep", *(str(a) for a in arguments)])
    said = capsys.readouterr()
    return ended.value.code, said.out, said.err


def close_turns(one, other):
    """Whether angles in degrees are equal but for whole turns."""
    return np.allclose(
        np.exp(1j * np.radians(one)), np.exp(1j * np.radians(other)), rtol=0, atol=1e-7
    )


# --- the modes of each point ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("jansen_leg", {"crank": np.linspace(0, 330, 4)}),
        pytest.param(
            "ankle",
            {"ankle.1": np.linspace(-40, 40, 5), "ankle.2": np.linspace(-40, 40, 4)},
            marks=pytest.mark.long,
        ),
        ("ankle", {"upper_motor": [0.0, 9.0], "ankle.2": 4.0}),
        pytest.param(
            "excavator_bucket",
            {"boom": [5.0, 10.0], "stick_cylinder": 60.0, "bucket": [-20.0, 20.0]},
            marks=pytest.mark.long,
        ),
        pytest.param("pantograph_leg", {"x": [90.0, 100.0], "y": 240.0}, marks=pytest.mark.long),
        ("four_bar", {"follower": np.linspace(-90, 90, 9)}),
    ],
)
def test_points_have_the_modes_that_they_have_alone(tmp_path, name, given):
    """Count, all joints, named points, pose, residual and condition of `symkin.modes` at each
    point.
    """
    mechanism = symkin.load(name)
    data = sweep(mechanism, directory=tmp_path / "s", given=given, chunk=7, workers=0).open().load()
    space = make_space(mechanism, given, over="coordinates")
    points = space.points(tuple(slice(0, n) for n in space.shape))
    flat = {
        v: data[v].values.reshape(len(points), *data[v].shape[len(space.shape) :])
        for v in data.data_vars
        if "chunk" not in data[v].dims
    }
    for i, point in enumerate(points):
        alone = symkin.modes(mechanism, **space.given(point))
        assert flat["count"][i] == len(alone)
        for k, mode in enumerate(alone):
            joints = np.concatenate([np.atleast_1d(value) for value in mode.joints.values()])
            angular = data["joint_units"].values == "deg"
            assert close_turns(flat["joints"][i, k][angular], joints[angular])
            assert np.allclose(flat["joints"][i, k][~angular], joints[~angular], rtol=0, atol=1e-6)
            if mode.points:
                assert np.allclose(
                    flat["points"][i, k], list(mode.points.values()), rtol=0, atol=1e-6
                )
            if mode.has_platform:
                assert np.allclose(flat["position"][i, k], mode.position, rtol=0, atol=1e-6)
            assert flat["residual"][i, k] < 1e-9 * mechanism.characteristic_length
            assert flat["condition"][i, k] == pytest.approx(mode.condition, rel=1e-4)


def test_counts_are_those_of_an_independent_solver(tmp_path):
    """As many modes as random starts in maximal coordinates reach, at points with two, one pair and
    none.
    """
    angles = [-80.0, -20.0, 10.0, 45.0, 70.0]
    data = sweep(
        symkin.load("four_bar"), directory=tmp_path / "s", given={"follower": angles}, workers=0
    ).open()
    graph = read(MECHANISMS / "four_bar.toml", ["follower"])
    for angle, count in zip(angles, data["count"].values.tolist(), strict=True):
        assert len(configurations(graph, {"follower": angle}, 60).x) == count


def test_a_tracer_keeps_its_distances(tmp_path):
    """A point of the coupler is as far from the crank's pin, where that is by the crank's angle, as
    at the reference, and the coupler curve is closed: a whole turn ends where it began.
    """
    mechanism = symkin.load(four_bar_with_tracer(tmp_path))
    angles = np.linspace(0.0, 360.0, 73)
    data = sweep(mechanism, {"crank": angles}, tmp_path / "s", workers=0).open().load()
    assert data["named_point"].values.tolist() == ["tracer"]
    assert (data["count"].values == 2).all()
    tracer = data["points"].values[:, :, 0]
    pin = 40.0 * np.stack(
        [np.cos(np.radians(angles)), np.sin(np.radians(angles)), 0 * angles], axis=1
    )
    assert np.allclose(np.linalg.norm(tracer - pin[:, None], axis=2), math.dist((40, 95), (0, 40)))
    assert np.allclose(tracer[0], tracer[-1])


def test_all_actuated_joints_by_name_are_the_direct_problem(tmp_path):
    """Of limbs, the arrays of --given with every leg and of --grid are the same."""
    platform = symkin.load("zhang2009")
    legs = dict(zip((c.name for c in platform.actuated), platform.example.joints, strict=True))
    by_name = (
        sweep(
            platform, directory=tmp_path / "given", given=legs | {"leg2": [340.0, 345.0]}, workers=0
        )
        .open()
        .load()
    )
    inputs = sweep(platform, {"leg2": [340.0, 345.0]}, tmp_path / "grid", workers=0).open().load()
    assert by_name.attrs["problem"] == inputs.attrs["problem"] == "direct"
    for v in inputs.data_vars:
        assert np.array_equal(
            by_name[v].values, inputs[v].values, equal_nan=v not in ("count", "completeness")
        )


def test_limbs_are_swept_by_the_place_of_their_platform(tmp_path):
    """A five-bar by that of its tip: every mode has it, and the crank's end is a coupler off."""
    given = {"x": [40.0, 50.0], "y": [100.0, 110.0]}
    mechanism = replace(five_bar(), motion="planar")
    data = sweep(mechanism, directory=tmp_path / "s", given=given, workers=0).open().load()
    assert (data["count"].values == 4).all()
    place = data["position"].values[..., :2]
    assert np.allclose(place[..., 0], data["x"].values[:, None, None])
    assert np.allclose(place[..., 1], data["y"].values[:, None])
    angles = np.radians(data["joints"].sel(joint="q1").values)
    ends = 60.0 * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    assert np.allclose(np.linalg.norm(place - ends, axis=-1), 80.0)


@pytest.mark.long
@pytest.mark.slow
def test_limbs_are_swept_by_coordinates_of_their_pose(tmp_path):
    """A 3-RPS by height, azimuth and tilt: every mode has the pose that is told, and the legs'
    lengths are distances of its ends.
    """
    given = {"z": [290.0, 300.0], "azimuth": [0.5], "tilt": 0.2}
    data = sweep(three_rps(), directory=tmp_path / "s", given=given, workers=0).open().load()
    assert (data["count"].values > 0).all()
    there = np.arange(data.sizes["mode"]) < data["count"].values[..., None]
    assert np.allclose(
        data["position"].values[..., 2][there],
        np.broadcast_to(data["z"].values[:, None, None], there.shape)[there],
    )
    x, y = (data["quaternion"].values[..., k] for k in (1, 2))
    tilt = np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))
    assert np.allclose(tilt[there], 0.2)


@pytest.mark.slow
def test_points_that_close_to_the_digits_of_a_file_only(tmp_path):
    """A Bennett linkage written with six digits: at each point the configuration of least squares,
    said as sampled, as `modes` has it.
    """
    text = (MECHANISMS / "bennett.toml").read_text()
    path = tmp_path / "nearly.toml"
    path.write_text(
        re.sub(
            r"(point = \[)([-\d.]+)",
            lambda m: f"{m[1]}{float(m[2]) + (3e-4 if float(m[2]) == 20.0 else 0.0)}",
            text,
        )
    )
    nearly = symkin.load(path)
    data = (
        sweep(nearly, directory=tmp_path / "s", given={"input": [20.0, 40.0]}, workers=0)
        .open()
        .load()
    )
    alone = symkin.modes(nearly, given={"input": 40.0})
    assert data["count"].values.tolist() == [1, 1]
    assert (
        data["completeness"].attrs["flag_meanings"][int(data["completeness"][1])]
        == alone.completeness
    )
    assert float(data["residual"][1, 0]) == pytest.approx(alone[0].residual, rel=1e-6)
    assert alone[0].residual > 1e-6


def test_poses_of_a_planar_graph_are_swept(tmp_path):
    """A plate on three chains of two links: each is bent either way, and the plate where it is
    asked to be.
    """
    grid = {"x": [-5.0, 5.0], "y": [0.0, 4.0]}
    graph = graph_twin(three_rrr("planar"))
    data = sweep(graph, grid, tmp_path / "s", poses=True, workers=0).open().load()
    assert (data["count"].values == 8).all()
    wanted = np.stack(np.meshgrid(*grid.values(), indexing="ij"), axis=-1)
    assert np.allclose(data["position"].values[..., :2], wanted[:, :, None])


@pytest.mark.long
@pytest.mark.slow
def test_poses_of_a_graph_are_swept(tmp_path):
    """A spherical wrist by rotation vectors: eight working modes at each, with that orientation."""
    grid = {"rx": [-8.0, 8.0], "rz": [0.0, 10.0]}
    data = (
        sweep(symkin.load("spherical_wrist"), grid, tmp_path / "s", poses=True, workers=0)
        .open()
        .load()
    )
    assert (data["count"].values == 8).all()
    turn = np.radians(
        np.stack(np.meshgrid(grid["rx"], [0.0], grid["rz"], indexing="ij"), axis=-1)[:, 0]
    )
    half = 0.5 * np.linalg.norm(turn, axis=-1)
    assert np.allclose(data["quaternion"].values[..., 0], np.cos(half)[..., None])


def test_a_sweep_goes_on_and_does_not_depend_on_chunks_done_before(tmp_path):
    """A chunk that is removed is computed again to the same bytes; a sweep with another held value
    is refused.
    """
    ankle, given = symkin.load("ankle"), {"ankle.1": np.linspace(-10, 10, 6), "ankle.2": 3.0}
    sweep(ankle, directory=tmp_path / "a", given=given, chunk=2, workers=0)
    sweep(ankle, directory=tmp_path / "b", given=given, chunk=2, workers=0)
    for path in (tmp_path / "b" / "points" / "c" / "1").rglob("*"):
        if path.is_file():
            path.unlink()
    again = sweep(ankle, directory=tmp_path / "b", given=given, chunk=2, workers=0)
    assert (again.damaged, again.computed) == (1, 1)
    assert same_files(tmp_path / "a", tmp_path / "b")
    with pytest.raises(InputError, match=r"base is ankle\.2"):
        sweep(ankle, directory=tmp_path / "b", given=given | {"ankle.2": 4.0}, chunk=2, workers=0)


@pytest.mark.long
@pytest.mark.slow
def test_processes_compute_the_same_arrays(tmp_path):
    """Two workers and this process write the same files, of a structure that is solved by
    groups.
    """
    leg, given = symkin.load("jansen_leg"), {"crank": np.linspace(0, 340, 18)}
    sweep(leg, directory=tmp_path / "here", given=given, chunk=5, workers=0)
    sweep(leg, directory=tmp_path / "there", given=given, chunk=5, workers=2)
    assert same_files(tmp_path / "here", tmp_path / "there")


@pytest.mark.parametrize("quantity", ["conditioning", "reach"])
def test_other_quantities_of_a_graph(tmp_path, quantity):
    """Conditions and distances from singularities are those of the modes; where the follower cannot
    stand nothing is reached.
    """
    four_bar, angles = symkin.load("four_bar"), [-80.0, 10.0, 45.0]
    data = sweep(
        four_bar, directory=tmp_path / "s", given={"follower": angles}, quantity=quantity, workers=0
    ).open()
    if quantity == "reach":
        assert data["reached"].values.tolist() == [0, 1, 1]
        return
    alone = symkin.modes(four_bar, given={"follower": 45.0})
    for place, mode in enumerate(alone):
        alone_there = symkin.singularity(mode, given=["follower"]).distances
        assert float(data["distance_type_2"][2, place]) == pytest.approx(
            alone_there["type 2"], rel=1e-6
        )
        assert float(data["distance_increased"][2, place]) == pytest.approx(
            alone_there["increased"], rel=1e-6
        )
    assert np.isnan(data["distance_type_1"].values).all()
    assert float(data["least_condition"][2]) == pytest.approx(
        min(mode.condition for mode in alone), rel=1e-6
    )
    assert np.isnan(float(data["least_condition"][0]))


# --- what a user writes ---------------------------------------------------------------------------


def test_given_values_as_text():
    """NAME=LOW:HIGH:COUNT is swept, NAME=VALUE held, a pose has seven numbers, and a sample takes
    the ends.
    """
    read_values = read_given_text("crank=0:90:4,knee=sqrt(4),pose=1,2,3,1,0,0,0", angle_unit="deg")
    assert read_values["crank"].tolist() == [0.0, 30.0, 60.0, 90.0]
    assert read_values["knee"] == 2.0
    assert read_values["pose"] == [1, 2, 3, 1, 0, 0, 0]
    assert read_given_text("crank=0:90,knee=5", sampled=True)["crank"].tolist() == [0.0, 90.0]


@pytest.mark.parametrize(
    ("mechanism", "arguments", "said"),
    [
        ("four_bar", [], "nothing is swept"),
        ("four_bar", ["--given", "crank=10"], "nothing is swept"),
        ("four_bar", ["--given", "crnk=0:9:3"], "do you mean 'crank'?"),
        ("four_bar", ["--given", "crank=0:9"], "allowed: NAME=LOW:HIGH:COUNT"),
        ("four_bar", ["--given", "crank=0:9:2,crank=1"], "twice"),
        ("four_bar", ["--given", "crank"], "not of the form"),
        ("four_bar", ["--grid", "follower=0:9:3"], "--given follower"),
        ("four_bar", ["--given", "crank=0:9:2", "--at", "5"], "at is given"),
        ("four_bar", ["--given", "crank=0:9:2", "--grid", "crank=0:9:2"], "both"),
        ("four_bar", ["--given", "crank=0:9:2", "--poses"], "--poses"),
        ("four_bar", ["--given", "crank=0:9:2,follower=3"], "mobility is 1"),
        ("four_bar", ["--grid", "x=0:9:2", "--poses"], "no platform link"),
        ("ankle", ["--given", "ankle.1=0:9:2"], "leaves ankle 1 freedom"),
        ("ankle", ["--grid", "x=0:9:2", "--poses"], "tie the coordinates"),
        ("ankle", ["--given", "ankle.1=0:9:2,ankle.2=1,pose=0,0,0,1,0,0,0"], "are 6"),
        (
            "four_bar",
            ["--given", "crank=0:9:2", "--plot", "a.png", "--of", "folower"],
            "do you mean 'follower'?",
        ),
        ("four_bar", ["--given", "crank=0:9:2", "--of", "follower"], "--plot"),
        (
            "four_bar",
            [
                "--given",
                "crank=0:9:2",
                "--plot",
                "a.png",
                "--of",
                "follower",
                "--quantity",
                "reach",
            ],
            "quantity = 'modes'",
        ),
        (
            "jansen_leg",
            ["--given", "crank=0:9:2", "--plot", "a.png", "--of", "foot,knee"],
            "points and joints",
        ),
        ("jansen_leg", ["--given", "crank=0:9:2", "--csv", "no/such/folder.csv"], "folder"),
        ("excavator_bucket", ["--given", "boom=0:9:2,stick=nan,bucket=1"], "nan"),
    ],
)
def test_wrong_input_is_one_line(capsys, tmp_path, monkeypatch, mechanism, arguments, said):
    """Status 2, one line that names the mistake, and no folder."""
    monkeypatch.chdir(tmp_path)
    code, out, err = command(capsys, mechanism, *arguments, "-o", "s", "--workers", "0")
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "s").exists()


def test_a_mechanism_and_nothing_else_is_refused():
    with pytest.raises(InputError, match="directory"):
        sweep(symkin.load("four_bar"), given={"crank": [0.0, 1.0]})
    with pytest.raises(InputError, match="mapping"):
        sweep(symkin.load("four_bar"), given=[0.0, 1.0], directory="s")
    with pytest.raises(InputError, match="do not rise"):
        sweep(symkin.load("four_bar"), given={"crank": [1.0, 0.0]}, directory="s")


# --- tables and pictures --------------------------------------------------------------------------


def test_a_table_has_a_row_a_mode(capsys, tmp_path):
    """The foot's path as a CSV file: what is swept, the mode, the point, the joints, once each."""
    folder, table = tmp_path / "s", tmp_path / "foot.csv"
    code, out, _ = command(
        capsys,
        "jansen_leg",
        "--given",
        "crank=0:90:4",
        "-o",
        folder,
        "--workers",
        "0",
        "--csv",
        table,
    )
    assert code == 0
    data = xarray.open_zarr(folder).load()
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert f"{len(rows)} rows" in out
    assert len(rows) == int(data["count"].sum())
    assert list(rows[0])[:5] == ["crank[deg]", "mode", "foot.x[mm]", "foot.y[mm]", "foot.z[mm]"]
    for row in rows:
        at = data.sel(crank=float(row["crank[deg]"])).isel(mode=int(row["mode"]) - 1)
        assert float(row["foot.y[mm]"]) == float(at["points"][0, 1])
        assert float(row["knee[deg]"]) == float(at["joints"].sel(joint="knee"))
        assert row["within_limits"] == ""


def test_a_table_of_what_each_point_has(capsys, tmp_path):
    table = tmp_path / "reach.csv"
    options = [
        "--quantity",
        "reach",
        "-o",
        tmp_path / "s",
        "--workers",
        "0",
        "--csv",
        table,
        "--json",
    ]
    code, out, _ = command(capsys, "four_bar", "--given", "follower=-80:40:3", *options)
    assert (code, out[0]) == (0, "{")
    assert [row["reached"] for row in csv.DictReader(table.read_text().splitlines())] == [
        "0",
        "1",
        "1",
    ]


@pytest.mark.parametrize(
    ("name", "given", "of", "axes"),
    [
        pytest.param(
            "jansen_leg",
            {"crank": np.linspace(0, 360, 121)},
            ["foot"],
            ("x [mm]", "y [mm]"),
            marks=pytest.mark.long,
        ),
        ("ankle", {"ankle.1": np.linspace(-9, 9, 5), "ankle.2": 2.0}, ["toe", "heel"], None),
        pytest.param(
            "ankle",
            {"ankle.1": np.linspace(-9, 9, 5), "ankle.2": np.linspace(0, 9, 3)},
            ["upper_motor"],
            ("ankle.1 [deg]", "upper_motor [deg]"),
            marks=pytest.mark.long,
        ),
        (
            "four_bar",
            {"follower": np.linspace(-80, 80, 9)},
            "crank",
            ("follower [deg]", "crank [deg]"),
        ),
        ("four_bar", {"follower": [-85.0, -80.0]}, "crank", ("follower [deg]", "crank [deg]")),
    ],
)
def test_pictures_of_points_and_joints(tmp_path, name, given, of, axes):
    """Every mode is drawn, and the assembly that the file describes as a line."""
    swept = sweep(symkin.load(name), directory=tmp_path / "s", given=given, workers=0)
    figure = swept.plot(tmp_path / "picture.png", of=of)
    ax = figure.axes[0]
    assert axes is None or (ax.get_xlabel(), ax.get_ylabel()) == axes
    assert (tmp_path / "picture.png").stat().st_size > 5000
    if name == "jansen_leg":
        foot = ax.lines[0].get_xydata()
        assert np.isfinite(foot).all()
        assert np.allclose(foot[0], foot[-1])
        at_reference = np.linalg.norm(foot - symkin.load(name).link_points[0].point[:2], axis=1)
        assert at_reference.min() < 1e-6
        dots = sum(len(part.get_offsets()) for part in ax.collections)
        assert dots == sum(count * points for count, points in swept.points_by_count.items())


def test_a_map_says_what_is_held(tmp_path):
    """The default picture of two ranges: counts over them, the title with what is given, the held
    value below it.
    """
    given = {"boom": [0.0, 10.0], "stick": [-20.0, 0.0], "bucket": 20.0}
    figure = sweep(
        symkin.load("excavator_bucket"), directory=tmp_path / "s", given=given, workers=0
    ).plot()
    assert "given boom, stick, bucket" in figure.get_suptitle()
    assert figure.axes[0].get_title() == "at bucket = 20 deg"


def test_a_folder_of_another_form_is_kept(tmp_path):
    """The path of a sweep's table is written whole or not at all; a sweep's folder is never a
    table.
    """
    swept = sweep(
        symkin.load("four_bar"), directory=tmp_path / "s", given={"crank": [0.0, 9.0]}, workers=0
    )
    with pytest.raises(InputError, match="cannot be written"):
        swept.write_csv(Path(tmp_path / "s"))
