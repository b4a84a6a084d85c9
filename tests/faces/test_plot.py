"""Laws of the drawn skeletons (links keep their lengths, both sides of a cut meet), and of the
figures made of them.
"""

from __future__ import annotations

import math
import subprocess
import sys
import warnings
from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.gate import in_gate_but
from helpers.inside import (
    Camera,
    check_picture_path,
    drawn_layout,
    figure_of_modes,
    outline,
)
from symkin import InputError, Joint, Limb, Mechanism, Modes, Pose, Rod

AROUND = [2 * math.pi * k / 3 for k in range(3)]


def _radial(angle: float) -> np.ndarray:
    return np.array([math.cos(angle), math.sin(angle), 0.0])


def delta_robot() -> Mechanism:
    """Three actuated arms of 220 mm, each with two parallel rods to the platform."""
    limbs = []
    for k, angle in enumerate(AROUND, start=1):
        u, n = _radial(angle), _radial(angle + math.pi / 2)
        elbow = 200 * u + 220 * (math.cos(0.6) * u + math.sin(0.6) * np.array([0.0, 0.0, 1.0]))
        rods = [Rod(tuple(elbow + s * 40 * n), tuple(60 * u + s * 40 * n)) for s in (-1, 1)]
        limbs.append(
            Limb(f"arm{k}", [Joint(f"q{k}", "R", point=200 * u, axis=-n, actuated=True)], rods)
        )
    return Mechanism(
        "delta", limbs, platform_position=(0, 0, 520), motion="translation", angle_unit="deg"
    )


def planar_3rrr() -> Mechanism:
    limbs = []
    for k, angle in enumerate(AROUND, start=1):
        a, c = 0.5 * _radial(angle), 0.15 * _radial(angle)
        b = 0.5 * (a + c) + 0.25 * _radial(angle + math.pi / 2)
        joints = [
            Joint(f"{name}{k}", "R", point=p, axis=(0, 0, 1), actuated=name == "a")
            for name, p in zip("abc", (a, b, c), strict=True)
        ]
        limbs.append(Limb(f"leg{k}", joints))
    return Mechanism(
        "planar_3rrr",
        limbs,
        motion="planar",
        length_unit="m",
        angle_unit="deg",
        title="planar 3-RRR",
    )


def sps_joints() -> Mechanism:
    """A hexapod whose legs are limbs of S, P and S joints: both S are cut."""
    limbs = []
    for k in range(6):
        turn = 0.2 * (-1) ** k
        base, top = (
            _radial(math.pi * k / 3 + turn),
            0.6 * _radial(math.pi * k / 3 - turn) + np.array([0.0, 0.0, 1.0]),
        )
        leg = top - base
        slide = Joint(f"p{k}", "P", axis=leg, actuated=True, zero=float(np.linalg.norm(leg)))
        limbs.append(
            Limb(
                f"leg{k}", [Joint(f"s{k}", "S", point=base), slide, Joint(f"e{k}", "S", point=top)]
            )
        )
    return Mechanism(
        "sps_joints",
        limbs,
        platform_position=(0, 0, 1),
        length_unit="m",
        title="legs of joints $x$ 6_4",
    )


@cache
def modes_of(name: str) -> Modes:
    own = {"delta": delta_robot, "planar_3rrr": planar_3rrr, "sps_joints": sps_joints}
    if name in own:
        return symkin.modes(own[name]())
    mechanism = symkin.load(name)
    if name == "gluon_6l3":
        return symkin.modes(mechanism, pose=symkin.modes(mechanism)[0].pose)
    return symkin.modes(
        mechanism, joints=[0.2, 0.25, 0.2, 0.22, 0.3, 0.25] if name == "ren2008" else None
    )


NAMES = (
    "zhang2009",
    "zhao2000",
    "zhao2000_links",
    "gluon_6l3",
    "yao2020",
    "ren2008",
    "delta",
    "planar_3rrr",
    "sps_joints",
)


