"""What may be chosen of pictures: names, views and modes are drawn as chosen, and what is left out
is said.
"""

from functools import cache
from itertools import combinations, pairwise

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inside import (
    FRAME_COLOURS,
    chosen_numbers,
    figure_of_modes,
    left_out,
    parse,
    pieces,
    ranges_text,
    shown_numbers,
)
from symkin import InputError


@cache
def modes_of(name):
    return symkin.modes(symkin.load(name))


def labels_of(figure):
    texts = [*figure.texts, *(text for ax in figure.axes for text in ax.texts)]
    return [text for text in texts if text.get_gid() == "label"]


@pytest.mark.parametrize(
    ("choice", "numbers"),
    [
        ("1-3,7", [1, 2, 3, 7]),
        ("all", list(range(1, 13))),
        ("10-40", [10, 11, 12]),
        ([5, 2, 2], [2, 5]),
        ("4", [4]),
    ],
)
def test_chosen_modes_are_rising_numbers(choice, numbers):
    """A range takes those of it that are there."""
    assert chosen_numbers(choice, 12) == numbers


@pytest.mark.parametrize(
    ("choice", "sentence"),
    [
        ("13", "there is no mode 13; there are 12 modes"),
        ("0", "numbers from 1"),
        ("3-1", "numbers from 1"),
        ("a", "'a' is no choice"),
        ("", "no choice"),
        ("13-20", "none of these is there"),
        ("1,,2", "no choice"),
        ([-1], "no choice"),
    ],
)
def test_a_choice_that_cannot_be_is_one_sentence(choice, sentence):
    with pytest.raises(InputError, match="--modes") as caught:
        chosen_numbers(choice, 12)
    assert sentence in str(caught.value)


def test_too_many_panels_are_refused():
    with pytest.raises(InputError, match="choose 200 at most"):
        chosen_numbers("all", 201)


@pytest.mark.parametrize(
    ("numbers", "text"), [([], ""), ([1], "1"), ([1, 2, 3, 7, 9, 10], "1-3, 7, 9-10")]
)
def test_numbers_in_short(numbers, text):
    assert ranges_text(numbers) == text


def test_what_is_left_out_is_said():
    """Law: the numbers that are shown and those that are left out are all modes, once each."""
    found = modes_of("zhao2000_links")
    shown = shown_numbers(found, "2-4,9")
    assert shown == [2, 3, 4, 9]
    assert "shows 4 of 16 modes, leaves out 12: 1, 5-8, 10-16" in left_out(found, shown)
    assert left_out(found, range(1, 17)) == ""
    figure = figure_of_modes(found, modes="2-4,9")
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert {text for text in texts if text.startswith("mode ")} == {
        "mode 2",
        "mode 3",
        "mode 4",
        "mode 9",
    }
    assert any("4 of 16 modes shown" in text for text in texts)


@pytest.mark.parametrize("name", ["zhao2000", "gluon_6l3", "ankle", "delta", "jansen_leg"])
def test_names_are_written_apart_and_within(name):
    """Every joint is named in each panel, no name over another or beyond the edge; without names
    there is none.
    """
    found = modes_of(name)
    figure = figure_of_modes(found, modes="1-2", names="all")
    renderer = figure.canvas.get_renderer()
    labels = labels_of(figure)
    boxes = [label.get_window_extent(renderer) for label in labels]
    assert all(
        box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height
        for box in boxes
    )
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    text = " ".join(label.get_text().replace("\n", " ") for label in labels)
    panels = min(2, len(found))
    for joint in found.problem.mechanism.all_joints:
        assert text.count(joint.name) >= panels, joint.name
    assert not labels_of(figure_of_modes(found, modes="1-2"))


