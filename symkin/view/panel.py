"""One 3-D panel: a skeleton drawn on matplotlib's 3-D axes, nearer parts over farther ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.view.skeleton import Segment, SegmentKind, Skeleton, outline

COLOURS = {
    "text": "#1f2933",
    "quiet": "#52606d",
    "base": "#9aa5b1",
    "base edge": "#616e7c",
    "platform": "#2f7fc1",
    "platform edge": "#1b5a91",
    "link": "#3e4c59",
    "accent": "#e8743b",
    "grid": "#dde3ea",
    "pane": "#fafbfc",
    "axis": "#9aa5b1",
}
FRAME_COLOURS = ("#c0392b", "#2e8b57", "#2c5fa8")
"""Axes x, y, z of a frame."""
STYLE = {
    "font.family": "DejaVu Sans",
    "grid.color": COLOURS["grid"],
    "grid.linewidth": 0.6,
    "axes3d.xaxis.panecolor": COLOURS["pane"],
    "axes3d.yaxis.panecolor": COLOURS["pane"],
    "axes3d.zaxis.panecolor": COLOURS["pane"],
    "axes.edgecolor": COLOURS["axis"],
    "savefig.bbox": None,
    "text.usetex": False,
}
"""Matplotlib settings under which a figure is made and saved."""

_FLAT = 1e-6
"""Extent (of the largest) below which a mechanism is flat and is seen from above."""
_THINNEST = 0.4
"""Least extent of the box in any direction, of the largest."""
_LINES: dict[SegmentKind, tuple[tuple[float, str], ...]] = {
    "link": ((2.6, COLOURS["link"]),),
    "rod": ((1.8, COLOURS["link"]),),
    "slide": ((6.0, "#b8c2cc"), (1.4, COLOURS["link"])),
    "actuated slide": ((6.0, "#f5c3a7"), (1.8, COLOURS["accent"])),
}
"""Widths (points) and colours of each kind of segment, lowest first."""


@dataclass(frozen=True, eq=False)
class View:
    """What all panels share: limits (3, 2) in `unit`, and whether the mechanism is flat (drawn seen from above)."""

    limits: np.ndarray
    unit: str
    flat: bool

    @staticmethod
    def around(bodies: Sequence[Skeleton], unit: str) -> View:
        """The box that holds every body, with a margin and no side too thin."""
        points = np.vstack([body.points for body in bodies])
        low, high = points.min(axis=0), points.max(axis=0)
        largest = float(max(high - low)) or 1.0
        flat = bool(high[2] - low[2] < _FLAT * largest)
        extent = np.maximum(high - low, _THINNEST * largest) + 0.08 * largest
        middle = 0.5 * (low + high)
        return View(np.column_stack([middle - 0.5 * extent, middle + 0.5 * extent]), unit, flat)

    @property
    def extent(self) -> np.ndarray:
        return np.asarray(self.limits[:, 1] - self.limits[:, 0])

    @property
    def angles(self) -> tuple[float, float]:
        """Elevation and azimuth of the eye, degrees."""
        return (90.0, -90.0) if self.flat else (21.0, -57.0)

    @property
    def towards_eye(self) -> np.ndarray:
        elevation, azimuth = np.radians(self.angles)
        level = np.cos(elevation)
        return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def draw_skeleton(ax: Any, body: Skeleton, view: View, scale: float = 1.0) -> None:
    """Draw one configuration on Axes3D; `scale` multiplies line widths and dots."""
    _set_axes(ax, view, scale)
    painter = _Painter(ax, view, scale)
    painter.plate(body.base, "base", hub=None)
    if not body.serial:
        painter.plate(body.platform, "platform", hub=np.asarray(body.pose.position))
    for segment in _segments(body):
        painter.segment(segment)
    painter.dots([dot.point for limb in body.limbs for dot in limb.dots], [d.actuated for limb in body.limbs for d in limb.dots])
    painter.frame(np.zeros(3), np.eye(3), 0.12)
    painter.frame(np.asarray(body.pose.position), np.asarray(body.pose.rotation), 0.2 if body.serial else 0.12)


def _segments(body: Skeleton) -> Iterator[Segment]:
    for limb in body.limbs:
        yield from limb.segments
        yield from limb.rods


def legend_handles(bodies: Sequence[Skeleton]) -> list[Any]:
    """Legend entries for the kinds of parts that are drawn."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    limbs = [limb for body in bodies for limb in body.limbs]
    handles: list[Any] = []
    for name in () if bodies[0].serial else ("base", "platform"):
        handles.append(Patch(facecolor=COLOURS[name], edgecolor=COLOURS[f"{name} edge"], alpha=0.5, label=name))
    for drives, name in ((True, "actuated joint"), (False, "passive joint")):
        if any(dot.actuated == drives for limb in limbs for dot in limb.dots):
            handles.append(Line2D([], [], linestyle="none", label=name, **_dot_style(drives, 1.0)))
    for kind, name in (("actuated slide", "actuated length"), ("slide", "passive slide")):
        if any(segment.kind == kind for limb in limbs for segment in limb.segments):
            lines = [Line2D([], [], linewidth=width, color=colour) for width, colour in _LINES[kind]]
            handles.append(lines[0])
            lines[0].set_label(name)
    return handles


