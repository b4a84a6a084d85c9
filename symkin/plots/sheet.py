"""Figures, and pages in pixels, y upward, on which sketches are drawn, with the texts on them;
fonts and settings of every picture, and the lock under which pictures are drawn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.computed_once import not_waiting
from symkin.drawing.palette import COLOURS
from symkin.locks import Lock
from symkin.quiet import warnings_ignored

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHEET_DPI = 150
"""Pixels an inch."""
_BORDER = 0.1
"""Inches about axes with their texts."""
_APART = 8.0
"""Pixels below which two symbols stand at one place."""


def blank_figure(width: float, height: float, **look: Any) -> Figure:
    """A white figure of some inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), facecolor="white", **look)
    FigureCanvasAgg(figure)
    return figure


def new_figure(width: float, height: float, **look: Any) -> Figure:
    """A figure of some inches whose axes lay themselves out."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    layout = ConstrainedLayoutEngine(w_pad=_BORDER, h_pad=_BORDER)
    return blank_figure(width, height, layout=layout, **look)


def foot_legend(figure: Figure, entries: Mapping[str, Any], columns: int) -> None:
    """A legend below all axes; none without entries."""
    if entries:
        look: dict[str, Any] = {"frameon": False, "fontsize": 9, "labelcolor": COLOURS["quiet"]}
        place: Any = "outside lower center"
        figure.legend(list(entries.values()), list(entries), loc=place, ncols=columns, **look)


def labelled(ax: Any) -> dict[str, Any]:
    """What is drawn on axes by the names for a legend, each once."""
    handles, labels = ax.get_legend_handles_labels()
    return dict(zip(labels, handles, strict=True))


def own_legend(ax: Any, entries: Mapping[str, Any], **place: Any) -> None:
    """A legend of axes without a frame, whose texts are no mathematics; none without entries."""
    if entries:
        look: dict[str, Any] = {"frameon": False, "labelcolor": COLOURS["text"], **place}
        for text in ax.legend(list(entries.values()), list(entries), **look).get_texts():
            text.set_parse_math(False)


def name_axes(ax: Any, x: str, y: str | None = None, colour: str = COLOURS["quiet"]) -> None:
    """Write what axes are, which is no mathematics."""
    ax.set_xlabel(x, color=colour, parse_math=False)
    if y is not None:
        ax.set_ylabel(y, color=colour, parse_math=False)


def subtitle(ax: Any, text: str, size: float = 9.0, **look: Any) -> None:
    """Write what one of several axes shows, or what is held, above it."""
    ax.set_title(text, fontsize=size, color=COLOURS["quiet"], parse_math=False, **look)


def note(ax: Any, text: str, at: Any, away: tuple[float, float], **look: Any) -> None:
    """A text some points away from a place."""
    style: dict[str, Any] = {"fontsize": 8, "parse_math": False, "textcoords": "offset points"}
    ax.annotate(text, at, xytext=away, **style | look)


def open_axes(figure: Figure, ratios: tuple[float, ...], **shared: Any) -> Any:
    """Axes side by side, open above and at the right."""
    found = figure.subplots(1, len(ratios), width_ratios=ratios, **shared)
    for ax in found:
        ax.spines[["top", "right"]].set_visible(False)
    return found


def colour_bar(ax: Any, drawn: Any, what: str, **look: Any) -> Any:
    """What the colours of a map mean, beside it."""
    bar = ax.figure.colorbar(drawn, ax=ax, pad=0.02, **look)
    bar.set_label(what, color=COLOURS["quiet"], parse_math=False)
    bar.ax.tick_params(colors=COLOURS["quiet"])
    return bar


def head(figure: Figure, title: str, size: float = 13.0) -> None:
    """The title of a figure."""
    look: dict[str, Any] = {"fontsize": size, "fontweight": "bold", "color": COLOURS["text"]}
    figure.suptitle(title, parse_math=False, **look)


def make_sheet(width: float, height: float) -> tuple[Figure, Any]:
    """A figure whose axes are its pixels."""
    figure = blank_figure(width / SHEET_DPI, height / SHEET_DPI, dpi=SHEET_DPI)
    return figure, sheet_axes(figure)


def sheet_axes(figure: Figure) -> Any:
    """Axes over a whole figure, of `SHEET_DPI` pixels an inch, whose pixels they have as
    coordinates.
    """
    width, height = SHEET_DPI * figure.get_size_inches()
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.set(xlim=(0.0, width), ylim=(0.0, height))
    ax.set_axis_off()
    return ax


def text_extent(ax: Any, text: str, font: float, **look: Any) -> tuple[float, float]:
    """Width and height of a text in pixels."""
    drawn = ax.text(0, 0, text, fontsize=font, parse_math=False, **look)
    box = drawn.get_window_extent(ax.figure.canvas.get_renderer())
    drawn.remove()
    return float(box.width), float(box.height)


def symbol_size(centres: np.ndarray, share: float, least: float, most: float) -> float:
    """Pixels of a joint's symbol: the share of the distance of the nearest two of the centres
    (n, 2) that are apart, within bounds.
    """
    gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2)
    apart = gaps[gaps > _APART]
    return float(np.clip(share * (apart.min() if apart.size else most), least, most))


def outlined() -> list[Any]:
    """The white edge of a text, which keeps it legible over lines."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=1.8, foreground="white", alpha=0.75)]


def direction(vector: np.ndarray) -> np.ndarray:
    """The unit vector along one in the picture; upward where it has no length."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-9 else np.array([0.0, 1.0])


_matplotlib = Lock()
_FONTS = (
    "DejaVu Sans",
    "Noto Sans CJK SC",
    "Noto Sans CJK JP",
    "WenQuanYi Micro Hei",
    "Microsoft YaHei",
    "PingFang SC",
)
"""Fonts in order, as far as they are there: those after the first for titles in other scripts."""


def style() -> Any:
    """Matplotlib settings under which a figure is made and saved, whatever the user's own are."""
    from matplotlib.font_manager import get_font_names

    there = set(get_font_names())
    grid = {"grid.color": COLOURS["grid"], "grid.linewidth": 0.6, "axes.edgecolor": COLOURS["axis"]}
    fonts = {
        "font.family": [name for name in _FONTS if name in there],
        "text.usetex": False,
        "axes.unicode_minus": True,
    }
    # fonts in PDF files as outlines that journals take (type 42); the salt makes names within SVG
    # files the same at each run
    files = {
        "savefig.bbox": None,
        "savefig.transparent": False,
        "pdf.fonttype": 42,
        "svg.hashsalt": "symkin",
    }
    return grid | fonts | files


@contextmanager
def drawing() -> Iterator[None]:
    """Make and save figures under `style` and matplotlib's own defaults, whatever the user's file
    says, one thread at a time: settings, fonts and parsers belong to the process.
    """
    from matplotlib import rc_context, rcdefaults, rcParams

    with _matplotlib, not_waiting(), rc_context():
        with warnings_ignored():  # old versions read fonts by what its parser calls deprecated
            rcdefaults()
        rcParams.update(style())
        yield
