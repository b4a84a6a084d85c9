"""Singularity loci and graphs of modes over coordinates that are told by name: closed forms of the
ankle and the four-bar.
"""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.command_line import run, run_json
from helpers.graph_twin import graph_twin
from helpers.inside import displaced
from symkin import InputError

MOTORS = (
    ((0.0, 40.0, 250.0), (-45.0, 40.0, 255.0), (-50.0, 35.0, 20.0)),
    ((0.0, -40.0, 180.0), (-45.0, -40.0, 185.0), (-50.0, -35.0, 20.0)),
)
"""Each motor's axis point (along y), its crank's end and the rod's end on the foot, at the
reference (see the file).
"""


def reaches(pitch: float, roll: float) -> list[float]:
    """For each motor and sign, what is left of (rho +- r)^2 + dy^2 = L^2, over the squared rod:
    zero where crank and rod are in one plane through the motor's axis, rho the distance of the
    rod's end on the foot from that axis.
    """
    (c, s), (cr, sr) = (
        (math.cos(math.radians(a)), math.sin(math.radians(a))) for a in (pitch, roll)
    )
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ np.array(
        [[1, 0, 0], [0, cr, -sr], [0, sr, cr]]
    )
    left = []
    for axis, crank, foot in (tuple(map(np.array, motor)) for motor in MOTORS):
        end, radius = turn @ foot, math.hypot(*(crank - axis)[[0, 2]])
        rho, aside = math.hypot(*(end - axis)[[0, 2]]), (end - axis)[1]
        rod = float(np.linalg.norm(crank - foot))
        left += [((rho + sign * radius) ** 2 + aside**2) / rod**2 - 1.0 for sign in (1.0, -1.0)]
    return left


def test_loci_of_the_ankles_posture_are_the_motors_dead_points() -> None:
    """Every point of every curve over pitch and roll has one motor's crank and rod in line."""
    mechanism = symkin.load("ankle")
    here = symkin.solve(mechanism, given={"ankle.1": 3.0, "ankle.2": 2.0}).solution
    assert here is not None
    loci = symkin.singular_loci(
        here,
        ("ankle.1", "ankle.2"),
        given=["ankle.1", "ankle.2"],
        ranges=[(-90.0, 90.0), (-90.0, 90.0)],
        starts=20,
    )
    assert len(loci.curves) >= 3
    for curve in loci.curves:
        assert curve.kind == "type 2"
        left = [min(map(abs, reaches(*point))) for point in curve.points[::10]]
        assert max(left) < 1e-9
    assert loci.given(loci.curves[0].points[0])["given"].keys() == {"ankle.1", "ankle.2"}
    assert "nothing else is held" in str(loci)


