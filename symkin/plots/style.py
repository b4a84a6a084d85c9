"""Fonts and settings of every picture, and the lock under which pictures are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from symkin.computed_once import not_waiting
from symkin.drawing.palette import COLOURS
from symkin.locks import Lock
from symkin.quiet import warnings_ignored

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
