"""Draw one configuration of a mechanism on matplotlib's 3-D axes, nearer parts over farther ones,
where lines cross too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.plots.crossings import Piece, pieces
from symkin.plots.mechanism_lines import Dot, MechanismLines, Segment, SegmentKind, outline
from symkin.plots.style import COLOURS
from symkin.plots.view3d import View, set_axes
from symkin.singularities.named_screw import NamedScrew

FRAME_COLOURS = ("#c0392b", "#2e8b57", "#2c5fa8")
"""Axes x, y, z of a frame."""
FRAME_LENGTH = 0.1
"""Length of the axes of frames, of the box."""
_EDGE, _REACH = 3.0, 0.03
"""Width (points) that a white edge adds to a line where it passes over another, and half its
length, of the box.
"""
_OVERLAP = 1e-3
"""Share of the box by which pieces of one line overlap, so that no seam is seen."""
_END_ON = 0.999
"""Share of a direction along the line of sight from which on an axis is seen as a point."""
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
    """Draw one configuration on Axes3D; the box takes `share` of the axes' width, `scale`
    multiplies lines and dots.
    """
    set_axes(ax, view, share)
    painter = _Painter(ax, view, scale)
    painter.plate(body.base if body.has_platform else _pad(view), "base", hub=None)
    if body.has_platform:
        painter.plate(body.platform, "platform", hub=np.asarray(body.pose.position))
    painter.segments(list(_segments(body)))
    painter.dots([dot for limb in body.limbs for dot in limb.dots])
    painter.frame(np.zeros(3), np.eye(3))
    painter.frame(np.asarray(body.pose.position), np.asarray(body.pose.rotation))


def _pad(view: View) -> np.ndarray:
    """A serial arm's foot: a polygon about the origin, (24, 3)."""
    angles = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    return (
        0.05
        * float(view.extent.max())
        * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(24)])
    )


def _segments(body: MechanismLines) -> Iterator[Segment]:
    for limb in body.limbs:
        yield from limb.segments
        yield from limb.rods


def draw_twist(ax: Any, twist: NamedScrew, body: MechanismLines, view: View) -> None:
    """Draw a platform motion: its axis through the box (a circle with a dot where it is seen
    end-on), or an arrow at the platform's origin where it is a translation.
    """
    length, point = float(view.extent.max()), twist.point
    if point is None:
        origin = np.asarray(body.pose.position)
        ax.quiver(
            *origin,
            *(0.35 * length * twist.direction),
            zorder=40.0,
            arrow_length_ratio=0.25,
            **_TWIST,
        )
        return
    middle = point + twist.direction * float((view.limits.mean(axis=1) - point) @ twist.direction)
    ends = np.array(
        [middle - 0.5 * length * twist.direction, middle + 0.5 * length * twist.direction]
    )
    ax.plot(*ends.T, linestyle="--", zorder=40.0, **_TWIST)
    if view.flat and abs(twist.direction[2]) > _END_ON:
        for marker, size in (("o", 9.0), (".", 4.0)):
            ax.plot(
                *middle[:, None],
                marker=marker,
                markersize=size,
                fillstyle="none" if marker == "o" else "full",
                zorder=40.0,
                **_TWIST,
            )


def frame_handle() -> Any:
    """What stands for the axes of frames in a legend: three strokes side by side."""
    from matplotlib.lines import Line2D

    return tuple(Line2D([], [], linewidth=1.8, color=colour) for colour in FRAME_COLOURS)


