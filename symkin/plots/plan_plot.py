"""The picture of a measurement plan: where its configurations are, in their groups, and the
accuracy that is expected of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.calibration.design.planning import Plan
from symkin.drawing.outline import grouped
from symkin.drawing.palette import COLOURS, SERIES
from symkin.plots.sheet import foot_legend, head, labelled, name_axes, new_figure, note, open_axes
from symkin.plots.style import drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_NUMBERED = 60
"""Configurations whose numbers are written beside them."""
_NEAR = 0.06
"""Distance over the extent below which numbers would cover each other."""


@drawing()
def figure_of_plan(plan: Plan) -> Figure:
    """Positions of the platform or tool in two planes with their numbers, a colour a group, and the
    expected pose errors of the plan beside those of random configurations.
    """
    m = plan.mechanism
    figure = new_figure(11.0, 4.6)
    first, second, third, fourth = open_axes(figure, (3, 3, 1.4, 1.4))
    for ax, (u, v) in ((first, (0, 1)), (second, (0, 2))):
        _places(ax, plan, u, v)
    _errors(third, f"position [{m.length_unit}]", [plan.accuracy.position, plan.random.position])
    _errors(
        fourth,
        f"orientation [{m.angle_unit}]",
        [m.angle_out(plan.accuracy.angle), m.angle_out(plan.random.angle)],
    )
    title = f"{m.name}: {len(plan.groups)} configurations to measure, {plan.criterion}-optimal"
    head(figure, title, 12)
    foot_legend(figure, labelled(first), 6)
    return figure


def _places(ax: Any, plan: Plan, u: int, v: int) -> None:
    points = np.asarray(plan.configurations.poses)[:, [u, v]]
    for group in np.unique(plan.groups):
        here = points[plan.groups == group]
        name = "" if group < 0 else f"group {group + 1}"
        ax.plot(*here.T, "o", ms=5, color=SERIES[int(group) % len(SERIES)], label=name or None)
    for numbers, point in _numbered(points):
        note(ax, numbers, point, (4, 3), fontsize=7, color=COLOURS["quiet"])
    name_axes(ax, *(f"{'xyz'[k]} [{plan.mechanism.length_unit}]" for k in (u, v)))
    ax.set_aspect("equal", adjustable="datalim")
    ax.grid(color=COLOURS["grid"], lw=0.6)


def _numbered(points: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Numbers of the first configurations where they stand; those of near ones in one text."""
    near = _NEAR * float(np.ptp(points, axis=0).max())
    numbers = map(str, range(1, 1 + _MOST_NUMBERED))
    found = grouped(zip(numbers, points, strict=False), near)
    return [(", ".join(here), point) for here, point in found]


def _errors(ax: Any, label: str, values: list[float]) -> None:
    """Expected errors (root mean square) of the plan and of random configurations."""
    bars = ax.bar(
        ["plan", "random"], values, color=[COLOURS["platform"], COLOURS["base"]], width=0.6
    )
    ax.bar_label(
        bars, labels=[f"{value:.3g}" for value in values], fontsize=8, color=COLOURS["text"]
    )
    ax.set_ylabel(f"expected error of {label}")
    ax.margins(0.12, 0.12)