PANELS = in_gate_but(NAMES, ["yao2020", "ren2008", "delta"])
"""Mechanisms whose figures the gate draws: many panels and one, rods, slides, flat, an arm."""


@cache
def figure_of(name: str):
    return figure_of_modes(modes_of(name), most=16)


def layouts(modes: Modes) -> list:
    """The marks of each mode."""
    return [drawn_layout(modes.problem.mechanism).at(mode.link_poses) for mode in modes]


# --- marks ----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_both_links_of_every_joint_agree(name):
    """Law: the places of a joint on its two links are one, but along a slide's axis, at the cut
    joint too.
    """
    modes = modes_of(name)
    assert len(modes) > 0
    for layout in layouts(modes):
        for mark in layout.joints:
            gap = mark.end - mark.start
            if mark.type in "PCH":
                gap = gap - (gap @ mark.axes[0]) * mark.axes[0]
            assert np.abs(gap).max() < 1e-8 * layout.size


@pytest.mark.parametrize("name", ["zhao2000_links", "planar_3rrr", "gluon_6l3", "delta"])
def test_links_keep_their_shapes(name):
    """Law: the points of every link are as far apart as at the reference."""
    modes = modes_of(name)
    reference = drawn_layout(modes.problem.mechanism)
    for layout in layouts(modes):
        for link, mark in reference.links.items():
            for i, j in combinations(range(len(mark.points)), 2):
                before, now = (
                    np.linalg.norm(points[i] - points[j])
                    for points in (mark.points, layout.links[link].points)
                )
                assert abs(now - before) < 1e-8 * layout.size


@pytest.mark.parametrize("name", ["zhang2009", "ren2008", "sps_joints"])
def test_rods_are_as_long_as_their_coordinates_say(name):
    """Law: the drawn leg's length is offset + value; law for legs of joints: the P joint's value
    itself.
    """
    modes = modes_of(name)
    mechanism = modes.problem.mechanism
    for mode, layout in zip(modes, layouts(modes), strict=True):
        drawn = [rod for rod in layout.rods if rod.actuated]
        drawn += [joint for joint in layout.joints if joint.type == "P"]
        lengths = [np.linalg.norm(mark.end - mark.start) for mark in drawn]
        given = [
            mode.values[c.name] - (0.0 if c.least is None else c.least) for c in mechanism.actuated
        ]
        np.testing.assert_allclose(lengths, given, atol=1e-8 * mechanism.characteristic_length)


@pytest.mark.parametrize("name", NAMES)
def test_platform_points_move_as_one_body(name):
    """Law: limbs end at the platform's points, moved by its pose; base points stay."""
    modes = modes_of(name)
    mechanism = modes.problem.mechanism
    reference, back = drawn_layout(mechanism), mechanism.reference_pose.inverse()
    for mode, layout in zip(modes, layouts(modes), strict=True):
        moved = [mode.pose.apply(back.apply(p)) for p in reference.links["platform"].points]
        np.testing.assert_allclose(
            layout.links["platform"].points, moved, atol=1e-8 * mechanism.characteristic_length
        )
        np.testing.assert_allclose(
            layout.links["base"].points,
            reference.links["base"].points,
            atol=1e-12 * mechanism.characteristic_length,
        )


def test_serial_arms_end_at_the_tool():
    """Law: an arm is drawn from the base frame to the tool."""
    for name in ("gluon_6l3", "yao2020"):
        for mode, layout in zip(modes_of(name), layouts(modes_of(name)), strict=True):
            np.testing.assert_allclose(layout.links["base"].points[0], 0.0)
            np.testing.assert_allclose(
                layout.links["platform"].points[-1], mode.position, atol=1e-6
            )


