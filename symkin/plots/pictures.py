"""The picture of each result: what `result.plot()` draws, by the result's type, written whole or
not at all to a path that is checked before. Matplotlib is imported only when one is drawn.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.errors import InputError
from symkin.files.outputs import write_output
from symkin.plots.sheet import drawing
from symkin.quiet import warnings_ignored
from symkin.verb import read_as

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(result: object, path: Path | str | None = None, **options: Any) -> Figure:
    """The figure of a result, written to `path` where one is given. Raises InputError for what has
    no picture, for options that it does not take, and for a file that cannot be written, before
    anything is drawn.
    """
    target = None if path is None else check_picture_path(path)
    figure = figure_of(result, **options)
    if target is not None:
        write_picture(figure, target)
    return figure


_FIGURES = {
    "Calibration": ("calibration_plot", "figure_of_calibration"),
    "ClosedConfiguration": ("figures", "figure_of_closed"),
    "Jacobian": ("jacobian_plot", "figure_of_jacobian"),
    "Loci": ("loci_plot", "figure_of_loci"),
    "Mobility": ("figures", "figure_of_mobility"),
    "ModeGraph": ("loci_plot", "figure_of_mode_graph"),
    "Modes": ("modes_plot", "figure_of_modes"),
    "Plan": ("calibration_plot", "figure_of_plan"),
    "Singularity": ("modes_plot", "figure_of_singularity"),
    "Solution": ("modes_plot", "figure_of_solution"),
    "SolveResult": ("modes_plot", "figure_of_solve"),
    "Swept": ("sweep_plot", "figure_of_sweep"),
    "Track": ("track_plot", "figure_of_track"),
    "Transmission": ("transmission_plot", "figure_of_transmission"),
    "Transmissions": ("transmission_plot", "figure_of_transmissions"),
}
"""Module and function that draw a result, by the name of its type: the picture of one needs no
import of the others.
"""


def figure_of(result: object, **options: Any) -> Figure:
    """The figure of a result, by its type. Raises InputError for options that it does not take."""
    function = _function(result)
    kinds = {
        name: str(p.annotation)
        for name, p in signature(function).parameters.items()
        if p.kind is p.KEYWORD_ONLY or p.default is not p.empty
    }
    wrong = next((name for name in options if name not in kinds), None)
    if wrong is not None:
        taken = f"; allowed: {', '.join(kinds)}" if kinds else ", which takes none"
        raise InputError(
            f"plot: {wrong!r} is no option of the picture of a {type(result).__name__}{taken}"
        )
    told = {name: read_as(kinds[name], f"plot: {name}", v) for name, v in options.items()}
    figure: Figure = function(result, **told)
    return figure


def _function(result: object) -> Callable[..., Any]:
    """What draws a result, by its type. Raises InputError where there is nothing."""
    name = next((kind.__name__ for kind in type(result).__mro__ if kind.__name__ in _FIGURES), None)
    if name is None:
        raise InputError(f"plot: a {type(result).__name__} has no picture")
    module, function = _FIGURES[name]
    found: Callable[..., Any] = getattr(import_module(f"symkin.plots.{module}"), function)
    return found


_DPI = 150
"""Pixels an inch of pictures that are made of pixels."""
_UNDATED: dict[str, dict[str, None]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
"""What is left out of files by suffix, so that one picture is one file, byte for byte."""
_NOT_DRAWN = ("pgf", "raw", "rgba")
"""Formats of matplotlib that no viewer shows, or that want LaTeX."""


def picture(figure: Figure, suffix: str = ".png") -> bytes:
    """A figure as the content of a file with a suffix."""
    content, suffix = io.BytesIO(), suffix.lower()
    with drawing(), warnings_ignored("Glyph .* missing"):
        figure.savefig(content, dpi=_DPI, format=suffix[1:], metadata=_UNDATED.get(suffix))
    return content.getvalue()


def write_picture(figure: Figure, target: Path) -> None:
    """Write a figure whole or not at all, in the format of the path's suffix. Raises InputError."""
    try:
        write_output(target, picture(figure, target.suffix))
    except OSError as error:
        raise InputError(
            f"plot: {str(target)!r} cannot be written ({error.strerror or error})"
        ) from None
    except InputError as error:
        raise InputError(f"plot: {error}") from None


def check_picture_path(path: Path | str) -> Path:
    """The path of a picture that can be written; to be asked before a long computation. Raises
    InputError.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    target = Path(path)
    formats = sorted(set(FigureCanvasAgg.get_supported_filetypes()).difference(_NOT_DRAWN))
    if target.suffix.lower().lstrip(".") not in formats:
        raise InputError(
            f"plot: {str(target)!r} has no picture format as its suffix; allowed: "
            f".{', .'.join(formats)}"
        )
    if not target.parent.is_dir():
        raise InputError(
            f"plot: the folder {str(target.parent)!r} of {target.name!r} does not exist; create it "
            f"first"
        )
    if target.is_dir():
        raise InputError(f"plot: {str(target)!r} is a folder; the name of a file is needed")
    if not os.access(target if target.exists() else target.parent, os.W_OK):
        raise InputError(f"plot: {str(target)!r} cannot be written (permission denied)")
    return target
