"""What many configurations say, in their standard writing: their coordinates, the platform's poses,
joints that a closure leaves out, limits of all joints, named points of links.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import LinkPoses, joint_readings, link_poses
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.numeric.mapped import Mapped
from symkin.numeric.system import System
from symkin.numeric.tolerances import LIMIT_SLACK, ROUNDED_COMPONENT
from symkin.spatial.rotation import wrapped

_TURN = 2.0 * math.pi


@dataclass(frozen=True, eq=False)
class Writing:
    """Columns of configurations whose numbers several writings have: angles, the limits of some of
    them, rod lengths with the least of each, quaternions.
    """

    angles: list[int]
    limited: list[tuple[int, tuple[float, float]]]
    rods: list[int]
    least: np.ndarray
    rotations: list[slice]

    @staticmethod
    def of(coordinates: Sequence[Coordinate], places: Mapping[str, slice]) -> Writing:
        """Those of coordinates at their `places`."""
        columns = [(c, places[c.name].start) for c in coordinates]
        angles = [(c, k) for c, k in columns if c.is_periodic]
        rods = [(c.least, k) for c, k in columns if c.least is not None]
        return Writing(
            [k for _, k in angles],
            [(k, c.limits) for c, k in angles if c.limits is not None],
            [k for _, k in rods],
            np.array([least for least, _ in rods]),
            [places[c.name] for c in coordinates if c.is_rotation],
        )

    def standard(self, values: np.ndarray) -> np.ndarray:
        """The same configurations (m, width) in their standard writing: rod lengths not negative,
        angles in (-pi, pi] and moved by whole turns into their limits where possible, quaternions
        of unit length with w >= 0.
        """
        values = values + 0.0
        if self.angles:
            angles = wrapped(values[:, self.angles])
            angles[angles <= -math.pi + 1e-15] += _TURN
            values[:, self.angles] = angles
        for k, limits in self.limited:
            values[:, k] = into_limits(values[:, k], limits)
        if self.rods:
            rods = values[:, self.rods]
            values[:, self.rods] = np.where(rods < self.least, 2.0 * self.least - rods, rods)
        for place in self.rotations:
            values[:, place] = positive_quaternions(values[:, place])
        return values


def canonical(rows: System, points: np.ndarray) -> np.ndarray:
    """Points (m, width) of rows in their standard writing."""
    return _writing_of_rows(rows).standard(points)


@lru_cache(maxsize=256)
def _writing_of_rows(rows: System) -> Writing:
    return Writing.of(rows.unknowns, rows.places)


@lru_cache(maxsize=128)
def writing_of(closure: Closure) -> Writing:
    """What several writings have of a closure's variables."""
    return Writing.of(closure.coordinates, closure.slices)


def positive_quaternions(q: np.ndarray) -> np.ndarray:
    """Quaternions (m, 4) of unit length, the first component that is not zero to rounding
    positive.
    """
    q = q / np.sqrt(np.add.reduce(q * q, axis=1))[:, None]
    leading = (np.abs(q) > ROUNDED_COMPONENT).argmax(axis=1)
    sign = np.copysign(1.0, q[np.arange(len(q)), leading])
    return q * sign[:, None] + 0.0


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
    values = Writing.of(coordinates, places).standard(np.concatenate(columns, axis=1))
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
