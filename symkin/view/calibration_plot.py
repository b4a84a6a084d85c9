"""Pictures of a calibration: residuals, parameter changes with their standard deviations, pose sigma over the workspace."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.view.box import COLOURS, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from symkin.calibration.calibrate import Calibration
    from symkin.calibration.prediction import PoseSigma

_DPI = 130
_MOST_BARS = 60
"""Parameters that one picture shows, those that changed most."""
_SEEN, _HIGH = 40.0, 2.0
"""Residuals that reach so many standard deviations make the normal curve too narrow to be drawn; above so many times the highest bar
it is cut off."""
_KINDS = {"group": "#2f7fc1", "inclination": "#e8743b", "position": "#3a9d5d", "orientation": "#8c5fbf", "distance": "#b5892b"}
_AXES_OF = {
    "group": "inclination in its group", "inclination": "inclination", "position": "position", "orientation": "orientation",
    "distance": "distance",
}  # fmt: skip


@drawing()
def png(figure: Figure) -> bytes:
    """The picture as a PNG file's content."""
    content = io.BytesIO()
    figure.savefig(content, dpi=_DPI, format="png")
    return content.getvalue()


@drawing()
def residual_figure(fit: Calibration) -> Figure:
    """Normalised residuals by posture, and their distribution beside the normal one."""
    rows = [r for r in fit.residuals if r.normalised is not None]
    figure, (left, right) = _figure(11, 4.2, (3, 1))
    flagged = {(o.posture, o.kind) for o in fit.outliers}
    for kind in dict.fromkeys(r.kind for r in rows):
        chosen = [r for r in rows if r.kind == kind]
        left.plot(
            [r.posture + 1 for r in chosen], [r.normalised for r in chosen], ".", ms=5, color=_KINDS.get(kind, COLOURS["text"]),
            label=_AXES_OF.get(kind, kind),
        )  # fmt: skip
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
        left.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False, ncols=3, borderaxespad=0.2)
    _distribution(right, values, reach)
    return figure


def _distribution(axes: Axes, values: np.ndarray, reach: float) -> None:
    """Readings by the size of their residual, and how many the normal distribution has there: N w exp(-t^2 / 2) / sqrt(2 pi) for N
    readings and bins of width w, or a band over its three standard deviations where it is too narrow to be drawn."""
    from matplotlib.ticker import MaxNLocator

    if len(values):
        counts, edges = np.histogram(values, bins=min(40, max(8, len(values) // 8)), range=(-reach, reach))
        width = float(edges[1] - edges[0])
        axes.barh(edges[:-1], counts, height=width, align="edge", color="#9cc3e4", label="residuals")
        t = np.linspace(-reach, reach, 400)
        normal = len(values) * width * np.exp(-0.5 * t * t) / np.sqrt(2 * np.pi)
        if reach < _SEEN:
            axes.set_xlim(right=1.05 * min(max(counts.max(), normal.max()), _HIGH * counts.max()))
            axes.plot(normal, t, color=COLOURS["text"], lw=1.2, label="normal")
        else:
            axes.axhspan(-3.0, 3.0, color=COLOURS["text"], lw=1.5, label="normal, three sigma")
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False, ncols=2, borderaxespad=0.2, handlelength=1.2)
    axes.set(ylim=(-reach, reach), xlabel="number of readings")
    axes.set_xlim(left=0)
    axes.xaxis.set_major_locator(MaxNLocator(3, integer=True))


@drawing()
def parameter_figure(fit: Calibration) -> Figure:
    """Changes from nominal with two standard deviations, one panel a unit."""
    m = fit.mechanism
    kinds = [k for k in ("length", "angle", "number") if any(p.kind == k and not p.held for p in fit.parameters)]
    most = max(min(_MOST_BARS, sum(p.kind == k and not p.held for p in fit.parameters)) for k in kinds)
    figure, panels = _figure(4.2 + 3.6 * len(kinds), 1.6 + 0.19 * most, (1,) * len(kinds))
    for axes, kind in zip(panels, kinds, strict=True):
        free = [p for p in fit.parameters if p.kind == kind and not p.held]
        kept = sorted(sorted(free, key=lambda p: -abs(p.change))[:_MOST_BARS], key=free.index)
        out = m.angle_out if kind == "angle" else float
        places = np.arange(len(kept))[::-1]
        axes.barh(places, [out(p.change) for p in kept], color="#9cc3e4", height=0.7)
        sigma = [0.0 if p.sigma is None else 2 * out(p.sigma) for p in kept]
        axes.errorbar(
            [out(p.change) for p in kept], places, xerr=sigma, fmt="none", ecolor=COLOURS["text"], elinewidth=1, capsize=2
        )
        axes.set_yticks(places, [p.name for p in kept], fontsize=7)
        axes.set_ylim(-1, len(kept))
        axes.axvline(0, color=COLOURS["quiet"], lw=0.8)
        unit = {"length": m.length_unit, "angle": m.angle_unit, "number": "1"}[kind]
        axes.set_xlabel(f"identified less nominal [{unit}]")
        axes.set_title(f"{len(kept)} of {len(free)} {kind}s, bars of two sigma", loc="left")
    return figure


@drawing()
def pose_sigma_figure(fit: Calibration, sigma: PoseSigma) -> Figure:
    """Standard deviations of position and orientation over the poses, seen from above and from the side."""
    m = fit.mechanism
    figure, panels = _figure(11, 4.4, (1, 1))
    x, y, z = sigma.poses[:, 0], sigma.poses[:, 1], sigma.poses[:, 2]
    shown = (
        (panels[0], x, y, "y", sigma.position, "position", m.length_unit),
        (panels[1], x, z, "z", np.array([m.angle_out(float(a)) for a in sigma.angle]), "orientation", m.angle_unit),
    )
    for axes, across, up, name, values, what, unit in shown:
        dots = axes.scatter(across, up, c=values, s=22, cmap="viridis")
        figure.colorbar(dots, ax=axes, label=f"sigma of {what} [{unit}]")
        axes.set(xlabel=f"x of the platform [{m.length_unit}]", ylabel=f"{name} of the platform [{m.length_unit}]")
        axes.set_title(f"Sigma of the {what}, seen from {'above' if name == 'y' else 'the side'}", loc="left")
    return figure


def _figure(width: float, height: float, ratios: tuple[int, ...]) -> tuple[Figure, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(ratios), squeeze=False, width_ratios=ratios)[0]
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
    return figure, panels
