"""What many configurations say, in their standard writing: their coordinates, the platform's poses,
joints that a closure leaves out, limits of all joints, named points of links.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import LinkPoses, joint_readings, link_poses
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.mapped import Mapped
from symkin.numeric.tolerances import LIMIT_SLACK, ROUNDED_COMPONENT
from symkin.spatial.rotation import wrapped

_TURN = 2.0 * math.pi


def canonical(
    coordinates: Sequence[Coordinate], places: Mapping[str, slice], values: np.ndarray
) -> np.ndarray:
    """The same configurations (m, width) in their standard writing: rod lengths not negative,
    angles in (-pi, pi] and moved by whole turns into their limits where possible, quaternions of
    unit length with w >= 0. `places` are those of coordinates.
    """
    values = values.copy()
    angles = [places[c.name].start for c in coordinates if c.is_periodic]
    if angles:
        values[:, angles] = _without_turns(values[:, angles])
    for c in coordinates:
        place = places[c.name]
        if c.is_rotation:
            values[:, place] = positive_quaternions(values[:, place])
        elif c.is_periodic and c.limits is not None:
            values[:, place] = into_limits(values[:, place], c.limits)
        elif c.least is not None:
            values[:, place] = np.where(
                values[:, place] < c.least, 2.0 * c.least - values[:, place], values[:, place]
            )
    return values + 0.0


def positive_quaternions(q: np.ndarray) -> np.ndarray:
    """Quaternions (m, 4) of unit length, the first component that is not zero to rounding
    positive.
    """
    q = q / np.sqrt(np.add.reduce(q * q, axis=1))[:, None]
    leading = (np.abs(q) > ROUNDED_COMPONENT).argmax(axis=1)
    sign = np.copysign(1.0, q[np.arange(len(q)), leading])
    return q * sign[:, None] + 0.0


def _without_turns(angles: np.ndarray) -> np.ndarray:
    """Angles without whole turns, in (-pi, pi]."""
    turned = wrapped(angles)
    return np.where(turned <= -math.pi + 1e-15, turned + _TURN, turned)


def into_limits(angles: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Angles moved by the fewest whole turns that bring them into their limits; as they are where
    none do.
    """
    low, high = limits
    moved = angles + _TURN * np.ceil((low - angles) / _TURN - 1e-12)
    outside = (angles < low) | (angles > high)
    return np.where(outside & (moved <= high + 1e-12), moved, angles)


def poses_of(closure: Closure, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (m, 3) and unit quaternions (m, 4), w >= 0, of the platform at full vectors of
    variables (m, variables).
    """
    packed = _pose_function(closure)(values)[0][:, :, 0]
    quaternion = positive_quaternions(packed[:, 3:])
    # w is 0 to rounding of either sign where the first component that is not decides the sign
    quaternion[:, 0] = np.maximum(quaternion[:, 0], 0.0)
    return packed[:, :3], quaternion


@lru_cache(maxsize=128)
def _pose_function(closure: Closure) -> Mapped:
    return Mapped.of(
        [closure.variables],
        [closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))],
    )


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
