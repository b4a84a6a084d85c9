"""Draw one configuration of a mechanism on matplotlib's 3-D axes, nearer parts over farther ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.plots.mechanism_lines import Dot, MechanismLines, Segment, SegmentKind, outline
from symkin.plots.style import COLOURS
from symkin.plots.view3d import View, set_axes
from symkin.singularities.named_screw import NamedScrew

FRAME_COLOURS = ("#c0392b", "#2e8b57", "#2c5fa8")
"""Axes x, y, z of a frame."""
_FRAME = 0.1
"""Length of the axes of frames, of the box."""
_TWIST: dict[str, Any] = {"color": "#8c2d9c", "linewidth": 1.8}
"""Look of the axes of platform motions."""
_LINES: dict[SegmentKind, tuple[tuple[float, str], ...]] = {
    "link": ((2.6, COLOURS["link"]),),
    "rod": ((1.8, COLOURS["link"]),),
    "slide": ((6.0, "#b8c2cc"), (1.4, COLOURS["link"])),
    "actuated slide": ((6.0, "#f6cdb5"), (2.0, COLOURS["accent"])),
}
"""Widths (points) and colours of each kind of segment, lowest first."""


def draw_lines(ax: Any, body: MechanismLines, view: View, share: float, scale: float = 1.0) -> None:
    """Draw one configuration on Axes3D; the box takes `share` of the axes' width, `scale` multiplies lines and dots."""
    set_axes(ax, view, share)
    painter = _Painter(ax, view, scale)
    painter.plate(body.base if body.has_platform else _pad(view), "base", hub=None)
    if body.has_platform:
        painter.plate(body.platform, "platform", hub=np.asarray(body.pose.position))
    for segment in _segments(body):
        painter.segment(segment)
    painter.dots([dot for limb in body.limbs for dot in limb.dots])
    painter.frame(np.zeros(3), np.eye(3))
    painter.frame(np.asarray(body.pose.position), np.asarray(body.pose.rotation))


def _pad(view: View) -> np.ndarray:
    """A serial arm's foot: a polygon about the origin, (24, 3)."""
    angles = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    return 0.05 * float(view.extent.max()) * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(24)])


def _segments(body: MechanismLines) -> Iterator[Segment]:
    for limb in body.limbs:
        yield from limb.segments
        yield from limb.rods


def draw_twist(ax: Any, twist: NamedScrew, body: MechanismLines, view: View) -> None:
    """Draw a platform motion: its axis through the box, or an arrow at the platform's origin where it is a translation."""
    length, point = float(view.extent.max()), twist.point
    if point is None:
        origin = np.asarray(body.pose.position)
        ax.quiver(*origin, *(0.35 * length * twist.direction), zorder=40.0, arrow_length_ratio=0.25, **_TWIST)
        return
    middle = point + twist.direction * float((view.limits.mean(axis=1) - point) @ twist.direction)
    ends = np.array([middle - 0.5 * length * twist.direction, middle + 0.5 * length * twist.direction])
    ax.plot(*ends.T, linestyle="--", zorder=40.0, **_TWIST)


def twist_handle() -> Any:
    """What stands for platform motions in a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], linestyle="--", **_TWIST)


def legend_entries(bodies: Sequence[MechanismLines]) -> dict[str, Any]:
    """Names and handles for the kinds of parts that are drawn."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    limbs = [limb for body in bodies for limb in body.limbs]
    entries: dict[str, Any] = {}
    for name in ("base", "platform")[: 1 + bodies[0].has_platform]:
        entries[name] = Patch(facecolor=COLOURS[name], edgecolor=COLOURS[f"{name} edge"], alpha=0.5)
    for drives, name in ((True, "actuated joint"), (False, "passive joint")):
        if any(dot.actuated == drives for limb in limbs for dot in limb.dots):
            entries[name] = Line2D([], [], linestyle="none", **_dot_style(drives, 1.0))
    slides: tuple[tuple[SegmentKind, str], ...] = (("actuated slide", "actuated slide"), ("slide", "passive slide"))
    for kind, name in slides:
        if any(segment.kind == kind for limb in limbs for segment in limb.segments):
            entries[name] = tuple(Line2D([], [], linewidth=width, color=colour) for width, colour in _LINES[kind])
    return entries


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
        return 10.0 + float(np.mean(np.atleast_2d(points), axis=0) @ self.view.axes[2]) / self.largest + lift

    def segment(self, segment: Segment) -> None:
        if segment.length > 1e-6 * self.largest:
            for k, (width, colour) in enumerate(_LINES[segment.kind]):
                self.line(segment.start, segment.end, width, colour, 0.01 * k)

    def line(self, start: np.ndarray, end: np.ndarray, width: float, colour: str, lift: float = 0.0) -> None:
        both = np.array([start, end])
        cap = "butt" if width > 5.0 else "round"
        order = self.order(both, lift)
        self.ax.plot(*both.T, color=colour, linewidth=width * self.scale, solid_capstyle=cap, zorder=order)

    def dots(self, dots: Sequence[Dot]) -> None:
        """Joints lie over all lines; where several share a place, an actuated one covers the others."""
        for dot in dots:
            style = _dot_style(dot.actuated, self.scale)
            self.ax.plot(
                *dot.point[:, None], linestyle="none", zorder=self.order(dot.point, 10.05 if dot.actuated else 10.0), **style
            )

    def plate(self, points: np.ndarray, name: str, hub: np.ndarray | None) -> None:
        """The body through `points`: a polygon, or lines to its `hub` where the points lie on a line."""
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

        corners = outline(points)
        if len(corners) >= 3:
            face = Poly3DCollection(
                [corners], facecolor=COLOURS[name], edgecolor=COLOURS[f"{name} edge"], linewidth=1.3 * self.scale,
                alpha=0.38, zorder=self.order(corners, -0.02),
            )  # fmt: skip
            self.ax.add_collection3d(face)
            return
        spokes = [(corner, hub) for corner in corners] if hub is not None else list(pairwise(corners))
        for start, end in spokes:
            self.line(start, end, 3.2, COLOURS[f"{name} edge"])

    def frame(self, origin: np.ndarray, rotation: np.ndarray) -> None:
        for axis, colour in zip(rotation.T, FRAME_COLOURS, strict=True):
            self.line(origin, origin + _FRAME * self.largest * axis, 1.4, colour, 0.02)
