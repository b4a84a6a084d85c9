"""`symkin sweep` as its users call it, and the maps that it draws."""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import figure_of_sweep, main
from helpers.samples import Z, three_rrr
from symkin import InputError, Joint, Limb, Mechanism, sweep

xarray = pytest.importorskip("xarray")
PLATFORM = symkin.load("zhang2009")


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main(["sweep", *(str(a) for a in arguments)])
    said = capsys.readouterr()
    return ended.value.code, said.out, said.err


def two_links():
    """A planar arm of links 2 and 1 whose tool reaches 1 < r < 3."""
    joints = [
        Joint("a", "R", (0, 0, 0), Z, actuated=True),
        Joint("b", "R", (2, 0, 0), Z, actuated=True),
    ]
    limb = Limb("limb", [*joints, Joint("c", "R", (3, 0, 0), Z)])
    return Mechanism(
        "two_links", [limb], platform_position=(3, 0, 0), motion="planar", length_unit="m"
    )


def test_command_writes_arrays_and_a_map(capsys, tmp_path):
    """Status 0, the counts on stdout, arrays in the folder, a picture; again, with nothing left to
    do.
    """
    grid, folder, picture = "leg1=120:150:3,leg2=340:350:2", tmp_path / "s", tmp_path / "map.png"
    code, out, err = run(
        capsys, "zhang2009", "--grid", grid, "-o", folder, "--workers", "0", "--plot", picture
    )
    assert (code, err) == (0, "")
    assert "6 points" in out
    assert xarray.open_zarr(folder)["count"].shape == (3, 2)
    assert picture.read_bytes().startswith(b"\x89PNG")
    code, out, _ = run(capsys, "zhang2009", "--grid", grid, "-o", folder, "--workers", "0")
    assert code == 0
    assert "kept from before" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--grid", "leg7=1:2:3"], "has no 'leg7' to sweep"),
        (["--grid", "leg1=2:1:3"], "reversed"),
        (["--grid", "x=1:2:3"], "--poses"),
        (["--grid", "leg1=1:2:3", "--at", "1,2"], "at: 2 values"),
        (["--grid", "leg1=1:2:3", "--quantity", "speed"], "speed"),
        (["--grid", "leg1=1:2:x"], "whole number"),
        (["--grid", "leg1=1:2", "--random", "many"], "'many' is not a whole number"),
        (["--grid", "leg1=1:2:3", "--slice", "leg2=1", "--plot", "a.png"], "'leg2' is not swept"),
        (["--grid", "leg1=1:2:3", "--slice", "leg1", "--plot", "a.png"], "NAME=VALUE"),
        (["--grid", "leg1=1:2:3", "--plot", "a.xyz"], "picture format"),
        (["--grid", "leg1=1:2:3", "--slice", "leg1=7", "--plot", "a.png"], "outside"),
        (["--grid", "x=1:2:3", "--poses", "--at", "1,2"], "at: 2 values"),
        (["--grid", "gamma=1:2:3", "--poses"], "no 'gamma' to sweep"),
        (["--grid", "x=1:2:3", "--at", "0,0,0,1,0,0,z", "--poses"], "'z'"),
        (
            ["--grid", "leg1=1:2", "--random", "3", "--slice", "leg1=1", "--plot", "a.png"],
            "no slices",
        ),
        ([], "grid"),
    ],
)
def test_wrong_input_is_one_line(capsys, tmp_path, monkeypatch, arguments, said):
    """Status 2, one line that names the mistake, and no folder."""
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, "zhang2009", *arguments, "-o", "s", "--workers", "0")
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "s").exists()


