"""Pictures of graphs: links keep their shapes in every mode, every joint has its symbol, names do
not cover each other.
"""

import json
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.gate import in_gate, in_gate_but
from helpers.inside import (
    FRAME_COLOURS,
    Camera,
    drawing,
    drawn_layout,
    figure_of_modes,
    figure_of_sketch,
    figure_of_solution,
    parse,
    read_robot,
)
from symkin import Joint, LinkJoint

GALLERY = json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text())
PLANAR = {
    "excavator_bucket",
    "four_bar",
    "four_leg_group",
    "jansen_leg",
    "klann_leg",
    "pantograph_five_bar",
    "pantograph_leg",
    "parallel_gripper",
    "planetary_gear",
    "slider_crank",
    "stephenson_six_bar",
    "triad",
    "watt_six_bar",
}
ALL_TYPES = """format = 1
name = "m"
title = "$x$ all types"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "r"
type = "R"
links = ["base", "a"]
point = [0, 0, 0]
axis = [0, 0, 1]
actuated = true
[[joint]]
name = "c"
type = "C"
links = ["a", "b"]
point = [40, 0, 0]
axis = [0, 1, 1]
[[joint]]
name = "u"
type = "U"
links = ["b", "c"]
point = [60, 20, 30]
axis = [1, 0, 0]
axis2 = [0, 1, 0]
[[joint]]
name = "h"
type = "H"
links = ["c", "d"]
point = [90, 40, 10]
axis = [0, 0, 1]
pitch = 5
[[joint]]
name = "s"
type = "S"
links = ["d", "e"]
point = [100, 0, 60]
[[joint]]
name = "p"
type = "P"
links = ["base", "e"]
axis = [0, 0, 1]
[[joint]]
name = "w"
type = "weld"
links = ["e", "f"]
[[rod]]
name = "bar"
links = ["base", "f"]
from = [150, 0, 0]
to = [120, 30, 60]
[[rod]]
name = "jack"
links = ["base", "d"]
from = [50, 90, 0]
to = [95, 60, 40]
actuated = true
[[link]]
name = "f"
points = { nose = [130, 0, 80] }
[platform]
link = "e"
position = [110, 10, 60]
"""


@cache
def first_modes(name: str) -> symkin.Modes:
    return symkin.modes(symkin.load(name), given=GALLERY[name]["cases"][0]["given"])


@pytest.mark.parametrize(
    "name",
    in_gate_but(
        sorted(set(GALLERY) - {"excavator_bucket", "slider_crank", "pantograph_leg"}),
        [
            "bricard",
            "goldberg",
            "double_wishbone",
            "four_leg_group",
            "watt_six_bar",
            "pantograph_five_bar",
            "sarrus",
            "spherical_wrist",
            "triad",
            "delta_parallelograms",
            "klann_leg",
            "stephenson_six_bar",
            "five_link_suspension",
        ],
    ),
)
def test_links_keep_their_shapes_in_every_mode(name):
    """Distances between the points of a link are those at the reference, whatever the
    configuration; slides have no place on links.
    """
    mechanism = symkin.load(name)
    slides = {joint.name for joint in mechanism.all_joints if joint.type == "P"}
    reference = drawn_layout(mechanism)
    for mode in first_modes(name).modes[:8]:
        lines = drawn_layout(mechanism).at(mode.link_poses)
        for link, mark in reference.links.items():
            if link == "base" and slides:
                continue
            points, moved = mark.points, lines.links[link].points
            for i, j in combinations(range(len(points)), 2):
                before = np.linalg.norm(points[i] - points[j])
                now = np.linalg.norm(moved[i] - moved[j])
                assert abs(now - before) < 1e-6 * mechanism.characteristic_length


@pytest.mark.parametrize(
    "name",
    in_gate_but(
        ["ankle", "delta_parallelograms", "five_link_suspension"], ["five_link_suspension"]
    ),
)
def test_rods_keep_their_lengths_in_every_mode(name):
    mechanism = symkin.load(name)
    for mode in first_modes(name):
        for line, rod in zip(
            drawn_layout(mechanism).at(mode.link_poses).rods, mechanism.link_rods, strict=True
        ):
            assert abs(np.linalg.norm(line.end - line.start) - rod.reference_length) < 1e-6


