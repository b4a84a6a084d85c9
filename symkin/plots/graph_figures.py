"""Figures of graphs of links: the sketch at the reference configuration with names, and a panel for
each of several modes.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.plots.configuration_panel import FRAME_COLOURS, frame_text
from symkin.plots.graph_labels import draw_labels
from symkin.plots.graph_lines import GraphLines, reference_graph_lines, view_axes
from symkin.plots.graph_painter import GraphPainter
from symkin.plots.joint_symbols import NAMES, draw_symbol
from symkin.plots.label_placement import Page
from symkin.plots.picture_options import Names, ViewName
from symkin.plots.sheet import SHEET_DPI, make_sheet, sheet_axes, symbol_size, text_extent
from symkin.plots.style import COLOURS, drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH, _HEIGHT = 1500.0, 1200.0
"""Pixels of the sketch."""
_TOP, _BOTTOM, _SIDE = 160.0, 110.0, 150.0
"""Pixels above, below and beside what is drawn: title, legend, labels."""
_SYMBOL, _LEAST_SYMBOL = 40.0, 22.0
"""Length of a joint's symbol in pixels, and the least that crowded joints leave of it."""
_SHARE = 0.9
"""What symbols take of the distance of the nearest two, and of their largest length."""
_PANEL, _LARGER = 520.0, {1: 1.6, 2: 1.3}
"""Pixels of the longer side of a panel's drawing, and by what it is larger where panels are as
few.
"""
_PANEL_GAP, _PANEL_TITLE, _PANEL_LINE, _HEAD, _FOOT = 46.0, 44.0, 19.0, 150.0, 90.0
"""Pixels between panels, above each for its title and for a line of its text, and of the figure's
head and foot.
"""
_LEAST_CELL = 380.0
"""Least width of a panel in pixels, for its text."""
_PANEL_NAMES = 0.78
"""Size of names in panels, of those in the sketch."""
_MOST_COLUMNS = 4
_WIDEST = 2200.0
"""Pixels that one row of panels may have."""
_NARROWEST = 1150.0
"""Least width of a figure of panels in pixels, for its title."""
_FAR = 0.5
"""Distance over the size beyond which the base frame's origin is left out of the picture."""
_THIN = 0.12
"""Least extent of a drawing in any direction, of the size."""


@dataclass(frozen=True, eq=False)
class GraphPanel:
    """One configuration: its title, a text below it, and its lines."""

    title: str
    text: str
    lines: GraphLines


def sketch_of_graph(mechanism: Mechanism, names: Names = "all") -> Figure:
    """The graph at the reference configuration with the names of joints, rods and points; a planar
    one is seen along its axes.
    """
    lines = reference_graph_lines(mechanism)
    axes, planar = view_axes(lines)
    with drawing():
        figure, ax = make_sheet(_WIDTH, _HEIGHT)
        room = np.array([_WIDTH - 2 * _SIDE, _HEIGHT - _TOP - _BOTTOM - 0.6 * _SIDE])
        low, high = _extent([lines], axes)
        scale = float(np.min(room / (high - low)))
        centre = np.array([0.5 * _WIDTH, _BOTTOM + 0.5 * (_HEIGHT - _TOP - _BOTTOM)])
        painter = GraphPainter(
            ax,
            lines,
            axes,
            planar,
            scale,
            centre - 0.5 * scale * (low + high),
            _symbol_size(lines, axes, scale, _SYMBOL),
            origin=shows_origin([lines], axes),
        )
        painter.draw()
        unnamed = draw_labels(figure, painter, Page(_WIDTH, _HEIGHT - _TOP), names)
        more = f"; {unnamed} names find no room" if unnamed else ""
        facts = [f"graph at the reference configuration; lengths in {mechanism.length_unit}{more}"]
        _heading(ax, mechanism, facts, _WIDTH, _HEIGHT)
        _legend(figure, ax, [lines], planar, _WIDTH, 0.0, named=names not in ("none", "loops"))
    return figure


def panels_of_graph(
    mechanism: Mechanism,
    panels: Sequence[GraphPanel],
    facts: Sequence[str],
    part: str = "",
    *,
    names: Names = "none",
    views: Sequence[ViewName] = ("main",),
) -> Figure:
    """The panels in rows, to one scale, each seen from the same sides; the mechanism's title, then
    `part`, above the `facts`.
    """
    block = GraphBlock.of(mechanism, panels, names, views)
    width = max(block.pixels[0] + _PANEL_GAP, _NARROWEST)
    head = _HEAD + _PANEL_LINE * max(0, sum(len(_facts_lines(fact, width)) for fact in facts) - 2)
    whole = width, head + block.pixels[1] + _FOOT
    with drawing():
        figure, ax = make_sheet(*whole)
        unnamed = block.paint(figure, ax, 0.5 * whole[0], whole[1] - head)
        more = [f"{unnamed} names find no room; choose fewer modes or names"] if unnamed else []
        _heading(ax, mechanism, [*facts, *more], *whole, part)
        block.paint_legend(figure, ax, whole[0], 0.0)
    return figure


