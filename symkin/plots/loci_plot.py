"""Pictures over a plane of two coordinates: singularity loci, and the sheets of a graph of modes.
Matplotlib is imported only when one is drawn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, KIND_COLOURS, SERIES
from symkin.plots.sheet import drawing, foot_legend, head, labelled, name_axes, new_figure, subtitle
from symkin.position.given import given_coordinates
from symkin.position.varied_pose import axis_title
from symkin.singularities.loci import MISSING, NONE_MET

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.following.mode_graph import ModeGraph
    from symkin.singularities.loci import Loci
    from symkin.singularities.locus import Locus

_NARROW = 4.0
"""Ratio of the window's sides beyond which equal scales would leave a strip that cannot be read."""


def figure_of_loci(loci: Loci) -> Figure:
    """The window with every curve: strong where it belongs to the configuration's working mode,
    thin elsewhere; cusps as rings, the configuration as a cross; equal scales where both sides are
    of one unit.
    """
    with drawing():
        figure = new_figure(7.4, 7.2 if len(loci.ranges) == 2 else 2.6)
        axes = figure.subplots()
        draw_curves(axes, loci)
        head(figure, f"{loci.plane.mechanism.name}: singularity loci")
        subtitle(axes, loci.held)
        foot_legend(figure, labelled(axes), 3)
    return figure


def draw_curves(axes: Any, loci: Loci) -> None:
    """The curves, those of other working modes thin, cusps and the configuration on given axes,
    with limits and labels.
    """
    if len(loci.ranges) == 1:
        _draw_points(axes, loci)
        return
    for curve in loci.curves:
        draw_locus(axes, curve, emphasise=True)
        ends = curve.loose_ends(loci.ranges)
        if len(ends):
            look = {"color": KIND_COLOURS[curve.kind], "ms": 6, "mew": 1.4, "zorder": 4}
            axes.plot(*ends.T, "x", label="tracing ends", **look)
    u, v = (_out(loci, k) for k in range(2))
    if all(low <= value <= high for value, (low, high) in zip((u, v), loci.ranges, strict=True)):
        draw_cross(axes, u, v, label="configuration")
    if not loci.curves:
        apart = 0.25 if v > float(np.mean(loci.ranges[1])) else 0.75
        look = {"transform": axes.transAxes, "color": COLOURS["quiet"], "zorder": 6, "fontsize": 12}
        axes.text(0.5, apart, loci.without_curves, ha="center", va="center", **look)
    axes.set(xlim=loci.ranges[0], ylim=loci.ranges[1])
    titles = map(axis_title, loci.plane.names) if loci.plane.of_pose else loci.plane.names
    names = [f"{title} [{unit}]" for title, unit in zip(titles, loci.units, strict=True)]
    name_axes(axes, names[0] + _caption(loci), names[1], COLOURS["text"])
    if (
        loci.units[0] == loci.units[1]
        and 1 / _NARROW <= np.ptp(loci.ranges[0]) / np.ptp(loci.ranges[1]) <= _NARROW
    ):
        axes.set_aspect("equal")
    axes.grid(color=COLOURS["grid"], lw=0.6)


def _draw_points(axes: Any, loci: Loci) -> None:
    """The singular points over one coordinate, on a line."""
    for curve in loci.curves:
        look = {"color": KIND_COLOURS[curve.kind], "ms": 7, "zorder": 4}
        axes.plot(curve.points[:, 0], [0.0], "D", label=curve.kind, **look)
    draw_cross(axes, _out(loci, 0), 0.0, label="configuration")
    axes.axhline(0.0, color=COLOURS["grid"], lw=1.0, zorder=1)
    axes.set(xlim=loci.ranges[0], ylim=(-1.0, 1.0), yticks=[])
    name = f"{loci.plane.names[0]} [{loci.units[0]}]"
    name_axes(axes, name + _caption(loci), colour=COLOURS["text"])


def draw_cross(axes: Any, u: float, v: float, **look: Any) -> None:
    """The configuration that is given."""
    axes.plot([u], [v], "+", color=COLOURS["text"], ms=11, mew=1.6, zorder=5, **look)


def _caption(loci: Loci) -> str:
    """Below the axes, where no curve is: that some may be missing."""
    return (
        f"\n{'curves' if len(loci.ranges) == 2 else 'points'} may be missing; raise --starts"
        if {MISSING, NONE_MET} & set(loci.notes)
        else ""
    )


