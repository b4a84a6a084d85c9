"""The standard writing of configurations, and the platform's poses, of many configurations at
once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.model.joint import Coordinate
from symkin.numeric.mapped import Mapped
from symkin.numeric.tolerances import ROUNDED_COMPONENT
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
    return np.asarray(values + 0.0)


def positive_quaternions(q: np.ndarray) -> np.ndarray:
    """Quaternions (m, 4) of unit length, the first component that is not zero to rounding
    positive.
    """
    q = q / np.sqrt(np.einsum("ni,ni->n", q, q))[:, None]
    leading = np.argmax(np.abs(q) > ROUNDED_COMPONENT, axis=1)
    sign = np.where(q[np.arange(len(q)), leading] < 0.0, -1.0, 1.0)
    return np.asarray(q * sign[:, None] + 0.0)


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
