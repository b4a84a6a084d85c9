"""Draw one configuration of a mechanism in a picture plane: links as lines and plates, joints by
their symbols, nearer lines over farther ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.drawing.camera import Camera
from symkin.drawing.layout import ORIGIN, JointMark, Layout, LinkMark, RodMark
from symkin.drawing.outline import outline
from symkin.drawing.palette import COLOURS, FRAME_COLOURS
from symkin.model.joint import BASE
from symkin.model.joint_forms import JointType
from symkin.plots.crossings import Piece, pieces
from symkin.plots.joint_symbols import draw_symbol, reach_of
from symkin.singularities.named_screw import NamedScrew
from symkin.spatial.pose import Pose

RING = 0.72
"""Radius over the symbol's length of the ring around a joint that closes a loop."""
_SAME = 1e-6
_NEAR = 0.2
"""Share of a symbol within which two places are drawn as one."""
_ROD_END = 0.7
"""Length of the symbols at a rod's ends, of a joint's."""
_AXIS = 1.35
"""Half length of the line along a joint's axis, of its symbol."""
FRAME, _ARROW = 1.5, 2.1
"""Length of the axes of frames, of a joint's symbol: of strokes, and of arrows."""
_NEAR_EYE = 0.1
"""Sine from the eye's direction below which a frame's axis is not drawn."""
_GAP, _REACH = 3.0, 7.0
"""Width (points) that a white edge adds to a line where it passes over another, and half its length
in pixels.
"""
_LAP = 0.6
"""Pixels by which pieces of one line overlap, so that no seam is seen."""
_SAG = 0.08
"""Height of the arc of a coupling, of its length."""
_MOTION = 3.0
"""Half length of the axis of a platform's motion, of what is drawn at least, in symbols."""

Looks = tuple[tuple[float, str], ...]
_RODS = {False: 1.7, True: 2.4}
"""Widths of rods in points, by whether they are actuated."""
_RAILS: dict[bool, Looks] = {
    False: ((5.0, COLOURS["slide"]), (1.3, COLOURS["link"])),
    True: ((5.0, COLOURS["actuated slide"]), (1.8, COLOURS["accent"])),
}
"""Widths (points) and colours of a slide's rail, lowest first, by whether it is actuated."""


@dataclass(frozen=True, eq=False)
class _Line:
    """A line between two points (3,) that covers others where it is nearer to the eye."""

    start: np.ndarray
    end: np.ndarray
    looks: Looks
    gid: str
    order: float