def test_links_and_joints_are_named_alone():
    found = modes_of("zhao2000")
    links, joints = (
        {label.get_text() for label in labels_of(figure_of_modes(found, modes=[1], names=n))}
        for n in ("links", "joints")
    )
    assert links == {"O", "P", "base", "platform", "trt1", "trt2", "trt3", "op"}
    assert {"O", "P", "theta1", "radial1", "height1", "top1", "op"} <= joints
    assert not joints & {"base", "platform", "trt1"}
    with pytest.raises(InputError, match="allowed: all, joints, links, loops, none"):
        found.plot(names="every")
    with pytest.raises(InputError, match="zhao2000 has limbs"):
        found.plot(names="loops")


@pytest.mark.parametrize("name", ["zhao2000", "ankle"])
def test_each_view_has_a_panel(name):
    found = modes_of(name)
    figure = figure_of_modes(found, modes="1-2", views="main,top,front,side")
    texts = [t.get_text() for t in (*figure.texts, *(t for ax in figure.axes for t in ax.texts))]
    for title in ("from above", "from the front", "from the side"):
        assert {f"mode 1, {title}", f"mode 2, {title}"} <= set(texts)
    for wrong in ("above", "", ["top", "top"]):
        with pytest.raises(InputError, match="--views"):
            found.plot(views=wrong)


def test_views_are_along_the_axes_of_the_base():
    """Law: from above x is to the right and y up, from the front x and z, from the side y and z."""
    figure = figure_of_modes(modes_of("zhao2000"), modes=[1], views=["top", "front", "side"])
    drawn = [line for line in figure.axes[0].lines if line.get_gid() == "frame"]
    drawn.sort(key=lambda line: line.get_xdata()[0])
    for number, (right, up) in enumerate(("xy", "xz", "yz")):
        # of the base and of the platform, two axes of each are seen
        ways = {}
        for line in drawn[4 * number : 4 * number + 4]:
            ways.setdefault(line.get_color(), []).append(
                line.get_xydata()[1] - line.get_xydata()[0]
            )
        colours = dict(zip("xyz", FRAME_COLOURS, strict=True))
        assert set(ways) == {colours[right], colours[up]}
        assert any(abs(way[1]) < 1e-9 < way[0] for way in ways[colours[right]])
        assert any(abs(way[0]) < 1e-9 < way[1] for way in ways[colours[up]])


def test_titles_say_the_orientation():
    """Law: roll, pitch and yaw of a title are the mode's orientation."""
    mechanism = symkin.load("zhang2009")
    found = symkin.modes(mechanism)
    (ax,) = figure_of_modes(found).axes
    texts = [t.get_text() for t in ax.texts if "roll, pitch, yaw" in t.get_text()]
    assert len(texts) == len(found)
    for text, mode in zip(texts, found, strict=True):
        angles = [float(v) for v in text.split("yaw (")[1].split(")")[0].split(",")]
        turned = symkin.Pose.from_euler((0, 0, 0), np.radians(angles), "xyz")
        assert np.abs(turned.rotation - mode.rotation).max() < 1e-4


@pytest.mark.parametrize("name", ["zhao2000", "gluon_6l3", "ankle"])
def test_the_legend_explains_frames(name):
    figure = figure_of_modes(modes_of(name))
    texts = [t.get_text() for legend in figure.legends for t in legend.get_texts()]
    texts += [t.get_text() for ax in figure.axes for t in ax.texts]
    assert any(text.startswith("x, y, z of base and") for text in texts)


