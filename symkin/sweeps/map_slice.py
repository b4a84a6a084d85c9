"""The part of a sweep that a map shows: one quantity over one or two of the swept values, the
others cut; which slices it may be cut at, and which points and joints can be drawn in its place.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from symkin.computed_once import cached_property
from symkin.errors import InputError
from symkin.model.file import parse
from symkin.model.mechanism import Mechanism
from symkin.sweeps.layout import labels
from symkin.sweeps.space import Axis, Space
from symkin.sweeps.store import read_attributes, require_zarr
from symkin.text import meant, shown

SHOWN = {"modes": "count", "conditioning": "least_condition", "reach": "count_within_limits"}
"""The array that is shown of each quantity."""
TITLES = {
    "count": "Number of real modes",
    "least_condition": "Condition of the best mode",
    "count_within_limits": "Number of real modes within limits",
}
_MOST_POINTS = 200_000
"""Points of a sample that are shown."""


@dataclass(frozen=True, eq=False)
class MapSlice:
    """What is shown: `values` along the axes `x` and `y` (None for a curve), each (name, unit,
    coordinates); `fixed` says where the others are cut, `cuts` in numbers; `scattered`: coordinates
    belong to single points.
    """

    values: np.ndarray
    x: tuple[str, str, np.ndarray]
    y: tuple[str, str, np.ndarray] | None
    fixed: tuple[str, ...]
    scattered: bool
    cuts: Mapping[str, float] = field(default_factory=dict)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The ends of each axis, of a grid those of its cells."""
        axes = [axis for axis in (self.x, self.y) if axis is not None]
        ends = {
            name: values if self.scattered or len(values) < 2 else edges(values)
            for name, _, values in axes
        }
        return {name: (float(values.min()), float(values.max())) for name, values in ends.items()}

    @property
    def some(self) -> list[float]:
        """The point with a mode that is nearest to the middle; empty where none has one."""
        axes = [axis[2] for axis in (self.x, self.y) if axis is not None]
        flat = np.stack(
            axes if self.scattered else [a.ravel() for a in np.meshgrid(*axes, indexing="ij")],
            axis=1,
        )
        values = self.values.ravel().astype(float)
        spans = [high - low or 1.0 for low, high in self.ranges.values()]
        away = np.linalg.norm((flat - flat.mean(axis=0)) / spans, axis=1)
        away[~np.isfinite(values) | (values == 0)] = np.inf
        place = int(np.argmin(away))
        return [float(v) for v in flat[place]] if np.isfinite(away[place]) else []


