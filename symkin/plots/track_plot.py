"""A picture of a track: the robot at its start, where it comes nearest to a singularity and at its
end, and below it, over the inputs, what moves and how near singularities and limits are.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, SERIES
from symkin.errors import InputError
from symkin.following.sample import Sample
from symkin.following.track_result import Track
from symkin.plots.figures import Block
from symkin.plots.look import panel_of
from symkin.plots.picture_options import looks_of
from symkin.plots.sheet import SHEET_DPI, blank_figure, labelled, own_legend
from symkin.plots.style import drawing
from symkin.plots.track_curves import Curve, CurvePanel, Input, inputs_of, panels_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEAST_WIDTH = 9.0
"""Inches of the figure at least."""
_MARGIN = 0.4
"""Inches beside the robots."""
_PANEL, _PANEL_GAP = 1.55, 0.28
"""Inches of a panel of curves, and between two."""
_HEAD, _HEAD_LINE, _LEGEND, _ROW = 0.5, 0.2, 0.75, 0.185
"""Inches of the title, of a line below it, of the robots' legend, and of a row of inputs below the
curves.
"""
_CHARACTER = 0.082
"""Inches of a character of a legend or of an input's name, for the margins."""
_TICKS_APART = 0.09
"""Share of the axis between the tick at a stop and others."""
_MOST_NAMED, _MOST_STANDING, _MOST_INPUTS = 8, 3, 7
"""Curves, quantities that stand and inputs that are named; of more, the first ones."""
_BESIDE = 0.02
"""Share of the path below which the place nearest to a singularity counts as the start or the
end.
"""
_THIN, _WIDER = 1.5, 2.2
"""Width of a curve in points, and what it is wider for each later curve that covers it."""
_COVERED = 0.008
"""Distance over the panel's range below which two curves cover each other."""
_SHORT = 0.1
"""Share of a path below which two curves only cross."""