def test_named_points_and_frame_are_those_of_the_solution():
    for mode in first_modes("jansen_leg"):
        lines = drawn_layout(symkin.load("jansen_leg")).at(mode.link_poses)
        np.testing.assert_allclose(lines.points["foot"][1], mode.points["foot"], atol=1e-9)
        np.testing.assert_allclose(lines.pose.position, mode.position, atol=1e-9)


@pytest.mark.parametrize("name", sorted(GALLERY))
def test_planar_graphs_are_seen_along_their_axes(name):
    lines = drawn_layout(symkin.load(name))
    camera = Camera.of(lines)
    axes, planar = camera.axes, camera.planar
    assert planar == (name in PLANAR)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    if planar:
        assert all(
            abs(abs(joint.axes[0] @ axes[2]) - 1.0) < 1e-9
            for joint in lines.joints
            if joint.type == "R"
        )


SKETCHED = [
    "ankle",
    "excavator_bucket",
    "hexapod_stack",
    "all types",
    "spherical_wrist",
    "delta_parallelograms",
    "four_leg_group",
    "bennett",
]
"""What the gate sketches: flat and in space, few names and many."""


@cache
def sketch(name: str):
    return figure_of_sketch(parse(ALL_TYPES) if name == "all types" else symkin.load(name))


@pytest.mark.parametrize(
    "name",
    in_gate([*sorted(GALLERY), "all types"], SKETCHED[:4]),
)
def test_every_joint_rod_and_point_is_drawn_and_named(name):
    mechanism = parse(ALL_TYPES) if name == "all types" else symkin.load(name)
    figure = sketch(name)
    (ax,) = figure.axes
    groups = {artist.get_gid() for artist in ax.get_children()}
    texts = " ".join(text.get_text().replace("\n", " ") for text in ax.texts)
    for joint in mechanism.all_joints:
        assert f"joint {joint.type} {joint.name}" in groups
        assert joint.name in texts
    for rod in mechanism.link_rods:
        assert f"rod {rod.name}" in groups
        assert rod.name in texts
    for point in mechanism.link_points:
        assert f"point {point.name}" in groups
        assert point.name in texts
    assert "base" in groups
    if (
        mechanism.platform_link is not None
        and len(drawn_layout(mechanism).links[mechanism.platform_link].points) > 1
    ):
        assert f"link {mechanism.platform_link}" in groups


@pytest.mark.parametrize("name", in_gate([*sorted(GALLERY), "all types"], SKETCHED))
def test_names_lie_in_the_picture_and_apart(name):
    figure = sketch(name)
    (ax,) = figure.axes
    with drawing():
        boxes = [
            text.get_window_extent(figure.canvas.get_renderer())
            for text in ax.texts
            if text.get_gid() == "label"
        ]
    width, height = figure.bbox.width, figure.bbox.height
    for box in boxes:
        assert box.x0 >= 0.0
        assert box.y0 >= 0.0
        assert box.x1 <= width
        assert box.y1 <= height
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


@pytest.mark.parametrize("name", ["pantograph_leg", "four_bar", "ankle", "all types"])
def test_the_legend_tells_the_axes_and_frames_that_are_drawn(name):
    """Colours of axes and letters of origins stand in the legend where they stand in the drawing,
    and nowhere else.
    """
    (ax,) = sketch(name).axes
    (told,) = [text for text in ax.texts if text.get_text()[:4] in ("x, y", "x, z")]
    row = [line for line in ax.lines if line.get_ydata()[0] == told.get_position()[1]]
    drawn = [line for line in ax.lines if line.get_gid() == "frame"]
    named = {text.get_text() for text in ax.texts if text.get_gid() == "label"}
    colours = {line.get_color() for line in drawn}
    assert {line.get_color() for line in row} & set(FRAME_COLOURS) == colours
    assert told.get_text().count(",") == len(colours) - 1
    assert ("(O)" in told.get_text()) == any(text[:2] in ("O", "O ") for text in named)
    assert ("(P)" in told.get_text()) == any(text[-1] == "P" for text in named)


