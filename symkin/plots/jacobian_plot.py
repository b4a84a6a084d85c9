"""The picture of a Jacobian: its matrix at one configuration, with the names of its rows and columns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.errors import InputError
from symkin.plots.style import COLOURS, drawing
from symkin.text import matplotlib_text
from symkin.velocity.jacobian import Jacobian, Values

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_WRITTEN = 144
"""Entries whose numbers are written into their cells."""


def figure_of_jacobian(jacobian: Jacobian, *, at: Values | None = None) -> Figure:
    """Colours by the entries' values, rotations' rows and lengths' rows by one scale; `at` is the configuration (default: the
    reference). Raises InputError where the matrix is not finite there."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    matrix = jacobian.at(jacobian.closure.reference if at is None else at)
    if not np.isfinite(matrix).all():
        where = "reference configuration" if at is None else "configuration"
        raise InputError(f"plot: the {jacobian.kind} Jacobian is not defined at the {where}; give a regular one with at=...")
    rows, columns = jacobian.shape
    with drawing():
        figure = Figure(figsize=(2.6 + 0.75 * columns, 1.9 + 0.42 * rows), facecolor="white", layout="constrained")
        FigureCanvasAgg(figure)
        ax: Any = figure.add_subplot()
        reach = float(np.max(np.abs(matrix), initial=0.0)) or 1.0
        image = ax.imshow(matrix, cmap="RdBu_r", vmin=-reach, vmax=reach, aspect="auto")
        ax.set_xticks(range(columns), [matplotlib_text(name) for name in jacobian.columns], rotation=45, ha="right")
        ax.set_yticks(range(rows), [matplotlib_text(name) for name in jacobian.rows])
        if matrix.size <= _MOST_WRITTEN:
            for (i, j), value in np.ndenumerate(matrix):
                colour = "white" if abs(value) > 0.6 * reach else COLOURS["text"]
                ax.text(j, i, f"{value + 0.0:.3g}", ha="center", va="center", fontsize=7.5, color=colour)
        figure.colorbar(image, ax=ax, shrink=0.9)
        title = f"{jacobian.mechanism.name}: {jacobian.kind} Jacobian"
        ax.set_title(title + (" at the reference" if at is None else ""), fontsize=11, color=COLOURS["text"], parse_math=False)
    return figure
