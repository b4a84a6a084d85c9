"""A four-bar by circles, for calibration: what its encoders and a tracker would read, without
symkin.
"""

from __future__ import annotations

import numpy as np

FILE = """format = 1
name = "four_bar"
length_unit = "mm"
angle_unit = "deg"
[[joint]]
name = "crank"
type = "R"
links = ["base", "crank_link"]
point = {pivot}
axis = [0.0, 0.0, 1.0]
zero = 90.0
actuated = true
[[joint]]
name = "crank_pin"
type = "R"
links = ["crank_link", "coupler"]
point = {pin}
axis = [0.0, 0.0, 1.0]
[[joint]]
name = "follower_pin"
type = "R"
links = ["coupler", "rocker"]
point = {top}
axis = [0.0, 0.0, 1.0]
[[joint]]
name = "follower"
type = "R"
links = ["base", "rocker"]
point = {foot}
axis = [0.0, 0.0, 1.0]
[[link]]
name = "coupler"
points = {{ pen = {pen} }}
[[link]]
name = "base"
points = {{ mark = {mark} }}
"""
POINTS = {
    "pivot": [0.0, 0.0],
    "pin": [0.0, 40.0],
    "top": [99.0, 60.0],
    "foot": [110.0, 0.0],
    "pen": [50.0, 80.0],
    "mark": [0.0, 120.0],
}
PATHS = {
    "pivot": "crank.point",
    "pin": "crank_pin.point",
    "top": "follower_pin.point",
    "foot": "follower.point",
    "pen": "coupler.points.pen",
    "mark": "base.points.mark",
}
"""Key paths of the points in symkin."""


def toml(points=POINTS) -> str:
    """The mechanism file."""
    return FILE.format(
        **{name: [float(v) for v in (*point, 0.0)] for name, point in points.items()}
    )


def built(rng, spread=0.5):
    """The points of a machine as it was built."""
    return {
        name: np.array(point) + rng.uniform(-spread, spread, 2) for name, point in POINTS.items()
    }


def readings(points, crank, offset=0.0, *, side=1.0):
    """Of cranks (n,) in radians: follower (n,) from the reference on, with an offset; pen (n, 2);
    distance of pen and mark (n,); turn of the coupler from the reference (n,); of side -1, in the
    other assembly mode.
    """
    pivot, pin, top, foot, pen, mark = (np.array(points[name], dtype=float) for name in POINTS)
    turned = crank - np.pi / 2
    a = pivot + _turned(np.tile(pin - pivot, (len(crank), 1)), turned)
    b = _meet(a, np.linalg.norm(top - pin), foot, np.linalg.norm(top - foot), side)
    angle = _angle(b - a) - _angle(top - pin)
    places = a + _turned(np.tile(pen - pin, (len(crank), 1)), angle)
    follower = _wrapped(_angle(b - foot) - _angle(top - foot)) + offset
    return follower, places, np.linalg.norm(places - mark, axis=1), _wrapped(angle)


def _meet(a, r, centre, s, side):
    """Where circles of radius r about points a (n, 2) meet one of radius s, on the left from a to
    its centre (side 1) or right.
    """
    gap = centre - a
    d = np.linalg.norm(gap, axis=1)
    along = (d**2 + r**2 - s**2) / (2 * d)
    across = side * np.sqrt(r**2 - along**2)
    unit = gap / d[:, None]
    return a + along[:, None] * unit + across[:, None] * np.column_stack([-unit[:, 1], unit[:, 0]])


def _turned(v, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]])


def _angle(v):
    return np.arctan2(v[..., 1], v[..., 0])


def _wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi
