"""Pictures of a calibration: residuals, parameter changes with their standard deviations, pose
sigma over the workspace; and of a plan, where its configurations are and what is expected of them.
"""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.data.observables import ParameterKind, judged_link, unit_of, value_out
from symkin.calibration.design.planning import Plan
from symkin.calibration.judge.departure import judged_poses
from symkin.drawing.outline import grouped
from symkin.drawing.palette import COLOURS, SERIES
from symkin.errors import InputError
from symkin.plots.label_placement import Box, Label, Page
from symkin.plots.sheet import (
    colour_bar,
    drawing,
    foot_legend,
    head,
    labelled,
    name_axes,
    new_figure,
    note,
    open_axes,
    own_legend,
    subtitle,
    text_extent,
)
from symkin.text import not_among

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from symkin.calibration.judge.accuracy import PoseSigma
    from symkin.calibration.judge.result import Calibration, Parameter
    from symkin.model.mechanism import Mechanism

_MOST_BARS = 60
"""Parameters that one picture shows, those that changed most."""
_SEEN, _HIGH = 40.0, 2.0
"""Residuals that reach so many standard deviations make the normal curve too narrow to be drawn;
above so many times the highest bar it is cut off.
"""
_TOLD, _FAR, _LINEAR = 3.0, 40.0, 10.0
"""A change of so many standard deviations is told by the readings; where one reaches the second,
the axis is logarithmic beyond the third.
"""
_MOST_POSES = 1000
"""Measured poses that are drawn, spread evenly over the file."""


def figure_of_calibration(fit: Calibration, *, what: str = "parameters") -> Figure:
    """The changes of the parameters, or with `what` = "residuals" the normalised residuals. Raises
    InputError.
    """
    figures = {"parameters": parameter_figure, "residuals": residual_figure}
    if what not in figures:
        raise InputError(f"plot: what = {not_among(what, figures)}")
    return figures[what](fit)


@drawing()
def residual_figure(fit: Calibration) -> Figure:
    """Normalised residuals by posture, and their distribution beside the normal one."""
    rows = [r for r in fit.residuals if r.normalised is not None]
    figure = new_figure(11.0, 4.4)
    left, right = open_axes(figure, (3, 1), sharey=True)
    for kind, colour in zip(dict.fromkeys(r.kind for r in rows), cycle(SERIES)):
        own = [r for r in rows if r.kind == kind]
        look = {"label": "inclination in its group" if kind == "group" else kind, "color": colour}
        places = [r.configuration + 1 for r in own]
        left.plot(places, [r.normalised for r in own], ".", ms=5, **look)
    values = np.array([r.normalised for r in rows], dtype=float)
    reach = max(4.0, 1.1 * float(np.max(np.abs(values), initial=0.0)))
    _lines(left.axhline)
    flagged = {(o.configuration, o.kind) for o in fit.outliers}
    for number in sorted({posture for posture, _ in flagged}):
        left.axvline(number + 1, color=COLOURS["accent"], lw=1, alpha=0.5)
    left.set_ylim(-reach, reach)
    name_axes(left, "posture", "residual over its standard deviation")
    title = "residuals" + (f"; {len(flagged)} outliers left out (lines)" if flagged else "")
    subtitle(left, title, loc="left")
    _legend(left, ncols=3)
    _distribution(right, values, reach)
    head(figure, f"{fit.mechanism.name}: residuals of the calibration", 12)
    return figure


def _legend(ax: Axes, **options: Any) -> None:
    """The legend above the axes, at their right end."""
    place = {"loc": "lower right", "borderaxespad": 0.2, "bbox_to_anchor": (1.0, 1.0)}
    own_legend(ax, labelled(ax), fontsize=9, **place | options)


def _lines(line: Any) -> None:
    """A line at zero, and those within which the readings tell nothing."""
    line(0.0, color=COLOURS["quiet"], lw=0.8)
    for level in (-_TOLD, _TOLD):
        line(level, color=COLOURS["quiet"], lw=0.8, ls="--")


