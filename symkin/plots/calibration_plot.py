"""Pictures of a calibration: residuals, parameter changes with their standard deviations, pose
sigma over the workspace.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from symkin.calibration.data.measurements import spread_rows
from symkin.calibration.data.observables import ParameterKind, judged_link, unit_of, value_out
from symkin.calibration.judge.departure import judged_poses
from symkin.drawing.palette import COLOURS
from symkin.errors import InputError
from symkin.plots.sheet import blank_figure
from symkin.plots.style import drawing
from symkin.text import matplotlib_text, not_among

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from symkin.calibration.judge.accuracy import PoseSigma
    from symkin.calibration.judge.result import Calibration, Parameter
    from symkin.model.mechanism import Mechanism

_DPI = 130
_COMPRESSION = 2
"""Of 9: files a tenth larger than the smallest, written in a third of the time."""
_BELOW, _ABOVE, _ASIDE, _CHARACTER = 0.55, 0.45, 0.75, 0.064
"""Inches that axes leave below for their label, above for title and legend, and aside for numbers
and a label, and a character of a parameter's name. A layout that measures every text takes as long
as the drawing.
"""
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
_KINDS = {
    "group": "#2f7fc1",
    "inclination": "#e8743b",
    "position": "#3a9d5d",
    "orientation": "#8c5fbf",
    "distance": "#b5892b",
}
_OTHER_KINDS = (
    "#2f7fc1",
    "#3a9d5d",
    "#e8743b",
    "#8c5fbf",
    "#1f2933",
    "#c2477f",
    "#2aa198",
    "#7d8f1f",
)
"""Colours of readings of joints, points and other links, in turn."""
_AXES_OF = {
    "group": "inclination in its group",
    "inclination": "inclination",
    "position": "position",
    "orientation": "orientation",
    "distance": "distance",
}


@drawing()
def png(figure: Figure) -> bytes:
    """The picture as a PNG file's content."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.image import imsave

    content = io.BytesIO()
    canvas: Any = FigureCanvasAgg(figure)
    figure.dpi = _DPI
    canvas.draw()  # once, where savefig draws twice
    settings = {"compress_level": _COMPRESSION}
    imsave(content, canvas.buffer_rgba(), format="png", dpi=_DPI, pil_kwargs=settings)
    return content.getvalue()


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
    figure, (left, right) = _figure(11, 4.2, (3, 1), (_ASIDE, _ASIDE, 0.2))
    flagged = {(o.configuration, o.kind) for o in fit.outliers}
    others = cycle(_OTHER_KINDS)
    for kind in dict.fromkeys(r.kind for r in rows):
        colour = _KINDS[kind] if kind in _KINDS else next(others)
        chosen = [r for r in rows if r.kind == kind]
        left.plot(
            [r.configuration + 1 for r in chosen],
            [r.normalised for r in chosen],
            ".",
            ms=5,
            color=colour,
            label=_AXES_OF.get(kind, kind),
        )
    values = np.array([r.normalised for r in rows], dtype=float)
    reach = max(4.0, 1.1 * float(np.max(np.abs(values), initial=0.0)))
    for level in (-3, 3):
        left.axhline(level, color=COLOURS["quiet"], lw=0.8, ls="--")
    left.axhline(0, color=COLOURS["quiet"], lw=0.8)
    for number in sorted({posture for posture, _ in flagged}):
        left.axvline(number + 1, color=COLOURS["accent"], lw=1, alpha=0.5)
    left.set(xlabel="posture", ylabel="residual over its standard deviation", ylim=(-reach, reach))
    title = "Residuals" + (f"; {len(flagged)} outliers left out (lines)" if flagged else "")
    left.set_title(title, loc="left")
    if len(values):
        _legend(left, 1.0, ncols=3)
    _distribution(right, values, reach)
    return figure


def _legend(axes: Axes, across: float, **options: Any) -> None:
    """The legend above the axes, at their left (0) or right (1) end."""
    place: Any = {"loc": "lower right" if across else "lower left", "borderaxespad": 0.2}
    axes.legend(bbox_to_anchor=(across, 1.0), frameon=False, **place | options)


def _distribution(axes: Axes, values: np.ndarray, reach: float) -> None:
    """Readings by the size of their residual, and how many the normal distribution has there: N w
    exp(-t^2 / 2) / sqrt(2 pi) for N readings and bins of width w, or a band over its three standard
    deviations where it is too narrow to be drawn.
    """
    from matplotlib.ticker import MaxNLocator

    if len(values):
        counts, edges = np.histogram(
            values, bins=min(40, max(8, len(values) // 8)), range=(-reach, reach)
        )
        width = float(edges[1] - edges[0])
        axes.barh(
            edges[:-1], counts, height=width, align="edge", color="#9cc3e4", label="residuals"
        )
        t = np.linspace(-reach, reach, 400)
        normal = len(values) * width * np.exp(-0.5 * t * t) / np.sqrt(2 * np.pi)
        if reach < _SEEN:
            axes.set_xlim(right=1.05 * min(max(counts.max(), normal.max()), _HIGH * counts.max()))
            axes.plot(normal, t, color=COLOURS["text"], lw=1.2, label="normal")
        else:
            axes.axhspan(-3.0, 3.0, color=COLOURS["text"], lw=1.5, label="normal, three sigma")
        _legend(axes, 1.0, ncols=2, handlelength=1.2)
    axes.set(ylim=(-reach, reach), xlabel="number of readings")
    axes.set_xlim(left=0)
    axes.xaxis.set_major_locator(MaxNLocator(3, integer=True))


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
    aside = [0.2 + _CHARACTER * max(len(p.name) for p in shown[k]) for k in kinds]
    figure, panels = _figure(
        2.0 + 6.0 * len(kinds),
        1.6 + 0.19 * rows,
        (3, 2) * len(kinds),
        [*(inches for names in aside for inches in (names, 0.2)), 0.2],
    )
    for k, kind in enumerate(kinds):
        free = sum(p.kind == kind for p in own)
        _changes(
            panels[2 * k],
            shown[kind],
            kind,
            fit.mechanism,
            f"{len(shown[kind])} of {free} {kind}s, bars of two sigma",
        )
        _ratios(panels[2 * k + 1], shown[kind])
    return figure


def _most_changed(parameters: list[Parameter]) -> list[Parameter]:
    """Those that changed most, as many as one picture shows, in their order."""
    return sorted(
        sorted(parameters, key=lambda p: -abs(p.change))[:_MOST_BARS], key=parameters.index
    )


def _changes(
    axes: Axes, kept: list[Parameter], kind: ParameterKind, m: Mechanism, title: str
) -> None:
    places, one = np.arange(len(kept))[::-1], value_out(m, kind, 1.0)
    changes = [one * p.change for p in kept]
    axes.barh(places, changes, color="#9cc3e4", height=0.7)
    axes.errorbar(
        changes,
        places,
        xerr=[2 * one * (p.sigma or 0.0) for p in kept],
        fmt="none",
        ecolor=COLOURS["text"],
        elinewidth=1,
        capsize=2,
    )
    axes.set_yticks(places, [p.name for p in kept], fontsize=7)
    axes.set_ylim(-1, len(kept))
    axes.axvline(0, color=COLOURS["quiet"], lw=0.8)
    axes.set_xlabel(f"identified less nominal [{unit_of(m, kind) or '1'}]")
    axes.set_title(title, loc="left")


def _ratios(axes: Axes, kept: list[Parameter]) -> None:
    """Changes over their standard deviations, those within three of them pale; logarithmic beyond
    ten where they reach far.
    """
    places = np.arange(len(kept))[::-1]
    ratios = np.array([p.change / p.sigma if p.sigma else np.nan for p in kept])
    reach = float(np.nanmax(np.abs(ratios))) if np.any(np.isfinite(ratios)) else 0.0
    pale = np.where(np.abs(ratios) <= _TOLD, "#cfe0ee", "#2f7fc1")
    axes.barh(places, np.nan_to_num(ratios), color=pale, height=0.7)
    axes.set_yticks([])
    axes.set_ylim(-1, len(kept))
    for level in (-_TOLD, _TOLD):
        axes.axvline(level, color=COLOURS["quiet"], lw=0.8, ls="--")
    axes.axvline(0, color=COLOURS["quiet"], lw=0.8)
    if reach > _FAR:
        axes.set_xscale("symlog", linthresh=_LINEAR)
        top = int(np.log10(reach))
        powers = [10.0**k for k in range(top, 0, -max(1, (top + 1) // 2))][::-1]
        axes.set_xticks([*(-p for p in reversed(powers)), 0.0, *powers])
    axes.set_xlim(*(np.array([-1.0, 1.0]) * max(1.3 * reach, _TOLD + 1.0)))
    axes.set_xlabel("identified less nominal over sigma")
    axes.set_title("in sigma, lines at three" if reach else "sigma unknown", loc="left")


@drawing()
def pose_sigma_figure(fit: Calibration, sigma: PoseSigma) -> Figure:
    """Standard deviations of position and orientation over the poses, seen from above and from the
    side, and the poses measured.
    """
    m = fit.mechanism
    judged = (
        "the platform" if m.platform_link is not None else f"link {matplotlib_text(judged_link(m))}"
    )
    figure, (above, bar, beside, other) = _figure(
        11, 4.8, (1, 0.04, 1, 0.04), (_ASIDE, 0.15, 0.9 + _ASIDE, 0.15, 0.9)
    )
    measured = _platform_positions(fit)
    angles = sigma.angle * m.angle_out(1.0)
    shown = (
        (above, bar, 1, sigma.position, "position", m.length_unit, "above"),
        (beside, other, 2, angles, "orientation", m.angle_unit, "the side"),
    )
    for axes, scale, up, values, what, unit, side in shown:
        dots = axes.scatter(sigma.poses[:, 0], sigma.poses[:, up], c=values, s=22, cmap="viridis")
        axes.plot(
            measured[:, 0],
            measured[:, up],
            "x",
            ms=4,
            mew=0.9,
            color=COLOURS["accent"],
            label=f"measured, {_drawn_of(measured, fit)}",
        )
        figure.colorbar(dots, cax=scale, label=f"sigma of {what} [{unit}]")
        axes.set(
            xlabel=f"x of {judged} [{m.length_unit}]",
            ylabel=f"{'xyz'[up]} of {judged} [{m.length_unit}]",
        )
        axes.set_title(f"Sigma of the {what}, seen from {side}", loc="left", pad=18)
        _legend(axes, 0.0, borderaxespad=0.1, handletextpad=0.2)
    return figure


def _drawn_of(measured: np.ndarray, fit: Calibration) -> str:
    few = len(measured) < len(fit.used)
    return f"{len(measured)} of {len(fit.used)} postures" if few else f"{len(measured)} postures"


def _platform_positions(fit: Calibration) -> np.ndarray:
    """Where the platform frame was (n, 3) in the measured postures, in the base frame: observed
    poses less the measuring frames.
    """
    rows, state = spread_rows(len(fit.poses), _MOST_POSES), fit.state
    joints = fit.problem.measurements.joints[rows]
    return judged_poses(fit.problem, state.p, state.z[rows], joints)[:, :3]


def _figure(
    width: float, height: float, ratios: Sequence[float], aside: Sequence[float]
) -> tuple[Figure, Any]:
    """Set axes side by side, as wide as the ratios say of what the inches `aside`, before each and
    at the end, leave.
    """
    figure = blank_figure(width, height)
    share = (width - sum(aside)) / sum(ratios)
    bottom, tall = _BELOW / height, 1.0 - (_BELOW + _ABOVE) / height
    left, panels = 0.0, []
    for ratio, inches in zip(ratios, aside[:-1], strict=True):
        left += inches
        panels.append(figure.add_axes((left / width, bottom, share * ratio / width, tall)))
        left += share * ratio
        panels[-1].spines[["top", "right"]].set_visible(False)
    return figure, panels
