"""Pictures of a graph of assembly modes: one panel a sheet over the two inputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, SERIES
from symkin.plots.loci_plot import draw_cross
from symkin.plots.sheet import foot_legend, head, name_axes, new_figure, subtitle
from symkin.plots.style import drawing
from symkin.position.given import given_coordinates

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.following.mode_graph import ModeGraph

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
        for k, panel in enumerate(axes):
            if k < count:
                _sheet(panel, graph, k)
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
        keys = [axes[0].scatter([], [], s=22, c=colour) for colour in _COLOURS]
        foot_legend(figure, dict(zip(_COUNTS, keys, strict=True)), 4)
        title = f"{graph.mechanism.name}: modes joined without a singularity{more}"
        head(figure, title, 12)
    return figure


def _places(graph: ModeGraph, points: np.ndarray) -> np.ndarray:
    """Places (m, 2) of known values (m, names) in a panel; over one axis on a line."""
    columns = [graph.names.index(axis.name) for axis in graph.axes]
    flat = points[:, columns]
    return flat if len(columns) == 2 else np.hstack([flat, np.zeros((len(flat), 1))])


def _sheet(panel: Any, graph: ModeGraph, k: int) -> None:
    points, sheet = _places(graph, graph.inputs), graph.sheets[k]
    for (a, i), (b, _) in graph.edges:
        if (a, i) in sheet:
            panel.plot(*points[[a, b]].T, "-", color=COLOURS["base"], lw=0.8, zorder=1)
    counts = np.bincount([point for point, _ in sheet], minlength=len(points))[:-1]
    colours = [_COLOURS[min(c, len(_COLOURS) - 1)] for c in counts]
    panel.scatter(*points[:-1].T, s=22, c=colours, zorder=2)
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


def _unit(graph: ModeGraph, name: str) -> str:
    coordinate = given_coordinates(graph.mechanism)[name]
    return graph.mechanism.unit_of(coordinate)
