"""A figure of several configurations of one mechanism: equal 3-D panels with titles, one heading and one legend."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from symkin.model.mechanism import Mechanism
from symkin.plots.configuration_panel import draw_lines, draw_twist, legend_entries, twist_handle
from symkin.plots.mechanism_lines import MechanismLines
from symkin.plots.style import COLOURS, drawing
from symkin.plots.view3d import View
from symkin.quiet import warnings_ignored
from symkin.singularities.named_screw import NamedScrew

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEAD, _FOOT, _NARROWEST = 1.0, 0.42, 7.4
"""Inches above the panels (figure title) and below them (legend), and the least width of a figure."""


@dataclass(frozen=True, eq=False)
class Panel:
    """One configuration: its title, a text below it, the mechanism's lines, and twists whose axes are drawn."""

    title: str
    text: str
    lines: MechanismLines
    twists: tuple[NamedScrew, ...] = ()


def panel_figure(mechanism: Mechanism, panels: Sequence[Panel], facts: Sequence[str], part: str = "") -> Figure:
    """The panels in rows, to one scale; the mechanism's title, then `part`, above the `facts`, a line each."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    view = View.around([panel.lines for panel in panels], mechanism.length_unit)
    grid = _Grid.for_panels(len(panels), view, max(panel.text.count("\n") for panel in panels) + 1)
    with drawing():
        figure = Figure(figsize=grid.figure_size, facecolor="white")
        FigureCanvasAgg(figure)
        for k, panel in enumerate(panels):
            _draw_panel(figure, grid, k, panel, view)
        _heading(figure, mechanism, facts, part)
        _legend(figure, panels)
    return figure


@dataclass(frozen=True)
class _Grid:
    """Where panels stand, in inches: a title of `title` inches above a box seen `box` = (width, height) large, with
    `margin` = (left, right, bottom) around it for labels."""

    count: int
    columns: int
    width: float
    title: float
    box: tuple[float, float]
    margin: tuple[float, float, float]

    @staticmethod
    def for_panels(count: int, view: View, title_lines: int) -> _Grid:
        columns = count if count <= 3 else math.ceil(math.sqrt(count))
        width = {1: 5.6, 2: 4.6, 3: 3.9}.get(columns, 3.4)
        margin = (0.62, 0.2, 0.62) if view.flat else (0.3, 0.62, 0.42)
        wide, high = view.picture
        scale = min((width - margin[0] - margin[1]) / wide, 1.05 * width / high)
        return _Grid(count, columns, width, 0.38 + 0.17 * title_lines, (scale * wide, scale * high), margin)

    @property
    def height(self) -> float:
        return self.title + self.box[1] + self.margin[2]

    @property
    def figure_size(self) -> tuple[float, float]:
        rows = math.ceil(self.count / self.columns)
        return max(self.columns * self.width, _NARROWEST), _HEAD + rows * self.height + _FOOT

    def place(self, k: int) -> tuple[float, float]:
        """Middle and top of panel k, inches from the figure's lower left corner."""
        row, column = divmod(k, self.columns)
        width, height = self.figure_size
        return 0.5 * width + (column + 0.5 - 0.5 * self.columns) * self.width, height - _HEAD - row * self.height


def _draw_panel(figure: Figure, grid: _Grid, k: int, panel: Panel, view: View) -> None:
    """Panel number k: its title, and below it the axes, a square about the middle of the box as it is seen."""
    width, height = grid.figure_size
    middle, top = grid.place(k)
    centre = middle + 0.5 * (grid.margin[0] - grid.margin[1]), top - grid.title - 0.5 * grid.box[1]
    side = 1.2 * max(grid.box)
    box = ((centre[0] - 0.5 * side) / width, (centre[1] - 0.5 * side) / height, side / width, side / height)
    ax: Any = figure.add_axes(box, projection="3d")
    draw_lines(ax, panel.lines, view, share=grid.box[0] / side, scale=0.8 if grid.columns > 2 else 1.0)
    for twist in panel.twists:
        draw_twist(ax, twist, panel.lines, view)
    _text(figure, middle / width, top - 0.03, panel.title, ha="center", fontsize=10.5, fontweight="bold")
    lines = "\n".join(textwrap.fill(line, int(14 * grid.width)) for line in panel.text.split("\n"))
    _text(figure, middle / width, top - 0.25, lines, ha="center", fontsize=8.5, color=COLOURS["quiet"])


def _heading(figure: Figure, mechanism: Mechanism, facts: Sequence[str], part: str) -> None:
    """The figure's title: the mechanism, then `part`; below it the `facts`, a line each."""
    width, height = figure.get_size_inches()
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    heading = figure.suptitle(
        _shortened(title, int(10 * width) - len(part)) + part, y=1.0 - 0.12 / height, va="top", fontsize=14,
        fontweight="bold", color=COLOURS["text"], parse_math=False,
    )  # fmt: skip
    with warnings_ignored("Glyph .* missing"):
        heading.set_fontsize(14.0 * min(1.0, 0.94 * width * figure.dpi / heading.get_window_extent().width))
    lines = [_shortened(line, int(width * 14)) for line in facts]
    _text(figure, 0.5, height - 0.42, "\n".join(lines), ha="center", fontsize=9.5, color=COLOURS["quiet"])


def _shortened(text: str, room: int) -> str:
    return text if len(text) <= room else text[: room - 1].rstrip() + "\N{HORIZONTAL ELLIPSIS}"


def _legend(figure: Figure, panels: Sequence[Panel]) -> None:
    """One legend at the foot, with an entry for each kind of part that is drawn."""
    entries = legend_entries([panel.lines for panel in panels])
    if any(panel.twists for panel in panels):
        entries["motion that is not held"] = twist_handle()
    figure.legend(
        list(entries.values()), list(entries), loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=7, frameon=False, fontsize=9,
        labelcolor=COLOURS["quiet"], handletextpad=0.8, columnspacing=1.6,
    )  # fmt: skip


def _text(figure: Figure, x: float, y: float, text: str, **look: Any) -> None:
    """Text whose top is `y` inches above the figure's foot, taken as it is (no mathematics)."""
    options: dict[str, Any] = {"va": "top", "linespacing": 1.4, "color": COLOURS["text"], "parse_math": False} | look
    figure.text(x, y / figure.get_figheight(), text, **options)
