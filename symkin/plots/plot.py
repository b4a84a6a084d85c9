"""Pictures of modes: one 3-D panel per mode, all to the same scale. Matplotlib is imported only when one is drawn."""

from __future__ import annotations

import io
import math
import os
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.errors import InputError
from symkin.files.outputs import write_output
from symkin.plots.box import COLOURS, View, drawing
from symkin.plots.panel import draw_skeleton, legend_entries
from symkin.plots.skeleton import Skeleton, reference_skeleton, skeleton
from symkin.quiet import warnings_ignored

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.assembly.mode_list import Modes
    from symkin.position.solution import Solution

_DPI = 150
_NOT_DRAWN = ("pgf", "raw", "rgba")
_HEAD, _FOOT, _NARROWEST = 1.0, 0.42, 7.4
"""Inches above the panels (figure title) and below them (legend), and the least width of a figure."""


def draw_modes(modes: Modes, path: Path | str, *, most: int = 12) -> int:
    """Write `figure_of_modes` to a file whose suffix is its format, and return the count of panels.

    Raises InputError for a format that matplotlib cannot write and for a folder that is missing or not writable.
    """
    target = check_picture_path(path)
    figure = figure_of_modes(modes, most)
    write_picture(figure, target)
    return len(figure.axes)


def write_picture(figure: Figure, target: Path) -> None:
    """Write a figure whole or not at all, in the format of the path's suffix. Raises InputError."""
    content = io.BytesIO()
    try:
        with drawing(), warnings_ignored("Glyph .* missing"):
            figure.savefig(content, dpi=_DPI, format=target.suffix[1:].lower())
        write_output(target, content.getvalue())
    except OSError as error:
        raise InputError(f"plot: {str(target)!r} cannot be written ({error.strerror or error})") from None
    except InputError as error:
        raise InputError(f"plot: {error}") from None


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
    """One panel per mode, `most` of them, poses before branches, all with the same limits and equal axes; without modes the
    mechanism's reference configuration. Raises InputError for `most` below 1."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if most < 1:
        raise InputError(f"most = {most} must be at least 1")
    mechanism = modes.problem.mechanism
    numbered = _chosen(modes, most)
    shown = [s for _, s in numbered]
    bodies = [skeleton(mechanism, s.values, s.pose) for s in shown] or [reference_skeleton(mechanism)]
    titles = [(f"mode {k}", _mode_text(modes, s)) for k, s in numbered]
    titles = titles or [(_nothing(modes), "drawn at the reference configuration")]
    view = View.around(bodies, mechanism.length_unit)
    grid = _Grid.for_panels(len(bodies), view, max(text.count("\n") for _, text in titles) + 1)
    with drawing():
        figure = Figure(figsize=grid.figure_size, facecolor="white")
        FigureCanvasAgg(figure)
        for k, (body, title) in enumerate(zip(bodies, titles, strict=True)):
            _panel(figure, grid, k, body, view, title)
        _heading(figure, modes, len(shown))
        _legend(figure, bodies)
    return figure


def _chosen(modes: Modes, most: int) -> list[tuple[int, Solution]]:
    """Numbers and modes to draw: all, or one for each pose first and then others, in their order."""
    numbered = list(enumerate(modes.modes, start=1))
    if len(numbered) <= most:
        return numbered
    first = {id(mode) for mode in modes.representatives}
    ranked = sorted(numbered, key=lambda pair: (id(pair[1]) not in first, pair[0]))
    return sorted(ranked[:most], key=lambda pair: pair[0])


# --- layout ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Grid:
    """Where panels stand, in inches: a title of `title` inches above a box seen `box` = (width, height) large, with
    `margin` = (left, right, bottom) around it for labels."""

    count: int
    columns: int
    width: float
    title: float
    box: tuple[float, float]
    margin: tuple[float, float, float]

    @staticmethod
    def for_panels(count: int, view: View, title_lines: int) -> _Grid:
        columns = count if count <= 3 else math.ceil(math.sqrt(count))
        width = {1: 5.6, 2: 4.6, 3: 3.9}.get(columns, 3.4)
        margin = (0.62, 0.2, 0.62) if view.flat else (0.3, 0.62, 0.42)
        wide, high = view.picture
        scale = min((width - margin[0] - margin[1]) / wide, 1.05 * width / high)
        return _Grid(count, columns, width, 0.38 + 0.17 * title_lines, (scale * wide, scale * high), margin)

    @property
    def height(self) -> float:
        return self.title + self.box[1] + self.margin[2]

    @property
    def figure_size(self) -> tuple[float, float]:
        rows = math.ceil(self.count / self.columns)
        return max(self.columns * self.width, _NARROWEST), _HEAD + rows * self.height + _FOOT

    def place(self, k: int) -> tuple[float, float]:
        """Middle and top of panel k, inches from the figure's lower left corner."""
        row, column = divmod(k, self.columns)
        width, height = self.figure_size
        return 0.5 * width + (column + 0.5 - 0.5 * self.columns) * self.width, height - _HEAD - row * self.height