def frame_text(mechanism: Mechanism, named: bool) -> str:
    """What the axes of frames are, for a legend; with the letters of their origins where these are
    named.
    """
    has_frame = mechanism.serial or mechanism.platform_link is not None
    base, other = (
        ("base (O)", f"{mechanism.frame_name} ({mechanism.frame_name[0].upper()})")
        if named
        else ("base", mechanism.frame_name)
    )
    return f"x, y, z of {base} and {other}" if has_frame else f"x, y, z of the {base}"


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
    slides: tuple[tuple[SegmentKind, str], ...] = (
        ("actuated slide", "actuated slide"),
        ("slide", "passive slide"),
    )
    for kind, name in slides:
        if any(segment.kind == kind for limb in limbs for segment in limb.segments):
            entries[name] = tuple(
                Line2D([], [], linewidth=width, color=colour) for width, colour in _LINES[kind]
            )
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
        """Matplotlib z-order of an artist about the mean of `points`; `lift` brings it nearer (of
        the box).
        """
        return (
            10.0
            + float(np.mean(np.atleast_2d(points), axis=0) @ self.view.axes[2]) / self.largest
            + lift
        )

    def segments(self, segments: Sequence[Segment]) -> None:
        """Lines in pieces, so that of two that cross the nearer one is on top, parted by a white
        edge.
        """
        long = [segment for segment in segments if segment.length > 1e-6 * self.largest]
        for piece in pieces([(segment.start, segment.end) for segment in long], self.view.axes):
            self.piece(piece, _LINES[long[piece.number].kind])

    def piece(self, piece: Piece, looks: Sequence[tuple[float, str]]) -> None:
        along = piece.end - piece.start
        along = along / (np.linalg.norm(along) or 1.0) * self.largest
        order = 10.0 + piece.nearness / self.largest
        if piece.over is not None:
            back, ahead = (
                min(_REACH, float(np.linalg.norm(end - piece.over)) / self.largest)
                for end in (piece.start, piece.end)
            )
            edge = piece.over - back * along, piece.over + ahead * along
            self.stroke(*edge, looks[0][0] + _EDGE, "white", order - 0.005, "butt")
        lap = [0.0 if free else _OVERLAP * along for free in piece.free]
        for k, (width, colour) in enumerate(looks):
            cap = "butt" if width > 5.0 or not all(piece.free) else "round"
            self.stroke(
                piece.start - lap[0], piece.end + lap[1], width, colour, order + 0.002 * k, cap
            )

    def line(
        self, start: np.ndarray, end: np.ndarray, width: float, colour: str, lift: float = 0.0
    ) -> None:
        self.stroke(
            start,
            end,
            width,
            colour,
            self.order(np.array([start, end]), lift),
            "butt" if width > 5.0 else "round",
        )

    def stroke(
        self, start: np.ndarray, end: np.ndarray, width: float, colour: str, order: float, cap: str
    ) -> None:
        both = np.array([start, end])
        self.ax.plot(
            *both.T, color=colour, linewidth=width * self.scale, solid_capstyle=cap, zorder=order
        )

    def dots(self, dots: Sequence[Dot]) -> None:
        """Joints lie over all lines; where several share a place, an actuated one covers the
        others.
        """
        for dot in dots:
            style = _dot_style(dot.actuated, self.scale)
            self.ax.plot(
                *dot.point[:, None],
                linestyle="none",
                zorder=self.order(dot.point, 10.05 if dot.actuated else 10.0),
                **style,
            )

    def plate(self, points: np.ndarray, name: str, hub: np.ndarray | None) -> None:
        """The body through `points`: a polygon, or lines to its `hub` where the points lie on a
        line.
        """
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

        corners = outline(points)
        if len(corners) >= 3:
            face = Poly3DCollection(
                [corners],
                facecolor=COLOURS[name],
                edgecolor=COLOURS[f"{name} edge"],
                linewidth=1.3 * self.scale,
                alpha=0.38,
                zorder=self.order(corners, -0.02),
            )
            self.ax.add_collection3d(face)
            return
        spokes = (
            [(corner, hub) for corner in corners] if hub is not None else list(pairwise(corners))
        )
        for start, end in spokes:
            self.line(start, end, 3.2, COLOURS[f"{name} edge"])

    def frame(self, origin: np.ndarray, rotation: np.ndarray) -> None:
        for axis, colour in zip(rotation.T, FRAME_COLOURS, strict=True):
            self.line(origin, origin + FRAME_LENGTH * self.largest * axis, 1.4, colour, 0.02)
