"""Maps of a sweep: the number of real modes, or the condition of the best one, over one or two of
the swept values.

A grid of more dimensions is cut at the middle of the others, or where `slices` says; a random
sample is drawn as points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, KIND_COLOURS
from symkin.errors import InputError
from symkin.plots.loci_plot import draw_locus
from symkin.plots.sheet import (
    colour_bar,
    drawing,
    foot_legend,
    labelled,
    name_axes,
    new_figure,
    note,
    own_legend,
)
from symkin.plots.sweep_values import axis_text, figure_of_values, write_title
from symkin.singularities.loci import MISSING, NONE_MET, Loci
from symkin.sweeps.interrupts import interrupts_held
from symkin.sweeps.map_loci import loci_over
from symkin.sweeps.map_slice import TITLES, MapSlice, SweepFolder, edges
from symkin.sweeps.run import Swept

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NONE, _UNKNOWN = "#dfe3e8", "#ffffff"
"""Colours of cells without a mode, and of points that are not counted."""
_CROSS: dict[str, Any] = {"marker": "x", "color": "#b03a48", "linewidths": 0.8}
_PLUS: dict[str, Any] = {"marker": "+", "color": COLOURS["quiet"], "linewidths": 0.8}
"""Looks of single points without a mode, and of single points that are not counted: they have no
area to be grey or white.
"""
_MOST_ENTRIES = 12
"""Counts that the legend of a map names one by one; of more, it names evenly spaced ones."""
_NARROW = 20.0
"""Ratio of conditions below which powers of ten alone make too few ticks."""


def figure_of_sweep(
    sweep: Swept | Path | str,
    slices: Mapping[str, float] | None = None,
    of: str | Sequence[str] = (),
    loci: Loci | bool = False,
) -> Figure:
    """The map of a sweep or of its folder, or with `of` the paths of named points or the values of
    joints (see `sweep_values`). `slices` gives values, in the mechanism's units, at which
    dimensions of a grid are cut: the nearest grid values are taken. `loci` of the same plane, or
    True for a search, are laid over the map. Raises InputError for a folder that holds no sweep, a
    slice outside what is swept, and loci of another plane.
    """
    slices, folder = slices or {}, sweep.folder if isinstance(sweep, Swept) else Path(sweep)
    with interrupts_held():
        swept = SweepFolder.of(folder)
        swept.check_map(slices)
        if of and loci is not False:
            raise InputError(
                "plot: loci are laid over the map, and `of` draws points or joints in its place; "
                "give one of them"
            )
        if of:
            return figure_of_values(swept, (of,) if isinstance(of, str) else tuple(of), slices)
        name, part = swept.shown, swept.map_slice(slices)
    curves = loci_over(loci, swept, part.ranges, part.cuts, part.some)
    with drawing():
        figure = new_figure(7.4, 6.0 if part.y else 4.4)
        ax: Any = figure.add_subplot()
        if part.y is None:
            _curve(ax, part, name)
        elif name == "least_condition":
            _continuous_map(ax, part)
        else:
            _discrete_map(ax, part)
        _words(ax, part, swept, name)
        if curves is not None:
            draw_loci(ax, curves, list(part.ranges))
        # the layout of axes of one scale is found in two goes, the second when it is drawn
        figure.draw_without_rendering()
    return figure


# --- drawing --------------------------------------------------------------------------------------


def _curve(ax: Any, part: MapSlice, name: str) -> None:
    values = np.where(part.values < 0, np.nan, part.values.astype(float))
    x, look = part.x[2], {"color": COLOURS["platform edge"]}
    if part.scattered or len(x) < 2:
        ax.plot(x, values, ".", markersize=4 if len(x) > 1 else 9, **look)
    elif name == "least_condition":
        ax.plot(x, values, linewidth=1.6, marker="." if len(x) < 80 else "", **look)
    else:
        ax.step(x, values, where="mid", linewidth=1.6, **look)
    empty = np.isnan(values)
    if name != "least_condition" and empty.all():
        ax.set_xlim(x.min() - 0.5, x.max() + 0.5)
        middle = {
            "ha": "center",
            "va": "center",
            "transform": ax.transAxes,
            "color": COLOURS["quiet"],
        }
        ax.text(0.5, 0.5, "too many modes to list at every point", **middle)
    if name == "least_condition" and empty.any():
        margin = 0.05 * float(np.ptp(x)) or 0.5
        ax.set_xlim(x.min() - margin, x.max() + margin)
        ax.scatter(
            x[empty],
            np.zeros(empty.sum()),
            transform=ax.get_xaxis_transform(),
            clip_on=False,
            zorder=3,
            **_CROSS,
        )
    if name == "least_condition" and np.isfinite(values).any():
        ax.set_yscale("log")
    elif name != "least_condition":
        ax.yaxis.get_major_locator().set_params(integer=True)
        ax.set_ylim(bottom=-0.3, top=max(1.0, float(np.nanmax(values, initial=0.0))) + 0.7)
    note = " (cross: no mode)" if name == "least_condition" and empty.any() else ""
    ax.set_ylabel(TITLES[name].lower() + note, color=COLOURS["quiet"])
    ax.grid(True)


def _painted(ax: Any, part: MapSlice, **look: Any) -> Any:
    """Cells of a grid, or points of a sample, with their values as colours; single points without a
    value get marks.
    """
    assert part.y is not None  # noqa: S101 - curves are drawn elsewhere
    if part.scattered:
        size = float(np.clip(40_000 / max(1, len(part.values)), 2.0, 40.0))
        drawn = ax.scatter(
            part.x[2], part.y[2], c=part.values, s=size, linewidths=0, rasterized=True, **look
        )
        for mark, where in (
            (_CROSS, np.isnan(part.values) | (part.values == 0)),
            (_PLUS, part.values < 0),
        ):
            ax.scatter(part.x[2][where], part.y[2][where], s=size, rasterized=True, **mark)
        return drawn
    return ax.pcolormesh(edges(part.x[2]), edges(part.y[2]), part.values.T, rasterized=True, **look)


def _discrete_map(ax: Any, part: MapSlice) -> None:
    """A colour for each count that occurs; its legend names them with their shares."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    counts, points = np.unique(part.values, return_counts=True)
    positive = counts[counts > 0]
    shades = dict(
        zip(
            positive.tolist(),
            colormaps["viridis"](np.linspace(0.15, 0.97, len(positive))),
            strict=True,
        )
    )
    none = _UNKNOWN if part.scattered else _NONE
    colours = [_UNKNOWN if c < 0 else none if c == 0 else shades[int(c)] for c in counts]
    norm = (
        BoundaryNorm([*(counts - 0.5), counts[-1] + 0.5], len(counts)) if len(counts) > 1 else None
    )
    _painted(ax, part, cmap=ListedColormap(colours), norm=norm)
    shown = np.unique(
        np.linspace(0, len(counts) - 1, min(_MOST_ENTRIES, len(counts))).round().astype(int)
    )
    patches = [Patch(facecolor=colours[i], edgecolor=COLOURS["axis"], linewidth=0.5) for i in shown]
    marks = [
        ax.scatter([], [], s=40.0, **(_CROSS if counts[i] == 0 else _PLUS))
        for i in shown
        if counts[i] <= 0
    ]
    handles = [*marks, *patches[len(marks) :]] if part.scattered else patches
    texts = [
        f"{'not counted' if counts[i] < 0 else counts[i]}  ({100 * points[i] / points.sum():.3g} %)"
        for i in shown
    ]
    entries = dict(zip(texts, handles, strict=True))
    own_legend(ax, entries, loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=9)


