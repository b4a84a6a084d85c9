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
from itertools import combinations, product

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.gate import in_gate_but
from helpers.inside import (
    MechanismLines,
    View,
    build_closure,
    check_picture_path,
    figure_of_modes,
    joint_displacement,
    lines_at,
    link_displacements,
    outline,
    reference_lines,
)
from helpers.laws import chain, frame
from helpers.samples import random_coordinate, random_mechanism
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


def skeletons(modes: Modes) -> list[MechanismLines]:
    return [lines_at(modes.problem.mechanism, mode.values, mode.pose) for mode in modes]


# --- links ----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_both_sides_of_every_joint_agree(name):
    """Law: the links before and behind a joint differ by what the joint allows, at the cut joint
    too.
    """
    modes = modes_of(name)
    mechanism = modes.problem.mechanism
    assert len(modes) > 0
    for mode, limb in product(modes, mechanism.limbs):
        if not isinstance(limb, Limb):
            continue
        links = link_displacements(mechanism, limb, mode.values, mode.pose)
        assert len(links) == len(limb.joints) + 1
        for joint, before, behind in zip(limb.joints, links[:-1], links[1:], strict=True):
            gap = behind.apply(np.array(joint.point)) - before.apply(np.array(joint.point))
            if joint.type == "P":
                axis = before.turn(np.array(joint.axis))
                gap = np.concatenate(
                    [
                        gap - (gap @ axis) * axis,
                        mechanism.characteristic_length
                        * (behind.rotation - before.rotation).ravel(),
                    ]
                )
            assert np.abs(gap).max() < 1e-8 * mechanism.characteristic_length


@pytest.mark.parametrize("kinds", ["rRS", "SrR", "UrP", "hCR", "PPr", "CRrH"])
def test_links_of_random_limbs_are_products_of_displacements(kinds):
    """At the pose to which random joint values lead, without those of the cut joint: the links on
    both sides of the cut are where the joints from the base on place them.
    """
    rng = np.random.default_rng(2)
    for _ in range(5):
        mechanism = random_mechanism(rng, [kinds])
        (limb,) = mechanism.limbs
        values = {
            c.name: random_coordinate(rng, c) for joint in limb.joints for c in joint.coordinates
        }
        reference = frame(mechanism.platform_position, mechanism.platform_quaternion)
        held = {c.name for c in build_closure(mechanism).coordinates}
        known = {name: value for name, value in values.items() if name in held}
        assert len(known) < len(values)
        links = link_displacements(
            mechanism, limb, known, Pose.from_matrix(chain(limb.joints, values) @ reference)
        )
        for count, link in enumerate(links):
            np.testing.assert_allclose(link.matrix, chain(limb.joints[:count], values), atol=1e-9)


VALUES = {
    "R": (0.7,),
    "P": (0.4,),
    "H": (5.0,),
    "C": (-0.8, 0.3),
    "U": (0.5, -1.1),
    "S": ((0.5, -0.5, 0.1, 0.7),),
}


def _joint(kind: str, k: int, rng: np.random.Generator) -> tuple[Joint, list]:
    first, second = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
    options = {
        "axis": None if kind == "S" else first,
        "axis2": second if kind == "U" else None,
        "pitch": 0.2 if kind == "H" else 0.0,
        "zero": 0.3 if kind in "RPH" else 0.0,
    }
    values = list(VALUES[kind])
    if kind == "S":
        values = [np.array(values[0]) / np.linalg.norm(values[0])]
    return Joint(f"j{k}", kind, point=rng.normal(size=3), **options), values


@pytest.mark.parametrize("kinds", ["RCR", "HRU", "PCPR", "RUS", "SRR", "CCC", "PPP", "RHPS"])
def test_cut_coordinates_are_not_needed(kinds):
    """Law: with any one joint's coordinates withheld, the links stand where the whole chain puts
    them.
    """
    rng = np.random.default_rng(7)
    built = [_joint(kind, k, rng) for k, kind in enumerate(kinds)]
    limb = Limb("limb", [joint for joint, _ in built])
    mechanism = Mechanism(
        "one", [limb], platform_position=(0.2, 0.4, 0.9), platform_quaternion=(0.5, 0.5, 0.5, 0.5)
    )
    chain = [Pose.identity()]
    for joint, values in built:
        chain.append(chain[-1] @ joint_displacement(joint, values))
    pose = chain[-1] @ mechanism.reference_pose
    everything = {
        c.name: v for joint, values in built for c, v in zip(joint.coordinates, values, strict=True)
    }
    for cut in limb.joints:
        names = {c.name for c in cut.coordinates}
        known = {name: value for name, value in everything.items() if name not in names}
        for link, expected in zip(
            link_displacements(mechanism, limb, known, pose), chain, strict=True
        ):
            np.testing.assert_allclose(link.matrix, expected.matrix, atol=1e-12)