@dataclass(eq=False)
class Painter:
    """One configuration on matplotlib's axes: a point p is drawn at shift + scale * (axes p),
    symbols are `symbol` long, lines `width` times as wide as usual; the base frame is drawn with
    `origin`, axes of joints and arrows of frames where it is `large`; `colours` are those of links
    and rods by name, in place of the usual ones, and a picture with such colours has no symbols and
    frames. `strokes` gathers the lines (2, 2) that were drawn,
    `symbols` boxes (x, y, half width, half height), in the units of the axes.
    """

    ax: Any
    layout: Layout
    camera: Camera
    scale: float
    shift: np.ndarray
    symbol: float
    width: float = 1.0
    origin: bool = True
    large: bool = False
    colours: dict[str, str] | None = None
    strokes: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    symbols: list[np.ndarray] = field(default_factory=list)
    _lines: list[_Line] = field(default_factory=list)

    def seen(self, direction: np.ndarray) -> np.ndarray:
        """A direction in the picture, (2,)."""
        return self.camera.flat(direction)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture (..., 2)."""
        return self.shift + self.scale * self.camera.flat(points)

    def depth(self, point: np.ndarray) -> float:
        """Nearness to the eye, over the size, within -1 and 1."""
        return float(np.clip(point @ self.camera.axes[2] / self.layout.size, -1.0, 1.0))

    def draw(self) -> None:
        """Everything, lowest first."""
        layout, colours = self.layout, self.colours or {}
        self._couplings()
        for link, mark in layout.links.items():
            if mark.role == "base":
                self._base(mark)
            else:
                usual = "platform edge" if mark.role == "platform" else mark.colour
                self._link(link, mark, colours.get(link, COLOURS.get(usual, usual)))
        for joint in layout.joints:
            if joint.type in "PCH":
                self._line(joint.start, joint.end, _RAILS[joint.actuated], "rail", 4.0)
        for rod in layout.rods:
            width, ink = _RODS[rod.actuated], colours.get(rod.name, COLOURS["link"])
            self._line(rod.start, rod.end, ((width, ink),), f"rod {rod.name}", 4.0)
        self._draw_lines()
        if self.colours is not None:
            self._dots()
            return
        for rod in layout.rods:
            self._rod(rod)
        for joint in layout.joints:
            self._joint(joint)
        for name, (_, point) in layout.points.items():
            self._dot(point, name)
        self._frames()

    # --- links ------------------------------------------------------------------------------------

    def _base(self, mark: LinkMark) -> None:
        """Its plate or line, where it is no plane of the picture, and the sign of the fixed link
        where it stands: at its own origin, or at points that are no corners of its plate.
        """
        column, points, edge = mark.of(ORIGIN), mark.points, COLOURS["base edge"]
        corners = outline(self.at(points))
        if self.camera.planar:
            # two pivots are joined by a line, whose length is told; a slide holds no place of it
            slides = {joint.name for joint in self.layout.joints if joint.type == "P"}
            points = points[[owner != ORIGIN for owner in mark.owners]]
            joined = len(points) == 2 and not slides & set(mark.owners)
            column, corners = column[:0], self.at(points) if joined else corners[:0]
        if len(corners) > 2:
            inner = 0.0 if self.colours is None else 1.2
            points = self._plate(points, corners, COLOURS["base"], edge, BASE, (1.2, inner))
        elif len(corners) == 2:
            style = "-" if len(column) else (0, (4.0, 2.0))
            self._flat(corners[0], corners[1], 1.2, edge, BASE, 1.0, style)
        if len(column) or self.colours is None:
            for point in np.unique(np.round(column if len(column) else points, 9), axis=0):
                self._ground(point)

    def _ground(self, point: np.ndarray) -> None:
        """The sign of the fixed link: a line with hatches below a point."""
        x, y = self.at(point) - (0.0, 0.42 * self.symbol)
        wide, fine = 0.7 * self.symbol, 0.22 * self.symbol
        segments = [((x - wide, y), (x + wide, y))]
        segments += [
            ((x + k * wide, y), (x + k * wide - 0.8 * fine, y - fine))
            for k in np.linspace(-0.9, 0.9, 6)
        ]
        for number, (start, end) in enumerate(segments):
            width = 1.5 if number == 0 else 0.9
            self._flat(np.array(start), np.array(end), width, COLOURS["base edge"], BASE, 1.0)

    def _link(self, link: str, mark: LinkMark, colour: str) -> None:
        """A plate where its outline is seen as one, else its edges."""
        gid, corners = f"link {link}", outline(self.at(mark.points))
        if mark.edges is None and len(corners) > 2:
            points, pose = mark.points, self.layout.pose
            if mark.role == "platform" and pose is not None:
                away = np.linalg.norm(points - pose.position, axis=1)
                points = points[away > _SAME * self.layout.size]
            rim = 2.2 if self.colours is None else 0.8
            self._plate(points, corners, colour, colour, gid, (rim, 1.6))
            return
        width = 3.4 if mark.role == "platform" else 2.6
        body = mark.body(self.layout.size)
        for a, b in body.edges:
            self._line(body.points[a], body.points[b], ((width, colour),), gid, 3.0)

    def _plate(
        self,
        points: np.ndarray,
        corners: np.ndarray,
        face: str,
        edge: str,
        gid: str,
        widths: tuple[float, float],
    ) -> np.ndarray:
        """A plate within `corners` (k, 2), with lines from points within it to the nearest corner;
        `widths` are those of its rim and of these lines. Returns the points within.
        """
        from matplotlib.patches import Polygon

        fixed = gid == BASE
        order = 1.0 if fixed else 2.0 + 0.5 * self.depth(points.mean(axis=0))
        area = Polygon(
            corners,
            closed=True,
            facecolor=face,
            edgecolor=edge,
            alpha=0.25 if self.large else 0.35,
            linewidth=0.0,
            hatch="////" if self.large and fixed else None,
            zorder=order,
            gid=gid,
        )
        self.ax.add_patch(area)
        rim, inner = (order, order) if fixed else (order + 1.0, 3.0)
        for start, end in pairwise([*corners, corners[0]]):
            self._flat(start, end, widths[0], edge, gid, rim)
        gaps = np.linalg.norm(corners[:, None] - self.at(points)[None], axis=2)
        within = gaps.min(axis=0) > _NEAR * self.symbol
        for k in np.flatnonzero(within & (widths[1] > 0.0)):
            nearest = corners[int(np.argmin(gaps[:, k]))]
            self._flat(self.at(points[k]), nearest, widths[1], edge, gid, inner)
        return points[within]

    def _couplings(self) -> None:
        """Dotted arcs between coupled joints, which no link lies on; those that share a place have
        none.
        """
        marks = self.layout.marks
        for names in self.layout.couplings:
            start, end = (marks[name].centre for name in names)
            if np.linalg.norm(end - start) > _SAME * self.layout.size:
                order = 1.5 + 0.5 * self.depth(0.5 * (start + end))
                arc = _arc(self.at(start), self.at(end))
                look: dict[str, Any] = {"linestyle": (0, (1.5, 2.0)), "linewidth": self.width}
                look |= {"color": COLOURS["accent"], "zorder": order}
                self.ax.plot(*arc.T, gid="coupling", **look)
                self.strokes += pairwise(arc)

    # --- joints and frames ------------------------------------------------------------------------

    def _joint(self, mark: JointMark) -> None:
        axes, place = [self.seen(axis) for axis in mark.axes], self.at(mark.centre)
        order = 6.0 + self.depth(mark.centre) + (0.5 if mark.actuated else 0.0)
        turns = mark.type in "RCH"
        end_on = turns and bool(np.linalg.norm(axes[0]) <= _NEAR)
        order += 0.6 * (end_on and self.camera.planar)  # a pin is seen in its slide
        if self.large and turns and not end_on:
            reach = _AXIS * self.symbol * axes[0]
            dashes = (0, (7.0, 2.0, 1.5, 2.0))
            self._flat(place - reach, place + reach, 0.8, COLOURS["quiet"], "axis", 5.0, dashes)
        gid = f"joint {mark.type} {mark.name}"
        self._symbol(mark.type, place, axes, self.symbol, gid, order, drives=mark.actuated)
        if mark.name in self.layout.closing:
            self._ring(place, f"closes a loop: {mark.name}")

    def _rod(self, rod: RodMark) -> None:
        """The joints at its ends, and its slide where it is actuated."""
        along = rod.end - rod.start
        along = along / (float(np.linalg.norm(along)) or 1.0)
        across = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
        across /= float(np.linalg.norm(across)) or 1.0
        axes = [self.seen(across), self.seen(np.cross(along, across))]
        for kind, point in zip(rod.kinds, (rod.start, rod.end), strict=True):
            gid, order = f"joint {kind} {rod.name}.{kind}", 5.5 + self.depth(point)
            self._symbol(kind, self.at(point), axes, _ROD_END * self.symbol, gid, order)
        if rod.actuated:
            gid, order = f"joint P {rod.name}", 6.5 + self.depth(rod.centre)
            seen = [self.seen(along)]
            self._symbol("P", self.at(rod.centre), seen, self.symbol, gid, order, drives=True)

    def _symbol(
        self,
        kind: JointType,
        place: np.ndarray,
        axes: Sequence[np.ndarray],
        size: float,
        gid: str,
        order: float,
        *,
        drives: bool = False,
    ) -> None:
        draw_symbol(self.ax, kind, place, axes, size, actuated=drives, label=gid, order=order)
        self.symbols.append(np.array([*place, *(size * reach_of(kind, axes))]))

    def _ring(self, place: np.ndarray, gid: str) -> None:
        from matplotlib.patches import Circle

        radius = RING * self.symbol
        ring = Circle(
            place.tolist(),
            radius,
            facecolor="none",
            edgecolor=COLOURS["loop"],
            linewidth=1.3 * self.width,
            zorder=9.0,
            gid=gid,
        )
        self.ax.add_patch(ring)
        self.symbols.append(np.array([*place, radius, radius]))

    def _dots(self) -> None:
        """Where joints are, in place of their symbols."""
        places = [mark.centre for mark in self.layout.joints]
        places += [place for rod in self.layout.rods for place in (rod.start, rod.end)]
        style = {"markeredgecolor": COLOURS["link"], "markeredgewidth": 0.6, "zorder": 15.0}
        x, y = self.at(np.array(places)).T
        size = 2.4 * self.width
        self.ax.plot(x, y, "o", markersize=size, markerfacecolor="white", **style)

    def _dot(self, point: np.ndarray, name: str) -> None:
        x, y = self.at(point)
        look = {"color": COLOURS["text"], "zorder": 15.0, "gid": f"point {name}"}
        self.ax.plot([x], [y], "D", markersize=5.0 * self.width, **look)
        self.symbols.append(np.array([x, y, 0.12 * self.symbol, 0.12 * self.symbol]))

    @property
    def frames(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Origins (3,) and rotations (3, 3) of the frames that are drawn."""
        return frames_of(self.layout, base=self.origin)

    def tips(self, origin: np.ndarray, rotation: np.ndarray) -> list[np.ndarray | None]:
        """Where the axes of a frame end in the picture; None of one that points to the eye."""
        length = (_ARROW if self.large else FRAME) * self.symbol
        return [
            self.at(origin) + length * self.seen(axis) if is_seen(self.camera, axis) else None
            for axis in rotation.T
        ]

    def _frames(self) -> None:
        for origin, rotation in self.frames:
            start = self.at(origin)
            for tip, colour in zip(self.tips(origin, rotation), FRAME_COLOURS, strict=True):
                if tip is not None:
                    self._flat(start, tip, 1.3, colour, "frame", 14.0)
                    if self.large:
                        self._arrow(start, tip, colour, 14.0)

    def _arrow(self, start: np.ndarray, tip: np.ndarray, colour: str, order: float) -> None:
        look = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.4, "mutation_scale": 10.0}
        look |= {"shrinkA": 0.0, "shrinkB": 0.0}
        self.ax.annotate("", tuple(tip), tuple(start), arrowprops=look, zorder=order)

    def draw_twist(self, twist: NamedScrew) -> None:
        """A motion of the platform: its axis (a circle with a dot where it points to the eye), or
        an arrow at the platform's origin where it is a translation.
        """
        colour, gid = COLOURS["motion"], "motion"
        points = self.layout.all_points
        extent = float(np.ptp(points, axis=0).max()) or self.layout.size
        if twist.point is None:
            pose = self.layout.pose
            origin = np.zeros(3) if pose is None else np.asarray(pose.position)
            tip = self.at(origin + 0.35 * extent * twist.direction)
            self._arrow(self.at(origin), tip, colour, 16.0)
            return
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        centre = twist.point + twist.direction * float((middle - twist.point) @ twist.direction)
        way = self.seen(twist.direction)
        if np.linalg.norm(way) < 1e-3:
            for marker, size in (("o", 9.0), (".", 4.0)):
                style = {"marker": marker, "markersize": size, "color": colour, "zorder": 16.0}
                fill = "none" if marker == "o" else "full"
                self.ax.plot(*self.at(centre)[:, None], fillstyle=fill, gid=gid, **style)
            return
        reach = max(0.5 * extent * self.scale, _MOTION * self.symbol) * way
        place = self.at(centre)
        self._flat(place - reach, place + reach, 1.8, colour, gid, 16.0, "--")

    # --- lines ------------------------------------------------------------------------------------

    def _line(
        self, start: np.ndarray, end: np.ndarray, looks: Looks, gid: str, order: float
    ) -> None:
        if np.linalg.norm(end - start) > _SAME * self.layout.size:
            self._lines.append(_Line(np.asarray(start), np.asarray(end), looks, gid, order))

    def _draw_lines(self) -> None:
        """Lines in pieces, so that of two that cross the nearer one is on top, parted by a white
        edge.
        """
        ends = [(line.start, line.end) for line in self._lines]
        planar = self.camera.planar
        for piece in pieces(ends, self.camera.axes, whole=planar):
            self._piece(piece, self._lines[piece.number])
        self.strokes += [(self.at(start), self.at(end)) for start, end in ends]

    def _piece(self, piece: Piece, line: _Line) -> None:
        start, end = self.at(piece.start), self.at(piece.end)
        way = end - start
        way = way / (float(np.linalg.norm(way)) or 1.0)
        nearness = float(np.clip(piece.nearness / self.layout.size, -1.0, 1.0))
        # rods and rails are no higher than links, so that depth alone decides where they cross
        order = line.order + 0.5 * nearness if self.camera.planar else 3.5 + 0.5 * nearness
        if piece.over is not None:
            over = self.at(piece.over)
            back, ahead = (min(_REACH, float(np.linalg.norm(p - over))) for p in (start, end))
            width = line.looks[0][0] + _GAP
            ends = over - back * way, over + ahead * way
            self._stroke(*ends, width, "white", "", order - 0.005, cap="butt")
        lap = [0.0 if free else _LAP * way for free in piece.free]
        for k, (width, colour) in enumerate(line.looks):
            cap = "round" if all(piece.free) and width < 5.0 else "butt"
            self._stroke(
                start - lap[0], end + lap[1], width, colour, line.gid, order + 0.002 * k, cap=cap
            )

    def _flat(self, start: np.ndarray, end: np.ndarray, *look: Any) -> None:
        """A stroke that names keep away from."""
        self._stroke(start, end, *look)
        self.strokes.append((start, end))

    def _stroke(
        self,
        start: np.ndarray,
        end: np.ndarray,
        width: float,
        colour: str,
        gid: str,
        order: float,
        style: Any = "-",
        cap: str = "round",
    ) -> None:
        self.ax.plot(
            [start[0], end[0]],
            [start[1], end[1]],
            color=colour,
            linewidth=width * self.width,
            linestyle=style,
            solid_capstyle=cap,
            zorder=order,
            gid=gid or None,
        )


def _arc(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Points (k, 2) of a flat arc."""
    share = np.linspace(0.0, 1.0, 17)[:, None]
    across = np.array([start[1] - end[1], end[0] - start[0]])
    return start + share * (end - start) + _SAG * 4.0 * share * (1.0 - share) * across


def frames_of(layout: Layout, *, base: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Origins (3,) and rotations (3, 3) of the base frame, where it is meant, and of the
    platform's or tool's, where there is one.
    """
    poses = [Pose.identity()] * base + ([] if layout.pose is None else [layout.pose])
    return [(np.asarray(pose.position), np.asarray(pose.rotation)) for pose in poses]


def is_seen(camera: Camera, axis: np.ndarray) -> bool:
    """Whether a frame's axis does not point to the eye."""
    return bool(np.linalg.norm(camera.flat(axis)) > _NEAR_EYE)
