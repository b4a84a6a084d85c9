"""Singularity loci against closed forms: every point a true zero, every boundary of the number of
modes on a curve.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.inside import (
    build_problem,
    classify,
    figure_of_loci,
    has_self_motion,
    locus_systems,
    main,
    make_solution,
    plane_of,
)
from helpers.samples import (
    RRR_BASE,
    RRR_LINKS,
    RRR_PLATFORM,
    five_bar,
    four_bar,
    hexapod,
    pieper,
    random_mechanism,
    three_rrr,
    tilted_rps,
)
from symkin import InputError, Loci, singular_loci


def loci_of(mechanism: symkin.Mechanism, plane: tuple[str, str], **options: object) -> Loci:
    joints = [
        mechanism.angle_out(c.reference[0]) if c.is_angular else c.reference[0]
        for c in mechanism.actuated
    ]
    return singular_loci(symkin.solve(mechanism, joints=joints).solution, plane, **options)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def bars() -> Loci:
    return loci_of(five_bar(), ("q1", "q2"), kinds=("type 2",), starts=80)


@pytest.fixture(scope="module")
def rrr_poses() -> Loci:
    return loci_of(three_rrr("planar"), ("x", "y"), ranges=((-60, 60), (-60, 60)), starts=30)


@pytest.fixture(scope="module")
def rrr_inputs() -> Loci:
    return loci_of(three_rrr("planar"), ("q1", "q2"), kinds=("type 2",), starts=60)


def elbows_apart(points: np.ndarray) -> np.ndarray:
    """Distance of the five-bar's elbows (bases 100 apart, cranks 60) for inputs (n, 2) in
    degrees.
    """
    one, two = np.radians(points).T
    return np.hypot(100 + 60 * np.cos(two) - 60 * np.cos(one), 60 * np.sin(two) - 60 * np.sin(one))


@pytest.mark.slow
def test_five_bar_loci_are_its_closed_form(bars: Loci) -> None:
    """Type 2 (a closure that is not square): couplers of 80 in one line, elbows 160 apart; or
    elbows in one place, where the tip turns freely: 120 cos q = 100.
    """
    curves = [c for c in bars.curves if not c.is_point]
    assert curves
    assert max(np.abs(elbows_apart(c.points) - 160).max() for c in curves) < 1e-8
    free = [c.points[0] for c in bars.curves if c.is_point]
    both = math.degrees(math.acos(50 / 60))
    expected = [(both, 180 - both), (-both, 180 + both)]
    assert len(free) == 2
    assert all(c.self_motion for c in bars.curves if c.is_point)
    for place in expected:
        assert (
            min(np.abs(np.remainder(point - place + 180, 360) - 180).max() for point in free) < 1e-6
        )


def test_joints_named_as_coordinates_of_the_pose_are_the_joints(bars: Loci) -> None:
    """A five-bar whose cranks are called x and y has the curves of its twin over its angles."""
    plain = five_bar()
    left, right = plain.limbs
    limbs = [
        replace(limb, joints=(replace(limb.joints[0], name=name), *limb.joints[1:]))
        for limb, name in ((left, "x"), (right, "y"))
    ]
    named = loci_of(replace(plain, limbs=limbs), ("x", "y"), kinds=("type 2",), starts=20)
    assert not named.plane.of_pose
    assert named.ranges == bars.ranges
    assert {curve.kind for curve in named.curves} == {"type 2"}
    point = named.curves[0].points[0]
    assert symkin.singularity(plain, joints=point.tolist()).kinds == ("type 2",)


def test_the_whole_closed_form_is_found(bars: Loci) -> None:
    """Every point at which the elbows are 160 apart has a point of the curves beside it: none is
    missed.
    """
    points = np.vstack([c.points for c in bars.curves])
    grid = np.linspace(-90, 269, 300)
    for one in grid[::10]:
        value = elbows_apart(np.column_stack([np.full_like(grid, one), grid])) - 160
        for k in np.flatnonzero(np.sign(value[:-1]) != np.sign(value[1:])):
            assert np.linalg.norm(points - [one, grid[k]], axis=1).min() < 4.0


@pytest.mark.slow
def test_type_1_of_a_3_rrr_is_four_circles_a_limb(rrr_poses: Loci) -> None:
    """A limb of two links is stretched or folded: its platform joint is 125 or 5 from its base
    joint.
    """
    for k, limb in enumerate(("limb1", "limb2", "limb3")):
        angle = math.pi / 2 + 2 * math.pi * k / 3
        middle = (RRR_BASE - RRR_PLATFORM) * np.array([math.cos(angle), math.sin(angle)])
        curves = [c for c in rrr_poses.of("type 1") if c.limb == limb]
        assert curves
        for curve in curves:
            reach = np.linalg.norm(curve.points - middle, axis=1)
            nearest = np.minimum(
                np.abs(reach - sum(RRR_LINKS)), np.abs(reach - (RRR_LINKS[1] - RRR_LINKS[0]))
            )
            assert nearest.max() < 1e-8


@pytest.mark.slow
def test_type_2_of_a_3_rrr_is_three_lines_through_a_point(rrr_poses: Loci) -> None:
    """The forces along the second links (lines through elbow and platform joint) meet or are
    parallel: their determinant vanishes, by matrices of the test's own.
    """
    assert rrr_poses.of("type 2")
    for curve in rrr_poses.of("type 2"):
        for point, configuration in zip(curve.points, curve.configurations, strict=True):
            assert (
                abs(lines_determinant(point, dict(zip(curve.names, configuration, strict=True))))
                < 1e-9
            )


def lines_determinant(point: np.ndarray, values: dict[str, float]) -> float:
    """Unit lines (direction; moment / 100) along the second links at gamma = 0."""
    rows = []
    for k in range(3):
        angle = math.pi / 2 + 2 * math.pi * k / 3
        radial = np.array([math.cos(angle), math.sin(angle)])
        q = values[f"q{k + 1}"]
        elbow, end = (
            RRR_BASE * radial + RRR_LINKS[0] * np.array([math.cos(q), math.sin(q)]),
            point + RRR_PLATFORM * radial,
        )
        d = (end - elbow) / np.linalg.norm(end - elbow)
        rows.append([*d, (end[0] * d[1] - end[1] * d[0]) / 100])
    return float(np.linalg.det(rows))


def test_points_of_the_working_mode_are_marked(rrr_poses: Loci) -> None:
    """`in_mode` where all elbows are on the side of the configuration's: the sign of the cross
    product of a limb's links.
    """
    reference = [float(rrr_poses.solution.values[f"q{k}"]) for k in (1, 2, 3)]
    for curve in rrr_poses.of("type 2"):
        sides = np.array(
            [
                elbow_sides(p, c[: len(curve.names)], curve.names)
                for p, c in zip(curve.points, curve.configurations, strict=True)
            ]
        )
        own = elbow_sides(np.zeros(2), np.array([*reference]), ("q1", "q2", "q3"))
        expected = np.all(np.sign(sides) == np.sign(own), axis=1)
        clear = np.abs(sides).min(axis=1) > 1e-6
        assert np.array_equal(curve.in_mode[clear], expected[clear])


def elbow_sides(
    point: np.ndarray, configuration: np.ndarray, names: tuple[str, ...]
) -> list[float]:
    values, sides = dict(zip(names, configuration, strict=False)), []
    for k in range(3):
        angle = math.pi / 2 + 2 * math.pi * k / 3
        radial = np.array([math.cos(angle), math.sin(angle)])
        first = RRR_LINKS[0] * np.array(
            [math.cos(values[f"q{k + 1}"]), math.sin(values[f"q{k + 1}"])]
        )
        second = point + RRR_PLATFORM * radial - RRR_BASE * radial - first
        sides.append(float(first[0] * second[1] - first[1] * second[0]) / 1e4)
    return sides


@pytest.mark.slow
def test_the_number_of_modes_changes_at_the_locus_and_nowhere_else(rrr_inputs: Loci) -> None:
    """Beside a point of the locus (not near a cusp) the numbers of real modes, by complete
    enumeration, differ by two.
    """
    mechanism, rng = three_rrr("planar"), np.random.default_rng(3)
    q3 = rrr_inputs.solution.actuated_values[2]
    curve = max(rrr_inputs.curves, key=lambda c: len(c.points))
    for k in rng.choice(np.arange(5, len(curve.points) - 5), 6, replace=False):
        along = curve.points[k + 1] - curve.points[k - 1]
        across = 1e-4 * np.array([-along[1], along[0]]) / np.linalg.norm(along)
        counts = [
            len(symkin.modes(mechanism, joints=[*(curve.points[k] + side * across), q3]))
            for side in (1, -1)
        ]
        assert abs(counts[0] - counts[1]) == 2


@pytest.mark.slow
def test_cusps_are_where_three_modes_meet(rrr_inputs: Loci) -> None:
    """On a small circle about a cusp three modes are near its pose in the wedge, and one
    elsewhere.
    """
    cusps = np.vstack([c.cusps for c in rrr_inputs.curves])
    assert len(cusps) == 4
    mechanism = three_rrr("planar")
    for curve in rrr_inputs.curves:
        for cusp in curve.cusps:
            k = int(np.argmin(np.linalg.norm(curve.points - cusp, axis=1)))
            place = {name: i for i, name in enumerate(curve.names)}
            pose = curve.configurations[k, [place["pose.x"], place["pose.y"], place["pose.gamma"]]]
            counts = set()
            for turn in np.linspace(0, 2 * math.pi, 40, endpoint=False):
                joints = [
                    *(cusp + 0.03 * np.array([math.cos(turn), math.sin(turn)])),
                    rrr_inputs.solution.actuated_values[2],
                ]
                modes = symkin.modes(mechanism, joints=joints)
                near = [np.linalg.norm(mode.position[:2] - pose[:2]) < 15 for mode in modes]
                counts.add(sum(near))
            assert counts == {1, 3}


@pytest.mark.slow
def test_wrist_of_an_arm_over_two_joints() -> None:
    """Over q4, q5 the arm with a z-y-z wrist is singular where q5 is a multiple of a half turn,
    whatever q4.
    """
    arm = pieper()
    solution = symkin.solve(arm, joints=[0.3, 0.4, 0.9, 0.2, 0.7, 0.1]).solution
    loci = singular_loci(solution, ("q4", "q5"), ranges=((-3, 3), (-4, 4)), starts=40)
    values = np.concatenate([c.points[:, 1] for c in loci.curves])
    assert np.abs(np.sin(values)).max() < 1e-9
    assert {round(v / math.pi) for v in values} == {-1, 0, 1}
    assert all(c.kind == "type 1" for c in loci.curves)


@pytest.mark.slow
def test_turns_of_a_hexapod_about_two_axes() -> None:
    """rx, ry turn about base axes through the platform origin: a locus over x, rz has the closed
    form gamma = +-90 at x = 0.
    """
    base, platform = (
        np.radians([10, 110, 130, 230, 250, 350]),
        np.radians([30, 90, 150, 210, 270, 330]),
    )
    ring = [
        np.column_stack([r * np.cos(t), r * np.sin(t), np.zeros(6)])
        for r, t in ((200, base), (120, platform))
    ]
    mechanism = hexapod([tuple(b) for b in ring[0]], [tuple(a) for a in ring[1]], 120.0)
    loci = loci_of(mechanism, ("x", "rz"), ranges=((-50, 50), (-2, 2)), starts=40)
    curves = loci.of("type 2")
    assert curves
    for sign in (1, -1):
        near = np.vstack([c.points for c in curves])
        middle = near[np.sign(near[:, 1]) == sign]
        assert np.abs(np.abs(middle[np.argmin(np.abs(middle[:, 0])), 1]) - math.pi / 2) < 0.05


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    "limbs", [("pUS", "pUS", "pUS", "SPS", "SPS", "SPS"), ("rPS", "rHS", "pSR")], ids="-".join
)
def test_loci_of_random_mechanisms_are_zeros(limbs: tuple[str, ...]) -> None:
    """P, H, U and S joints: a point of a locus over two inputs is classified as the locus says
    (type 2, or passive joints alone).
    """
    mechanism = random_mechanism(np.random.default_rng(1), limbs)
    problem = build_problem(mechanism, "direct")
    solution = make_solution(problem, problem.closure.reference)
    names = [c.name for c in mechanism.actuated]
    loci = singular_loci(solution, names[:2], kinds=("type 2",), starts=12)
    assert loci.curves
    for curve in loci.curves:
        assert curve.largest_row < 1e-10 * mechanism.characteristic_length
        values = problem.closure.reference.copy()
        z, start = curve.configurations[len(curve.points) // 2], 0
        for name in curve.names:
            place = problem.closure.slices[name]
            values[place] = z[start : start + (place.stop - place.start)]
            start += place.stop - place.start
        assert curve.kind in classify(make_solution(problem, values)).kinds


@pytest.mark.slow
def test_a_platform_of_fewer_freedoms_has_no_plane_of_poses() -> None:
    """The five-bar's coupler has two freedoms of its plane's three: x and y alone cannot vary."""
    with pytest.raises(InputError, match="2 freedoms of 3"):
        loci_of(five_bar(), ("x", "y"))


def test_a_freedom_without_an_actuator_has_no_curves() -> None:
    """Two limbs r-S leave a freedom that no actuated joint decides: a note says so."""
    mechanism = random_mechanism(np.random.default_rng(9), ("rS", "rS"))
    problem = build_problem(mechanism, "direct")
    names = [c.name for c in mechanism.actuated]
    loci = singular_loci(
        make_solution(problem, problem.closure.reference), names, kinds=("type 2",), starts=10
    )
    assert loci.curves == ()
    assert any("everywhere" in note for note in loci.notes)


def near_double() -> list[symkin.Solution]:
    """Two isolated modes of the tilted 3-RPS that almost meet, where curves of its two operation
    modes nearly touch.
    """
    mechanism = tilted_rps()
    joints = [317.135906, 99.664134, mechanism.actuated[2].reference[0]]
    return [mode for mode in symkin.modes(mechanism, joints=joints) if mode.condition > 1e6]


@pytest.mark.slow
def test_curves_that_nearly_touch_are_no_self_motion() -> None:
    """Where every mode is certified to be isolated, no motion with the inputs held is claimed from
    any of them.
    """
    modes = near_double()
    assert len(modes) >= 2
    assert all(mode.certified for mode in modes)
    for mode in modes:
        (system,) = locus_systems(plane_of(mode, ("d1", "d2")), ("type 2",))
        assert not has_self_motion(system, system.centre)


@pytest.mark.parametrize(("off", "moves"), [(0.0, True), (1e-7, True), (1e-3, False)])
def test_a_self_motion_is_shown_from_an_inexact_point(off: float, moves: bool) -> None:
    """Five-bar, elbows in one place: the tip turns, also from inputs (radians) known to 1e-7 only;
    0.06 apart it does not.
    """
    planar = replace(five_bar(), motion="planar")
    bars = loci_of(planar, ("q1", "q2"), kinds=("type 2",), starts=80)
    (system,) = locus_systems(bars.plane, ("type 2",))
    for curve in bars.curves:
        if curve.is_point:
            z = curve.configurations[0].copy()
            z[system.uv] += [off, 0.0]
            assert has_self_motion(system, z) is moves


@pytest.mark.slow
@pytest.mark.parametrize("window", [((5000, 6000), (0.5, 1.0)), ((1e5, 2e5), (1e5, 2e5))])
def test_an_empty_window_says_so_in_the_picture(window: tuple) -> None:
    """No limb reaches there: the picture says so, its axes have the window's sides and are no
    strip.
    """
    mechanism = tilted_rps()
    joints = [c.reference[0] for c in mechanism.actuated]
    loci = singular_loci(
        symkin.solve(mechanism, joints=joints).solution, ("d1", "d2"), ranges=window, starts=20
    )
    (axes,) = figure_of_loci(loci).axes
    assert "no locus was met in this window" in [text.get_text() for text in axes.texts]
    box = axes.get_position()
    assert min(box.width, box.height) > 0.3


# --- the border -----------------------------------------------------------------------------------


def test_json_text_and_picture(bars: Loci, tmp_path: Path) -> None:
    """The JSON goes through json, the text names each curve, the picture is a PNG."""
    content = json.loads(json.dumps(bars.to_dict(), allow_nan=False))
    assert content["plane"] == ["q1", "q2"]
    assert len(content["curves"]) == len(bars.curves) == str(bars).count("type 2")
    bars.plot(tmp_path / "loci.png")
    assert (tmp_path / "loci.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError, match="no picture format"):
        bars.plot(tmp_path / "loci.xyz")


@pytest.mark.parametrize(
    ("plane", "options", "message"),
    [
        (("q1", "x"), {}, "allowed: two of x, y, gamma, rz"),
        (("q1", "q1"), {}, "two different"),
        (("q1", "q2"), {"ranges": ((0, 1),)}, "1 given, two are needed"),
        (("q1", "q2"), {"ranges": ((0, 1), (2, 1))}, "range of q2"),
        (("q1", "q2"), {"kinds": ("type 3",)}, "type 3"),
        (("q1", "q2"), {"starts": 0}, "starts = 0"),
        (("q1", "q2"), {"seed": -1}, "seed = -1"),
    ],
)
def test_what_does_not_fit_is_refused(plane: tuple[str, str], options: dict, message: str) -> None:
    """One sentence that names the value and what is allowed."""
    with pytest.raises(InputError, match=message):
        loci_of(five_bar(), plane, **options)


def test_loci_are_about_a_solution() -> None:
    """A mechanism in its place is told."""
    with pytest.raises(InputError, match="of type Mechanism; a Solution is needed"):
        symkin.singular_loci(five_bar(), ("q1", "q2"))


def test_a_mechanism_of_one_input_has_no_plane_of_inputs() -> None:
    """The four-bar has one actuated joint."""
    with pytest.raises(InputError, match="one or two of the actuated joints, crank"):
        loci_of(four_bar()[0], ("crank", "d"))


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stop:
        main(["singularities", *arguments])
    return int(stop.value.code or 0)


def test_command_names_the_singularity(capsys: pytest.CaptureFixture[str]) -> None:
    """gamma = 90 degrees of the 6-SPS platform, as JSON and as text."""
    pose = "0,0,100,0.70710678118654752,0,0,0.70710678118654752"
    assert run("zhang2009", "--pose", pose, "--json") == 0
    assert json.loads(capsys.readouterr().out)["kinds"] == ["type 2"]
    assert run("zhang2009", "--pose", pose) == 0
    assert "screw of pitch" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["zhang2009", "--range", "1:2,3:4"], 2, "belong to --plane"),
        (["zhang2009", "--plane", "x"], 2, "two different coordinates"),
        (["zhang2009", "--plane", "x,y", "--range", "1:2:3,4:5"], 2, "is no range"),
        (
            ["zhang2009", "--plane", "leg1,leg2", "--range=-50:-10,10:20"],
            2,
            "range of leg1 ends at -10 mm",
        ),
        (["zhang2009", "--joints", "1,1,1,1,1,1"], 3, "infeasible"),
        (["zhang2009", "--plane", "x,y", "--plot", "/nowhere/a.png"], 2, "does not exist"),
    ],
)
def test_command_refuses(
    arguments: list[str], status: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 2 for bad input, 3 where no configuration is reached, one line on stderr."""
    assert run(*arguments) == status
    assert message in capsys.readouterr().err