def draw_locus(axes: Any, curve: Locus, *, emphasise: bool, words: str = "", **look: Any) -> None:
    """A curve, thin where it belongs to other working modes, with rings at its cusps; or a point.
    `words` stand before its kind in the legend.
    """
    name, style = words + curve.kind, {"color": KIND_COLOURS[curve.kind], **look}
    style |= {"gid": f"locus {curve.kind}"}
    points, mode = curve.points, curve.in_mode | (not emphasise)
    if curve.is_point:
        marker, what = (
            ("s", "self-motion") if curve.self_motion else ("D", "curves that nearly touch")
        )
        look = {"ms": 6, "zorder": 4, "clip_on": False}
        axes.plot(*points[:1].T, marker, label=f"{name}, {what}", **look, **style)
        return
    if curve.closed:
        points, mode = np.vstack([points, points[:1]]), np.append(mode, mode[0])
    if not mode.all():
        others = f"{name}, other working modes"
        axes.plot(*points.T, "-", lw=0.8, alpha=0.45, label=others, zorder=2, **style)
    if mode.any():
        strong = np.where(mode[:, None], points, np.nan)
        axes.plot(*strong.T, "-", lw=1.9, label=name, zorder=3, **style)
    if len(curve.cusps):
        ring = {"mfc": "white", "mec": style["color"], "ms": 6, "mew": 1.4}
        axes.plot(*curve.cusps.T, "o", label="cusp", zorder=4, gid="cusp", **ring)


def _out(loci: Loci, k: int) -> float:
    c = loci.plane.coordinates[k]
    return loci.plane.mechanism.value_out(c, c.reference[0])


_MOST_PANELS = 8
"""Sheets that are drawn, the largest first."""
_COLOURS = (COLOURS["grid"], SERIES[4], SERIES[0], SERIES[1])
"""Colours for none, one, two and more modes of a sheet at one point."""
_COUNTS = ("no mode of the sheet", "one", "two", "three or more")
"""What the colours mean."""


def figure_of_mode_graph(graph: ModeGraph, *, route: np.ndarray | None = None) -> Figure:
    """A panel for each sheet: at each grid point how many of its modes belong to the sheet, edges
    without a singularity, the chosen input as a cross; `route` (m, joints), a path of
    `ModeGraph.path`, on the first panel.
    """
    count = min(len(graph.sheets), _MOST_PANELS)
    across = min(count, 4)
    down = max(1, -(-count // max(across, 1)))
    with drawing():
        high = 3.5 if len(graph.axes) == 2 else 1.3
        figure = new_figure(3.6 * max(across, 1) + 0.6, high * down + 0.9)
        axes = np.atleast_1d(figure.subplots(down, max(across, 1), squeeze=False)).ravel()
        there = set[int]()
        for k, panel in enumerate(axes):
            if k < count:
                there |= _sheet(panel, graph, k)
            else:
                panel.set_axis_off()
        if route is not None and count:
            last = len(graph.found) - 1
            shown = next(
                (k for k in range(count) if any(point == last for point, _ in graph.sheets[k])), 0
            )
            axes[shown].plot(
                *_places(graph, route).T, "-", color=COLOURS["accent"], lw=2.0, zorder=4
            )
        more = "" if count == len(graph.sheets) else f", the {count} largest of {len(graph.sheets)}"
        keys = {_COUNTS[k]: axes[0].scatter([], [], s=22, c=_COLOURS[k]) for k in sorted(there)}
        foot_legend(figure, keys, 4)
        title = f"{graph.mechanism.name}: modes joined without a singularity{more}"
        head(figure, title, 12)
    return figure


def _places(graph: ModeGraph, points: np.ndarray) -> np.ndarray:
    """Places (m, 2) of known values (m, names) in a panel; over one axis on a line."""
    columns = [graph.names.index(axis.name) for axis in graph.axes]
    flat = points[:, columns]
    return flat if len(columns) == 2 else np.hstack([flat, np.zeros((len(flat), 1))])


def _sheet(panel: Any, graph: ModeGraph, k: int) -> set[int]:
    """Draw a sheet; which of the colours it has."""
    points, sheet = _places(graph, graph.inputs), graph.sheets[k]
    for (a, i), (b, _) in graph.edges:
        if (a, i) in sheet:
            panel.plot(*points[[a, b]].T, "-", color=COLOURS["base"], lw=0.8, zorder=1)
    counts = np.bincount([point for point, _ in sheet], minlength=len(points))[:-1]
    kinds = np.minimum(counts, len(_COLOURS) - 1)
    panel.scatter(*points[:-1].T, s=22, c=[_COLOURS[kind] for kind in kinds], zorder=2)
    mine = [str(mode + 1) for point, mode in sorted(sheet) if point == len(points) - 1]
    if mine:
        draw_cross(panel, *points[-1])
    of = f": mode{'s' if len(mine) > 1 else ''} {', '.join(mine)} of the input" if mine else ""
    subtitle(panel, f"sheet {k + 1}{of}")
    panel.locator_params(nbins=5)
    titles = [f"{axis.name} [{_unit(graph, axis.name)}]" for axis in graph.axes]
    name_axes(panel, titles[0], titles[1] if len(titles) == 2 else None, COLOURS["text"])
    if len(titles) == 1:
        panel.set(yticks=[], ylim=(-1.0, 1.0))
    return set(kinds.tolist())


def _unit(graph: ModeGraph, name: str) -> str:
    coordinate = given_coordinates(graph.mechanism)[name]
    return graph.mechanism.unit_of(coordinate)
