"""A figure of several configurations of one mechanism: equal 3-D panels with titles, one heading
and one legend.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from symkin.model.mechanism import Mechanism
from symkin.plots.configuration_panel import (
    draw_lines,
    draw_twist,
    frame_handle,
    frame_text,
    legend_entries,
    twist_handle,
)
from symkin.plots.mechanism_lines import MechanismLines
from symkin.plots.panel_labels import PanelLabels
from symkin.plots.picture_options import Names, ViewName
from symkin.plots.style import COLOURS, drawing
from symkin.plots.view3d import View
from symkin.quiet import warnings_ignored
from symkin.singularities.named_screw import NamedScrew

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEAD, _FOOT, _NARROWEST = 1.0, 0.62, 7.4
"""Inches above the panels (figure title) and below them (legend), and the least width of a
figure.
"""
_VIEW_TITLES: dict[ViewName, str] = {
    "main": "at an angle",
    "top": "from above",
    "front": "from the front",
    "side": "from the side",
}
"""Titles of panels where a configuration is seen from several sides."""


@dataclass(frozen=True, eq=False)
class Panel:
    """One configuration: its title, a text below it, the mechanism's lines, and twists whose axes
    are drawn.
    """

    title: str
    text: str
    lines: MechanismLines
    twists: tuple[NamedScrew, ...] = ()


def panel_figure(
    mechanism: Mechanism,
    panels: Sequence[Panel],
    facts: Sequence[str],
    part: str = "",
    *,
    names: Names = "none",
    views: Sequence[ViewName] = ("main",),
) -> Figure:
    """The panels in rows, to one scale; the mechanism's title, then `part`, above the `facts`, a
    line each.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    block = PanelBlock.of(mechanism, panels, names, views)
    width, height = max(block.size[0], _NARROWEST), _HEAD + block.size[1] + _FOOT
    with drawing():
        figure = Figure(figsize=(width, height), facecolor="white")
        FigureCanvasAgg(figure)
        block.draw(figure, 0.5 * width, height - _HEAD)
        _heading(figure, mechanism, facts, part)
        block.draw_legend(figure, 0.0)
    return figure


@dataclass(frozen=True, eq=False)
class PanelBlock:
    """Panels of configurations as a part of a figure: each panel from each of the views, all to one
    scale.
    """

    mechanism: Mechanism
    panels: Sequence[Panel]
    names: Names
    views: tuple[View, ...]
    grid: _Grid

    @staticmethod
    def of(
        mechanism: Mechanism,
        panels: Sequence[Panel],
        names: Names,
        views: Sequence[ViewName],
        columns: int | None = None,
    ) -> PanelBlock:
        around = View.around([panel.lines for panel in panels], mechanism.length_unit)
        seen = tuple(around.seen_from(name) for name in views)
        across = columns or _columns(len(panels), len(seen))
        return PanelBlock(mechanism, panels, names, seen, _Grid.for_panels(panels, across, seen))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in inches."""
        return self.grid.size

    def draw(self, figure: Figure, middle: float, top: float) -> None:
        """Draw the panels below `top` about `middle`, in inches from the figure's lower left
        corner.
        """
        cells = [(panel, view) for panel in self.panels for view in self.views]
        for k, (panel, view) in enumerate(cells):
            across, down = self.grid.place(k)
            self._panel(figure, panel, view, middle + across, top - down)

    def _panel(self, figure: Figure, panel: Panel, view: View, middle: float, top: float) -> None:
        """One panel: its title, and below it the axes, a square about the middle of the box as it
        is seen.
        """
        grid, (width, height) = self.grid, figure.get_size_inches()
        centre = (
            middle + 0.5 * (grid.margin[0] - grid.margin[1]),
            top - grid.title - 0.5 * grid.scale * view.picture[1],
        )
        side = 1.2 * max(grid.box)
        box = (
            (centre[0] - 0.5 * side) / width,
            (centre[1] - 0.5 * side) / height,
            side / width,
            side / height,
        )
        ax: Any = figure.add_axes(box, projection="3d")
        share = grid.scale * view.picture[0] / side
        draw_lines(ax, panel.lines, view, share=share, scale=0.8 if grid.columns > 2 else 1.0)
        for twist in panel.twists:
            draw_twist(ax, twist, panel.lines, view)
        self._titles(figure, panel, view, middle / width, top)
        corner, sides = (
            (middle - 0.5 * grid.width, top - grid.height),
            (grid.width, grid.height - grid.title),
        )
        PanelLabels(figure, ax, view, corner, sides).draw(self.mechanism, panel.lines, self.names)

    def _titles(self, figure: Figure, panel: Panel, view: View, x: float, top: float) -> None:
        first = view is self.views[0]
        seen: ViewName = "top" if view.flat and view.name == "main" else view.name
        side = _VIEW_TITLES[seen] if len(self.views) > 1 else ""
        title = ", ".join(part for part in (panel.title, side) if part)
        _text(figure, x, top - 0.03, title, ha="center", fontsize=10.5, fontweight="bold")
        lines = "\n".join(wrapped_lines(panel.text, self.grid.width)) if first else ""
        _text(figure, x, top - 0.25, lines, ha="center", fontsize=8.5, color=COLOURS["quiet"])

    def draw_legend(self, figure: Figure, foot: float) -> None:
        """One legend `foot` inches above the figure's lower edge, with an entry for each kind of
        part that is drawn.
        """
        from matplotlib.legend_handler import HandlerTuple

        entries, frame = legend_entries([panel.lines for panel in self.panels]), frame_handle()
        entries[frame_text(self.mechanism, self.names != "none")] = frame
        if any(panel.twists for panel in self.panels):
            entries["motion that is not held"] = twist_handle()
        for rows in range(1, len(entries) + 1):
            legend = figure.legend(
                list(entries.values()),
                list(entries),
                loc="lower center",
                bbox_to_anchor=(0.5, foot / figure.get_figheight()),
                ncols=math.ceil(len(entries) / rows),
                frameon=False,
                fontsize=9,
                labelcolor=COLOURS["quiet"],
                handletextpad=0.8,
                columnspacing=1.6,
                handler_map={frame: HandlerTuple(ndivide=None, pad=0.2)},
            )
            extent = legend.get_window_extent(figure.canvas.get_renderer())  # type: ignore[attr-defined]
            if extent.width < 0.99 * figure.bbox.width or rows == len(entries):
                return
            legend.remove()


def _columns(panels: int, views: int) -> int:
    """Panels beside each other: as many rows as columns, the views of one configuration in one
    row.
    """
    if views == 1:
        return panels if panels <= 3 else math.ceil(math.sqrt(panels))
    if panels == 1:
        return 2 if views in (2, 4) else 3
    return views * max(1, round(math.sqrt(panels / views)))


def wrapped_lines(text: str, width: float) -> list[str]:
    """The lines of a text below a panel's title, of `width` inches."""
    return [
        part for line in text.split("\n") for part in textwrap.wrap(line, int(15 * width)) or [""]
    ]


