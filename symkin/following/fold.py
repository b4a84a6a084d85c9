"""Prove the last step to a turning point: one like all others (see `steps`), whose end has the null
vector for its tangent, and in which the branch is regular although u is not a parameter of it any
more.

If d2u/ds2 < 0 in all of the tube, and both the station where it takes over and, further on, the
turning point, whose own box is proved, lie in it, then u grows from the station to the turning
point, and that is the first singularity on the branch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.following.singular_point import SingularPoint, turning_system
from symkin.following.station import ALONE, Station
from symkin.following.steps import between
from symkin.following.tube import Interval

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
    half, is_square = station.half, interval.system.is_square
    v = np.where(point.null[:, 0] @ station.slope > 0.0, 1.0, -1.0) * point.null[:, 0]
    if half is None or float(v @ (point.y - station.y)[:-1]) <= _SHORTEST_WAY:
        return None
    box = _turning_box(interval, point) if is_square else None
    if is_square and box is None:
        return None
    begin, end = station.several, point.y[None]
    curve = between((begin.y, begin.tangent), (end, np.append(v, 0.0)[None]))
    boxes = [begin.half] if box is None else [begin.half, box[None]]
    tubes = interval.tubes(curve, ALONE, *boxes)
    if not tubes.hold(0.0, begin.y, begin.half)[0]:
        return None
    if box is None:
        return Fold(None)
    if not tubes.hold(1.0, end, box[None])[0] or not interval.folds(tubes, ALONE)[0]:
        return None
    return Fold(float(box[-1]))


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
