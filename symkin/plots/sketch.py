"""The kinematic sketch of a mechanism: axes, joint symbols, links, base and platform, frames with
labels, main dimensions.

Matplotlib is imported only when one is drawn. The figure is laid out in pixels, y upward, so that
texts can be kept apart.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.plots.configuration_panel import FRAME_COLOURS
from symkin.plots.graph_figures import sketch_of_graph
from symkin.plots.joint_symbols import NAMES, draw_symbol, reach_of
from symkin.plots.label_placement import Box, Label, Page
from symkin.plots.mechanism_lines import LimbLines, outline
from symkin.plots.picture_file import check_picture_path, write_picture
from symkin.plots.picture_options import Names, names_from
from symkin.plots.sheet import direction, make_sheet, symbol_size, text_extent
from symkin.plots.sketch_layout import JointMark, Layout, apart, make_layout
from symkin.plots.style import COLOURS, drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.position.close_result import ClosedConfiguration
    from symkin.position.mobility_result import Mobility

_WIDTH, _HEIGHT = 1500.0, 1260.0
"""Pixels of the picture."""
_TOP, _BOTTOM, _SIDE = 150.0, 95.0, 130.0
"""Pixels above, below and beside what is drawn: title, legend, labels."""
_SYMBOL = 46.0
"""Length of a joint's symbol in pixels, and the least that crowded joints leave of it."""
_LEAST_SYMBOL = 26.0
_SHARE = 0.8
"""What symbols take of the distance of the nearest two."""
_FRAME = 85.0
"""Length of the axes of frames in pixels."""
_LEGEND_GAP = 95.0
"""Pixels of an entry of the legend beside its text."""
_AXIS = 1.35
"""Half length of the line along a joint's axis, of its symbol."""
_LINK, _ROD = 2.8, 1.8
"""Widths of links and rods in points."""


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
    """The sketch at the reference configuration with the names of joints and links, or of some; a
    planar mechanism is seen along its axes. Raises InputError for names that are no choice
    (`picture_options.Names`).
    """
    chosen = names_from(names, graph=mechanism.is_graph, mechanism=mechanism.name)
    if mechanism.is_graph:
        return sketch_of_graph(mechanism, chosen)
    with drawing():
        figure, ax = make_sheet(_WIDTH, _HEIGHT)
        sheet = _Sheet.of(figure, ax, make_layout(mechanism))
        sheet.draw_bodies()
        sheet.draw_links()
        sheet.draw_joints()
        sheet.draw_frames()
        sheet.draw_labels(chosen)
        _heading(sheet)
        _legend(sheet)
    return figure


