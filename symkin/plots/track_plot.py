"""A picture of a track: the robot at its start, where it comes nearest to a singularity and at its
end, and below it, over the inputs, what moves and how near singularities and limits are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, SERIES
from symkin.errors import InputError
from symkin.following.sample import Sample
from symkin.following.track_result import Track
from symkin.plots.figures import Block, head_of, heading
from symkin.plots.modes_plot import panel_of
from symkin.plots.picture_options import looks_of
from symkin.plots.sheet import (
    SHEET_DPI,
    drawing,
    labelled,
    new_figure,
    note,
    own_legend,
    sheet_axes,
)
from symkin.plots.track_curves import Curve, CurvePanel, Input, drawn_panels, inputs_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEAST_WIDTH, _MARGIN = 1350.0, 60.0
"""Pixels of the figure's width at least, and beside the robots."""
_PANEL, _ROW, _FOOT = 275.0, 28.0, 68.0
"""Pixels of a panel of curves with what is between two, of a row of inputs below them, and of the
rest there.
"""
_BETWEEN = 0.04
"""Inches above and below a panel of curves."""
_LEGEND, _BELOW = 112.0, 30.0
"""Pixels of the robots' legend, and of it what is below its last row."""
_TICKS_APART = 0.09
"""Share of the axis between the tick at a stop and others."""
_MOST_NAMED, _MOST_STANDING, _MOST_INPUTS = 8, 4, 7
"""Curves, quantities that stand and inputs that are named; of more, the first ones."""
_BESIDE = 0.02
"""Share of the path below which the place nearest to a singularity counts as the start or the
end.
"""
_THIN, _WIDER = 1.5, 2.2
"""Width of a curve in points, and what it is wider for each later curve that covers it."""
_COVERED = 0.008
"""Distance over the panel's range below which two curves cover each other."""
_SHORT = 0.1
"""Share of a path below which two curves only cross."""


