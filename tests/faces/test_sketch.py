"""Kinematic sketches: every joint with the symbol of its type, texts apart, planar mechanisms in
their plane, the same bytes again.
"""

from functools import cache
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import symkin
from helpers.command_line import run
from helpers.inside import (
    COLOURS,
    Camera,
    Label,
    Page,
    draw_sketch,
    drawn_layout,
    figure_of_sketch,
    parse,
    raised,
    write_picture,
)
from helpers.inside import LabelBox as Box
from helpers.samples import Z, delta, readme_five_bar, three_rrr
from symkin import InputError, Joint, Limb, Mechanism, RodLimb

SYMBOLS = {"R", "P", "H", "C", "U", "S"}


def one_of_each() -> Mechanism:
    """Limbs with all six types of joints; two of them share points."""
    first = Limb(
        "a",
        [
            Joint("r", "R", (0, 0, 0), Z, actuated=True),
            Joint("u", "U", (60, 0, 40), (1, 0, 0), axis2=(0, 1, 0)),
            Joint("c", "C", (60, 0, 120), (0, 0.6, 0.8)),
            Joint("s", "S", (20, 0, 170)),
        ],
    )
    second = Limb(
        "b",
        [
            Joint("h", "H", (200, 0, 0), Z, pitch=5, actuated=True),
            Joint("h-2", "R", (200, 0, 0), (1, 0, 0)),
            Joint("p", "P", axis=Z),
            Joint("r2", "R", (180, 20, 110), (1, 0, 0)),
            Joint("s2", "S", (120, 20, 170)),
        ],
    )
    third = Limb(
        "third limb",
        [
            Joint("u3", "U", (100, 180, 0), (1, 0, 0), axis2=(0, 1, 0)),
            Joint("p3", "P", axis=(-0.2, -0.4, 0.9), actuated=True),
            Joint("s3", "S", (80, 100, 170)),
        ],
    )
    limbs = [first, second, third]
    return Mechanism(
        "one_of_each",
        limbs,
        platform_position=(80, 50, 170),
        length_unit="mm",
        title="$x$ one of _each^",
    )


def upright_five_bar() -> Mechanism:
    """A planar mechanism in the plane of x and z."""
    y = (0, 1, 0)
    left = Limb(
        "left",
        [Joint("q1", "R", (-75, 0, 0), y, actuated=True), Joint("e1", "R", (-75, 0, 100), y)],
    )
    right = Limb(
        "right",
        [
            Joint("q2", "R", (75, 0, 0), y, actuated=True),
            Joint("slide", "P", axis=Z),
            Joint("tip", "R", (20, 0, 200), y),
        ],
    )
    return Mechanism("upright", [left, right], platform_position=(20, 0, 200), length_unit="mm")


FOUR_BAR = """format = 1
name = "bar"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "crank"
type = "R"
links = ["base", "crank_link"]
point = [0, 0, 0]
axis = [0, 0, 1]
actuated = true
[[joint]]
name = "pin"
type = "R"
links = ["crank_link", "rod"]
point = [0, {1}, 0]
axis = [0, 0, 1]
[[joint]]
name = "rocker_pin"
type = "R"
links = ["rod", "rocker"]
point = [{0}, {2}, 0]
axis = [0, 0, 1]
[[joint]]
name = "follower"
type = "R"
links = ["base", "rocker"]
point = [{0}, 0, 0]
axis = [0, 0, 1]
"""


OWN = {
    "one_of_each": one_of_each,
    "five_bar": lambda: readme_five_bar("planar"),
    "3-RRR": lambda: three_rrr("planar"),
    "delta": delta,
    "upright": upright_five_bar,
}
EVERY = [*(name for name in symkin.shipped_names() if not symkin.load(name).is_graph), *OWN]


def mechanism_of(name: str) -> Mechanism:
    return OWN[name]() if name in OWN else symkin.load(name)


@cache
def figure_of(name: str) -> Any:
    return figure_of_sketch(mechanism_of(name))


def artists(name: str, gid: str) -> list[Any]:
    (ax,) = figure_of(name).axes
    return [artist for artist in ax.get_children() if artist.get_gid() == gid]