def test_of_crossing_lines_the_nearer_is_over():
    """Law: the pieces of a line make it up; at each crossing one of the two is over, the one nearer
    to the eye.
    """
    rng = np.random.default_rng(3)
    lines = [(rng.normal(size=3), rng.normal(size=3)) for _ in range(12)]
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found = pieces(lines, axes)
    for number, (start, end) in enumerate(lines):
        mine = [piece for piece in found if piece.number == number]
        ends = [mine[0].start, *(piece.end for piece in mine)]
        np.testing.assert_allclose(ends[0], start)
        np.testing.assert_allclose(ends[-1], end)
        assert sum(np.linalg.norm(b - a) for a, b in pairwise(ends)) == pytest.approx(
            np.linalg.norm(end - start)
        )
    over = [piece for piece in found if piece.over is not None]
    assert len(over) > 3
    for piece in over:
        seen = axes[:2] @ piece.over
        others = []
        for other in found:
            gap, along = seen - axes[:2] @ other.start, axes[:2] @ (other.end - other.start)
            share = gap @ along / (along @ along)
            if (
                other.number != piece.number
                and 0 <= share <= 1
                and np.linalg.norm(gap - share * along) < 1e-9
            ):
                others.append(
                    (other.nearness, axes[2] @ (other.start + share * (other.end - other.start)))
                )
        assert len(others) == 1
        assert others[0][1] < axes[2] @ piece.over
        assert others[0][0] < piece.nearness


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"views": 3}, "views = 3; a text or a list of texts is needed"),
        ({"modes": 3}, "modes = 3; a text or a list of whole numbers is needed"),
        ({"names": 3}, "names = 3; a text is needed"),
        ({"most": "3"}, "most = '3'; a whole number is needed"),
        ({"colour": 3}, "'colour' is no option .*; allowed: modes, most, names, views"),
    ],
)
def test_options_of_another_type_are_one_sentence(options, sentence):
    with pytest.raises(InputError, match=f"^plot: {sentence}"):
        modes_of("zhao2000").plot(**options)


def test_names_change_no_colour_of_a_jacobian():
    """Angles are shaded times the size, whatever a joint is called: also as a pose's coordinate or
    a twist's is.
    """
    text = symkin.load("four_bar").to_toml()
    other = symkin.load("zhao2000").to_toml()
    shades = []
    for crank, pin, theta in (("crank", "follower_pin", "theta1"), ("vx", "x", "vy")):
        bar = parse(text.replace('"crank"', f'"{crank}"').replace('"follower_pin"', f'"{pin}"'))
        platform = parse(other.replace('"theta1"', f'"{theta}"'))
        rates = symkin.jacobian(bar, of=[pin], by=[crank]), symkin.jacobian(platform, "direct")
        shades.append([np.array(j.plot().axes[0].images[0].get_array()) for j in rates])
    for before, after in zip(*shades, strict=True):
        np.testing.assert_array_equal(before, after)


def test_commands_take_the_options(tmp_path, capsys):
    path = tmp_path / "a.png"
    status, text, _ = run(
        capsys,
        "modes",
        "zhao2000_links",
        "--plot",
        path,
        "--modes",
        "1-3",
        "--names",
        "joints",
        "--views",
        "top",
    )
    assert status == 0
    assert "leaves out 13: 4-16" in text
    status, text, _ = run(capsys, "singularities", "zhao2000", "--plot", path, "--names", "all")
    assert status == 0
    assert f"picture: {path}" in text
    for wrong, sentence in (
        (("modes", "zhao2000", "--names", "all"), "--names is given without --plot"),
        (
            ("modes", "zhao2000", "--plot", tmp_path / "b.png", "--modes", "x"),
            "'x' is no choice of modes",
        ),
        (("modes", "zhao2000", "--plot", tmp_path / "b.png", "--modes", "9"), "there is no mode 9"),
        (
            (
                "singularities",
                "zhao2000",
                "--plane",
                "theta1,op",
                "--plot",
                tmp_path / "b.png",
                "--names",
                "all",
            ),
            "one configuration",
        ),
    ):
        status, _, err = run(capsys, *wrong)
        assert status == 2
        assert sentence in err
    assert not (tmp_path / "b.png").exists()


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
def test_a_picture_is_the_same_file_at_each_run(tmp_path, suffix):
    files = [tmp_path / f"{k}.{suffix}" for k in range(2)]
    for file in files:
        modes_of("four_bar").plot(file, names="all")
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_picture_of_a_singularity_says_what_its_table_says():
    """Coordinates that leave a freedom at every configuration leave it at this one."""
    found = symkin.singularity(symkin.load("five_link_suspension"))
    texts = [text.get_text() for text in found.plot().axes[0].texts]
    assert "\nsingular everywhere: the given coordinates leave 1 freedom" in str(found)
    assert "singular everywhere" in texts
    assert any("not driven, everywhere: 1" in text for text in texts)