@dataclass(frozen=True, eq=False)
class _Side:
    """One side from which panels are seen: rows right, up and towards the eye, whether planar,
    lower and upper bounds (2,).
    """

    name: ViewName
    axes: np.ndarray
    planar: bool
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, eq=False)
class GraphBlock:
    """Panels of configurations of a graph as a part of a sheet: each panel from each of the sides,
    all to one scale, in cells of `cell` pixels of which `text` are above the drawing.
    """

    mechanism: Mechanism
    panels: Sequence[GraphPanel]
    names: Names
    sides: tuple[_Side, ...]
    columns: int
    scale: float
    cell: tuple[float, float]
    text: float

    @staticmethod
    def of(
        mechanism: Mechanism,
        panels: Sequence[GraphPanel],
        names: Names,
        views: Sequence[ViewName],
        columns: int | None = None,
    ) -> GraphBlock:
        sides = tuple(_side(mechanism, panels, view) for view in views)
        room = _PANEL * _LARGER.get(len(panels) * len(sides), 1.0)
        scale = room / float(max(np.max(side.high - side.low) for side in sides))
        width, height = (
            scale * max(float((side.high - side.low)[k]) for side in sides) for k in range(2)
        )
        cell_wide = max(width, _LEAST_CELL) + _PANEL_GAP
        across = columns or _columns(len(panels), len(sides), cell_wide)
        text = _PANEL_TITLE + _PANEL_LINE * max(
            len(_wrapped(panel.text, cell_wide)) for panel in panels
        )
        return GraphBlock(
            mechanism,
            panels,
            names,
            sides,
            across,
            scale,
            (cell_wide, height + text + _PANEL_GAP),
            text,
        )

    @property
    def pixels(self) -> tuple[float, float]:
        """Width and height."""
        return self.columns * self.cell[0], math.ceil(
            len(self.panels) * len(self.sides) / self.columns
        ) * self.cell[1]

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in inches."""
        return self.pixels[0] / SHEET_DPI, self.pixels[1] / SHEET_DPI

    def draw(self, figure: Figure, middle: float, top: float) -> None:
        """Draw the panels below `top` about `middle`, in inches from the lower left corner of a
        figure that is no sheet yet.
        """
        self.paint(figure, sheet_axes(figure), SHEET_DPI * middle, SHEET_DPI * top)

    def draw_legend(self, figure: Figure, foot: float) -> None:
        """The legend `foot` inches above the lower edge of a figure that is no sheet yet."""
        self.paint_legend(
            figure, sheet_axes(figure), SHEET_DPI * figure.get_figwidth(), SHEET_DPI * foot
        )

    def paint(self, figure: Any, ax: Any, middle: float, top: float) -> int:
        """Draw on a sheet, in pixels. How many names find no room."""
        cells = [(panel, side) for panel in self.panels for side in self.sides]
        unnamed = 0
        for k, (panel, side) in enumerate(cells):
            row, column = divmod(k, self.columns)
            x = middle + (column + 0.5 - 0.5 * self.columns) * self.cell[0]
            unnamed += self._panel(figure, ax, panel, side, x, top - row * self.cell[1])
        return unnamed

    def _panel(
        self, figure: Any, ax: Any, panel: GraphPanel, side: _Side, x: float, top: float
    ) -> int:
        centre = np.array([x, top - self.text - 0.5 * (self.cell[1] - self.text - _PANEL_GAP)])
        shift = centre - 0.5 * self.scale * (side.low + side.high)
        symbol = min(_symbol_size(panel.lines, side.axes, self.scale, 26.0, 14.0), 26.0)
        origin = shows_origin([panel.lines for panel in self.panels], side.axes)
        painter = GraphPainter(
            ax, panel.lines, side.axes, side.planar, self.scale, shift, symbol, 0.8, origin
        )
        painter.draw()
        seen = _SIDE_TITLES[side.name] if len(self.sides) > 1 else ""
        _write(
            ax,
            x,
            top,
            ", ".join(part for part in (panel.title, seen) if part),
            fontsize=10.5,
            fontweight="bold",
        )
        if side is self.sides[0]:
            _write(
                ax,
                x,
                top - 26.0,
                "\n".join(_wrapped(panel.text, self.cell[0])),
                fontsize=8.0,
                color=COLOURS["quiet"],
            )
        page = Page(
            self.cell[0],
            self.cell[1] - self.text,
            left=x - 0.5 * self.cell[0],
            foot=top - self.cell[1],
        )
        return draw_labels(figure, painter, page, self.names, _PANEL_NAMES)

    def paint_legend(self, figure: Any, ax: Any, width: float, foot: float) -> None:
        _legend(
            figure,
            ax,
            [panel.lines for panel in self.panels],
            self.sides[0].planar,
            width,
            foot,
            named=self.names not in ("none", "loops"),
        )


def _side(mechanism: Mechanism, panels: Sequence[GraphPanel], name: ViewName) -> _Side:
    axes, planar = view_axes(reference_graph_lines(mechanism))
    if name != "main":
        normal, axes = axes[2], _SIDES[name]
        planar = planar and abs(float(normal @ axes[2])) > 1.0 - 1e-9
    return _Side(name, axes, planar, *_extent([panel.lines for panel in panels], axes))


_SIDES: dict[ViewName, np.ndarray] = {
    "top": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "front": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "side": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
}
"""Rows right, up and towards the eye."""
_SIDE_TITLES: dict[ViewName, str] = {
    "main": "main view",
    "top": "from above",
    "front": "from the front",
    "side": "from the side",
}
"""Titles of panels where a configuration is seen from several sides."""


def _wrapped(text: str, width: float) -> list[str]:
    """The lines of a panel's text, of `width` pixels."""
    return [
        part for line in text.split("\n") for part in textwrap.wrap(line, int(width / 9.6)) or [""]
    ]


