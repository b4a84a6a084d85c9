"""Check the path of a picture before a long computation, and write a figure whole or not at all."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

from symkin.errors import InputError
from symkin.files.outputs import write_output
from symkin.plots.style import drawing
from symkin.quiet import warnings_ignored

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
