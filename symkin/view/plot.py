"""Pictures of modes: one 3-D panel per mode, all to the same scale. Matplotlib is imported only when one is drawn."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.errors import InputError
from symkin.view.panel import COLOURS, STYLE, View, draw_skeleton, legend_handles
from symkin.view.skeleton import Skeleton, reference_skeleton, skeleton

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.position.solution import Modes, Solution

_DPI = 150
_NOT_DRAWN = ("pgf", "raw", "rgba")
_HEAD, _FOOT = 0.95, 0.4
"""Inches above the panels (figure title) and below them (legend)."""


def draw_modes(modes: Modes, path: Path | str, *, most: int = 12) -> int:
    """Write `figure_of_modes` to a file whose suffix is its format, and return the count of panels.

    Raises InputError for a format that matplotlib cannot write and for a folder that is missing or not writable.
    """
    target = check_picture_path(path)
    figure = figure_of_modes(modes, most)
    try:
        figure.savefig(target, dpi=_DPI)
    except OSError as error:
        raise InputError(f"plot: {str(target)!r} cannot be written ({error.strerror or error})") from None
    return len(figure.axes)


def check_picture_path(path: Path | str) -> Path:
    """The path of a picture that can be written; to be asked before a long computation. Raises InputError."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    target = Path(path)
    formats = sorted(set(FigureCanvasAgg.get_supported_filetypes()).difference(_NOT_DRAWN))
    if target.suffix.lower().lstrip(".") not in formats:
        raise InputError(f"plot: {str(target)!r} has no picture format as its suffix; allowed: .{', .'.join(formats)}")
    if not target.parent.is_dir():
        raise InputError(f"plot: the folder {str(target.parent)!r} of {target.name!r} does not exist; create it first")
    if target.is_dir():
        raise InputError(f"plot: {str(target)!r} is a folder; the name of a file is needed")
    if not os.access(target if target.exists() else target.parent, os.W_OK):
        raise InputError(f"plot: {str(target)!r} cannot be written (permission denied)")
    return target


def figure_of_modes(modes: Modes, most: int = 12) -> Figure:
    """One panel per mode, the first `most` of them, all with the same limits and equal axes; without modes the
    mechanism's reference configuration. Raises InputError for `most` below 1."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if most < 1:
        raise InputError(f"most = {most} must be at least 1")
    mechanism = modes.problem.mechanism
    shown = modes.modes[:most]
    bodies = [skeleton(mechanism, s.values, s.pose) for s in shown] or [reference_skeleton(mechanism)]
    titles = [(f"mode {k}", _mode_text(modes, s)) for k, s in enumerate(shown, start=1)]
    titles = titles or [(_nothing(modes), "drawn at the reference configuration")]
    columns, side = _columns(len(bodies)), _side(len(bodies))
    rows = math.ceil(len(bodies) / columns)
    view = View.around(bodies, mechanism.length_unit)
    with rc_context(STYLE):
        figure = Figure(figsize=(max(columns * side, 7.4), rows * side + _HEAD + _FOOT), facecolor="white")
        FigureCanvasAgg(figure)
        for k, (body, title) in enumerate(zip(bodies, titles, strict=True)):
            _panel(figure, (rows, columns, k), body, view, title)
        _heading(figure, modes, len(shown))
        _legend(figure, bodies)
    return figure


# --- layout ------------------------------------------------------------------------------------------------------


def _columns(count: int) -> int:
    return count if count <= 3 else math.ceil(math.sqrt(count))


def _side(count: int) -> float:
    """Width and height of a panel, inches."""
    return 5.4 if count == 1 else 4.6 if count <= 4 else 3.9


def _panel(figure: Figure, place: tuple[int, int, int], body: Skeleton, view: View, title: tuple[str, str]) -> None:
    """Panel number k of a grid of rows and columns between the figure's head and foot, its title above the axes."""
    rows, columns, k = place
    row, column = divmod(k, columns)
    figure_width, figure_height = figure.get_size_inches()
    width, height = figure_width / columns, (figure_height - _HEAD - _FOOT) / rows
    top = figure_height - _HEAD - row * height
    below = 0.3 + 0.16 * len(title[1].split("\n"))
    box = (column * width / figure_width, (top - height) / figure_height, 1.0 / columns, (height - below) / figure_height)
    ax: Any = figure.add_axes(box, projection="3d")
    draw_skeleton(ax, body, view, scale=0.8 if columns > 2 else 1.0)
    middle = (column + 0.5) / columns
    _text(figure, middle, top - 0.05, title[0], ha="center", fontsize=10.5, fontweight="bold")
    _text(figure, middle, top - 0.26, title[1], ha="center", fontsize=8.5, color=COLOURS["quiet"])


