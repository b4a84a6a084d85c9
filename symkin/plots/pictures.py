"""The picture of each result: what `result.plot()` draws, by the result's type. Matplotlib is
imported only when one is drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin.errors import InputError
from symkin.plots.picture_file import check_picture_path, write_picture
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
    "ModeGraph": ("mode_graph_plot", "figure_of_mode_graph"),
    "Modes": ("modes_plot", "figure_of_modes"),
    "Plan": ("plan_plot", "figure_of_plan"),
    "Singularity": ("singularity_plot", "figure_of_singularity"),
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
