"""The legend at the foot of a sheet: what symbols, lines and colours mean, and the scale."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.drawing.camera import Camera
from symkin.drawing.layout import JOINT_NAMES, Layout
from symkin.drawing.palette import COLOURS, FRAME_COLOURS
from symkin.plots.joint_symbols import draw_symbol
from symkin.plots.painter import frames_of, is_seen
from symkin.plots.sheet import text_extent

_ENTRY = 84.0
"""Pixels of an entry of the legend beside its text."""
_LONGEST_BAR = 130.0
"""Pixels of a scale bar at most."""
_STROKES: dict[str, dict[str, Any]] = {
    "rod": {"color": COLOURS["link"], "linewidth": 1.7},
    "link of the frame": {"color": COLOURS["platform edge"], "linewidth": 3.4},
    "closes a loop, in the file's order": {
        "color": COLOURS["loop"],
        "marker": "o",
        "markersize": 11.0,
        "markerfacecolor": "none",
        "markeredgewidth": 1.3,
        "linewidth": 0.0,
    },
    "coupling": {"color": COLOURS["accent"], "linewidth": 1.2, "linestyle": (0, (1.5, 2.0))},
    "point": {"color": COLOURS["text"], "marker": "D", "markersize": 4.5, "linewidth": 0.0},
    "motion that is not held": {"color": COLOURS["motion"], "linewidth": 1.8, "linestyle": "--"},
}
"""Lines and marks by what they mean."""


def draw_legend(
    ax: Any,
    layouts: Sequence[Layout],
    cameras: Sequence[Camera],
    scale: float,
    place: tuple[float, float],
    *,
    named: bool,
    origin: bool,
    twists: bool = False,
) -> None:
    """Symbols of the joint types that are drawn, of rods, of the platform's link, of couplings and
    of frames (of the base's with `origin`), and a bar for the `scale` (pixels a length unit), in as
    few rows as hold them; `place` is the sheet's width, and where its foot is.
    """
    width, foot = place
    frames = [turn for one in layouts for _, turn in frames_of(one, base=origin)]
    axes = [k for k in range(3) if any(is_seen(c, turn[:, k]) for c in cameras for turn in frames)]
    entries = list(_entries(layouts[0], scale, twists))
    if axes:
        colours = [FRAME_COLOURS[k] for k in axes]
        entries.insert(-1, (_frame_text(layouts[0], axes, named=named, origin=origin), colours))
    gaps = [_gap(look) for _, look in entries]
    widths = [
        text_extent(ax, name, 9.5)[0] + gap + 0.38 * _ENTRY
        for (name, _), gap in zip(entries, gaps, strict=True)
    ]
    count = 1
    while count < len(entries) and any(
        sum(widths[row]) > width - 20.0 for row in _rows(len(entries), count)
    ):
        count += 1
    for k, row in enumerate(_rows(len(entries), count)):
        y = foot + 38.0 + (40.0 if count < 3 else 28.0) * (count - 1 - k)
        x = 0.5 * (width - sum(widths[row]) + 24.0)
        for (name, look), gap, wide in zip(entries[row], gaps[row], widths[row], strict=True):
            _entry(ax, look, np.array([x, y]), end_on=cameras[0].planar)
            style = {"ha": "left", "va": "center", "color": COLOURS["quiet"], "parse_math": False}
            ax.text(x + gap, y, name, fontsize=9.5, **style)
            x += wide


def _gap(look: Any) -> float:
    """Pixels from the beginning of an entry to its text."""
    return look + 0.12 * _ENTRY if isinstance(look, float) else 0.62 * _ENTRY


def _rows(entries: int, count: int) -> list[slice]:
    cuts = [math.ceil(entries * k / count) for k in range(count + 1)]
    return [slice(a, b) for a, b in pairwise(cuts)]


def _entries(layout: Layout, scale: float, twists: bool) -> Iterator[tuple[str, Any]]:
    """Texts with what stands before them: a symbol (type, actuated), the look of a line, or the
    length of a bar, the last.
    """
    ends = {kind for rod in layout.rods for kind in rod.kinds}
    slides = {"P"} if any(rod.actuated for rod in layout.rods) else set()
    drawn = {joint.type for joint in layout.joints} | ends | slides
    for kind, name in JOINT_NAMES.items():
        if kind in drawn:
            yield f"{kind} {name}".removeprefix(f"{name} "), (kind, False)
    driven = [joint.type for joint in layout.joints if joint.actuated]
    if driven or slides:
        yield "actuated", ((driven or ["P"])[0], True)
    is_drawn = (
        any(not rod.actuated for rod in layout.rods),
        layout.pose is not None,
        bool(layout.closing),
        bool(layout.couplings),
        bool(layout.points),
        twists,
    )
    for (text, look), there in zip(_STROKES.items(), is_drawn, strict=True):
        if there:
            yield text.replace("the frame", f"the {layout.mechanism.frame_name} frame"), look
    length, pixels = scale_bar(scale)
    yield f"{length:g} {layout.mechanism.length_unit}", pixels


def scale_bar(scale: float) -> tuple[float, float]:
    """Round length of a bar, and its pixels, at `scale` pixels a length unit."""
    longest = _LONGEST_BAR / scale
    step = 10.0 ** math.floor(math.log10(longest))
    length = step * next(k for k in (5.0, 2.0, 1.0) if k * step <= longest)
    return length, length * scale


def _frame_text(layout: Layout, axes: Sequence[int], *, named: bool, origin: bool) -> str:
    """Which axes of which frames are drawn; with the letters of their origins where these are
    named.
    """
    frames = {"base": "O"} if origin else {}
    if layout.pose is not None:
        frames[layout.mechanism.frame_name] = layout.mechanism.frame_name[0].upper()
    told = " and ".join(f"{name} ({o})" if named else name for name, o in frames.items())
    return f"{', '.join('xyz'[k] for k in axes)} of {'the ' * (len(frames) == 1)}{told}"


def _entry(ax: Any, look: Any, place: np.ndarray, *, end_on: bool) -> None:
    """What stands before a text of the legend."""
    from matplotlib.lines import Line2D

    x, y = place
    if isinstance(look, list):
        part = 0.5 * _ENTRY / len(look)
        for k, colour in enumerate(look):
            ends = [x + part * k, x + part * (k + 0.8)]
            ax.add_line(Line2D(ends, [y, y], color=colour, linewidth=1.8, zorder=10.0))
    elif isinstance(look, float):
        style: dict[str, Any] = {"color": COLOURS["text"], "linewidth": 1.2, "marker": "|"}
        ax.add_line(Line2D([x, x + look], [y, y], zorder=10.0, gid="scale", **style))
    elif isinstance(look, dict):
        ends = [x + 0.25 * _ENTRY] if look["linewidth"] == 0.0 else [x, x + 0.5 * _ENTRY]
        ax.add_line(Line2D(ends, [y] * len(ends), zorder=10.0, **look))
    else:
        kind, drives = look
        along = np.zeros(2) if end_on and kind == "R" else np.array([0.94, 0.2])
        axes, centre = [along, np.array([-0.3, 0.7])], np.array([x + 0.25 * _ENTRY, y])
        draw_symbol(ax, kind, centre, axes, 28.0, actuated=drives, label="legend", order=10.0)