@pytest.mark.parametrize("name", in_gate(["four_bar", "ankle", "triad"], ["four_bar", "ankle"]))
def test_every_mode_has_a_panel(name):
    """Twelve panels at most, and the title says how many modes there are."""
    modes = first_modes(name)
    (ax,) = figure_of_modes(modes).axes
    titles = [text.get_text() for text in ax.texts if text.get_text().startswith("mode ")]
    assert len(titles) == min(12, len(modes))
    assert any(f"{len(modes)} modes" in text.get_text() for text in ax.texts)
    assert len(figure_of_solution(modes[0]).axes) == 1


def test_panels_write_no_rounding_noise():
    """A coordinate that is zero but for rounding is written as 0."""
    found = symkin.solve(symkin.load("four_bar"), joints=[90.0], start={"follower": 1.0}).solution
    noisy = replace(
        found,
        values={name: v + 1e-15 if name != "crank" else v for name, v in found.values.items()},
    )
    assert any(0.0 < abs(v) < 1e-9 for v in noisy.joints.values())
    (text,) = [
        t.get_text() for t in figure_of_solution(noisy).axes[0].texts if "crank_pin" in t.get_text()
    ]
    assert "e-" not in text


def test_a_graph_without_modes_is_drawn_at_its_reference():
    modes = symkin.modes(symkin.load("slider_crank"), given={"piston": 5000.0})
    assert len(modes) == 0
    (ax,) = figure_of_modes(modes).axes
    assert any("reference configuration" in text.get_text() for text in ax.texts)


def test_the_commands_write_pictures(tmp_path, capsys):
    for number, arguments in enumerate(
        (["show", "four_bar"], ["modes", "four_bar", "--given", "crank=100"])
    ):
        path = tmp_path / f"{number}.png"
        status, text, _ = run(capsys, *arguments, "--plot", path)
        assert status == 0
        assert str(path) in text
        assert path.stat().st_size > 10_000


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 1, 1)])
def test_an_arm_of_links_stands_where_it_is_held(axis):
    """A base of one joint is a column from its origin in space; in a plane the ground is below the
    joint.
    """
    first = LinkJoint(Joint("a", "R", (30, 0, 0), (0, 0, 1)), ("base", "crank"))
    second = LinkJoint(Joint("b", "R", (60, 0, 0), axis), ("crank", "rod"))
    arm = symkin.Mechanism("arm", link_joints=[first, second], platform_link="rod")
    (ax,) = figure_of_sketch(arm, "none").axes
    base = [line.get_xydata() for line in ax.lines if line.get_gid() == "base"]
    joint = next(p for p in ax.patches if p.get_gid() == "joint R a" and hasattr(p, "center"))
    ground = np.mean(max(base, key=lambda ends: abs(ends[1, 0] - ends[0, 0])), axis=0)
    assert (abs(ground[0] - joint.center[0]) < 1.0) == (axis == (0, 0, 1))


@pytest.mark.parametrize(
    ("name", "count"), [("four_bar", 1), ("slider_crank", 0), ("klann_leg", 0)]
)
def test_two_pivots_are_joined_by_the_line_whose_length_is_told(name, count):
    """A length of the base stood in an empty place; no line leads to where a slide is by chance."""
    (ax,) = figure_of_sketch(symkin.load(name)).axes
    dashes = [a for a in ax.lines if a.get_gid() == "base" and a.get_linestyle() == "--"]
    assert len(dashes) == count


