"""Loci over the map of a sweep: where neighbouring cells have other counts of modes a curve passes
between them; another plane is refused.
"""

from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.gate import in_gate
from helpers.inside import figure_of_sweep
from helpers.samples import five_bar
from symkin import InputError

HERE = [81.6, 202.8, 330.6, 105.2]
CASES = {
    "zhao2000": {
        "grid": {"theta1": np.linspace(40.0, 130.0, 19), "op": np.linspace(10.0, 170.0, 17)}
    },
    "ankle": {
        "given": {
            "upper_motor": np.linspace(-60.0, 60.0, 13),
            "lower_motor": np.linspace(-60.0, 60.0, 13),
        }
    },
}


@cache
def swept(name):
    return symkin.sweep(
        symkin.load(name), directory=Path(mkdtemp()) / "s", workers=0, **CASES[name]
    )


def curves_of(figure):
    return [
        line.get_xydata()
        for line in figure.axes[0].get_lines()
        if str(line.get_gid()).startswith("locus")
    ]


@pytest.mark.parametrize("name", in_gate(CASES, ["ankle"]))
def test_counts_change_across_curves_only(name):
    """Law: along each row of the grid, a curve crosses between two cells of different counts."""
    figure = figure_of_sweep(swept(name), loci=True)
    curves = curves_of(figure)
    assert curves
    data = swept(name).open()
    count = data["count"].values
    u, v = (data[dim].values for dim in data["count"].dims)
    changes = np.argwhere(np.diff(count, axis=0) != 0)
    assert len(changes) > 5
    for i, j in changes:
        crossed = False
        for points in curves:
            for (u0, v0), (u1, v1) in pairwise(points):
                if (v0 - v[j]) * (v1 - v[j]) <= 0.0 and v0 != v1:
                    at = u0 + (v[j] - v0) / (v1 - v0) * (u1 - u0)
                    crossed |= u[i] - 1e-3 * np.ptp(u) <= at <= u[i + 1] + 1e-3 * np.ptp(u)
        assert crossed, (u[i], v[j])


def test_given_loci_are_those_of_the_maps_plane():
    """Drawn on the map's axes in either order of its coordinates; of another plane they are
    refused.
    """
    here = symkin.solve(symkin.load("ankle")).solution
    for names in (("upper_motor", "lower_motor"), ("lower_motor", "upper_motor")):
        loci = symkin.singular_loci(here, names, ranges=[(-60.0, 60.0)] * 2, starts=12)
        drawn = np.vstack(curves_of(figure_of_sweep(swept("ankle"), loci=loci)))
        places = [names.index(name) for name in ("upper_motor", "lower_motor")]
        traced = np.vstack([curve.points for curve in loci.curves])[:, places]
        assert np.max(np.min(np.abs(drawn[:, None] - traced).sum(axis=2), axis=1)) < 1e-9
    names = ("ankle.1", "ankle.2")
    other = symkin.singular_loci(here, names, given=names, starts=2)
    with pytest.raises(InputError, match=r"over ankle\.1, ankle\.2 and the map over upper_motor"):
        swept("ankle").plot(loci=other)


@pytest.mark.long
def test_given_loci_are_drawn_in_either_order_of_their_plane():
    platform = symkin.load("zhao2000")
    here = symkin.solve(platform, joints=HERE).solution
    ranges = {"theta1": (40.0, 130.0), "op": (10.0, 170.0)}
    found = {}
    for names in (("theta1", "op"), ("op", "theta1")):
        loci = symkin.singular_loci(
            here, names, ranges=[ranges[n] for n in names], kinds=("type 2",), starts=60
        )
        figure = figure_of_sweep(swept("zhao2000"), loci=loci)
        points = np.vstack(curves_of(figure))
        for column, (low, high) in zip(points.T, ranges.values(), strict=True):
            # curves are traced to their first point beyond the window
            assert (
                low - 0.05 * (high - low) < column.min() < column.max() < high + 0.05 * (high - low)
            )
        found[names] = len(curves_of(figure))
        assert [text.get_text() for text in figure.legends[0].get_texts()] == ["singular, type 2"]
    assert len(set(found.values())) == 1


