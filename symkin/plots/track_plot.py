"""A picture of a track: what moves along the path, and how near a singularity it comes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.errors import InputError
from symkin.following.sample import listed_joints
from symkin.plots.style import COLOURS, drawing
from symkin.spatial.rotation import rotation_vector_from_quaternion
from symkin.text import matplotlib_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.following.track_result import Track

_MOST_NAMED = 8
"""Curves of a panel that its legend names; of more, the first ones."""


@drawing()
def figure_of_track(track: Track) -> Figure:
    """Panels over the path, or over time: the platform's position and turning from the start (direct problem), the actuated
    joints (inverse problem) or all joints that are found and the named points (values by name, or no platform), and the smallest singular value; the stop, if any, as a line. Raises InputError for a track without
    samples."""
    from matplotlib.figure import Figure

    if not track.samples:
        raise InputError(f"plot: {track.trajectory.mechanism.name} was not followed, so that there is nothing to draw")
    panels = list(_panels(track))
    figure = Figure(figsize=(7.4, 1.0 + 2.1 * (len(panels) + 1)), layout="constrained")
    axes = figure.subplots(len(panels) + 1, 1, sharex=True)
    where = _abscissa(track)
    for ax, (label, curves) in zip(axes, panels, strict=False):
        for name, values in list(curves.items()):
            ax.plot(where, values, label=matplotlib_text(name), lw=1.6, marker="." if len(where) < 40 else None)
        ax.set_ylabel(label)
        handles, names = ax.get_legend_handles_labels()
        ax.legend(handles[:_MOST_NAMED], names[:_MOST_NAMED], loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    _singular_panel(axes[-1], track, where)
    axes[-1].set_xlabel("time [s]" if track.trajectory.times is not None else "share of the path")
    for ax in axes:
        _mark_stop(ax, track, where)
    mechanism = track.trajectory.mechanism
    told = ", ".join(c.name for c in track.problem.known_coordinates)
    what = f"given {told}" if track.trajectory.kind == "given" else f"of the {track.trajectory.kind} problem"
    title = f"{mechanism.title or mechanism.name}: one mode {what}"
    figure.suptitle(matplotlib_text(title), fontsize=11)
    return figure


def _abscissa(track: Track) -> np.ndarray:
    timed = track.trajectory.times is not None
    return np.array([s.time if timed else s.parameter for s in track.samples], dtype=float)


def _panels(track: Track) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    """Label and curves of each panel."""
    mechanism, samples = track.trajectory.mechanism, track.samples
    if track.trajectory.kind == "direct" and samples[0].has_platform:
        positions = np.array([s.pose.position for s in samples], dtype=float)
        yield f"position [{mechanism.length_unit}]", dict(zip("xyz", positions.T, strict=True))
        turns = np.unwrap(np.array([rotation_vector_from_quaternion(s.pose.quaternion) for s in samples]), axis=0)
        shown = [[mechanism.angle_out(float(v)) for v in row] for row in turns]
        yield (
            f"rotation vector [{mechanism.angle_unit}]",
            dict(zip(("about x", "about y", "about z"), np.array(shown).T, strict=True)),
        )
        return
    known = {c.name for c in track.problem.known_coordinates}
    found = mechanism.actuated if track.trajectory.kind == "inverse" else listed_joints(track.problem)
    for angular, unit in ((False, mechanism.length_unit), (True, mechanism.angle_unit)):
        chosen = [c for c in found if c.is_angular == angular and c.kind != "quaternion" and c.name not in known]
        if chosen:
            yield f"joints [{unit}]", {c.name: np.array([s.joints[c.name] for s in samples]) for c in chosen}
    if track.trajectory.kind != "inverse" and samples[0].points:
        named = {name: np.array([s.points[name] for s in samples]) for name in samples[0].points}
        curves = {f"{name}.{axis}": points[:, k] for name, points in named.items() for k, axis in enumerate("xyz")}
        yield f"points [{mechanism.length_unit}]", curves


def _singular_panel(ax: Any, track: Track, where: np.ndarray) -> None:
    ax.plot(
        where,
        [s.smallest_singular_value for s in track.samples],
        color=COLOURS["accent"],
        lw=1.6,
        marker="." if len(where) < 40 else None,
    )
    largest = max(s.smallest_singular_value for s in track.samples)
    ax.set_ylim(0.0, 1.1 * largest if largest > 0.0 else 1.0)
    ax.set_ylabel("smallest\nsingular value")


def _mark_stop(ax: Any, track: Track, where: np.ndarray) -> None:
    if track.stop is None or track.stop.place is None:
        return
    ax.axvline(where[-1], color=COLOURS["accent"], lw=1.0, ls="--")
    if ax.get_subplotspec().is_first_row():
        ax.annotate(
            track.stop.kind, (where[-1], 1.0), xycoords=("data", "axes fraction"), xytext=(0, 3), textcoords="offset points",
            ha="center", fontsize=8,
        )  # fmt: skip
