"""The picture of a transmission: the torque of each joint over the range, the ratios of its motors,
and of two joints the torques and rates that are possible together.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.drawing.palette import COLOURS, SERIES
from symkin.plots.sheet import (
    colour_bar,
    drawing,
    head,
    labelled,
    name_axes,
    new_figure,
    own_legend,
    subtitle,
)
from symkin.transmissions.polytope import between_planes, torque_vertices
from symkin.transmissions.states import States
from symkin.transmissions.transmission_result import Transmission, Transmissions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANEL = (4.0, 3.7)
"""Inches of a panel."""
_CURVE = 101
"""Points of a curve."""
_DASHES = ("-", "--", ":")
"""Lines of motors in turn, so that of two alike each is seen."""
_SPREAD = 95.0
"""Percentile of torques at which colours and axes end: near a dead centre they grow without
bound.
"""

_CONSTANT = 0.999
"""Share of the highest colour above which all torques are one."""
_SAME = 1e-6
"""Distance over the range below which two values of the samples' grid are one."""


def figure_of_transmission(found: Transmission) -> Figure:
    """The largest torque of each joint alone, over the joints' range, each with its least place;
    the ratios of motors along each joint, the others at the reference; of two joints all torques
    and rates at the reference, and where each torque is least.
    """
    return _figure([found])


def figure_of_transmissions(found: Transmissions) -> Figure:
    """Rows of panels for each transmission."""
    return _figure(list(found.found))


def _figure(several: list[Transmission]) -> Figure:
    columns = max(_columns(one) for one in several)
    with drawing():
        size = (_PANEL[0] * columns, 2 * _PANEL[1] * len(several))
        figure = new_figure(*size)
        axes: Any = figure.subplots(2 * len(several), columns, squeeze=False)
        for k, one in enumerate(several):
            _draw(one, axes[2 * k : 2 * k + 2])
            for ax in axes[2 * k : 2 * k + 2, _columns(one) :].flat:
                ax.set_axis_off()
        head(figure, f"{several[0].linkage.mechanism.name}: motors to joints", 12)
    return figure


def _columns(one: Transmission) -> int:
    return len(one.joints) + (len(one.joints) == 2)


def _draw(one: Transmission, axes: Any) -> None:
    n = len(one.joints)
    for i in range(n):
        _torque(one, axes[0, i], i)
        _ratios(one, axes[1, i], i)
    if n == 2:
        least = [int(np.argmin(one.survey.alone[:, i])) for i in range(2)]
        rows = list(dict.fromkeys([0, *least]))
        _polytopes(one, axes[0, 2], "torque", rows)
        _polytopes(one, axes[1, 2], "speed", rows)


def _unit(one: Transmission, i: int) -> str:
    """The unit of a joint's values."""
    mechanism, (c,) = one.linkage.mechanism, one.linkage.coordinates_of(one.joints[i : i + 1])
    return mechanism.unit_of(c)


def _position(one: Transmission, i: int) -> str:
    """A joint and the unit of its values."""
    return f"{one.joints[i]}, {_unit(one, i)}"


def _per(one: Transmission, i: int) -> str:
    """The units of motors' rates by a joint's, where these are of another kind than the joint's."""
    (joint,), motors = (one.linkage.coordinates_of(n) for n in ((one.joints[i],), one.motors))
    angle, length = "rad", one.linkage.mechanism.length_unit
    own, other = (angle, length) if joint.is_angular else (length, angle)
    return f", {other}/{own}" * any(m.is_angular != joint.is_angular for m in motors)


def _effect(one: Transmission, i: int, kind: str) -> str:
    """The unit of a joint's torques or rates; where nothing is told, what they are multiples of."""
    (c,) = one.linkage.coordinates_of(one.joints[i : i + 1])
    length = one.linkage.mechanism.length_unit
    if f"{kind}_limits" in one.data.untold:
        return "for 1 at each motor"
    if kind == "speed":
        return "rad/s" if c.is_angular else f"{length}/s"
    return f"N {length}" if c.is_angular else "N"


def _values(one: Transmission) -> np.ndarray:
    """The joints of all samples in the mechanism's units."""
    survey = one.survey
    return np.array([[survey.out(i, v) for i, v in enumerate(row)] for row in survey.states.joints])


def _torque(one: Transmission, ax: Any, i: int) -> None:
    """The torque of a joint alone: over two joints a map, else along the joint itself, of one joint
    over the whole range.
    """
    torque, joints = one.survey.alone[:, i], _values(one)
    if len(one.joints) == 1:
        line, found = _along(one, i)
        regular = np.isfinite(found.jacobian + found.inverse_jacobian.transpose(0, 2, 1))
        kept = regular.all(axis=(1, 2))
        joints, states = line[kept], States(one.linkage, found.w[kept])
        torque = replace(one.survey, states=states).alone[:, i]
    high = np.percentile(torque, _SPREAD)
    unit = _effect(one, i, "torque")
    subtitle(ax, f"torque of {one.joints[i]} alone, {unit}")
    if len(one.joints) == 2:
        least = int(np.argmin(torque))
        flat = torque[least] > _CONSTANT * high
        shade = {"cmap": "viridis", "vmin": 0.0 if flat else torque[least], "vmax": high}
        cells, alone = _cells(one)
        ax.scatter(*joints[alone].T, c=torque[alone], s=12, marker="s", linewidths=0, **shade)
        image = ax.tripcolor(*joints.T, cells, torque, shading="gouraud", rasterized=True, **shade)
        colour_bar(ax, image, "", extend="neither" if flat else "max", fraction=0.05)
        ax.plot(*joints[least], "v", color=COLOURS["accent"], label=f"least {torque[least]:.3g}")
        ax.plot(*joints[0], "o", color=COLOURS["text"], label=f"reference {torque[0]:.3g}")
        name_axes(ax, _position(one, 0), _position(one, 1))
        _legend(ax)
        return
    order = np.argsort(joints[:, i])
    look = "-" if len(one.joints) == 1 else "."
    ax.plot(joints[order, i], torque[order], look, color=SERIES[0], markersize=3)
    ax.set_ylim(0.0, 1.1 * high)
    name_axes(ax, _position(one, i))
    ax.grid(True)