def test_sliding_joints_are_drawn_along_their_axes():
    """zhao2000: R, then out along the radial axis at the base's height, up along z, R."""
    for mode, layout in zip(modes_of("zhao2000"), layouts(modes_of("zhao2000")), strict=True):
        marks = layout.marks
        for k in (1, 2, 3):
            radial, height = marks[f"radial{k}"], marks[f"height{k}"]
            length = np.linalg.norm(radial.end - radial.start)
            np.testing.assert_allclose(length, abs(mode.values[f"radial{k}"]), atol=1e-6)
            np.testing.assert_allclose(
                height.end - height.start, [0, 0, mode.position[2]], atol=1e-6
            )
            np.testing.assert_allclose(radial.start, marks[f"theta{k}"].end, atol=1e-6)
            np.testing.assert_allclose(radial.end, height.start, atol=1e-6)
            np.testing.assert_allclose(height.end, marks[f"top{k}"].start, atol=1e-6)


def test_base_rails_begin_beside_their_own_point():
    """A P joint at the base without a point: its rail runs from beside the origin to the next
    joint.
    """
    joints = [
        Joint("p", "P", axis=(0, 0, 1), actuated=True, zero=2.0),
        Joint("s", "S", point=(1, 0, 2)),
    ]
    mechanism = Mechanism("rail", [Limb("limb", joints)], platform_position=(0, 0, 2))
    up = Pose(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0, 0, 0]))
    poses = {"base": Pose.identity(), "limb.1": up, "platform": up}
    slide = drawn_layout(mechanism).at(poses).marks["p"]
    np.testing.assert_allclose([slide.start, slide.end], [[1, 0, 0], [1, 0, 3]])


def test_spherical_mechanisms_do_not_collapse_to_a_point():
    """Where all joints are given at one point, points of their axes are drawn."""
    axes = [[(1, 0, 0), (0.6, 0.8, 0), (0, 0.6, 0.8)], [(0, 1, 0), (0, 0.8, 0.6), (-0.6, 0, 0.8)]]
    limbs = [
        Limb(
            f"limb{k}",
            [Joint(f"j{k}{i}", "R", axis=axis, actuated=i == 0) for i, axis in enumerate(three)],
        )
        for k, three in enumerate(axes)
    ]
    layout = drawn_layout(Mechanism("wrist", limbs, motion="spherical"))
    for joint, axis in zip(layout.joints, [*axes[0], *axes[1]], strict=True):
        np.testing.assert_allclose(joint.centre, np.array(axis) / np.linalg.norm(axis))


def test_a_delta_arm_is_a_bar_with_a_cross_bar():
    """Its link goes from the motor to the middle of its rods' ends, and from there to each."""
    layout = drawn_layout(delta_robot())
    mark = layout.links["arm1.1"]
    ends = [rod.start for rod in layout.rods if rod.links[0] == "arm1.1"]
    drawn = [(mark.points[a], mark.points[b]) for a, b in mark.edges]
    hub = np.mean(ends, axis=0)
    expected = [(layout.marks["q1"].centre, hub), *((hub, end) for end in ends)]
    np.testing.assert_allclose(drawn, expected)
    assert np.linalg.norm(hub - layout.marks["q1"].centre) == pytest.approx(220.0)


def test_outline_is_convex_and_in_order():
    """Law: hull corners go once around; inner points and repeated points are left out; a line
    leaves its two ends.
    """
    square = np.array([[0, 0, 1], [1, 1, 1], [1, 0, 1], [0, 1, 1]], dtype=float)
    corners = outline(np.vstack([square, [[0.5, 0.5, 1], [1, 1, 1], [0.5, 0, 1]]]))
    sides = np.roll(corners, -1, axis=0) - corners
    assert corners.shape == (4, 3)
    np.testing.assert_allclose(np.linalg.norm(sides, axis=1), 1.0)
    assert len(outline(np.array([[0.0, 0, 0], [2, 2, 2], [1, 1, 1]]))) == 2
    assert len(outline(np.zeros((3, 3)))) == 1


# --- figures --------------------------------------------------------------------------------------