def figure_of_track(
    track: Track, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """The robot at some places of the path, then panels over the inputs: the platform's position
    and turning from its start (direct problem), the actuated joints (inverse problem) or all joints
    that are found and the named points (values by name, or no platform); distances to singularity
    and to limits. The stop, if any, is a line. Raises InputError for a track without samples.
    """
    if not track.samples:
        raise InputError(
            f"plot: {track.trajectory.mechanism.name} was not followed, so that there is nothing "
            f"to draw"
        )
    mechanism = track.trajectory.mechanism
    options = looks_of(mechanism, names, views)
    told = [c.name for c in track.problem.known_coordinates]
    robots = [panel_of(title, s.solution, told, text) for title, text, s in _places(track)]
    with drawing():
        views_of_each = len(options["views"])
        block = Block.of(
            mechanism,
            robots,
            options["names"],
            options["views"],
            len(robots) if views_of_each == 1 else views_of_each,
        )
        return _Sheet.of(track, block).draw()


def _places(track: Track) -> list[tuple[str, str, Sample]]:
    """Titles, places on the path and samples of the robots that are drawn: the start, the place
    nearest to a singularity where it lies between, and the stop or the end; one place alone once.
    """
    first, last = track.samples[0], track.end
    found = [("start", "", first)]
    near = track.nearest
    if near is not None and _BESIDE < near.parameter < last.parameter - _BESIDE:
        found.append(("nearest to a singularity", f"at {near.parameter:.4g} of the path", near))
    if last is not first:
        stop = track.stop
        title = "end" if stop is None else f"stop: {stop.kind}"
        kinds = "" if stop is None else "".join(f", {kind}" for kind in stop.kinds)
        found.append(
            (title, "" if stop is None else f"at {last.parameter:.6g} of the path{kinds}", last)
        )
    return found


@dataclass(frozen=True, eq=False)
class _Sheet:
    """The page of one track, in inches: robots above `panels` over the abscissa `x`, whose rows are
    `inputs`.
    """

    track: Track
    block: Block
    facts: tuple[str, ...]
    panels: tuple[CurvePanel, ...]
    x: np.ndarray
    title: str
    inputs: tuple[Input, ...]
    margins: tuple[float, float]

    @staticmethod
    def of(track: Track, block: Block) -> _Sheet:
        panels, moved = tuple(panels_of(track)), inputs_of(track)
        timed = track.trajectory.times is not None
        title, x = "time [s]" if timed else "share of the path", _abscissa(track, timed)
        if len(moved) == 1 and not timed and (np.diff(moved[0].values) > 0).all():
            title, x, moved = moved[0].title, moved[0].values, []
        rows = [title, *(i.title for i in moved[:_MOST_INPUTS])]
        entries = [
            line for panel in panels for text in _entries(panel) for line in text.split("\n")
        ]
        margins = (
            max(1.1, _CHARACTER * max(map(len, rows)) + 0.5),
            max(1.0, _CHARACTER * max(map(len, entries), default=0) + 0.55),
        )
        width = max(_LEAST_WIDTH, block.size[0] + _MARGIN)
        facts = textwrap.wrap(track.statement[0].upper() + track.statement[1:], int(13 * width))
        return _Sheet(
            track, block, tuple(facts), panels, x, title, tuple(moved[:_MOST_INPUTS]), margins
        )

    @property
    def width(self) -> float:
        return max(_LEAST_WIDTH, float(self.block.size[0]) + _MARGIN)

    @property
    def foot(self) -> float:
        return 0.45 + _ROW * (1 + len(self.inputs))

    @property
    def height(self) -> float:
        curves = len(self.panels) * (_PANEL + _PANEL_GAP)
        return float(
            _HEAD
            + _HEAD_LINE * (len(self.facts) + 1)
            + self.block.size[1]
            + _LEGEND
            + curves
            + self.foot
        )

    def draw(self) -> Figure:
        figure = blank_figure(self.width, self.height, dpi=SHEET_DPI)
        self._heading(figure)
        top = self.height - _HEAD - _HEAD_LINE * (len(self.facts) + 1)
        legend = top - self.block.size[1] - _LEGEND + 0.2
        self.block.draw(figure, 0.5 * self.width, top, legend)
        for k, panel in enumerate(self.panels):
            self._panel(figure, panel, k)
        return figure

    def _heading(self, figure: Figure) -> None:
        track = self.track
        mechanism, kind = track.trajectory.mechanism, track.trajectory.kind
        told = ", ".join(c.name for c in track.problem.known_coordinates)
        what = (
            textwrap.shorten(f"given {told}", 60, placeholder=" ...")
            if kind == "given"
            else f"of the {kind} problem"
        )
        title = textwrap.shorten(
            f"{mechanism.title or mechanism.name}: one mode {what}",
            int(9.5 * self.width),
            placeholder=" ...",
        )
        look: dict[str, Any] = {"ha": "center", "va": "top", "parse_math": False}
        figure.text(
            0.5,
            1.0 - 0.12 / self.height,
            title,
            fontsize=13,
            fontweight="bold",
            color=COLOURS["text"],
            **look,
        )
        lines = "\n".join(self.facts)
        figure.text(
            0.5,
            1.0 - _HEAD / self.height,
            lines,
            fontsize=9,
            color=COLOURS["quiet"],
            linespacing=1.35,
            **look,
        )

    # --- curves -----------------------------------------------------------------------------------

    def _panel(self, figure: Figure, panel: CurvePanel, k: int) -> None:
        left, right = self.margins
        low = self.foot + (len(self.panels) - 1 - k) * (_PANEL + _PANEL_GAP)
        box = (
            left / self.width,
            low / self.height,
            1.0 - (left + right) / self.width,
            _PANEL / self.height,
        )
        ax: Any = figure.add_axes(box)
        _draw_curves(ax, panel, self.x)
        ax.set_ylabel(panel.label, fontsize=8.5, color=COLOURS["quiet"])
        ax.tick_params(labelsize=8, colors=COLOURS["quiet"])
        ax.grid(color=COLOURS["grid"], linewidth=0.6)
        margin = 0.03 * float(np.ptp(self.x)) or 0.5
        ax.set_xlim(self.x.min() - margin, self.x.max() + margin)
        self._marks(ax, k == 0)
        _legend(ax, panel)
        self._ticks(ax, k == len(self.panels) - 1)

    def _marks(self, ax: Any, is_first: bool) -> None:
        """The stop and the place nearest to a singularity, as lines; their names above the first
        panel.
        """
        track, parameters = self.track, [s.parameter for s in self.track.samples]
        marks: list[tuple[str, float, Any]] = []
        if track.stop is not None and track.stop.place is not None:
            marks.append(("stop", float(self.x[-1]), "--"))
        if track.nearest is not None and track.nearest.parameter < parameters[-1] - 1e-9:
            marks.append(
                ("nearest", float(np.interp(track.nearest.parameter, parameters, self.x)), ":")
            )
        for name, place, style in marks:
            ax.axvline(
                place,
                color=COLOURS["accent"] if name == "stop" else COLOURS["quiet"],
                lw=1.4,
                ls=style,
                gid=name,
                zorder=1.5,
            )
            if is_first:
                text = (
                    track.stop.kind
                    if track.stop is not None and name == "stop"
                    else "nearest to a singularity"
                )
                beyond = name == "stop" or place > float(np.mean(ax.get_xlim()))
                ax.annotate(
                    text,
                    (place, 1.0),
                    xycoords=("data", "axes fraction"),
                    xytext=(0, 3 if name == "stop" else 13),
                    textcoords="offset points",
                    ha="right" if beyond else "left",
                    fontsize=8,
                    color=COLOURS["quiet"],
                )

    def _ticks(self, ax: Any, is_last: bool) -> None:
        """Ticks at the same places in all panels; below the last one the values of the inputs
        there, a row each.
        """
        from matplotlib.ticker import MaxNLocator

        low, high = float(self.x.min()), float(self.x.max())
        steps = [1, 1.5, 3, 4.5, 6, 9, 10] if self.title.endswith("[deg]") else [1, 2, 2.5, 5, 10]
        places = [
            float(v) for v in MaxNLocator(7, steps=steps).tick_values(low, high) if low <= v <= high
        ]
        if self.track.stop is not None or not places:
            places = [v for v in places if abs(v - self.x[-1]) > _TICKS_APART * (high - low)] + [
                float(self.x[-1])
            ]
        if not is_last:
            ax.set_xticks(places, labels=[""] * len(places))
            return
        rows = [[f"{place:.6g}" for place in places]]
        rows += [
            [f"{v + 0.0:.5g}" for v in np.interp(places, self.x, i.values)] for i in self.inputs
        ]
        ax.set_xticks(
            places,
            labels=["\n".join(column) for column in zip(*rows, strict=True)],
            fontsize=8,
            linespacing=1.35,
        )
        names = "\n".join([self.title, *(i.title for i in self.inputs)])
        # beside the first label, whose half width is kept free
        ax.annotate(
            names,
            (0.0, 0.0),
            xycoords="axes fraction",
            xytext=(-16, -7),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=8,
            linespacing=1.35,
            color=COLOURS["text"],
            parse_math=False,
        )


def _abscissa(track: Track, timed: bool) -> np.ndarray:
    return np.array([s.time if timed else s.parameter for s in track.samples], dtype=float)


def _draw_curves(ax: Any, panel: CurvePanel, x: np.ndarray) -> None:
    """Curves, of which earlier ones are wider where later ones cover them, so that each is seen."""
    span = max((float(np.ptp(curve.values)) for curve in panel.curves), default=0.0)
    if panel.curves:
        whole = np.concatenate([curve.values for curve in panel.curves])
        span = max(
            span,
            float(np.ptp(whole)),
            float(np.abs(whole).max()) if panel.floor is not None else 0.0,
        )
    for k, curve in enumerate(panel.curves):
        look: dict[str, Any] = {"color": SERIES[k % len(SERIES)], "zorder": 2.0 + 0.01 * k}
        marker = "." if len(curve.at) < 2 else None
        ax.plot(x[curve.at], curve.values, linewidth=_THIN, label=curve.name, marker=marker, **look)
        over = np.sum(
            [_covers(later, curve, span) for later in panel.curves[k + 1 :]], axis=0, initial=0
        )
        for level in range(1, int(np.max(over, initial=0)) + 1):
            seen = np.where(over >= level, curve.values, np.nan)
            ax.plot(
                x[curve.at],
                seen,
                linewidth=_THIN + _WIDER * level,
                solid_capstyle="butt",
                gid="covered",
                **look,
            )
    if panel.floor is not None and panel.curves:
        least = min(panel.floor, *(float(curve.values.min()) for curve in panel.curves))
        top = max(float(curve.values.max()) for curve in panel.curves)
        ax.set_ylim(
            least - 0.04 * (top - least), top + 0.08 * (top - least) if top > least else 1.0
        )
        if least < panel.floor:
            ax.axhline(panel.floor, color=COLOURS["text"], lw=0.8)


def _covers(later: Curve, curve: Curve, span: float) -> np.ndarray:
    """At which of a curve's places a later one lies on it, over a stretch that is seen."""
    near = np.abs(np.interp(curve.at, later.at, later.values) - curve.values) <= _COVERED * span
    edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        near[begin:end] &= end - begin > _SHORT * len(near)
    return np.asarray(near)


def _entries(panel: CurvePanel) -> list[str]:
    """The texts of a panel's legend."""
    named = [curve.name for curve in panel.curves[:_MOST_NAMED]]
    named += (
        [f"and {len(panel.curves) - _MOST_NAMED} more"] if len(panel.curves) > _MOST_NAMED else []
    )
    standing = list(panel.stands[:_MOST_STANDING])
    return (
        named
        + standing
        + (
            [f"{len(panel.stands) - _MOST_STANDING} more stand"]
            if len(panel.stands) > _MOST_STANDING
            else []
        )
    )


def _legend(ax: Any, panel: CurvePanel) -> None:
    from matplotlib.lines import Line2D

    handles = list(labelled(ax).values())[:_MOST_NAMED]
    thin = [Line2D([], [], color=handle.get_color(), linewidth=2.0) for handle in handles]
    texts = _entries(panel)
    blank = [Line2D([], [], linewidth=0.0) for _ in texts[len(thin) :]]
    own_legend(
        ax,
        dict(zip(texts, [*thin, *blank], strict=True)),
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        fontsize=8,
        labelspacing=0.3,
        handlelength=1.4,
    )