@pytest.mark.slow
def test_reach_of_an_arm_is_a_ring(tmp_path):
    """An arm of links 2 and 1 reaches 1 <= r <= 3, with two working modes inside."""
    values = np.linspace(-3.1, 3.1, 9)
    swept = sweep(
        two_links(),
        {"x": values, "y": values},
        tmp_path / "s",
        poses=True,
        at=[1, 1, 0, 1, 0, 0, 0],
        quantity="reach",
        workers=0,
    )
    data = swept.open().load()
    r = np.hypot(*np.meshgrid(values, values, indexing="ij"))
    assert np.array_equal(data.reached.values == 1, (r > 1) & (r < 3))
    assert set(data["count"].values[(r > 1) & (r < 3)]) == {2}


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["modes", "conditioning", "reach"])
def test_maps_show_the_arrays(tmp_path, quantity):
    """The cells of a map are the array, cut at the middle of a third axis or where the slice says;
    one axis is a curve.
    """
    grid = {"leg1": [120.0, 130.0, 140.0], "leg2": [340.0, 345.0], "leg3": [100.0, 105.0, 110.0]}
    data = sweep(PLATFORM, grid, tmp_path / "s", quantity=quantity, workers=0).open().load()
    name = {"modes": "count", "conditioning": "least_condition", "reach": "count_within_limits"}[
        quantity
    ]
    cuts = (
        ({}, {"leg3": 1}),
        ({"leg3": 109.0}, {"leg3": 2}),
        ({"leg1": 121.0}, {"leg1": 0}),
    )
    for slices, place in cuts if quantity == "modes" else cuts[1:2]:
        cells = figure_of_sweep(tmp_path / "s", slices).axes[0].collections[0].get_array()
        assert np.array_equal(np.asarray(cells), data[name].isel(place).values.T)
    line = figure_of_sweep(tmp_path / "s", {"leg3": 100.0, "leg2": 340.0}).axes[0].lines[0]
    assert np.array_equal(line.get_ydata(), data[name].values[:, 0, 0].astype(float))


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["modes", "conditioning", "reach"])
def test_random_points_without_a_mode_are_marked(tmp_path, quantity):
    """Each random point outside of the ring that the arm reaches, and no other, has a mark of its
    own, in maps and curves.
    """
    bounds = {"x": (0.5, 4), "y": (-0.5, 0.5)}
    swept = (
        sweep(
            two_links(), bounds, tmp_path / "s", poses=True, quantity=quantity, random=60, workers=0
        )
        .open()
        .load()
    )
    outside = np.hypot(swept.x, swept.y).values
    outside = (outside < 1) | (outside > 3)
    assert 0 < outside.sum() < 60
    marks = figure_of_sweep(tmp_path / "s", {}).axes[0].collections[1]
    assert np.array_equal(marks.get_offsets()[:, 0], swept.x.values[outside])
    assert len(marks.get_edgecolor())
    line = sweep(
        two_links(),
        {"x": (0.5, 4)},
        tmp_path / "l",
        poses=True,
        quantity=quantity,
        random=20,
        workers=0,
    )
    outside = (line.open().x.values < 1) | (line.open().x.values > 3)
    ax = figure_of_sweep(tmp_path / "l", {}).axes[0]
    if quantity == "conditioning":
        assert np.array_equal(ax.collections[0].get_offsets()[:, 0], line.open().x.values[outside])
    assert ax.get_xlim()[0] <= line.open().x.min() <= line.open().x.max() <= ax.get_xlim()[1]


@pytest.mark.slow
def test_captions_name_the_angle_about_z(tmp_path):
    """What is held or offset is in the caption: gamma where it does not vary, its offset where rz
    does, nothing where gamma does.
    """
    arm = three_rrr("planar")
    for axis, said in (
        ("x", "gamma = 17.189 deg"),
        ("rz", "gamma = rz + 17.189 deg"),
        ("gamma", ""),
    ):
        folder, at = tmp_path / axis, [0, 0, 0, np.cos(0.15), 0, 0, np.sin(0.15)]
        sweep(
            replace(arm, angle_unit="deg"), {axis: [0.0, 5.0]}, folder, poses=True, at=at, workers=0
        )
        caption = figure_of_sweep(folder, {}).axes[0].get_title()
        assert said in caption if said else "gamma" not in caption


@pytest.mark.slow
def test_maps_of_samples_and_of_nothing(tmp_path):
    """A sample is drawn as points; where no point has a mode there is a picture too; a folder
    without a sweep is refused.
    """
    sweep(PLATFORM, {"leg1": (120, 140), "leg2": (340, 350)}, tmp_path / "s", random=7, workers=0)
    assert len(figure_of_sweep(tmp_path / "s", {}).axes[0].collections[0].get_offsets()) == 7
    for quantity in ("modes", "conditioning"):
        sweep(
            PLATFORM,
            {"leg1": [1000.0, 1001.0], "leg2": [340.0, 341.0]},
            tmp_path / quantity,
            quantity=quantity,
            workers=0,
        )
        figure_of_sweep(tmp_path / quantity)
    with pytest.raises(InputError, match="holds no sweep"):
        figure_of_sweep(tmp_path / "missing")


@pytest.mark.slow
def test_module_runs_with_worker_processes(tmp_path):
    """`python -m symkin sweep` with two local processes prints no traceback, and to a pipe only
    what takes longer than 5 s.
    """
    command = [
        sys.executable,
        "-m",
        "symkin",
        "sweep",
        "zhang2009",
        "--grid",
        "leg1=120:150:4",
        "--workers",
        "2",
        "-o",
        str(tmp_path / "s"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0
    assert re.fullmatch(r"(symkin: [^\n]* \(\d+ s\)\n)*", done.stderr), done.stderr
    assert "4 points" in done.stdout
