"""Many modes in one picture: a grid of bare panels, all to one scale, each with its number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.camera import Camera
from symkin.drawing.layout import Layout, layout_of
from symkin.drawing.palette import COLOURS
from symkin.plots.painter import Painter
from symkin.plots.sheet import SHEET_DPI, drawing, make_sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin import Modes

LIMB_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Colours that stay apart for all kinds of colour vision (Okabe and Ito), one a limb."""
HEAD, FOOT = 0.95, 0.45
"""Inches above and below the panels."""
CAPTION = 0.4
"""Inches below a drawing for its caption."""


def draw_small_multiples(
    found: Modes,
    title: str,
    subtitle: str,
    columns: int,
    *,
    width: float = 2.0,
    scale: float = 0.5,
    captions: Sequence[str] = (),
) -> Figure:
    """Draw one panel a mode, `columns` in a row, each `width` inches wide, lines `scale` times as
    wide as usual; limbs of a platform in colours of their own; a caption (up to two lines) below
    each drawing where there are any.
    """
    mechanism = found.problem.mechanism
    reference = layout_of(mechanism)
    camera, layouts = Camera.of(reference), [reference.at(mode.link_poses) for mode in found]
    seen = camera.flat(np.vstack([layout.all_points for layout in layouts]))
    low, high = seen.min(axis=0), seen.max(axis=0)
    wide, caption = SHEET_DPI * width, SHEET_DPI * (CAPTION if captions else 0.0)
    pixels = 0.9 * wide / float(high[0] - low[0])
    tall = pixels * float(high[1] - low[1]) + 0.14 * wide + caption
    rows = math.ceil(len(layouts) / columns)
    whole = columns * wide, SHEET_DPI * (HEAD + FOOT) + rows * tall
    with drawing():
        figure, ax = make_sheet(*whole)
        _write(ax, 0.5 * whole[0], whole[1] - 21.0, title, fontsize=16, fontweight="bold")
        _write(ax, 0.5 * whole[0], whole[1] - 75.0, subtitle, fontsize=11, color=COLOURS["quiet"])
        for k, layout in enumerate(layouts):
            row, column = divmod(k, columns)
            corner = np.array([column * wide, SHEET_DPI * FOOT + (rows - 1 - row) * tall])
            _card(ax, corner, wide, tall)
            centre = corner + [0.5 * wide, 0.5 * (tall + caption)]
            shift = centre - 0.5 * pixels * (low + high)
            colours = {} if mechanism.serial else _limb_colours(layout)
            wide_lines = 1.2 if mechanism.serial else 2.4
            look = {"symbol": 20.0 * scale, "width": wide_lines * scale, "colours": colours}
            Painter(ax, layout, camera, pixels, shift, **look).draw()
            number = {"ha": "left", "fontweight": "bold", "color": COLOURS["quiet"]}
            _write(
                ax,
                corner[0] + 0.06 * wide,
                corner[1] + tall - 13.0,
                str(k + 1),
                fontsize=10,
                **number,
            )
            if captions:
                look = {"va": "bottom", "fontsize": 8.5, "color": COLOURS["quiet"]}
                _write(ax, centre[0], corner[1] + 10.0, captions[k], linespacing=1.3, **look)
        if not mechanism.serial:
            _legend(figure, [limb.name for limb in mechanism.limbs])
    return figure


def _write(ax: Any, x: float, y: float, text: str, **look: Any) -> None:
    style = {"ha": "center", "va": "top", "color": COLOURS["text"], "zorder": 30.0}
    ax.text(x, y, text, **(style | look))


def _limb_colours(layout: Layout) -> dict[str, str]:
    """The colour of the rod, or of the links, of each limb."""
    found = {}
    for limb, colour in zip(layout.mechanism.limbs, LIMB_COLOURS, strict=False):
        found[limb.name] = colour
        found |= {link: colour for link in layout.links if link.rsplit(".", 1)[0] == limb.name}
    return found


def _card(ax: Any, corner: np.ndarray, wide: float, tall: float) -> None:
    """Draw a pale ground that keeps a panel apart from its neighbours."""
    from matplotlib.patches import Rectangle

    card = Rectangle(
        (float(corner[0]) + 4.5, float(corner[1]) + 4.5),
        wide - 9.0,
        tall - 9.0,
        facecolor=COLOURS["pane"],
        edgecolor=COLOURS["grid"],
        linewidth=0.8,
        zorder=0.0,
    )
    ax.add_patch(card)


def _legend(figure: Figure, names: Sequence[str]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [Line2D([], [], color=colour, lw=3) for colour in LIMB_COLOURS[: len(names)]]
    bodies = [
        Patch(facecolor=COLOURS[name], edgecolor=COLOURS[f"{name} edge"], alpha=0.5)
        for name in ("base", "platform")
    ]
    figure.legend(
        [*bodies, *handles],
        ["base", "platform", *names],
        loc="lower center",
        ncols=8,
        frameon=False,
        fontsize=11,
        labelcolor=COLOURS["quiet"],
    )
