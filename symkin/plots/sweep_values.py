"""Pictures of what a sweep's modes do: the paths of named points in the plane of their largest
extents, or joints over what is swept.

Every mode is a dot, coloured by the first swept value. Along one swept value the assembly that the
mechanism file describes is drawn as a line: from the mode nearest to the reference on, sample by
sample, as far as one mode is beyond doubt the nearest.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symkin.closure.closure import build_closure
from symkin.drawing.palette import COLOURS, SERIES
from symkin.model.mechanism import Mechanism
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
from symkin.position.given import given_coordinates
from symkin.position.varied_pose import axis_title, turn_text
from symkin.spatial.rotation import conjugate, multiply
from symkin.sweeps.map_slice import SweepFolder, check_drawable
from symkin.text import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NEAREST = 0.5
"""A mode goes on to the nearest one of the next sample where it is nearer than this share of the
distance of the second.
"""
_HALF_TURN = {"deg": 180.0, "rad": np.pi}
"""Difference of two neighbouring angles beyond which a whole turn is between them, by unit."""
_MOST_DOTS = 200_000
"""Modes that are drawn."""
_LEAST_AREA, _LARGEST_AREA, _ALL_DOTS = 3.0, 14.0, 4000.0
"""Areas of dots (points squared): few dots are larger, so that all of them cover about as much."""


@dataclass(frozen=True, eq=False)
class _Modes:
    """The modes of n points: which of the places (n, modes) hold one, `swept` values (n,) by name
    and unit of the first axis, and `line` (n,), the place of the mode that the line goes through,
    -1 where there is none.
    """

    data: Any
    there: np.ndarray
    first: tuple[str, str, np.ndarray]
    line: np.ndarray
    fixed: tuple[str, ...]


def figure_of_values(
    swept: SweepFolder, names: Sequence[str], slices: Mapping[str, float]
) -> Figure:
    """The picture of named points, or of joints. Raises InputError for a name that the sweep does
    not have.
    """
    points = check_drawable(swept.mechanism, swept.attributes["quantity"], swept.names, names)
    modes = _modes(swept, slices, points)
    with drawing():
        figure = new_figure(7.4, 6.0 if points else 4.8)
        ax: Any = figure.add_subplot()
        if points:
            _paths(ax, modes, swept, names)
        else:
            _curves(ax, modes, swept, names)
        write_title(ax, f"{_kind(modes, points)} of {', '.join(names)}", swept, modes.fixed)
    return figure


def _kind(modes: _Modes, points: bool) -> str:
    """What the picture shows, for its title."""
    if not points:
        return "Values"
    return "Path" if (modes.line >= 0).any() else "Positions"


# --- what is drawn --------------------------------------------------------------------------------


def _modes(folder: SweepFolder, slices: Mapping[str, float], points: bool) -> _Modes:
    """All modes, or those at the slices; of joints, over the axis of most values alone."""
    names, sampled, axes = folder.names, folder.sampled, folder.axes
    free = [n for n in names if n not in slices]
    first = max(free, key=lambda n: axes[n].size)
    swept = free if sampled or points else [first]
    data, _, fixed = folder.cut_at([n for n in names if n not in swept], slices)
    order = data["count"].dims
    data = data.transpose(*order, "mode", ...)
    values = axes[first].broadcast_like(data["count"]).transpose(*order).values.ravel()
    count = np.maximum(data["count"].values.ravel(), 0)
    there = np.arange(data.sizes.get("mode", 0)) < count[:, None]
    line = np.full(len(count), -1)
    if not sampled and len(swept) == 1:
        begin = _nearest_sample(folder.mechanism, first, values)
        line = _line(folder.mechanism, data, there, begin)
    return _Modes(data, there, (first, axes[first].attrs["units"], values), line, fixed)


def _numbers(modes: _Modes, name: str, width: int) -> np.ndarray:
    """An array (n, modes, ...) of all modes."""
    array = modes.data[name].values
    return np.asarray(array.reshape(*modes.there.shape, *array.shape[array.ndim - width :]))


def _nearest_sample(mechanism: Mechanism, name: str, values: np.ndarray) -> int:
    """The sample nearest to the reference; the first where a coordinate of the pose is swept."""
    known = {c.name: c for c in mechanism.coordinates if not c.is_rotation}
    if name not in known:
        return 0
    c = known[name]
    reference = mechanism.value_out(c, c.reference[0])
    return int(np.argmin(np.abs(values - reference)))


def _line(mechanism: Mechanism, data: Any, there: np.ndarray, begin: int) -> np.ndarray:
    """The place of one mode at each sample, from the one nearest to the reference on in both
    directions; -1 where it is in doubt.
    """
    units = data["joint_units"].values.tolist()
    features = _features(mechanism, data["joints"].values, units)
    reference = _features(mechanism, _reference(mechanism, data["joint"].values.tolist()), units)
    found = np.full(len(there), -1)
    if not there.size or not there[begin].any():
        return found
    found[begin] = int(np.argmin(np.linalg.norm(features[begin][there[begin]] - reference, axis=1)))
    for step in (1, -1):
        place, i = found[begin], begin + step
        while 0 <= i < len(there) and there[i].any():
            away = np.linalg.norm(features[i][there[i]] - features[i - step, place], axis=1)
            order = np.argsort(away)
            if len(order) > 1 and away[order[0]] > _NEAREST * away[order[1]]:
                break
            found[i] = place = int(order[0])
            i += step
    return found


def _reference(mechanism: Mechanism, labels_of_joints: Sequence[str]) -> np.ndarray:
    """Values of joints at the reference, in the mechanism's units."""
    values: dict[str, float] = {}
    for c in mechanism.coordinates:
        if c.is_rotation:
            values |= {f"{c.name}.{axis}": v for axis, v in zip("wxyz", c.reference, strict=True)}
        else:
            values[c.name] = mechanism.value_out(c, c.reference[0])
    return np.array([values[label] for label in labels_of_joints])


