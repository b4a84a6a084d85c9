"""Pictures as geometry: drawn points are link poses applied to points, axes point where they point,
what is nearer covers.

The poses are random, so that a point, an axis or a depth that is taken from another link or view is
somewhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import symkin
from helpers.inside import (
    Camera,
    Painter,
    drawn_layout,
    links_of,
    pieces,
)
from helpers.random_graphs import random_graph
from helpers.samples import unit

SEEDS = range(12)


def displaced(seed):
    """A random graph of links, a random displacement (rotation, shift) of each link but the base,
    and the lines there."""
    rng, mechanism = np.random.default_rng(seed), random_graph(seed)
    size, poses = mechanism.characteristic_length, {}
    for link in sorted({"base", *links_of(mechanism)}):
        pose = symkin.Pose(size * rng.normal(size=3), unit(rng, 4))
        poses[link] = symkin.Pose.identity() if link == "base" else pose
    moves = {link: (pose.rotation, pose.position) for link, pose in poses.items()}
    return mechanism, moves, drawn_layout(mechanism).at(poses)


def moved(moves, link, point):
    rotation, shift = moves[link]
    return rotation @ np.array(point) + shift


def painted(lines, axes, *, origin=True):
    """A painter with a scale and a shift of its own, after it has drawn."""
    figure = Figure(figsize=(6, 6), dpi=50)
    FigureCanvasAgg(figure)
    ax = figure.add_axes((0, 0, 1, 1))
    size = lines.mechanism.characteristic_length
    camera = Camera(axes, planar=False)
    painter = Painter(ax, lines, camera, 100.0 / size, np.array([7.0, -3.0]), 5.0, origin=origin)
    painter.draw()
    return painter


def named(painter, gid):
    return [artist for artist in painter.ax.get_children() if artist.get_gid() == gid]


def random_view(seed):
    """Rows right, up, towards the eye."""
    q = np.linalg.qr(np.random.default_rng(100 + seed).normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


@pytest.mark.parametrize("seed", SEEDS)
def test_axes_are_carried_by_their_links(seed):
    """The first axis of a joint turns with its first link, the second one of a universal joint with
    its second."""
    mechanism, moves, lines = displaced(seed)
    marks = {mark.name: mark for mark in lines.joints}
    for entry in mechanism.link_joints:
        joint, mark = entry.joint, marks[entry.joint.name]
        given = [(k, a) for k, a in enumerate((joint.axis, joint.axis2)) if a is not None]
        assert len(mark.axes) == len(given)
        for k, axis in given:
            np.testing.assert_allclose(mark.axes[k], moves[entry.links[k]][0] @ axis, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_drawn_points_are_moved_by_their_links(seed):
    """Joints stand at the point of their second link, rods between points of their links."""
    mechanism, moves, lines = displaced(seed)
    size = mechanism.characteristic_length
    marks = {mark.name: mark for mark in lines.joints}
    for entry in mechanism.link_joints:
        if entry.joint.type not in ("P", "weld"):
            place = mechanism.places[entry.joint.name]
            for link in entry.links:
                point = moved(moves, link, place)
                assert (
                    min(np.linalg.norm(point - p) for p in lines.links[link].points) < 1e-12 * size
                )
            np.testing.assert_allclose(
                marks[entry.joint.name].centre,
                moved(moves, entry.links[1], place),
                atol=1e-12 * size,
            )
    for rod, line in zip(mechanism.link_rods, lines.rods, strict=True):
        np.testing.assert_allclose(
            line.start, moved(moves, rod.links[0], rod.start), atol=1e-12 * size
        )
        np.testing.assert_allclose(line.end, moved(moves, rod.links[1], rod.end), atol=1e-12 * size)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_picture_is_a_view_of_the_points(seed):
    """Rods and joints are drawn where shift + scale (right, up) leads their points; of two joints
    that are driven alike, the one nearer to the eye covers the other."""
    mechanism, _, lines = displaced(seed)
    axes, size = random_view(seed), mechanism.characteristic_length
    painter = painted(lines, axes)

    def seen(point):
        return np.array([7.0, -3.0]) + 100.0 / size * np.array([axes[0] @ point, axes[1] @ point])

    ordered = {}
    for rod in lines.rods:
        drawn = [a.get_xydata() for a in named(painter, f"rod {rod.name}")]
        np.testing.assert_allclose(drawn[0][0], seen(rod.start), atol=1e-9)
        np.testing.assert_allclose(drawn[-1][1], seen(rod.end), atol=1e-9)
    for mark in lines.joints:
        first, *_ = named(painter, f"joint {mark.type} {mark.name}")
        ordered.setdefault(mark.actuated, []).append((axes[2] @ mark.centre, first.get_zorder()))
    for pairs in ordered.values():
        heights, orders = (np.array(column) for column in zip(*sorted(pairs), strict=True))
        near = np.abs(heights) < size
        assert np.all(np.diff(orders) >= 0)
        assert np.all(np.diff(orders[near]) > 0)


def crossing(upper):
    """Two links as bars that cross at the origin as seen along z, `upper` above the other by half
    their length."""
    heights = {
        "first": 50.0 if upper == "first" else 0.0,
        "second": 50.0 if upper == "second" else 0.0,
    }
    z, joints = (0.0, 0.0, 1.0), []
    for link, way in (("first", (100.0, 0.0)), ("second", (0.0, 100.0))):
        x, y = way
        joints += [
            symkin.LinkJoint(
                symkin.Joint(f"{link} start", "R", (-x, -y, heights[link]), z), ("base", link)
            ),
            symkin.LinkJoint(
                symkin.Joint(f"{link} end", "R", (x, y, heights[link]), z), (link, f"{link} tail")
            ),
        ]
    return symkin.Mechanism("crossing", link_joints=joints)


@pytest.mark.parametrize("upper", ["first", "second"])
@pytest.mark.parametrize("below", [False, True])
def test_the_nearer_link_has_the_pixel_of_the_crossing(upper, below):
    """Seen from above and from below: the colour at the crossing is that of the link nearer to the
    eye."""
    lines = drawn_layout(crossing(upper))
    axes = np.diag([1.0, -1.0, -1.0]) if below else np.eye(3)
    painter = painted(bars_alone(lines), axes, origin=False)
    nearer = upper if not below else {"first": "second", "second": "first"}[upper]
    x, y = painter.at(np.zeros(3))
    painter.ax.set(xlim=(x - 20, x + 20), ylim=(y - 20, y + 20))
    painter.ax.axis("off")
    canvas = painter.ax.figure.canvas
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())
    middle = pixels[pixels.shape[0] // 2, pixels.shape[1] // 2, :3] / 255
    colours = {
        link: to_rgb(named(painter, f"link {link}")[0].get_color()) for link in ("first", "second")
    }
    assert min(colours, key=lambda link: np.linalg.norm(middle - colours[link])) == nearer


def bars_alone(lines):
    """The same without base and tails, which have no part in the crossing, and without symbols."""
    kept = {link: points for link, points in lines.links.items() if link in ("first", "second")}
    return replace(lines, links=kept, joints=())


@pytest.mark.parametrize("seed", SEEDS)
def test_views_are_right_handed(seed):
    """Right, up and towards the eye are orthonormal and of positive hand: no picture is a mirror
    image."""
    axes = Camera.of(displaced(seed)[2]).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) > 0


@pytest.mark.parametrize("seed", SEEDS)
def test_frames_point_where_their_axes_point(seed):
    """The arrows of the base frame are seen along its axes, red, green and blue in turn, all to one
    scale."""
    _, _, lines = displaced(seed)
    axes = random_view(seed)
    painter = painted(lines, axes)
    arrows = [a.get_xydata() for a in named(painter, "frame")][:3]
    expected = [axes[:2, k] for k in range(3) if np.linalg.norm(axes[:2, k]) > 0.1]
    for (start, end), way in zip(arrows, expected, strict=False):
        np.testing.assert_allclose(start, [7.0, -3.0], atol=1e-9)
        np.testing.assert_allclose((end - start) / 7.5, way, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_pieces_of_crossing_lines_lie_over_each_other_by_depth(seed):
    """Two lines that are made to cross in the picture at known shares of both, and two beside them:
    pieces make up their lines, and the piece at the crossing has the depth there and covers the
    other if it is nearer."""
    rng, axes = np.random.default_rng(seed), random_view(seed)
    shares, depths, lines = rng.uniform(0.1, 0.9, 2), rng.normal(size=2), []
    for share, depth in zip(shares, depths, strict=True):
        along = np.array([*unit(rng, 2), 3.0 * rng.normal()])
        crossing = np.array([0.3, -0.2, depth])
        lines.append(
            (axes.T @ (crossing - share * along), axes.T @ (crossing + (1.0 - share) * along))
        )
    lines += [(axes.T @ [9.0, 9.0, k], axes.T @ [9.0 + k, 11.0, k]) for k in (0.0, 1.0)]
    found = pieces(lines, axes)
    for number, (start, end) in enumerate(lines):
        (own,) = [piece for piece in found if piece.number == number]
        np.testing.assert_allclose([own.start, own.end], [start, end], atol=1e-12)
        if number > 1:
            assert own.over is None
            continue
        assert own.nearness == pytest.approx(depths[number])
        assert (own.over is not None) == (depths[number] > depths[1 - number])
        if own.over is not None:
            np.testing.assert_allclose(axes @ own.over, [0.3, -0.2, depths[number]], atol=1e-12)