@pytest.mark.parametrize("kinds", ["SRS", "SPS", "RSRSR"])
def test_two_cut_balls_hold_what_is_between(kinds):
    """Law: without the coordinates of both spherical joints, their centres and the links between
    still meet.
    """
    rng = np.random.default_rng(3)
    built = [_joint(kind, k, rng) for k, kind in enumerate(kinds)]
    limb = Limb("limb", [joint for joint, _ in built])
    mechanism = Mechanism("one", [limb])
    chain = [Pose.identity()]
    for joint, values in built:
        chain.append(chain[-1] @ joint_displacement(joint, values))
    known = {
        c.name: v
        for j, values in built
        for c, v in zip(j.coordinates, values, strict=True)
        if j.type != "S"
    }
    links = link_displacements(mechanism, limb, known, chain[-1])
    np.testing.assert_allclose(links[-1].matrix, chain[-1].matrix)
    for joint, before, behind in zip(limb.joints, links[:-1], links[1:], strict=True):
        gap = behind.apply(np.array(joint.point)) - before.apply(np.array(joint.point))
        moved = 0.0 if joint.type != "P" else known[joint.name] - joint.zero
        assert abs(np.linalg.norm(gap) - abs(moved)) < 1e-12


# --- skeletons ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["zhao2000_links", "planar_3rrr", "gluon_6l3", "delta"])
def test_links_between_revolutes_keep_their_lengths(name):
    """Law: every drawn link is as long as at the reference."""
    modes = modes_of(name)
    size = modes.problem.mechanism.characteristic_length
    at_reference = reference_lines(modes.problem.mechanism)
    for body in skeletons(modes):
        for limb, reference in zip(body.limbs, at_reference.limbs, strict=True):
            pairs = zip(
                [*limb.segments, *limb.rods], [*reference.segments, *reference.rods], strict=True
            )
            assert all(
                abs(a.length - b.length) < 1e-8 * size
                for a, b in pairs
                if a.kind in ("link", "rod")
            )


@pytest.mark.parametrize("name", ["zhang2009", "ren2008", "sps_joints"])
def test_rods_are_as_long_as_their_coordinates_say(name):
    """Law: the drawn leg's length is offset + value; law for legs of joints: the P joint's value
    itself.
    """
    modes = modes_of(name)
    mechanism = modes.problem.mechanism
    for mode, body in zip(modes, skeletons(modes), strict=True):
        lengths = [sum(s.length for s in limb.segments) for limb in body.limbs]
        given = [
            mode.values[c.name] - (0.0 if c.least is None else c.least) for c in mechanism.actuated
        ]
        np.testing.assert_allclose(lengths, given, atol=1e-8 * mechanism.characteristic_length)


@pytest.mark.parametrize("name", NAMES)
def test_platform_points_move_as_one_body(name):
    """Law: limbs end at the platform's points, moved by its pose; base points stay."""
    modes = modes_of(name)
    mechanism = modes.problem.mechanism
    at_reference = reference_lines(mechanism)
    back = mechanism.reference_pose.inverse()
    for mode, body in zip(modes, skeletons(modes), strict=True):
        moved = [mode.pose.apply(back.apply(point)) for point in at_reference.platform]
        np.testing.assert_allclose(
            body.platform, moved, atol=1e-8 * mechanism.characteristic_length
        )
        np.testing.assert_allclose(
            body.base, at_reference.base, atol=1e-12 * mechanism.characteristic_length
        )


def test_serial_arms_end_at_the_tool():
    """Law: the line of a serial arm runs from the base frame to the tool."""
    for name in ("gluon_6l3", "yao2020"):
        for mode, body in zip(modes_of(name), skeletons(modes_of(name)), strict=True):
            np.testing.assert_allclose(body.limbs[0].points[0], 0.0)
            np.testing.assert_allclose(body.limbs[0].points[-1], mode.position, atol=1e-6)


def test_sliding_joints_are_drawn_along_their_axes():
    """zhao2000: R, then out along the radial axis at the base's height, up along z, R."""
    for mode, body in zip(modes_of("zhao2000"), skeletons(modes_of("zhao2000")), strict=True):
        for k, limb in enumerate(body.limbs[:3], start=1):
            drawn = [s for s in limb.segments if s.length > 1e-6]
            assert [s.kind for s in drawn] == ["slide", "slide"]
            np.testing.assert_allclose(drawn[0].length, abs(mode.values[f"radial{k}"]), atol=1e-6)
            np.testing.assert_allclose(
                drawn[1].end - drawn[1].start, [0, 0, mode.position[2]], atol=1e-6
            )
        assert [s.kind for s in body.limbs[3].segments] == ["actuated slide"]