@pytest.mark.long
def test_loci_of_another_plane_are_refused():
    platform = symkin.load("zhao2000")
    here = symkin.solve(platform, joints=HERE).solution
    moved = symkin.solve(platform, joints=[*HERE[:2], 320.0, HERE[3]]).solution
    other = symkin.solve(symkin.load("ankle"), joints=[0.0, 0.0]).solution
    window = [(40.0, 130.0), (10.0, 170.0)]
    for loci, sentence in (
        (
            symkin.singular_loci(here, ("theta1", "theta2"), starts=2),
            "the loci are over theta1, theta2 and the map over theta1, op",
        ),
        (
            symkin.singular_loci(moved, ("theta1", "op"), ranges=window, starts=2),
            "other values than the map",
        ),
        (
            symkin.singular_loci(other, ("upper_motor", "lower_motor"), starts=2),
            "the loci are of ankle and the map of zhao2000",
        ),
    ):
        with pytest.raises(InputError, match="plot: ") as caught:
            swept("zhao2000").plot(loci=loci)
        assert sentence in str(caught.value)
    with pytest.raises(InputError, match="give one of them"):
        swept("ankle").plot(loci=True, of="toe")


def test_over_one_value_loci_are_lines(tmp_path):
    """The dead centres of a four-bar linkage, where its follower drives."""
    found = symkin.sweep(
        symkin.load("four_bar"),
        given={"follower": np.linspace(0.0, 180.0, 19)},
        directory=tmp_path / "s",
        workers=0,
    )
    places = sorted(float(points[0, 0]) for points in curves_of(figure_of_sweep(found, loci=True)))
    data = found.open()
    count, follower = data["count"].values, data["follower"].values
    changes = np.flatnonzero(np.diff(count))
    assert len(places) == len(changes) == 2
    assert all(
        follower[k] <= place <= follower[k + 1] for k, place in zip(changes, places, strict=True)
    )


def test_loci_over_poses_of_a_graph_are_refused_before_the_sweep(tmp_path, capsys):
    words = [
        "sweep",
        "delta_parallelograms",
        "--poses",
        "--grid",
        "x=-10:10:3,y=-10:10:3",
        "-o",
        tmp_path / "s",
    ]
    status, _, err = run(capsys, *words, "--plot", tmp_path / "a.png", "--loci")
    assert status == 2
    assert "pose coordinates in general cannot vary alone" in err
    assert not (tmp_path / "s").exists()


@pytest.mark.long
def test_points_of_the_loci_are_named(tmp_path):
    """A five-bar with equal rods turns as one where both cranks' ends meet (two points of the plane
    of its cranks).
    """
    mechanism = five_bar()
    axes = {"q1": np.linspace(-180.0, 180.0, 7), "q2": np.linspace(-180.0, 180.0, 7)}
    figure = figure_of_sweep(symkin.sweep(mechanism, axes, tmp_path / "s", workers=0), loci=True)
    named = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert "singular, type 2, self-motion" in named


def test_the_command_lays_them_over(tmp_path, capsys):
    words = [
        "sweep",
        "ankle",
        "--given",
        "upper_motor=-60:60:9,lower_motor=-60:60:9",
        "-o",
        tmp_path / "s",
        "--workers",
        "0",
    ]
    status, text, _ = run(capsys, *words, "--plot", tmp_path / "a.pdf", "--loci")
    assert status == 0
    assert "a.pdf" in text
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    for more, sentence in (
        (["--loci"], "--loci is given without --plot; it says what the picture shows"),
        (["--loci", "--plot", "a.png", "--of", "toe"], "both --loci and --of"),
    ):
        status, _, err = run(capsys, *words, *more)
        assert status == 2
        assert sentence in err