@dataclass(frozen=True)
class _Grid:
    """Where panels stand, in inches: a title of `title` inches above a box of `box` = (width,
    height) at most, `scale` inches a length unit, with `margin` = (left, right, bottom) around it
    for labels.
    """

    count: int
    columns: int
    width: float
    title: float
    box: tuple[float, float]
    margin: tuple[float, float, float]
    scale: float

    @staticmethod
    def for_panels(panels: Sequence[Panel], columns: int, views: Sequence[View]) -> _Grid:
        width = {1: 5.6, 2: 4.6, 3: 3.9}.get(columns, 3.4)
        margin = tuple(max(view.margins[k] for view in views) for k in range(3))
        wide, high = (max(view.picture[k] for view in views) for k in range(2))
        scale = min((width - margin[0] - margin[1]) / wide, 1.05 * width / high)
        lines = max(len(wrapped_lines(panel.text, width)) for panel in panels)
        return _Grid(
            len(panels) * len(views),
            columns,
            width,
            0.38 + 0.17 * lines,
            (scale * wide, scale * high),
            (margin[0], margin[1], margin[2]),
            scale,
        )

    @property
    def height(self) -> float:
        return self.title + self.box[1] + self.margin[2]

    @property
    def size(self) -> tuple[float, float]:
        return self.columns * self.width, math.ceil(self.count / self.columns) * self.height

    def place(self, k: int) -> tuple[float, float]:
        """Middle of panel k from the block's middle, and its top below the block's."""
        row, column = divmod(k, self.columns)
        return (column + 0.5 - 0.5 * self.columns) * self.width, row * self.height


def _heading(figure: Figure, mechanism: Mechanism, facts: Sequence[str], part: str) -> None:
    """The figure's title: the mechanism, then `part`; below it the `facts`, a line each."""
    width, height = figure.get_size_inches()
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    heading = figure.suptitle(
        _shortened(title, int(10 * width) - len(part)) + part,
        y=1.0 - 0.12 / height,
        va="top",
        fontsize=14,
        fontweight="bold",
        color=COLOURS["text"],
        parse_math=False,
    )
    with warnings_ignored("Glyph .* missing"):
        heading.set_fontsize(
            14.0 * min(1.0, 0.94 * width * figure.dpi / heading.get_window_extent().width)
        )
    lines = [_shortened(line, int(width * 14)) for line in facts]
    _text(
        figure,
        0.5,
        height - 0.42,
        "\n".join(lines),
        ha="center",
        fontsize=9.5,
        color=COLOURS["quiet"],
    )


def _shortened(text: str, room: int) -> str:
    return text if len(text) <= room else text[: room - 1].rstrip() + "\N{HORIZONTAL ELLIPSIS}"


def _text(figure: Figure, x: float, y: float, text: str, **look: Any) -> None:
    """Text whose top is `y` inches above the figure's foot, taken as it is (no mathematics)."""
    options: dict[str, Any] = {
        "va": "top",
        "linespacing": 1.4,
        "color": COLOURS["text"],
        "parse_math": False,
    } | look
    figure.text(x, y / figure.get_figheight(), text, **options)
