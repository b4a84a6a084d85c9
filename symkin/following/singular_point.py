"""Locate singular points of a branch G(z, u) = 0 in doubles: where dG/dz loses rank ahead of a
regular point of it.

A turning point is a root of G = 0, dG/dz v = 0, v0.v = 1 (v0 an estimate of v), at which the branch
turns back in u:

    u = u* + (1/2) u'' t^2,    u'' = - w.(d2G/dz2 v v) / (w.dG/du),    w dG/dz = 0.

At a bifurcation [dG/dz, dG/du] loses rank too: k >= 2 independent null vectors V of it, and G = 0,
[dG/dz, dG/du] V = 0, V0.V = 1 with V0 their estimate has more equations than unknowns, but a root;
both are solved by Gauss-Newton on all rows (Moore and Spence 1980; Seydel, Practical Bifurcation
and Stability Analysis, 2010). The law of u follows by differentiating G(z(t), u(t)) = 0 twice at
u' = 0: d2G/dz2 v v + dG/dz z'' + dG/du u'' = 0, times w.

The last step to a turning point is proved like all others (see `steps`): its end has the null
vector for its tangent, and the branch is regular in it although u is not a parameter of it any
more. If d2u/ds2 < 0 in all of the tube, and both the station where it takes over and, further on,
the turning point, whose own box is proved, lie in it, then u grows from the station to the turning
point, and that is the first singularity on the branch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca
import numpy as np

from symkin.computed_once import lru_cache
from symkin.following.path_system import PathSystem
from symkin.following.station import ALONE, Station
from symkin.following.steps import between
from symkin.following.tube import Interval
from symkin.numeric.tolerances import RANK_TOLERANCE

PointKind = Literal["turning point", "bifurcation", "degenerate"]

_CONVERGED = 1e-11
"""Rows and null vectors of an accepted singular point, dimensionless, are below this."""
_BIFURCATION_CONVERGED = 10 * np.finfo(float).eps
"""The same for a bifurcation, whose equations are more than its unknowns: what is left there beyond
rounding (2e-16 at most for parallelograms, deltas and five-bars that do branch) is the distance by
which the path misses it.
"""
_MOST_STEPS = 25
_LED_THERE = 0.3
"""The distance to a singular point may differ by this share from what the branch's slope says."""
_LEAST_CURVATURE = 1e-6
"""A turning point whose curvature u'' is below this is degenerate: three modes or more meet
there.
"""


@dataclass(frozen=True, eq=False)
class SingularPoint:
    """`y` = (z, u) there, `null` (w, k) the null vectors of dG/dz as columns, `curvature` d2u/dt2
    along a single one.
    """

    kind: PointKind
    y: np.ndarray
    null: np.ndarray
    curvature: float

    @property
    def u(self) -> float:
        return float(self.y[-1])


def find_singular_point(interval: Interval, a: Station) -> SingularPoint | None:
    """The singular point ahead of a station on its branch, or None where none is found or what is
    found does not lie where the branch leads.
    """
    return _turning_point(interval, a) or _bifurcation(interval, a)


def _turning_point(interval: Interval, a: Station) -> SingularPoint | None:
    null = np.linalg.svd(_jacobian(interval, a.y)[:, :-1])[2][-1:].T
    found = _gauss_newton(interval, a, null, 2.0, whole=False)
    return None if found is None else _classified(interval, found[0], found[1][:, 0])


def _bifurcation(interval: Interval, a: Station) -> SingularPoint | None:
    _, singular, right = np.linalg.svd(_jacobian(interval, a.y))
    width = interval.system.width
    small = 1 + int(np.sum(singular[:width] < 3.0 * singular[width - 1]))
    found = _gauss_newton(interval, a, right[-small:].T, 1.0, whole=True)
    return None if found is None else _classified(interval, found[0], None)


def _jacobian(interval: Interval, y: np.ndarray) -> np.ndarray:
    """dG/dy (rows, w + 1) at a point."""
    return interval.evaluate(y[None], ALONE)[1][0]


def _is_where_led(actual: np.ndarray, expected: np.ndarray) -> bool:
    return (
        float(np.linalg.norm(actual - expected))
        <= _LED_THERE * float(np.linalg.norm(actual)) + 1e-10
    )


def _classified(interval: Interval, y: np.ndarray, null: np.ndarray | None) -> SingularPoint | None:
    """Which kind it is, by the ranks of dG/dz and of [dG/dz, dG/du] and the curvature there. `null`
    is that of a turning point; one at which the ranks are those of a bifurcation is none: whether
    branches meet, the equations of a bifurcation say.
    """
    jacobian, width = _jacobian(interval, y), interval.system.width
    _, singular, right = np.linalg.svd(jacobian[:, :-1])
    whole = np.linalg.svd(jacobian, compute_uv=False)
    zeros = int(np.sum(singular[:width] < RANK_TOLERANCE * whole[0]))
    if zeros == 0:
        return None
    basis = right[width - zeros : width].T
    if zeros > 1 or whole[width - 1] < RANK_TOLERANCE * whole[0]:
        return None if null is not None else SingularPoint("bifurcation", y, basis, 0.0)
    v = basis[:, 0] if null is None else null / np.linalg.norm(null)
    # u'' with dz/dt = v: the second derivative of the rows by central differences of dG/dy, and
    # least squares in (z'', u'')
    step = 1e-5 * np.append(v, 0.0)
    second = (_jacobian(interval, y + step) - _jacobian(interval, y - step))[:, :-1] @ v / 2e-5
    curvature = float(np.linalg.lstsq(jacobian, -second, rcond=1e-9)[0][-1])
    kind: PointKind = "turning point" if abs(curvature) > _LEAST_CURVATURE else "degenerate"
    return SingularPoint(kind, y, v[:, None], curvature)