def _features(mechanism: Mechanism, joints: np.ndarray, units: Sequence[str]) -> np.ndarray:
    """Joints (..., joints) so that equal configurations are equal: cosines and sines of angles,
    lengths over the size.
    """
    columns = []
    for k, unit in enumerate(units):
        value = joints[..., k]
        if unit == mechanism.angle_unit:
            columns += [
                np.cos(mechanism.angle_in(1.0) * value),
                np.sin(mechanism.angle_in(1.0) * value),
            ]
        else:
            columns.append(value if unit == "1" else value / mechanism.characteristic_length)
    return np.stack(columns, axis=-1)


# --- drawing --------------------------------------------------------------------------------------


def _paths(ax: Any, modes: _Modes, swept: SweepFolder, names: Sequence[str]) -> None:
    """Named points in the two directions in which they move most."""
    listed = modes.data["named_point"].values.tolist()
    all_points = _numbers(modes, "points", 2)
    points = all_points[:, :, [listed.index(name) for name in names]]
    moved = points[modes.there].reshape(-1, 3)
    span = np.nan_to_num(np.ptp(moved, axis=0)) if len(moved) else np.zeros(3)
    across = sorted(np.argsort(-span, kind="stable")[:2].tolist())
    unit = modes.data["points"].attrs["units"]
    name, swept_unit, values = modes.first
    owner = np.nonzero(modes.there)[0][:_MOST_DOTS]
    for k, point in enumerate(names):
        flat = points[:, :, k][modes.there][:_MOST_DOTS]
        drawn = _dots(ax, flat[:, across[0]], flat[:, across[1]], c=values[owner], cmap="viridis")
        if (modes.line >= 0).any():
            path = _along(points[:, :, k], modes.line)
            look = {"color": SERIES[k % len(SERIES)], "linewidth": 1.6}
            ax.plot(*path[:, across].T, label=f"{point}, assembly of the file", **look)
    colour_bar(ax, drawn, axis_text(swept, name, swept_unit))
    ax.set_aspect("equal", adjustable="datalim")
    name_axes(ax, *(f"{'xyz'[k]} [{unit}]" for k in across))
    own_legend(ax, labelled(ax), fontsize=9, loc="best")


def _curves(ax: Any, modes: _Modes, swept: SweepFolder, names: Sequence[str]) -> None:
    """Joints over the swept values."""
    listed = modes.data["joint"].values.tolist()
    joints, units = _numbers(modes, "joints", 1), modes.data["joint_units"].values
    name, unit, values = modes.first
    owner = np.nonzero(modes.there)[0][:_MOST_DOTS]
    for k, joint in enumerate(names):
        place, colour = listed.index(joint), SERIES[k % len(SERIES)]
        flat = joints[:, :, place][modes.there][:_MOST_DOTS]
        _dots(ax, values[owner], flat, color=colour, alpha=0.6)
        if (modes.line >= 0).any():
            path = _along(joints[:, :, [place]], modes.line)[:, 0]
            x, y = _without_turns(values, path, _HALF_TURN.get(units[place], np.inf))
            ax.plot(x, y, color=colour, linewidth=1.6, label=f"{joint}, assembly of the file")
        else:
            ax.plot([], [], ".", color=colour, label=joint)
    shown = ", ".join(dict.fromkeys(f"{n} [{units[listed.index(n)]}]" for n in names))
    name_axes(ax, axis_text(swept, name, unit), shown)
    ax.grid(True)
    own_legend(ax, labelled(ax), fontsize=9, loc="best")