@pytest.mark.slow
@pytest.mark.parametrize("name", EVERY)
def test_every_joint_is_drawn_with_its_symbol(name: str) -> None:
    """Each joint of the mechanism, and the three of each rod limb, has artists that say type and
    name; actuated ones alone have the accent colour.
    """
    mechanism = mechanism_of(name)
    wanted = {(joint.type, joint.name): joint.actuated for _, joint in mechanism.joints}
    for limb in mechanism.limbs:
        if isinstance(limb, RodLimb):
            wanted |= {
                (kind, limb.name if kind == "P" else f"{limb.name}.{kind}"): kind == "P"
                for kind in limb.type
            }
    assert {kind for kind, _ in wanted} <= SYMBOLS
    for (kind, joint), actuated in wanted.items():
        drawn = artists(name, f"joint {kind} {joint}")
        assert drawn, (kind, joint)
        fills = [
            to_rgb(a.get_facecolor()[:3])
            for a in drawn
            if hasattr(a, "get_facecolor") and a.get_fill()
        ]
        assert (to_rgb(COLOURS["accent"]) in fills) == actuated, joint


@pytest.mark.parametrize("name", EVERY)
def test_texts_lie_in_the_picture_and_apart(name: str) -> None:
    """No text meets another or the picture's edge, and each joint, limb and frame is named."""
    figure = figure_of(name)
    (ax,) = figure.axes
    renderer = figure.canvas.get_renderer()
    texts = [text for text in ax.texts if text.get_text()]
    boxes = [text.get_window_extent(renderer) for text in texts]
    for box, text in zip(boxes, texts, strict=True):
        assert min(box.x0, box.y0, figure.bbox.width - box.x1, figure.bbox.height - box.y1) >= 0, (
            text.get_text()
        )
    for (a, one), (b, other) in combinations(zip(texts, boxes, strict=True), 2):
        away = one.x1 <= other.x0 or other.x1 <= one.x0 or one.y1 <= other.y0 or other.y1 <= one.y0
        assert away, (a.get_text(), b.get_text())
    said = {text.get_text() for text in texts}
    mechanism = mechanism_of(name)
    names = {joint.name for _, joint in mechanism.joints} | {
        limb.name for limb in mechanism.limbs if not mechanism.serial
    }
    assert names <= said
    assert "O" in said or "O = P" in said


@pytest.mark.parametrize(
    ("name", "lengths"),
    [
        ("zhao2000_links", {"70"}),
        ("gluon_6l3", {"105.03", "174.42", "75.66", "80.09", "44.36"}),
        ("delta", {"100", "220"}),
        ("five_bar", {"100", "150"}),
        ("yao2020", {"300", "85", "105"}),
    ],
)
def test_main_dimensions_are_those_of_the_papers(name: str, lengths: set[str]) -> None:
    """Links and rods carry their lengths, equal ones once."""
    said = [text.get_text() for text in artists(name, "label")]
    assert lengths <= set(said)
    assert all(said.count(length) == 1 for length in lengths)


@pytest.mark.parametrize(("name", "normal"), [("five_bar", 2), ("3-RRR", 2), ("upright", 1)])
def test_a_planar_mechanism_is_drawn_in_its_plane(name: str, normal: int) -> None:
    """Seen along its axes: distances in the picture are true, x to the right, what is up stays
    up.
    """
    layout = drawn_layout(mechanism_of(name))
    camera = Camera.of(layout)
    assert camera.planar
    assert abs(camera.axes[2][normal]) == pytest.approx(1.0)
    points = np.array([joint.centre for joint in layout.joints])
    flat = camera.flat(points)
    for i, j in combinations(range(len(points)), 2):
        assert np.linalg.norm(flat[i] - flat[j]) == pytest.approx(
            np.linalg.norm(points[i] - points[j])
        )
    assert camera.axes[0] @ np.eye(3)[0] == pytest.approx(1.0)
    assert camera.axes[1] @ np.eye(3)[3 - normal] == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["zhao2000", "zhang2009", "gluon_6l3", "one_of_each"])
def test_a_spatial_mechanism_is_seen_at_an_angle(name: str) -> None:
    camera = Camera.of(drawn_layout(mechanism_of(name)))
    assert not camera.planar
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-12)


def test_a_platform_in_the_plane_of_its_base_is_raised_and_says_so() -> None:
    """The 6-SPS platform of the file lies in its base's plane; raised, its circles keep their
    radii.
    """
    layout, _ = raised(drawn_layout(symkin.load("zhang2009")))
    assert layout.links["platform"].points[:, 2].min() > 100
    said = " ".join(t.get_text().replace("\n", " ") for t in figure_of("zhang2009").axes[0].texts)
    for note in (
        "platform raised by 318.8 mm from its reference",
        "base joints on a circle of 275 mm",
        "platform joints on a circle of 250 mm",
    ):
        assert note in said


