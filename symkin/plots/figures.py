"""Figures of mechanisms: the sketch at the reference configuration with names and lengths, and a
panel for each of several configurations.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.camera import Camera, ViewName
from symkin.drawing.layout import Layout, layout_of
from symkin.drawing.palette import COLOURS
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.plots.label_placement import Page
from symkin.plots.labels import draw_labels, lengths_of
from symkin.plots.legend import draw_legend
from symkin.plots.painter import FRAME, Painter, frames_of
from symkin.plots.picture_options import Names, names_from
from symkin.plots.pictures import check_picture_path, write_picture
from symkin.plots.raised import circle_notes, raised
from symkin.plots.sheet import drawing, make_sheet, symbol_size, text_extent
from symkin.quiet import warnings_ignored
from symkin.singularities.named_screw import NamedScrew

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.position.close_result import ClosedConfiguration
    from symkin.position.mobility_result import Mobility

_WIDTH, _HEIGHT = 1500.0, 1260.0
"""Pixels of the sketch."""
_TOP, _BOTTOM, _SIDE = 150.0, 110.0, 135.0
"""Pixels above, below and beside what is drawn: title, legend, labels."""
_SYMBOL, _LEAST_SYMBOL = 48.0, 22.0
"""Length of a joint's symbol in pixels, and the least that crowded joints leave of it."""
_PANEL_SYMBOL, _LEAST_PANEL_SYMBOL = 26.0, 14.0
"""The same in panels."""
_SHARE = 0.9
"""What symbols take of the distance of the nearest two, and of their largest length."""
_STEP = 1.05
"""Distance between symbols of joints that share a point, over their length."""
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
_TITLE, _LETTER = 14.0, 13.5
"""Points of the heading, where it fits, and pixels a letter of the smallest, of which it is cut."""
_FAR = 0.5
"""Distance over the size beyond which the base frame's origin is left out of the picture."""
_THIN = 0.12
"""Least extent of a drawing in any direction, of the size."""
_SIDE_TITLES: dict[ViewName, str] = {
    "main": "main view",
    "top": "from above",
    "front": "from the front",
    "side": "from the side",
}
"""Titles of panels where a configuration is seen from several sides."""


# --- sketches -------------------------------------------------------------------------------------


def draw_sketch(mechanism: Mechanism, path: Path | str, names: str = "all") -> None:
    """Write the sketch to a file whose suffix is its format. Raises InputError for a file that
    cannot be written, and for names that are no choice.
    """
    target = check_picture_path(path)
    write_picture(figure_of_sketch(mechanism, names), target)


def figure_of_mobility(found: Mobility, *, names: str = "all") -> Figure:
    """The sketch of the mechanism whose mobility was found."""
    return figure_of_sketch(found.closure.mechanism, names)


def figure_of_closed(found: ClosedConfiguration, *, names: str = "all") -> Figure:
    """The sketch of a mechanism at its closed configuration. Raises InputError where nothing
    closes.
    """
    if found.reference is None:
        raise InputError(
            f"plot: {found.mechanism} has no closed configuration to draw, or nothing that moves"
        )
    return figure_of_sketch(found.reference, names)


def figure_of_sketch(mechanism: Mechanism, names: str = "all") -> Figure:
    """The mechanism at its reference configuration with the names of joints and links, or of some;
    a planar one is seen along its axes. Raises InputError for names that are no choice
    (`picture_options.Names`).
    """
    chosen = names_from(names, mechanism)
    layout, notes = raised(layout_of(mechanism))
    camera = Camera.of(layout)
    unit = mechanism.length_unit
    with drawing():
        figure, ax = make_sheet(_WIDTH, _HEIGHT)
        room = np.array([_WIDTH - 2 * _SIDE, _HEIGHT - _TOP - _BOTTOM - 0.6 * _SIDE])
        side = _Side.of([layout], camera)
        scale = float(np.min(room / side.extent))
        centre = np.array([0.5 * _WIDTH, _BOTTOM + 0.5 * (_HEIGHT - _TOP - _BOTTOM)])
        symbol = _symbol_size(layout, camera, scale, _SYMBOL, _LEAST_SYMBOL)
        painter = side.painted(ax, layout, scale, centre, symbol, large=True)
        named = chosen not in ("none", "loops")
        page, lengths = Page(_WIDTH, _HEIGHT - _TOP), lengths_of(layout) if named else {}
        unnamed = draw_labels(painter, page, chosen, lengths=lengths)
        facts = [
            "kinematic sketch at the reference configuration",
            f"lengths in {unit}",
            f"size {mechanism.characteristic_length:.5g} {unit}",
            *notes,
            *circle_notes(layout),
            *([f"{unnamed} names find no room"] if unnamed else []),
        ]
        heading(ax, mechanism, ["; ".join(facts)], _WIDTH, _HEIGHT)
        look = {"named": named, "origin": side.origin}
        draw_legend(ax, [layout], [camera], scale, (_WIDTH, 0.0), **look)
    return figure


