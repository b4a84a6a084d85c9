"""The study of yao2020 as a reader runs it: rows against paper and computation, errata named, rows
quote what was run.

Published figures: Yao Haifeng et al. 2020, sections 3.1 to 3.3. The computed figures were found
independently, before the study was written; closed forms of reach, distances and angles are written
out here once more.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import symkin
from helpers.study_outcome import Outcome, assert_complete

pytestmark = [pytest.mark.slow, pytest.mark.long]

SOLUTIONS = (
    (-35.5964, 2.7296, 22.5391, 7.7660, 62.2486, -51.5743),
    (144.4036, 177.2704, -157.4609, 7.7660, 62.2486, -51.5743),
    (-89.7350, 16.6451, 4.5028, 7.7660, 117.7514, -407.5519),
    (90.2650, 163.3549, -175.4972, 7.7660, 117.7514, -407.5519),
)
"""Computed by two independent means; the paper prints the first, to 0.02."""
PICTURES = ("frames", "planes", "returns", "guesses", "holes")


@pytest.fixture(scope="module")
def yao(tmp_path_factory) -> Outcome:
    return Outcome("yao2020", tmp_path_factory.mktemp("yao2020"), "--points", "3")


def test_errata_and_pictures(yao):
    parts = [
        "axes 5 and 6 meet in D",
        "E lies on axis 3 only where theta4 = 0",
        "tells only sin(theta5)",
        "falls and then rises only where",
        "no bracket",
        "33 steps to 1e-8, not 7",
        "equation (11)",
        "1e-8 was not met",
        "there is no (15)",
        "no iterative search",
    ]
    assert_complete(yao, parts)
    for name in PICTURES:
        assert (yao.folder / f"yao2020_{name}.png").read_bytes()[:4] == b"\x89PNG"


def test_forward_example_and_lengths(yao):
    """Section 3.1 by equation (3) and by symkin; the lengths behind the printed points D0, E0,
    F0.
    """
    for name in ("forward, A", "A by symkin"):
        assert yao.number(name) == pytest.approx([-513.6785, -105.8242, -77.5586], abs=1e-4)
    A, B, C = (yao.number(f"forward, {name}") for name in "ABC")
    assert [math.dist(A, B), math.dist(A, C), (B - A) @ (C - A)] == pytest.approx(
        [50, 50, 0], abs=1e-9
    )
    assert yao.number("a3, d1, a2") == pytest.approx([160, 105, 85], abs=3e-5)
    assert yao.number("a1 from") == pytest.approx(300.003, abs=1e-3)


def test_motions_of_a_point(yao):
    """(1) and (2) on a line along z: moved up by 4, and turned by a quarter."""
    assert yao.number("(1): (1, 2, 3) moved by 4").tolist() == [1, 2, 7]
    assert yao.number("(2): (1, 2, 3) turned by 90 deg") == pytest.approx([-1, 0, 3], abs=1e-12)


def test_printed_points_are_reproduced(yao):
    """D0, E0, F0 of section 3.2, each coordinate to its last digit."""
    printed = {
        "D0": (-367.3381, 155.1228, 110.8512),
        "E0": (-359.3707, 198.4627, 15.5455),
        "F0": (-284.9595, 233.1612, 37.5452),
    }
    for name, point in printed.items():
        (row,) = yao.rows(name)
        assert row["paper"] == list(point)
        assert row["computed"] == pytest.approx(point, abs=1e-4)
        assert row["verdict"] == "reproduced"


def test_solutions(yao):
    """All four solutions of the worked example; the printed one is the first, to its own error.
    Every route finds four.
    """
    for k, expected in enumerate(SOLUTIONS, start=1):
        assert yao.number(f"inverse, solution {k}") == pytest.approx(expected, abs=6e-5)
    first = yao.rows("inverse, solution 1")[0]
    assert first["paper"] == [-35.5954, 2.7289, 22.5392, 7.7657, 62.2462, -51.556]
    assert np.abs(first["difference"]).max() < 0.02
    assert yao.number("solutions by return of the axes, by continuation").tolist() == [4, 4]
    assert yao.rows("continuation: the same")[0]["computed"] == "True"
    assert yao.number("symkin.solve from the printed answer") == pytest.approx(
        SOLUTIONS[0], abs=6e-5
    )


def test_return_of_the_axes(yao):
    """Section 2.2.2: one axis after another; F ends on axis 3 at -a1."""
    for k in range(1, 5):
        assert yao.number(f"theta{k} = ") == pytest.approx(SOLUTIONS[0][k - 1], abs=6e-5)
    assert yao.number("joints 6, 5, 1, 2 at zero: F") == pytest.approx([-300, 0, 0], abs=1e-8)
    printed = yao.number("(11) as printed")
    assert printed == pytest.approx([90 + 22.5391, -22.5391], abs=1e-4)
    assert yao.number("over 200 poses: wrong by arctan2(-D4y, D4z)")[1] == 0


def test_search(yao):
    """What the loop with the midpoint does on [-500, 0], and what the printed answer leaves."""
    assert yao.number("f at -500, -250, 0") == pytest.approx([50.4, -42.9, 26.3], abs=0.06)
    assert yao.number("loop with the midpoint, f_min f_mid")[0] == pytest.approx(
        -407.5519, abs=1e-4
    )
    assert yao.number("loop with the midpoint, f_mid f_max") == pytest.approx(
        [-51.5743, 33], abs=1e-4
    )
    assert yao.number("|OF| - a1 at the printed L6") == pytest.approx(8.4e-3, abs=1e-4)
    assert yao.number("A missed by the printed answer") == pytest.approx(0.0114, abs=1e-4)
    assert yao.number("L6 moved by") == pytest.approx([1.6e-4, 7.3e-3], abs=1e-4)
    assert yao.number("L6 = e_x -+ sqrt") == pytest.approx([-407.5519, -51.5743], abs=1e-4)


def test_iterations_over_poses(yao):
    """Law: a midpoint halves 500 mm, so that its last interval is 500 / 2^steps; every way ends at
    the L6 that was drawn.
    """
    for name in ("loop with the full angle", "chord", "rootfinder", "closed form"):
        right, other, none = yao.number(f"over poses, {name}: ends")
        assert right == 100
        assert other == none == 0
    least, median, most = yao.number("over poses, printed loop: steps")
    assert least <= median <= most
    assert 30 <= median <= 36
    assert yao.number("over poses, chord: steps")[2] <= 10
    times = [row for row in yao.content["rows"] if "time a pose" in row["quantity"]]
    assert len(times) == 5
    assert all(row["volatile"] and row["computed"] > 0 for row in times)


def test_hits_and_misses(yao):
    """Every guess hits a mode or fails; multistart and continuation agree on the example, and few
    starts miss solutions.
    """
    for what, modes in (
        ("inverse, (5)-(8) in L6, theta5 (two solutions each)", 2),
        ("inverse, (3) in six joints", 4),
    ):
        for solver in ("rootfinder", "IPOPT"):
            hits, failures = (
                yao.number(f"{what}, {solver}: hits"),
                yao.number(f"{what}, {solver}: guesses that led to no"),
            )
            assert len(hits) == modes
            assert hits.min() > 0
            assert hits.sum() + failures == 100
    for solver in ("batched", "newton", "ipopt"):
        assert yao.number(
            f"inverse, symkin.modes by multistart, {solver}: solutions met"
        ).tolist() == [4, 0]
    assert yao.number("random poses, of 25: continuation") == 25
    few, many = (
        yao.number(f"random poses, of 25: multistart, {starts} starts") for starts in (20, 200)
    )
    assert few[0] < 25
    assert few[1] > 0
    assert many.tolist() == [25, 0]


def test_path_of_holes(yao):
    """Section 3.3: all holes on one mode; the slide alone drills; the reach ends where the closed
    form says.
    """
    assert yao.number("holes of our pattern") == 86
    path = yao.rows("path of all holes")[0]
    assert path["computed"].startswith("258, reached the end")
    assert path["run"][0]["text"] == "track: 258 poses, certified"
    moved, least, most = yao.number("into a hole")
    assert [moved, least, most] == pytest.approx([0, -80, -80], abs=1e-9)
    assert yao.number("L6 stays inside") > 0
    for z in (105, 255):
        inside, outside = yao.number(f"reach at z = {z}: solutions")
        assert inside > 0 == outside
        assert abs(yao.number(f"reach at z = {z}: y where")) < 1e-9


def test_joint_errors(yao):
    """A degree at joint k moves A by its distance from axis k, largest at the holes furthest from
    it: axis 1 is the z axis.
    """
    y, x = 60.0 * 4.5, 570.0 + 60.0
    assert yao.number("A moves for 1 deg")[0] == pytest.approx(
        math.radians(1) * math.hypot(x, y), abs=1e-6
    )


def test_reach_is_where_solutions_are():
    """Law: a pose has solutions with F between axis 5 and O exactly where the margin of the reach
    is not negative. Oracle: continuation on random poses around the edge, F beyond axis 5 being
    rare there.
    """
    from studies.yao2020.holes import reach_margin
    from studies.yao2020.model import symkin_pose, turn

    arm, rng, seen = symkin.load("yao2020"), np.random.default_rng(1), set()
    for _ in range(12):
        R = (
            turn("z", rng.uniform(-90, 90))
            @ turn("y", rng.uniform(-90, 90))
            @ turn("x", rng.uniform(-90, 90))
        )
        z, off = rng.uniform(-250, 250), rng.uniform(1, 30) * rng.choice([-1, 1])
        e = np.array([rng.uniform(-500, -200), 85 + math.sqrt(300**2 - z**2) - off, z])
        A = R @ (e - (160, 0, -105))
        assert reach_margin(A, R) == pytest.approx(off)
        assert (len(symkin.modes(arm, pose=symkin_pose(A, R))) > 0) == (off > 0)
        seen.add(off > 0)
    assert seen == {True, False}


def test_arms_of_figure_1_have_spherical_wrists():
    """Law: with a spherical wrist, joints 4 to 6 leave the wrist's centre where it is."""
    from studies.yao2020.model import drawn_axes, posed_axes, spherical_wrists

    for arm in spherical_wrists().values():
        lines, types = drawn_axes(arm), [joint.type for joint in arm.limbs[0].joints]
        centre, rng = lines[4][0], np.random.default_rng(2)
        for _ in range(5):
            joints = [0, 0, 0, *rng.uniform(-180, 180, 3)]
            for point, direction in posed_axes(lines, joints, types)[3:]:
                assert np.linalg.norm(np.cross(centre - point, direction)) < 1e-12