@dataclass(eq=False)
class _Sheet:
    """The page on which one sketch is drawn: `scale` pixels a length unit, `shift` (2,) of the base
    frame's origin, symbols of `symbol` pixels.
    """

    figure: Any
    ax: Any
    layout: Layout
    scale: float
    shift: np.ndarray
    symbol: float
    joints: tuple[JointMark, ...]
    page: Page
    labels: list[tuple[Label, dict[str, Any]]]

    @staticmethod
    def of(figure: Any, ax: Any, layout: Layout) -> _Sheet:
        """Everything within the margins, symbols as large as crowded joints leave room for."""
        room = np.array([_WIDTH - 2 * _SIDE, _HEIGHT - _TOP - _BOTTOM - _SIDE])
        flat = layout.seen(np.vstack([layout.body.points, *(j.centre for j in layout.joints)]))
        low, high = flat.min(axis=0), flat.max(axis=0)
        scale = float(
            np.min(room / np.maximum(high - low, 0.15 * layout.mechanism.characteristic_length))
        )
        shift = np.array(
            [0.5 * _WIDTH, _BOTTOM + 0.5 * (_HEIGHT - _TOP - _BOTTOM)]
        ) - 0.5 * scale * (low + high)
        centres = scale * layout.seen(np.array([joint.centre for joint in layout.joints]))
        symbol = symbol_size(centres, _SHARE, _LEAST_SYMBOL, _SYMBOL)
        joints = apart(layout.joints, layout.mechanism.characteristic_length, 1.05 * symbol / scale)
        page = Page(_WIDTH, _HEIGHT - _TOP - _BOTTOM + 60.0)
        return _Sheet(
            figure=figure,
            ax=ax,
            layout=layout,
            scale=scale,
            shift=shift,
            symbol=symbol,
            joints=joints,
            page=page,
            labels=[],
        )

    def at(self, point: np.ndarray) -> np.ndarray:
        """A point of the base frame, or several, in pixels."""
        return np.asarray(self.shift + self.scale * self.layout.seen(point))

    def depth(self, point: np.ndarray) -> float:
        """Nearness to the eye, over the size: the order in which symbols cover each other."""
        return (
            float(np.asarray(point) @ self.layout.axes[2])
            / self.layout.mechanism.characteristic_length
        )

    # --- bodies and links -------------------------------------------------------------------------

    def draw_bodies(self) -> None:
        body = self.layout.body
        corners = outline(body.base)
        if len(corners) >= 3 and not self.layout.planar:
            self._plate(corners, "base", hatch="////")
        else:
            feet = np.unique(np.round(body.base, 9), axis=0)
            for point in feet:
                self._ground(point)
            if len(feet) == 2:
                self._line(feet[0], feet[1], 0.8, COLOURS["base edge"], "base", 1.0)
        if body.has_platform:
            self._platform(outline(body.platform), np.asarray(body.pose.position))

    def _platform(self, corners: np.ndarray, origin: np.ndarray) -> None:
        if len(corners) >= 3:
            self._plate(corners, "platform", hatch=None)
            return
        for corner in corners:
            if np.linalg.norm(corner - origin) > 1e-9 * self.layout.mechanism.characteristic_length:
                self._line(corner, origin, 5.0, COLOURS["platform edge"], "platform", 2.0)

    def _plate(self, corners: np.ndarray, name: str, hatch: str | None) -> None:
        from matplotlib.patches import Polygon

        flat = self.at(corners)
        area = Polygon(
            flat,
            closed=True,
            facecolor=COLOURS[name],
            edgecolor=COLOURS[f"{name} edge"],
            alpha=0.28,
            linewidth=1.4,
            hatch=hatch,
            zorder=1.0 if name == "base" else 2.0,
            gid=name,
        )
        self.ax.add_patch(area)
        for a, b in pairwise([*flat, flat[0]]):
            self.page.add_line(self._on_page(a), self._on_page(b), step=14.0)

    def _ground(self, point: np.ndarray) -> None:
        """The sign of the fixed link: a line with hatches below a point."""
        x, y = self.at(point) - (0.0, 0.42 * self.symbol)
        wide = 0.8 * self.symbol
        self._stroke([(x - wide, y), (x + wide, y)], 1.6, COLOURS["base edge"], "base", 1.0)
        for k in np.linspace(-0.9, 0.9, 7):
            self._stroke(
                [(x + k * wide, y), (x + k * wide - 9.0, y - 11.0)],
                1.0,
                COLOURS["base edge"],
                "base",
                1.0,
            )
        self.page.symbols.append(Box(*self._on_page((x, y - 5.0)), wide, 8.0))

    def draw_links(self) -> None:
        for limb in self.layout.body.limbs:
            for start, end in pairwise(
                _path(limb, self.joints, self.layout.mechanism.characteristic_length)
            ):
                self._line(start, end, _LINK, COLOURS["link"], f"limb {limb.name}", 3.0)
            for rod in limb.rods:
                width = _ROD if rod.kind == "rod" else _LINK
                self._line(rod.start, rod.end, width, COLOURS["link"], f"limb {limb.name}", 3.0)

    def _line(
        self, start: np.ndarray, end: np.ndarray, width: float, colour: str, gid: str, order: float
    ) -> None:
        a, b = self.at(start), self.at(end)
        self._stroke(
            [a, b], width, colour, gid, order + 0.1 * self.depth(0.5 * (np.asarray(start) + end))
        )
        self.page.add_line(self._on_page(a), self._on_page(b))

    def _stroke(
        self,
        points: Sequence[Any],
        width: float,
        colour: str,
        gid: str,
        order: float,
        style: Any = "-",
    ) -> None:
        rows = np.array(points)
        self.ax.plot(
            rows[:, 0],
            rows[:, 1],
            linestyle=style,
            color=colour,
            linewidth=width,
            solid_capstyle="round",
            zorder=order,
            gid=gid,
        )

    # --- joints -----------------------------------------------------------------------------------

    def draw_joints(self) -> None:
        for joint in self.joints:
            centre, seen = self.at(joint.centre), [self.layout.seen(axis) for axis in joint.axes]
            for axis in seen if joint.type in ("R", "C", "H") else ():
                reach = _AXIS * self.symbol * axis
                self._stroke(
                    [centre - reach, centre + reach],
                    0.8,
                    COLOURS["quiet"],
                    "axis",
                    5.0,
                    (0, (7, 2, 1.5, 2)),
                )
                self.page.add_line(
                    self._on_page(centre - reach), self._on_page(centre + reach), step=8.0
                )
            label, order = f"joint {joint.type} {joint.name}", 6.0 + self.depth(joint.centre)
            draw_symbol(
                self.ax,
                joint.type,
                centre,
                seen,
                self.symbol,
                actuated=joint.actuated,
                label=label,
                order=order,
            )
            self.page.symbols.append(
                Box(*self._on_page(centre), *(self.symbol * reach_of(joint.type, seen)))
            )

    # --- frames -----------------------------------------------------------------------------------

    def draw_frames(self) -> None:
        pose = self.layout.body.pose
        position, rotation = np.asarray(pose.position), np.asarray(pose.rotation)
        name = self.layout.mechanism.frame_name[0].upper()
        same = np.linalg.norm(
            position
        ) < 1e-9 * self.layout.mechanism.characteristic_length and np.allclose(
            rotation, np.eye(3), atol=1e-9
        )
        self._frame(np.zeros(3), np.eye(3), f"O = {name}" if same else "O", "")
        if not same:
            self._frame(position, rotation, name, "'")

    def _frame(self, origin: np.ndarray, rotation: np.ndarray, name: str, mark: str) -> None:
        start = self.at(origin)
        middle = np.zeros(2)
        for axis, letter, colour in zip(rotation.T, "xyz", FRAME_COLOURS, strict=True):
            seen = self.layout.seen(axis)
            if np.linalg.norm(seen) < 0.1:
                continue
            tip = start + _FRAME * seen
            middle += seen
            self._arrow(start, tip, colour)
            self.page.add_line(self._on_page(start), self._on_page(tip))
            self._label(
                letter + mark,
                tip,
                2.0,
                seen / np.linalg.norm(seen),
                10.0,
                colour=colour,
                style="italic",
            )
        away = -middle / (np.linalg.norm(middle) or 1.0)
        self._label(name, start, 8.0, away, 11.0, colour=COLOURS["text"], weight="bold")

    def _arrow(self, start: np.ndarray, tip: np.ndarray, colour: str) -> None:
        look = {
            "arrowstyle": "-|>",
            "color": colour,
            "linewidth": 1.8,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
            "mutation_scale": 11.0,
        }
        self.ax.annotate("", tuple(tip), tuple(start), arrowprops=look, zorder=20.0)

    # --- labels -----------------------------------------------------------------------------------

    def draw_labels(self, names: Names) -> None:
        """Names of joints, limbs and dimensions, after those of frames; then all texts where they
        do not meet.
        """
        middle = np.mean([self.at(joint.centre) for joint in self.joints], axis=0)
        for joint in self.joints if names in ("all", "joints") else ():
            if "." not in joint.name or any(
                joint.name == j.name for _, j in self.layout.mechanism.joints
            ):
                centre = self.at(joint.centre)
                self._label(
                    joint.name,
                    centre,
                    0.42 * self.symbol,
                    direction(centre - middle),
                    9.5,
                    colour=COLOURS["text"],
                )
        for limb, lines in zip(self.layout.mechanism.limbs, self.layout.body.limbs, strict=True):
            if names in ("all", "links") and limb.joints and self.layout.body.has_platform:
                base = self.at(lines.base)
                self._label(
                    limb.name,
                    base,
                    0.5 * self.symbol,
                    direction(base - middle),
                    10.0,
                    colour=COLOURS["base edge"],
                    weight="bold",
                )
        for dimension in self.layout.dimensions:
            look = {"colour": COLOURS["platform edge"], "style": "italic"}
            self._label(
                dimension.text, self.at(dimension.place), 3.0, np.array([0.0, 1.0]), 9.0, **look
            )
        for label, look in self.labels:
            self._write(label, self.page.place(label), look)

    def _label(
        self,
        text: str,
        anchor: np.ndarray,
        reach: float,
        wish: np.ndarray,
        font: float,
        **look: Any,
    ) -> None:
        width, height = self._extent(text, font, look)
        x, y = self._on_page(anchor)
        label = Label(text, (x, y), reach, width, height, (float(wish[0]), float(wish[1])))
        self.labels.append((label, {"fontsize": font, **look}))

    def _extent(self, text: str, font: float, look: dict[str, Any]) -> tuple[float, float]:
        """Width and height of a text in pixels."""
        return text_extent(self.figure, self.ax, text, font, **_words(look))

    def _write(self, label: Label, box: Box, look: dict[str, Any]) -> None:
        look = dict(look)
        x, y = self._off_page((box.x, box.y))
        anchor = np.array(self._off_page(label.anchor))
        edge = np.clip(anchor, (x - box.wide, y - box.high), (x + box.wide, y + box.high))
        if np.linalg.norm(edge - anchor) > label.reach + 16.0:
            start = anchor + direction(edge - anchor) * label.reach
            self._stroke([start, edge], 0.6, COLOURS["axis"], "leader", 19.0)
            self.page.add_line(self._on_page(start), self._on_page(edge))
        self.ax.text(
            x,
            y,
            label.text,
            ha="center",
            va="center",
            fontsize=look.pop("fontsize"),
            zorder=30.0,
            parse_math=False,
            gid="label",
            **_words(look),
        )

    def _on_page(self, point: Any) -> tuple[float, float]:
        return float(point[0]), float(point[1]) - _BOTTOM + 20.0

    def _off_page(self, point: Any) -> tuple[float, float]:
        return float(point[0]), float(point[1]) + _BOTTOM - 20.0