# --- panels ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Panel:
    """One configuration: its title, a text below it, its marks, and motions of the platform whose
    axes are drawn.
    """

    title: str
    text: str
    layout: Layout
    twists: tuple[NamedScrew, ...] = ()


def figure_of_panels(
    mechanism: Mechanism,
    panels: Sequence[Panel],
    facts: Sequence[str],
    part: str = "",
    *,
    names: Names = "none",
    views: Sequence[ViewName] = ("main",),
) -> Figure:
    """The panels in rows, to one scale, each seen from the same sides; the mechanism's title, then
    `part`, above the `facts`.
    """
    block = Block.of(mechanism, panels, names, views)
    width = max(block.pixels[0] + _PANEL_GAP, _NARROWEST)
    head = head_of(facts, width)
    whole = width, head + block.pixels[1] + _FOOT
    with drawing():
        figure, ax = make_sheet(*whole)
        unnamed = block.paint(ax, 0.5 * whole[0], whole[1] - head)
        more = [f"{unnamed} names find no room; choose fewer modes or names"] if unnamed else []
        heading(ax, mechanism, [*facts, *more], *whole, part)
        block.paint_legend(ax, whole[0], 0.0)
    return figure


@dataclass(frozen=True, eq=False)
class _Side:
    """One side from which configurations are seen, lower and upper bounds (2,) of what is seen, and
    whether the base frame's origin is near enough to be in the picture.
    """

    camera: Camera
    low: np.ndarray
    high: np.ndarray
    origin: bool

    @staticmethod
    def of(layouts: Sequence[Layout], camera: Camera) -> _Side:
        return _Side(camera, *_extent(layouts, camera), shows_origin(layouts, camera))

    @property
    def extent(self) -> np.ndarray:
        return np.asarray(self.high - self.low)

    def reach_above(self, layout: Layout, scale: float) -> float:
        """Pixels by which frames and symbols of joints reach above the bounds, in panels."""
        marks = self.spread(layout, scale, _PANEL_SYMBOL).joints
        tops = [(mark.centre, _SHARE) for mark in marks]
        for origin, rotation in frames_of(layout, base=self.origin):
            tops.append((origin, FRAME * max(0.0, *self.camera.flat(rotation.T)[:, 1])))
        places = (scale * self.camera.flat(p)[1] + up * _PANEL_SYMBOL for p, up in tops)
        return max([0.0, *(float(place - scale * self.high[1]) for place in places)])

    def spread(self, layout: Layout, scale: float, symbol: float) -> Layout:
        """Joints that share a point stand apart, but along axes that point to the eye."""
        return layout if self.camera.planar else layout.spread(_STEP * (symbol / scale))

    def painted(
        self,
        ax: Any,
        layout: Layout,
        scale: float,
        centre: np.ndarray,
        symbol: float,
        **look: Any,
    ) -> Painter:
        """Draw a configuration about a place of a sheet."""
        drawn = self.spread(layout, scale, symbol)
        shift = centre - 0.5 * scale * (self.low + self.high)
        made = Painter(ax, drawn, self.camera, scale, shift, symbol, origin=self.origin, **look)
        made.draw()
        return made


