"""One curve of a singularity locus in a plane of two coordinates; curves with the same picture are
merged into one.

A locus that stands in one point of the plane may belong to a motion with both coordinates held, or
to curves that nearly touch, where the equations are too ill-conditioned for the next step; finite
steps must show a motion. Configurations z_0 ... z_n at such steps along the null direction are
brought to F(z_k, u, v) = 0 together, with one (u, v) for all of them; only where every row vanishes
and the configurations stay apart is there one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from symkin.numeric.rank import null_space
from symkin.numeric.system import System
from symkin.numeric.tolerances import SINGULAR_VALUE
from symkin.result import json_fields
from symkin.singularities.curve import CORRECTED, Curve, distance
from symkin.singularities.locus_system import LocusSystem

SAME_PICTURE = 5e-4
"""Curves whose points are within this of another curve (of the window's sides) have one picture."""
_LEAST_SHARE, _FARTHEST = 0.9, 0.01
"""So many of the points at least, and the others within this: a polyline cuts off sharp tips, and
its ends lie up to a step outside the window. A step is 1/150 of the sides.
"""
_SAME_PLACE = 1e-6
"""A distance below this, of the window's sides, counts as zero."""


@dataclass(frozen=True, eq=False)
class Locus:
    """One curve, or one point over a single coordinate: `points` (n, 2), (1, 1), in the plane and
    `configurations` (n, width of the unknowns `names`, those of the machine that is meant), every
    one a zero.

    Where passive joints alone lose the rank, the kind is "passive". `hits` counts the starts.
    Curves of other working modes and mirror images with the same picture are not listed again.

    `in_mode` (n,) says which points belong to the working mode of the plane's configuration (all of
    them, where that cannot be told); `self_motion`: finite steps show that the mechanism moves with
    both coordinates held; a curve of one point without it is a place where curves nearly touch or
    cross. `cusps` (c, 2) are points at which the curve in the plane turns back. Values are in the
    mechanism's units; configurations in radians.
    """

    kind: str
    limb: str | None
    points: np.ndarray
    closed: bool
    in_mode: np.ndarray
    cusps: np.ndarray
    names: tuple[str, ...]
    configurations: np.ndarray
    largest_row: float
    hits: int
    self_motion: bool = False

    @property
    def is_point(self) -> bool:
        """The curve stands in one point of the plane."""
        return is_one_place(self.points)

    def to_dict(self) -> dict[str, Any]:
        """The curve in the JSON of `Loci`, but for its loose ends, which depend on the window."""
        told = ("kind", "limb", "closed", "points", "cusps", "in_mode", "largest_row", "hits")
        return json_fields(self, *told, "self_motion")

    def loose_ends(self, ranges: Sequence[Sequence[float]]) -> np.ndarray:
        """Ends (n, 2) of an open curve inside the window, where tracing could not go on; cusps are
        not counted.
        """
        if self.closed or self.is_point:
            return np.zeros((0, 2))
        low, high = np.array(ranges, dtype=float).T
        ends = self.points[[0, -1]]
        within = np.all((ends > low) & (ends < high), axis=1)
        at_cusp = [
            bool(len(self.cusps))
            and float(np.abs((self.cusps - end) / (high - low)).max(axis=1).min()) < _SAME_PLACE
            for end in ends
        ]
        return ends[within & ~np.array(at_cusp)]


def make_locus(
    system: LocusSystem, curve: Curve, cusps: np.ndarray, in_mode: np.ndarray, hits: int
) -> Locus:
    """A traced curve in the mechanism's units; `cusps` are numbers of its points."""
    mechanism = system.plane.mechanism
    factors = np.array([mechanism.value_out(c, 1.0) for c in system.plane.coordinates])
    w = curve.points[:, system.uv.stop :] / system.curve.characteristic_length
    kind = (
        "passive" if system.loss.is_passive(curve.points[:, : system.uv.stop], w) else system.kind
    )
    values, _ = system.curve.linearise(curve.points, np.zeros(0))
    names = (*(c.name for c in system.free), *system.plane.names)
    points = curve.points[:, system.uv] * factors
    return Locus(
        kind=kind,
        limb=system.plane.limb_name(system.limb),
        points=points,
        closed=curve.closed,
        in_mode=in_mode,
        cusps=points[cusps if kind == "type 2" else cusps[:0]],
        names=names,
        configurations=curve.points[:, : system.uv.stop],
        largest_row=float(np.max(np.abs(values))),
        hits=hits,
        self_motion=points.shape[1] == 2
        and is_one_place(points)
        and has_self_motion(system, curve.points[len(points) // 2]),
    )


def is_one_place(points: np.ndarray) -> bool:
    """Whether points (n, 2) of a curve are one place of the plane."""
    return bool(np.ptp(points, axis=0).max() <= _SAME_PLACE * max(1.0, float(np.abs(points).max())))


def merged(curves: Sequence[Locus], sides: np.ndarray) -> tuple[Locus, ...]:
    """One locus for each picture: those with more points in the configuration's working mode stand
    for the others.
    """
    kept: list[Locus] = []
    for curve in sorted(curves, key=lambda c: (-int(c.in_mode.sum()), -len(c.points))):
        place = next((k for k, other in enumerate(kept) if _has_picture(other, curve, sides)), None)
        if place is None:
            kept.append(curve)
        else:
            other = kept[place]
            limb = other.limb if other.limb == curve.limb else other.limb or curve.limb
            kept[place] = replace(
                other,
                hits=other.hits + curve.hits,
                limb=limb,
                self_motion=other.self_motion or curve.self_motion,
            )
    return tuple(sorted(kept, key=lambda c: (c.kind, c.limb or "", -len(c.points))))


def _has_picture(other: Locus, curve: Locus, sides: np.ndarray) -> bool:
    """Whether `curve` lies on the polyline of `other`, but for points where that is too coarse."""
    if (
        other.kind != curve.kind
        or (other.limb != curve.limb and curve.kind != "passive")
        or other.is_point != curve.is_point
    ):
        return False
    away, _ = picture_distance(other.points, other.closed, sides, curve.points)
    return bool(np.mean(away < SAME_PICTURE) >= _LEAST_SHARE and np.all(away < _FARTHEST))


def picture_distance(
    line: np.ndarray, closed: bool, sides: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How far points (k, 2) are from a polyline (n, 2), of the window's sides, and the number of
    the nearest segment.
    """
    line = np.vstack([line, line[:1]]) if closed or len(line) == 1 else line
    begin, along = line[:-1] / sides, np.diff(line, axis=0) / sides
    gaps = points[:, None] / sides - begin
    lengths = np.maximum(np.sum(along**2, axis=1), 1e-300)
    share = np.clip(np.sum(gaps * along, axis=2) / lengths, 0.0, 1.0)
    away = np.linalg.norm(gaps - share[:, :, None] * along, axis=2)
    return away.min(axis=1), away.argmin(axis=1)


_COUNT, _STEP = 6, 0.01
"""How many finite steps show a motion, and the length of each, of the size."""
_LEAST_DISTANCE = 0.5
"""Least distance of neighbours after the correction, of a step: an isolated configuration draws all
of them together.
"""
_MOST_DRIFT = 1e-5
"""Most that (u, v) may move in the correction, of the size: beyond, the motion belongs to another
point of the plane.
"""
_ITERATIONS = 15
"""Gauss-Newton steps of the correction of all configurations together."""


def has_self_motion(system: LocusSystem, z: np.ndarray) -> bool:
    """Whether from the curve's point z the free coordinates move over a finite length with one (u,
    v), every row of F below 1e-11 of the size at each step.
    """
    if not system.free:
        return False
    begin = z[: system.uv.stop]
    for sense in (1.0, -1.0):
        chain = _close_all(system.closed, _steps_along(system.closed, begin, sense))
        if chain is not None and _finite_motion(system, begin, chain):
            return True
    return False


def _steps_along(closed: System, begin: np.ndarray, sense: float) -> np.ndarray:
    """Configurations (n, width) at finite steps along the null direction with u and v held, roughly
    closed.
    """
    points, length = [begin], _STEP * closed.characteristic_length
    direction = sense * _null_space(closed, begin)[-1]
    for _ in range(_COUNT):
        z = _moved(closed, points[-1], length * direction)
        for _ in range(3):
            values, jacobian = closed.linearise_one(z, np.zeros(0))
            step = np.linalg.lstsq(jacobian[:, :-2], -values, rcond=SINGULAR_VALUE)[0]
            z = _moved(
                closed, z, step * min(1.0, length / max(float(np.linalg.norm(step)), length))
            )
        basis = _null_space(closed, z)
        ahead = basis.T @ (basis @ direction)
        direction = ahead / max(float(np.linalg.norm(ahead)), 1e-12)
        points.append(z)
    return np.array(points)


def _moved(closed: System, z: np.ndarray, step: np.ndarray) -> np.ndarray:
    """A step of the free coordinates alone."""
    return closed.move(z[None], np.append(step, [0.0, 0.0])[None])[0]


def _null_space(closed: System, z: np.ndarray) -> np.ndarray:
    """Orthonormal rows; the last one belongs to the smallest singular value, however large it
    is.
    """
    jacobian = closed.linearise_one(z, np.zeros(0))[1][:, :-2]
    return null_space(jacobian, SINGULAR_VALUE, relative=True, least=1)


def _close_all(closed: System, points: np.ndarray) -> np.ndarray | None:
    """Zeros of all rows at all points with one step of (u, v) for all of them, by least-norm
    Gauss-Newton; None where they are not reached.
    """
    count, freedom = len(points), closed.freedom - 2
    for _ in range(_ITERATIONS):
        values, jacobians = closed.linearise(points, np.zeros(0))
        if not (np.isfinite(values).all() and np.isfinite(jacobians).all()):
            return None
        if float(np.abs(values).max(initial=0.0)) <= CORRECTED * closed.characteristic_length:
            return points
        rows = values.shape[1]
        matrix = np.zeros((count * rows, count * freedom + 2))
        for k, jacobian in enumerate(jacobians):
            matrix[k * rows : (k + 1) * rows, k * freedom : (k + 1) * freedom] = jacobian[:, :-2]
            matrix[k * rows : (k + 1) * rows, -2:] = jacobian[:, -2:]
        step = np.linalg.lstsq(matrix, -values.ravel(), rcond=SINGULAR_VALUE)[0]
        shared = np.tile(step[-2:], (count, 1))
        points = closed.move(points, np.hstack([step[:-2].reshape(count, freedom), shared]))
    return None


def _finite_motion(system: LocusSystem, begin: np.ndarray, chain: np.ndarray) -> bool:
    closed, count = system.closed, len(system.free)
    steps = [distance(closed, a, b, count) for a, b in pairwise(chain)]
    length = _STEP * closed.characteristic_length
    scale = np.array([c.lever(closed.characteristic_length) for c in system.plane.coordinates])
    strayed = float(np.max(np.abs((chain[0] - begin)[system.uv] * scale)))
    reached = distance(closed, chain[-1], chain[0], count)
    return (
        min(steps) >= _LEAST_DISTANCE * length
        and reached >= 0.5 * _COUNT * _LEAST_DISTANCE * length
        and strayed <= _MOST_DRIFT * closed.characteristic_length
    )
