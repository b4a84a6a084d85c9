"""Symbols of joints as kinematic schemes draw them, seen from any direction.

R: a cylinder on its axis, a circle where the axis points to the eye. P: a prism on its rail. C: a
cylinder that its rail passes through. H: a cylinder with a thread. U: a cross of two axes in a
ring. S: a ball in an open socket. Weld: a filled square.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symkin.drawing.palette import COLOURS
from symkin.model.joint_forms import JointType

_WIDTH = 0.52
"""Diameter of cylinders and side of prisms, over their length."""
_END_ON = 0.25
"""Length of a direction as it is seen (of 1) below which an axis counts as pointing to the eye."""
_CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
"""Corners of a square."""
_EDGE = 1.2
"""Width of outlines in points."""


def draw_symbol(
    ax: Any,
    kind: JointType,
    centre: np.ndarray,
    axes: Sequence[np.ndarray],
    size: float,
    *,
    actuated: bool,
    label: str,
    order: float,
) -> None:
    """Draw the symbol of a joint at `centre` (2,), its `axes` (2,) as they are seen (of 1), `size`
    long; every artist has the group id `label`.
    """
    fill = COLOURS["accent"] if actuated else "white"
    artists = _DRAWN[kind](centre, list(axes), size, fill)
    for number, artist in enumerate(artists):
        artist.set_zorder(order + 0.001 * number)
        artist.set_gid(label)
        ax.add_artist(artist)


def _revolute(centre: np.ndarray, axes: list[np.ndarray], size: float, fill: str) -> list[Any]:
    axis, seen = _direction(axes[0])
    if seen < _END_ON:
        return [_disc(centre, 0.5 * _WIDTH * size * 1.15, fill), _dot(centre, 0.09 * size)]
    return _cylinder(centre, axis, seen, size, fill)


def _prismatic(centre: np.ndarray, axes: list[np.ndarray], size: float, fill: str) -> list[Any]:
    axis, seen = _direction(axes[0])
    half, side = 0.5 * size * max(seen, _WIDTH), 0.5 * _WIDTH * size
    across = np.array([-axis[1], axis[0]])
    corners = [centre + i * half * axis + j * side * across for i, j in _CORNERS]
    rail = 1.55 * half * axis
    inside = (
        [_line([corners[0], corners[2]], 0.7), _line([corners[1], corners[3]], 0.7)]
        if seen < _END_ON
        else []
    )
    middle = [_line([centre - half * axis, centre + half * axis], 0.7)] if not inside else []
    return [_line([centre - rail, centre + rail], 1.1), _polygon(corners, fill), *inside, *middle]


def _cylindrical(centre: np.ndarray, axes: list[np.ndarray], size: float, fill: str) -> list[Any]:
    axis, seen = _direction(axes[0])
    if seen < _END_ON:
        ring = _disc(centre, 0.5 * _WIDTH * size * 1.15, fill)
        return [ring, _disc(centre, 0.25 * _WIDTH * size, "white"), _dot(centre, 0.07 * size)]
    rail = 1.1 * size * seen * axis
    return [_line([centre - rail, centre + rail], 1.8), *_cylinder(centre, axis, seen, size, fill)]


def _helical(centre: np.ndarray, axes: list[np.ndarray], size: float, fill: str) -> list[Any]:
    axis, seen = _direction(axes[0])
    drawn = _revolute(centre, axes, size, fill)
    across = np.array([-axis[1], axis[0]]) * 0.5 * _WIDTH * size
    half = 0.5 * size * max(seen, _WIDTH)
    turns = np.linspace(-0.7, 0.7, 6)
    thread = [
        centre + s * half * axis + (across if k % 2 else -across) * 0.85
        for k, s in enumerate(turns)
    ]
    return [*drawn, _line(thread, 0.9)]


def _universal(centre: np.ndarray, axes: list[np.ndarray], size: float, fill: str) -> list[Any]:
    radius = 0.4 * size
    drawn = [_disc(centre, radius, fill)]
    for axis in axes:
        way, seen = _direction(axis)
        reach = radius * 1.5 * max(seen, 0.3) * way
        drawn += [
            _line([centre - reach, centre + reach], 1.6),
            _dot(centre + reach, 0.07 * size),
            _dot(centre - reach, 0.07 * size),
        ]
    return drawn


def _spherical(centre: np.ndarray, _axes: list[np.ndarray], size: float, fill: str) -> list[Any]:
    from matplotlib.patches import Arc

    radius = 0.26 * size
    socket = Arc(
        (float(centre[0]), float(centre[1])),
        3.1 * radius,
        3.1 * radius,
        theta1=150.0,
        theta2=390.0,
        edgecolor=COLOURS["link"],
        lw=1.5,
    )
    return [socket, _disc(centre, radius, fill)]


def _weld(centre: np.ndarray, _axes: list[np.ndarray], size: float, _fill: str) -> list[Any]:
    half = 0.18 * size
    return [_polygon([centre + half * np.array(c) for c in _CORNERS], COLOURS["link"])]


_DRAWN = {
    "R": _revolute,
    "P": _prismatic,
    "C": _cylindrical,
    "H": _helical,
    "U": _universal,
    "S": _spherical,
    "weld": _weld,
}


def reach_of(kind: JointType, axes: Sequence[np.ndarray]) -> np.ndarray:
    """Half sides (2,) of the box that holds a symbol, over its size."""
    if kind in ("U", "S", "weld"):
        return np.full(2, 0.45)
    axis, seen = _direction(axes[0])
    along, across = (1.1 if kind == "C" else 0.5) * max(seen, _WIDTH), 0.5 * _WIDTH
    return np.asarray(np.abs(axis) * along + np.abs(axis[::-1]) * across + 0.06)


# --- shapes ---------------------------------------------------------------------------------------


def _direction(seen: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit direction in the picture, and how long the axis looks (of 1)."""
    length = float(np.linalg.norm(seen))
    return (seen / length if length > 1e-9 else np.array([1.0, 0.0])), min(1.0, length)


