"""The picture of each result: what `result.plot()` draws. Matplotlib is imported only when one is drawn."""

from __future__ import annotations

from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.assembly.mode_list import Modes
from symkin.errors import InputError
from symkin.following.mode_graph import ModeGraph
from symkin.following.track_result import Track
from symkin.plots.loci_plot import figure_of_loci
from symkin.plots.mode_graph_plot import figure_of_mode_graph
from symkin.plots.plot import check_picture_path, figure_of_modes, write_picture
from symkin.plots.sketch import figure_of_sketch
from symkin.plots.track_plot import figure_of_track
from symkin.position.mobility import Mobility
from symkin.singularities.loci import Loci

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(result: object, path: Path | str | None = None, **options: Any) -> Figure:
    """The figure of a result, written to `path` where one is given. Raises InputError for what has no picture, and for a file
    that cannot be written, before anything is drawn."""
    target = None if path is None else check_picture_path(path)
    figure = figure_of(result, **options)
    if target is not None:
        write_picture(figure, target)
    return figure


@singledispatch
def figure_of(result: object, **_: Any) -> Figure:
    """The figure of a result, by its type."""
    raise InputError(f"a {type(result).__name__} has no picture")


figure_of.register(Modes, figure_of_modes)
figure_of.register(Track, figure_of_track)
figure_of.register(Loci, figure_of_loci)
figure_of.register(ModeGraph, figure_of_mode_graph)


@figure_of.register
def _(result: Mobility) -> Figure:
    return figure_of_sketch(result.closure.mechanism)