def test_couplings_and_hands_lie_on_nothing_else():
    """The coupling of two wheels on the line of their bearings is an arc beside it; two wheels on
    one axle show where each of them points.
    """
    (ax,) = figure_of_sketch(symkin.load("differential")).axes
    arcs = [a.get_xydata() for a in ax.lines if a.get_gid() == "coupling"]
    assert arcs
    for arc in arcs:
        away = arc[len(arc) // 2] - 0.5 * (arc[0] + arc[-1])
        assert np.linalg.norm(away) > 0.05 * np.linalg.norm(arc[-1] - arc[0])
    links = drawn_layout(symkin.load("planetary_gear")).links
    (sun, ring) = (np.diff(links[name].points, axis=0)[0] for name in ("sun_gear", "ring_gear"))
    assert np.linalg.norm(np.cross(sun, ring)) > 0.5 * np.linalg.norm(sun) * np.linalg.norm(ring)


# --- robots of other formats ----------------------------------------------------------------------

ROBOTS = Path(__file__).parents[1] / "data" / "models"
CROWDED = (
    "urdf_gepetto_yaml/digit_like_2legs.urdf",
    "urdf_onshape_closing/reachy_mini.urdf",
    "urdf_loop_joint/strandbeest.urdf",
)


@cache
def robot(name: str):
    return symkin.load(ROBOTS / name)


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(CROWDED, CROWDED[1:2]))
def test_a_robot_is_legible(name):
    """Its closures are ringed and no other joint; names lie apart, those that find no room are
    counted.
    """
    figure = figure_of_sketch(robot(name))
    (ax,) = figure.axes
    closures = {closure.joint.name for closure in read_robot(ROBOTS / name).closures}
    rings = {
        artist.get_gid()
        for artist in ax.patches
        if str(artist.get_gid()).startswith("closes a loop")
    }
    assert rings == {f"closes a loop: {name}" for name in closures}
    with drawing():
        labels = [text for text in ax.texts if text.get_gid() == "label"]
        boxes = [text.get_window_extent(figure.canvas.get_renderer()) for text in labels]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert len(labels) >= 20
    told = [text.get_text() for text in ax.texts if "find no room" in text.get_text()]
    assert bool(told) == (name == CROWDED[2])


def test_a_planar_linkage_that_a_ball_closes_is_seen_along_its_axes():
    """As MJCF closes it, by a connect; a ball within the tree may turn in any way."""
    joints = [
        LinkJoint(Joint(name, "R", point, (0, 0, 1)), links)
        for name, point, links in (
            ("a", (0, 0, 0), ("base", "crank")),
            ("b", (0, 1, 0), ("crank", "rod")),
            ("c", (4, 0, 0), ("base", "rocker")),
        )
    ]
    ball = LinkJoint(Joint("pin", "S", (4, 3, 0)), ("rod", "rocker"))
    closed = symkin.Mechanism("closed", link_joints=[*joints, ball])
    assert Camera.of(drawn_layout(closed)).planar
    within = symkin.Mechanism("within", link_joints=[ball, *joints])
    assert not Camera.of(drawn_layout(within)).planar


@pytest.mark.slow
def test_names_of_loops_alone_or_none(tmp_path, capsys):
    mechanism, where = robot(CROWDED[1]), ROBOTS / CROWDED[1]
    closing = drawn_layout(mechanism).closing
    assert set(closing) == {closure.joint.name for closure in read_robot(where).closures}
    texts = {
        names: {
            t.get_text()
            for t in figure_of_sketch(mechanism, names).axes[0].texts
            if t.get_gid() == "label"
        }
        for names in ("loops", "none")
    }
    assert texts == {"loops": set(closing), "none": set()}
    assert run(capsys, "show", where, "--plot", tmp_path / "a.png", "--names", "loops")[0] == 0
    for wrong, sentence in (
        (
            ("show", where, "--plot", tmp_path / "b.png", "--names", "few"),
            "--names: 'few' is unknown; allowed: all, joints, links, loops, none",
        ),
        (("show", where, "--names", "loops"), "--names is given without --plot"),
        (
            ("show", "zhao2000", "--plot", tmp_path / "b.png", "--names", "loops"),
            "zhao2000 has limbs",
        ),
    ):
        status, _, err = run(capsys, *wrong)
        assert status == 2
        assert sentence in err
    assert not (tmp_path / "b.png").exists()