def _dot_style(drives: bool, scale: float) -> dict[str, Any]:
    return {
        "marker": "o",
        "markersize": (6.2 if drives else 4.6) * scale,
        "markerfacecolor": COLOURS["accent"] if drives else "white",
        "markeredgecolor": COLOURS["link"],
        "markeredgewidth": 1.1 * scale,
    }


class _Painter:
    """Puts lines, plates and dots on Axes3D with a z-order by their distance from the eye."""

    def __init__(self, ax: Any, view: View, scale: float) -> None:
        self.ax, self.view, self.scale = ax, view, scale
        self.largest = float(view.extent.max())

    def order(self, points: np.ndarray, lift: float = 0.0) -> float:
        """Matplotlib z-order of an artist about the mean of `points`; `lift` brings it nearer (of the box)."""
        return 10.0 + float(np.mean(np.atleast_2d(points), axis=0) @ self.view.towards_eye) / self.largest + lift

    def segment(self, segment: Segment) -> None:
        if segment.length > 1e-6 * self.largest:
            for k, (width, colour) in enumerate(_LINES[segment.kind]):
                self.line(segment.start, segment.end, width, colour, 0.01 * k)

    def line(self, start: np.ndarray, end: np.ndarray, width: float, colour: str, lift: float = 0.0) -> None:
        both = np.array([start, end])
        self.ax.plot(
            *both.T, color=colour, linewidth=width * self.scale, solid_capstyle="round", zorder=self.order(both, lift)
        )  # fmt: skip

    def dots(self, points: Sequence[np.ndarray], actuated: Sequence[bool]) -> None:
        for point, drives in sorted(zip(points, actuated, strict=True), key=lambda pair: pair[1]):
            self.ax.plot(
                *point[:, None], linestyle="none", zorder=self.order(point, 0.06 if drives else 0.05),
                **_dot_style(drives, self.scale),
            )  # fmt: skip

    def plate(self, points: np.ndarray, name: str, hub: np.ndarray | None) -> None:
        """The body through `points`: a polygon, or lines to its `hub` where the points lie on a line."""
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        corners = outline(points)
        if len(corners) >= 3:
            face = Poly3DCollection(
                [corners], facecolor=COLOURS[name], edgecolor=COLOURS[f"{name} edge"], linewidth=1.3 * self.scale,
                alpha=0.38, zorder=self.order(corners),
            )  # fmt: skip
            self.ax.add_collection3d(face)
            return
        spokes = [(corner, hub) for corner in corners] if hub is not None else list(zip(corners[:-1], corners[1:], strict=True))
        for start, end in spokes:
            self.line(start, end, 3.2, COLOURS[f"{name} edge"])

    def frame(self, origin: np.ndarray, rotation: np.ndarray, length: float) -> None:
        for axis, colour in zip(rotation.T, FRAME_COLOURS, strict=True):
            self.line(origin, origin + length * self.largest * axis, 1.4, colour, 0.02)


def _set_axes(ax: Any, view: View, scale: float) -> None:
    """Equal axes with shared limits, few ticks and labels with the unit."""
    from matplotlib.ticker import MaxNLocator

    ax.computed_zorder = False
    ax.set_proj_type("ortho")
    ax.view_init(*view.angles)
    ax.set(xlim=view.limits[0], ylim=view.limits[1], zlim=view.limits[2])
    ax.set_box_aspect(view.extent, zoom=1.3 if view.flat else 1.0)
    ax.tick_params(labelsize=7.0, pad=-1.0, colors=COLOURS["quiet"])
    for axis, name, extent in zip((ax.xaxis, ax.yaxis, ax.zaxis), "xyz", view.extent, strict=True):
        axis.set_major_locator(MaxNLocator(max(2, round(4 * extent / view.extent.max()))))
        axis.set_label_text(f"{name} ({view.unit})", fontsize=8.0, color=COLOURS["quiet"])
        axis.labelpad = -3.0
        axis.line.set_color(COLOURS["axis"])
    if view.flat:
        ax.set_zticks([])
        ax.set_zlabel("")