def figure_of_track(
    track: Track, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """The robot at some places of the path, then panels over the inputs: the platform's position
    and turning from its start (direct problem), the actuated joints (inverse problem) or all joints
    that are found and the named points (values by name, or no platform); distances to singularity
    and to limits. The stop, if any, is a line. Raises InputError for a track without samples.
    """
    if not track.samples:
        raise InputError(
            f"plot: {track.trajectory.mechanism.name} was not followed, so that there is nothing "
            f"to draw"
        )
    mechanism = track.trajectory.mechanism
    options = looks_of(mechanism, names, views)
    told = [c.name for c in track.problem.known_coordinates]
    robots = [panel_of(title, s.solution, told, text) for title, text, s in _places(track)]
    with drawing():
        across = len(robots) if len(options["views"]) == 1 else len(options["views"])
        block = Block.of(mechanism, robots, **options, columns=across)
        return _figure(track, block)


def _places(track: Track) -> list[tuple[str, str, Sample]]:
    """Titles, places on the path and samples of the robots that are drawn: the start, the place
    nearest to a singularity where it lies between, and the stop or the end; one place alone once.
    """
    first, last = track.samples[0], track.end
    found = [("start", "", first)]
    near = track.nearest
    if near is not None and _BESIDE < near.parameter < last.parameter - _BESIDE:
        found.append(("nearest to a singularity", f"at {near.parameter:.4g} of the path", near))
    if last is not first:
        stop = track.stop
        title = "end" if stop is None else f"stop: {stop.kind}"
        kinds = "" if stop is None else "".join(f", {kind}" for kind in stop.kinds)
        found.append(
            (title, "" if stop is None else f"at {last.parameter:.6g} of the path{kinds}", last)
        )
    return found


def _figure(track: Track, block: Block) -> Figure:
    """Robots above curves, on one sheet."""
    panels, path = drawn_panels(track), _Path.of(track)
    width = max(_LEAST_WIDTH, block.pixels[0] + _MARGIN)
    facts = [_what(track), track.statement[0].upper() + track.statement[1:]]
    curves = len(panels) * _PANEL + _FOOT + _ROW * len(path.inputs)
    top = curves + _LEGEND + block.pixels[1]
    height = top + head_of(facts, width)
    figure = new_figure(width / SHEET_DPI, height / SHEET_DPI, dpi=SHEET_DPI)
    sheet = sheet_axes(figure)
    heading(sheet, block.mechanism, facts, width, height)
    block.paint(sheet, 0.5 * width, top)
    block.paint_legend(sheet, width, curves + _BELOW)
    layout: Any = figure.get_layout_engine()
    layout.set(rect=(0.01, 0.0, 0.98, curves / height), h_pad=_BETWEEN)
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, panel in zip(axes, panels, strict=True):
        _panel(ax, panel, path)
    _name_marks(axes[0], path)
    _ticks(axes[-1], path)
    return figure


def _what(track: Track) -> str:
    """What is followed, for the heading."""
    if track.trajectory.kind != "given":
        return f"one mode of the {track.trajectory.kind} problem"
    return f"one mode given {', '.join(c.name for c in track.problem.known_coordinates)}"


@dataclass(frozen=True, eq=False)
class _Path:
    """What curves are drawn over: the abscissa `x` with its title, the inputs that are rows below
    it, the marks on it by their texts, each with place, colour and line, and whether the path
    stops.
    """

    x: np.ndarray
    title: str
    inputs: list[Input]
    marks: dict[str, tuple[float, str, str]]
    stops: bool

    @staticmethod
    def of(track: Track) -> _Path:
        timed, moved = track.trajectory.times is not None, inputs_of(track)
        title = "time [s]" if timed else "share of the path"
        x = np.array([s.time if timed else s.parameter for s in track.samples], dtype=float)
        if len(moved) == 1 and not timed and (np.diff(moved[0].values) > 0).all():
            title, x, moved = moved[0].title, moved[0].values, []
        parameters = [s.parameter for s in track.samples]
        marks = {}
        if track.stop is not None and track.stop.place is not None:
            marks[track.stop.kind] = float(x[-1]), COLOURS["accent"], "--"
        if track.nearest is not None and track.nearest.parameter < parameters[-1] - 1e-9:
            place = float(np.interp(track.nearest.parameter, parameters, x))
            marks["nearest to a singularity"] = place, COLOURS["quiet"], ":"
        return _Path(x, title, moved[:_MOST_INPUTS], marks, track.stop is not None)


# --- curves ---------------------------------------------------------------------------------------


def _panel(ax: Any, panel: CurvePanel, path: _Path) -> None:
    _draw_curves(ax, panel, path.x)
    ax.set_ylabel(panel.label, fontsize=8.5, color=COLOURS["quiet"])
    ax.tick_params(labelsize=8, colors=COLOURS["quiet"])
    ax.grid(color=COLOURS["grid"], linewidth=0.6)
    margin = 0.03 * float(np.ptp(path.x)) or 0.5
    ax.set_xlim(path.x.min() - margin, path.x.max() + margin)
    for place, colour, style in path.marks.values():
        gid = "stop" if style == "--" else "nearest"
        ax.axvline(place, color=colour, lw=1.4, ls=style, gid=gid, zorder=1.5)
    _legend(ax, panel)


def _name_marks(ax: Any, path: _Path) -> None:
    """The names of the marks, above the first panel, one above the other."""
    for k, (text, (place, _, style)) in enumerate(path.marks.items()):
        left = style == "--" or place > float(np.mean(ax.get_xlim()))
        look = {"ha": "right" if left else "left", "color": COLOURS["quiet"]}
        note(ax, text, (place, 1.0), (0, 3 + 10 * k), xycoords=("data", "axes fraction"), **look)


def _ticks(ax: Any, path: _Path) -> None:
    """Ticks at the same places in all panels; below the last one the values of the inputs there, a
    row each.
    """
    from matplotlib.ticker import MaxNLocator

    low, high = float(path.x.min()), float(path.x.max())
    steps = [1, 1.5, 3, 4.5, 6, 9, 10] if path.title.endswith("[deg]") else [1, 2, 2.5, 5, 10]
    found = MaxNLocator(7, steps=steps).tick_values(low, high)
    places = [float(v) for v in found if low <= v <= high]
    if path.stops or not places:
        end = float(path.x[-1])
        places = [*(v for v in places if abs(v - end) > _TICKS_APART * (high - low)), end]
    rows = [[f"{place:.6g}" for place in places]]
    rows += [[f"{v + 0.0:.5g}" for v in np.interp(places, path.x, i.values)] for i in path.inputs]
    columns = ["\n".join(column) for column in zip(*rows, strict=True)]
    ax.set_xticks(places, labels=columns, fontsize=8, linespacing=1.35)
    names = "\n".join([path.title, *(i.title for i in path.inputs)])
    # beside the first label, whose half width is kept free
    look = {"ha": "right", "va": "top", "linespacing": 1.35, "color": COLOURS["text"]}
    note(ax, names, (0.0, 0.0), (-16, -7), xycoords="axes fraction", **look)


def _draw_curves(ax: Any, panel: CurvePanel, x: np.ndarray) -> None:
    """Curves, of which earlier ones are wider where later ones cover them, so that each is seen."""
    whole = np.concatenate([[], *(curve.values for curve in panel.curves)])
    low, high = (float(end(whole)) if len(whole) else 0.0 for end in (np.min, np.max))
    span = high - low
    if panel.floor is not None:
        span = max(span, high, -low)
    for k, curve in enumerate(panel.curves):
        look: dict[str, Any] = {"color": SERIES[k % len(SERIES)], "zorder": 2.0 + 0.01 * k}
        marker = "." if len(curve.at) < 2 else None
        ax.plot(x[curve.at], curve.values, linewidth=_THIN, label=curve.name, marker=marker, **look)
        over = np.sum(
            [_covers(later, curve, span) for later in panel.curves[k + 1 :]], axis=0, initial=0
        )
        for level in range(1, int(np.max(over, initial=0)) + 1):
            seen = np.where(over >= level, curve.values, np.nan)
            ax.plot(
                x[curve.at],
                seen,
                linewidth=_THIN + _WIDER * level,
                solid_capstyle="butt",
                gid="covered",
                **look,
            )
    if panel.floor is not None and panel.curves:
        least = min(panel.floor, low)
        ends = least - 0.04 * (high - least), high + 0.08 * (high - least) if high > least else 1.0
        ax.set_ylim(*ends)
        if least < panel.floor:
            ax.axhline(panel.floor, color=COLOURS["text"], lw=0.8)


def _covers(later: Curve, curve: Curve, span: float) -> np.ndarray:
    """At which of a curve's places a later one lies on it, over a stretch that is seen."""
    near = np.abs(np.interp(curve.at, later.at, later.values) - curve.values) <= _COVERED * span
    edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        near[begin:end] &= end - begin > _SHORT * len(near)
    return np.asarray(near)


def _entries(panel: CurvePanel) -> list[str]:
    """The texts of a panel's legend."""
    named, standing = [curve.name for curve in panel.curves], list(panel.stands)
    more, others = len(named) - _MOST_NAMED, len(standing) - _MOST_STANDING
    return [
        *named[:_MOST_NAMED],
        *([f"and {more} more"] if more > 0 else []),
        *standing[:_MOST_STANDING],
        *([f"{others} more stand"] if others > 0 else []),
    ]


def _legend(ax: Any, panel: CurvePanel) -> None:
    from matplotlib.lines import Line2D

    handles = list(labelled(ax).values())[:_MOST_NAMED]
    thin = []
    for h in handles:
        line = {"color": h.get_color(), "marker": h.get_marker()}
        thin.append(Line2D([], [], linewidth=min(2.0, len(h.get_xdata()) - 1), **line))
    texts = _entries(panel)
    blank = [Line2D([], [], linewidth=0.0) for _ in texts[len(thin) :]]
    look = {"fontsize": 8, "labelspacing": 0.3, "handlelength": 1.4}
    place = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
    own_legend(ax, dict(zip(texts, [*thin, *blank], strict=True)), **look, **place)
