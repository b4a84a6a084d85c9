"""What the page paints of a plane of two coordinates: its title, the colours of curves and of a
map's values, and the legends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from symkin.drawing.palette import COLOURS, KIND_COLOURS

_SHADES = ("#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725")
"""Of small values to large ones (viridis)."""
_MOST_ENTRIES = 8
"""Counts that a legend names."""
_NO_MODE = -1

Legend = list[tuple[str | None, str]]


def painted_plane(plane: Mapping[str, Any]) -> dict[str, Any]:
    """A plane {names, units, ranges, held, curves: [{kind, points}], pose, map: {title, values,
    condition, every, edges or points}} with its title, colours and legends.
    """
    curves, cells = plane["curves"], plane.get("map")
    kinds = {curve["kind"]: KIND_COLOURS.get(curve["kind"], COLOURS["loop"]) for curve in curves}
    words = [] if cells is None else [cells["title"]]
    if kinds or cells is None or plane["lociAsked"]:
        words.append("singular curves" if kinds else "singular curves: none met")
    title = ", ".join(words)
    told = [title[:1].upper() + title[1:], plane["held"]]
    shown = "singular curves" if cells is None else "the map of a sweep"
    painted = {
        "label": f"Plane of {' and '.join(plane['names'])} with {shown}; point at a place to go "
        f"there, or use the arrow keys",
        "title": "; ".join(part for part in told if part),
        "curves": [curve | {"colour": kinds[curve["kind"]]} for curve in curves],
        "kinds": [(colour, kind) for kind, colour in kinds.items()],
    }
    return {**plane, **painted, "map": None if cells is None else _painted_map(cells)}


def _painted_map(cells: Mapping[str, Any]) -> dict[str, Any]:
    """A map with a shade for each value, by its number: -1 where there is no mode, null where that
    is not known.
    """
    values = cells["values"]
    positive = sorted({value for value in values if value})
    shades, legend = (_conditions if cells["condition"] else _counts)(positive)
    unknown = _NO_MODE if cells["condition"] and "edges" in cells else None
    numbers = dict(zip(positive, shades, strict=True)) | {0: _NO_MODE, None: unknown}
    every = f"; one point of {cells['every']} each way" if cells["every"] > 1 else ""
    return {
        "shades": _SHADES,
        "fills": [numbers[value] for value in values],
        "every": every,
        "legend": [*legend, (None, "none")],
        **{key: cells[key] for key in ("edges", "points") if key in cells},
    }


def _counts(positive: Sequence[float]) -> tuple[list[int], Legend]:
    """Shades of counts, a shade further each, and a legend of some of them."""
    last, step = max(1, len(positive) - 1), -(-len(positive) // _MOST_ENTRIES)
    shades = [_shade(k / last) for k in range(len(positive))]
    named = zip(positive[::step], shades[::step], strict=True) if positive else ()
    return shades, [(_SHADES[shade], f"{value:g}") for value, shade in named]


def _conditions(positive: Sequence[float]) -> tuple[list[int], Legend]:
    """Shades of conditions by their logarithm, large ones dark, and a legend of three."""
    if not positive:
        return [], []
    low, high = math.log(positive[0]), math.log(positive[-1])

    def shade(value: float) -> int:
        return _shade(1.0 - (math.log(value) - low) / ((high - low) or 1.0))

    ends = dict.fromkeys((positive[0], math.exp(0.5 * (low + high)), positive[-1]))
    legend: Legend = [(_SHADES[shade(end)], f"{float(f'{end:.3g}'):g}") for end in ends]
    return [shade(value) for value in positive], legend


def _shade(share: float) -> int:
    return math.floor(share * (len(_SHADES) - 1) + 0.5)