def _gauss_newton(
    interval: Interval, a: Station, null: np.ndarray, led: float, *, whole: bool
) -> tuple[np.ndarray, np.ndarray] | None:
    """y and null vectors (as columns) at a root of the extended rows ahead of a station, whose
    slope leads there `led` times as far as u; None where the iteration does not settle.
    """
    extended = _extended(interval.system, null.shape[1], whole)
    fixed, c = null.ravel("F"), interval.c[0]
    n, x, size = len(a.y), np.concatenate([a.y, fixed]), np.inf
    for _ in range(_MOST_STEPS):
        values, jacobian = (np.asarray(v) for v in extended(x, c, fixed))
        if not (np.isfinite(values).all() and np.isfinite(jacobian).all()):
            return None
        step = np.linalg.lstsq(jacobian, values.ravel(), rcond=1e-14)[0]
        before, size = size, float(np.max(np.abs(step)))
        if size > 10.0:
            return None
        x = x - step
        if size < 1e-14 or (size < 1e-9 and size > 0.3 * before):
            break
    left = float(np.max(np.abs(np.asarray(extended(x, c, fixed)[0]))))
    away = x[:n] - a.y
    if (
        not left < (_BIFURCATION_CONVERGED if whole else _CONVERGED)
        or not away[-1] > 0.0
        or not _is_where_led(away[:-1], led * away[-1] * a.slope)
    ):
        return None
    return x[:n], x[n:].reshape(null.shape, order="F")


@lru_cache(maxsize=128)
def _extended(system: PathSystem, count: int, whole: bool) -> ca.Function:
    """(y, null vectors; c; their estimate) to the extended rows and their Jacobian. `whole`: null
    vectors of dG/dy, else of dG/dz.
    """
    length = system.width + int(whole)
    vectors = ca.SX.sym("v", length, count)
    fixed = ca.SX.sym("v0", length, count)
    slope = ca.jacobian(system.rows, system.y)[:, :length]
    normal = ca.mtimes(fixed.T, vectors) - ca.SX.eye(count)
    rows = ca.vertcat(system.rows, ca.vec(ca.mtimes(slope, vectors)), ca.vec(normal))
    x = ca.vertcat(system.y, ca.vec(vectors))
    outputs = [ca.densify(rows), ca.densify(ca.jacobian(rows, x))]
    return ca.Function("extended", [x, system.c, ca.vec(fixed)], outputs, {"cse": True})


@lru_cache(maxsize=128)
def turning_system(system: PathSystem) -> PathSystem:
    """G = 0 and dG/dz v = 0 in (z, v, u): twice as many rows, to be completed by v0.v = 1, for a
    proof of a turning point.
    """
    w = system.width
    v = ca.SX.sym("v", w)
    rows = ca.vertcat(system.rows, ca.mtimes(ca.jacobian(system.rows, system.y)[:, :w], v))
    y = ca.vertcat(system.y[:w], v, system.y[w])
    return replace(system, y=y, rows=rows, scale=np.concatenate([system.scale, np.ones(w)]))


_SHORTEST_WAY = 1e-11
"""A way shorter than this (over the size, or rad) is within rounding."""


@dataclass(frozen=True)
class Fold:
    """A tube leads to a turning point. `error`: a box of this half width in u is proved to hold
    exactly one turning point, the first singularity after the station.
    """

    error: float


def prove_fold(interval: Interval, station: Station, point: SingularPoint) -> Fold | None:
    """Go from a station to the turning point ahead; None where that is not proved."""
    half = station.half
    v = np.where(point.null[:, 0] @ station.slope > 0.0, 1.0, -1.0) * point.null[:, 0]
    if half is None or float(v @ (point.y - station.y)[:-1]) <= _SHORTEST_WAY:
        return None
    begin, end = station.several, point.y[None]
    curve = between((begin.y, begin.tangent), (end, np.append(v, 0.0)[None]))
    tubes = interval.tubes(curve, ALONE, begin.half)
    box = _turning_box(interval, point, tubes.combined[0])
    if box is None:
        return None
    tubes = interval.tubes(curve, ALONE, begin.half, box[None])
    holds = tubes.hold(0.0, begin.y, begin.half)[0] and tubes.hold(1.0, end, box[None])[0]
    if not holds or not interval.folds(tubes, ALONE)[0]:
        return None
    return Fold(float(box[-1]))


def _turning_box(
    interval: Interval, point: SingularPoint, combined: np.ndarray
) -> np.ndarray | None:
    """Half widths (w + 1,) of a box about the point that is proved to hold exactly one turning
    point of the `combined` rows.
    """
    v = point.null[:, 0]
    y = np.concatenate([point.y[:-1], v, point.y[-1:]])[None]
    direction = np.concatenate([np.zeros(len(v)), v, [0.0]])
    across = np.linalg.svd(direction[None])[2][1:].T
    turning = Interval(turning_system(interval.system), interval.c)
    rows = None
    if not interval.system.is_square:
        rows = np.kron(np.eye(2), combined)[None]
    half = turning.boxes(y, turning.evaluate(y, ALONE)[1], across, ALONE, rows)[0]
    return np.append(half[: len(v)], half[-1]) if np.isfinite(half).all() else None