def _heading(figure: Figure, modes: Modes, shown: int) -> None:
    """The figure's title: the mechanism; below it what is given, how many modes there are and how complete they are."""
    width, height = figure.get_size_inches()
    mechanism = modes.problem.mechanism
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    part = f" \N{EM DASH} {shown} of {len(modes)} modes shown" if shown < len(modes) else ""
    room = int(width * 8.5) - len(part)
    figure.suptitle(
        textwrap.shorten(title, room, placeholder=" \N{HORIZONTAL ELLIPSIS}") + part, y=1.0 - 0.12 / height, va="top",
        fontsize=14, fontweight="bold", color=COLOURS["text"], parse_math=False,
    )  # fmt: skip
    lines = [textwrap.shorten(line, int(width * 15), placeholder=" \N{HORIZONTAL ELLIPSIS}") for line in _facts(modes)]
    _text(figure, 0.5, height - 0.42, "\n".join(lines), ha="center", fontsize=9.5, color=COLOURS["quiet"])


def _legend(figure: Figure, bodies: Sequence[Skeleton]) -> None:
    """One legend at the foot, with an entry for each kind of part that is drawn."""
    figure.legend(
        handles=legend_handles(bodies), loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=7, frameon=False, fontsize=9,
        labelcolor=COLOURS["quiet"], handletextpad=0.5, columnspacing=1.6,
    )  # fmt: skip


def _text(figure: Figure, x: float, y: float, text: str, **style: Any) -> None:
    """Text whose top is `y` inches above the figure's foot, taken as it is (no mathematics)."""
    options = {"va": "top", "linespacing": 1.4, "color": COLOURS["text"], "parse_math": False} | style
    figure.text(x, y / figure.get_figheight(), text, **options)


# --- words -------------------------------------------------------------------------------------------------------


def _facts(modes: Modes) -> list[str]:
    """What is given, and the count of modes with its completeness."""
    mechanism = modes.problem.mechanism
    given = "; ".join(f"{key} {_list(values)}" for key, values in modes.given.items())
    count = len(modes)
    found = f"{count} mode{'' if count == 1 else 's'}" if count else _nothing(modes)
    units = f"{mechanism.length_unit}, {mechanism.angle_unit}"
    statement = f"{found}; completeness: {modes.completeness}" + (f", {modes.starts} starts" if modes.starts else "")
    return [f"{modes.problem.kind} problem at {given} ({units})", statement]


def _nothing(modes: Modes) -> str:
    return "no isolated solution" if modes.positive_dimensional else "no real solution"


def _mode_text(modes: Modes, solution: Solution) -> str:
    """Where the mode is: the platform's position, or for an inverse problem the actuated joints, and its limits."""
    mechanism = solution.mechanism
    if modes.problem.kind == "inverse":
        where = f"joints {_list(solution.actuated)}"
    else:
        size = mechanism.size
        where = f"position {_list([0.0 if abs(v) < 1e-9 * size else v for v in solution.position])} {mechanism.length_unit}"
    limits = {None: "", True: "\n\N{CHECK MARK} within limits", False: "\n\N{BALLOT X} outside limits"}
    return textwrap.fill(where, 56) + limits[solution.within_limits]


def _list(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
