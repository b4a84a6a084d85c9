"""Curves of singular configurations over the map of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symkin.drawing.palette import COLOURS
from symkin.plots.loci_plot import KIND_COLOURS, point_look
from symkin.plots.sheet import foot_legend
from symkin.singularities.loci import MISSING, NONE_MET, Loci

_WIDTH, _EDGE = 1.8, 4.0
"""Widths in points of a curve and of the white edge that parts it from the map."""


def draw_loci(figure: Any, ax: Any, loci: Loci, names: Sequence[str]) -> None:
    """The curves on a map whose axes are `names`, with a legend below it; the map's limits stay."""
    from matplotlib.patheffects import withStroke

    edge = [withStroke(linewidth=_EDGE, foreground="white", alpha=0.9)]
    limits = ax.get_xlim(), ax.get_ylim()
    order = [loci.plane.names.index(name) for name in names]
    handles: dict[str, Any] = {}
    for curve in loci.curves:
        colour = KIND_COLOURS[curve.kind]
        points = curve.points[:, order] if len(order) == 2 else curve.points
        name = f"singular, {curve.kind}"
        if len(order) == 1:
            drawn = ax.axvline(
                points[0, 0],
                color=colour,
                lw=_WIDTH,
                path_effects=edge,
                zorder=5.0,
                gid=f"locus {curve.kind}",
            )
        else:
            closed = np.vstack([points, points[:1]]) if curve.closed else points
            look: dict[str, Any] = {"lw": _WIDTH}
            if curve.is_point:
                marker, what = point_look(curve)
                look, name = {"marker": marker, "ms": 6, "ls": "none"}, f"{name}, {what}"
            drawn = ax.plot(
                *closed.T,
                color=colour,
                path_effects=edge,
                zorder=5.0,
                gid=f"locus {curve.kind}",
                **look,
            )[0]
            if len(curve.cusps):
                ax.plot(
                    *curve.cusps[:, order].T,
                    "o",
                    mfc="white",
                    mec=colour,
                    ms=6,
                    mew=1.4,
                    zorder=6.0,
                    gid="cusp",
                )
        handles.setdefault(name, drawn)
    ax.set(xlim=limits[0], ylim=limits[1])
    missing = {MISSING, NONE_MET} & set(loci.notes)
    told = "" if loci.curves else f"{loci.without_curves}; "
    note = f"{told}curves may be missing" if missing else told.removesuffix("; ")
    if note:
        ax.annotate(
            note,
            (1.0, 1.0),
            xycoords="axes fraction",
            xytext=(0, -4),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=8,
            color=COLOURS["text"],
            path_effects=edge,
        )
    foot_legend(figure, handles, 3)
