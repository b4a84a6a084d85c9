"""Draw one configuration of a graph of links in a picture plane: links as lines and polygons,
joints by their symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.model.joint import BASE
from symkin.plots.configuration_panel import FRAME_COLOURS
from symkin.plots.graph_lines import GraphLines, RodLine
from symkin.plots.joint_symbols import draw_symbol
from symkin.plots.mechanism_lines import outline
from symkin.plots.style import COLOURS

LINK_COLOURS = (
    "#5b7a99",
    "#8a6d3b",
    "#6b8e4e",
    "#8e5572",
    "#4f8a8b",
    "#7a6fa8",
    "#a0614a",
    "#5f6b7a",
)
"""Of links other than the base and the platform's, in turn."""
RING = 0.72
"""Radius over the symbol's length of the ring around a joint that closes a loop."""
_SAME = 1e-6
_NEAR = 0.2
"""Share of a symbol within which two places are drawn as one."""


@dataclass(eq=False)
class GraphPainter:
    """One configuration on matplotlib's axes: a point p is drawn at shift + scale * (axes p),
    symbols are `symbol` long, lines `width` times as wide as usual; the base frame is drawn with
    `origin`. `strokes` gathers the lines (2, 2) that were drawn, in the units of the axes.
    """

    ax: Any
    lines: GraphLines
    axes: np.ndarray
    planar: bool
    scale: float
    shift: np.ndarray
    symbol: float
    width: float = 1.0
    origin: bool = True

    def __post_init__(self) -> None:
        self.strokes: list[tuple[np.ndarray, np.ndarray]] = []
        self.symbols: list[np.ndarray] = []

    @property
    def size(self) -> float:
        return self.lines.mechanism.characteristic_length

    def seen(self, direction: np.ndarray) -> np.ndarray:
        """A direction in the picture, (2,)."""
        return np.asarray(self.axes[:2] @ direction)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) in the picture (..., 2)."""
        return np.asarray(self.shift + self.scale * (np.asarray(points) @ self.axes[:2].T))

    def depth(self, point: np.ndarray) -> float:
        """Nearness to the eye, over the size, within -1 and 1."""
        return float(np.clip(np.asarray(point) @ self.axes[2] / self.size, -1.0, 1.0))

    def draw(self) -> None:
        """Everything, lowest first."""
        self._base()
        self._couplings()
        for number, (link, points) in enumerate(
            (k, v) for k, v in self.lines.links.items() if k != BASE
        ):
            self._link(link, np.array(points), LINK_COLOURS[number % len(LINK_COLOURS)])
        for start, end in self.lines.rails:
            self._stroke(start, end, 1.0, COLOURS["quiet"], "rail", 4.0)
        for rod in self.lines.rods:
            self._rod(rod)
        for joint in self.lines.joints:
            self._symbol(
                joint.type,
                joint.centre,
                [self.seen(a) for a in joint.axes],
                joint.actuated,
                joint.name,
            )
        for name, point in self.lines.points.items():
            x, y = self.at(point)
            self.ax.plot(
                [x],
                [y],
                marker="D",
                markersize=5.0 * self.width,
                color=COLOURS["text"],
                linestyle="none",
                zorder=15.0,
                gid=f"point {name}",
            )
            self.symbols.append(np.array([x, y, 0.12 * self.symbol]))
        self._frames()

    # --- links ------------------------------------------------------------------------------------

    def _base(self) -> None:
        points = np.array(self.lines.links.get(BASE, np.zeros((0, 3))))
        if not len(points):
            return
        corners = self._corners(points)
        if len(corners) >= 3 and not self.planar:
            self._plate(corners, COLOURS["base"], COLOURS["base edge"], BASE, 1.0, hatch="////")
            points = np.array(
                [
                    p
                    for p in points
                    if np.min(np.linalg.norm(corners - self.at(p), axis=1)) > _NEAR * self.symbol
                ]
            )
        elif len(corners) == 2 and not self.planar:
            self._flat(
                corners[0], corners[1], 1.2, COLOURS["base edge"], BASE, 1.0, (0, (4.0, 2.0))
            )
        for point in np.unique(np.round(points, 9), axis=0) if len(points) else ():
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
            self._flat(
                np.array(start),
                np.array(end),
                1.5 if number == 0 else 0.9,
                COLOURS["base edge"],
                BASE,
                1.0,
            )

    def _link(self, link: str, points: np.ndarray, colour: str) -> None:
        is_platform = link == self.lines.mechanism.platform_link
        colour = COLOURS["platform edge"] if is_platform else colour
        width = 3.4 if is_platform else 2.6
        if is_platform and self.lines.pose is not None:
            points = np.vstack([points, self.lines.pose.position])
        distinct = _distinct(points, _SAME * self.size)
        if len(distinct) < 2:
            return
        if len(distinct) == 2:
            self._stroke(distinct[0], distinct[1], width, colour, f"link {link}", 3.0)
            return
        corners = self._corners(distinct)
        if len(corners) < 3:
            for start, end in pairwise(corners):
                self._flat(
                    start,
                    end,
                    width,
                    colour,
                    f"link {link}",
                    3.0 + 0.5 * self.depth(distinct.mean(axis=0)),
                )
            return
        self._plate(
            corners,
            colour,
            colour,
            f"link {link}",
            2.0 + 0.5 * self.depth(distinct.mean(axis=0)),
            hatch=None,
        )
        for point in self.at(distinct):
            gaps = np.linalg.norm(corners - point, axis=1)
            if gaps.min() > _NEAR * self.symbol:
                self._flat(
                    point, corners[int(np.argmin(gaps))], 0.6 * width, colour, f"link {link}", 3.0
                )

    def _corners(self, points: np.ndarray) -> np.ndarray:
        """The outline of points as they are seen, (k, 2)."""
        flat = self.at(points)
        return outline(flat) if len(flat) >= 3 else flat

    def _plate(
        self, corners: np.ndarray, face: str, edge: str, gid: str, order: float, hatch: str | None
    ) -> None:
        from matplotlib.patches import Polygon

        area = Polygon(
            corners,
            closed=True,
            facecolor=face,
            edgecolor=edge,
            alpha=0.25,
            linewidth=0.0,
            hatch=hatch,
            zorder=order,
            gid=gid,
        )
        self.ax.add_patch(area)
        for start, end in pairwise([*corners, corners[0]]):
            self._flat(
                start,
                end,
                1.2 if gid == BASE else 2.2,
                edge,
                gid,
                order + (0.0 if gid == BASE else 1.0),
            )

    def _rod(self, rod: RodLine) -> None:
        for point in (rod.start, rod.end):
            x, y = self.at(point)
            self.ax.plot(
                [x],
                [y],
                marker="o",
                markersize=5.0 * self.width,
                markerfacecolor="white",
                markeredgecolor=COLOURS["link"],
                markeredgewidth=1.1 * self.width,
                linestyle="none",
                zorder=6.5 + self.depth(point),
                gid=f"rod {rod.name}",
            )
            self.symbols.append(np.array([x, y, 0.12 * self.symbol]))
        self._stroke(rod.start, rod.end, 1.7, COLOURS["link"], f"rod {rod.name}", 4.0)
        if rod.actuated:
            along = rod.end - rod.start
            length = float(np.linalg.norm(along)) or 1.0
            self._symbol(
                "P", 0.5 * (rod.start + rod.end), [self.seen(along / length)], True, rod.name
            )

    def _couplings(self) -> None:
        """Dotted lines between coupled joints; those that share a place have none."""
        for start, end in self.lines.couplings:
            if np.linalg.norm(end - start) > _SAME * self.size:
                self._stroke(start, end, 1.0, COLOURS["accent"], "coupling", 1.5, (0, (1.5, 2.0)))

    # --- joints and frames ------------------------------------------------------------------------

    def _symbol(
        self, kind: Any, centre: np.ndarray, axes: Sequence[np.ndarray], drives: bool, name: str
    ) -> None:
        place = self.at(centre)
        order = 6.0 + self.depth(centre) + (0.5 if drives else 0.0)
        draw_symbol(
            self.ax,
            kind,
            place,
            axes,
            self.symbol,
            actuated=drives,
            label=f"joint {kind} {name}",
            order=order,
        )
        closes = name in self.lines.closing
        self.symbols.append(np.array([*place, (RING if closes else 0.48) * self.symbol]))
        if closes:
            self._ring(place, f"closes a loop: {name}")

    def _ring(self, place: np.ndarray, gid: str) -> None:
        from matplotlib.patches import Circle

        self.ax.add_patch(
            Circle(
                tuple(place),
                RING * self.symbol,
                facecolor="none",
                edgecolor=COLOURS["loop"],
                linewidth=1.3 * self.width,
                zorder=9.0,
                gid=gid,
            )
        )

    def _frames(self) -> None:
        if self.origin:
            self._frame(np.zeros(3), np.eye(3))
        if self.lines.pose is not None:
            self._frame(np.asarray(self.lines.pose.position), np.asarray(self.lines.pose.rotation))

    def _frame(self, origin: np.ndarray, rotation: np.ndarray) -> None:
        start = self.at(origin)
        for axis, colour in zip(rotation.T, FRAME_COLOURS, strict=True):
            seen = self.seen(axis)
            if np.linalg.norm(seen) > 0.1:
                self._flat(start, start + 1.5 * self.symbol * seen, 1.3, colour, "frame", 14.0)

    # --- strokes ----------------------------------------------------------------------------------

    def _stroke(
        self,
        start: np.ndarray,
        end: np.ndarray,
        width: float,
        colour: str,
        gid: str,
        order: float,
        style: Any = "-",
    ) -> None:
        middle = 0.5 * (np.asarray(start) + np.asarray(end))
        self._flat(
            self.at(start),
            self.at(end),
            width,
            colour,
            gid,
            order + 0.5 * self.depth(middle),
            style,
        )

    def _flat(
        self,
        start: np.ndarray,
        end: np.ndarray,
        width: float,
        colour: str,
        gid: str,
        order: float,
        style: Any = "-",
    ) -> None:
        self.ax.plot(
            [start[0], end[0]],
            [start[1], end[1]],
            color=colour,
            linewidth=width * self.width,
            linestyle=style,
            solid_capstyle="round",
            zorder=order,
            gid=gid,
        )
        self.strokes.append((start, end))


def _distinct(points: np.ndarray, near: float) -> np.ndarray:
    """The points (n, 3) that are no nearer to one before them than `near`."""
    kept: list[np.ndarray] = []
    for point in points:
        if all(np.linalg.norm(point - other) > near for other in kept):
            kept.append(point)
    return np.array(kept)