def _panel(figure: Figure, grid: _Grid, k: int, body: Skeleton, view: View, title: tuple[str, str]) -> None:
    """Panel number k: its title, and below it the axes, a square about the middle of the box as it is seen."""
    width, height = grid.figure_size
    middle, top = grid.place(k)
    centre = middle + 0.5 * (grid.margin[0] - grid.margin[1]), top - grid.title - 0.5 * grid.box[1]
    side = 1.2 * max(grid.box)
    box = ((centre[0] - 0.5 * side) / width, (centre[1] - 0.5 * side) / height, side / width, side / height)
    ax: Any = figure.add_axes(box, projection="3d")
    draw_skeleton(ax, body, view, share=grid.box[0] / side, scale=0.8 if grid.columns > 2 else 1.0)
    _text(figure, middle / width, top - 0.03, title[0], ha="center", fontsize=10.5, fontweight="bold")
    lines = "\n".join(textwrap.fill(line, int(14 * grid.width)) for line in title[1].split("\n"))
    _text(figure, middle / width, top - 0.25, lines, ha="center", fontsize=8.5, color=COLOURS["quiet"])


def _heading(figure: Figure, modes: Modes, shown: int) -> None:
    """The figure's title: the mechanism; below it what is given, how many modes there are and how complete they are."""
    width, height = figure.get_size_inches()
    mechanism = modes.problem.mechanism
    title = mechanism.name + (f": {mechanism.title}" if mechanism.title else "")
    part = f" \N{EM DASH} {shown} of {len(modes)} modes shown" if shown < len(modes) else ""
    heading = figure.suptitle(
        _shortened(title, int(10 * width) - len(part)) + part, y=1.0 - 0.12 / height, va="top", fontsize=14,
        fontweight="bold", color=COLOURS["text"], parse_math=False,
    )  # fmt: skip
    with warnings_ignored("Glyph .* missing"):
        heading.set_fontsize(14.0 * min(1.0, 0.94 * width * figure.dpi / heading.get_window_extent().width))
    lines = [_shortened(line, int(width * 14)) for line in _facts(modes)]
    _text(figure, 0.5, height - 0.42, "\n".join(lines), ha="center", fontsize=9.5, color=COLOURS["quiet"])


def _shortened(text: str, room: int) -> str:
    return text if len(text) <= room else text[: room - 1].rstrip() + "\N{HORIZONTAL ELLIPSIS}"


def _legend(figure: Figure, bodies: Sequence[Skeleton]) -> None:
    """One legend at the foot, with an entry for each kind of part that is drawn."""
    entries = legend_entries(bodies)
    figure.legend(
        list(entries.values()), list(entries), loc="lower center", bbox_to_anchor=(0.5, 0.0), ncols=7, frameon=False, fontsize=9,
        labelcolor=COLOURS["quiet"], handletextpad=0.8, columnspacing=1.6,
    )  # fmt: skip


def _text(figure: Figure, x: float, y: float, text: str, **look: Any) -> None:
    """Text whose top is `y` inches above the figure's foot, taken as it is (no mathematics)."""
    options: dict[str, Any] = {"va": "top", "linespacing": 1.4, "color": COLOURS["text"], "parse_math": False} | look
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
    """Where the mode is: the platform's pose, or for an inverse problem the actuated joints; and whether within limits."""
    where = f"joints {_list(solution.actuated_values)}" if modes.problem.kind == "inverse" else _pose_text(solution)
    limits = {None: "", True: "\n\N{CHECK MARK} within limits", False: "\n\N{BALLOT X} outside limits"}
    return where + limits[solution.within_limits]


def _pose_text(solution: Solution) -> str:
    """Position, with the angle where the motion has one; the quaternion for a spherical motion."""
    mechanism = solution.mechanism
    if mechanism.motion == "spherical":
        return f"quaternion {_list(_clean(solution.quaternion, 1.0))}"
    text = f"{_list(_clean(solution.position, mechanism.size))} {mechanism.length_unit}"
    if "pose.gamma" not in solution.values:
        return f"position {text}"
    (angle,) = _clean([mechanism.angle_out(solution.values["pose.gamma"])], 1.0)
    return f"{text}, gamma {angle:.5g} {mechanism.angle_unit}"


def _clean(values: Sequence[float] | np.ndarray, size: float) -> list[float]:
    return [0.0 if abs(v) < 1e-9 * size else float(v) for v in values]


def _list(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.5g}" for v in values) + ")"
