"""Many modes in one picture: a grid of bare panels, all to one scale, each with its number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.shared.report import new_figure
from symkin.plots.configuration_panel import FRAME_COLOURS, draw_lines
from symkin.plots.crossings import pieces
from symkin.plots.mechanism_lines import MechanismLines, lines_at
from symkin.plots.style import COLOURS, drawing
from symkin.plots.view3d import View

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin import Modes

LIMB_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Colours that stay apart for all kinds of colour vision (Okabe and Ito), one a limb."""
HEAD, FOOT = 0.95, 0.45
"""Inches above and below the panels."""


@dataclass(frozen=True, eq=False)
class _Frame:
    """How the shared box is laid into panels: `width` and `height` of a panel's drawing, inches;
    `scale`, inches a length unit; `shift`, inches from the middle of the drawing to the middle of
    the box; `caption`, inches below the drawing.
    """

    width: float
    height: float
    scale: float
    shift: np.ndarray
    caption: float

    @staticmethod
    def around(
        bodies: Sequence[MechanismLines], view: View, width: float, caption: float
    ) -> _Frame:
        """Make panels as large as all bodies, seen on the plane of the picture, allow."""
        seen = (np.vstack([body.points for body in bodies]) - view.limits.mean(axis=1)) @ view.axes[
            :2
        ].T
        low, high = seen.min(axis=0), seen.max(axis=0)
        scale = 0.9 * width / float(high[0] - low[0])
        height = scale * float(high[1] - low[1]) + 0.14 * width + caption
        return _Frame(width, height, scale, -0.5 * scale * (low + high), caption)


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
    """Draw one panel a mode, `columns` in a row, each `width` inches wide; limbs of a platform in
    colours of their own; a caption (up to two lines) below each drawing where there are any.
    """
    mechanism = found.problem.mechanism
    bodies = [lines_at(mechanism, mode.values, mode.pose) for mode in found]
    view = View.around(bodies, mechanism.length_unit)
    frame = _Frame.around(bodies, view, width, caption=0.4 if captions else 0.0)
    rows = math.ceil(len(bodies) / columns)
    with drawing():
        figure = new_figure(columns * width, HEAD + rows * frame.height + FOOT)
        figure.set_layout_engine("none")
        _heading(figure, title, subtitle)
        for k, body in enumerate(bodies):
            row, column = divmod(k, columns)
            corner = np.array([column * width, FOOT + (rows - 1 - row) * frame.height])
            _panel(figure, body, view, frame, corner, scale)
            _card(figure, corner, frame)
            place = (corner + [0.06 * width, frame.height - 0.09]) / figure.get_size_inches()
            figure.text(
                *place, str(k + 1), va="top", fontsize=10, fontweight="bold", color=COLOURS["quiet"]
            )
            if captions:
                place = (corner + [0.5 * width, 0.07]) / figure.get_size_inches()
                figure.text(
                    *place,
                    captions[k],
                    va="bottom",
                    ha="center",
                    fontsize=8.5,
                    color=COLOURS["quiet"],
                    linespacing=1.3,
                )
        if not mechanism.serial:
            _legend(figure, [limb.name for limb in mechanism.limbs])
    return figure


def _heading(figure: Figure, title: str, subtitle: str) -> None:
    high = figure.get_figheight()
    figure.text(
        0.5,
        1 - 0.14 / high,
        title,
        ha="center",
        va="top",
        fontsize=16,
        fontweight="bold",
        color=COLOURS["text"],
    )
    figure.text(
        0.5, 1 - 0.5 / high, subtitle, ha="center", va="top", fontsize=11, color=COLOURS["quiet"]
    )


def _panel(
    figure: Figure,
    body: MechanismLines,
    view: View,
    frame: _Frame,
    corner: np.ndarray,
    scale: float,
) -> None:
    """Draw one bare panel whose lower left corner (inches) is `corner`: square axes that hold the
    whole box.
    """
    size = figure.get_size_inches()
    side = 1.3 * frame.scale * max(view.picture)
    foot = (
        corner
        + [0.5 * frame.width, 0.5 * (frame.height + frame.caption)]
        + frame.shift
        - 0.5 * side
    )
    axes: Any = figure.add_axes((*(foot / size), *(side / size)), projection="3d")
    draw_lines(axes, body, view, share=frame.scale * view.picture[0] / side, scale=scale)
    away = _centre(axes, view) * side
    axes.set_position((*((foot - away) / size), *(side / size)))
    _strip(axes)
    if body.has_platform:
        _spokes(axes, body, scale)
        _colour_limbs(axes, body, view, scale)


def _centre(axes: Any, view: View) -> np.ndarray:
    """Find where the middle of the box is seen from the middle of the axes, as a share of their
    size.
    """
    seen = axes.get_proj() @ np.array([*view.limits.mean(axis=1), 1.0])
    limits = axes.viewLim
    return np.asarray(
        (seen[:2] / seen[3] - [limits.x0, limits.y0]) / [limits.width, limits.height] - 0.5
    )


def _card(figure: Figure, corner: np.ndarray, frame: _Frame) -> None:
    """Draw a pale ground that keeps a panel apart from its neighbours."""
    from matplotlib.patches import Rectangle

    size = figure.get_size_inches()
    foot, extent = (corner + 0.03) / size, (np.array([frame.width, frame.height]) - 0.06) / size
    look = {
        "facecolor": COLOURS["pane"],
        "edgecolor": COLOURS["grid"],
        "linewidth": 0.8,
        "zorder": -1,
    }
    figure.add_artist(Rectangle(tuple(foot), *extent, transform=figure.transFigure, **look))


def _strip(axes: Any) -> None:
    """Take away labels, box and the axes of frames."""
    for text in list(axes.texts):
        text.remove()
    for line in [line for line in axes.lines if line.get_color() in FRAME_COLOURS]:
        line.remove()
    axes.set_axis_off()


def _spokes(axes: Any, body: MechanismLines, scale: float) -> None:
    """Draw thin lines from the middle of base and platform to their joints: which points belong to
    one body.
    """
    for points, name in ((body.base, "base edge"), (body.platform, "platform edge")):
        for point in points:
            axes.plot(
                *np.array([points.mean(axis=0), point]).T,
                color=COLOURS[name],
                lw=1.1 * scale,
                alpha=0.6,
                zorder=9.0,
            )


def _colour_limbs(axes: Any, body: MechanismLines, view: View, scale: float) -> None:
    """Colour each limb over its own lines, cut where they cross others, at the depth of each
    piece.
    """
    parts = [
        (colour, segment)
        for limb, colour in zip(body.limbs, LIMB_COLOURS, strict=False)
        for segment in limb.segments
        if segment.length > 0.0
    ]
    for piece in pieces([(segment.start, segment.end) for _, segment in parts], view.axes):
        ends, order = (
            np.array([piece.start, piece.end]),
            10.01 + piece.nearness / float(view.extent.max()),
        )
        axes.plot(
            *ends.T,
            color=parts[piece.number][0],
            lw=4.4 * scale,
            solid_capstyle="round",
            zorder=order,
        )


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