def _cylinder(
    centre: np.ndarray, axis: np.ndarray, seen: float, size: float, fill: str
) -> list[Any]:
    """Sides and far end as one outline, the near end as an ellipse."""
    from matplotlib.patches import Ellipse

    across, radius = np.array([-axis[1], axis[0]]), 0.5 * _WIDTH * size
    depth = radius * float(np.sqrt(max(0.0, 1.0 - seen**2)))
    half = 0.5 * size * seen * axis
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 15)
    back = [centre - half + radius * np.sin(t) * across + depth * np.cos(t) * axis for t in turn]
    outline = [centre + half + radius * across, *back, centre + half - radius * across]
    tip = centre + half
    angle = float(np.degrees(np.arctan2(axis[1], axis[0])))
    end = Ellipse(
        (float(tip[0]), float(tip[1])),
        max(2 * depth, 0.06 * size),
        2 * radius,
        angle=angle,
        facecolor=fill,
        edgecolor=COLOURS["link"],
        linewidth=_EDGE,
    )
    return [_polygon(outline, fill), end]


def _polygon(corners: Sequence[np.ndarray], fill: str) -> Any:
    from matplotlib.patches import Polygon

    return Polygon(
        np.array(corners),
        closed=True,
        facecolor=fill,
        edgecolor=COLOURS["link"],
        linewidth=_EDGE,
        joinstyle="round",
    )


def _disc(centre: np.ndarray, radius: float, fill: str, edge: str = COLOURS["link"]) -> Any:
    from matplotlib.patches import Circle

    place = float(centre[0]), float(centre[1])
    return Circle(place, radius, facecolor=fill, edgecolor=edge, linewidth=_EDGE)


def _dot(centre: np.ndarray, radius: float) -> Any:
    return _disc(centre, radius, COLOURS["link"], "none")


def _line(points: Sequence[np.ndarray], width: float) -> Any:
    from matplotlib.lines import Line2D

    rows = np.array(points)
    return Line2D(
        rows[:, 0], rows[:, 1], color=COLOURS["link"], linewidth=width, solid_capstyle="round"
    )
