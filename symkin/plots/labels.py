"""Names in a picture: frames first, then joints that close loops, driven joints, other joints,
points, rods, links, and lengths.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from symkin.drawing.layout import HAND, Layout
from symkin.drawing.outline import grouped
from symkin.drawing.palette import COLOURS, FRAME_COLOURS
from symkin.model.joint import BASE, PLATFORM
from symkin.plots.label_placement import Box, Label, Page
from symkin.plots.painter import RING, Painter
from symkin.plots.picture_options import Names
from symkin.plots.sheet import direction, outlined, text_extent

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
_MOST_LENGTHS = 12
"""Lengths that are written; of more, none is."""
_ONE_PLACE = 3.0
"""Pixels below which joints stand at one place."""
_SHORT, _SAME = 0.01, 1e-6
"""Lengths over the size: below which one is not written, and below which two points are one."""


def draw_labels(
    painter: Painter,
    page: Page,
    names: Names = "all",
    scale: float = 1.0,
    lengths: Mapping[str, np.ndarray] | None = None,
) -> int:
    """Write names beside what they name, and `lengths` at their places (3,), where they do not
    meet, `scale` times as large as usual. How many names find no room.
    """
    for start, end in painter.strokes:
        page.add_line(start.tolist(), end.tolist())
    page.symbols += [Box(*box) for box in painter.symbols]
    middle = np.mean(painter.at(painter.layout.all_points), axis=0)
    wanted = list(_wanted(painter, names))
    crowded, left_out = len(wanted) > _CROWDED, 0
    numbers = list(_lengths(painter, lengths or {}))
    for name in [*wanted, *numbers]:
        font = scale * name.font
        wide, high = text_extent(painter.ax, name.text, font, **name.look)
        wish = direction(name.anchor - middle) if name.wish is None else name.wish
        label = replace(name, font=font, wish=wish, width=wide, height=high)
        box = page.find(label, _FARTHEST, _MOST_COST) if crowded else page.place(label)
        if box is None:
            left_out += name not in numbers
        else:
            _write(painter.ax, page, label, box)
    return left_out


def _wanted(painter: Painter, names: Names) -> Iterator[Label]:
    """All names, the most important first."""
    if names == "none":
        return
    if names != "loops":
        yield from _frames(painter)
    if names != "links":
        yield from _joints(painter, names)
    if names == "loops":
        return
    layout = painter.layout
    for name, (_, point) in layout.points.items() if names != "joints" else ():
        look = {"color": COLOURS["text"], "fontstyle": "italic"}
        yield Label(name, painter.at(point), 6.0, 9.0, look)
    for rod in layout.rods:
        if rod.label and (rod.actuated or names != "joints"):
            reach = 0.4 * painter.symbol if rod.actuated else 4.0
            yield Label(rod.label, painter.at(rod.centre), reach, 9.0, {"color": COLOURS["link"]})
    if names in ("links", "all"):
        yield from _links(painter, names)


def _frames(painter: Painter) -> Iterator[Label]:
    """Letters of frames at their origins, and of arrows at their tips."""
    mechanism, bold = painter.layout.mechanism, {"fontweight": "bold"}
    letter, frames = mechanism.frame_name[0].upper(), painter.frames
    gap = float(np.linalg.norm(frames[0][0] - frames[-1][0])) if frames else 0.0
    together = len(frames) == 2 and gap <= _SAME * painter.layout.size
    for number, (origin, rotation) in enumerate(frames):
        base = painter.origin and number == 0
        text = f"O = {letter}" if together else "O" if base else letter
        colour = COLOURS["text" if base else "platform edge"]
        tips = painter.tips(origin, rotation)
        place = painter.at(origin)
        away = -np.sum([tip - place for tip in tips if tip is not None], axis=0, initial=0.0)
        if not (together and number):
            look = {"color": colour, **bold}
            yield Label(text, place, 6.0, 10.0, look, direction(np.broadcast_to(away, 2)))
        turned = np.linalg.norm(rotation - frames[0][1]) > _SAME
        for tip, axis, ink in zip(tips, "xyz", FRAME_COLOURS, strict=True):
            if painter.large and tip is not None and (number == 0 or turned or not together):
                mark = "" if base else "'"
                look = {"color": ink, "fontstyle": "italic"}
                yield Label(axis + mark, tip, 2.0, 9.0, look, direction(tip - place))


def _links(painter: Painter, names: Names) -> Iterator[Label]:
    """Names of limbs at their first joints, and of links: of base and platform, where the file does
    not name them, only where links alone are named.
    """
    layout = painter.layout
    for limb, joint in layout.limbs.items():
        look = {"color": COLOURS["base edge"], "fontweight": "bold"}
        reach = 0.5 * painter.symbol
        yield Label(limb, painter.at(layout.marks[joint].start), reach, 9.5, look)
    named = {link: mark for link, mark in layout.links.items() if mark.label}
    if names == "all" and len(named) > _MOST_LINK_NAMES:
        return
    inks = {"base": "base edge", "platform": "platform edge", "link": "quiet"}
    for link, mark in named.items():
        if names == "links" or link not in (BASE, PLATFORM):
            text = layout.mechanism.frame_name if link == PLATFORM else link
            look = {"color": COLOURS[inks[mark.role]], "fontstyle": "italic"}
            yield Label(text, painter.at(mark.points.mean(axis=0)), 2.0, 8.5, look)


def _lengths(painter: Painter, lengths: Mapping[str, np.ndarray]) -> Iterator[Label]:
    look = {"color": COLOURS["platform edge"], "fontstyle": "italic"}
    for text, place in lengths.items():
        yield Label(text, painter.at(place), 3.0, 8.5, look, np.array([0.0, 1.0]))


def lengths_of(layout: Layout) -> dict[str, np.ndarray]:
    """Lengths that stay as they are, each once, with the middle of what is as long: of links
    between two points and of rods; none where they are many.
    """
    found: dict[str, np.ndarray] = {}
    for start, end in _rigid(layout):
        length = float(np.linalg.norm(end - start))
        if length > _SHORT * layout.size:
            found.setdefault(f"{length:.5g}", 0.5 * (start + end))
    return found if len(found) <= _MOST_LENGTHS else {}


def _rigid(layout: Layout) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points of a link that are two, or joined; a slide's only across its axis, along which its
    place tells nothing.
    """
    slides = {mark.name: mark.axes[0] for mark in layout.joints if mark.type == "P"}
    for mark in layout.links.values():
        held = [k for k, owner in enumerate(mark.owners) if owner != HAND]
        found = []
        for a, b in mark.edges if mark.edges is not None else combinations(held, 2):
            along = mark.points[b] - mark.points[a]
            size = max(float(np.linalg.norm(along)), _SAME * layout.size)
            axes = [slides[mark.owners[k]] for k in (a, b) if mark.owners[k] in slides]
            if size > _SAME * layout.size:
                across = all(abs(axis @ along) < _SAME * size for axis in axes)
                found.append((mark.points[a], mark.points[b], across))
        if mark.edges is not None or len(found) == 1:
            yield from ((a, b) for a, b, across in found if across)
    yield from ((rod.start, rod.end) for rod in layout.rods if not rod.actuated)