def _columns(count: int, sides: int, cell: float) -> int:
    """Columns of panels: all in a row where they are few and narrow, else rows as even as can be;
    the sides of one configuration stand in one row.
    """
    if count * sides <= _MOST_COLUMNS and count * sides * cell <= _WIDEST:
        return count * sides
    if sides > 1:
        return sides * max(1, min(_MOST_COLUMNS // sides, round(math.sqrt(count))))
    rows = math.ceil(count / min(_MOST_COLUMNS, max(1, math.ceil(math.sqrt(1.6 * count)))))
    return math.ceil(count / rows)


def _extent(bodies: Sequence[GraphLines], axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (2,) in the picture, no side too thin; the base frame's origin within
    where it is near.
    """
    size = bodies[0].mechanism.characteristic_length
    points = [body.all_points for body in bodies]
    points += [np.atleast_2d(body.pose.position) for body in bodies if body.pose is not None]
    flat = np.vstack(points) @ axes[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    if shows_origin(bodies, axes):
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    lacking = np.maximum(_THIN * size - (high - low), 0.0)
    return low - 0.5 * lacking - 0.03 * size, high + 0.5 * lacking + 0.03 * size


def shows_origin(bodies: Sequence[GraphLines], axes: np.ndarray) -> bool:
    """Whether the base frame's origin is near enough to what is drawn to be in the picture."""
    flat = np.vstack([body.all_points for body in bodies]) @ axes[:2].T
    away = np.maximum(np.maximum(flat.min(axis=0), -flat.max(axis=0)), 0.0)
    return float(np.linalg.norm(away)) < _FAR * bodies[0].mechanism.characteristic_length


def _symbol_size(
    lines: GraphLines, axes: np.ndarray, scale: float, most: float, least: float = _LEAST_SYMBOL
) -> float:
    """Pixels: what the distance of the nearest two symbols that are apart leaves, within bounds."""
    if not lines.joints:
        return most
    return symbol_size(
        scale * np.array([joint.centre for joint in lines.joints]) @ axes[:2].T,
        _SHARE,
        least,
        _SHARE * most,
    )


# --- texts ----------------------------------------------------------------------------------------


def _heading(
    ax: Any, mechanism: Mechanism, facts: Sequence[str], width: float, height: float, part: str = ""
) -> None:
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    room = int(width / 17)
    shortened = (
        title
        if len(title) + len(part) <= room
        else title[: room - len(part) - 1].rstrip() + "\N{HORIZONTAL ELLIPSIS}"
    )
    _write(ax, 0.5 * width, height - 22.0, shortened + part, fontsize=14.0, fontweight="bold")
    lines = "\n".join(line for fact in facts for line in _facts_lines(fact, width))
    _write(
        ax,
        0.5 * width,
        height - 62.0,
        lines,
        fontsize=9.0,
        color=COLOURS["quiet"],
        linespacing=1.35,
    )


def _facts_lines(fact: str, width: float) -> list[str]:
    """The lines of a fact in the heading of a sheet of `width` pixels."""
    return textwrap.wrap(fact, int(width / 11.5))


def _legend(
    figure: Any,
    ax: Any,
    bodies: Sequence[GraphLines],
    planar: bool,
    width: float,
    foot: float,
    *,
    named: bool,
) -> None:
    """Symbols of the joint types that are drawn, of rods, of the platform's link, of couplings and
    of frames, in a row or two.
    """
    lines = bodies[0]
    kinds = [kind for kind in NAMES if any(joint.type == kind for joint in lines.joints)]
    entries: list[tuple[str, Any]] = [(NAMES[kind], (kind, False)) for kind in kinds]
    if any(joint.actuated for joint in lines.joints) or any(rod.actuated for rod in lines.rods):
        kind = next((joint.type for joint in lines.joints if joint.actuated), "P")
        entries.append(("actuated", (kind, True)))
    strokes = (
        (
            "rod",
            any(not rod.actuated for rod in lines.rods),
            {
                "color": COLOURS["link"],
                "linewidth": 1.7,
                "marker": "o",
                "markersize": 4.5,
                "markerfacecolor": "white",
            },
        ),
        (
            "link of the platform frame",
            lines.pose is not None,
            {"color": COLOURS["platform edge"], "linewidth": 3.4},
        ),
        (
            "closes a loop, in the file's order",
            bool(lines.closing),
            {
                "color": COLOURS["loop"],
                "marker": "o",
                "markersize": 11.0,
                "markerfacecolor": "none",
                "markeredgewidth": 1.3,
                "linewidth": 0.0,
            },
        ),
        (
            "coupling",
            bool(lines.couplings),
            {"color": COLOURS["accent"], "linewidth": 1.2, "linestyle": (0, (1.5, 2.0))},
        ),
        (
            "point",
            bool(lines.points),
            {"color": COLOURS["text"], "marker": "D", "markersize": 4.5, "linewidth": 0.0},
        ),
    )
    entries += [(name, look) for name, drawn, look in strokes if drawn]
    entries.append((frame_text(lines.mechanism, named), FRAME_COLOURS))
    widths = [text_extent(figure, ax, name, 9.5)[0] for name, _ in entries]
    half = math.ceil(len(entries) / 2)
    one_row = sum(widths) + _ENTRY * len(entries) < width - 20.0
    rows = [slice(0, len(entries))] if one_row else [slice(0, half), slice(half, len(entries))]
    for k, row in enumerate(rows):
        y = foot + 38.0 + 40.0 * (len(rows) - 1 - k)
        x = 0.5 * (width - sum(widths[row]) - _ENTRY * len(widths[row]) + 24.0)
        for (name, look), wide in zip(entries[row], widths[row], strict=True):
            _entry(ax, look, np.array([x, y]), end_on=planar)
            ax.text(
                x + 0.62 * _ENTRY,
                y,
                name,
                ha="left",
                va="center",
                fontsize=9.5,
                color=COLOURS["quiet"],
                parse_math=False,
            )
            x += wide + _ENTRY


_ENTRY = 84.0
"""Pixels of an entry of the legend beside its text."""


def _entry(ax: Any, look: Any, place: np.ndarray, *, end_on: bool) -> None:
    """What stands before a text of the legend: a symbol (type, actuated), the strokes of frames, or
    a line of some look.
    """
    from matplotlib.lines import Line2D

    x, y = place
    if look is FRAME_COLOURS:
        for k, colour in enumerate(FRAME_COLOURS):
            ax.add_line(
                Line2D(
                    [x + 0.17 * k * _ENTRY, x + (0.17 * k + 0.13) * _ENTRY],
                    [y, y],
                    color=colour,
                    linewidth=1.8,
                    zorder=10.0,
                )
            )
        return
    if isinstance(look, dict):
        ends = [x + 0.25 * _ENTRY] if look["linewidth"] == 0.0 else [x, x + 0.5 * _ENTRY]
        ax.add_line(Line2D(ends, [y] * len(ends), zorder=10.0, **look))
        return
    kind, drives = look
    axes = [np.zeros(2) if end_on and kind == "R" else np.array([0.94, 0.2]), np.array([-0.3, 0.7])]
    draw_symbol(
        ax,
        kind,
        np.array([x + 0.25 * _ENTRY, y]),
        axes,
        28.0,
        actuated=drives,
        label="legend",
        order=10.0,
    )


def _write(ax: Any, x: float, y: float, text: str, **look: Any) -> None:
    ax.text(
        x,
        y,
        text,
        ha="center",
        va="top",
        parse_math=False,
        zorder=30.0,
        **({"color": COLOURS["text"]} | look),
    )
