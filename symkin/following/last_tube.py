"""Prove the last step to a turning point: a tube over s = e.y, e the null vector there, in which
the branch is regular although u is not a parameter of it any more.

If d2u/ds2 < 0 in all of the tube, du/ds > 0 at the station where it takes over, and the turning
point, whose own box is proved, lies in it, then u grows from the station to the turning point, and
that is the first singularity on the branch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.following.cubic import Cubic
from symkin.following.path_system import NEWTON_ARRIVED, least_squares
from symkin.following.singular_point import SingularPoint, turning_system
from symkin.following.step_certificate import Interval, Tube

_OVERHANG = 0.02
"""The tube begins before the station and ends beyond the turning point by this share of the way
between them.
"""
_SHORTEST_WAY = 1e-11
"""A way shorter than this (over the size, or rad) is within rounding."""


@dataclass(frozen=True)
class LastTube:
    """A tube leads to a turning point. `error`: a box of this half width in u is proved to hold
    exactly one turning point, the first singularity after the station; None where rows are
    redundant, so that nothing of this is proved.
    """

    error: float | None


def prove_last_tube(
    interval: Interval,
    y: np.ndarray,
    slope: np.ndarray,
    half: np.ndarray | None,
    point: SingularPoint,
) -> LastTube | None:
    """Go from a station (its y, slope dz/du and proved box) to the turning point ahead; None where
    that is not proved.
    """
    v = point.null[:, 0]
    direction = np.append(v if v @ slope > 0.0 else -v, 0.0)
    pace, whole = float(direction[:-1] @ slope), float(direction @ (point.y - y))
    if half is None or pace <= 0.0 or whole <= _SHORTEST_WAY:
        return None
    begin = on_plane(interval, y - (_OVERHANG * whole / pace) * np.append(slope, 1.0), direction)
    end = on_plane(interval, point.y + _OVERHANG * whole * direction, direction)
    if begin is None or end is None:
        return None
    curve = Cubic.hermite(*begin, *end, float(direction @ (end[0] - begin[0])))
    tube = interval.tube(curve, direction, half)
    if tube is None or not _box_lies_in(curve, tube, direction, y, half):
        return None
    if not interval.system.is_square:
        return LastTube(None)
    box = _turning_box(interval, point)
    if box is None or not _box_lies_in(curve, tube, direction, point.y, box):
        return None
    if not (
        _parameter_grows(interval, y, half, direction)
        and interval.folds_once(curve, direction, tube)
    ):
        return None
    return LastTube(float(box[-1]))


def on_plane(
    interval: Interval, y: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """The branch's point on the hyperplane through y, and its tangent dy/ds there: [dG/dy; e]
    dy/ds = (0, 1).
    """
    y, jacobian, size = interval.system.correct(y, interval.c, direction)
    if not size < NEWTON_ARRIVED:
        return None
    tangent = least_squares(
        np.vstack([jacobian, direction]), np.append(np.zeros(len(jacobian)), 1.0)
    )
    return (y, tangent) if np.isfinite(tangent).all() else None


def _box_lies_in(
    curve: Cubic, tube: Tube, direction: np.ndarray, y: np.ndarray, half: np.ndarray
) -> bool:
    """Whether all of a box about y lies in the tube, each of its points on the hyperplane of some
    point of the curve.
    """
    offset = float(direction @ (y - curve.control[0]))
    spread = float(np.abs(direction) @ half) + 1e-15
    if not spread < offset < curve.length - spread:
        return False
    centre, extent = curve.velocity
    away = (
        np.abs(curve.at(offset / curve.length) - y)
        + half
        + spread * (np.abs(centre) + extent)
        + curve.rounding
    )
    return bool((away <= tube.half).all())


def _parameter_grows(
    interval: Interval, y: np.ndarray, half: np.ndarray, direction: np.ndarray
) -> bool:
    """Whether s is proved to grow with u at the root in the station's box."""
    n = len(y)
    found = interval.tangent(y, half, np.append(np.zeros(n - 1), 1.0))
    return (
        found is not None
        and float(direction @ found[0])
        > (1.0 + 1e-12) * float(np.abs(direction) @ found[1]) + 1e-12
    )


def _turning_box(interval: Interval, point: SingularPoint) -> np.ndarray | None:
    """Half widths (w + 1,) of a box about the point that is proved to hold exactly one turning
    point.
    """
    system = interval.system
    v = point.null[:, 0]
    y = np.concatenate([point.y[:-1], v, point.y[-1:]])
    direction = np.concatenate([np.zeros(len(v)), v, [0.0]])
    augmented = Interval(turning_system(system), interval.c)
    half = augmented.point(y, direction, augmented.evaluate(y)[1])
    return None if half is None else np.append(half[: len(v)], half[-1])
