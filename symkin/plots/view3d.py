"""Limits, direction of view, ticks and labels of 3-D panels: all panels of a figure that are seen
from one side share a `View`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from symkin.plots.mechanism_lines import MechanismLines
from symkin.plots.picture_options import ViewName
from symkin.plots.style import COLOURS

_FLAT = 1e-6
"""Extent (of the largest) below which a mechanism is flat and is seen from above."""
_UPRIGHT = 0.3
"""Level share of its direction below which an edge counts as upright."""
_THINNEST = 0.4
"""Least extent of the box in any direction, of the largest."""
_ANGLES: dict[ViewName, tuple[float, float]] = {
    "main": (21.0, -57.0),
    "top": (89.99, -90.01),
    "front": (0.01, -90.01),
    "side": (0.01, -0.01),
}
"""Elevation and azimuth of the eye in degrees; from above not quite 90, which leaves no up
direction.
"""


@dataclass(frozen=True, eq=False)
class View:
    """What panels share: limits (3, 2) in `unit`, whether the mechanism is flat (its main view is
    from above), and the view's name.
    """

    limits: np.ndarray
    unit: str
    flat: bool
    name: ViewName = "main"

    @staticmethod
    def around(bodies: Sequence[MechanismLines], unit: str) -> View:
        """The box that holds every body, with a margin and no side too thin."""
        points = np.vstack([body.points for body in bodies])
        low, high = points.min(axis=0), points.max(axis=0)
        largest = float(max(high - low)) or 1.0
        flat = bool(high[2] - low[2] < _FLAT * largest)
        extent = np.maximum(high - low, _THINNEST * largest) + 0.1 * largest
        middle = 0.5 * (low + high)
        return View(np.column_stack([middle - 0.5 * extent, middle + 0.5 * extent]), unit, flat)

    @property
    def extent(self) -> np.ndarray:
        return np.asarray(self.limits[:, 1] - self.limits[:, 0])

    def seen_from(self, name: ViewName) -> View:
        """The same box, seen from another side."""
        return replace(self, name=name)

    @property
    def angles(self) -> tuple[float, float]:
        """Elevation and azimuth of the eye, degrees."""
        return _ANGLES["top" if self.flat and self.name == "main" else self.name]

    @property
    def axes(self) -> np.ndarray:
        """Rows: the picture's right and up and the direction towards the eye, in the base frame."""
        (se, sa), (ce, ca) = np.sin(np.radians(self.angles)), np.cos(np.radians(self.angles))
        return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])

    @property
    def picture(self) -> tuple[float, float]:
        """Width and height of the box as it is seen (length unit)."""
        width, height, _ = np.abs(self.axes) @ self.extent
        return float(width), float(height)

    @property
    def edges(self) -> dict[str, np.ndarray]:
        """The edges of the box that carry labels, each (2, 3), by the name of the axis; none for
        one that points to the eye.
        """
        (x0, x1), (y0, y1), (z0, z1) = self.limits
        if self.angles == _ANGLES["main"]:
            corners = {
                "x": ((x0, y0, z0), (x1, y0, z0)),
                "y": ((x1, y0, z0), (x1, y1, z0)),
                "z": ((x1, y1, z0), (x1, y1, z1)),
            }
        elif self.angles == _ANGLES["top"]:
            corners = {"x": ((x0, y0, z1), (x1, y0, z1)), "y": ((x0, y0, z1), (x0, y1, z1))}
        elif self.name == "front":
            corners = {"x": ((x0, y0, z0), (x1, y0, z0)), "z": ((x0, y0, z0), (x0, y0, z1))}
        else:
            corners = {"y": ((x1, y0, z0), (x1, y1, z0)), "z": ((x1, y0, z0), (x1, y0, z1))}
        return {name: np.array(ends) for name, ends in corners.items()}

    @property
    def margins(self) -> tuple[float, float, float]:
        """Inches beside (left, right) and below the box for its labels."""
        return (0.3, 0.62, 0.46) if self.angles == _ANGLES["main"] else (0.66, 0.2, 0.62)


def set_axes(ax: Any, view: View, share: float) -> None:
    """Set up Axes3D: the view's limits to equal scales, the box seen over `share` of the axes'
    width, ticks and labels.
    """
    ax.computed_zorder = False
    ax.patch.set_visible(False)
    ax.set_proj_type("ortho")
    ax.view_init(*view.angles)
    ax.set(xlim=view.limits[0], ylim=view.limits[1], zlim=view.limits[2])
    _zoom(ax, view, share)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.line.set_color(COLOURS["axis"])
        axis.set_ticks([])
    ax.tick_params(colors=COLOURS["axis"])
    for name, edge in view.edges.items():
        axis, limits = (
            {"x": ax.xaxis, "y": ax.yaxis, "z": ax.zaxis}[name],
            view.limits["xyz".index(name)],
        )
        values = _ticks(limits, float(view.extent.max()))
        axis.set_ticks(values, labels=[""] * len(values))
        _label_edge(
            ax,
            edge,
            (values - limits[0]) / (limits[1] - limits[0]),
            values,
            f"{name} [{view.unit}]",
        )


def _zoom(ax: Any, view: View, share: float) -> None:
    ax.set_box_aspect(view.extent)
    seen = project(ax, np.array(list(product(*view.limits))))
    ax.set_box_aspect(view.extent, zoom=share * float(ax.viewLim.width) / float(np.ptp(seen[:, 0])))


def project(ax: Any, points: np.ndarray) -> np.ndarray:
    """Points (n, 3) on the axes' plane, (n, 2)."""
    seen = np.column_stack([points, np.ones(len(points))]) @ ax.get_proj().T
    return np.asarray(seen[:, :2] / seen[:, 3:])


def _ticks(limits: np.ndarray, largest: float) -> np.ndarray:
    """Round values within the limits, as far apart on all edges, and off the corners, where labels
    would meet.
    """
    from matplotlib.ticker import MaxNLocator

    step = float(np.diff(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]).tick_values(0.0, largest))[0])
    low, high = limits + 0.05 * largest * np.array([1.0, -1.0])
    return step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)


def _label_edge(
    ax: Any, edge: np.ndarray, places: np.ndarray, values: np.ndarray, name: str
) -> None:
    """Write tick values at `places` (0 to 1 along an edge of the box) and the axis's name, on the
    side away from the box.
    """
    start, end = project(ax, edge)
    along = (end - start) / np.linalg.norm(end - start)
    upright = abs(along[0]) < _UPRIGHT
    outward = (
        np.array([math.copysign(1.0, start[0]), 0.0])
        if upright
        else np.array([along[1], -along[0]])
    )
    side = "center" if not upright else "left" if outward[0] > 0.0 else "right"
    texts = [f"{value:g}".replace("-", "\N{MINUS SIGN}") for value in values + 0.0]
    look: dict[str, Any] = {
        "textcoords": "offset points",
        "color": COLOURS["quiet"],
        "annotation_clip": False,
        "va": "center",
    }
    offset = (6.0 if upright else 10.0) * outward
    for place, text in zip(places, texts, strict=True):
        ax.annotate(text, start + place * (end - start), offset, fontsize=7.0, ha=side, **look)
    distance = 15.0 + 4.6 * max(map(len, texts), default=0) if upright else 28.0
    turn = float(np.degrees(np.arctan2(along[1], along[0])))
    ax.annotate(
        name,
        0.5 * (start + end),
        distance * outward,
        fontsize=8.0,
        rotation=turn,
        ha="center",
        **look,
    )
