"""Paint a plane of two coordinates for the page, as SVG: its title, curves, a map's cells or dots,
and the legends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from symkin.drawing.palette import COLOURS, KIND_COLOURS
from symkin.page.static_files import static_template

_SHADES = ("#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725")
"""Of small values to large ones (viridis)."""
_MOST_ENTRIES = 8
"""Counts that a legend names."""
_MOST_APART = math.log(1.5)
"""Of the sides' lengths, where both have one unit and one scale."""

Legend = list[tuple[str | None, str]]


def painted_plane(plane: Mapping[str, Any]) -> dict[str, Any]:
    """A plane {names, units, ranges, held, curves: [{kind, points}], pose, map: {title, values,
    condition, every, edges or points}} as `html` with its title, colours and legends, and what of
    it is asked of the mechanism.
    """
    curves, cells, ranges = plane["curves"], plane.get("map"), np.array(plane["ranges"], float)
    kinds = {curve["kind"]: KIND_COLOURS.get(curve["kind"], COLOURS["loop"]) for curve in curves}
    words = [] if cells is None else [cells["title"]]
    if kinds or cells is None or plane["lociAsked"]:
        words.append("singular curves" if kinds else "singular curves: none met")
    title = ", ".join(words)
    told = [title[:1].upper() + title[1:], plane["held"]]
    across, up = np.ptp(ranges, axis=1)
    is_even = len(set(plane["units"])) == 1 and abs(math.log(up / across)) < _MOST_APART
    html = static_template("plane.html").render(
        names=plane["names"],
        shown="singular curves" if cells is None else "the map of a sweep",
        title="; ".join(part for part in told if part),
        aspect=across / up if is_even else None,
        curves=[(kinds[c["kind"]], _lines(_shares(c["points"], ranges))) for c in curves],
        kinds=[(colour, kind) for kind, colour in kinds.items()],
        map=None if cells is None else _painted_map(cells, ranges),
        ends=[
            " to ".join(f"{float(f'{end:.4g}'):g}" for end in ends) + f" {unit}"
            for ends, unit in zip(plane["ranges"], plane["units"], strict=True)
        ],
    )
    kept = {key: plane.get(key) for key in ("names", "ranges", "pose")}
    return kept | {"html": html, "what": "plane" if cells is None else "map"}


def _shares(points: Sequence[Any], ranges: np.ndarray) -> np.ndarray:
    """Places in the picture (n, 2) of points of the plane: from 0 to 1, down from the top."""
    shares = (np.reshape(points, (-1, 2)) - ranges[:, 0]) / np.ptp(ranges, axis=1)
    return np.abs(np.array([0.0, 1.0]) - shares)


def _lines(places: np.ndarray) -> str:
    """A path of SVG through places, a single one as a dot."""
    texts = [f"{x:.5g} {y:.5g}" for x, y in places.tolist()]
    return f"M{'L'.join(texts)}{'z' if len(texts) == 1 else ''}"


def _painted_map(cells: Mapping[str, Any], ranges: np.ndarray) -> dict[str, Any]:
    """A map's paths by colour, "" where there is no mode, and its legend."""
    values = cells["values"]
    positive = sorted({value for value in values if value})
    shades, legend = (_conditions if cells["condition"] else _counts)(positive)
    colours = {v: _SHADES[k] for v, k in zip(positive, shades, strict=True)} | {0: ""}
    paths: dict[str, list[str]] = {}
    if "points" in cells:
        for place, value in zip(_shares(cells["points"], ranges), values, strict=True):
            if value is not None:
                paths.setdefault(colours[value], []).append(_lines(place[None]))
    else:
        colours[None] = "" if cells["condition"] else "#fff"
        x, y = (
            np.abs(k - (np.array(e) - low) / (high - low)).round(5).tolist()
            for k, (e, (low, high)) in enumerate(zip(cells["edges"], ranges, strict=True))
        )
        rows = len(y) - 1
        for i in range(len(x) - 1):
            column = [colours[value] for value in values[i * rows : (i + 1) * rows]]
            for colour, run in groupby(range(rows), key=column.__getitem__):
                places = list(run)
                path = f"M{x[i]:g} {y[places[0]]:g}H{x[i + 1]:g}V{y[places[-1] + 1]:g}H{x[i]:g}z"
                paths.setdefault(colour, []).append(path)
    every = f"; one point of {cells['every']} each way" if cells["every"] > 1 else ""
    return {
        "paths": {colour: "".join(found) for colour, found in paths.items()},
        "kind": "dots" if "points" in cells else "cells",
        "every": every,
        "legend": [*legend, (None, "none")],
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