def _words(look: dict[str, Any]) -> dict[str, Any]:
    """Matplotlib's names of a text's look."""
    return {
        {"colour": "color", "weight": "fontweight", "style": "fontstyle"}[key]: value
        for key, value in look.items()
    }


def _path(limb: LimbLines, joints: Sequence[JointMark], size: float) -> list[np.ndarray]:
    """Corners of a limb's links, through the symbols of its joints where these stand apart."""
    drawn = {joint.name: joint.centre for joint in joints}
    path: list[np.ndarray] = []
    for corner in limb.points:
        here = [
            drawn[name]
            for name, place in limb.places.items()
            if np.linalg.norm(place - corner) < 1e-6 * size and name in drawn
        ]
        path += here or [corner]
    return path


# --- title and legend -----------------------------------------------------------------------------


def _heading(sheet: _Sheet) -> None:
    mechanism, layout = sheet.layout.mechanism, sheet.layout
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    sheet.ax.text(
        0.5 * _WIDTH,
        _HEIGHT - 22.0,
        textwrap.shorten(title, 90, placeholder=" ..."),
        ha="center",
        va="top",
        fontsize=14.0,
        fontweight="bold",
        color=COLOURS["text"],
        parse_math=False,
    )
    unit = mechanism.length_unit
    facts = [
        "kinematic sketch at the reference configuration",
        f"lengths in {unit}",
        f"size {mechanism.characteristic_length:.5g} {unit}",
    ]
    text = textwrap.fill("; ".join([*facts, *layout.notes]), 120)
    sheet.ax.text(
        0.5 * _WIDTH,
        _HEIGHT - 62.0,
        text,
        ha="center",
        va="top",
        fontsize=9.5,
        color=COLOURS["quiet"],
        parse_math=False,
        linespacing=1.4,
    )


