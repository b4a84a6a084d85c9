"""The picture of each result: what `result.plot()` draws, by the result's type. Matplotlib is imported only when one is drawn."""

from __future__ import annotations

from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.assembly.mode_list import Modes
from symkin.calibration.judge.result import Calibration
from symkin.errors import InputError
from symkin.following.mode_graph import ModeGraph
from symkin.following.track_result import Track
from symkin.plots.calibration_plot import figure_of_calibration
from symkin.plots.jacobian_plot import figure_of_jacobian
from symkin.plots.loci_plot import figure_of_loci
from symkin.plots.mode_graph_plot import figure_of_mode_graph
from symkin.plots.modes_plot import figure_of_modes, figure_of_solution, figure_of_solve
from symkin.plots.picture_file import check_picture_path, write_picture
from symkin.plots.singularity_plot import figure_of_singularity
from symkin.plots.sketch import figure_of_sketch
from symkin.plots.sweep_plot import figure_of_sweep
from symkin.plots.track_plot import figure_of_track
from symkin.position.mobility import Mobility
from symkin.position.solution import Solution
from symkin.position.solve_result import SolveResult
from symkin.singularities.loci import Loci
from symkin.singularities.singularity import Singularity
from symkin.sweeps.run import Swept
from symkin.velocity.jacobian import Jacobian

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(result: object, path: Path | str | None = None, **options: Any) -> Figure:
    """The figure of a result, written to `path` where one is given. Raises InputError for what has no picture, for options that
    it does not take, and for a file that cannot be written, before anything is drawn."""
    target = None if path is None else check_picture_path(path)
    try:
        figure = figure_of(result, **options)
    except TypeError as error:
        if "unexpected keyword argument" not in str(error):
            raise
        raise InputError(f"plot: {', '.join(options)} is not what the picture of a {type(result).__name__} takes") from None
    if target is not None:
        write_picture(figure, target)
    return figure


@singledispatch
def figure_of(result: object, **_: Any) -> Figure:
    """The figure of a result, by its type."""
    raise InputError(f"plot: a {type(result).__name__} has no picture")


figure_of.register(Calibration, figure_of_calibration)
figure_of.register(Jacobian, figure_of_jacobian)
figure_of.register(Loci, figure_of_loci)
figure_of.register(Mobility, lambda found: figure_of_sketch(found.closure.mechanism))
figure_of.register(ModeGraph, figure_of_mode_graph)
figure_of.register(Modes, figure_of_modes)
figure_of.register(Singularity, figure_of_singularity)
figure_of.register(Solution, figure_of_solution)
figure_of.register(SolveResult, figure_of_solve)
figure_of.register(Swept, figure_of_sweep)
figure_of.register(Track, figure_of_track)