def _joints(painter: Painter, names: Names) -> Iterator[Label]:
    """Names of joints, those of one place in one text; of two colours where some of them close
    loops.
    """
    closing = painter.layout.closing
    driven = {joint.name for joint in painter.layout.joints if joint.actuated}
    drawn = ((joint.name, painter.at(joint.centre)) for joint in painter.layout.joints)
    places = grouped(drawn, _ONE_PLACE)
    places.sort(key=lambda entry: (not closing & set(entry[0]), not driven & set(entry[0])))
    for here, place in places:
        loops = [name for name in here if name in closing]
        others = [name for name in here if name not in closing]
        reach = (RING + 0.1 if loops else 0.5) * painter.symbol
        for group, colour in ((loops, "loop"), (others, "text")):
            if group and (names != "loops" or group is loops):
                yield Label(_joined(group), place, reach, 9.5, {"color": COLOURS[colour]})


def _joined(names: list[str]) -> str:
    kept = names if len(names) <= _MOST_AT_ONE_PLACE else names[: _MOST_AT_ONE_PLACE - 1]
    more = f" and {len(names) - len(kept)} more" if len(kept) < len(names) else ""
    return textwrap.fill(", ".join(kept) + more, 40)


def _write(ax: Any, page: Page, label: Label, box: Box) -> None:
    """The text, and a line to what it names where it stands away from it."""
    anchor = label.anchor
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
        fontsize=label.font,
        **label.look,
    )