def _legend(sheet: _Sheet) -> None:
    """Symbols of the joint types that are drawn, and the colour of actuated ones, in a row at the
    foot.
    """
    kinds = [kind for kind in NAMES if any(joint.type == kind for joint in sheet.joints)]
    names = [NAMES[kind] for kind in kinds] + (
        ["actuated"] if any(joint.actuated for joint in sheet.joints) else []
    )
    widths = [sheet._extent(name, 10.0, {})[0] for name in names]
    x = 0.5 * (_WIDTH - sum(widths) - _LEGEND_GAP * len(names) + 30.0)
    along = np.array([0.94, 0.2])
    for k, (name, width) in enumerate(zip(names, widths, strict=True)):
        kind, drives = (
            (kinds[k], False)
            if k < len(kinds)
            else ("P" if "P" in kinds and "R" not in kinds else kinds[0], True)
        )
        end_on = sheet.layout.planar and kind == "R"
        centre, axes = (
            np.array([x + 20.0, 40.0]),
            [np.zeros(2) if end_on else along, np.array([-0.3, 0.7])],
        )
        draw_symbol(sheet.ax, kind, centre, axes, 32.0, actuated=drives, label="legend", order=10.0)
        sheet.ax.text(
            x + 62.0,
            40.0,
            name,
            ha="left",
            va="center",
            fontsize=10.0,
            color=COLOURS["quiet"],
            parse_math=False,
        )
        x += width + _LEGEND_GAP