def lines_of(figure, gid):
    (ax,) = figure.axes
    return [line for line in ax.lines if line.get_gid() == gid]


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_every_mode_has_a_panel_to_one_scale(name):
    """Law: one panel per mode, all drawn to one scale, everything inside: the base looks the
    same in all.
    """
    modes, figure = modes_of(name), figure_of(name)
    (ax,) = figure.axes
    titles = [text.get_text() for text in ax.texts if text.get_text().startswith("mode ")]
    assert titles == [f"mode {k}" for k in range(1, min(len(modes), 16) + 1)]
    width, height = (limits[1] for limits in (ax.get_xlim(), ax.get_ylim()))
    points = np.vstack([line.get_xydata() for line in ax.lines])
    assert np.all(points >= 0.0)
    assert np.all(points <= [width, height])
    base = np.array([line.get_xydata() for line in lines_of(figure, "base")])
    panels = base.reshape(len(titles), -1, 2)
    assert np.ptp(panels - panels[:, :1], axis=0).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_titles_and_labels_lie_in_the_figure_and_apart(name):
    """No text reaches over the figure's edge, and no two overlap, with 16 panels too."""
    figure = figure_of(name)
    figure.draw_without_rendering()
    width, height = figure.canvas.get_width_height()
    (ax,) = figure.axes
    boxes = [text.get_window_extent() for text in ax.texts if text.get_text()]
    for box in boxes:
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "PNG", "pdf", "svg"])
def test_pictures_are_written(tmp_path, suffix):
    target = tmp_path / f"modes.{suffix}"
    assert len(modes_of("gluon_6l3" if suffix == "pdf" else "zhang2009").plot(target).axes) > 0
    assert target.stat().st_size > 5000


def test_frames_stay_below_the_text_of_their_panel():
    """The tool of a level arm stands above all joints; of a machine that is far from the base frame
    no frame is drawn.
    """
    five_bar, four_bar = symkin.load("pantograph_five_bar"), symkin.load("four_bar")
    sheet = symkin.solve(five_bar).plot().axes[0]
    told = min(text.get_position()[1] for text in sheet.texts if "roll" in text.get_text())
    lines = 3 * 19.0  # three lines of text hang from there
    tips = [line.get_ydata()[1] for line in sheet.lines if line.get_gid() == "frame"]
    assert len(tips) == 4
    assert max(tips) < told - lines
    moved = [
        replace(e, joint=replace(e.joint, point=tuple(np.add(e.joint.point, (1e4, 0.0, 0.0)))))
        for e in four_bar.link_joints
    ]
    far = symkin.solve(replace(four_bar, link_joints=moved), given={"crank": 60.0}).plot()
    assert not any(line.get_gid() == "frame" for line in far.axes[0].lines)


def test_symbols_stay_below_the_text_of_their_panel_and_the_title_is_whole():
    """Joints that share the platform's points stand apart above it."""
    sheet = symkin.solve(symkin.load("zhao2000_links")).plot().axes[0]
    told = min(text.get_position()[1] for text in sheet.texts if "roll" in text.get_text())
    symbols = [a for a in sheet.get_children() if str(a.get_gid()).startswith("joint R top")]
    assert symbols
    assert max(a.get_window_extent().y1 for a in symbols) < told - 2 * 19.0
    gripper = symkin.load("parallel_gripper")
    texts = [text.get_text() for text in symkin.modes(gripper).plot().axes[0].texts]
    assert f"parallel_gripper: {gripper.title}" in texts


def test_a_pin_is_seen_in_its_slide_and_joints_have_units():
    """The revolute joint on the axis of a piston is drawn over it; angles and lengths are told with
    their unit.
    """
    sheet = symkin.solve(symkin.load("slider_crank"), given={"crank": 90.0}).plot().axes[0]
    order = {
        name: max(a.get_zorder() for a in sheet.get_children() if name in str(a.get_gid()))
        for name in ("joint R small_end", "joint P piston")
    }
    assert order["joint R small_end"] > order["joint P piston"]
    (told,) = (text.get_text() for text in sheet.texts if "piston" in text.get_text())
    assert told.replace("\N{NO-BREAK SPACE}", " ").endswith("small_end 0 deg, piston 75 mm")