@dataclass(frozen=True, eq=False)
class SweepFolder:
    """What a sweep's folder has pinned, and its arrays."""

    attributes: Mapping[str, Any]
    data: Any

    @staticmethod
    def of(folder: Path) -> SweepFolder:
        """Raises InputError for a folder that holds no sweep."""
        require_zarr()
        import xarray

        attributes = read_attributes(folder)
        if attributes is None:
            raise InputError(f"{folder}: holds no sweep")
        return SweepFolder(attributes, xarray.open_zarr(folder))

    @cached_property
    def mechanism(self) -> Mechanism:
        return parse(self.attributes["mechanism_file"])

    @property
    def sampled(self) -> bool:
        """Whether its points are random."""
        return self.attributes["sample"] is not None

    @property
    def names(self) -> list[str]:
        """What is swept."""
        return list(self.attributes["axes"])

    @property
    def of_poses(self) -> bool:
        return bool(self.attributes["sweeps over"] == "poses")

    @cached_property
    def axes(self) -> dict[str, Any]:
        """The arrays of what is swept, by name."""
        return {n: self.data[label] for n, label in self.labels.items()}

    @property
    def labels(self) -> dict[str, str]:
        """The names of these arrays."""
        return dict(zip(self.names, labels(self.names), strict=True))

    @property
    def shown(self) -> str:
        """The array that a map shows."""
        return SHOWN[self.attributes["quantity"]]

    @cached_property
    def space(self) -> Space:
        """What the sweep went over: points of it give the arguments of `symkin.modes`."""
        axes = tuple(Axis(name, "", np.zeros(1)) for name in self.names)
        base = self.attributes["base"]
        told = base if isinstance(base, Mapping) else tuple(base)
        return Space(self.mechanism, self.attributes["sweeps over"], axes, told)

    def check_map(self, slices: Mapping[str, float]) -> None:
        """Raise InputError for slices outside what is swept, and where they leave no map."""
        values = {n: array.values for n, array in self.axes.items()}
        check_slices(slices, values, sampled=self.sampled)
        check_map_is_left(slices, self.names)

    def map_slice(self, slices: Mapping[str, float]) -> MapSlice:
        """The array that is shown, cut at `slices`: the nearest grid values are taken."""
        return self._sample() if self.sampled else self._cut(slices)

    def _cut(self, slices: Mapping[str, float]) -> MapSlice:
        """A grid, cut so that at most two axes are left: those of most values, unless `slices` cuts
        them.
        """
        names = self.names
        long = [n for n in names if n not in slices and self.axes[n].size > 1]
        shown = long[:2] or [n for n in names if n not in slices][:1] or names[:1]
        part, cuts, fixed = self.cut_at([n for n in names if n not in shown], slices)
        x, y = ([*map(self._axis, shown), None])[:2]
        assert x is not None  # noqa: S101 - a sweep has an axis
        return MapSlice(part[self.shown].values, x, y, fixed, False, cuts)

    def _axis(self, name: str, part: slice = slice(None)) -> tuple[str, str, np.ndarray]:
        array = self.axes[name]
        return name, array.attrs["units"], array[part].values

    def cut_at(
        self, cut: Sequence[str], slices: Mapping[str, float]
    ) -> tuple[Any, dict[str, float], tuple[str, ...]]:
        """The arrays at the values of some axes that are nearest to `slices`, or in the middle;
        these values by name, and what is told of them.
        """
        places, found, told = {}, {}, []
        for n in (n for n in self.names if n in cut):
            _, unit, values = self._axis(n)
            middle = values[(len(values) - 1) // 2]
            place = places[self.labels[n]] = int(np.argmin(np.abs(values - slices.get(n, middle))))
            found[n] = float(values[place])
            told.append(f"{n} = {found[n]:.5g} {unit}")
        return self.data.isel(places), found, tuple(told)

    def _sample(self) -> MapSlice:
        """The first points of a sample over the first two swept values."""
        names, part = self.names, slice(0, _MOST_POINTS)
        x, y = [*(self._axis(n, part) for n in names[:2]), None][:2]
        assert x is not None  # noqa: S101 - a sweep has an axis
        fixed = (f"all values of {', '.join(names[2:])}",) if len(names) > 2 else ()
        return MapSlice(self.data[self.shown][part].values, x, y, fixed, True)


def edges(values: np.ndarray) -> np.ndarray:
    """Edges of the cells about rising values."""
    if len(values) == 1:
        return values[0] + np.array([-0.5, 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


_ROUNDING = 1e-9
"""Share of a bound by which a slice may pass it: the last digits of arithmetic."""


def check_slices(
    slices: Mapping[str, float], swept: Mapping[str, np.ndarray], *, sampled: bool
) -> None:
    """Raises InputError for slices that a sweep over these values does not have."""
    if slices and sampled:
        raise InputError(
            "slice: a random sample has no slices; it is drawn over the first two swept values"
        )
    for name, value in slices.items():
        if name not in swept:
            raise InputError(
                f"slice: {name!r} is not swept{meant(name, swept)}; allowed: {', '.join(swept)}"
            )
        low, high = float(np.min(swept[name])), float(np.max(swept[name]))
        slack = _ROUNDING * max(abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            allowed = f"{low:.10g} to {high:.10g}" if high > low else f"{low:.10g}"
            raise InputError(
                f"slice: {name} = {value:.10g} lies outside what is swept; allowed: {allowed}"
            )


def check_map_is_left(slices: Mapping[str, float], swept: Iterable[str]) -> None:
    """Raises InputError for slices that leave nothing over which a map could be drawn."""
    if slices and set(swept) <= set(slices):
        all_of_it = f"{', '.join(slices)} {'is' if len(slices) == 1 else 'are'} all that is swept"
        raise InputError(f"slice: {all_of_it}; leave at least one out, over which the map is drawn")


def check_drawable(
    mechanism: Mechanism, quantity: str, swept: Sequence[str], names: Sequence[str]
) -> bool:
    """Whether names are those of points and not of joints. Raises InputError for names of neither,
    of both, and where what they stand for is not stored or is what is swept.
    """
    points = [point.name for point in mechanism.link_points]
    joints = [c.name for c in mechanism.coordinates if not c.is_rotation and c.name not in swept]
    for name in names:
        if name not in points and name not in joints:
            allowed = (
                f"points {', '.join(points) or 'none'}; joints that are not swept "
                f"{', '.join(joints) or 'none'}"
            )
            raise InputError(
                f"of: {shown(name)} is no point and no joint to "
                f"draw{meant(name, [*points, *joints])}; allowed: {allowed}"
            )
    if quantity != "modes":
        raise InputError(
            f"of: quantity = {quantity!r} stores no points and joints; sweep with quantity = "
            f"'modes'"
        )
    of_points = [name in points for name in names]
    if any(of_points) and not all(of_points):
        raise InputError(f"of: {', '.join(names)} are points and joints; draw the one or the other")
    return all(of_points)