def _distribution(ax: Axes, values: np.ndarray, reach: float) -> None:
    """Readings by the size of their residual, and how many the normal distribution has there: N w
    exp(-t^2 / 2) / sqrt(2 pi) for N readings and bins of width w, or a band over its three standard
    deviations where it is too narrow to be drawn.
    """
    from matplotlib.ticker import MaxNLocator

    if len(values):
        bins = min(40, max(8, len(values) // 8))
        counts, edges = np.histogram(values, bins=bins, range=(-reach, reach))
        width, colour = float(edges[1] - edges[0]), COLOURS["bar"]
        ax.barh(edges[:-1], counts, width, align="edge", color=colour, label="residuals")
        t = np.linspace(-reach, reach, 400)
        normal = len(values) * width * np.exp(-0.5 * t * t) / np.sqrt(2 * np.pi)
        if reach < _SEEN:
            ax.set_xlim(right=1.05 * min(max(counts.max(), normal.max()), _HIGH * counts.max()))
            ax.plot(normal, t, color=COLOURS["text"], lw=1.2, label="normal")
        else:
            ax.axhspan(-3.0, 3.0, color=COLOURS["text"], lw=1.5, label="normal, three sigma")
        _legend(ax, ncols=2, handlelength=1.2)
    name_axes(ax, "number of readings")
    ax.set_xlim(left=0)
    ax.xaxis.set_major_locator(MaxNLocator(3, integer=True))


@drawing()
def parameter_figure(fit: Calibration) -> Figure:
    """Changes from nominal with two standard deviations, and the changes over their standard
    deviations: two panels a unit.
    """
    chosen = fit.free or [p for p in fit.parameters if not p.held]
    own = sorted(chosen, key=fit.parameters.index)
    kinds = [k for k in get_args(ParameterKind) if any(p.kind == k for p in own)]
    shown = {k: _most_changed([p for p in own if p.kind == k]) for k in kinds}
    rows = max(len(kept) for kept in shown.values())
    figure = new_figure(2.0 + 6.0 * len(kinds), 1.9 + 0.19 * rows)
    panels = iter(open_axes(figure, (3, 2) * len(kinds)))
    for kind, kept in shown.items():
        free = sum(p.kind == kind for p in own)
        title = f"{len(kept)} of {free} {kind}s, bars of two sigma"
        _changes(next(panels), kept, kind, fit.mechanism, title)
        _ratios(next(panels), kept)
    head(figure, f"{fit.mechanism.name}: what the calibration changed", 12)
    return figure


def _most_changed(parameters: list[Parameter]) -> list[Parameter]:
    """Those that changed most, as many as one picture shows, in their order."""
    most = sorted(parameters, key=lambda p: -abs(p.change))[:_MOST_BARS]
    return sorted(most, key=parameters.index)


def _bars(ax: Axes, values: np.ndarray, colour: Any) -> np.ndarray:
    """Draw bars from above, and return their places."""
    places = np.arange(len(values))[::-1]
    ax.barh(places, np.nan_to_num(values), color=colour, height=0.7)
    ax.set_ylim(-1, len(values))
    return places


def _changes(
    ax: Axes, kept: list[Parameter], kind: ParameterKind, m: Mechanism, title: str
) -> None:
    one = value_out(m, kind, 1.0)
    changes = np.array([one * p.change for p in kept])
    places = _bars(ax, changes, COLOURS["bar"])
    spread = [2 * one * (p.sigma or 0.0) for p in kept]
    look: dict[str, Any] = {"fmt": "none", "ecolor": COLOURS["text"], "elinewidth": 1, "capsize": 2}
    ax.errorbar(changes, places, xerr=spread, **look)
    ax.set_yticks(places, [p.name for p in kept], fontsize=7, parse_math=False)
    ax.axvline(0, color=COLOURS["quiet"], lw=0.8)
    ax.locator_params("x", nbins=5)
    name_axes(ax, f"identified less nominal [{unit_of(m, kind) or '1'}]")
    subtitle(ax, title, loc="left")


def _ratios(ax: Axes, kept: list[Parameter]) -> None:
    """Changes over their standard deviations, those within three of them pale; logarithmic beyond
    ten where they reach far.
    """
    ratios = np.array([p.change / p.sigma if p.sigma else np.nan for p in kept])
    reach = float(np.nanmax(np.abs(ratios))) if np.any(np.isfinite(ratios)) else 0.0
    _bars(ax, ratios, np.where(np.abs(ratios) <= _TOLD, COLOURS["pale"], COLOURS["platform"]))
    ax.set_yticks([])
    _lines(ax.axvline)
    if reach > _FAR:
        ax.set_xscale("symlog", linthresh=_LINEAR)
        top = int(np.log10(reach))
        powers = [10.0**k for k in range(top, 0, -max(1, (top + 1) // 2))][::-1]
        ax.set_xticks([*(-p for p in reversed(powers)), 0.0, *powers])
    ax.set_xlim(*(np.array([-1.0, 1.0]) * max(1.3 * reach, _TOLD + 1.0)))
    name_axes(ax, "identified less nominal over sigma")
    subtitle(ax, "in sigma, lines at three" if reach else "sigma unknown", loc="left")


@drawing()
def pose_sigma_figure(fit: Calibration, sigma: PoseSigma) -> Figure:
    """Standard deviations of position and orientation over the poses, seen from above and from the
    side, and the poses measured.
    """
    m, measured, used = fit.mechanism, _platform_positions(fit), len(fit.used)
    judged = f"the {m.frame_name}" if m.platform_link is not None else f"link {judged_link(m)}"
    told = f"{len(measured)} of {used}" if len(measured) < used else str(used)
    figure = new_figure(11.0, 5.0)
    angles = sigma.angle * m.angle_out(1.0)
    shown = (
        (1, sigma.position, "position", m.length_unit, "above"),
        (2, angles, "orientation", m.angle_unit, "the side"),
    )
    for ax, (up, values, what, unit, side) in zip(open_axes(figure, (1, 1)), shown, strict=True):
        dots = ax.scatter(sigma.poses[:, 0], sigma.poses[:, up], c=values, s=22, cmap="viridis")
        look = {"ms": 4, "mew": 0.9, "color": COLOURS["accent"]}
        ax.plot(*measured[:, [0, up]].T, "x", label=f"measured, {told} postures", **look)
        colour_bar(ax, dots, f"sigma of {what} [{unit}]")
        name_axes(ax, *(f"{axis} of {judged} [{m.length_unit}]" for axis in ("x", "xyz"[up])))
        subtitle(ax, f"sigma of the {what}, seen from {side}", loc="left")
        ax.set_aspect("equal", adjustable="datalim")
    foot_legend(figure, labelled(ax), 1)
    head(figure, f"{m.name}: how well poses are known after the calibration", 12)
    return figure


def _platform_positions(fit: Calibration) -> np.ndarray:
    """Where the platform frame was (n, 3) in the measured postures, in the base frame: observed
    poses less the measuring frames.
    """
    rows, state = spread_rows(len(fit.poses), _MOST_POSES), fit.state
    joints = fit.problem.measurements.joints[rows]
    return judged_poses(fit.problem, state.p, state.z[rows], joints)[:, :3]


_MOST_NUMBERED = 60
"""Configurations whose numbers are written beside them."""
_POINT, _BESIDE = 3.5, 22.0
"""Pixels of a configuration's mark to its middle, and of its number from it where there is room."""
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
    figure.draw_without_rendering()  # lays the axes out
    for ax, (u, v) in ((first, (0, 1)), (second, (0, 2))):
        _number(ax, np.asarray(plan.configurations.poses)[:, [u, v]])
    return figure


def _places(ax: Any, plan: Plan, u: int, v: int) -> None:
    points = np.asarray(plan.configurations.poses)[:, [u, v]]
    for group in np.unique(plan.groups):
        here = points[plan.groups == group]
        name = "" if group < 0 else f"group {group + 1}"
        ax.plot(*here.T, "o", ms=5, color=SERIES[int(group) % len(SERIES)], label=name or None)
    name_axes(ax, *(f"{'xyz'[k]} [{plan.mechanism.length_unit}]" for k in (u, v)))
    ax.set_aspect("equal", adjustable="datalim")
    ax.grid(color=COLOURS["grid"], lw=0.6)


def _number(ax: Any, points: np.ndarray) -> None:
    """Write numbers beside the points, over no other point."""
    area, pixels = ax.get_window_extent(), ax.transData.transform
    page = Page(area.width, area.height, left=area.x0, foot=area.y0)
    page.symbols = [Box(float(x), float(y), _POINT, _POINT) for x, y in pixels(points)]
    for numbers, point in _numbered(points):
        anchor, look = pixels(point), {"fontsize": 7, "color": COLOURS["quiet"]}
        wide, high = text_extent(ax, numbers, 7.0)
        wish = np.array([0.8, 0.6])
        label = Label(numbers, anchor, _POINT + 1.0, 7.0, look, wish, wide, high)
        box = page.find(label, _BESIDE) or page.place(label)
        away = 72.0 / ax.figure.dpi * (np.array([box.x, box.y]) - anchor)
        note(ax, numbers, point, tuple(away), ha="center", va="center", **look)


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
    name_axes(ax, "", f"expected error of {label}")
    ax.margins(0.12, 0.12)