def test_a_jacobians_rounding_is_written_as_0_and_its_units_are_told():
    """What is nothing beside the largest entry has no digits of its own."""
    ax = symkin.jacobian(symkin.load("delta")).plot().axes[0]
    assert not any("e-" in text.get_text() for text in ax.texts)
    assert ax.get_title() == "lengths in mm, angles in rad"
    rates = symkin.jacobian(symkin.load("four_bar"), of=["follower"], by=["crank"])
    bars = [j.plot().axes[1].get_ylabel() for j in (symkin.jacobian(symkin.load("delta")), rates)]
    assert ["size" in text for text in bars] == [True, False]


def test_titles_in_other_scripts_and_long_titles(tmp_path):
    """Neither a missing glyph nor a long title stops or overfills a picture; matplotlib's
    mathematics is off.
    """
    mechanism = replace(symkin.load("gluon_6l3"), title="六自由度机械臂 $x_1$ " + 40 * "long ")
    modes = symkin.modes(mechanism)
    assert len(modes.plot(tmp_path / "modes.png").axes) == 1
    figure = figure_of_modes(modes)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        titles = [text.get_window_extent() for text in figure.axes[0].texts]
    assert len(titles) >= 3
    assert all(box.x0 >= 0 and box.x1 <= figure.canvas.get_width_height()[0] for box in titles)


def test_more_modes_than_panels():
    figure = figure_of_modes(modes_of("zhao2000_links"), most=5)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert sum(text.startswith("mode ") for text in texts) == 5
    assert f"5 of {len(modes_of('zhao2000_links'))} modes shown" in " ".join(texts)
    with pytest.raises(InputError, match="most = 0"):
        figure_of_modes(modes_of("zhao2000_links"), most=0)


def test_without_modes_the_reference_is_drawn(tmp_path):
    modes = symkin.modes(symkin.load("zhang2009"), joints=[1, 900, 1, 900, 1, 900])
    figure = figure_of_modes(modes)
    assert len(figure.axes) == 1
    assert any(text.get_text() == "no real solution" for text in figure.axes[0].texts)
    assert len(modes.plot(str(tmp_path / "none.png")).axes) == 1


def test_panel_titles_say_where_and_whether_within_limits():
    (ax,) = figure_of_modes(modes_of("ren2008"), most=1).axes
    texts = [text.get_text() for text in ax.texts]
    assert "mode 1" in texts
    assert any(text.startswith("position (") and "within limits" in text for text in texts)


def test_flat_mechanisms_are_seen_from_above():
    flat, solid = Camera.of(drawn_layout(planar_3rrr())), Camera.of(drawn_layout(delta_robot()))
    np.testing.assert_allclose(flat.axes, np.eye(3), atol=1e-12)
    assert flat.planar
    assert not solid.planar


@pytest.mark.parametrize(
    "name", ["modes", "modes.xyz", "modes.pgf", "missing/modes.png", "folder.png"]
)
def test_paths_that_cannot_be_written(tmp_path, name):
    """Each error names the path and says what to do, before anything is drawn."""
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(InputError, match=name.split("/")[-1].replace(".", r"\.")) as caught:
        check_picture_path(tmp_path / name)
    assert str(caught.value).startswith("plot: ")
    with pytest.raises(InputError):
        modes_of("zhang2009").plot(tmp_path / name)


def test_a_write_that_fails_is_an_input_error(tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    def fail(*_args, **_options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(InputError, match="Permission denied"):
        modes_of("zhang2009").plot(tmp_path / "modes.png")


@pytest.mark.slow
def test_symkin_does_not_import_matplotlib():
    """Nor does the plotting module before it draws; pyplot is never imported."""
    code = (
        f"import sys, symkin, {inside.where('figure_of_modes')} as plot; assert 'matplotlib' not "
        f"in sys.modules;"
        "plot.figure_of_modes(symkin.modes(symkin.load('gluon_6l3'))); assert 'matplotlib.pyplot' "
        "not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
