"""The picture of a Jacobian: its matrix at one configuration, with the names of its rows and
columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS
from symkin.errors import InputError
from symkin.plots.sheet import colour_bar, drawing, head, new_figure, subtitle
from symkin.position.given import given_coordinates
from symkin.position.solve_result import SolveError
from symkin.singularities.configuration import configuration
from symkin.text import matplotlib_text
from symkin.velocity.jacobian import Jacobian, Values
from symkin.velocity.jacobian_names import TWIST

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_WRITTEN = 144
"""Entries whose numbers are written into their cells."""
_ROUNDING = 1e-13
"""Entries of no more than this share of the largest are written as 0."""


def figure_of_jacobian(jacobian: Jacobian, *, at: Values | None = None) -> Figure:
    """The entries with their numbers, colours by their size with angles times the mechanism's size;
    `at` is the configuration (default: the reference). Raises InputError where the matrix is not
    defined there.
    """
    mechanism, kind = jacobian.mechanism, jacobian.kind
    where, end = ("reference configuration", " at the reference") if at is None else ("", "")
    try:
        matrix = jacobian.at(_reference(jacobian) if at is None else at)
    except SolveError as error:
        raise InputError(f"plot: {error}; give a regular configuration with at=...") from None
    if not np.isfinite(matrix).all():
        raise InputError(
            f"plot: the {kind} Jacobian is not defined at the {where or 'configuration'}; give a "
            f"regular one with at=..."
        )
    what = "rates of rows by columns" if kind == "rates" else f"{kind} Jacobian"
    return _matrix_figure(jacobian, matrix, f"{mechanism.name}: {what}{end}")


def _reference(jacobian: Jacobian) -> Values:
    """The reference, or where coordinates are told by name what they reach from there."""
    rates, mechanism = jacobian.expressions, jacobian.mechanism
    if rates.limbs is not None:
        return jacobian.closure.reference
    known = rates.problem.known_coordinates
    return configuration(
        mechanism, given={c.name: mechanism.value_out(c, c.reference[0]) for c in known}
    )


def _matrix_figure(jacobian: Jacobian, matrix: np.ndarray, title: str) -> Figure:
    rows, columns = jacobian.shape
    with drawing():
        size = max(4.2, 2.6 + 0.75 * columns, 0.1 * len(title)), max(2.6, 1.9 + 0.42 * rows)
        figure = new_figure(*size)
        ax: Any = figure.add_subplot()
        weights = [np.array(_weights(jacobian, n)) for n in (jacobian.rows, jacobian.columns)]
        shade = matrix * weights[0][:, None] / weights[1]
        reach = float(np.max(np.abs(shade), initial=0.0)) or 1.0
        image = ax.imshow(shade, cmap="RdBu_r", vmin=-reach, vmax=reach, aspect="auto")
        ax.set_xticks(
            range(columns),
            [matplotlib_text(name) for name in jacobian.columns],
            rotation=45,
            ha="right",
        )
        ax.set_yticks(range(rows), [matplotlib_text(name) for name in jacobian.rows])
        if matrix.size <= _MOST_WRITTEN:
            for (i, j), value in np.ndenumerate(matrix):
                look = {"color": "white" if abs(shade[i, j]) > 0.6 * reach else COLOURS["text"]}
                look |= {"ha": "center", "va": "center"}
                written = value if abs(shade[i, j]) > _ROUNDING * reach else 0.0
                ax.text(j, i, f"{written + 0.0:.3g}", fontsize=7.5, **look)
        weighed = len(set(np.concatenate(weights))) > 1
        colour_bar(ax, image, "colours: angles\ntimes the size" if weighed else "", shrink=0.9)
        subtitle(ax, f"lengths in {jacobian.mechanism.length_unit}, angles in rad", 8.0)
        head(figure, title, 11)
    return figure


def _weights(jacobian: Jacobian, names: Sequence[str]) -> list[float]:
    """The size for each angle or part of a quaternion, 1 for each length; a joint may have the name
    of a pose's coordinate or of a twist's.
    """
    mechanism = jacobian.mechanism
    if names == TWIST:
        lengths = set(TWIST[:3])
    elif jacobian.kind == "analytic" and names is jacobian.rows:
        lengths = {"x", "y", "z"}
    else:
        lengths = {name for name, c in given_coordinates(mechanism).items() if c.is_length}
    return [1.0 if name in lengths else mechanism.characteristic_length for name in names]