def test_joints_that_share_a_point_stand_apart_on_their_axes() -> None:
    """Three axes through one point: the symbols lie a step and more from each other, each on its
    own axis, and the links between them go from one to the next.
    """
    layout = drawn_layout(symkin.load("yao2020")).spread(40.0)
    shoulder = layout.joints[:3]
    for one, other in combinations(shoulder, 2):
        assert np.linalg.norm(one.centre - other.centre) >= 40.0 - 1e-9
    for joint in shoulder:
        assert np.linalg.norm(np.cross(joint.centre, joint.axes[0])) < 1e-9
    for one, other in pairwise(shoulder):
        points = layout.links[one.links[1]].points
        np.testing.assert_allclose(points, [one.centre, other.centre], atol=1e-12)


@pytest.mark.parametrize("scale", [0.003, 0.17, 1.0, 44.0])
def test_the_scale_bar_is_as_long_as_it_says(scale: float) -> None:
    """Law: a mechanism of any size in its picture has a bar of a round length, to the scale of its
    links.
    """
    mechanism = parse(FOUR_BAR.format(*(round(v / scale, 6) for v in (100, 40, 75))))
    (ax,) = figure_of_sketch(mechanism).axes
    (bar,) = [line for line in ax.lines if line.get_gid() == "scale"]
    drawn = float(np.ptp(bar.get_xdata()))
    centres = [a for a in ax.get_children() if str(a.get_gid()) == "link crank_link"]
    ends = centres[0].get_xydata()
    pixels = float(np.linalg.norm(ends[1] - ends[0])) / (40 / scale)
    (said,) = [
        t.get_text() for t in ax.texts if t.get_text().endswith(" mm") and len(t.get_text()) < 12
    ]
    assert drawn == pytest.approx(float(said.split()[0]) * pixels, rel=1e-5)
    assert 20.0 < drawn <= 130.0


def test_labels_find_a_place_even_where_all_is_full() -> None:
    """Forty labels of one point: none meets another."""
    page = Page(600.0, 400.0, symbols=[Box(300.0, 200.0, 20.0, 20.0)])
    placed = [
        page.place(Label(str(k), np.array([300.0, 200.0]), 20.0, 9.0, {}, width=30.0, height=12.0))
        for k in range(40)
    ]
    assert not any(a.meets(b) for a, b in combinations(placed, 2))
    assert all(15 <= box.x <= 585 and 6 <= box.y <= 394 for box in placed)


@pytest.mark.parametrize(
    ("suffix", "begins"), [("pdf", b"%PDF"), ("svg", b"<?xml"), ("jpg", b"\xff\xd8")]
)
def test_pictures_of_any_kind_are_written(tmp_path: Path, suffix: str, begins: bytes) -> None:
    target = tmp_path / f"sketch.{suffix}"
    write_picture(figure_of("zhang2009"), target)
    assert target.read_bytes().startswith(begins)


def test_show_writes_the_picture(capsys, tmp_path: Path) -> None:
    """Status 0, the account of the mechanism and the picture's name on stdout; twice the same
    bytes.
    """
    target = tmp_path / "sketch.png"
    pictures = []
    for _ in range(2):
        status, out, err = run(capsys, "show", "zhang2009", "--plot", str(target))
        assert (status, err) == (0, "")
        assert "Mobility" in out
        assert f"picture: {target}" in out
        pictures.append(target.read_bytes())
    assert pictures[0].startswith(b"\x89PNG")
    assert pictures[0] == pictures[1]


def test_the_equations_and_the_sketch_go_together(capsys, tmp_path: Path) -> None:
    target = tmp_path / "sketch.png"
    status, out, _ = run(capsys, "show", "zhang2009", "--latex", "--plot", str(target))
    assert status == 0
    assert out.startswith("% closure of zhang2009")
    assert target.exists()


@pytest.mark.parametrize(
    ("name", "words"),
    [("sketch.xyz", ".xyz"), ("sketch", "png"), ("none/sketch.png", "folder"), (".", "folder")],
)
def test_bad_names_are_refused_before_anything_is_printed(
    capsys, tmp_path, monkeypatch, name: str, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run(capsys, "show", "zhang2009", "--plot", name)
    assert (status, out) == (2, "")
    assert words in err or "picture format" in err
    with pytest.raises(InputError):
        draw_sketch(symkin.load("zhang2009"), tmp_path / name)
    assert not list(tmp_path.iterdir())