@dataclass(frozen=True, eq=False)
class Block:
    """Panels of configurations as a part of a sheet: each panel from each of the sides, all to one
    scale, in cells of `cell` pixels of which `text` are above the drawing.
    """

    mechanism: Mechanism
    panels: Sequence[Panel]
    names: Names
    sides: tuple[_Side, ...]
    columns: int
    scale: float
    cell: tuple[float, float]
    text: float

    @staticmethod
    def of(
        mechanism: Mechanism,
        panels: Sequence[Panel],
        names: Names,
        views: Sequence[ViewName],
        columns: int | None = None,
    ) -> Block:
        main, layouts = Camera.of(layout_of(mechanism)), [panel.layout for panel in panels]
        sides = tuple(_Side.of(layouts, main.seen_from(view)) for view in views)
        room = _PANEL * _LARGER.get(len(panels) * len(sides), 1.0)
        largest = np.max([side.extent for side in sides], axis=0)
        scale = room / float(largest.max())
        width, height = map(float, scale * largest)
        cell_wide = max(width, _LEAST_CELL) + _PANEL_GAP
        across = columns or _columns(len(panels), len(sides), cell_wide)
        lines = max(len(_wrapped(panel.text, cell_wide)) for panel in panels)
        over = max(side.reach_above(layout, scale) for side in sides for layout in layouts)
        text = _PANEL_TITLE + _PANEL_LINE * lines + over
        cell = (cell_wide, height + text + _PANEL_GAP)
        return Block(mechanism, panels, names, sides, across, scale, cell, text)

    @property
    def pixels(self) -> tuple[float, float]:
        """Width and height."""
        rows = math.ceil(len(self.panels) * len(self.sides) / self.columns)
        return self.columns * self.cell[0], rows * self.cell[1]

    def paint(self, ax: Any, middle: float, top: float) -> int:
        """Draw on a sheet, in pixels. How many names find no room."""
        cells = [(panel, side) for panel in self.panels for side in self.sides]
        unnamed = 0
        for k, (panel, side) in enumerate(cells):
            row, column = divmod(k, self.columns)
            x = middle + (column + 0.5 - 0.5 * self.columns) * self.cell[0]
            unnamed += self._panel(ax, panel, side, x, top - row * self.cell[1])
        return unnamed

    def _symbol(self, side: _Side) -> float:
        """One size of symbols for all panels: that of most of them."""
        bounds = _PANEL_SYMBOL, _LEAST_PANEL_SYMBOL
        layouts = [panel.layout for panel in self.panels]
        sizes = [_symbol_size(layout, side.camera, self.scale, *bounds) for layout in layouts]
        return float(np.median(sizes))

    def _panel(self, ax: Any, panel: Panel, side: _Side, x: float, top: float) -> int:
        centre = np.array([x, top - self.text - 0.5 * (self.cell[1] - self.text - _PANEL_GAP)])
        symbol = self._symbol(side)
        painter = side.painted(ax, panel.layout, self.scale, centre, symbol, width=0.8)
        for twist in panel.twists:
            painter.draw_twist(twist)
        seen = _SIDE_TITLES[side.camera.name] if len(self.sides) > 1 else ""
        title = ", ".join(part for part in (panel.title, seen) if part)
        _write(ax, x, top, title, fontsize=10.5, fontweight="bold")
        if side is self.sides[0]:
            text = "\n".join(_wrapped(panel.text, self.cell[0]))
            _write(ax, x, top - 26.0, text, fontsize=8.0, color=COLOURS["quiet"])
        wide, high = self.cell
        page = Page(wide, high - self.text, left=x - 0.5 * wide, foot=top - high)
        return draw_labels(painter, page, self.names, _PANEL_NAMES)

    def paint_legend(self, ax: Any, width: float, foot: float) -> None:
        layouts = [panel.layout for panel in self.panels]
        named = self.names not in ("none", "loops")
        look = {
            "named": named,
            "origin": any(side.origin for side in self.sides),
            "twists": any(panel.twists for panel in self.panels),
        }
        cameras = [side.camera for side in self.sides]
        draw_legend(ax, layouts, cameras, self.scale, (width, foot), **look)


