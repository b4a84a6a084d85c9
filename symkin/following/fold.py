"""Prove the last step to a turning point: a tube along the null vector there, in which the branch
is regular although u is not a parameter of it any more.

If d2u/ds2 < 0 in all of the tube, and both the station where it takes over and, further on, the
turning point, whose own box is proved, lie in it, then u grows from the station to the turning
point, and that is the first singularity on the branch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.following.cubic import Cubic
from symkin.following.path_system import NEWTON_ARRIVED, least_squares
from symkin.following.singular_point import SingularPoint, turning_system
from symkin.following.station import ALONE, Station
from symkin.following.tube import Interval

_OVERHANG = 0.02
"""The curve begins before the station and ends beyond the turning point by this share of the way
between them.
"""
_SHORTEST_WAY = 1e-11
"""A way shorter than this (over the size, or rad) is within rounding."""


@dataclass(frozen=True)
class Fold:
    """A tube leads to a turning point. `error`: a box of this half width in u is proved to hold
    exactly one turning point, the first singularity after the station; None where rows are
    redundant, so that nothing of this is proved.
    """

    error: float | None


def prove_fold(interval: Interval, station: Station, point: SingularPoint) -> Fold | None:
    """Go from a station to the turning point ahead; None where that is not proved."""
    v, half = point.null[:, 0], station.half
    direction = np.append(v if v @ station.slope > 0.0 else -v, 0.0)
    pace = float(direction[:-1] @ station.slope)
    whole = float(direction @ (point.y - station.y))
    if half is None or pace <= 0.0 or whole <= _SHORTEST_WAY:
        return None
    before = station.y - (_OVERHANG * whole / pace) * np.append(station.slope, 1.0)
    begin = on_plane(interval, before, direction)
    end = on_plane(interval, point.y + _OVERHANG * whole * direction, direction)
    if begin is None or end is None:
        return None
    length = float(direction @ (end[0] - begin[0]))
    (a, slope_a), (b, slope_b) = ([v[None] for v in place] for place in (begin, end))
    curve = Cubic.hermite(a, slope_a, b, slope_b, np.array([length]))
    tubes = interval.tubes(curve, ALONE, half[None])

    def holds(y: np.ndarray, box: np.ndarray) -> bool:
        share = float(direction @ (y - begin[0])) / length
        return bool(tubes.hold(share, y[None], box[None])[0])

    if not holds(station.y, half):
        return None
    if not interval.system.is_square:
        return Fold(None)
    box = _turning_box(interval, point)
    if box is None or not holds(point.y, box) or not interval.folds(tubes, ALONE)[0]:
        return None
    return Fold(float(box[-1]))


def on_plane(
    interval: Interval, y: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """The branch's point on the hyperplane through y, and its tangent dy/ds there: [dG/dy; e]
    dy/ds = (0, 1).
    """
    found, jacobian, size = interval.system.correct(y[None], interval.c, direction)
    if not size[0] < NEWTON_ARRIVED:
        return None
    rows = np.vstack([jacobian[0], direction])
    tangent = least_squares(rows[None], np.append(np.zeros(len(rows) - 1), 1.0)[None])[0]
    return (found[0], tangent) if np.isfinite(tangent).all() else None


def _turning_box(interval: Interval, point: SingularPoint) -> np.ndarray | None:
    """Half widths (w + 1,) of a box about the point that is proved to hold exactly one turning
    point.
    """
    v = point.null[:, 0]
    y = np.concatenate([point.y[:-1], v, point.y[-1:]])[None]
    direction = np.concatenate([np.zeros(len(v)), v, [0.0]])
    across = np.linalg.svd(direction[None])[2][1:].T
    turning = Interval(turning_system(interval.system), interval.c)
    half = turning.boxes(y, turning.evaluate(y, ALONE)[1], across, ALONE)[0]
    return np.append(half[: len(v)], half[-1]) if np.isfinite(half).all() else None