def _continuous_map(ax: Any, part: MapSlice) -> None:
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import LogLocator

    finite = part.values[np.isfinite(part.values)]
    low, high = (finite.min(), finite.max()) if finite.size else (1.0, 10.0)
    ax.set_facecolor(_UNKNOWN if part.scattered else _NONE)
    drawn = _painted(ax, part, cmap="viridis_r", norm=LogNorm(low, max(high, 1.01 * low)))
    ticks = np.geomspace(low, high, 5) if high < _NARROW * low else LogLocator(subs=(1.0, 2.0, 5.0))
    what = f"condition ({'cross' if part.scattered else 'grey'}: no mode)"
    colour_bar(ax, drawn, what, ticks=ticks, format="%.3g").minorticks_off()


def _words(ax: Any, part: MapSlice, swept: SweepFolder, name: str) -> None:
    """Title, what is fixed, labels of the axes."""
    write_title(ax, TITLES[name], swept, part.fixed)
    axes = [axis for axis in (part.x, part.y) if axis is not None]
    name_axes(ax, *(axis_text(swept, *axis[:2]) for axis in axes))
    if part.y is not None:
        spans = [float(np.ptp(axis[2])) for axis in axes]
        if part.x[1] == part.y[1] and 0.8 < spans[0] / max(spans[1], 1e-300) < 1.25:
            ax.set_aspect("equal")


# --- loci -----------------------------------------------------------------------------------------


_WORDS = "singular, "
_WIDTH, _EDGE = 1.8, 4.0
"""Widths in points of a curve and of the white edge that parts it from the map."""


def draw_loci(ax: Any, loci: Loci, names: Sequence[str]) -> None:
    """The curves on a map whose axes are `names`, with a legend below it; the map's limits stay."""
    from matplotlib.patheffects import withStroke

    edge = [withStroke(linewidth=_EDGE, foreground="white", alpha=0.9)]
    limits = ax.get_xlim(), ax.get_ylim()
    order = [loci.plane.names.index(name) for name in names]
    for curve in loci.curves:
        if len(order) == 1:
            look = {"lw": _WIDTH, "zorder": 5.0, "gid": f"locus {curve.kind}"}
            ax.axvline(
                curve.points[0, 0],
                color=KIND_COLOURS[curve.kind],
                label=f"{_WORDS}{curve.kind}",
                path_effects=edge,
                **look,
            )
        else:
            turned = replace(curve, points=curve.points[:, order], cusps=curve.cusps[:, order])
            draw_locus(ax, turned, emphasise=False, words=_WORDS, path_effects=edge)
    ax.set(xlim=limits[0], ylim=limits[1])
    missing = {MISSING, NONE_MET} & set(loci.notes)
    told = "" if loci.curves else f"{loci.without_curves}; "
    text = f"{told}curves may be missing" if missing else told.removesuffix("; ")
    if text:
        look = {"ha": "right", "va": "top", "color": COLOURS["text"], "path_effects": edge}
        note(ax, text, (1.0, 1.0), (0, -4), xycoords="axes fraction", **look)
    foot_legend(ax.figure, labelled(ax), 3)
