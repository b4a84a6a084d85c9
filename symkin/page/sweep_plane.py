"""A sweep's map as a plane of the page: its cells beside the sliders, and the mechanism where one
points.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from symkin.errors import InputError
from symkin.page.view import View, view_solution
from symkin.plots.sweep_values import held_texts
from symkin.singularities.configuration import configuration
from symkin.spatial.pose import Pose
from symkin.sweeps.map_loci import loci_over
from symkin.sweeps.map_slice import TITLES, MapSlice, SweepFolder, edges

_MOST_CELLS = 40_000
"""Cells or points of a map that a page holds (0.2 MB); of finer maps it holds every second, third,
... row and column.
"""


def view_of_sweep(
    folder: Path, slices: Mapping[str, float] | None = None, *, loci: bool = False
) -> View:
    """The page of a sweep's mechanism with the sweep's map, cut at `slices`, and with `loci` its
    singular curves.

    It begins at the point with a mode that is nearest to the middle. Raises InputError for a folder
    that holds no sweep, and for a map that no page can follow: over one coordinate, or over turns
    of a pose.
    """
    swept = SweepFolder.of(folder)
    swept.check_map(slices or {})
    name, space, part = swept.shown, swept.space, swept.map_slice(slices or {})
    _check_plane(part, swept)
    values = dict(part.cuts) | dict(zip(part.ranges, part.some, strict=True))
    told = space.given([values[axis.name] for axis in space.axes])
    here = configuration(space.mechanism, **told)
    joints = zip((c.name for c in space.mechanism.actuated), told.get("joints", ()), strict=False)
    curves = loci_over(loci, swept, part.ranges, part.cuts, part.some)
    plane = {
        "names": list(part.ranges),
        "units": [axis[1] for axis in (part.x, part.y) if axis is not None],
        "ranges": [list(ends) for ends in part.ranges.values()],
        "held": ", ".join([*part.fixed, *held_texts(swept)]),
        "pose": _numbers(told["pose"]) if "pose" in told else None,
        "curves": []
        if curves is None
        else [{"kind": curve.kind, "points": curve.points.tolist()} for curve in curves.curves],
        "lociAsked": loci,
        "map": _cells(part, TITLES[name], is_condition=name == "least_condition"),
    }
    return view_solution(here, told.get("given") or dict(joints), plane=plane)


def _check_plane(part: MapSlice, swept: SweepFolder) -> None:
    """Raise InputError for a map that has no plane to point at, or none whose points the page can
    reach.
    """
    names = list(part.ranges)
    if part.y is None or set(names) | set(part.cuts) < set(swept.names):
        raise InputError(
            f"view: a map over {', '.join(swept.names)} is no plane; two swept coordinates "
            f"are needed, others cut by --slice"
        )
    if swept.of_poses and not set(names) <= set("xyz"):
        raise InputError(
            f"view: a map over {' and '.join(names)} has no page; of poses, maps over two of x, y, "
            f"z have one"
        )
    if not part.some:
        raise InputError(
            "view: no point of this map has a mode, so that there is no configuration to show"
        )


def _numbers(pose: Pose) -> list[float]:
    return [*map(float, pose.position), *map(float, pose.quaternion)]


def _cells(part: MapSlice, title: str, *, is_condition: bool) -> dict[str, Any]:
    """Values over edges of cells, or over single points (u, v); null where a value is not known or,
    of conditions, there is no mode.
    """
    assert part.y is not None  # noqa: S101 - checked before
    x, y, values = part.x[2], part.y[2], part.values.astype(float)
    step = 1
    if part.scattered:
        step = -(-len(values) // _MOST_CELLS)
        places = {"points": np.stack([x, y], axis=1)[::step].round(9).tolist()}
        values = values[::step]
    else:
        while -(-len(x) // step) * -(-len(y) // step) > _MOST_CELLS:
            step += 1
        values = values[::step, ::step]
        places = {"edges": [edges(x[::step]).tolist(), edges(y[::step]).tolist()]}
    known = np.isfinite(values) & (values >= 0)
    told = [
        None if not is_known else float(f"{value:.4g}")
        for value, is_known in zip(values.ravel(), known.ravel(), strict=True)
    ]
    return {"title": title, "values": told, "condition": is_condition, "every": step, **places}