def _cells(one: Transmission) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k, 3) between neighbours on the samples' grid of two coordinates, and the samples
    that belong to none.
    """
    survey, place = one.survey, dict[tuple[int, ...], int]()
    values = survey.states.w[:, one.linkage.places_of(survey.grid)]
    low, apart = values[1:].min(axis=0), np.diff(np.sort(values[1:], axis=0), axis=0)
    steps = [float(gaps[gaps > _SAME * gaps.sum()].min(initial=np.inf)) for gaps in apart.T]
    for row, indices in enumerate(np.rint((values[1:] - low) / steps).astype(int).tolist(), 1):
        place[tuple(indices)] = row
    cells = []
    for a, b in {(a - i, b - j) for a, b in place for i in (0, 1) for j in (0, 1)}:
        corners = [place.get(other) for other in ((a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1))]
        there = [row for row in corners if row is not None]
        cells += [[there[0], *pair] for pair in pairwise(there[1:])]
    found = np.array(cells, dtype=int).reshape(-1, 3)
    return found, np.setdiff1d(np.arange(1, len(values)), found)


def _legend(ax: Any, below: float = 0.2, columns: int = 2) -> None:
    """A legend below an axis' label, where nothing is covered."""
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, -below)}
    own_legend(ax, labelled(ax), ncols=columns, fontsize=7, **place)


def _along(one: Transmission, i: int) -> tuple[np.ndarray, States]:
    """Joints along the range of one, the others at the reference, and the linkage there."""
    line = np.tile(_values(one)[0], (_CURVE, 1))
    low, high = (one.survey.out(i, end.value) for end in one.survey.ends[i])
    line[:, i] = np.linspace(low, high, _CURVE)
    return line, one.states(joints=line, check=False)


def _ratios(one: Transmission, ax: Any, i: int) -> None:
    """The motors' rates by the joint's along its range, the other joints at the reference; the play
    of the joint where the motors' resolutions are told.
    """
    survey, ends = one.survey, one.survey.ends[i]
    line, states = _along(one, i)
    ratios = states.inverse_jacobian[:, :, i]
    for a, name in enumerate(one.motors):
        look = {"color": SERIES[a % len(SERIES)], "linestyle": _DASHES[a % len(_DASHES)]}
        ax.plot(line[:, i], ratios[:, a], label=name, **look)
    known = ratios[np.isfinite(ratios)]
    if known.size:
        least, most = np.percentile(known, [100.0 - _SPREAD, _SPREAD])
        margin = 0.2 * (most - least) + 0.05
        ax.set_ylim(least - margin, most + margin)
    title = f"rates of motors by that of {one.joints[i]}{_per(one, i)}"
    if survey.backlash is not None:
        title += f"\nplay at most {survey.out(i, survey.backlash[i]):.3g} {_unit(one, i)}"
    subtitle(ax, title)
    name_axes(ax, f"{_position(one, i)}\nfrom {ends[0].by}\nto {ends[1].by}")
    ax.grid(True)
    _legend(ax, 0.36)


def _polytopes(one: Transmission, ax: Any, kind: str, rows: list[int]) -> None:
    """All torques, or rates, of two joints at some samples."""
    data, states, joints = one.data, one.survey.states, _values(one)
    for colour, row in zip(SERIES, rows, strict=False):
        g = states.inverse_jacobian[row]
        if kind == "torque":
            corners = torque_vertices(g, data.torque_limits)
        else:
            corners = between_planes(g, *data.speed_limits.T)
        first, second = (f"{v:.2g} {_unit(one, i)}" for i, v in enumerate(joints[row]))
        name = f"at {first}, {second}" if row else "at the reference"
        ax.fill(*corners.T, facecolor="none", edgecolor=colour, linewidth=1.6, label=name)
        if not row:
            reach = 1.6 * np.abs(corners).max(axis=0)
    ax.set_xlim(-reach[0], reach[0])
    ax.set_ylim(-reach[1], reach[1])
    ax.axhline(0.0, color=COLOURS["axis"], linewidth=0.6)
    ax.axvline(0.0, color=COLOURS["axis"], linewidth=0.6)
    subtitle(ax, f"{'torques' if kind == 'torque' else 'rates'} of both together")
    name_axes(ax, *(f"{n}, {_effect(one, i, kind)}" for i, n in enumerate(one.joints)))
    ax.grid(True)
    _legend(ax, columns=1)