def test_modes_change_by_two_across_a_locus() -> None:
    """Over the motors, at regular points of the longest curve of type 2: two more modes on one
    side of it than on the other.
    """
    mechanism = symkin.load("ankle")
    here = symkin.solve(mechanism).solution
    assert here is not None
    loci = symkin.singular_loci(
        here, ("upper_motor", "lower_motor"), ranges=[(-180.0, 180.0), (-180.0, 180.0)], starts=10
    )
    curve = max(loci.of("type 2"), key=lambda c: len(c.points))
    for k in (len(curve.points) // 5, 3 * len(curve.points) // 5):  # no cusps
        tangent = curve.points[k + 1] - curve.points[k - 1]
        normal = np.array([-tangent[1], tangent[0]]) / np.linalg.norm(tangent)
        counts = [
            len(symkin.modes(mechanism, **loci.given(curve.points[k] + side * 0.02 * normal)))
            for side in (-1, 1)
        ]
        assert abs(counts[0] - counts[1]) == 2


def test_loci_of_limbs_by_coordinates_of_the_pose() -> None:
    """A five-bar by its tip's coordinates: an arm of 60 and 80 is stretched or folded, 140 or 20
    from a pivot 100 apart.
    """
    mechanism = samples.five_bar()
    here = symkin.solve(mechanism, given={"x": 50.0, "y": 110.0}).solution
    assert here is not None
    with pytest.raises(InputError, match="type 1"):
        symkin.singular_loci(here, ("x", "y"), given=["x", "y"], kinds=("type 1",))
    loci = symkin.singular_loci(
        here, ("x", "y"), given=["x", "y"], ranges=[(-50.0, 150.0), (-150.0, 150.0)], starts=6
    )
    assert loci.curves
    for curve in loci.curves:
        far = [
            [
                abs(math.hypot(x - pivot, y) - reach)
                for pivot in (0.0, 100.0)
                for reach in (20.0, 140.0)
            ]
            for x, y in curve.points
        ]
        assert np.min(far, axis=1).max() < 1e-6


def test_all_dead_points_of_a_four_bar_over_its_follower() -> None:
    """Crank 40 and coupler 101 in line, the rocker 61 above or below the base 110: four angles by
    the cosine theorem.
    """
    here = symkin.solve(symkin.load("four_bar")).solution
    assert here is not None
    inner = [math.acos((110.0**2 + 61.0**2 - far**2) / (2 * 110.0 * 61.0)) for far in (141.0, 61.0)]
    angles = [
        sign * (math.pi - angle) - math.atan2(60.0, -11.0)
        for angle in inner
        for sign in (1.0, -1.0)
    ]
    expected = sorted(math.degrees(math.remainder(angle, 2 * math.pi)) for angle in angles)
    loci = symkin.singular_loci(
        here, ["follower"], given=["follower"], ranges=[(-180.0, 180.0)], starts=60
    )
    assert [float(point.points[0, 0]) for point in loci.curves] == pytest.approx(expected, abs=1e-6)
    assert "type 2 at -27.99869" in str(loci)


def test_modes_change_at_singular_points_only() -> None:
    """Between neighbouring singular points of the Stephenson six-bar over its crank the count of
    modes is one, at each it changes.
    """
    mechanism = symkin.load("stephenson_six_bar")
    here = symkin.solve(mechanism).solution
    assert here is not None
    loci = symkin.singular_loci(here, ["crank"], ranges=[(-180.0, 180.0)])
    ends = [-180.0, *(float(point.points[0, 0]) for point in loci.curves), 180.0]
    counts = [
        [len(symkin.modes(mechanism, given={"crank": a + share * (b - a)})) for share in (0.1, 0.9)]
        for a, b in pairwise(ends)
    ]
    assert all(len(set(count)) == 1 for count in counts)
    assert all(abs(a[0] - b[0]) >= 1 for a, b in pairwise(counts))
    assert counts[0][0] == counts[-1][0]


def test_the_command_lists_and_draws_points(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    options = [
        "--given",
        "piston=75",
        "--plane",
        "piston",
        "--range",
        "-200:200",
        "--starts",
        "60",
        "--plot",
        str(tmp_path / "p.png"),
    ]
    status, found = run_json(capsys, "singularities", "slider_crank", *options)
    assert (status, found["plane"], found["ranges"]) == (0, ["piston"], [[-200.0, 200.0]])
    assert [curve["points"][0][0] for curve in found["curves"]] == pytest.approx(
        [-125.0, -45.0, 45.0, 125.0]
    )
    assert (tmp_path / "p.png").stat().st_size > 1000


def test_the_command_draws_loci_of_given_coordinates(
    tmp_path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = [
        "--plane",
        "ankle.1,ankle.2",
        "--range",
        "-60:60,-60:60",
        "--starts",
        "5",
        "--plot",
        str(tmp_path / "l.png"),
    ]
    status, found = run_json(
        capsys, "singularities", "ankle", "--given", "ankle.1=0,ankle.2=0", *options
    )
    assert (status, found["plane"]) == (0, ["ankle.1", "ankle.2"])
    assert found["curves"]
    assert (tmp_path / "l.png").stat().st_size > 1000


def test_modes_of_a_crank_rocker_never_meet_over_the_crank() -> None:
    """Two sheets over the whole turn, one axis; each mode is followed to the end, with proofs."""
    graph = symkin.mode_graph(symkin.load("four_bar"), [("crank", 0.0, 350.0)], 6)
    assert [len(found) for found in graph.found] == [2] * 7
    assert (len(graph.sheets), graph.groups, graph.certified, graph.stopped) == (
        2,
        [[0], [1]],
        True,
        0,
    )


def test_the_command_tells_the_same_graph(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command's JSON is that of the verb, and its picture a file; a range that is none is one
    sentence.
    """
    picture = tmp_path / "sheets.png"
    words = ["mode-graph", "four_bar", "--over", "crank=0:350", "--points", "4"]
    status, out, _ = run(capsys, *words, "--json", "--plot", picture)
    graph = symkin.mode_graph(symkin.load("four_bar"), [("crank", 0.0, 350.0)], 4)
    assert (status, json.loads(out)) == (0, graph.to_dict())
    assert picture.stat().st_size > 1000
    status, _, err = run(capsys, "mode-graph", "four_bar", "--over", "crank=0")
    assert (status, err.count("\n")) == (2, 1)
    assert "--over: 'crank=0' is no range; NAME=LOW:HIGH,..., such as" in err


def test_modes_over_the_follower_end_at_the_cranks_dead_point(tmp_path) -> None:
    """No mode beyond 54 degrees, where crank and coupler are folded: the rocker 61, 101 - 40 and
    the base 110 make a triangle with equal sides. The two modes before it stop there.
    """
    reach = math.degrees(math.pi - math.acos(55.0 / 61.0) - math.atan2(60.0, -11.0))
    ends = ("follower", reach - 14.0, reach + 6.0)
    graph = symkin.mode_graph(symkin.load("four_bar"), [ends], 3, given={"follower": reach - 12.0})
    assert [len(found) for found in graph.found] == [2, 2, 0, 2]
    assert (graph.groups, graph.stopped, graph.names) == ([[0], [1]], 2, ("follower",))
    assert graph.to_dict()["given"] == {"follower": reach - 12.0}
    graph.plot(tmp_path / "g.png")
    assert (tmp_path / "g.png").stat().st_size > 1000


def test_elbows_of_the_ankle_stay_apart_over_pitch_and_roll() -> None:
    """Four ways of two cranks; without a dead point none becomes another."""
    graph = symkin.mode_graph(
        symkin.load("ankle"),
        [("ankle.1", -10.0, 20.0), ("ankle.2", -10.0, 10.0)],
        2,
        given={"ankle.1": 1.0, "ankle.2": 2.0},
    )
    assert graph.groups == [[0], [1], [2], [3]]
    assert graph.certified
    assert len(graph.edges) == 4 * 5


@pytest.mark.parametrize(
    ("axes", "given", "part"),
    [
        ([("crank", 0.0, 10.0)], {"follower": 0.0}, "allowed: follower"),
        ([("folower", 0.0, 10.0)], {"folower": 0.0}, "do you mean 'follower'?"),
        ([("crank", 0.0, 10.0)], {"crank": 0.0, "follower": 3.0}, "leave"),
    ],
)
def test_axes_that_do_not_fit_are_refused(
    axes: list[tuple[str, float, float]], given: dict[str, float], part: str
) -> None:
    with pytest.raises(InputError, match=part):
        symkin.mode_graph(symkin.load("four_bar"), axes, 2, given=given)


@pytest.mark.parametrize("written", [lambda machine: machine, graph_twin], ids=["limbs", "graph"])
def test_poses_of_a_tilted_plane_are_refused_with_its_axis_in_every_spelling(written):
    """A planar platform that stands on its edge: x and y leave its plane, whose axis is told."""
    on_edge = symkin.Pose(np.zeros(3), np.array([1.0, 1.0, 0.0, 0.0]) / math.sqrt(2.0))
    machine = written(displaced(samples.three_rrr(), on_edge))
    here = symkin.solve(machine).solution
    with pytest.raises(InputError, match=r"x, y' *: .*planar motion about \(0, -1, 0\)") as refused:
        symkin.singular_loci(here, ("x", "y"), starts=1)
    assert "q1, q2, q3" in str(refused.value)