def test_base_rails_begin_beside_their_own_point():
    """A P joint at the base without a point: its rail runs from beside the origin to the next
    joint.
    """
    joints = [
        Joint("p", "P", axis=(0, 0, 1), actuated=True, zero=2.0),
        Joint("s", "S", point=(1, 0, 2)),
    ]
    mechanism = Mechanism("rail", [Limb("limb", joints)], platform_position=(0, 0, 2))
    (limb,) = lines_at(
        mechanism, {"p": 3.0}, Pose(np.array([0.0, 0.0, 3.0]), np.array([1.0, 0, 0, 0]))
    ).limbs
    np.testing.assert_allclose(limb.points[[0, -1]], [[1, 0, 0], [1, 0, 3]])


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
    body = reference_lines(Mechanism("wrist", limbs, motion="spherical"))
    np.testing.assert_allclose(
        np.linalg.norm(np.vstack([limb.points for limb in body.limbs]), axis=1), 1.0
    )


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


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_every_mode_has_a_panel_with_equal_axes(name):
    """Law: one panel per mode, the same limits everywhere, the same scale along x, y and z,
    everything inside.
    """
    modes, figure = modes_of(name), figure_of(name)
    assert len(figure.axes) == min(len(modes), 16)
    limits = [np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()]) for ax in figure.axes]
    for ax, limit in zip(figure.axes, limits, strict=True):
        scales = ax.get_box_aspect()
        np.testing.assert_allclose(
            np.ptp(limit, axis=1) / scales, np.ptp(limit, axis=1)[0] / scales[0]
        )
        np.testing.assert_allclose(limit, limits[0])
    points = np.vstack([body.points for body in skeletons(modes)[:16]])
    assert np.all(points >= limits[0][:, 0])
    assert np.all(points <= limits[0][:, 1])


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_titles_and_labels_lie_in_the_figure_and_apart(name):
    """No text reaches over the figure's edge, and no two titles overlap, with 16 panels too."""
    figure = figure_of(name)
    figure.draw_without_rendering()
    width, height = figure.canvas.get_width_height()
    titles = [text.get_window_extent() for text in (*figure.texts, figure.legends[0])]
    labels = [text.get_window_extent() for ax in figure.axes for text in ax.texts]
    for box in (*titles, *labels):
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height
    assert not any(a.overlaps(b) for a, b in combinations(titles, 2))
    unit = modes_of(name).problem.mechanism.length_unit
    assert all(any(t.get_text() == f"x [{unit}]" for t in ax.texts) for ax in figure.axes)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "PNG", "pdf", "svg"])
def test_pictures_are_written(tmp_path, suffix):
    target = tmp_path / f"modes.{suffix}"
    assert len(modes_of("gluon_6l3" if suffix == "pdf" else "zhang2009").plot(target).axes) > 0
    assert target.stat().st_size > 5000


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
        titles = [text.get_window_extent() for text in figure.texts]
    assert len(titles) >= 3
    assert all(box.x0 >= 0 and box.x1 <= figure.canvas.get_width_height()[0] for box in titles)


def test_more_modes_than_panels():
    figure = figure_of_modes(modes_of("zhao2000_links"), most=5)
    assert len(figure.axes) == 5
    assert f"5 of {len(modes_of('zhao2000_links'))} modes shown" in figure.get_suptitle()
    with pytest.raises(InputError, match="most = 0"):
        figure_of_modes(modes_of("zhao2000_links"), most=0)


def test_without_modes_the_reference_is_drawn(tmp_path):
    modes = symkin.modes(symkin.load("zhang2009"), joints=[1, 900, 1, 900, 1, 900])
    figure = figure_of_modes(modes)
    assert len(figure.axes) == 1
    assert any(text.get_text() == "no real solution" for text in figure.texts)
    assert len(modes.plot(str(tmp_path / "none.png")).axes) == 1


def test_panel_titles_say_where_and_whether_within_limits():
    texts = [text.get_text() for text in figure_of_modes(modes_of("ren2008"), most=1).texts]
    assert "mode 1" in texts
    assert any(text.startswith("position (") and "within limits" in text for text in texts)


def test_flat_mechanisms_are_seen_from_above():
    flat, solid = skeletons(modes_of("planar_3rrr")), skeletons(modes_of("delta"))
    assert View.around(flat, "m").flat
    assert not View.around(solid, "mm").flat


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
