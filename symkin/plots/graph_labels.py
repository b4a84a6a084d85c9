"""Names in the sketch of a graph: those of joints that close loops first, then of driven joints,
other joints, points, rods, links.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.model.joint import BASE
from symkin.plots.graph_painter import RING, GraphPainter
from symkin.plots.label_placement import Box, Label, Page
from symkin.plots.picture_options import Names
from symkin.plots.sheet import direction, outlined, text_extent
from symkin.plots.style import COLOURS

_MOST_LINK_NAMES = 16
"""Links whose names are written; beyond, they hide what they name."""
_MOST_AT_ONE_PLACE = 4
"""Names of joints at one place that are written in full."""
_CROWDED = 40
"""Names beyond which a picture is crowded: those that would stand far away or cover a symbol are
left out.
"""
_FARTHEST, _MOST_COST = 70.0, 75.0
"""Pixels between a name and what it names, and what its place may cost, in a crowded picture."""


@dataclass(frozen=True)
class _Name:
    """A text for what lies at `anchor` (2,) with radius `reach`."""

    text: str
    anchor: np.ndarray
    reach: float
    font: float
    look: dict[str, Any]


def draw_labels(
    figure: Any, painter: GraphPainter, page: Page, names: Names = "all", scale: float = 1.0
) -> int:
    """Write names beside what they name, where they do not meet, `scale` times as large as usual.
    How many find no room.
    """
    for start, end in painter.strokes:
        page.add_line(start.tolist(), end.tolist())
    page.symbols += [Box(x, y, reach, reach) for x, y, reach in painter.symbols]
    middle = np.mean(painter.at(painter.lines.all_points), axis=0)
    wanted = list(_wanted(painter, names))
    crowded, left_out = len(wanted) > _CROWDED, 0
    for name in wanted:
        font = scale * name.font
        width, height = text_extent(figure, painter.ax, name.text, font, **name.look)
        wish = direction(name.anchor - middle)
        label = Label(
            name.text,
            (name.anchor[0], name.anchor[1]),
            name.reach,
            width,
            height,
            (wish[0], wish[1]),
        )
        box = page.find(label, _FARTHEST, _MOST_COST) if crowded else page.place(label)
        if box is None:
            left_out += 1
        else:
            _write(painter.ax, page, label, box, {"fontsize": font, **name.look})
    return left_out


def _wanted(painter: GraphPainter, names: Names) -> Iterator[_Name]:
    """All names, the most important first."""
    lines = painter.lines
    if names == "none":
        return
    bold = {"fontweight": "bold"}
    same = (
        lines.pose is not None and float(np.linalg.norm(lines.pose.position)) <= 1e-6 * painter.size
    )
    if painter.origin and not same and names != "loops":
        yield _Name("O", painter.at(np.zeros(3)), 4.0, 10.0, {"color": COLOURS["text"], **bold})
    if lines.pose is not None and names != "loops":
        text = "O = P" if same and painter.origin else "P"
        yield _Name(
            text,
            painter.at(np.asarray(lines.pose.position)),
            4.0,
            10.0,
            {"color": COLOURS["platform edge"], **bold},
        )
    if names != "links":
        yield from _joints(painter, names)
    if names == "loops":
        return
    for name, point in lines.points.items() if names != "joints" else ():
        yield _Name(
            name, painter.at(point), 6.0, 9.0, {"color": COLOURS["text"], "fontstyle": "italic"}
        )
    for rod in lines.rods:
        if names == "joints" and not rod.actuated:
            continue
        reach = 0.4 * painter.symbol if rod.actuated else 4.0
        yield _Name(
            rod.name,
            painter.at(0.5 * (rod.start + rod.end)),
            reach,
            9.0,
            {"color": COLOURS["link"]},
        )
    if names == "links" or (names == "all" and len(lines.links) <= _MOST_LINK_NAMES):
        for link, points in lines.links.items():
            if link != BASE:
                colour = (
                    COLOURS["platform edge"]
                    if link == lines.mechanism.platform_link
                    else COLOURS["quiet"]
                )
                yield _Name(
                    link,
                    painter.at(np.mean(points, axis=0)),
                    2.0,
                    8.5,
                    {"color": colour, "fontstyle": "italic"},
                )


def _joints(painter: GraphPainter, names: Names) -> Iterator[_Name]:
    """Names of joints, those of one place in one text; of two colours where some of them close
    loops.
    """
    closing = painter.lines.closing
    driven = {joint.name for joint in painter.lines.joints if joint.actuated}
    places = _places(painter)
    places.sort(key=lambda entry: (not closing & set(entry[0]), not driven & set(entry[0])))
    for here, place in places:
        loops = [name for name in here if name in closing]
        others = [name for name in here if name not in closing]
        reach = (RING + 0.1 if loops else 0.6) * painter.symbol
        for group, colour in ((loops, "loop"), (others, "text")):
            if group and (names != "loops" or group is loops):
                yield _Name(_joined(group), place, reach, 9.5, {"color": COLOURS[colour]})


def _places(painter: GraphPainter) -> list[tuple[list[str], np.ndarray]]:
    """Places of joints in the picture, with the names of those that share one."""
    found: list[tuple[list[str], np.ndarray]] = []
    for joint in painter.lines.joints:
        place = painter.at(joint.centre)
        names = next((names for names, other in found if np.linalg.norm(place - other) < 3.0), None)
        if names is None:
            found.append(([joint.name], place))
        else:
            names.append(joint.name)
    return found


def _joined(names: list[str]) -> str:
    kept = names if len(names) <= _MOST_AT_ONE_PLACE else names[: _MOST_AT_ONE_PLACE - 1]
    more = f" and {len(names) - len(kept)} more" if len(kept) < len(names) else ""
    return textwrap.fill(", ".join(kept) + more, 40)


def _write(ax: Any, page: Page, label: Label, box: Box, look: dict[str, Any]) -> None:
    """The text, and a line to what it names where it stands away from it."""
    anchor = np.array(label.anchor)
    edge = np.clip(
        anchor, (box.x - box.wide, box.y - box.high), (box.x + box.wide, box.y + box.high)
    )
    if np.linalg.norm(edge - anchor) > label.reach + 16.0:
        start = anchor + direction(edge - anchor) * label.reach
        ax.plot(
            [start[0], edge[0]],
            [start[1], edge[1]],
            color=COLOURS["axis"],
            linewidth=0.6,
            zorder=19.0,
            gid="leader",
        )
        page.add_line(start.tolist(), edge.tolist())
    ax.text(
        box.x,
        box.y,
        label.text,
        ha="center",
        va="center",
        zorder=30.0,
        parse_math=False,
        gid="label",
        path_effects=outlined(),
        **look,
    )
