"""The picture of a singularity: the configuration, with the axes of the platform's motions that the actuated joints do not
hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

from symkin.plain_number import plain
from symkin.plots.mechanism_lines import lines_at
from symkin.plots.panel_figure import Panel, panel_figure
from symkin.singularities.singularity_result import Singularity

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_of_singularity(found: Singularity) -> Figure:
    """One panel: the mechanism at the configuration; platform motions as dashed axes, translations as arrows."""
    solution, mechanism = found.solution, found.solution.mechanism
    kinds = ", ".join(found.kinds) + " singularity" if found.kinds else "singular" if found.is_singular else "regular"
    twists = "\n".join(str(twist) for twist in found.twists)
    panel = Panel(kinds, twists, lines_at(mechanism, solution.values, solution.pose), found.twists)
    distances = ", ".join(f"{kind} {plain(value):.3g}" for kind, value in found.distances.items())
    return panel_figure(mechanism, [panel], [f"distance from singularities (0 singular): {distances}"])