def _wrapped(text: str, width: float) -> list[str]:
    """The lines of a panel's text, of `width` pixels; a unit stays beside its values."""
    lines = text.replace(") ", ")\N{NO-BREAK SPACE}").split("\n")
    return [part for line in lines for part in textwrap.wrap(line, int(width / 9.6)) or [""]]


def _columns(count: int, sides: int, cell: float) -> int:
    """Columns of panels: all in a row where they are few and narrow, else rows as even as can be;
    the sides of one of several
    configurations stand in one row.
    """
    if count * sides <= _MOST_COLUMNS and count * sides * cell <= _WIDEST:
        return count * sides
    if count == 1:
        return math.ceil(sides / 2)
    if sides > 1:
        return sides * max(1, min(_MOST_COLUMNS // sides, round(math.sqrt(count))))
    rows = math.ceil(count / min(_MOST_COLUMNS, max(1, math.ceil(math.sqrt(1.6 * count)))))
    return math.ceil(count / rows)


# --- extents --------------------------------------------------------------------------------------


def _extent(layouts: Sequence[Layout], camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (2,) in the picture, no side too thin; the base frame's origin within
    where it is near.
    """
    size = layouts[0].size
    points = [layout.all_points for layout in layouts]
    points += [np.atleast_2d(layout.pose.position) for layout in layouts if layout.pose is not None]
    flat = camera.flat(np.vstack(points))
    low, high = flat.min(axis=0), flat.max(axis=0)
    if shows_origin(layouts, camera):
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    lacking = np.maximum(_THIN * size - (high - low), 0.0)
    return low - 0.5 * lacking - 0.03 * size, high + 0.5 * lacking + 0.03 * size


def shows_origin(layouts: Sequence[Layout], camera: Camera) -> bool:
    """Whether the base frame's origin is near enough to what is drawn to be in the picture."""
    flat = camera.flat(np.vstack([layout.all_points for layout in layouts]))
    away = np.maximum(np.maximum(flat.min(axis=0), -flat.max(axis=0)), 0.0)
    return float(np.linalg.norm(away)) < _FAR * layouts[0].size


def _symbol_size(layout: Layout, camera: Camera, scale: float, most: float, least: float) -> float:
    """Pixels: what the distance of the nearest two symbols that are apart leaves, within bounds."""
    centres = [mark.centre for mark in layout.joints]
    centres += [rod.centre for rod in layout.rods if rod.actuated]
    if not centres:
        return most
    return symbol_size(scale * camera.flat(np.array(centres)), _SHARE, least, _SHARE * most)


# --- texts ----------------------------------------------------------------------------------------


def heading(
    ax: Any, mechanism: Mechanism, facts: Sequence[str], width: float, height: float, part: str = ""
) -> None:
    """Write the mechanism's title, then `part`, at the top of a sheet, and facts below it."""
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    room = int(width / _LETTER) - len(part)
    if len(title) > room:
        title = title[: room - 1].rstrip() + "\N{HORIZONTAL ELLIPSIS}"
    text, bold = title + part, {"fontweight": "bold"}
    with warnings_ignored("Glyph .* missing"):
        wide = text_extent(ax, text, _TITLE, **bold)[0]
    font = _TITLE * min(1.0, 0.94 * width / wide)
    _write(ax, 0.5 * width, height - 22.0, text, fontsize=font, **bold)
    lines = "\n".join(line for fact in facts for line in _facts_lines(fact, width))
    look = {"fontsize": 9.0, "color": COLOURS["quiet"], "linespacing": 1.35}
    _write(ax, 0.5 * width, height - 62.0, lines, **look)


def head_of(facts: Sequence[str], width: float) -> float:
    """Pixels of the heading of a sheet of panels."""
    return _HEAD + _PANEL_LINE * max(0, sum(len(_facts_lines(fact, width)) for fact in facts) - 2)


def _facts_lines(fact: str, width: float) -> list[str]:
    """The lines of a fact in the heading of a sheet of `width` pixels."""
    return textwrap.wrap(fact, int(width / 11.5))


def _write(ax: Any, x: float, y: float, text: str, **look: Any) -> None:
    style = {"ha": "center", "va": "top", "parse_math": False, "zorder": 30.0}
    ax.text(x, y, text, **(style | {"color": COLOURS["text"]} | look))