def _without_turns(x: np.ndarray, y: np.ndarray, half_turn: float) -> tuple[np.ndarray, np.ndarray]:
    """A line that is broken where an angle goes on a whole turn away."""
    turns = np.flatnonzero(np.abs(np.diff(y)) > half_turn) + 1
    return np.insert(x, turns, np.nan), np.insert(y, turns, np.nan)


def _along(values: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Values (n, width) of the modes that a line goes through; NaN where it does not."""
    return np.where((line >= 0)[:, None], values[np.arange(len(line)), np.maximum(line, 0)], np.nan)


def _dots(ax: Any, x: np.ndarray, y: np.ndarray, **look: Any) -> Any:
    area = float(np.clip(_ALL_DOTS / max(1, len(x)), _LEAST_AREA, _LARGEST_AREA))
    return ax.scatter(x, y, s=area, linewidths=0, rasterized=True, **look)


def write_title(ax: Any, what: str, swept: SweepFolder, fixed: Sequence[str]) -> None:
    """The title, and below it what is fixed besides what the sweep holds."""
    head(ax.figure, f"{what}: {swept.mechanism.name}, {_problem(swept)}")
    lines = ", ".join([*fixed, *held_texts(swept)])
    subtitle(ax, f"at {lines}" if lines else "", 9.5, wrap=True)
    ax.tick_params(colors=COLOURS["quiet"])


def _problem(swept: SweepFolder) -> str:
    """The problem by its name, or by what is given."""
    name, base = (swept.attributes[key] for key in ("problem", "base"))
    if name != "given":
        return f"{name} problem"
    return f"given {', '.join([*swept.names, *(base if isinstance(base, Mapping) else ())])}"


def axis_text(swept: SweepFolder, name: str, unit: str) -> str:
    """What stands at the axis of a swept coordinate."""
    return f"{axis_title(name) if swept.of_poses else name} [{unit}]"


def held_texts(swept: SweepFolder) -> list[str]:
    """Joints, or coordinates of the pose, that are not swept, with their values; rounding noise as
    0.
    """
    mechanism, values = swept.mechanism, swept.attributes["base"]
    if swept.of_poses:
        return _held_pose(mechanism, values, swept.names)
    if not isinstance(values, Mapping):
        values = dict(zip((c.name for c in mechanism.actuated), values, strict=False))
    coordinates = given_coordinates(mechanism)
    found = []
    for name, value in values.items():
        if name in coordinates and name not in swept.names:
            unit = mechanism.unit_of(coordinates[name])
            found.append(f"{name} = {plain(value, mechanism.characteristic_length):.5g} {unit}")
        elif name not in coordinates:
            found.append(f"{name} ({', '.join(f'{plain(float(v)):.4g}' for v in value)})")
    return found


def _held_pose(mechanism: Mechanism, base: Sequence[float], swept: Collection[str]) -> list[str]:
    """Coordinates of the mechanism's motion: a planar one has no z and an angle gamma, one with a
    free rotation an orientation.
    """
    found, closure = [], build_closure(mechanism)
    for c in closure.role("pose"):
        name = c.name.removeprefix("pose.")
        if c.is_rotation:
            numbers = ", ".join(f"{plain(float(v)):.4g}" for v in base[3:])
            found.append(f"orientation ({numbers}){turn_text(swept)}")
        elif name in ("x", "y", "z") and name not in swept:
            found.append(
                f"{name} = {plain(base['xyz'.index(name)], mechanism.characteristic_length):.5g} "
                f"{mechanism.length_unit}"
            )
        elif name == "gamma" and "gamma" not in swept:
            turn = multiply(np.array(base[3:]), conjugate(mechanism.reference_pose.quaternion))
            angle = plain(mechanism.angle_out(2.0 * math.atan2(turn[3], turn[0])))
            if "rz" not in swept or angle:
                found.append(
                    f"gamma = {'rz + ' * ('rz' in swept)}{angle:.5g} {mechanism.angle_unit}"
                )
    return found
