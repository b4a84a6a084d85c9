"""Coordinates of joints that a closure leaves out, limits of all joints, and named points of
links.
"""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import LinkPoses, joint_readings, link_poses
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.tolerances import LIMIT_SLACK
from symkin.position.canonical import canonical


@lru_cache(maxsize=128)
def left_out(closure: Closure) -> tuple[Coordinate, ...]:
    """The coordinates that the closure does not hold: those of cut joints."""
    held = {c.name for c in closure.coordinates}
    return tuple(c for c in closure.mechanism.coordinates if c.name not in held)


def readings(closure: Closure, poses: LinkPoses) -> dict[str, np.ndarray]:
    """Values (m, width) of the coordinates that the closure leaves out, in their standard writing,
    from the poses of links.
    """
    coordinates = left_out(closure)
    if not coordinates:
        return {}
    read = joint_readings(closure, poses)
    columns = [np.atleast_2d(read[c.name]).T for c in coordinates]
    ends = np.cumsum([c.width for c in coordinates])
    places = {
        c.name: slice(int(end) - c.width, int(end))
        for c, end in zip(coordinates, ends, strict=True)
    }
    values = canonical(coordinates, places, np.concatenate(columns, axis=1))
    return {name: values[:, place] for name, place in places.items()}


def readings_at(closure: Closure, values: np.ndarray) -> dict[str, np.ndarray]:
    """As `readings`, from full vectors of variables (m, variables)."""
    return readings(closure, link_poses(closure, values)) if left_out(closure) else {}


def points_at(mechanism: Mechanism, poses: LinkPoses) -> dict[str, np.ndarray]:
    """Where the named points are (m, 3)."""
    return {
        p.name: poses[p.link].apply(np.array(p.point)[:, None]).T for p in mechanism.link_points
    }


def within_limits(closure: Closure, values: np.ndarray) -> np.ndarray | None:
    """Which configurations (m, variables), in their standard writing, lie within the limits of all
    joints; None where there are none.
    """
    limited = [(c, c.limits) for c in closure.coordinates if c.limits is not None]
    others = [(c, c.limits) for c in left_out(closure) if c.limits is not None]
    if not limited and not others:
        return None
    read = readings_at(closure, values) if others else {}
    inside = np.ones(len(values), dtype=bool)
    for c, (low, high) in (*limited, *others):
        slack = LIMIT_SLACK * c.unit(closure.characteristic_length)
        value = read[c.name][:, 0] if c.name in read else values[:, closure.slices[c.name].start]
        inside &= (low - slack <= value) & (value <= high + slack)
    return inside
