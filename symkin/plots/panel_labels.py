"""Names in a 3-D panel: joints, limbs, links and frames beside what they name, none over
another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.model.mechanism import Mechanism
from symkin.plots.label_placement import Box, Label, Page
from symkin.plots.mechanism_lines import MechanismLines
from symkin.plots.picture_options import Names
from symkin.plots.sheet import direction, outlined
from symkin.plots.style import COLOURS
from symkin.plots.view3d import View, project

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FONT = 7.5
"""Size of names in points."""
_DOT = 0.05
"""Half side of a joint's dot, inches."""
_LEADER = 0.1
"""Inches between a name and what it names beyond which a line joins them."""


@dataclass(frozen=True, eq=False)
class _Name:
    """A text for the point (3,) and how it looks."""

    text: str
    point: np.ndarray
    look: dict[str, Any] = field(default_factory=lambda: {"color": COLOURS["text"]})


@dataclass(frozen=True, eq=False)
class PanelLabels:
    """Names in the panel of `ax`, whose lower left corner is `corner` and whose sides are `sides`,
    in inches of `figure`.
    """

    figure: Figure
    ax: Any
    view: View
    corner: tuple[float, float]
    sides: tuple[float, float]

    def draw(self, mechanism: Mechanism, body: MechanismLines, names: Names) -> None:
        """Write what is to be named at one configuration."""
        if names == "none":
            return
        page = self._page(body)
        middle = np.mean(self._seen(body.points), axis=0)
        wanted = [
            (name, self._seen(name.point[None])[0]) for name in _wanted(mechanism, body, names)
        ]
        for name, anchor in wanted:
            width, height = self._extent(name)
            wish = direction(anchor - middle)
            label = Label(
                name.text,
                (anchor[0], anchor[1]),
                _DOT * self._dpi,
                width,
                height,
                (wish[0], wish[1]),
            )
            self._write(label, page.place(label), page, name.look)

    def _page(self, body: MechanismLines) -> Page:
        """The panel with its lines, joints and the labels of its axes, which names keep clear
        of.
        """
        page = Page(self.sides[0] * self._dpi, self.sides[1] * self._dpi)
        for limb in body.limbs:
            for segment in (*limb.segments, *limb.rods):
                page.add_line(*self._seen(np.array([segment.start, segment.end])))
            for dot in limb.dots:
                x, y = self._seen(dot.point[None])[0]
                page.symbols.append(Box(x, y, _DOT * self._dpi, _DOT * self._dpi))
        renderer = self.figure.canvas.get_renderer()  # type: ignore[attr-defined]
        for text in self.ax.texts:
            extent = text.get_window_extent(renderer)
            x, y = 0.5 * (extent.x0 + extent.x1), 0.5 * (extent.y0 + extent.y1)
            page.placed.append(
                Box(
                    x - self._origin[0],
                    y - self._origin[1],
                    0.5 * extent.width,
                    0.5 * extent.height,
                )
            )
        return page

    @property
    def _dpi(self) -> float:
        return float(self.figure.dpi)

    @property
    def _origin(self) -> np.ndarray:
        return self._dpi * np.array(self.corner)

    def _seen(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in pixels from the panel's corner, (n, 2)."""
        return np.asarray(self.ax.transData.transform(project(self.ax, points)) - self._origin)

    def _extent(self, name: _Name) -> tuple[float, float]:
        text = self.figure.text(0.0, 0.0, name.text, fontsize=_FONT, parse_math=False, **name.look)
        box = text.get_window_extent(self.figure.canvas.get_renderer())  # type: ignore[attr-defined]
        text.remove()
        return float(box.width), float(box.height)

    def _write(self, label: Label, box: Box, page: Page, look: dict[str, Any]) -> None:
        """The text, and a line to what it names where it stands away from it."""
        from matplotlib.lines import Line2D

        pixels = self._dpi * self.figure.get_size_inches()
        anchor, half = np.array(label.anchor), np.array([box.wide, box.high])
        edge = np.clip(anchor, (box.x, box.y) - half, (box.x, box.y) + half)
        if np.linalg.norm(edge - anchor) > label.reach + _LEADER * self._dpi:
            start = anchor + direction(edge - anchor) * label.reach
            page.add_line(start.tolist(), edge.tolist())
            ends = (np.array([start, edge]) + self._origin) / pixels
            line = Line2D(
                *ends.T,
                color=COLOURS["axis"],
                linewidth=0.6,
                transform=self.figure.transFigure,
                gid="leader",
            )
            self.figure.add_artist(line)
        x, y = (self._origin + (box.x, box.y)) / pixels
        self.figure.text(
            x,
            y,
            label.text,
            ha="center",
            va="center",
            fontsize=_FONT,
            parse_math=False,
            gid="label",
            path_effects=outlined(),
            **look,
        )


def _wanted(mechanism: Mechanism, body: MechanismLines, names: Names) -> Iterator[_Name]:
    """All names, frames first."""
    bold = {"color": COLOURS["text"], "fontweight": "bold"}
    origin = np.asarray(body.pose.position)
    same = float(np.linalg.norm(origin)) < 1e-9 * mechanism.characteristic_length
    letter = mechanism.frame_name[0].upper()
    yield _Name(f"O = {letter}" if same else "O", np.zeros(3), bold)
    if not same:
        yield _Name(letter, origin, bold)
    for limb, lines in zip(mechanism.limbs, body.limbs, strict=True):
        if names in ("all", "joints"):
            for joint, place in lines.places.items():
                yield _Name(joint, place)
            if not limb.joints:
                yield _Name(limb.name, 0.5 * (lines.segments[0].start + lines.segments[0].end))
        if names in ("all", "links") and limb.joints and body.has_platform:
            yield _Name(
                limb.name, lines.base, {"color": COLOURS["base edge"], "fontstyle": "italic"}
            )
    if names in ("all", "links"):
        yield _Name(
            "base",
            np.mean(body.base, axis=0),
            {"color": COLOURS["base edge"], "fontstyle": "italic"},
        )
        if body.has_platform:
            yield _Name(
                "platform",
                np.mean(body.platform, axis=0),
                {"color": COLOURS["platform edge"], "fontstyle": "italic"},
            )
