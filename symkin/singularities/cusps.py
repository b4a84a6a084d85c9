"""Find the cusps of a locus over two inputs: the points where its picture in the plane turns back.

Over two inputs q the locus is the fold of the direct problem: F(q, z) = 0, J w = 0, n J = 0 with
J = dF/dz. Along it

    n dF/dq q' = 0,    n d2F(w, z') + n d2F(w, q') = 0,    z' = a w + (a part linear in q').

Where n d2F(w, w) = 0 three modes meet. There (q', z') = (0, w) solves these equations: the velocity
in the plane vanishes, and as n d2F(w, w) changes its sign along the locus, so does q' (Whitney
1955; Zein, Wenger and Chablat 2008 for planar mechanisms).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.singularities.curve import Curve, correct, is_regular, tangent
from symkin.singularities.locus_system import LocusSystem

_LENGTHENINGS = 5
"""How often the bracket is made longer by a tenth: the curve is longer than its chord."""


def with_cusps(system: LocusSystem, curve: Curve) -> tuple[Curve, np.ndarray]:
    """The curve with its cusps among its points, and their numbers."""
    if system.kind != "type 2" or system.plane.of_pose:
        return curve, np.zeros(0, dtype=int)
    uv = curve.tangents[:, system.uv_columns]
    moves = np.linalg.norm(uv, axis=1) > SINGULAR_VALUE
    turns = [
        k
        for k in range(len(uv) - 1)
        if moves[k] and moves[k + 1] and float(uv[k] @ uv[k + 1]) < 0.0
    ]
    found = [
        (k + 1, z)
        for k in turns
        if (z := cusp_between(system, curve, k)) is not None and _is_cusp(system, z)
    ]
    if not found:
        return curve, np.zeros(0, dtype=int)
    places, points = [k for k, _ in found], np.array([z for _, z in found])
    tangents = np.insert(curve.tangents, places, curve.tangents[[k - 1 for k in places]], axis=0)
    numbers = np.array(places) + np.arange(len(places))
    return Curve(np.insert(curve.points, places, points, axis=0), tangents, curve.closed), numbers


def _is_cusp(system: LocusSystem, z: np.ndarray) -> bool:
    """Whether the velocity in the plane vanishes, not only its part along the bracket's, at a point
    where the curve is regular: crossings of curves have no one tangent.
    """
    t = tangent(system.curve, z)
    return (
        t is not None
        and float(np.linalg.norm(t[system.uv_columns])) <= SINGULAR_VALUE
        and is_regular(system.curve, z)
    )


def cusp_between(system: LocusSystem, curve: Curve, k: int) -> np.ndarray | None:
    """The point of the curve between its points k and k + 1 where the velocity in the plane changes
    its sense.
    """
    begin, ahead = curve.points[k], curve.tangents[k]
    along = ahead[system.uv_columns] - curve.tangents[k + 1][system.uv_columns]

    def at(length: float) -> Reading | None:
        z = correct(system.curve, system.curve.move(begin[None], length * ahead[None])[0])
        t = None if z is None else tangent(system.curve, z)
        if z is None or t is None:
            return None
        return z, float((t if t @ ahead > 0 else -t)[system.uv_columns] @ along)

    way = system.curve.difference(begin[None], curve.points[k + 1][None])[0]
    low, reach = at(0.0), float(way @ ahead)
    for length in (reach * 1.1**n for n in range(_LENGTHENINGS + 1)):
        high = at(length)
        if low is None or high is None:
            return None
        if low[1] * high[1] <= 0.0:
            return _sign_change(at, low, length)
    return None


Reading = tuple[np.ndarray, float]
"""A point of the curve and the velocity in the plane there, along a direction."""


def _sign_change(at: Callable[[float], Reading | None], low: Reading, length: float) -> np.ndarray:
    """The point between 0 and a length at which the reading vanishes, by halving."""
    begin, end, z = 0.0, length, low[0]
    while end - begin > 1e-15 * length:
        middle = 0.5 * (begin + end)
        found = at(middle)
        if found is None or not begin < middle < end:
            break
        z, value = found
        begin, end = (middle, end) if value * low[1] > 0.0 else (begin, middle)
    return z
