"""Curves of singular configurations over the map of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from symkin.drawing.palette import COLOURS, KIND_COLOURS
from symkin.plots.loci_plot import draw_locus
from symkin.plots.sheet import foot_legend, labelled, note
from symkin.singularities.loci import MISSING, NONE_MET, Loci

_WORDS = "singular, "
_WIDTH, _EDGE = 1.8, 4.0
"""Widths in points of a curve and of the white edge that parts it from the map."""


def draw_loci(ax: Any, loci: Loci, names: Sequence[str]) -> None:
    """The curves on a map whose axes are `names`, with a legend below it; the map's limits stay."""
    from matplotlib.patheffects import withStroke

    edge = [withStroke(linewidth=_EDGE, foreground="white", alpha=0.9)]
    limits = ax.get_xlim(), ax.get_ylim()
    order = [loci.plane.names.index(name) for name in names]
    for curve in loci.curves:
        if len(order) == 1:
            look = {"lw": _WIDTH, "zorder": 5.0, "gid": f"locus {curve.kind}"}
            ax.axvline(
                curve.points[0, 0],
                color=KIND_COLOURS[curve.kind],
                label=f"{_WORDS}{curve.kind}",
                path_effects=edge,
                **look,
            )
        else:
            turned = replace(curve, points=curve.points[:, order], cusps=curve.cusps[:, order])
            draw_locus(ax, turned, emphasise=False, words=_WORDS, path_effects=edge)
    ax.set(xlim=limits[0], ylim=limits[1])
    missing = {MISSING, NONE_MET} & set(loci.notes)
    told = "" if loci.curves else f"{loci.without_curves}; "
    text = f"{told}curves may be missing" if missing else told.removesuffix("; ")
    if text:
        look = {"ha": "right", "va": "top", "color": COLOURS["text"], "path_effects": edge}
        note(ax, text, (1.0, 1.0), (0, -4), xycoords="axes fraction", **look)
    foot_legend(ax.figure, labelled(ax), 3)
